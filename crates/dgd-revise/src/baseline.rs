//! A fair base: all free parameters and initial states fitted again, the noise it leaves, the space a re-fit reaches.

use crate::context::{Context, Trial, Values};
use crate::empirical;
use crate::error::ReviseError;
use crate::floor;
use crate::noise::Noise;
use crate::stack::Runner;
use crate::tangent::Tangent;
use dgd_lsq::lm::{self, Bounds, Effort, Minimum};
use nalgebra::DMatrix;

/// A fitted model, linearised.
#[derive(Debug, Clone)]
pub(crate) struct Baseline {
    pub members: Vec<usize>,
    pub values: Values,
    /// Simulated less measured, scaled.
    pub residual: Vec<f64>,
    pub tangent: Tangent,
    /// The residual off the tangent.
    pub off: Vec<f64>,
    pub noise: Noise,
    pub white_tangent: Tangent,
    pub white_off: Vec<f64>,
}

/// Two steps on one Jacobian, which costs a run for each parameter.
pub(crate) const SPARING: Effort = Effort {
    steps: 0,
    tolerance: 1e-6,
    fresh: 1,
    stale: 2,
    patience: 5,
};
/// To the end.
pub(crate) const FULL: Effort = Effort {
    steps: 80,
    tolerance: 1e-6,
    fresh: 20,
    ..SPARING
};
/// Near enough to be scored.
pub(crate) const NEAR: Effort = Effort {
    steps: 25,
    tolerance: 1e-4,
    fresh: 6,
    ..SPARING
};
/// To see what leads anywhere.
pub(crate) const QUICK: Effort = Effort {
    steps: 7,
    tolerance: 1e-3,
    fresh: 2,
    ..SPARING
};

impl Baseline {
    /// Linearises a fitted set.
    pub(crate) fn of(context: &Context<'_>, trial: &Trial) -> Option<Self> {
        let jacobian = fresh_jacobian(context, trial)?;
        let residual = trial.minimum.residuals.clone();
        let outputs = context.scale.len();
        let noise = Noise::of(context.data, &residual, outputs);
        let tangent = Tangent::of_matrix(&jacobian);
        let white = |v: &[f64]| noise.whiten(context.data, v);
        let white_tangent = Tangent::of(
            jacobian
                .column_iter()
                .map(|c| white(&c.iter().copied().collect::<Vec<_>>())),
        );
        Some(Self {
            members: trial.members.clone(),
            values: trial.values(),
            off: tangent.off(&residual),
            white_off: white_tangent.off(&white(&residual)),
            residual,
            tangent,
            noise,
            white_tangent,
        })
    }
}

/// The base with the parameters that a fit has driven to a bound put back where the description starts them, and the others
/// fitted beside them; `None` if none sits on a bound.
pub(crate) fn inside(context: &Context<'_>, trial: &Trial) -> Option<Baseline> {
    let built = context.build(&trial.members)?;
    let declared = Context::start(&built, &Values::new())?.1;
    let (low, high) = (trial.bounds.low(), trial.bounds.high());
    let at_bound = |theta: &[f64], i: usize| trial.bounds.touches(i, theta[i]);
    let fitted = &trial.minimum.theta;
    let (held, moving): (Vec<usize>, Vec<usize>) =
        (0..fitted.len()).partition(|&i| at_bound(fitted, i) && !at_bound(&declared, i));
    if held.is_empty() {
        return None;
    }
    let mut theta = fitted.clone();
    held.iter().for_each(|&i| theta[i] = declared[i]);
    let of = |all: &[f64]| moving.iter().map(|&i| all[i]).collect::<Vec<f64>>();
    let mut runner = Runner::new(&built, context.data, &context.simulation).ok()?;
    let mut all = theta.clone();
    let found = lm::minimise(
        &mut |t: &[f64]| {
            for (&i, v) in moving.iter().zip(t) {
                all[i] = *v;
            }
            runner.run(&all).map(|s| context.residual(s))
        },
        &of(&theta),
        &Bounds::new(of(low), of(high)).ok()?,
        None,
        None,
        NEAR,
    );
    if !found.cost.is_finite() {
        return None;
    }
    for (&i, v) in moving.iter().zip(&found.theta) {
        theta[i] = *v;
    }
    let mut there = trial.clone();
    there.minimum = Minimum { theta, ..found };
    Baseline::of(context, &there)
}

