//! What the model is free to do: one column of the stacked rows for each coefficient, with the width it may take.

use super::Bend;
use super::frame::Frame;
use crate::ablation::Step;
use crate::cores::each;
use crate::error_budget::{late, late_flows};
use crate::layout::{Layout, Section};
use crate::noise::Whitening;
use crate::numbers::mean;
use crate::record::Record;
use crate::relations::{Applied, Blocks, Rows};
use crate::vectors::{Column, MANY, Sparse};
use dgd_effects::{FRICTION_TERMS, HEAD_POWERS, HEAD_TERMS, Scale, friction_terms, head_terms};
use dgd_recording::{Rank, quantile};
use std::sync::Arc;

/// Prior widths of the friction terms, Pa at the scale's flow: intercept and linear term are physics, not curve.
pub(crate) const FRICTION_PRIOR_PA: [f64; FRICTION_TERMS] =
    [3.0e3, 4.0e3, 1e8, 1e8, 4.0e3, 2e3, 2e3, 2e3, 2e3, 2e3];
/// Prior widths of the friction terms, Pa at the scale's flow. Of a line in which flow may be laminar, whose law stands in the second term, as wide as any
/// law's; and wide bumps, for flow between the regimes is irregular.
pub(super) fn friction_priors(scale: Scale) -> [f64; FRICTION_TERMS] {
    /// By what bumps are wider then. Set by hand.
    const IRREGULAR: f64 = 10.0;
    let mut widths = FRICTION_PRIOR_PA;
    if scale.laminar.is_some() {
        widths[1] = widths[2];
        widths[5..].iter_mut().for_each(|width| *width *= IRREGULAR);
    }
    widths
}

/// Prior widths of the head terms, Pa at the scale: an offset within accuracy, the parabola as a share of the lift, terms of
/// another degree than the second, which break the affinity laws, small, then bumps.
const HEAD_OFFSET_PA: f64 = 3.0e3;
const HEAD_ODD_PA: f64 = 5.0e4;
const HEAD_BUMP_PA: f64 = 4.0e4;
/// Prior width of what two redundant outlets may stand apart, Pa.
const OUTLETS_PRIOR_PA: f64 = 2e4;
/// Prior width of the head's lean on inlet pressure.
const LEAN_PRIOR: f64 = 0.1;
/// Prior width of the time that meter and drive answer late where only more than timing counts, s.
const LATE_S: f64 = 2.0;
/// Prior width of the time by which mud pump and meter answer later or sooner than is allowed for, s: allowances go in steps of half a second and
/// of one. Set by hand.
const LATE_FLOW_S: f64 = 0.35;
/// Longest recording in which they may be late, s. Set by hand: over days rows outweigh any width, and a meter that is 6 s late in 85 h was not
/// named beside them.
const LATE_FLOW_WITHIN_S: f64 = 10.0 * 3600.0;
/// How much wider the curves' priors are where every smooth shape is let in.
const LOOSE: f64 = 6.0;

/// Mean and width of each head term at the scale, Pa.
///
/// Radial pumps of any make: a shut-off head somewhat above the usual lift, which falls with flow (Gülich 2010, on
/// performance characteristics; the numbers are ours). Where speed and flow hardly vary it is this that keeps a curve of
/// any slope from hiding gas or wear.
pub(super) fn head_priors(rows: &Rows, blocks: &Blocks) -> [(f64, f64); HEAD_TERMS] {
    let lift = typical_lift(rows, blocks);
    let mut out = [(0.0, HEAD_BUMP_PA); HEAD_TERMS];
    out[0].1 = HEAD_OFFSET_PA;
    out[1] = (1.3 * lift, 0.25 * lift);
    out[2] = (0.0, 0.2 * lift);
    out[3] = (-0.3 * lift, 0.2 * lift);
    out[4..HEAD_POWERS].fill((0.0, HEAD_ODD_PA));
    out
}

/// Median lift of the pump where its head may be judged, Pa.
fn typical_lift(rows: &Rows, blocks: &Blocks) -> f64 {
    let lifts =
        (blocks.lift.iter().zip(&rows.head)).filter_map(|(lift, head)| head.then_some(*lift));
    quantile(lifts, Rank::MEDIAN).unwrap_or(1e6).max(1e5)
}

/// Friction terms, then head terms, then the offset of the outlets, the lean, lateness, the slack and flows that are told late, as far as
/// they are there.
pub(super) struct Columns {
    /// Whitened as soon as they are made, and held only so: columns are what a tangent's memory goes into.
    pub whitened: Vec<Column>,
    /// Those of what is no curve, in the units of the rows.
    pub beyond_curves: Vec<Arc<Sparse>>,
    /// Prior mean of each coefficient.
    pub means: Vec<f64>,
    /// Prior width of each coefficient.
    pub widths: Vec<f64>,
}

