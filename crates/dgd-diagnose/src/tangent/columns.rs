//! What the model is free to do: one column of the stacked rows for each coefficient, with the width it may take.

use super::Bend;
use super::frame::Frame;
use crate::noise::{Layout, Whitening};
use crate::record::{Record, mean};
use crate::relations::{Blocks, Rows};
use crate::unrest::late;
use crate::vectors::Sparse;
use dgd_effects::{
    FRICTION_TERMS, HEAD_POWERS, HEAD_TERMS, Rank, friction_terms, head_terms, quantile,
};
use std::sync::Arc;

/// Prior widths of the friction terms, Pa at the scale's flow: intercept and linear term are physics, not curve.
pub(crate) const FRICTION_PRIOR_PA: [f64; FRICTION_TERMS] =
    [3.0e3, 4.0e3, 1e8, 1e8, 4.0e3, 2e3, 2e3, 2e3, 2e3, 2e3];
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

/// Friction terms, then head terms, then the offset of the outlets, the lean, lateness and the slack, as far as they are there.
pub(super) struct Columns {
    /// Whitened as soon as they are made, and held only so: columns are what a tangent's memory goes into.
    pub whitened: Vec<Vec<f64>>,
    /// Those of what is no curve, in the units of the rows.
    pub beyond_curves: Vec<Arc<Sparse>>,
    /// Prior mean of each coefficient.
    pub means: Vec<f64>,
    /// Prior width of each coefficient.
    pub widths: Vec<f64>,
}

impl Columns {
    pub(super) fn of(record: &Record, blocks: &Blocks, frame: &Frame) -> Self {
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
        let friction = by_column(total, 0, n, |b| {
            friction_terms(blocks.flow[b], scale).map(|v| v * blocks.friction_factor[b])
        });
        for (a, (column, width)) in friction.into_iter().zip(FRICTION_PRIOR_PA).enumerate() {
            out.push(whitening, &column, 0.0, width * wide(a));
        }
        let head = by_column(total, n, n, |b| {
            head_terms(blocks.speed[b], blocks.through[b], scale).map(|v| v * blocks.head_factor[b])
        });
        let priors = head_priors(&frame.rows, blocks);
        for (a, (column, (mean, width))) in head.into_iter().zip(priors).enumerate() {
            out.push(whitening, &column, mean, width * wide(a));
        }
        let sections = layout.sections();
        let mut beyond = |column: Vec<f64>, width: f64| {
            out.push(whitening, &column, 0.0, width);
            out.beyond_curves
                .push(Arc::new(Sparse::of(&column, &sections)));
        };
        if layout.difference > 0 {
            let mut column = vec![0.0; total];
            column[layout.difference_at()..layout.mass_at()].fill(1.0);
            beyond(column, OUTLETS_PRIOR_PA);
        }
        if frame.bend != Bend::Free {
            beyond(lean(record, layout), LEAN_PRIOR);
        }
        if frame.bend == Bend::Loose {
            for column in late(record.block_s(), &frame.curves, blocks, layout) {
                beyond(column, LATE_S);
            }
        }
        for free in &frame.slack {
            out.push(whitening, &free.column.whole(), 0.0, free.width);
            out.beyond_curves.push(Arc::clone(&free.column));
        }
        out
    }

    fn push(&mut self, whitening: &Whitening, column: &[f64], mean: f64, width: f64) {
        self.whitened.push(whitening.apply_whole(column));
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
    let head = &mut column[layout.head()..layout.difference_at()];
    for (row, samples) in head.iter_mut().zip(inlet.chunks(record.per_block)) {
        *row = mean(samples) - typical;
    }
    column
}

/// Columns of `total` rows from the terms of each of `count` rows after `first`.
fn by_column<const K: usize>(
    total: usize,
    first: usize,
    count: usize,
    terms: impl Fn(usize) -> [f64; K],
) -> Vec<Vec<f64>> {
    let mut columns = vec![vec![0.0; total]; K];
    for b in 0..count {
        for (column, v) in columns.iter_mut().zip(terms(b)) {
            column[first + b] = v;
        }
    }
    columns
}
