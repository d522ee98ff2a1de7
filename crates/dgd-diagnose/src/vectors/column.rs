//! A column over many rows of which only those that it touches take memory.

use super::{Reach, common, joint, support};
use dgd_lsq::dot;
use std::ops::Range;

/// Rows held on either side of a reach, 0 in all of them: products that go by eights round outwards.
const SPARE: usize = 8;

/// A column over rows, and over the rows of the priors behind them.
#[derive(Debug, Clone, Default)]
pub(crate) struct Column {
    /// How many rows there are before those of the priors.
    rows: usize,
    /// Rows in which it may differ from 0; those of the priors, which always belong to it, do not count.
    reach: Reach,
    /// The first row that is held, a whole number of eights.
    from: usize,
    /// The reach with [`SPARE`] rows and a little more on either side, as far as there are rows.
    values: Vec<f64>,
    priors: Vec<f64>,
}

impl Column {
    /// Of all its rows, without priors.
    pub(crate) fn of(rows: &[f64]) -> Self {
        let mut out = Self {
            rows: rows.len(),
            ..Self::default()
        };
        out.hold(support(rows));
        let held = out.from..out.from + out.values.len();
        out.values.copy_from_slice(&rows[held]);
        out
    }

    /// The same with more rows behind, which it does not touch.
    pub(crate) fn with_rows_behind(self, more: usize) -> Self {
        Self {
            rows: self.rows + more,
            ..self
        }
    }

    /// The same with rows of priors behind.
    pub(crate) fn with_priors(self, priors: Vec<f64>) -> Self {
        Self { priors, ..self }
    }

    /// Rows in which it may differ from 0, but for the priors'.
    pub(crate) fn reach(&self) -> &Reach {
        &self.reach
    }

    /// Rows of the priors.
    pub(super) fn priors(&self) -> &[f64] {
        &self.priors
    }

    /// All rows, those of the priors included.
    pub(super) fn len(&self) -> usize {
        self.rows + self.priors.len()
    }

    /// Some rows, not more than [`SPARE`] of which may lie on either side of the reach.
    pub(super) fn part(&self, rows: Range<usize>) -> &[f64] {
        if rows.is_empty() {
            return &[];
        }
        &self.values[rows.start - self.from..rows.end - self.from]
    }

    /// One row, held or not.
    pub(super) fn at(&self, row: usize) -> f64 {
        let held = row.checked_sub(self.from);
        held.and_then(|k| self.values.get(k))
            .copied()
            .unwrap_or(0.0)
    }

    /// Makes room for a reach that holds the one so far.
    fn hold(&mut self, reach: Reach) {
        let (from, to) = if reach.is_empty() {
            (0, 0)
        } else {
            let from = reach.start.saturating_sub(SPARE) / 8 * 8;
            let to = (reach.end + SPARE).next_multiple_of(8).min(self.rows);
            (from, to)
        };
        let old = self.from..self.from + self.values.len();
        if !(from >= old.start && to <= old.end) {
            let mut values = vec![0.0; to - from];
            if !old.is_empty() {
                values[old.start - from..old.end - from].copy_from_slice(&self.values);
            }
            (self.from, self.values) = (from, values);
        }
        self.reach = reach;
    }

    /// Product with a vector over the same rows and priors, the digits those of [`dot`].
    pub(crate) fn dot(&self, vector: &[f64]) -> f64 {
        let held = self.from..self.from + self.values.len();
        self.product(&vector[held], &vector[self.rows..])
    }

    /// Its length.
    pub(super) fn norm(&self) -> f64 {
        self.product(&self.values, &self.priors).sqrt()
    }

    /// Product with the rows that are held, and the priors, of another: each row in the one of eight sums in which
    /// [`dot`] has it.
    fn product(&self, values: &[f64], priors: &[f64]) -> f64 {
        let whole = self.len() / 8 * 8;
        let (mut sums, mut rest) = ([0.0; 8], 0.0);
        let (own, other) = (self.values.chunks_exact(8), values.chunks_exact(8));
        let mut row = self.from + self.values.len() / 8 * 8;
        let behind = (own.remainder().iter()).zip(other.remainder());
        for (x, y) in own.zip(other) {
            for k in 0..8 {
                sums[k] += x[k] * y[k];
            }
        }
        let mut add = |row: usize, product: f64| {
            if row < whole {
                sums[row % 8] += product;
            } else {
                rest += product;
            }
        };
        for (x, y) in behind {
            add(row, x * y);
            row += 1;
        }
        for (k, (x, y)) in self.priors.iter().zip(priors).enumerate() {
            add(self.rows + k, x * y);
        }
        sums.iter().sum::<f64>() + rest
    }

    /// Takes `share` of it away from a vector over the same rows and priors.
    pub(crate) fn take_from(&self, vector: &mut [f64], share: f64) {
        let reach = self.reach.clone();
        take(&mut vector[reach.clone()], share, self.part(reach));
        take(&mut vector[self.rows..], share, &self.priors);
    }

    pub(super) fn divide(&mut self, by: f64) {
        let all = self.values.iter_mut().chain(&mut self.priors);
        all.for_each(|v| *v /= by);
    }

    /// Takes a column of unit length out of this one, whose reach grows by it; returns how much of it was there.
    pub(super) fn rid_of(&mut self, q: &Self) -> f64 {
        let shared = common(&self.reach, &q.reach);
        let r = dot(q.part(shared.clone()), self.part(shared)) + dot(&q.priors, &self.priors);
        if r != 0.0 {
            self.hold(joint(&self.reach, &q.reach));
            let reach = q.reach.clone();
            let rows = if reach.is_empty() {
                0..0
            } else {
                reach.start - self.from..reach.end - self.from
            };
            take(&mut self.values[rows], r, q.part(reach));
            take(&mut self.priors, r, &q.priors);
        }
        r
    }

    /// All rows, and those of the priors.
    #[cfg(test)]
    pub(crate) fn whole(&self) -> Vec<f64> {
        let mut out = vec![0.0; self.rows];
        out[self.from..self.from + self.values.len()].copy_from_slice(&self.values);
        out.extend(&self.priors);
        out
    }
}

/// Takes `share` of one slice away from another.
pub(super) fn take(from: &mut [f64], share: f64, of: &[f64]) {
    from.iter_mut().zip(of).for_each(|(v, q)| *v -= share * q);
}
