//! What is late, and what is allowed to be: chosen together, since each stands in for the other.

mod allowances;

pub(crate) use allowances::{EARLY, allowances_with};

use crate::cores::apiece;
use crate::record::Record;
use crate::refine::{SHORTEST_S, nearest_time};
use crate::relations::Applied;
use crate::tangent::{Bend, Tangent};
use dgd_effects::{About, Effect, Timing, catalogue};
use dgd_lsq::dot;
use nalgebra::{DMatrix, DVector};

/// Misfit that a lag of the pump must save.
const EARNED: f64 = 3.0;

/// The timing allowances that named effects leave to be made, on top of `start`; a late meter among `named` is timed anew.
///
/// A lag of the pump, wrongly allowed for, takes part of the meter's delay. So the meter is timed beside every lag, and
/// the least that explains it stands; then a store is timed beside every delay that a sound meter may have.
pub(crate) fn allowed_beside(
    record: &Record,
    start: &[Applied],
    named: &mut [Applied],
    excluded: &[bool],
) -> Option<Vec<Applied>> {
    let late = |a: &Applied| is_late_meter(a.effect.about());
    let meter = named.iter().filter(|a| late(a)).count();
    let mut fixed = start.to_vec();
    let mut decided_on = None;
    if let (1, Some(k)) = (meter, named.iter().position(late)) {
        decided_on = Some(Timing::Pump);
        let (time, beside) = timed(record, start, named, k, excluded)?;
        named[k].parameters[0] = time;
        fixed.extend(beside);
    }
    let held = fixed.len();
    fixed.extend(named.iter().cloned());
    let state = allowances_with(record, &fixed, excluded, Bend::Lean, decided_on)?;
    let mut out = fixed[..held].to_vec();
    out.extend(state.into_iter().skip(fixed.len()));
    Some(out)
}

/// Whether an effect makes the return flow's meter late.
pub(crate) fn is_late_meter(about: &About) -> bool {
    about.search.timing == Some(Timing::Meter)
}

/// The time of the late meter `named[k]`, and what a sound rig is late by beside it.
fn timed(
    record: &Record,
    start: &[Applied],
    named: &[Applied],
    k: usize,
    excluded: &[bool],
) -> Option<(f64, Vec<Applied>)> {
    let mut state = start.to_vec();
    let at = state.len() + k;
    state.extend(named.iter().cloned());
    let tangent = Tangent::at(record, &state, excluded, Bend::Stiff)?;
    let longest = state[at].effect.about().parameters[0].high;
    let misfit = |time: f64, beside: &[Applied]| -> f64 {
        let mut next = state.clone();
        next[at].parameters[0] = time;
        next.extend_from_slice(beside);
        let off = tangent.left_over(record, &next);
        0.5 * dot(&off, &off)
    };
    let mut beside = Vec::new();
    let (mut time, mut least) = nearest_time(longest, state[at].parameters[0], |t| misfit(t, &[]));
    // That a meter is a second late itself needs no proof: what fits best stands.
    for (timing, earned) in [(Timing::Pump, EARNED), (Timing::Meter, 0.0)] {
        let mut best = None;
        for late in sound_times(&state, timing) {
            let mut tried = beside.clone();
            tried.push(late);
            let (t, m) = nearest_time(longest, time, |t| misfit(t, &tried));
            if m < least - earned {
                (least, best) = (m, Some((t, tried)));
            }
        }
        if let Some(best) = best {
            (time, beside) = best;
        }
    }
    Some((time, beside))
}

/// A late meter's time, s, and its evidence, with whatever a sound rig may be late by fitted beside it.
///
/// What was allowed for before the meter was accused took what it could of its lateness, and takes more of a store's than of a
/// delay's. `None` where nothing is told.
pub(crate) fn retimed(
    record: &Record,
    gate: &Tangent,
    state: &[Applied],
    meter: &Applied,
) -> Option<(f64, f64)> {
    /// Evidence, e-folds, up to which another start is tried, with nothing allowed for: near the noise what was allowed for and what is late in another way
    /// make a valley each. Set by hand.
    const NEAR: f64 = 100.0;
    let times = Times::beside(state, meter);
    let found = timed_from(record, gate, &times, times.first.clone());
    let clear = found.is_some_and(|(_, evidence)| evidence > NEAR);
    if clear || times.first[1..].iter().all(|time| *time == 0.0) {
        return found;
    }
    let mut alone = vec![0.0; times.first.len()];
    alone[0] = times.first[0];
    let alone = timed_from(record, gate, &times, alone);
    (found.into_iter().chain(alone)).max_by(|a, b| a.1.total_cmp(&b.1))
}

/// The same, sought from some times on.
fn timed_from(
    record: &Record,
    gate: &Tangent,
    times: &Times,
    start: Vec<f64>,
) -> Option<(f64, f64)> {
    /// Steps of the times, s, that tell their slopes.
    const STEP_S: f64 = 0.5;
    /// Steps towards the best at the most, and misfit that one must save.
    const ROUNDS: usize = 6;
    const SAVES: f64 = 0.5;
    let off = |at: &[f64]| gate.left_over(record, &times.applied(at));
    let half = |off: &[f64]| 0.5 * dot(off, off);
    let mut at = start;
    let mut here = off(&at);
    let mut least = half(&here);
    for _ in 0..ROUNDS {
        let slopes: Vec<Vec<f64>> = apiece((0..at.len()).collect(), |k| {
            let mut beside = at.clone();
            let room = at[k] + STEP_S <= times.ranges[k].1;
            let step = if room { STEP_S } else { -STEP_S };
            beside[k] += step;
            let there = off(&beside);
            (there.iter().zip(&here))
                .map(|(there, here)| (there - here) / step)
                .collect()
        });
        let next = gauss_newton_step(&slopes, &here, &at, &times.ranges);
        // A step that leads too far is taken by half, or by a quarter.
        let nearer = [1.0, 0.5, 0.25].into_iter().find_map(|share| {
            let next: Vec<f64> = (at.iter().zip(&next))
                .map(|(from, to)| from + share * (to - from))
                .collect();
            let there = off(&next);
            let misfit = half(&there);
            (misfit < least - SAVES).then_some((next, there, misfit))
        });
        let Some(nearer) = nearer else {
            break;
        };
        (at, here, least) = nearer;
    }
    let evidence = half(&gate.off) - least;
    evidence.is_finite().then_some((at[0], evidence))
}