/// Jacobian at a trial's parameters, by differences.
pub(crate) fn fresh_jacobian(context: &Context<'_>, trial: &Trial) -> Option<DMatrix<f64>> {
    let built = context.build(&trial.members)?;
    let mut runner = Runner::new(&built, context.data, &context.simulation).ok()?;
    let m = &trial.minimum;
    Some(lm::differences(
        &mut |t: &[f64]| runner.run(t).map(|s| context.residual(s)),
        &m.theta,
        &m.residuals,
        &trial.bounds,
    ))
}

/// Fits the base from its own start and from `more` others, and sets the scale of each output to its noise; of a single one to
/// what is left of it.
pub(crate) fn fit_base(context: &mut Context<'_>, more: usize) -> Result<Trial, ReviseError> {
    let parameters = context.assembly.parameters();
    for (o, scale) in context.scale.iter_mut().enumerate() {
        let rows = context.data.of_output(o);
        let values: Vec<f64> = rows.iter().map(|&i| context.data.measured[i]).collect();
        let n = values.len().max(1) as f64;
        let mean = values.iter().sum::<f64>() / n;
        let deviation = (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / n).sqrt();
        *scale = if deviation > 0.0 {
            deviation
        } else {
            mean.abs().max(1.0)
        };
    }
    let starts: Vec<Values> = (0..=more)
        .map(|k| {
            parameters
                .iter()
                .enumerate()
                .map(|(d, p)| {
                    let value = if k == 0 {
                        p.start
                    } else {
                        spread(p.low, p.high, p.start, k, d)
                    };
                    (p.path.clone(), value)
                })
                .collect()
        })
        .collect();
    let shared: &Context<'_> = context;
    let effort = Effort {
        steps: 15,
        fresh: 4,
        ..QUICK
    };
    let tried = shared.threads.map(&starts, |s| shared.fit(&[], s, effort));
    let mut best: Option<Trial> = None;
    for trial in tried.into_iter().flatten() {
        if best
            .as_ref()
            .is_none_or(|b| trial.cost() < (1.0 - 1e-6) * b.cost())
        {
            best = Some(trial);
        }
    }
    let best = best.ok_or(ReviseError::NotRun)?;
    let trial = shared.refine(&best, FULL).unwrap_or(best);
    let least: Vec<f64> = context.scale.iter().map(|s| 1e-6 * s).collect();
    let fitted: Vec<f64> = (0..context.scale.len())
        .map(|o| context.data.rms(&trial.minimum.residuals, o))
        .collect();
    for ((scale, fitted), least) in context.scale.iter_mut().zip(&fitted).zip(least) {
        if fitted.is_finite() {
            *scale = (*scale * fitted).max(least);
        }
    }
    // With several outputs the weights have changed.
    let trial = context
        .fit(&[], &trial.values(), FULL)
        .ok_or(ReviseError::NotRun)?;
    let recorded = |o: &usize| !context.data.of_output(*o).is_empty();
    if (0..context.scale.len()).filter(recorded).count() < 2 {
        return Ok(trial);
    }
    weigh_by_noise(context, &trial);
    context
        .fit(&[], &trial.values(), FULL)
        .ok_or(ReviseError::NotRun)
}

/// Most times its noise that an instrument may be off before it counts for less than its noise alone would have it: of a
/// model that is wrong nobody knows how wrong it is.
const OFF: f64 = 10.0;

/// Sets the scale of each output to its noise. What is left of it would hide, in an instrument that a missing effect moves most,
/// the little by which a like effect falls short; single instruments have nothing to be weighed against.
fn weigh_by_noise(context: &mut Context<'_>, trial: &Trial) {
    let (members, theta) = (&trial.members, &trial.minimum.theta);
    let quantities =
        empirical::quantities(context, context.data, members, theta).unwrap_or_default();
    let outputs = context.scale.len();
    let levels = floor::plain(
        context.data,
        &trial.minimum.residuals,
        outputs,
        &context.scale,
        &quantities,
    );
    for level in levels.iter().filter(|l| !l.rounding) {
        context.scale[level.output] *= level.rms / level.ratio().clamp(1.0, OFF);
    }
}

