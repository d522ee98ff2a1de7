//! Levenberg-Marquardt within a box, over a choice of rows.
//!
//! Nocedal, J. and Wright, S. J., *Numerical Optimization* (2006), 10.3; variables at a bound whose gradient points
//! outwards are held (Bertsekas 1982). Between fresh Jacobians Broyden's update serves where one costs a simulation for each
//! parameter.

mod search;
mod step;
#[cfg(test)]
mod tests;

use crate::LsqError;
use nalgebra::DMatrix;
use search::Search;

/// The box that the parameters are sought in; that of no parameter by default.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Bounds {
    low: Vec<f64>,
    high: Vec<f64>,
}

impl Bounds {
    /// From the least and the greatest values, shape `(p,)` each, in the units of the parameters. Where the two are equal the parameter
    /// is held.
    ///
    /// Steps are taken in shares of the box, and slopes by differences over at least 2e-7 of it, so none may be infinite, and none should be
    /// further out than a few thousand times what the parameter may be: beyond a million times, differences may span more than the
    /// parameter itself, and the search find nothing.
    ///
    /// # Errors
    /// [`LsqError::BoundCount`] if the two differ in length; [`LsqError::Bound`] with the first parameter whose bounds are not finite, not
    /// finitely apart or not in order.
    ///
    /// ```
    /// use dgd_lsq::{LsqError, lm::Bounds};
    /// assert_eq!(Bounds::new(vec![0.0], vec![2.0])?.span(0), 2.0);
    /// assert!(Bounds::new(vec![0.0], vec![f64::INFINITY]).is_err());
    /// # Ok::<(), LsqError>(())
    /// ```
    pub fn new(low: Vec<f64>, high: Vec<f64>) -> Result<Self, LsqError> {
        if low.len() != high.len() {
            return Err(LsqError::BoundCount {
                low: low.len(),
                high: high.len(),
            });
        }
        for (index, (&low, &high)) in low.iter().zip(&high).enumerate() {
            // Negated, so that a NaN is refused too.
            if !(low <= high && (high - low).is_finite()) {
                return Err(LsqError::Bound { index, low, high });
            }
        }
        Ok(Self { low, high })
    }

    /// Whether a value of parameter `index` lies at an end of the box, to a millionth of its span.
    ///
    /// # Panics
    /// On a parameter that there is not.
    #[must_use]
    pub fn touches(&self, index: usize, value: f64) -> bool {
        let near = 1e-6 * self.span(index);
        value - self.low[index] <= near || self.high[index] - value <= near
    }

    /// From 0 to 1 for each of `p` parameters.
    #[must_use]
    pub fn unit(p: usize) -> Self {
        Self {
            low: vec![0.0; p],
            high: vec![1.0; p],
        }
    }

    /// Least values, shape `(p,)`.
    #[must_use]
    pub fn low(&self) -> &[f64] {
        &self.low
    }

    /// Greatest values, shape `(p,)`.
    #[must_use]
    pub fn high(&self) -> &[f64] {
        &self.high
    }

    /// Width of the box along parameter `i`; never 0.
    ///
    /// # Panics
    /// On a parameter that there is not.
    #[must_use]
    pub fn span(&self, i: usize) -> f64 {
        (self.high[i] - self.low[i]).max(1e-300)
    }

    /// Puts `theta`, shape `(p,)`, inside; a NaN stays one.
    ///
    /// # Panics
    /// On more values than parameters.
    pub fn clamp(&self, theta: &mut [f64]) {
        for (i, t) in theta.iter_mut().enumerate() {
            *t = t.clamp(self.low[i], self.high[i]);
        }
    }
}

/// What is minimised: half the sum of squares of the residuals. Closures of `theta` are such.
pub trait Residuals {
    /// Residuals at `theta`, shape `(n,)`; `None` if there are none. Those of another length than at the start count as none.
    fn at(&mut self, theta: &[f64]) -> Option<Vec<f64>>;

