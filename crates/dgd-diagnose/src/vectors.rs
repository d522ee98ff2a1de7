//! Small dense linear algebra over long columns.

mod column;

use crate::cores::idle;
pub(crate) use column::Column;
use column::take;
use dgd_lsq::dot;
use rayon::prelude::*;
use std::ops::Range;

/// Rows that a vector may differ from 0 in.
pub(crate) type Reach = std::ops::Range<usize>;

/// Where a column holds anything but zeros: from the first to after the last.
pub(crate) fn support(column: &[f64]) -> Reach {
    let first = column.iter().position(|v| *v != 0.0);
    let last = column.iter().rposition(|v| *v != 0.0);
    match (first, last) {
        (Some(first), Some(last)) => first..last + 1,
        _ => 0..0,
    }
}

/// The rows of a reach, rounded out to eights from row `origin` on, within `origin..end`.
fn eights(reach: &Reach, origin: usize, end: usize) -> Range<usize> {
    let from = reach.start.clamp(origin, end) - origin;
    let to = reach.end.clamp(origin, end) - origin;
    let from = from - from % 8;
    let to = to.next_multiple_of(8).min((end - origin) / 8 * 8).max(from);
    origin + from..origin + to
}

fn add_products(sums: &mut [f64; 8], a: &[f64], b: &[f64]) {
    for (x, y) in a.chunks_exact(8).zip(b.chunks_exact(8)) {
        for k in 0..8 {
            sums[k] += x[k] * y[k];
        }
    }
}

/// Product of two vectors of one length of which each is 0 outside its reach, the digits those of [`dot`] of the whole of them.
pub(crate) fn product_within(a: (&[f64], &Reach), b: (&[f64], &Reach)) -> f64 {
    let n = a.0.len();
    let whole = n / 8 * 8;
    let rows = eights(&common(a.1, b.1), 0, n);
    let mut sums = [0.0; 8];
    add_products(&mut sums, &a.0[rows.clone()], &b.0[rows]);
    dot(&a.0[whole..], &b.0[whole..]) + sums.iter().sum::<f64>()
}

/// A column that is 0 but for one stretch of rows in each of some sections; only these take memory.
#[derive(Debug)]
pub(crate) struct Sparse {
    rows: usize,
    stretches: Vec<(usize, Vec<f64>)>,
}

impl Sparse {
    /// Of a column, by sections of its rows.
    pub(crate) fn of(column: &[f64], sections: &[Range<usize>]) -> Self {
        let stretch = |section: &Range<usize>| {
            let rows = support(&column[section.clone()]);
            let (from, to) = (section.start + rows.start, section.start + rows.end);
            (from < to).then(|| (from, column[from..to].to_vec()))
        };
        Self {
            rows: column.len(),
            stretches: sections.iter().filter_map(stretch).collect(),
        }
    }

    /// The whole column.
    pub(crate) fn whole(&self) -> Vec<f64> {
        let mut out = vec![0.0; self.rows];
        for (from, values) in &self.stretches {
            out[*from..from + values.len()].copy_from_slice(values);
        }
        out
    }

    /// Takes `share` of the column away from a vector of its length.
    pub(crate) fn take_from(&self, vector: &mut [f64], share: f64) {
        for (from, values) in &self.stretches {
            let rows = vector[*from..].iter_mut().zip(values);
            rows.for_each(|(v, c)| *v -= share * c);
        }
    }
}

/// Rows that are gone through together: with a few columns they fit a core's nearest cache.
const PIECE: usize = 1024;

/// Products of each column with rows `touched` of a vector, the digits those of [`dot`] of these slices.
///
/// Piece by piece, so that the vector is read from afar once and not once a column. No row of a prior may be touched.
pub(crate) fn products(columns: &[Column], vector: &[f64], touched: &Range<usize>) -> Vec<f64> {
    let (from, to) = (touched.start, touched.end);
    let whole = from + (to - from) / 8 * 8;
    let within = columns.iter().map(|q| eights(q.reach(), from, to));
    let within: Vec<Range<usize>> = within.collect();
    let mut sums = vec![[0.0; 8]; columns.len()];
    for start in (from..whole).step_by(PIECE) {
        let end = (start + PIECE).min(whole);
        for ((q, rows), sums) in columns.iter().zip(&within).zip(&mut sums) {
            let (start, end) = (start.max(rows.start), end.min(rows.end));
            if start < end {
                add_products(sums, q.part(start..end), &vector[start..end]);
            }
        }
    }
    (columns.iter().zip(sums))
        .map(|(q, sums)| {
            let rest: f64 = (whole..to).map(|row| q.at(row) * vector[row]).sum();
            sums.iter().sum::<f64>() + rest
        })
        .collect()
}

