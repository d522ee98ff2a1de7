//! The triangle that a stream of rows is reduced to.

use crate::{CONDITION_LIMIT, Fit, LsqError, Reduced};

/// Most columns a fit may have; bounds the memory of an [`Accumulator`].
pub const MAX_COLUMNS: usize = 256;

/// Rows gathered before they are folded into the triangle: four columns of them fit the first
/// cache, and the fixed cost of a fold is spread thin.
const BLOCK: usize = 256;

/// Rows of a least-squares problem, reduced as they come.
///
/// Holds the upper-triangular factor R of `[A y]` (QR by Householder reflections) and a block of
/// at most 256 rows, hence O(p²) memory for p columns however many rows are pushed. The result
/// depends on the order of the rows only by rounding, and is the same bytes for the same order.
#[derive(Debug, Clone)]
pub struct Accumulator {
    names: Vec<String>,
    /// R of `[A y]`, (p+1)×(p+1), row-major, upper triangle.
    r: Vec<f64>,
    /// Pending rows, one column of `BLOCK` after the other, already times the root of the weight.
    block: Vec<f64>,
    root_weights: Vec<f64>,
    pending: usize,
    /// Rows pushed, those of weight 0 included: only for messages.
    seen: u64,
    n: u64,
    spread: Spread,
}

impl Accumulator {
    /// An empty problem with one named column per coefficient.
    ///
    /// # Errors
    /// [`LsqError::Columns`] on no column or more than [`MAX_COLUMNS`].
    pub fn new<S: Into<String>>(names: impl IntoIterator<Item = S>) -> Result<Self, LsqError> {
        // One more than allowed is enough to know.
        let names: Vec<String> = names
            .into_iter()
            .take(MAX_COLUMNS + 1)
            .map(Into::into)
            .collect();
        if names.is_empty() || names.len() > MAX_COLUMNS {
            return Err(LsqError::Columns {
                found: names.len(),
                limit: MAX_COLUMNS,
            });
        }
        let width = names.len() + 1;
        Ok(Self {
            names,
            r: vec![0.0; width * width],
            block: vec![0.0; width * BLOCK],
            root_weights: vec![1.0; BLOCK],
            pending: 0,
            seen: 0,
            n: 0,
            spread: Spread::default(),
        })
    }

    /// The column names, in order.
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// Rows of positive weight so far.
    pub fn rows(&self) -> u64 {
        self.n
    }

    /// Adds the row `y = row · c + residual`.
    ///
    /// - `row`: shape `(p,)`, in the order of the names.
    ///
    /// # Errors
    /// [`LsqError::Width`], [`LsqError::NonFinite`]; the refused row is not counted as a row.
    #[inline]
    pub fn push(&mut self, row: &[f64], y: f64) -> Result<(), LsqError> {
        self.check(row, y)?;
        self.put(row, y, 1.0);
        Ok(())
    }

    /// Adds a row whose squared residual counts `weight` times (`lsqcov`'s weights: the inverse
    /// of the row's variance, up to a common factor).
    ///
    /// A row of weight 0 is checked and then dropped: it is not among the `n` of the fit.
    ///
    /// # Errors
    /// Those of [`push`](Self::push), and [`LsqError::Weight`].
    pub fn push_weighted(&mut self, row: &[f64], y: f64, weight: f64) -> Result<(), LsqError> {
        self.check(row, y)?;
        if !(weight.is_finite() && weight >= 0.0) {
            return Err(LsqError::Weight {
                index: self.seen,
                weight,
            });
        }
        if weight == 0.0 {
            self.seen += 1;
        } else {
            self.put(row, y, weight.sqrt());
        }
        Ok(())
    }

    /// Adds many rows given by columns: the same rows as one [`push`](Self::push) each, faster.
    ///
    /// - `columns`: one slice per name, each of shape `(m,)`; `y`: shape `(m,)`.
    ///
    /// # Errors
    /// [`LsqError::Width`] if there are not p columns, [`LsqError::Length`] if one is not of the length of
    /// `y`, [`LsqError::NonFinite`] on the first bad row; then no row is added.
    pub fn push_columns(&mut self, columns: &[&[f64]], y: &[f64]) -> Result<(), LsqError> {
        if columns.len() != self.names.len() {
            return Err(LsqError::Width {
                index: self.seen,
                found: columns.len(),
                expected: self.names.len(),
            });
        }
        if let Some(j) = columns.iter().position(|c| c.len() != y.len()) {
            return Err(LsqError::Length {
                column: self.names[j].clone(),
                found: columns[j].len(),
                expected: y.len(),
            });
        }
        if !columns.iter().all(|c| all_finite(c)) || !all_finite(y) {
            return Err(self.refusal_of_columns(columns, y));
        }
        let mut from = 0;
        while from < y.len() {
            let rows = (BLOCK - self.pending).min(y.len() - from);
            let sources = columns.iter().copied().chain([y]);
            for (column, source) in self.block.chunks_exact_mut(BLOCK).zip(sources) {
                column[self.pending..][..rows].copy_from_slice(&source[from..from + rows]);
            }
            self.root_weights[self.pending..][..rows].fill(1.0);
            self.pending += rows;
            self.seen += rows as u64;
            self.n += rows as u64;
            if self.pending == BLOCK {
                self.fold();
            }
            from += rows;
        }
        Ok(())
    }

