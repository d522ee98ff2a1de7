//! Coefficients and statistics out of the triangle.

use crate::LsqError;
use crate::accumulate::MAX_COLUMNS;
use nalgebra::DMatrix;

/// Most the condition number of the column-scaled triangle may be in [`finish`](crate::Accumulator::finish), and in
/// [`fit_robust`](crate::fit_robust) unless its options say otherwise; [`Reduced::solve`] takes any limit.
///
/// Beyond it fewer than about six digits of the coefficients are left of the sixteen of `f64`.
/// It is a numerical limit, of rounding alone; a model whose data have noise should ask for a smaller one, as `dgd-friction` (1e4) and
/// `dgd-pump` (1e5) do.
pub const CONDITION_LIMIT: f64 = 1e10;

/// Values below it have squares that lose digits, or are 0.
const LEAST_ROOT: f64 = 1e-150;

fn overflow(column: &str) -> LsqError {
    LsqError::Overflow {
        column: column.to_owned(),
    }
}

/// Infinite is a limit too: any condition is right then.
pub(crate) fn check_condition_limit(found: f64) -> Result<(), LsqError> {
    if found > 0.0 {
        return Ok(());
    }
    Err(LsqError::Option {
        name: "condition_limit",
        found,
        expected: "above 0",
    })
}

/// A linear least-squares estimate with the statistics of MATLAB's `lsqcov`.
#[derive(Debug, Clone, PartialEq)]
pub struct Fit {
    /// Column names, shape `(p,)`.
    pub names: Vec<String>,
    /// Estimate per column, shape `(p,)`.
    pub coefficients: Vec<f64>,
    /// `sqrt(diag((A'WA)^-1) · mse)`, shape `(p,)`: right if the residuals are independent and of
    /// variance proportional to 1/weight. Rig data at 1 Hz are correlated, so these are too small there.
    pub standard_errors: Vec<f64>,
    /// `(A'WA)^-1 · mse`, shape `(p, p)`, row-major.
    pub covariance: Vec<f64>,
    /// `rss / (n - p)`.
    pub mse: f64,
    /// Weighted residual sum of squares.
    pub rss: f64,
    /// `1 - rss / Σ w (y - ȳ)²`, about the (weighted) mean of y whether or not there is a constant
    /// column. Without a constant column it can be negative (worse than the mean alone). NaN if y is constant.
    pub r2: f64,
    /// Rows of positive weight.
    pub n: u64,
    /// Condition number of the triangle with columns scaled to unit length: the measure of
    /// persistent excitation. 1 is best; free of units.
    pub condition: f64,
}

impl Fit {
    /// The estimate for one row of regressors, shape `(p,)`; NaN for a row of another width.
    pub fn predict(&self, row: &[f64]) -> f64 {
        if row.len() != self.coefficients.len() {
            return f64::NAN;
        }
        self.coefficients.iter().zip(row).map(|(c, x)| c * x).sum()
    }
}

/// A least-squares problem reduced to the triangle R of `[A y]`: `‖A c - y‖² = ‖R [c; -1]‖²`.
///
/// For solvers that need the small problem itself: bounds, fixed coefficients, another basis.
#[derive(Debug, Clone)]
pub struct Reduced {
    pub(crate) names: Vec<String>,
    pub(crate) r: Vec<f64>,
    pub(crate) n: u64,
    pub(crate) total_about_mean: f64,
}

impl Reduced {
    /// The column names, in order.
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// Rows of positive weight.
    pub fn rows(&self) -> u64 {
        self.n
    }

    /// Entry of R, 0 below the diagonal; column p is the observation.
    ///
    /// Returns NaN outside the (p+1)×(p+1) triangle.
    pub fn r(&self, row: usize, column: usize) -> f64 {
        let width = self.width();
        if row >= width || column >= width {
            return f64::NAN;
        }
        if row > column {
            return 0.0;
        }
        self.r[row * width + column]
    }

    /// Root of the (weighted) sum of squares of a column; column p is the observation.
    pub fn column_norm(&self, column: usize) -> f64 {
        (0..=column)
            .map(|row| self.r(row, column).powi(2))
            .sum::<f64>()
            .sqrt()
    }

    /// (Weighted) squares of the observations about their mean: what R² is held against.
    pub fn total_about_mean(&self) -> f64 {
        self.total_about_mean
    }

    /// The same problem with some coefficients held: their columns move to the right-hand side.
    ///
    /// - `held`: pairs of column index and value; indices out of range are ignored.
    ///
    /// R² of the smaller fit is still about the mean of the original observations. Its standard
    /// errors do not count the held coefficients as estimated.
    ///
    /// # Errors
    /// [`LsqError::Held`] on a value that is not finite or a column held twice, [`LsqError::Overflow`] if what is held of the observations
    /// leaves `f64`, [`LsqError::Columns`] if no column is left.
    pub fn hold(&self, held: &[(usize, f64)]) -> Result<Self, LsqError> {
        let p = self.names.len();
        for (place, &(index, value)) in held.iter().enumerate() {
            let twice = held[..place].iter().any(|(other, _)| *other == index);
            if index < p && (twice || !value.is_finite()) {
                return Err(LsqError::Held { index, value });
            }
        }
        let free: Vec<usize> = (0..p)
            .filter(|j| held.iter().all(|(h, _)| h != j))
            .collect();
        if free.is_empty() {
            return Err(LsqError::Columns {
                found: 0,
                limit: MAX_COLUMNS,
            });
        }
        let mut rows = crate::Accumulator::new(free.iter().map(|&j| self.names[j].clone()))?;
        let mut row = vec![0.0; free.len()];
        for i in 0..=p {
            for (x, &j) in row.iter_mut().zip(&free) {
                *x = self.r(i, j);
            }
            let y = self.r(i, p)
                - held
                    .iter()
                    .filter(|(j, _)| *j < p)
                    .map(|&(j, v)| v * self.r(i, j))
                    .sum::<f64>();
            if !y.is_finite() {
                return Err(overflow("y"));
            }
            rows.push(&row, y)?;
        }
        Ok(Self {
            n: self.n,
            total_about_mean: self.total_about_mean,
            ..rows.reduce()
        })
    }

