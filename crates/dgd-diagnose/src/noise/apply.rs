//! Whitening a stacked vector, and its transpose.

use super::{Whitening, alone};
use crate::layout::Section;
use std::ops::Range;

/// A wander that has decayed to this adds no digit to anything.
pub(super) const FADED: f64 = 1e-40;

impl Whitening {
    /// Whitens a stacked vector; rows that may not be used become 0, and so do those that only a wander reaches which
    /// has faded.
    pub(crate) fn apply(&self, stacked: &[f64]) -> Vec<f64> {
        self.whitened(stacked, FADED)
    }

    /// The same with the wander followed to the end: the order of columns depends on where each of them ends.
    pub(crate) fn apply_whole(&self, stacked: &[f64]) -> Vec<f64> {
        self.whitened(stacked, 0.0)
    }

    fn whitened(&self, stacked: &[f64], faded: f64) -> Vec<f64> {
        let n = self.layout.blocks;
        let mut out = vec![0.0; self.layout.len()];
        let sections = self.layout.sections();
        // Most columns and effects live in one relation, and many begin late: what is 0 stays 0.
        let ends = |rows: Range<usize>| {
            let here = |k: &usize| self.valid[*k] && stacked[*k] != 0.0;
            let start = rows.start;
            let from = rows.clone().find(here)? - start;
            Some((from, rows.rev().find(here)? - start))
        };
        let mut live = sections.clone().map(ends);
        // The head row holds the friction row's noise.
        live[1] = match (live[0], live[1]) {
            (Some(a), Some(b)) => Some((a.0.min(b.0), a.1.max(b.1))),
            (a, b) => a.or(b),
        };
        for (section, (rows, live)) in Section::ALL.into_iter().zip(sections.into_iter().zip(live))
        {
            let Some((first, last)) = live else {
                continue;
            };
            let values = &stacked[rows.clone()];
            if section == Section::Head {
                let own: Vec<f64> = (first.saturating_sub(2)..n.min(last + 3))
                    .map(|b| {
                        if self.is_coupled(b) {
                            values[b] - self.coupling * stacked[b]
                        } else {
                            values[b]
                        }
                    })
                    .collect();
                self.filtered(
                    (section, faded),
                    &own,
                    first.saturating_sub(2),
                    (first, last),
                    &mut out[rows],
                );
            } else {
                self.filtered((section, faded), values, 0, (first, last), &mut out[rows]);
            }
        }
        out
    }

    /// Whitens one section from its row `first` on, nothing but zeros standing before it and after `last`.
    /// `values` are its rows from `from` on; a wander below `faded` is none.
    fn filtered(
        &self,
        (section, faded): (Section, f64),
        values: &[f64],
        from: usize,
        (first, last): (usize, usize),
        out: &mut [f64],
    ) {
        let rows = self.layout.rows(section);
        let [a, b] = self.memory[section as usize];
        let alone = alone([a, b]);
        let mut wander = [0.0_f64; 2];
        for i in first..rows.len() {
            let row = rows.start + i;
            if self.scale[row] <= 0.0 {
                continue;
            }
            // Two rows on, nothing is left of the last value but the wander that it moved.
            let value = if i > last + 2 {
                if wander.iter().all(|w| w.abs() < faded) {
                    break;
                }
                0.0
            } else {
                let at = i - from;
                let left = match self.predecessors[row] {
                    0 => values[at],
                    1 => values[at] - alone * values[at - 1],
                    _ => values[at] - a * values[at - 1] - b * values[at - 2],
                };
                left * self.start[row]
            };
            let (decay, gain) = (self.decay[row], self.gain[row]);
            wander = [wander[0] * decay[0], wander[1] * decay[1]];
            let innovation = value - self.passes[row] * (wander[0] + wander[1]);
            if !innovation.is_finite() {
                continue;
            }
            wander = [
                wander[0] + gain[0] * innovation,
                wander[1] + gain[1] * innovation,
            ];
            out[i] = innovation * self.scale[row];
        }
    }

    /// The transpose of [`Self::apply`]: what each raw row adds to the product with a whitened vector.
    ///
    /// With it the score of an effect that switches on at any block is one running sum.
    pub(crate) fn transpose(&self, white: &[f64]) -> Vec<f64> {
        let mut grad = vec![0.0; self.layout.len()];
        for rows in self.layout.sections() {
            let mut wander = [0.0; 2];
            for row in rows.rev() {
                if self.scale[row] <= 0.0 {
                    continue;
                }
                let (decay, gain) = (self.decay[row], self.gain[row]);
                let innovation =
                    white[row] * self.scale[row] + wander[0] * gain[0] + wander[1] * gain[1];
                grad[row] = innovation;
                let back = self.passes[row] * innovation;
                wander = [decay[0] * (wander[0] - back), decay[1] * (wander[1] - back)];
            }
        }
        let mut out = vec![0.0; self.layout.len()];
        for section in Section::ALL {
            let rows = self.layout.rows(section);
            let from = rows.start;
            for (i, row) in rows.enumerate() {
                if !self.valid[row] {
                    continue;
                }
                let g = grad[row] * self.start[row];
                let mut send = |j: usize, weight: f64| {
                    out[from + j] += weight * g;
                    if section == Section::Head && self.is_coupled(j) {
                        out[j] -= self.coupling * weight * g;
                    }
                };
                send(i, 1.0);
                for (back, weight) in self.memory_of(section, i) {
                    send(i - back, -weight);
                }
            }
        }
        out
    }
}
