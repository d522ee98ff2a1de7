//! The held-out windows, and both models fitted without them.

use crate::contest::solved;
use crate::empirical::anew;
use crate::numbers::{tails, whole};
use crate::record::Record;
use crate::refine::refine;
use crate::relations::{Applied, Blocks, joined};
use crate::scan::scan;
use crate::selection::Selection;
use crate::tangent::{Bend, Tangent};
use crate::timing::{allowed_beside, is_late_meter};
use dgd_effects::{AppliedEffect, AugmentedModel};
use dgd_lsq::dot;

/// Length of a held-out window, s, at the least: a diagnosis promises 20 minutes, and whole samples and a gap at its ends may take some of it. Set by hand.
const WINDOW_S: f64 = 1260.0;
/// Share of the recording held out: a diagnosis promises a fifth, of which whole samples may take some. Set by hand.
const HELD_SHARE: f64 = 0.215;

/// The windows that no fit may see, s: evenly spread over the hours in which anything was read, none across a gap of them where that can be helped.
pub(crate) fn held_out_of(record: &Record, intervals: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let (span, told) = (record.setting.span_s, &record.told);
    let until = |t: f64| told.between_s((span.0, t));
    let apart = intervals.iter().map(|i| (until(i.0), until(i.1)));
    // A gap may no more be cut through than a finding's edge.
    let gaps = told.gaps().iter().map(|gap| (until(gap.0), until(gap.0)));
    let windows = held_out((0.0, until(span.1)), &apart.chain(gaps).collect::<Vec<_>>());
    (windows.into_iter())
        .map(|(from, to)| (told.beyond_s(span.0, from), told.until_s(span.0, to)))
        .collect()
}

/// The windows: one in each equal part of the recording.
///
/// A window does not straddle the beginning or the end of a finding (`intervals`), which the samples outside it could
/// not tell, and lies within a finding where it fits: there is something to show.
fn held_out(span: (f64, f64), intervals: &[(f64, f64)]) -> Vec<(f64, f64)> {
    /// What lies this near, s, a fit on the rest cannot place.
    const MARGIN_S: f64 = 180.0;
    /// Where the middle of a window lies in its part, if it may lie anywhere. Set by hand.
    const USUAL: f64 = 0.55;
    /// Step by which a window is moved, s.
    const STEP_S: f64 = 60.0;
    /// What it costs to cut a finding, and what it saves to lie within one, in seconds from the usual place: more than any distance
    /// in a part, the first more than the second.
    const CUT_S: f64 = 1e6;
    const WITHIN_S: f64 = 1e5;
    let total = span.1 - span.0;
    let count = whole((total * HELD_SHARE / WINDOW_S).floor()).max(1);
    let length = (total * HELD_SHARE / count as f64).max(WINDOW_S).min(total);
    let part = total / count as f64;
    (0..count)
        .map(|k| {
            let first = span.0 + part * k as f64;
            let usual = first + (USUAL * part - 0.5 * length).max(0.0);
            let steps = whole(((part - length) / STEP_S).floor().max(0.0));
            let cost = |from: f64| -> f64 {
                let to = from + length;
                let near =
                    |t: f64| t > span.0 && t < span.1 && t > from - MARGIN_S && t < to + MARGIN_S;
                let cut = intervals.iter().filter(|i| near(i.0) || near(i.1)).count();
                let within = intervals
                    .iter()
                    .filter(|i| i.0 <= from && i.1 >= to)
                    .count();
                CUT_S * cut as f64 - WITHIN_S * within as f64 + (from - usual).abs()
            };
            let from = (0..=steps)
                .map(|j| first + STEP_S * j as f64)
                .chain([usual])
                .min_by(|a, b| cost(*a).total_cmp(&cost(*b)))
                .unwrap_or(usual);
            let from = from.max(span.0);
            (from, (from + length).min(span.1))
        })
        .collect()
}

/// The first of some windows, s, which ascend, that ends after a time.
pub(crate) fn ends_after(windows: &[(f64, f64)], t_s: f64) -> Option<&(f64, f64)> {
    windows.get(windows.partition_point(|w| w.1 <= t_s))
}