/// Takes shares of columns away from a vector over their rows and priors, in their order, piece by piece.
pub(crate) fn without(vector: &mut [f64], columns: &[Column], shares: &[f64]) {
    let n = vector.len();
    for start in (0..n).step_by(PIECE) {
        let end = (start + PIECE).min(n);
        for (q, share) in columns.iter().zip(shares) {
            if *share == 0.0 {
                continue;
            }
            let rows = n - q.priors().len();
            let (from, to) = (q.reach().start.max(start), q.reach().end.min(end));
            if from < to {
                take(&mut vector[from..to], *share, q.part(from..to));
            }
            let (from, to) = (rows.max(start), end);
            if from < to {
                take(
                    &mut vector[from..to],
                    *share,
                    &q.priors()[from - rows..to - rows],
                );
            }
        }
    }
}

/// Entries of columns from which on all cores are worth their while.
pub(crate) const MANY: usize = 1 << 19;

/// Share of its length that must be left of a column, or it is rid of the others once more.
const SHORTER: f64 = 1e-2;

/// Makes columns over the same rows and priors orthonormal in place (modified Gram-Schmidt); returns the upper triangle by
/// columns: how the columns were made of these.
///
/// A column of which little is left is rid of the others once more: rounding of what was taken away is as large a part of it as
/// it has become shorter (Parlett 1998, section 6.9).
///
/// Only the rows that two columns share cost anything, so that columns that touch little belong first. A column is taken
/// out of all later ones as soon as it is known, which changes no digit and lets the later ones go on side by side.
pub(crate) fn orthonormal(columns: &mut [Column]) -> Vec<Vec<f64>> {
    let p = columns.len();
    let mut triangle = vec![vec![0.0; p]; p];
    let before: Vec<f64> = columns.iter().map(Column::norm).collect();
    let many = idle() && columns.iter().map(Column::len).sum::<usize>() >= MANY;
    for a in 0..p {
        let (done, rest) = columns.split_at_mut(a);
        let Some((column, later)) = rest.split_first_mut() else {
            break;
        };
        if column.norm() < SHORTER * before[a] {
            for (b, q) in done.iter().enumerate() {
                triangle[a][b] += column.rid_of(q);
            }
        }
        let norm = column.norm();
        triangle[a][a] = norm;
        if norm > 0.0 {
            column.divide(norm);
        }
        let column: &Column = column;
        let take = |(c, row): (&mut Column, &mut Vec<f64>)| row[a] += c.rid_of(column);
        let triangle = &mut triangle[a + 1..];
        if many {
            later.par_iter_mut().zip(triangle).for_each(take);
        } else {
            later.iter_mut().zip(triangle).for_each(take);
        }
    }
    triangle
}

/// Rows that two reaches share.
fn common(a: &Reach, b: &Reach) -> Reach {
    let from = a.start.max(b.start);
    from..a.end.min(b.end).max(from)
}

/// Rows from the first to the last of two reaches.
fn joint(a: &Reach, b: &Reach) -> Reach {
    match (a.is_empty(), b.is_empty()) {
        (true, _) => b.clone(),
        (_, true) => a.clone(),
        _ => a.start.min(b.start)..a.end.max(b.end),
    }
}

/// Solves the triangle that [`orthonormal`] returns; a column that spans nothing gets 0.
pub(crate) fn back_substitute(triangle: &[Vec<f64>], mut right: Vec<f64>) -> Vec<f64> {
    for a in (0..right.len()).rev() {
        let pivot = triangle[a][a];
        right[a] = if pivot > 0.0 { right[a] / pivot } else { 0.0 };
        for b in 0..a {
            right[b] -= triangle[a][b] * right[a];
        }
    }
    right
}

/// The so many neighbours whose sum is largest, and that sum; none, and 0, if all are negative.
pub(crate) fn most_within(values: &[f64], reach: usize) -> (Range<usize>, f64) {
    let mut most = (0..0, 0.0);
    let mut sum = 0.0;
    for (i, v) in values.iter().enumerate() {
        sum += v;
        if let Some(gone) = i.checked_sub(reach) {
            sum -= values[gone];
        }
        if sum > most.1 {
            most = ((i + 1).saturating_sub(reach)..i + 1, sum);
        }
    }
    most
}

#[cfg(test)]
mod tests;