impl Columns {
    /// `blocks` are those under `applied`.
    pub(super) fn of(record: &Record, applied: &[Applied], blocks: &Blocks, frame: &Frame) -> Self {
        let whitening = &frame.whitening;
        let (layout, scale) = (whitening.layout, frame.curves.scale);
        let mut out = Self {
            whitened: Vec::new(),
            beyond_curves: Vec::new(),
            means: Vec::new(),
            widths: Vec::new(),
        };
        let (n, total) = (layout.blocks, layout.len());
        let wide = |term: usize| match frame.bend {
            Bend::Loose if term > 0 => LOOSE,
            _ => 1.0,
        };
        // Bends of the curves, each in one section.
        let bends = |section: Section, columns: Vec<Vec<f64>>| {
            let whiten = |column: Vec<f64>| {
                let mut whole = vec![0.0; total];
                whole[layout.rows(section)].copy_from_slice(&column);
                Column::of(&whitening.apply_whole(&whole))
            };
            if total * columns.len() >= MANY {
                each(columns, whiten)
            } else {
                columns.into_iter().map(whiten).collect()
            }
        };
        let friction = by_column(n, |b| {
            friction_terms(blocks.flow[b], scale).map(|v| v * blocks.friction_factor[b])
        });
        out.whitened.extend(bends(Section::Friction, friction));
        for (a, width) in friction_priors(scale).into_iter().enumerate() {
            out.means.push(0.0);
            out.widths.push(width * wide(a));
        }
        let head = by_column(n, |b| {
            head_terms(blocks.speed[b], blocks.through[b], scale).map(|v| v * blocks.head_factor[b])
        });
        out.whitened.extend(bends(Section::Head, head));
        for (a, (mean, width)) in head_priors(&frame.rows, blocks).into_iter().enumerate() {
            out.means.push(mean);
            out.widths.push(width * wide(a));
        }
        if layout.outlets > 0 {
            let mut column = vec![0.0; total];
            column[layout.rows(Section::Outlets)].fill(1.0);
            out.push_beyond(whitening, &column, OUTLETS_PRIOR_PA);
        }
        if frame.bend != Bend::Stiff {
            out.push_beyond(whitening, &lean(record, layout), LEAN_PRIOR);
        }
        if frame.bend == Bend::Loose {
            for column in late(record.block_s(), &frame.curves, blocks, layout) {
                out.push_beyond(whitening, &column, LATE_S);
            }
        }
        for free in &frame.slack {
            out.push(whitening, &free.column.whole(), 0.0, free.width);
            out.beyond_curves.push(Arc::clone(&free.column));
        }
        // Last, so that two hypotheses have all other columns alike. What a named lateness leaves over for want of form is no clock.
        if record.told_s() <= LATE_FLOW_WITHIN_S
            && record.takes(Step::LateFlows)
            && !applied.iter().any(Applied::names_lateness)
        {
            for column in late_flows(record, layout) {
                out.push_beyond(whitening, &column, LATE_FLOW_S);
            }
        }
        out
    }

    /// What is no curve.
    fn push_beyond(&mut self, whitening: &Whitening, column: &[f64], width: f64) {
        self.push(whitening, column, 0.0, width);
        let sparse = Sparse::of(column, &whitening.layout.sections());
        self.beyond_curves.push(Arc::new(sparse));
    }

    fn push(&mut self, whitening: &Whitening, column: &[f64], mean: f64, width: f64) {
        let whitened = whitening.apply_whole(column);
        self.whitened.push(Column::of(&whitened));
        self.means.push(mean);
        self.widths.push(width);
    }
}

/// The head's lean on inlet pressure.
///
/// Within the meter's noise, what the level tells of the flow is better than the meter: head leans towards the line
/// (lift = line pressure - inlet pressure), as any regression in a noisy flow must.
fn lean(record: &Record, layout: Layout) -> Vec<f64> {
    let inlet = &record.filled.inlet;
    let typical = mean(inlet);
    let mut column = vec![0.0; layout.len()];
    let head = &mut column[layout.rows(Section::Head)];
    for (row, samples) in head.iter_mut().zip(inlet.chunks(record.per_block)) {
        *row = mean(samples) - typical;
    }
    column
}

