//! Spikes: a few samples far off, with the same level before and after; and dropouts: one value repeated there for up to a minute.
//!
//! A Hampel filter (median of the neighbours, k robust standard deviations), but
//! only looked at where the series jumps, so that the cost is one cheap pass.

use crate::Faults;
use crate::scan::{Steps, level, median};
use dgd_recording::{Run, STANDING_M3_S};
use std::ops::Range;

/// How large and how long a spike is.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SpikeRule {
    pub(crate) sigmas: f64,
    pub(crate) longest: usize,
    /// Longest dropout, samples; 0 for what is no inflow.
    pub(crate) dropout: usize,
    /// The quantity may be set from one value to another and back: a dropout must then have come into noise.
    pub(crate) may_be_set: bool,
}

/// No spike is longer, whatever the clock: it bounds the work at each jump.
pub(crate) const LONGEST: usize = 50;
/// Nor a dropout.
pub(crate) const LONGEST_DROPOUT: usize = 120;
/// Neighbours looked at on either side.
const BESIDE: usize = 7;
/// Samples on either side of which these are taken.
pub(crate) const LOOKED_AT: usize = 3 * BESIDE;
/// Fewer neighbours than this on a side say nothing about its level.
const FEWEST: usize = 3;
/// The levels before and after may differ by this share of the excursion.
const RETURN_SHARE: f64 = 1.0 / 3.0;

/// An excursion and how far it leads off the level around it.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Excursion {
    pub(crate) range: Range<usize>,
    pub(crate) height: f64,
    /// The signal of a pump that runs was lost.
    pub(crate) dropout: bool,
}

impl Excursion {
    /// The run that a dropout is.
    pub(crate) fn run(&self, values: &[f64]) -> Run {
        Run {
            start: self.range.start,
            length: self.range.len(),
            value: values[self.range.start],
        }
    }
}

/// Smallest jump into a spike; infinite for a series that never moves.
pub(crate) fn least(steps: Steps, rule: SpikeRule) -> f64 {
    let least = (rule.sigmas * steps.noise).max(4.0 * steps.quantum);
    if least > 0.0 { least } else { f64::INFINITY }
}

/// Spikes of a series in order, from its jumps of more than [`least`]; `twins` are its redundant transmitters, and what one of
/// them shows too has happened.
pub(crate) fn find(
    values: &[f64],
    faults: &[Faults],
    jumps: &[usize],
    steps: Steps,
    rule: SpikeRule,
    twins: &[&[f64]],
) -> Vec<Excursion> {
    let mut found: Vec<Excursion> = Vec::new();
    let least = least(steps, rule);
    for &at in jumps {
        if found.last().is_some_and(|last| at < last.range.end) {
            continue;
        }
        // A jump is the way in of a spike, or the way out of one that begins at a gap.
        let after_gap = (1..=rule.longest.min(at))
            .find(|l| at == *l || !values[at - l - 1].is_finite())
            .map(|l| at - l..at);
        let forward = (1..=rule.longest)
            .map(|l| at..at + l)
            .take_while(|r| r.end <= values.len());
        let own = |range: &Range<usize>| {
            let height = excursion(values, faults, range, least, rule.sigmas)?;
            let shared = twins.iter().any(|twin| {
                shows(twin, range).is_some_and(|h| h * height.signum() > 0.5 * height.abs())
            });
            (!shared).then_some(height)
        };
        let spike = forward
            .chain(after_gap)
            .find_map(|range| Some((own(&range)?, range)));
        let long = || {
            let range = dropout(values, at, rule)?;
            Some((own(&range)?, range))
        };
        let excursion = spike.or_else(long).map(|(height, range)| Excursion {
            dropout: is_lost(values, &range, height, steps, rule),
            range,
            height,
        });
        found.extend(excursion.filter(|e| e.dropout || e.range.len() <= rule.longest));
    }
    found
}

/// The samples that repeat the value at `at`, if they are more than a spike has and not too many for a dropout.
fn dropout(values: &[f64], at: usize, rule: SpikeRule) -> Option<Range<usize>> {
    let most = &values[at..values.len().min(at + rule.dropout + 1)];
    let length = most.iter().take_while(|v| **v == values[at]).count();
    (length > rule.longest && length <= rule.dropout).then_some(at..at + length)
}