    /// `∂residual/∂parameter` by parameters scaled to 0..1 of their bounds, shape `(n, p)`, where the residuals are `r`;
    /// `None` if there is none. By forward [`differences`] unless written otherwise.
    ///
    /// ```
    /// use dgd_lsq::lm::{Bounds, Effort, Residuals, minimise};
    /// use dgd_lsq::nalgebra::DMatrix;
    /// struct Line;
    /// impl Residuals for Line {
    ///     fn at(&mut self, t: &[f64]) -> Option<Vec<f64>> {
    ///         Some(vec![2.0 * t[0] - 3.0])
    ///     }
    ///     fn jacobian(&mut self, _: &[f64], _: &[f64], bounds: &Bounds) -> Option<DMatrix<f64>> {
    ///         Some(DMatrix::from_element(1, 1, 2.0 * bounds.span(0)))
    ///     }
    /// }
    /// let bounds = Bounds::new(vec![0.0], vec![5.0])?;
    /// let found = minimise(&mut Line, &[0.0], &bounds, None, None, Effort::default());
    /// assert!((found.theta[0] - 1.5).abs() < 1e-9);
    /// # Ok::<(), dgd_lsq::LsqError>(())
    /// ```
    fn jacobian(&mut self, theta: &[f64], r: &[f64], bounds: &Bounds) -> Option<DMatrix<f64>> {
        Some(differences(self, theta, r, bounds))
    }

    /// Weights of the squares, for a robust loss, shape `(n,)`; all 1 if absent.
    fn weights(&self, r: &[f64]) -> Option<Vec<f64>> {
        let _ = r;
        None
    }
}

impl<F: FnMut(&[f64]) -> Option<Vec<f64>> + ?Sized> Residuals for F {
    fn at(&mut self, theta: &[f64]) -> Option<Vec<f64>> {
        self(theta)
    }
}

/// Where a minimisation ended.
#[derive(Debug, Clone, PartialEq)]
pub struct Minimum {
    /// Parameters, shape `(p,)`.
    pub theta: Vec<f64>,
    /// All rows, kept or not; empty if the start could not be run.
    pub residuals: Vec<f64>,
    /// Half the weighted sum of squares of the kept rows; not finite if the start could not be run.
    pub cost: f64,
    /// By parameters scaled to 0..1 of their bounds, at or near `theta`; all rows.
    pub jacobian: DMatrix<f64>,
    /// Steps tried.
    pub steps: usize,
    /// How it ended.
    pub ending: Ending,
}

/// How a minimisation ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Ending {
    /// At a minimum, to the tolerance; or, after a gain, as near to one as the residuals can tell.
    Converged,
    /// [`Effort::steps`] were used up.
    StepLimit,
    /// No step lowered the cost, though the Jacobian promises more than the tolerance: the residuals have a kink, or their Jacobian is wrong.
    /// Or there was no Jacobian, or none of numbers, or the bounds are too wide for one by differences.
    NoProgress,
    /// The start has a NaN, or another length than the bounds; or there are no residuals there, or a kept one is not a number or its square
    /// beyond `f64`.
    NoStart,
}

/// How far to go.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Effort {
    /// Steps tried.
    pub steps: usize,
    /// Relative gain of the cost below which it stops, twice in a row.
    pub tolerance: f64,
    /// Jacobians, the first included if it is not known.
    pub fresh: usize,
    /// Steps that may be taken on one Jacobian, updated, before there is a fresh one; more are where no more is left.
    pub stale: usize,
    /// Refusals in a row, each with eight times the damping, before it gives up.
    pub patience: usize,
}

impl Default for Effort {
    /// A fresh Jacobian at each step, to the end.
    fn default() -> Self {
        Self {
            steps: 100,
            tolerance: 1e-9,
            fresh: usize::MAX,
            stale: 0,
            patience: 14,
        }
    }
}