/// Columns of `count` rows from the terms of each row.
fn by_column<const K: usize>(count: usize, terms: impl Fn(usize) -> [f64; K]) -> Vec<Vec<f64>> {
    let mut columns = vec![vec![0.0; count]; K];
    for b in 0..count {
        for (column, v) in columns.iter_mut().zip(terms(b)) {
            column[b] = v;
        }
    }
    columns
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may fail by panic")]

    use super::{Columns, head_priors};
    use crate::ablation::Step;
    use crate::layout::{Layout, Section};
    use crate::numbers::mean;
    use crate::record::Record;
    use crate::relations::{Blocks, Rows};
    use crate::tangent::Bend;
    use crate::tangent::frame::Frame;
    use crate::test_rig::{Hidden, blocks, drilled};
    use crate::vectors::Column;
    use dgd_effects::{FRICTION_TERMS, HEAD_POWERS, HEAD_TERMS};

    fn record() -> Record {
        drilled(Hidden::default())
    }

    fn columns(record: &Record, bend: Bend) -> Columns {
        let blocks = Blocks::under(record, &[]);
        let frame = Frame::of(record, &blocks, &[], bend).unwrap();
        Columns::of(record, &[], &blocks, &frame)
    }

    #[test]
    fn a_pump_is_expected_to_lift_what_it_usually_does_falling_with_flow() {
        let priors = |lift: f64| {
            let mut b = blocks(90);
            b.lift.fill(lift);
            // Where the head may not be judged it tells nothing.
            b.lift[60..].fill(9.9 * lift);
            let rows = Rows {
                friction: vec![true; 90],
                still: vec![false; 90],
                head: (0..90).map(|k| k < 60).collect(),
                outlets: Vec::new(),
                balance: Vec::new(),
                stops: Vec::new(),
            };
            head_priors(&rows, &b)
        };
        let (one, two) = (priors(2e6), priors(4e6));
        // At the scale all terms are 1: the mean of the head is the sum of theirs.
        for (priors, lift) in [(one, 2e6), (two, 4e6)] {
            let head: f64 = priors[..HEAD_POWERS].iter().map(|p| p.0).sum();
            assert!((head / lift - 1.0).abs() < 1e-12);
            assert!(priors[1].0 > lift && priors[3].0 < 0.0);
            assert!(priors.iter().all(|p| p.1 > 0.0));
            // The parabola is free by about a fifth of the lift, and its pieces are not so free that it may rise with flow.
            for k in 1..4 {
                assert!((0.15..0.3).contains(&(priors[k].1 / lift)));
            }
        }
        // The parabola goes with the lift, all else does not.
        for (k, (one, two)) in one.iter().zip(&two).enumerate() {
            let times = if (1..4).contains(&k) { 2.0 } else { 1.0 };
            assert!((two.0 - times * one.0).abs() < 1e-6, "{k}");
            assert!((two.1 - times * one.1).abs() < 1e-6, "{k}");
        }
    }

    #[test]
    fn loose_curves_are_six_times_as_free_but_for_their_offsets() {
        let mut record = record();
        record.without = vec![Step::LateFlows];
        let curves = FRICTION_TERMS + HEAD_TERMS;
        for outlets in [1, 2] {
            if outlets == 2 {
                record.outlets.push(record.outlets[0].clone());
            }
            let [free, lean, loose] =
                [Bend::Stiff, Bend::Lean, Bend::Loose].map(|bend| columns(&record, bend).widths);
            // The offset of the outlets; the lean; what answers late.
            assert_eq!(free.len(), curves + outlets - 1);
            assert_eq!(lean.len(), free.len() + 1);
            assert_eq!(loose.len(), lean.len() + 2);
            assert_eq!(lean[..free.len()], free);
            for k in 0..free.len() {
                let offset = k == 0 || k == FRICTION_TERMS || k >= curves;
                let times = if offset { 1.0 } else { 6.0 };
                assert!((loose[k] / free[k] / times - 1.0).abs() < 1e-12, "{k}");
            }
        }
    }

    #[test]
    fn a_factor_on_a_curve_is_one_on_its_columns() {
        let record = record();
        let plain = Blocks::under(&record, &[]);
        let frame = Frame::of(&record, &plain, &[], Bend::Stiff).unwrap();
        let mut other = plain.clone();
        other.friction_factor.fill(1.25);
        other.head_factor.fill(0.5);
        let of = |b: &Blocks| -> Vec<Vec<f64>> {
            let whitened = Columns::of(&record, &[], b, &frame).whitened;
            let curves = whitened[..FRICTION_TERMS + HEAD_TERMS].iter();
            curves.map(Column::whole).collect()
        };
        for (k, (one, other)) in of(&plain).iter().zip(of(&other)).enumerate() {
            let factor = if k < FRICTION_TERMS { 1.25 } else { 0.5 };
            let size = one.iter().fold(0.0, |m: f64, v| m.max(v.abs()));
            for (one, other) in one.iter().zip(other) {
                assert!((other - factor * one).abs() <= 1e-9 * size, "{k}");
            }
        }
    }

    #[test]
    fn the_lean_is_the_inlet_pressure_about_its_mean_in_the_rows_of_the_head() {
        let record = record();
        let lean = columns(&record, Bend::Lean).beyond_curves[0].whole();
        let layout = Layout {
            blocks: record.blocks,
            outlets: 0,
            balance: record.blocks / 3,
        };
        assert_eq!(lean.len(), layout.len());
        let head = layout.rows(Section::Head);
        let typical = mean(&record.filled.inlet);
        assert!(lean[..head.start].iter().all(|v| *v == 0.0));
        assert!(lean[head.end..].iter().all(|v| *v == 0.0));
        assert!(mean(&lean[head.clone()]).abs() < 1e-3);
        for (b, row) in lean[head].iter().enumerate() {
            let m = record.per_block;
            let here = mean(&record.filled.inlet[b * m..(b + 1) * m]);
            assert!((row - (here - typical)).abs() < 1e-6);
        }
    }
}
