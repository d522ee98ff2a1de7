//! What a tangent stands on: which rows count, the curves it is linearised at, and the noise beside them.

use super::Bend;
use super::curves::{Evaluated, robust_curves};
use crate::noise::{Layout, Whitening};
use crate::record::{MASS_BLOCKS, Record};
use crate::relations::{Blocks, Rows};
use crate::slack::Slack;
use crate::unrest::{unrest, wander};
use dgd_effects::{Curves, Rank, Scale, quantile};
use std::sync::Arc;

/// Valid rows of friction and of head, without which there is nothing to fit.
const LEAST_ROWS: usize = 60;

/// All but the hypothesis.
#[derive(Clone)]
pub(super) struct Frame {
    pub rows: Rows,
    pub curves: Curves,
    pub whitening: Arc<Whitening>,
    pub bend: Bend,
    pub slack: Vec<Slack>,
}

impl Frame {
    /// Curves fitted robustly and the noise that they leave, without the `excluded` blocks; `None` where too little is left.
    pub(super) fn of(
        record: &Record,
        blocks: &Blocks,
        excluded: &[bool],
        bend: Bend,
    ) -> Option<Self> {
        let mut rows = Rows::of(record, blocks);
        exclude(&mut rows, excluded);
        let scale = Scale {
            flow_m3_s: upper(&record.flow)?.max(5e-3),
            speed_pct: upper(&record.speed)?.max(10.0),
        };
        let enough = |valid: &[bool]| valid.iter().filter(|v| **v).count() >= LEAST_ROWS;
        if !enough(&rows.friction) || !enough(&rows.head) {
            return None;
        }
        let curves = robust_curves(&rows, blocks, scale);
        let layout = Layout {
            blocks: record.blocks,
            difference: blocks.difference.len(),
            mass: blocks.imbalance.len(),
        };
        let residual = Evaluated::of(&curves, blocks, None).residual(layout, blocks);
        Some(Self {
            whitening: whitening(record, blocks, layout, &rows, &curves, &residual),
            rows,
            curves,
            bend,
            slack: Vec::new(),
        })
    }

    /// The noise measured anew beside better curves, without the rows that stand out alone.
    pub(super) fn again(
        mut self,
        record: &Record,
        blocks: &Blocks,
        curves: Curves,
        residual: &[f64],
        lonely: Vec<usize>,
    ) -> Self {
        let layout = self.whitening.layout;
        for row in lonely {
            strike(&mut self.rows, layout, row);
        }
        self.whitening = whitening(record, blocks, layout, &self.rows, &curves, residual);
        self.curves = curves;
        self
    }
}

/// The noise in the residuals of some curves.
fn whitening(
    record: &Record,
    blocks: &Blocks,
    layout: Layout,
    rows: &Rows,
    curves: &Curves,
    residual: &[f64],
) -> Arc<Whitening> {
    let unrest = unrest(record, curves, blocks, layout);
    let wander = wander(record, curves);
    Arc::new(Whitening::of(layout, rows, residual, &unrest, wander))
}

/// Takes every row of the excluded blocks out.
fn exclude(rows: &mut Rows, excluded: &[bool]) {
    for b in (0..rows.friction.len()).filter(|&b| excluded.get(b).copied().unwrap_or(false)) {
        rows.friction[b] = false;
        rows.head[b] = false;
        if let Some(d) = rows.difference.get_mut(b) {
            *d = false;
        }
        if let Some(m) = rows.mass.get_mut(b / MASS_BLOCKS) {
            *m = false;
        }
    }
}

/// Takes one stacked row out; a friction row takes the head row of its block along.
fn strike(rows: &mut Rows, layout: Layout, row: usize) {
    if row < layout.head() {
        rows.friction[row] = false;
        rows.head[row] = false;
    } else if row < layout.difference_at() {
        rows.head[row - layout.head()] = false;
    } else if row < layout.mass_at() {
        rows.difference[row - layout.difference_at()] = false;
    } else {
        rows.mass[row - layout.mass_at()] = false;
    }
}

/// Rows more than 4.5 deviations off between calm neighbours, away from starts of the pump: `off` is whitened, stacked.
///
/// A row that stands out alone is a glitch: no effect of minutes looks like that.
pub(super) fn lonely(record: &Record, layout: Layout, off: &[f64]) -> Vec<usize> {
    let m = record.per_block;
    let starting = |b: usize| {
        let r = (b.saturating_sub(9) * m)..((b + 2) * m).min(record.filled.pumping.len());
        record.filled.pumping[r].iter().any(|p| !*p)
    };
    let mut out = Vec::new();
    for (k, section) in layout.sections().into_iter().enumerate() {
        let (from, to) = (section.start, section.end);
        for row in section {
            let block = if k == 3 {
                (row - from) * MASS_BLOCKS
            } else {
                row - from
            };
            if off[row].abs() < 4.5 || (k < 2 && starting(block)) {
                continue;
            }
            // The memory of the filter lets a glitch ring for two rows; before it all is calm.
            let calm = |i: usize| i < from || i >= to || off[i].abs() < 3.0;
            let before = row == from || (calm(row - 1) && (row < from + 2 || calm(row - 2)));
            let after = calm(row + 2) && calm(row + 3) && calm(row + 4);
            if before && after {
                out.push(row);
            }
        }
    }
    out
}

/// 95th percentile of the finite values.
fn upper(values: &[f64]) -> Option<f64> {
    quantile(values.iter().copied(), Rank::Before(0.95))
}