/// Jacobian by forward differences in scaled parameters, a ten-thousandth of the value (of a 500th of the bounds at least); to the
/// other side where that leaves the bounds or has no residuals, or another number of them. A parameter that cannot be moved gets zeros. Nothing outside the bounds is asked for.
///
/// # Panics
/// On bounds that are fewer than the parameters.
pub fn differences<R: Residuals + ?Sized>(
    problem: &mut R,
    theta: &[f64],
    r: &[f64],
    bounds: &Bounds,
) -> DMatrix<f64> {
    let mut out = DMatrix::zeros(r.len(), theta.len());
    let mut moved = theta.to_vec();
    for j in 0..theta.len() {
        let span = bounds.span(j);
        // Small beside the value where that is small beside its bounds.
        let size = 1e-4 * theta[j].abs().max(2e-3 * span).min(span);
        for to in [theta[j] + size, theta[j] - size] {
            if to < bounds.low[j] || to > bounds.high[j] {
                continue;
            }
            moved[j] = to;
            let step = (moved[j] - theta[j]) / span;
            if step == 0.0 {
                // Held by bounds that meet, or by the last digit.
                break;
            }
            if let Some(there) = problem.at(&moved).filter(|there| there.len() == r.len()) {
                for ((o, a), b) in out.column_mut(j).iter_mut().zip(&there).zip(r) {
                    *o = (a - b) / step;
                }
                break;
            }
        }
        moved[j] = theta[j];
    }
    out
}

/// Minimises within `bounds` from `start`, shape `(p,)` and put inside them, over the rows in `keep` (all if `None`), with residuals and Jacobian at the start if they
/// are `known`.
///
/// A minimisation that ended badly is a result too: [`Minimum::ending`].
///
/// # Panics
/// On a mask, weights or a Jacobian that are fewer than the residuals, or a Jacobian of fewer columns than parameters.
///
/// ```
/// use dgd_lsq::lm::{Bounds, Effort, minimise};
/// // An exponential through three points.
/// let mut rows = |t: &[f64]| {
///     let points = [(0.0, 2.0), (1.0, 1.0), (2.0, 0.5)];
///     Some(points.iter().map(|(x, y): &(f64, f64)| t[0] * (-t[1] * x).exp() - y).collect::<Vec<f64>>())
/// };
/// let bounds = Bounds::new(vec![0.0; 2], vec![5.0; 2])?;
/// let found = minimise(&mut rows, &[1.0, 1.0], &bounds, None, None, Effort::default());
/// assert!((found.theta[1] - 2.0_f64.ln()).abs() < 1e-6);
/// # Ok::<(), dgd_lsq::LsqError>(())
/// ```
pub fn minimise<R: Residuals + ?Sized>(
    problem: &mut R,
    start: &[f64],
    bounds: &Bounds,
    keep: Option<&[bool]>,
    known: Option<(&[f64], &DMatrix<f64>)>,
    effort: Effort,
) -> Minimum {
    match Search::begin(problem, start, bounds, keep, known, effort) {
        Ok(mut search) => {
            let ending = search.run();
            search.minimum(ending)
        }
        Err(nowhere) => *nowhere,
    }
}

/// Element `index`, from 0, of Halton's sequence in dimension `dimension`: within 0 to 1, where more searches begin.
///
/// # Source
/// Halton, J. H., Numerische Mathematik 2 (1960).
///
/// ```
/// use dgd_lsq::lm::halton;
/// assert_eq!([0, 1, 2].map(|k| halton(k, 0)), [0.5, 0.25, 0.75]);
/// assert!((halton(0, 1) - 1.0 / 3.0).abs() < 1e-15);
/// ```
#[must_use]
pub fn halton(index: usize, dimension: usize) -> f64 {
    const PRIMES: [usize; 16] = [2, 3, 5, 7, 11, 13, 17, 19, 23, 29, 31, 37, 41, 43, 47, 53];
    let base = PRIMES[dimension % PRIMES.len()];
    // Beyond the list the same bases are used again, further along.
    let (mut i, mut share, mut sum) = (index + 1 + 17 * (dimension / PRIMES.len()), 1.0, 0.0);
    while i > 0 {
        #[expect(clippy::cast_precision_loss, reason = "a digit and a small prime")]
        let (digit, base) = ((i % base) as f64, base as f64);
        share /= base;
        sum += share * digit;
        i /= PRIMES[dimension % PRIMES.len()];
    }
    sum
}
