//! What is late, and what is allowed to be: chosen together, since each stands in for the other.

use crate::record::Record;
use crate::refine::nearest_time;
use crate::relations::Applied;
use crate::scan::allowances_with;
use crate::tangent::{Bend, Tangent, dot};
use dgd_effects::{About, Effect, Timing, catalogue};

/// Misfit that an allowance of the pump must save.
const EARNED: f64 = 3.0;

/// The timing allowances that named effects leave to be made, on top of `start`; a late meter among `named` is timed anew.
///
/// A lag of the pump, wrongly allowed for, takes part of the meter's delay. So the meter is timed beside every lag, and
/// the least that explains it stands.
pub(crate) fn allowed_beside(
    record: &Record,
    start: &[Applied],
    named: &mut [Applied],
    excluded: &[bool],
) -> Option<Vec<Applied>> {
    let late = |a: &Applied| is_late_meter(a.effect.about());
    let meter = named.iter().filter(|a| late(a)).count();
    let mut fixed = start.to_vec();
    let mut settled = None;
    if let (1, Some(k)) = (meter, named.iter().position(late)) {
        settled = Some(Timing::Pump);
        let (time, lag) = timed(record, start, named, k, excluded)?;
        named[k].parameters[0] = time;
        fixed.extend(lag);
    }
    let held = fixed.len();
    fixed.extend(named.iter().cloned());
    let state = allowances_with(record, &fixed, excluded, Bend::Lean, settled)?;
    let mut out = fixed[..held].to_vec();
    out.extend(state.into_iter().skip(fixed.len()));
    Some(out)
}

/// Whether an effect makes the return flow's meter late.
pub(crate) fn is_late_meter(about: &About) -> bool {
    about.search.timing == Some(Timing::Meter)
}

/// The time of the late meter `named[k]` and the pump's lag beside it, if one earns its place.
fn timed(
    record: &Record,
    start: &[Applied],
    named: &[Applied],
    k: usize,
    excluded: &[bool],
) -> Option<(f64, Option<Applied>)> {
    let mut state = start.to_vec();
    let at = state.len() + k;
    state.extend(named.iter().cloned());
    let tangent = Tangent::at(record, &state, excluded, Bend::Free)?;
    let longest = state[at].effect.about().parameters[0].high;
    let misfit = |time: f64, lag: Option<&Applied>| -> f64 {
        let mut next = state.clone();
        next[at].parameters[0] = time;
        next.extend(lag.cloned());
        let off = tangent.refitted(record, &next).off;
        0.5 * dot(&off, &off)
    };
    let (mut time, mut least) =
        nearest_time(longest, state[at].parameters[0], &mut |t| misfit(t, None));
    let mut chosen = None;
    for lag in pump_lags(&state) {
        let (t, m) = nearest_time(longest, time, &mut |t| misfit(t, Some(&lag)));
        if m < least - EARNED {
            (time, least, chosen) = (t, m, Some(lag));
        }
    }
    Some((time, chosen))
}

/// Lags of the pump that a sound rig shows, where a hypothesis holds none.
fn pump_lags(state: &[Applied]) -> Vec<Applied> {
    catalogue()
        .iter()
        .copied()
        .filter(|effect| effect.about().search.timing == Some(Timing::Pump))
        .filter(|effect| {
            let id = effect.about().id;
            state.iter().all(|a| a.effect.about().id != id)
        })
        .flat_map(|effect: &'static dyn Effect| {
            effect
                .about()
                .search
                .allowance
                .iter()
                .map(move |lag| Applied {
                    effect,
                    parameters: vec![*lag],
                    allowance: true,
                })
        })
        .collect()
}