/// Times that are fitted together: that of a late meter, from the shortest that one may have, and those that are allowed for beside it, each from 0, or
/// from what it was fitted as early, to the longest.
struct Times {
    /// What stays as it is.
    fixed: Vec<Applied>,
    meter: Applied,
    beside: Vec<&'static dyn Effect>,
    /// The times to begin with, s, the meter's own first.
    first: Vec<f64>,
    ranges: Vec<(f64, f64)>,
}

impl Times {
    fn beside(state: &[Applied], meter: &Applied) -> Self {
        let of = |a: &Applied| a.id();
        let timed = |a: &&Applied| a.allowance && a.effect.about().search.timing.is_some();
        let own = &meter.effect.about().parameters[0];
        let mut times = Self {
            fixed: (state.iter()).filter(|a| !timed(a)).cloned().collect(),
            meter: meter.clone(),
            beside: Vec::new(),
            first: vec![meter.parameters[0]],
            ranges: vec![(own.low.max(SHORTEST_S), own.high)],
        };
        for effect in catalogue().iter().copied() {
            let search = &effect.about().search;
            let id = effect.about().id;
            let taken = id == of(meter) || times.fixed.iter().any(|a| of(a) == id);
            if let (Some(_), Some(longest), false) = (search.timing, search.allowance.last(), taken)
            {
                let held = state.iter().find(|a| of(a) == id);
                times.beside.push(effect);
                times.first.push(held.map_or(0.0, |a| a.parameters[0]));
                // An allowance that was fitted as early may stay so; all others start at 0.
                let shortest = held.map_or(0.0, |a| a.parameters[0].min(0.0));
                times.ranges.push((shortest, *longest));
            }
        }
        times
    }

    /// The hypothesis with some times.
    fn applied(&self, at: &[f64]) -> Vec<Applied> {
        let allowed = self
            .beside
            .iter()
            .zip(&at[1..])
            .filter(|(_, time)| **time != 0.0);
        let mut out = self.fixed.clone();
        out.extend(allowed.map(|(effect, time)| Applied::allowed(*effect, *time)));
        let mut meter = self.meter.clone();
        meter.parameters[0] = at[0];
        out.push(meter);
        out
    }
}

/// Gauss and Newton's step within ranges: what would leave its range is held at its bound, and the others are solved for again. What
/// changes nothing stays.
pub(crate) fn gauss_newton_step(
    slopes: &[Vec<f64>],
    off: &[f64],
    at: &[f64],
    ranges: &[(f64, f64)],
) -> Vec<f64> {
    /// Ridge, as a share of the largest energy: times that cannot be told apart share a step.
    const RIDGE: f64 = 1e-9;
    let energies: Vec<f64> = slopes.iter().map(|slope| dot(slope, slope)).collect();
    let ridge = RIDGE * energies.iter().copied().fold(0.0, f64::max);
    let mut next = at.to_vec();
    let mut open: Vec<usize> = (0..at.len()).filter(|k| energies[*k] > ridge).collect();
    while !open.is_empty() {
        // What is held has moved the residual already.
        let mut moved = off.to_vec();
        for k in (0..at.len()).filter(|k| !open.contains(k)) {
            for (v, slope) in moved.iter_mut().zip(&slopes[k]) {
                *v += (next[k] - at[k]) * slope;
            }
        }
        let n = open.len();
        let gram = DMatrix::from_fn(n, n, |a, b| {
            let ridge = if a == b { ridge } else { 0.0 };
            dot(&slopes[open[a]], &slopes[open[b]]) + ridge
        });
        let right = DVector::from_fn(n, |a, _| -dot(&slopes[open[a]], &moved));
        let Some(by) = gram.cholesky().map(|factor| factor.solve(&right)) else {
            break;
        };
        let mut within = Vec::new();
        for (k, by) in open.iter().copied().zip(by.iter()) {
            let to = at[k] + by;
            next[k] = to.clamp(ranges[k].0, ranges[k].1);
            if next[k] == to {
                within.push(k);
            }
        }
        if within.len() == n {
            break;
        }
        open = within;
    }
    next
}

/// What a sound rig may be late by in a way, where a hypothesis holds none of it.
fn sound_times(state: &[Applied], timing: Timing) -> Vec<Applied> {
    catalogue()
        .iter()
        .copied()
        .filter(|effect| effect.about().search.timing == Some(timing))
        .filter(|effect| {
            let id = effect.about().id;
            state.iter().all(|a| a.id() != id)
        })
        .flat_map(|effect: &'static dyn Effect| {
            let times = effect.about().search.allowance.iter();
            times
                .filter(|time_s| **time_s > 0.0)
                .map(move |time_s| Applied::allowed(effect, *time_s))
        })
        .collect()
}

#[cfg(test)]
mod tests;
