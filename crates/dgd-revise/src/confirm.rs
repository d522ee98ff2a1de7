//! The test part, looked at once.

use crate::context::{Context, Trial};
use crate::draws::Draws;
use crate::empirical::{self, Corrected};
use crate::revision::TestStart;
use crate::stack::{Data, Runner};
use dgd_lsq::lm::{self, Bounds, Effort};

/// Readings of a fitted set over windows, by window, output and sample.
pub(crate) type Readings = Vec<Vec<Vec<f64>>>;

/// Parameters for each held-out window: those of the training, with initial states as asked for.
fn starts(
    context: &Context<'_>,
    trial: &Trial,
    test: &Data,
    how: TestStart,
) -> Option<Vec<Vec<f64>>> {
    let theta = &trial.minimum.theta;
    let built = context.build(&trial.members)?;
    let parameters = built.parameters();
    let own_channels = built.system().record.test.as_ref().is_some_and(|t| {
        !t.channels.is_empty() && t.channels != built.system().record.train.channels
    });
    let share = match how {
        TestStart::Trained => None,
        TestStart::FirstSamples(share) => Some(share),
        TestStart::Automatic => (!own_channels).then_some(0.05),
    };
    // Free initial states of the first window are those without `@`.
    let moving: Vec<usize> = (0..parameters.len())
        .filter(|&i| parameters[i].initial && !parameters[i].path.contains('@'))
        .collect();
    let (Some(share), false) = (share, moving.is_empty()) else {
        return Some(vec![theta.clone(); test.windows.len()]);
    };
    let bounds = Bounds::new(
        moving.iter().map(|&i| parameters[i].low).collect(),
        moving.iter().map(|&i| parameters[i].high).collect(),
    )
    .ok()?;
    let effort = Effort {
        steps: 30,
        tolerance: 1e-6,
        fresh: 30,
        ..crate::baseline::SPARING
    };
    test.windows
        .iter()
        .map(|window| {
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "a share of a length"
            )]
            let n = (share * window.time.len() as f64).ceil().max(3.0) as usize;
            let mut first = window.clone();
            first.time.truncate(n);
            first
                .inputs
                .iter_mut()
                .chain(&mut first.readings)
                .for_each(|v| v.truncate(n));
            let data = Data::new(vec![first], false);
            let mut runner = Runner::new(&built, &data, &context.simulation).ok()?;
            let mut full = theta.clone();
            let start: Vec<f64> = moving.iter().map(|&i| theta[i]).collect();
            let found = lm::minimise(
                &mut |t: &[f64]| {
                    for (&i, v) in moving.iter().zip(t) {
                        full[i] = *v;
                    }
                    let simulated = runner.run(&full)?;
                    Some(
                        simulated
                            .iter()
                            .zip(&data.measured)
                            .zip(&data.rows)
                            .map(|((s, m), row)| (s - m) / context.scale[row.output])
                            .collect(),
                    )
                },
                &start,
                &bounds,
                None,
                None,
                effort,
            );
            let mut theta = theta.clone();
            for (&i, v) in moving.iter().zip(&found.theta) {
                theta[i] = *v;
            }
            Some(theta)
        })
        .collect()
}

/// Rounds in which a correction and the quantity that it goes along settle.
const SETTLE: usize = 5;

/// Runs a fitted set over the held-out windows; with a correction and the set that its quantity is simulated by, if there is
/// one.
pub(crate) fn run_test(
    context: &Context<'_>,
    trial: &Trial,
    corrected: Option<(&Corrected, &Trial)>,
    test: &Data,
    how: TestStart,
) -> Option<Readings> {
    let thetas = starts(context, trial, test, how)?;
    let plain_thetas = match corrected {
        Some((_, plain)) => starts(context, plain, test, how)?,
        None => Vec::new(),
    };
    let built = context.build(&trial.members)?;
    let mut all = Vec::new();
    for (w, window) in test.windows.iter().enumerate() {
        let one = Data::new(vec![window.clone()], false);
        let outputs = match corrected {
            None => Runner::new(&built, &one, &context.simulation)
                .ok()?
                .outputs(&thetas[w])?,
            Some((c, plain)) => {
                // The quantity as the uncorrected model sees it there.
                let quantities =
                    empirical::quantities(context, &one, &plain.members, &plain_thetas[w])?;
                let quantity = quantities
                    .into_iter()
                    .find(|(n, _)| *n == c.candidate.along)?
                    .1;
                let mut there = empirical::Candidate {
                    quantity,
                    ..c.candidate.clone()
                };
                for _ in 0..SETTLE {
                    let own = empirical::seen(
                        context,
                        &one,
                        &trial.members,
                        &thetas[w],
                        &there,
                        &c.values,
                    );
                    match own {
                        Some(quantity) => there.quantity = quantity,
                        None => break,
                    }
                }
                empirical::run_corrected(
                    context,
                    &one,
                    &trial.members,
                    &thetas[w],
                    &there,
                    &c.values,
                )?
            }
        };
        all.extend(outputs);
    }
    Some(all)
}

/// Root mean square of an output over windows; NaN if it was not recorded.
pub(crate) fn rms(readings: &Readings, data: &Data, output: usize) -> f64 {
    let (mut sum, mut n) = (0.0, 0.0);
    for (row, measured) in data.rows.iter().zip(&data.measured) {
        if row.output == output {
            sum += (readings[row.window][output][row.sample] - measured).powi(2);
            n += 1.0;
        }
    }
    f64::sqrt(sum / n)
}

/// 95 % interval of 1 − after/before by a paired moving-block bootstrap (Künsch 1989), blocks of a twelfth of the record at
/// most.
pub(crate) fn gain_interval(
    before: &Readings,
    after: &Readings,
    data: &Data,
    output: usize,
    memory: usize,
) -> (f64, f64) {
    let pairs: Vec<(f64, f64)> = data
        .rows
        .iter()
        .zip(&data.measured)
        .filter(|(row, _)| row.output == output)
        .map(|(row, m)| {
            let error = |r: &Readings| (r[row.window][output][row.sample] - m).powi(2);
            (error(before), error(after))
        })
        .collect();
    let n = pairs.len();
    if n < 12 {
        return (f64::NAN, f64::NAN);
    }
    let length = (3 * memory).clamp(n.div_ceil(50), n.div_ceil(12));
    // Sums up to each sample, so that a block is one difference.
    let mut sums = vec![(0.0, 0.0)];
    for (b, a) in &pairs {
        let last = sums[sums.len() - 1];
        sums.push((last.0 + b, last.1 + a));
    }
    let mut draws = Draws::new(11, output as u64);
    let mut gains: Vec<f64> = (0..999)
        .map(|_| {
            let (mut b, mut a) = (0.0, 0.0);
            for _ in 0..n.div_ceil(length) {
                let from = draws.below(n - length + 1);
                b += sums[from + length].0 - sums[from].0;
                a += sums[from + length].1 - sums[from].1;
            }
            1.0 - (a / b.max(1e-300)).sqrt()
        })
        .collect();
    gains.sort_by(f64::total_cmp);
    (gains[24], gains[974])
}