    /// Adds all rows of `other`, as if they had been pushed here.
    ///
    /// # Errors
    /// [`LsqError::Names`] if the columns are not the same in the same order.
    pub fn merge(&mut self, mut other: Self) -> Result<(), LsqError> {
        if self.names != other.names {
            return Err(LsqError::Names {
                found: other.names,
                expected: self.names.clone(),
            });
        }
        self.fold();
        other.fold();
        let width = self.names.len() + 1;
        // The other triangle is p+1 rows with the same Gram matrix as all its rows.
        for first in (0..width).step_by(BLOCK) {
            let rows = BLOCK.min(width - first);
            for column in 0..width {
                for row in 0..rows {
                    self.block[column * BLOCK + row] = other.r[(first + row) * width + column];
                }
            }
            reduce(&mut self.r, &mut self.block, width, rows);
        }
        self.spread.join(&other.spread);
        self.seen += other.seen;
        self.n += other.n;
        Ok(())
    }

    /// The triangle on its own, for callers that fit parts of it (see [`Reduced`]).
    pub fn reduce(mut self) -> Reduced {
        self.fold();
        Reduced {
            names: self.names,
            r: self.r,
            n: self.n,
            total_about_mean: self.spread.about_mean(),
        }
    }

    /// Solves with [`CONDITION_LIMIT`] as the limit on the condition number.
    ///
    /// # Errors
    /// Those of [`Reduced::solve`].
    pub fn finish(self) -> Result<Fit, LsqError> {
        self.reduce().solve(CONDITION_LIMIT)
    }

    #[inline]
    fn check(&self, row: &[f64], y: f64) -> Result<(), LsqError> {
        if row.len() == self.names.len() && y.is_finite() && row.iter().all(|x| x.is_finite()) {
            return Ok(());
        }
        Err(self.refusal(row))
    }

    #[cold]
    fn refusal(&self, row: &[f64]) -> LsqError {
        if row.len() != self.names.len() {
            return LsqError::Width {
                index: self.seen,
                found: row.len(),
                expected: self.names.len(),
            };
        }
        let column = row.iter().position(|x| !x.is_finite());
        LsqError::NonFinite {
            index: self.seen,
            column: column.map_or_else(|| "y".to_owned(), |j| self.names[j].clone()),
        }
    }

    #[cold]
    fn refusal_of_columns(&self, columns: &[&[f64]], y: &[f64]) -> LsqError {
        let bad = |i: &usize| columns.iter().any(|c| !c[*i].is_finite()) || !y[*i].is_finite();
        let row = (0..y.len()).find(bad).unwrap_or(0);
        let column = columns.iter().position(|c| !c[row].is_finite());
        LsqError::NonFinite {
            index: self.seen + row as u64,
            column: column.map_or_else(|| "y".to_owned(), |j| self.names[j].clone()),
        }
    }

    #[inline]
    fn put(&mut self, row: &[f64], y: f64, root_weight: f64) {
        let at = self.pending;
        for (column, x) in self.block.chunks_exact_mut(BLOCK).zip(row) {
            column[at] = x * root_weight;
        }
        self.block[row.len() * BLOCK + at] = y * root_weight;
        self.root_weights[at] = root_weight;
        self.pending += 1;
        self.seen += 1;
        self.n += 1;
        if self.pending == BLOCK {
            self.fold();
        }
    }

    fn fold(&mut self) {
        let rows = std::mem::take(&mut self.pending);
        if rows == 0 {
            return;
        }
        let width = self.names.len() + 1;
        let y = &self.block[(width - 1) * BLOCK..][..rows];
        self.spread.join(&Spread::of(y, &self.root_weights[..rows]));
        reduce(&mut self.r, &mut self.block, width, rows);
    }
}

