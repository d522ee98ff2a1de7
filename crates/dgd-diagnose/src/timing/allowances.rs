//! Delays and lags of a sound rig.

use crate::cores::each;
use crate::record::Record;
use crate::relations::{Applied, joined};
use crate::scan::{Candidate, weigh};
use crate::tangent::{Bend, Tangent};
use dgd_effects::{Effect, Timing, catalogue};
use dgd_lsq::dot;

/// Misfit that an allowance must save.
const EARNED: f64 = 2.0;
/// What it must save beyond that where it makes something early: that comes of clocks alone, and no rotor, edge or filter makes it.
pub(crate) const EARLY: f64 = 12.0;
/// Misfit that another value must save beyond the one that is held.
const BETTER: f64 = 0.05;
/// How often the allowances are gone through at the most.
const SWEEPS: usize = 4;

/// Delays and lags that clocks, rotors and block edges make in a sound rig, on top of a hypothesis: allowed for before
/// anything is accused. `decided_on` are effects whose lateness has been decided upon.
pub(crate) fn allowances_with(
    record: &Record,
    start: &[Applied],
    excluded: &[bool],
    bend: Bend,
    decided_on: Option<Timing>,
) -> Option<Vec<Applied>> {
    let mut state: Vec<Applied> = start.to_vec();
    let mut tangent = Tangent::at(record, &state, excluded, bend)?;
    let timed: Vec<&'static dyn Effect> = (catalogue().iter().copied())
        .filter(|effect| {
            let about = effect.about();
            let held = start.iter().any(|a| a.id() == about.id);
            let decided = decided_on.is_some() && about.search.timing == decided_on;
            !(held || decided || about.search.allowance.is_empty())
        })
        .collect();
    let late = (start.iter()).any(|a| !a.allowance && a.effect.about().search.timing.is_some());
    // Each takes what a later one would explain better: they are gone through again.
    for _ in 0..SWEEPS {
        let mut moved = false;
        for effect in &timed {
            let about = effect.about();
            let now = state.iter().position(|a| a.allowance && a.id() == about.id);
            let one = |time_s: &f64| Applied::allowed(*effect, *time_s);
            // What a named lateness leaves over for want of form is no clock.
            let values = about.search.allowance.iter();
            let values = values.filter(|time_s| **time_s > 0.0 || !late);
            let dear = |time_s: f64| if time_s < 0.0 { EARLY } else { 0.0 };
            let held = now.map_or(0.0, |k| dear(state[k].parameters[0]));
            let values = values.filter(|v| now.is_none_or(|k| state[k].parameters[0] != **v));
            let weighed = each(values.collect(), |v| {
                let weighed = weigh(record, &tangent, &state, one(v));
                let evidence = weighed.evidence - dear(*v) + held;
                Candidate {
                    evidence,
                    ..weighed
                }
            });
            let best = (weighed.into_iter()).max_by(|a, b| a.evidence.total_cmp(&b.evidence));
            let mut least = EARNED;
            let mut next = None;
            if let Some(k) = now {
                let mut without = state.clone();
                without.remove(k);
                let off = tangent.left_over(record, &without);
                let lost = 0.5 * (dot(&off, &off) - dot(&tangent.off, &tangent.off));
                least = BETTER.max(EARNED + held - lost);
                if lost < EARNED + held {
                    next = Some(without);
                }
            }
            if let Some(best) = best.filter(|best| best.evidence > least) {
                next = Some(joined(&state, &best.applied));
            }
            if let Some(next) = next {
                state = next;
                tangent = Tangent::at(record, &state, excluded, bend)?;
                moved = true;
            }
        }
        if !moved {
            break;
        }
    }
    Some(state)
}
