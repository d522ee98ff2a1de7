//! Parameters of named effects, moved to where all of them together explain most.

use crate::cores::both;
use crate::empirical::again_as_it_runs;
use crate::incremental::Incremental;
use crate::record::Record;
use crate::relations::{Applied, on_grid};
use crate::tangent::{Bend, Tangent};
use dgd_effects::{Curve, KNOTS, Parameter, Quantity, Role};
use dgd_lsq::dot;

/// Sharpens every parameter of the effects at and after `from`, about the whole hypothesis.
pub(crate) fn refine(
    record: &Record,
    state: &mut [Applied],
    from: usize,
    excluded: &[bool],
    rounds: usize,
) {
    for _ in 0..rounds {
        for k in from..state.len() {
            if state[k].allowance || state[k].is_correction() {
                continue;
            }
            let Some(tangent) = Tangent::at(record, state, excluded, Bend::Stiff) else {
                return;
            };
            moved(record, &tangent, state, k);
        }
    }
}

fn moved(record: &Record, tangent: &Tangent, state: &mut [Applied], k: usize) {
    if state[k].effect.about().search.timing.is_some() {
        slide(record, tangent, state, k);
    } else {
        climb(record, tangent, state, k);
    }
}

/// An effect of a model to start from where the training rows do not hold it: a correction adds nothing, all else is as it was given.
pub(crate) fn unshown(mut given: Applied) -> Applied {
    if let Some(curve) = given.curve() {
        let mut flat = curve.flattened();
        flat.knots.truncate(KNOTS);
        given.parameters = flat.parameters();
    }
    given
}

/// The effects of a model to start from, fitted to the recording as the curves are: else what their sizes are off by would
/// pass for another effect. What the recording does not show stays as it is; `None` is what it speaks against, whatever the
/// size, and curves along time that it does not show: what another recording was off by at some time is nothing here.
pub(crate) fn fitted_here(
    record: &Record,
    start: &[Applied],
    excluded: &[bool],
) -> Vec<Option<Applied>> {
    /// Misfit that an effect must save for its size to be sought, or cost to be refuted.
    const SHOWN: f64 = 8.0;
    let mut state: Vec<Option<Applied>> = start.iter().cloned().map(Some).collect();
    for k in (0..2).flat_map(|_| 0..start.len()) {
        let Some(own) = state[k].clone() else {
            continue;
        };
        let held = |state: &[Option<Applied>]| state.iter().flatten().cloned().collect::<Vec<_>>();
        let at = state[..k].iter().flatten().count();
        let all = held(&state);
        let Some(tangent) = Tangent::at(record, &all, excluded, Bend::Stiff) else {
            break;
        };
        let mut others = all.clone();
        others.remove(at);
        if own.is_correction() {
            let held = own.curve();
            let found =
                (held.as_ref()).and_then(|held| again_as_it_runs(record, &others, held, excluded));
            let of_time = |held: Curve| held.quantity.is_timed() || held.quantity == Quantity::Time;
            if let Some(found) = found {
                state[k] = Some(Applied::from(&found));
            } else if held.is_none_or(of_time) {
                state[k] = None;
            }
            continue;
        }
        let misfit = |applied: &[Applied]| {
            let off = tangent.left_over(record, applied);
            0.5 * dot(&off, &off)
        };
        let (now, without) = (misfit(&all), misfit(&others));
        if (without - now).abs() < SHOWN {
            continue;
        }
        let mut next = all;
        moved(record, &tangent, &mut next, at);
        let then = misfit(&next);
        if without < now && without < then + SHOWN {
            state[k] = None;
        } else if then < now {
            state[k] = Some(next.remove(at));
        }
    }
    state
}

/// Shortest time, s, that makes a meter or a pump late.
pub(crate) const SHORTEST_S: f64 = 0.5;

/// Where the time of a late effect explains most, and the misfit there; steps in s, the curves fitted again at each.
pub(crate) fn nearest_time(
    longest: f64,
    from: f64,
    misfit: impl Fn(f64) -> f64 + Sync,
) -> (f64, f64) {
    let (mut best, mut least) = (from, misfit(from));
    for step in [3.0, 1.5, 0.7, 0.35] {
        for _ in 0..6 {
            let tries = [best + step, best - step].map(|time| time.clamp(SHORTEST_S, longest));
            let found: [f64; 2] = both(|| misfit(tries[0]), || misfit(tries[1])).into();
            let nearer = usize::from(found[1] < found[0]);
            if found[nearer] >= least - 0.05 {
                break;
            }
            (least, best) = (found[nearer], tries[nearer]);
        }
    }
    (best, least)
}

/// Moves what makes something late along its time, the curves fitted again at each step.
fn slide(record: &Record, tangent: &Tangent, state: &mut [Applied], k: usize) {
    let longest = state[k].effect.about().parameters[0].high;
    let misfit = |time: f64, state: &[Applied]| -> f64 {
        let mut next = state.to_vec();
        next[k].parameters[0] = time;
        let off = tangent.left_over(record, &next);
        dot(&off, &off)
    };
    let (best, _) = nearest_time(longest, state[k].parameters[0], |time| misfit(time, state));
    state[k].parameters[0] = best;
}