/// Start number `k`, from 1, of parameter `d`: Halton's points, in the logarithm where the bounds span decades.
fn spread(low: f64, high: f64, start: f64, k: usize, d: usize) -> f64 {
    if !(low.is_finite() && high.is_finite()) {
        return start;
    }
    let share = lm::halton(k - 1, d);
    if low > 0.0 && high / low > 100.0 {
        low * (high / low).powf(share)
    } else {
        low + (high - low) * share
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may")]
    use super::*;
    use crate::draws::Draws;
    use crate::parallel::Threads;
    use crate::stack::Data;
    use dgd_assembly::{Assembly, Portion, Record, SimulationOptions};

    /// Between -1 and 1, without memory.
    fn jitter(draws: &mut Draws) -> f64 {
        draws.below(20_001) as f64 / 10_000.0 - 1.0
    }

    /// Scales after the fit of a tank that empties evenly in its root, whose outflow reads a slow swing of 0.3 l/s.
    fn scales(instruments: &str) -> Vec<f64> {
        let text = format!(
            r#"
            connections = ["tank -> valve -> atmosphere"]
            [components]
            tank = {{ kind = "tank", area = 1.0 }}
            valve = {{ kind = "valve" }}
            {instruments}
            [initial]
            "tank.level" = 1.0
            [free]
            "valve.flow_coefficient" = {{ start = 3e-5, low = 1e-6, high = 1e-3 }}
            "#
        );
        let fall = 0.2e-4 * (1000.0f64 * 9.80665).sqrt();
        let root = |t: u32| 1.0 - fall * f64::from(t);
        let mut draws = Draws::new(7, 0);
        let mut level = |t: u32| root(t).powi(2) + 1e-3 * jitter(&mut draws);
        let h: Vec<f64> = (0..400).map(&mut level).collect();
        let mut draws = Draws::new(7, 1);
        let mut flow = |t: u32| {
            let swing = 3e-4 * (0.05 * f64::from(t)).sin();
            2.0 * fall * root(t) + 6e-5 * jitter(&mut draws) + swing
        };
        let q: Vec<f64> = (0..400).map(&mut flow).collect();
        let assembly = Assembly::parse(&text).unwrap();
        let columns = vec![("h", h.as_slice()), ("q", q.as_slice())];
        let windows = assembly.windows(&Record { columns }, Portion::Train);
        let data = Data::training(windows.unwrap());
        let mut context = Context {
            assembly: &assembly,
            asked: &assembly,
            data: &data,
            scale: vec![1.0; assembly.outputs().len()],
            simulation: SimulationOptions::default(),
            threads: &Threads::new(1),
            hypotheses: Vec::new(),
        };
        fit_base(&mut context, 0).unwrap();
        context.scale
    }

    const LEVEL: &str =
        r#"level = { kind = "instrument", measures = "level", of = "tank", channel = "h" }"#;
    const FLOW: &str =
        r#"flow = { kind = "instrument", measures = "flow", of = "valve", channel = "q" }"#;

    #[test]
    fn of_two_instruments_each_counts_by_its_noise_though_one_is_far_off() {
        // An even jitter of -1 to 1 has a root mean square of 1/√3.
        // Instruments stand in the order of their names.
        let noise = [6e-5, 1e-3].map(|a| a / 3.0_f64.sqrt());
        for (found, expected) in scales(&format!("{LEVEL}\n{FLOW}")).iter().zip(noise) {
            assert!((found / expected - 1.0).abs() < 0.2, "{found} {expected}");
        }
    }

    #[test]
    fn one_alone_counts_by_what_is_left_of_it() {
        let found = scales(FLOW)[0];
        assert!(found > 1e-4, "{found}");
    }
}
