//! Parameters of named effects, moved to where all of them together explain most.

mod climb;

use crate::cores::both;
use crate::empirical::again_as_it_runs;
use crate::record::Record;
use crate::relations::Applied;
use crate::tangent::{Bend, Tangent};
use climb::climb;
use dgd_effects::{Curve, KNOTS, Quantity};
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

#[cfg(test)]
mod tests;
