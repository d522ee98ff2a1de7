//! The test part, looked at once.

use crate::context::{Context, Trial};
use crate::draws::Draws;
use crate::empirical::{self, Corrected};
use crate::stack::{Data, Runner};
use dgd_assembly::{Assembly, HeldOut, Window};

/// Readings of a fitted set over windows, by window, output and sample.
pub(crate) type Readings = Vec<Vec<Vec<f64>>>;

/// The test part: held-out windows, and the runs that tell where they start.
pub(crate) struct TestPart {
    pub data: Data,
    held_out: Vec<HeldOut>,
}

impl TestPart {
    pub(crate) fn new(held_out: Vec<HeldOut>) -> Self {
        let windows: Vec<Window> = held_out.iter().map(|held| held.window.clone()).collect();
        let numbers = vec![0; windows.len()];
        Self {
            data: Data::new(windows, numbers),
            held_out,
        }
    }

    /// What is run, by window: its last samples are the window's. The same for every set of effects on `base`, or they could not be compared.
    fn runs<'a>(&'a self, base: &'a Assembly) -> impl Iterator<Item = (Data, usize)> + 'a {
        self.held_out.iter().map(|held| {
            let (number, run) = held.run(base);
            let samples = held.window.time.len();
            (Data::new(vec![run.clone()], vec![number]), samples)
        })
    }
}

/// Rounds in which a correction and the quantity that it goes along settle.
const SETTLE: usize = 5;

/// Runs a fitted set over the held-out windows; with a correction and the set that its quantity is simulated by, if there is
/// one.
pub(crate) fn run_test(
    context: &Context<'_>,
    trial: &Trial,
    corrected: Option<(&Corrected, &Trial)>,
    test: &TestPart,
) -> Option<Readings> {
    // What a training window's starts were off by says nothing of another.
    let context = &context.as_asked();
    let built = context.build(&trial.members)?;
    let theta = &Context::start(&built, &trial.values())?.1;
    let mut all = Vec::new();
    for (run, samples) in test.runs(context.assembly) {
        let outputs = match corrected {
            None => Runner::new(&built, &run, &context.simulation)
                .ok()?
                .outputs(theta)?,
            Some((c, plain)) => {
                // The quantity as the uncorrected model sees it there.
                let alone = context.build(&plain.members)?;
                let own = Context::start(&alone, &plain.values())?.1;
                let quantities = empirical::quantities(context, &run, &plain.members, &own)?;
                let quantity = quantities
                    .into_iter()
                    .find(|(n, _)| *n == c.candidate.along)?
                    .1;
                let mut there = empirical::Candidate {
                    quantity,
                    ..c.candidate.clone()
                };
                for _ in 0..SETTLE {
                    let own =
                        empirical::seen(context, &run, &trial.members, theta, &there, &c.values);
                    match own {
                        Some(quantity) => there.quantity = quantity,
                        None => break,
                    }
                }
                empirical::run_corrected(context, &run, &trial.members, theta, &there, &c.values)?
            }
        };
        all.extend(outputs.into_iter().map(|run| tail(run, samples)));
    }
    Some(all)
}

/// The last samples of each output of a run.
fn tail(mut outputs: Vec<Vec<f64>>, samples: usize) -> Vec<Vec<f64>> {
    for values in &mut outputs {
        values.drain(..values.len().saturating_sub(samples));
    }
    outputs
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

/// Fewest readings of an instrument for an interval.
pub(crate) const FEWEST: usize = 12;

/// 95 % interval of 1 − after/before by a paired moving-block bootstrap (Künsch 1989), blocks of a twelfth of the record at
/// most; NaN for fewer than [`FEWEST`] readings.
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
    if n < FEWEST {
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