/// Folds `rows` rows of `block` into the triangle `r` by Householder reflections.
///
/// The top of every reflected vector is one entry of R, because R is already triangular.
fn reduce(r: &mut [f64], block: &mut [f64], width: usize, rows: usize) {
    for j in 0..width {
        let (head, tail) = block.split_at_mut((j + 1) * BLOCK);
        let pivot = &head[j * BLOCK..][..rows];
        let below = dot(pivot, pivot);
        if below == 0.0 {
            continue;
        }
        let top = r[j * width + j];
        let norm = (top * top + below).sqrt();
        let reflected = if top > 0.0 { -norm } else { norm };
        let v0 = top - reflected;
        // 2 / (v'v), with v = (v0, pivot).
        let tau = 2.0 / (v0 * v0 + below);
        r[j * width + j] = reflected;
        for (k, other) in (j + 1..width).zip(tail.chunks_exact_mut(BLOCK)) {
            let other = &mut other[..rows];
            let top = &mut r[j * width + k];
            let step = tau * (v0 * *top + dot(pivot, other));
            *top -= step * v0;
            for (o, v) in other.iter_mut().zip(pivot) {
                *o -= step * v;
            }
        }
    }
}

/// No early exit: one that the compiler can vectorise is faster on the usual, clean columns.
fn all_finite(values: &[f64]) -> bool {
    values.iter().fold(true, |all, x| all & x.is_finite())
}

/// Sum of the products of two slices, as far as the shorter one goes.
///
/// In eight partial sums: the compiler may not reorder a sum, so the order is spelled out.
#[doc(hidden)] // For the crates beside this one.
#[must_use]
pub fn dot(a: &[f64], b: &[f64]) -> f64 {
    let n = a.len().min(b.len());
    let (a, b) = (&a[..n], &b[..n]);
    let mut sums = [0.0; 8];
    let (a8, b8) = (a.chunks_exact(8), b.chunks_exact(8));
    let rest: f64 = a8
        .remainder()
        .iter()
        .zip(b8.remainder())
        .map(|(x, y)| x * y)
        .sum();
    for (x, y) in a8.zip(b8) {
        for i in 0..8 {
            sums[i] += x[i] * y[i];
        }
    }
    rest + sums.iter().sum::<f64>()
}

/// Weighted mean of the observations and squares about it, joined as by Chan et al. (1983).
#[derive(Debug, Clone, Default)]
struct Spread {
    weight: f64,
    mean: f64,
    m2: f64,
}

impl Spread {
    /// Of a block whose observations are already times the root of their weight.
    fn of(y_weighted: &[f64], root_weights: &[f64]) -> Self {
        let weight = dot(root_weights, root_weights);
        let mean = dot(root_weights, y_weighted) / weight;
        let m2 = y_weighted
            .iter()
            .zip(root_weights)
            .map(|(y, s)| (y - s * mean).powi(2))
            .sum();
        Self { weight, mean, m2 }
    }

    /// Squares about the mean, 0 where they are what rounding leaves of observations that are all the same.
    fn about_mean(&self) -> f64 {
        let rounding = self.weight * (8.0 * f64::EPSILON * self.mean).powi(2);
        if self.m2 > rounding { self.m2 } else { 0.0 }
    }

    fn join(&mut self, other: &Self) {
        let weight = self.weight + other.weight;
        if other.weight == 0.0 || weight == 0.0 {
            return;
        }
        let step = other.mean - self.mean;
        self.m2 += other.m2 + step * step * self.weight * (other.weight / weight);
        self.mean += step * (other.weight / weight);
        self.weight = weight;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_triangle_keeps_the_gram_matrix() {
        let mut rows = Accumulator::new(["a", "b"]).expect("two columns");
        let mut gram = [0.0; 9];
        for i in 0..1000_u32 {
            let x = [f64::from(i % 7) - 2.0, f64::from(i % 11), f64::from(i % 5)];
            rows.push(&x[..2], x[2]).expect("finite");
            for (g, (a, b)) in gram.iter_mut().zip((0..9).map(|k| (x[k / 3], x[k % 3]))) {
                *g += a * b;
            }
        }
        rows.fold();
        for (i, j) in [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)] {
            let found: f64 = (0..3).map(|k| rows.r[k * 3 + i] * rows.r[k * 3 + j]).sum();
            assert!((found - gram[i * 3 + j]).abs() < 1e-11 * gram[i * 3 + j].abs());
        }
    }
}
