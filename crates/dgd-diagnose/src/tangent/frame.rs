//! What a tangent stands on: which rows count, the curves it is linearised at, and the noise beside them.

use super::Bend;
use super::curves::{Evaluated, robust_curves};
use crate::error_budget::{unrest, wander};
use crate::layout::{BALANCE_BLOCKS, Layout, Section};
use crate::noise::Whitening;
use crate::record::Record;
use crate::relations::{Blocks, Rows};
use crate::slack::Slack;
use crate::stops::Stop;
use dgd_effects::{Curves, Scale};
use dgd_recording::{Rank, quantile};
use std::sync::Arc;

/// Valid rows of friction and of head, without which there is nothing to fit.
pub(crate) const LEAST_ROWS: usize = 60;

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
        /// Least flow, m³/s, and speed, %, that curves are scaled by: of a pump that hardly runs. Set by hand.
        const LEAST_FLOW_M3_S: f64 = 5e-3;
        const LEAST_SPEED_PCT: f64 = 10.0;
        let mut rows = Rows::of(record, blocks);
        exclude(&mut rows, &record.stops, excluded);
        let scale = Scale {
            flow_m3_s: upper(&record.flow)?.max(LEAST_FLOW_M3_S),
            speed_pct: upper(&record.speed)?.max(LEAST_SPEED_PCT),
            laminar: record.laminar,
        };
        let enough = |valid: &[bool]| valid.iter().filter(|v| **v).count() >= LEAST_ROWS;
        if !enough(&rows.friction) || !enough(&rows.head) {
            return None;
        }
        let curves = robust_curves(&rows, blocks, scale);
        let layout = Layout {
            blocks: record.blocks,
            outlets: blocks.difference.len(),
            balance: blocks.imbalance.len(),
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
        isolated: Vec<usize>,
    ) -> Self {
        let layout = self.whitening.layout;
        for row in isolated {
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
fn exclude(rows: &mut Rows, stops: &[Stop], excluded: &[bool]) {
    let out = |b: usize| excluded.get(b).copied().unwrap_or(false);
    for (used, stop) in rows.stops.iter_mut().zip(stops) {
        *used &= !stop.blocks.clone().any(out);
    }
    for b in (0..rows.friction.len()).filter(|&b| out(b)) {
        rows.friction[b] = false;
        rows.head[b] = false;
        if let Some(d) = rows.outlets.get_mut(b) {
            *d = false;
        }
        if let Some(m) = rows.balance.get_mut(b / BALANCE_BLOCKS) {
            *m = false;
        }
    }
}

/// Takes one stacked row out; a friction row takes the head row of its block along.
fn strike(rows: &mut Rows, layout: Layout, row: usize) {
    match layout.place(row) {
        (Section::Friction, b) => (rows.friction[b], rows.head[b]) = (false, false),
        (Section::Head, b) => rows.head[b] = false,
        (Section::Outlets, b) => rows.outlets[b] = false,
        (Section::Balance, k) => rows.balance[k] = false,
    }
}

/// Deviations from which on a row stands out, and up to which its neighbours are calm. Set by hand.
const STANDS_OUT: f64 = 4.5;
const CALM: f64 = 3.0;
/// Blocks after a start of the pump in which its rows stand out for other reasons: a minute and a half. Set by hand.
const STARTING: usize = 9;

/// Rows more than [`STANDS_OUT`] deviations off between calm neighbours, away from starts of the pump: `off` is whitened, stacked.
///
/// A row that stands out alone is a glitch: no effect of minutes looks like that.
pub(super) fn isolated(record: &Record, layout: Layout, off: &[f64]) -> Vec<usize> {
    let m = record.per_block;
    let starting = |b: usize| {
        let r = (b.saturating_sub(STARTING) * m)..((b + 2) * m).min(record.filled.pumping.len());
        record.filled.pumping[r].iter().any(|p| !*p)
    };
    let mut out = Vec::new();
    for section in Section::ALL {
        let rows = layout.rows(section);
        let (from, to) = (rows.start, rows.end);
        let of_the_pump = matches!(section, Section::Friction | Section::Head);
        for row in rows {
            if off[row].abs() < STANDS_OUT || (of_the_pump && starting(row - from)) {
                continue;
            }
            // The memory of the filter lets a glitch ring in the row behind it; all else about it is calm.
            let calm = |i: usize| i >= to || off[i].abs() < CALM;
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

#[cfg(test)]
mod tests {
    use super::{exclude, isolated, strike};
    use crate::layout::BALANCE_BLOCKS;
    use crate::layout::Layout;
    use crate::relations::Rows;
    use crate::test_rig::{PER_BLOCK, steady, stops_told_late};

    const BLOCKS: usize = 60;
    const LAYOUT: Layout = Layout {
        blocks: BLOCKS,
        outlets: BLOCKS,
        balance: BLOCKS / BALANCE_BLOCKS,
    };

    fn rows() -> Rows {
        Rows {
            friction: vec![true; BLOCKS],
            still: vec![false; BLOCKS],
            head: vec![true; BLOCKS],
            outlets: vec![true; BLOCKS],
            balance: vec![true; BLOCKS / BALANCE_BLOCKS],
            stops: Vec::new(),
        }
    }

    /// Rows of friction, head, difference and balance that are out.
    fn out(rows: &Rows) -> [Vec<usize>; 4] {
        [&rows.friction, &rows.head, &rows.outlets, &rows.balance]
            .map(|valid| (0..valid.len()).filter(|&k| !valid[k]).collect())
    }

    fn none() -> Vec<usize> {
        Vec::new()
    }

    /// Which rows stand out alone where a recording is off by so much in some rows.
    fn alone(off: &[(usize, f64)], stands: &[usize]) -> Vec<usize> {
        let mut record = steady(BLOCKS);
        for block in stands {
            record.filled.pumping[block * PER_BLOCK + 2] = false;
        }
        let mut all = vec![0.0; LAYOUT.len()];
        off.iter().for_each(|(row, by)| all[*row] = *by);
        isolated(&record, LAYOUT, &all)
    }

    #[test]
    fn an_excluded_block_takes_every_row_of_it_out() {
        let mut rows = rows();
        let mut excluded = vec![false; 20];
        excluded[13] = true;
        exclude(&mut rows, &[], &excluded);
        assert_eq!(out(&rows), [vec![13], vec![13], vec![13], vec![4]]);
        // Without a second transmitter, and beyond the last whole row of the balance.
        rows.outlets.clear();
        rows.balance.truncate(4);
        excluded = vec![false; BLOCKS];
        excluded[59] = true;
        exclude(&mut rows, &[], &excluded);
        assert_eq!(out(&rows), [vec![13, 59], vec![13, 59], vec![], vec![]]);
    }

    #[test]
    fn an_excluded_block_takes_the_stop_out_that_it_lies_in() {
        let stops = stops_told_late(9);
        let used = |b: usize| {
            let mut rows = Rows {
                stops: vec![true; stops.len()],
                ..rows()
            };
            let mut excluded = vec![false; 540];
            excluded[b] = true;
            exclude(&mut rows, &stops, &excluded);
            rows.stops
        };
        // From 20 s before the pump stands at 1700 s, and 3500 s, to a minute and a half after.
        for (b, expected) in [
            (167, [true, true, true]),
            (168, [false, true, true]),
            (178, [false, true, true]),
            (179, [true, true, true]),
            (350, [true, false, true]),
        ] {
            assert_eq!(used(b), expected, "{b}");
        }
    }

    #[test]
    fn a_struck_row_is_one_of_its_section_and_friction_takes_the_head_along() {
        let struck = |row: usize| {
            let mut rows = rows();
            strike(&mut rows, LAYOUT, row);
            out(&rows)
        };
        for k in [0, 7, BLOCKS - 1] {
            assert_eq!(struck(k), [vec![k], vec![k], none(), none()]);
            assert_eq!(struck(BLOCKS + k), [none(), vec![k], none(), none()]);
            assert_eq!(struck(2 * BLOCKS + k), [none(), none(), vec![k], none()]);
        }
        for k in [0, 7, BLOCKS / BALANCE_BLOCKS - 1] {
            assert_eq!(struck(3 * BLOCKS + k), [none(), none(), none(), vec![k]]);
        }
    }

    #[test]
    fn a_row_between_calm_neighbours_is_alone_whatever_its_sign() {
        for section in 0..4 {
            let (from, rows) = (section * BLOCKS, LAYOUT.sections()[section].len());
            for k in [0, 1, 9, rows - 2, rows - 1] {
                for by in [5.0, -5.0] {
                    let row = from + k;
                    assert_eq!(alone(&[(row, by)], &[]), [row]);
                    assert_eq!(alone(&[(row, 0.8 * by)], &[]), none());
                }
            }
        }
    }

    #[test]
    fn a_row_rings_in_the_next_and_what_is_off_for_longer_is_not_alone() {
        let at = BLOCKS + 30;
        let with = |by: isize, off: f64| alone(&[(at, 6.0), (at.strict_add_signed(by), off)], &[]);
        for by in [-2, -1, 2, 3, 4] {
            assert_eq!(with(by, 4.0), none(), "{by}");
            assert_eq!(with(by, -4.0), none(), "{by}");
            assert_eq!(with(by, 2.0), [at], "{by}");
        }
        for (by, off) in [(1, 4.0), (-3, 4.0), (5, 4.0)] {
            assert_eq!(with(by, off), [at], "{by}");
        }
        // What is off in another section is no neighbour.
        let (last, first) = (2 * BLOCKS - 1, 2 * BLOCKS);
        assert_eq!(alone(&[(last, 6.0), (first + 1, 4.0)], &[]), [last]);
        assert_eq!(alone(&[(first, 6.0), (last, 4.0)], &[]), [first]);
        assert_eq!(alone(&[(first + 1, 6.0), (last, 4.0)], &[]), [first + 1]);
    }

    #[test]
    fn beside_a_start_a_row_of_the_line_or_the_pump_is_no_glitch() {
        let stands = 40;
        for k in [0, 30, 38, 39, 40, 44, 48, 49, 50, 58, 59] {
            // From the block before the pump stands to a minute and a half after.
            let near = (39..=49).contains(&k);
            for (section, blocked) in [near, near, false].into_iter().enumerate() {
                let row = section * BLOCKS + k;
                let found = alone(&[(row, 6.0)], &[stands]);
                assert_eq!(found.is_empty(), blocked, "{section} {k}");
            }
        }
        let balance = 3 * BLOCKS + 40 / BALANCE_BLOCKS;
        assert_eq!(alone(&[(balance, 6.0)], &[stands]), [balance]);
    }
}