/// Whether an excursion is what a logger writes that has lost the signal of a pump that runs: nothing, or a number beyond what it pumps.
fn is_lost(
    values: &[f64],
    range: &Range<usize>,
    height: f64,
    steps: Steps,
    rule: SpikeRule,
) -> bool {
    /// A code is beyond so many times the rate.
    const BEYOND: f64 = 2.0;
    let value = values[range.start];
    let rate = value - height;
    let runs = rate > STANDING_M3_S && rate > rule.sigmas * steps.noise;
    let told = value.abs() <= steps.quantum || value > BEYOND * rate;
    let one_value = values[range.clone()].iter().all(|v| *v == value);
    let before = &values[range.start.saturating_sub(LOOKED_AT)..range.start];
    let after = &values[range.end..values.len().min(range.end + LOOKED_AT)];
    let moves = |part: &[f64]| {
        let mut finite = part.iter().filter(|v| v.is_finite());
        let first = finite.next();
        finite.any(|v| Some(v) != first)
    };
    let by_hand = rule.may_be_set && !(moves(before) && moves(after));
    rule.dropout > 0 && runs && told && one_value && !by_hand
}

/// Height of `range` over the level around it, if it is a spike.
fn excursion(
    values: &[f64],
    faults: &[Faults],
    range: &Range<usize>,
    least: f64,
    sigmas: f64,
) -> Option<f64> {
    // It must leave as abruptly as it came; a gap or the end is no way out to judge by.
    let exit = values
        .get(range.end)
        .map(|v| (v - values[range.end - 1]).abs());
    if exit.is_some_and(|e| e <= least) {
        return None;
    }
    let inside = &values[range.clone()];
    if !near(values, range, inside, least) {
        return None;
    }
    let beside = |samples: &mut dyn Iterator<Item = usize>| {
        let mut list = [0.0; BESIDE];
        let usable = |i: &usize| faults[*i] == Faults::NONE && values[*i].is_finite();
        let mut count = 0;
        for (place, i) in list.iter_mut().zip(samples.take(LOOKED_AT).filter(usable)) {
            *place = values[i];
            count += 1;
        }
        (count >= FEWEST).then(|| level(&mut list[..count]))?
    };
    let (before, spread_before) = beside(&mut (0..range.start).rev())?;
    let (after, spread_after) = beside(&mut (range.end..values.len()))?;
    let base = 0.5 * (before + after);
    let smallest = smallest_over(inside, base)?;
    let enough = least.max(sigmas * spread_before.max(spread_after));
    let returns = (after - before).abs() <= RETURN_SHARE * smallest.abs();
    (returns && smallest.abs() > enough).then_some(smallest)
}

/// The value nearest to `base`, less it; `None` if they lie on both sides.
fn smallest_over(inside: &[f64], base: f64) -> Option<f64> {
    let smallest = inside
        .iter()
        .map(|v| v - base)
        .min_by(|a, b| a.abs().total_cmp(&b.abs()))?;
    let one_sided = inside.iter().all(|v| (v - base) * smallest > 0.0);
    one_sided.then_some(smallest)
}

/// A cheap look at the two neighbours alone, with slack: most jumps are steps or ramps.
fn near(values: &[f64], range: &Range<usize>, inside: &[f64], least: f64) -> bool {
    let before = range.start.checked_sub(1).and_then(|i| values.get(i));
    let (Some(before), Some(after)) = (before, values.get(range.end)) else {
        return true;
    };
    if !(before.is_finite() && after.is_finite()) {
        return true;
    }
    smallest_over(inside, 0.5 * (before + after)).is_some_and(|height| {
        height.abs() > 0.5 * least && (after - before).abs() <= 2.0 * RETURN_SHARE * height.abs()
    })
}

/// How far a twin's mean over `range` lies off its own level around it.
fn shows(twin: &[f64], range: &Range<usize>) -> Option<f64> {
    let finite = |r: Range<usize>| -> Vec<f64> {
        twin[r].iter().copied().filter(|v| v.is_finite()).collect()
    };
    let before = median(&mut finite(range.start.saturating_sub(BESIDE)..range.start))?;
    let after = median(&mut finite(
        range.end..(range.end + BESIDE).min(twin.len()).max(range.end),
    ))?;
    let inside = median(&mut finite(range.clone()))?;
    Some(inside - 0.5 * (before + after))
}