/// Moves every parameter but the strength in ever smaller steps, the strength solved for beside them.
fn climb(record: &Record, tangent: &Tangent, state: &mut [Applied], k: usize) {
    /// Sweeps over all parameters with steps of one size, and what one must gain for the next. Set by hand.
    const SWEEPS: usize = 4;
    const LEAST_GAIN: f64 = 1.0;
    /// Steps of one parameter in a sweep, and what one must gain. Set by hand.
    const STEPS: usize = 3;
    const GAIN: f64 = 0.05;
    let about = state[k].effect.about();
    // Only this effect moves: all others are run once.
    let mut others = state.to_vec();
    let own = others.remove(k);
    let ground = Incremental::under(record, &others);
    let shifted = |parameters: Vec<f64>| -> Vec<f64> {
        let one = Applied {
            parameters,
            ..own.clone()
        };
        let blocks = (ground.with(record, &one)).unwrap_or_else(|| {
            let all: Vec<Applied> = others.iter().cloned().chain([one]).collect();
            ground.other(record, &all)
        });
        tangent.beyond(record, &tangent.change_to(&blocks))
    };
    // Swept again, the times of an influx explain what was left of the training part, and less of what is held out.
    let has_times =
        (about.parameters.iter()).any(|p| matches!(p.role, Role::Onset | Role::Duration(_)));
    let sweeps = if has_times { 1 } else { SWEEPS };
    let base = state[k].parameters.clone();
    // The direction of a little more strength.
    let along = (!on_grid(about)).then(|| {
        let step = (0.05 * base[0].abs()).max(0.02 * about.parameters[0].usual);
        let mut p = base.clone();
        p[0] += step;
        let s: Vec<f64> = shifted(p).iter().map(|v| v / step).collect();
        let energy = dot(&s, &s).max(1e-300);
        (s, energy)
    });
    // What is left over when the parameters move, with the strength free: (misfit, change of strength).
    let left = |parameters: &[f64]| -> (f64, f64) {
        let shift = shifted(parameters.to_vec());
        let rest: Vec<f64> = tangent.off.iter().zip(&shift).map(|(a, b)| a - b).collect();
        let total = dot(&rest, &rest);
        match &along {
            Some((s, energy)) => {
                let c = dot(&rest, s);
                (total - c * c / energy, c / energy)
            }
            None => (total, 0.0),
        }
    };
    let moves = |(j, p): &(usize, &Parameter)| {
        !(*j == 0 && along.is_some() || matches!(p.role, Role::Choice(_) | Role::Sensor(_)))
    };
    let (misfit, gain) = left(&base);
    let mut best = (base, misfit, gain);
    let step = |best: &mut (Vec<f64>, f64, f64), j: usize, parameter: &Parameter, scale: f64| {
        for _ in 0..STEPS {
            let tried = |sign: f64| {
                let mut p = best.0.clone();
                p[j] += sign * scale * stride(parameter, p[j]);
                p[j] = p[j].clamp(parameter.low, parameter.high);
                let (misfit, gain) = left(&p);
                (p, misfit, gain)
            };
            let tried: [_; 2] = rayon::join(|| tried(1.0), || tried(-1.0)).into();
            let nearer = tried.into_iter().min_by(|a, b| a.1.total_cmp(&b.1));
            let Some(nearer) = nearer.filter(|nearer| nearer.1 < best.1 - GAIN) else {
                break;
            };
            *best = nearer;
        }
    };
    for scale in [1.0, 0.5, 0.25, 0.12] {
        // What one parameter gains may leave another free to move on.
        for _ in 0..sweeps {
            let (from, before) = (best.0.clone(), best.1);
            for (j, parameter) in about.parameters.iter().enumerate().filter(moves) {
                step(&mut best, j, parameter, scale);
            }
            if has_times || best.1 > before - LEAST_GAIN {
                break;
            }
            // Along a narrow valley one parameter at a time is slow: all of them as far again.
            let further: Vec<f64> = (about.parameters.iter().zip(best.0.iter().zip(&from)))
                .map(|(parameter, (to, from))| {
                    (2.0 * to - from).clamp(parameter.low, parameter.high)
                })
                .collect();
            let (misfit, gain) = left(&further);
            if misfit < best.1 - GAIN {
                best = (further, misfit, gain);
            }
        }
    }
    let (mut best, _, gain) = best;
    if along.is_some() {
        let p = &about.parameters[0];
        let limit = best[0].abs().max(p.usual);
        best[0] = (best[0] + gain.clamp(-limit, limit)).clamp(p.low, p.high);
    }
    state[k].parameters = best;
}

/// The longest step of a parameter from a value.
fn stride(parameter: &Parameter, value: f64) -> f64 {
    match parameter.role {
        Role::Onset | Role::Duration(_) => 80.0,
        Role::Grid(_) => 0.15 * value.abs().max(1.0),
        _ => 0.2 * value.abs().max(0.1 * parameter.usual).max(0.1),
    }
}

#[cfg(test)]
mod tests;