    /// Solves for the coefficients and their statistics.
    ///
    /// - `condition_limit`: most the condition number of the column-scaled triangle may be; infinite for any.
    ///
    /// # Errors
    /// [`LsqError::Option`] on a limit that is not above 0, [`LsqError::TooFewRows`] if n <= p, [`LsqError::NotExcited`] on a zero column
    /// or beyond the limit, [`LsqError::Overflow`] and [`LsqError::Underflow`] on squares beyond `f64`.
    pub fn solve(&self, condition_limit: f64) -> Result<Fit, LsqError> {
        check_condition_limit(condition_limit)?;
        self.check_range()?;
        let p = self.names.len();
        let norms: Vec<f64> = (0..p).map(|j| self.column_norm(j)).collect();
        let degrees = match self.n.checked_sub(p as u64) {
            Some(degrees) if degrees > 0 => degrees,
            _ => {
                return Err(LsqError::TooFewRows {
                    found: self.n,
                    columns: p,
                });
            }
        };
        let condition = self.excitation(&norms, condition_limit)?;
        let inverse = self.inverse_triangle();
        let coefficients = (0..p)
            .map(|i| (i..p).map(|k| inverse[i * p + k] * self.r(k, p)).sum())
            .collect();
        let rss = self.r(p, p).powi(2);
        #[expect(clippy::cast_precision_loss, reason = "row counts stay far below 2^53")]
        let mse = rss / degrees as f64;
        let covariance: Vec<f64> = (0..p * p)
            .map(|at| {
                let (i, j) = (at / p, at % p);
                mse * (i.max(j)..p)
                    .map(|k| inverse[i * p + k] * inverse[j * p + k])
                    .sum::<f64>()
            })
            .collect();
        Ok(Fit {
            standard_errors: (0..p).map(|i| covariance[i * p + i].sqrt()).collect(),
            names: self.names.clone(),
            coefficients,
            covariance,
            mse,
            rss,
            r2: if self.total_about_mean > 0.0 {
                1.0 - rss / self.total_about_mean
            } else {
                f64::NAN
            },
            n: self.n,
            condition,
        })
    }

    fn width(&self) -> usize {
        self.names.len() + 1
    }

    /// Whether the squares of all columns are within `f64`.
    fn check_range(&self) -> Result<(), LsqError> {
        let name = |j: usize| self.names.get(j).map_or("y", String::as_str);
        // First: what underflows in one column may come out as infinite in the next.
        for j in 0..self.width() {
            let largest = (0..=j).fold(0.0, |most: f64, i| most.max(self.r(i, j).abs()));
            if largest > 0.0 && largest < LEAST_ROOT {
                return Err(LsqError::Underflow {
                    column: name(j).to_owned(),
                });
            }
        }
        match (0..self.width()).find(|&j| !self.column_norm(j).is_finite()) {
            Some(j) => Err(overflow(name(j))),
            None => Ok(()),
        }
    }

    /// Condition number of R with unit columns, or the columns that take part in a near-dependence.
    fn excitation(&self, norms: &[f64], limit: f64) -> Result<f64, LsqError> {
        let refuse = |columns: Vec<String>, condition| {
            Err(LsqError::NotExcited {
                columns,
                condition,
                limit,
            })
        };
        let dead: Vec<String> = self
            .names
            .iter()
            .zip(norms)
            .filter(|(_, norm)| **norm == 0.0)
            .map(|(name, _)| name.clone())
            .collect();
        if !dead.is_empty() {
            return refuse(dead, f64::INFINITY);
        }
        let p = norms.len();
        let scaled = DMatrix::from_fn(p, p, |i, j| self.r(i, j) / norms[j]);
        let svd = scaled.svd(false, true);
        let largest = svd.singular_values.max();
        let smallest = svd.singular_values.min();
        let condition = largest / smallest;
        if condition.is_finite() && condition <= limit {
            return Ok(condition);
        }
        // A right singular vector of a small singular value spells the dependence out:
        // the columns it weighs heavily cannot be told apart.
        let mut involved = vec![false; p];
        if let Some(v_t) = svd.v_t {
            for (k, s) in svd.singular_values.iter().enumerate() {
                if largest > limit * s {
                    let peak = v_t.row(k).amax();
                    for (flag, v) in involved.iter_mut().zip(v_t.row(k).iter()) {
                        *flag |= v.abs() > 0.1 * peak;
                    }
                }
            }
        }
        let columns = self
            .names
            .iter()
            .zip(involved)
            .filter(|(_, flag)| *flag)
            .map(|(name, _)| name.clone())
            .collect();
        refuse(columns, condition)
    }

    /// Inverse of the p×p triangle, row-major, by back-substitution. The diagonal is not zero here:
    /// the condition number is finite.
    fn inverse_triangle(&self) -> Vec<f64> {
        let p = self.names.len();
        let mut inverse = vec![0.0; p * p];
        for j in 0..p {
            inverse[j * p + j] = 1.0 / self.r(j, j);
            for i in (0..j).rev() {
                let sum: f64 = (i + 1..=j).map(|k| self.r(i, k) * inverse[k * p + j]).sum();
                inverse[i * p + j] = -sum / self.r(i, i);
            }
        }
        inverse
    }
}
