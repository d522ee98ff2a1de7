//! The placebo: the same effect at other times, which must explain less.

use crate::diagnosis::Check;
use crate::record::Record;
use crate::relations::{Applied, joined};
use crate::scan::{Candidate, weigh};
use crate::selection::Selection;
use crate::tangent::{Bend, Tangent};
use dgd_lsq::dot;

/// Times at which a finding is tried again, at the most.
const TIMES: usize = 5;

/// Share of what a finding explains that its best placebo stays below: set by hand.
const MOST: f64 = 0.2;

/// Evidence that a finding must have beside the others for a share of it to tell anything, e-folds: by noise alone one score shows as much
/// in one case of seventy.
const LEAST: f64 = 3.0;

/// Of each finding that sets in, what the same effect explains at other times.
///
/// A check that is shown, and decides nothing: a wrong finding may pass it too.
pub(crate) fn placebo(record: &Record, selection: &Selection) -> Vec<Check> {
    (0..selection.named.len())
        .filter_map(|k| held_against(record, selection, k))
        .collect()
}

/// A finding beside its placebos; `None` if it has no onset, no other time is left for it, or it explains next to nothing by itself.
fn held_against(record: &Record, selection: &Selection, k: usize) -> Option<Check> {
    let named = &selection.named[k].applied;
    let about = named.effect.about();
    let onset = about.onset()?;
    let times = other_times(record, named);
    if times.is_empty() {
        return None;
    }
    let rest = selection.named.iter().enumerate().filter(|(j, _)| *j != k);
    let others = rest.fold(selection.allowances.clone(), |all, (_, n)| {
        joined(&all, &n.applied)
    });
    let tangent = Tangent::at(record, &others, &[], Bend::Stiff)?;
    let own = weigh(record, &tangent, &others, named.clone());
    let explained = 0.5 * own.score * own.score / own.energy;
    // With no energy it is no number, and of next to nothing every share is large.
    if !explained.is_finite() || explained < LEAST {
        return None;
    }
    let tries = times.iter().map(|at| {
        let mut moved = named.clone();
        moved.parameters[onset] = *at;
        let moved = weigh(record, &tangent, &others, moved);
        (beyond(&own, &moved) / explained, *at)
    });
    let (share, at) = tries.max_by(|a, b| a.0.total_cmp(&b.0))?;
    Some(Check {
        name: format!("{}: explains less at any other onset", about.id),
        passed: share < MOST,
        detail: format!(
            "of the evidence of {explained:.0} at {:.0} s, the best of {} other times, {:.0} s, explains {:.0} %",
            named.parameters[onset],
            times.len(),
            at,
            100.0 * share
        ),
    })
}

/// What a placebo explains beyond what it shares with the finding: what stays once it is on, is on at later onsets too.
fn beyond(own: &Candidate, placebo: &Candidate) -> f64 {
    /// Share of a placebo's energy below which it is the finding over again.
    const SAME: f64 = 1e-3;
    let shared = dot(&own.signature, &placebo.signature) / own.energy;
    let energy = placebo.energy - shared * shared * own.energy;
    let score = placebo.score - shared * own.score;
    let one_sided = placebo.applied.effect.about().parameters[0].low >= 0.0;
    if energy <= SAME * placebo.energy || (one_sided && score < 0.0) {
        return 0.0;
    }
    0.5 * score * score / energy
}

/// Onsets, spread over the recording, at which an effect would pass without meeting itself; or, of what stays on, would set in at
/// another time.
fn other_times(record: &Record, one: &Applied) -> Vec<f64> {
    /// Places that are looked at.
    const PLACES: usize = 40;
    /// Share of the recording between two onsets of what stays on.
    const APART: f64 = 0.1;
    let about = one.effect.about();
    let (from, to) = record.setting.span_s;
    let (Some(onset), span) = (about.onset(), to - from) else {
        return Vec::new();
    };
    let lasts = about.duration().map(|k| one.parameters[k]);
    let last = to - lasts.unwrap_or(APART * span);
    let apart = lasts.unwrap_or(APART * span);
    let free: Vec<f64> = (1..PLACES)
        .map(|k| from + (last - from) * k as f64 / PLACES as f64)
        .filter(|at| (at - one.parameters[onset]).abs() >= apart && *at < last)
        .collect();
    let tries = TIMES.min(free.len());
    // In the middle of as many stretches.
    (0..tries)
        .map(|k| free[(2 * k + 1) * free.len() / (2 * tries)])
        .collect()
}

#[cfg(test)]
mod tests;