/// The named effects fitted again on the training blocks alone.
///
/// The search begins at the grid's best or at the whole recording's answer, whichever leaves less in the training rows: an onset
/// may begin where the held-out rows helped to find it.
pub(crate) fn trained(
    record: &Record,
    start: &[Applied],
    selection: &Selection,
    excluded: &[bool],
) -> Option<Vec<Applied>> {
    let mut timed: Vec<Applied> = selection.named.iter().map(|n| n.applied.clone()).collect();
    let mut state = allowed_beside(record, start, &mut timed, excluded)?;
    for (k, (named, mut chosen)) in selection.named.iter().zip(timed).enumerate() {
        match named.applied.curve() {
            // Timed beside the pump's lag a moment ago.
            None if is_late_meter(named.applied.effect.about()) => {}
            None => {
                if let Some(tangent) = Tangent::at(record, &state, excluded, Bend::Stiff) {
                    let best = scan(record, &tangent, &state, named.applied.effect);
                    // Refined from where the training rows are explained better: a coarse grid beside the whole recording's place.
                    let left = |one: &Applied| {
                        let off = tangent.left_over(record, &joined(&state, one));
                        dot(&off, &off)
                    };
                    if let Some(coarse) = best.map(|best| solved(&best))
                        && left(&coarse) < left(&chosen)
                    {
                        chosen = coarse;
                    }
                }
            }
            Some(held) => {
                // Of two episodes the larger would be found again in place of either.
                let later = selection.named[k + 1..].iter().map(|n| &n.applied);
                let later = later.filter(|one| one.curve().is_some_and(|c| c.is_apart(&held)));
                let beside: Vec<Applied> = state.iter().chain(later).cloned().collect();
                let tangent = Tangent::at(record, &beside, excluded, Bend::Stiff);
                let again = tangent.and_then(|t| anew(record, &t, &beside, excluded, &held));
                // What the training rows do not show may not be run on the held-out windows.
                let trained = again.map_or_else(|| held.flattened(), |again| again.curve);
                chosen = Applied::from(&trained);
            }
        }
        state = joined(&state, &chosen);
    }
    let from = state.len() - selection.named.len();
    refine(record, &mut state, from, excluded, 2);
    Some(state)
}

/// The model that runs: curves, the range they were fitted on, effects. A run has no wander: its level is the curves'.
pub(crate) fn model(
    record: &Record,
    state: &[Applied],
    fit: &Tangent,
    excluded: &[bool],
) -> AugmentedModel {
    /// One block in so many lies beyond either end of a range.
    const TAIL: usize = 200;
    // In the true speed and flow, as the curves are: not in what an instrument reads that is off.
    let blocks = Blocks::under(record, state);
    let told = (0..record.blocks).filter(|b| fit.rows.head[*b]);
    let (speeds, ratios): (Vec<f64>, Vec<f64>) = told
        .map(|b| {
            (
                blocks.speed[b],
                blocks.through[b] / blocks.speed[b].max(1.0),
            )
        })
        .unzip();
    let range = |values: &[f64]| tails(values, TAIL).unwrap_or((0.0, 0.0));
    let (friction, head) = fit.flowing_level(&fit.residual, excluded);
    let mut curves = fit.curves.clone();
    curves.friction[0] += friction;
    curves.head[0] += head;
    AugmentedModel {
        curves,
        speed_range_pct: range(&speeds),
        ratio_range: range(&ratios),
        span_s: Some(record.setting.span_s),
        inlet_range_pa: Some(record.setting.inlet_range_pa),
        // What is early has no part in a run: nothing tells what is to come.
        effects: (state.iter())
            .filter(|a| !(a.allowance && a.parameters[0] < 0.0))
            .map(|a| AppliedEffect {
                id: a.id().to_owned(),
                parameters: a.parameters.clone(),
            })
            .collect(),
    }
}

#[cfg(test)]
mod tests;
