//! Huber's M-estimate by iteratively reweighted least squares.

use crate::fit::check_condition_limit;
use crate::{Accumulator, CONDITION_LIMIT, Fit, LsqError};

/// Median of |z| of a standard normal z: makes the MAD a standard deviation.
const NORMAL_MAD: f64 = 0.674_489_750_196_081_7;

/// Least `k`: so few residuals lie within fewer scales that none tells the slope of the loss.
const LEAST_K: f64 = 1e-3;

/// How [`fit_robust`] weighs and when it stops.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RobustOptions {
    /// Residuals beyond this many scales count less, weight `k/|u|`. Default 1.345: 95 % as
    /// efficient as least squares on normal residuals (Holland and Welsch 1977). At least 1e-3: below it this is the least absolute
    /// error, of which Huber's standard errors say nothing.
    pub k: f64,
    /// Stop when no coefficient moves more than this share of its standard error. Default 1e-3.
    pub tolerance: f64,
    /// Most reweightings. Default 50.
    pub max_iterations: u32,
    /// Most the condition number may be. Default [`CONDITION_LIMIT`].
    pub condition_limit: f64,
}

impl Default for RobustOptions {
    fn default() -> Self {
        Self {
            k: 1.345,
            tolerance: 1e-3,
            max_iterations: 50,
            condition_limit: CONDITION_LIMIT,
        }
    }
}

impl RobustOptions {
    fn check(&self) -> Result<(), LsqError> {
        let finite = |found: f64, least: f64| found.is_finite() && found >= least;
        let refusal = |name, found, expected| {
            Err(LsqError::Option {
                name,
                found,
                expected,
            })
        };
        if !finite(self.k, LEAST_K) {
            return refusal("k", self.k, "a finite number of at least 0.001");
        }
        if !finite(self.tolerance, f64::MIN_POSITIVE) {
            return refusal("tolerance", self.tolerance, "a finite number above 0");
        }
        check_condition_limit(self.condition_limit)
    }
}

/// How the reweighting ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum RobustStatus {
    /// The coefficients came to rest.
    Converged,
    /// The iteration limit was reached first.
    IterationLimit,
    /// More than half of the residuals are zero, or the same but for a thousandth of the least-squares error, so there is no scale to weigh by:
    /// the last weighted fit is returned, and its standard errors are NaN unless every row fits.
    ZeroScale,
}

/// A robust estimate beside the plain one it started from.
#[derive(Debug, Clone, PartialEq)]
pub struct RobustFit {
    /// Column names, shape `(p,)`.
    pub names: Vec<String>,
    /// Estimate per column, shape `(p,)`.
    pub coefficients: Vec<f64>,
    /// Huber's (1981, chapter 7) standard errors, shape `(p,)`; independent residuals assumed. Infinite where no residual lies within `k`
    /// scales.
    pub standard_errors: Vec<f64>,
    /// Their covariance, shape `(p, p)`, row-major.
    pub covariance: Vec<f64>,
    /// Scale of the residuals, `median|r| / 0.6745`, in units of y.
    pub scale: f64,
    /// Mean weight of the rows, 0 to 1: 1 means nothing was weighed down.
    pub weight_share: f64,
    /// Mean of the squared, unweighted residuals at the robust coefficients, over n - p.
    pub mse: f64,
    /// Reweightings done.
    pub iterations: u32,
    /// How the reweighting ended.
    pub status: RobustStatus,
    /// The plain least-squares fit of the same rows.
    pub least_squares: Fit,
}

/// Fits by Huber's loss: outliers count linearly, not quadratically.
///
/// - `names`: one per column.
/// - `rows`: replays all rows, in the same order at every call, by calling what it is given with
///   the regressors, shape `(p,)`, and the observation.
///
/// Keeps one residual per row (the scale is a median), so memory is O(n) here.
/// Huber's weights bound the residual, not the regressors: rows far out in the regressors still pull.
///
/// # Errors
/// Those of [`Accumulator::push`] and [`Reduced::solve`](crate::Reduced::solve);
/// [`LsqError::Option`] on `k` below 1e-3, or `tolerance` or `condition_limit` not above 0.
///
/// # Source
/// P. J. Huber, Robust Statistics (1981), chapter 7; recovery with outliers: `tests/it/robust.rs`.
///
/// ```
/// use dgd_lsq::{RobustOptions, RobustStatus, fit_robust};
/// let fit = fit_robust(
///     ["1"],
///     |row| [1.0, 1.1, 0.9, 1.05, 50.0].iter().for_each(|&y| row(&[1.0], y)),
///     &RobustOptions::default(),
/// )?;
/// assert!((fit.coefficients[0] - 1.0).abs() < 0.2);
/// assert_eq!(fit.status, RobustStatus::Converged);
/// # Ok::<(), dgd_lsq::LsqError>(())
/// ```
pub fn fit_robust<S, R>(
    names: impl IntoIterator<Item = S>,
    rows: R,
    options: &RobustOptions,
) -> Result<RobustFit, LsqError>
where
    S: Into<String>,
    R: Fn(&mut dyn FnMut(&[f64], f64)),
{
    options.check()?;
    let empty = Accumulator::new(names)?;
    let solve = |weight: &dyn Fn(f64) -> f64, coefficients: &[f64]| {
        let mut fitted = empty.clone();
        let mut outcome = Ok(());
        rows(&mut |row, y| {
            if outcome.is_ok() {
                let r = y - inner(coefficients, row);
                outcome = fitted.push_weighted(row, y, weight(r));
            }
        });
        outcome.and_then(|()| fitted.reduce().solve(options.condition_limit))
    };
    let least_squares = solve(&|_| 1.0, &[])?;
    let mut current = least_squares.coefficients.clone();
    let mut residuals = Vec::new();
    let mut iterations = 0;
    let status = loop {
        collect(&rows, &current, &mut residuals);
        let scale = scale_of(&mut residuals);
        if scale == 0.0 {
            break RobustStatus::ZeroScale;
        }
        if iterations == options.max_iterations {
            break RobustStatus::IterationLimit;
        }
        let next = solve(&|r| huber_weight(r / scale, options.k), &current)?;
        iterations += 1;
        let moved = next
            .coefficients
            .iter()
            .zip(&current)
            .zip(&next.standard_errors)
            .any(|((a, b), se)| (a - b).abs() > options.tolerance * se);
        current = next.coefficients;
        if !moved {
            break RobustStatus::Converged;
        }
    };
    collect(&rows, &current, &mut residuals);
    Ok(summary(
        least_squares,
        current,
        &mut residuals,
        options.k,
        iterations,
        status,
    ))
}

/// Share of the least-squares error below which a scale is none: more than half of the rows share one residual, as in steps of a coarse
/// reading, and the median of them says nothing of the others.
const LEAST_SCALE: f64 = 1e-3;

/// Huber's asymptotic covariance: that of least squares, with ψ's moments in place of the mse.
fn summary(
    least_squares: Fit,
    coefficients: Vec<f64>,
    residuals: &mut [f64],
    k: f64,
    iterations: u32,
    status: RobustStatus,
) -> RobustFit {
    #[expect(clippy::cast_precision_loss, reason = "row counts stay far below 2^53")]
    let (n, p) = (residuals.len() as f64, coefficients.len() as f64);
    let mse = residuals.iter().map(|r| r * r).sum::<f64>() / (n - p);
    let scale = scale_of(residuals);
    let none = scale <= LEAST_SCALE * least_squares.mse.sqrt();
    let status = if none {
        RobustStatus::ZeroScale
    } else {
        status
    };
    let (mut share, mut psi2, mut inside) = (0.0, 0.0, 0.0);
    for r in residuals.iter() {
        // With no scale nothing was weighed down.
        let u = if scale > 0.0 { r / scale } else { 0.0 };
        share += huber_weight(u, k);
        psi2 += u.abs().min(k).powi(2);
        inside += f64::from(u.abs() <= k);
    }
    let inside = inside / n;
    // Small-sample factor for the spread of ψ' (0 or 1) over the rows.
    let small = 1.0 + p / n * (1.0 - inside) / inside;
    let variance = (small * scale / inside).powi(2) * psi2 / (n - p);
    let covariance: Vec<f64> = least_squares
        .covariance
        .iter()
        .map(|c| {
            if least_squares.mse == 0.0 {
                0.0
            } else if none {
                f64::NAN
            } else {
                c / least_squares.mse * variance
            }
        })
        .collect();
    let width = coefficients.len();
    RobustFit {
        names: least_squares.names.clone(),
        standard_errors: (0..width)
            .map(|i| covariance[i * width + i].sqrt())
            .collect(),
        coefficients,
        covariance,
        scale,
        weight_share: share / n,
        mse,
        iterations,
        status,
        least_squares,
    }
}

fn collect(
    rows: &impl Fn(&mut dyn FnMut(&[f64], f64)),
    coefficients: &[f64],
    residuals: &mut Vec<f64>,
) {
    residuals.clear();
    rows(&mut |row, y| residuals.push(y - inner(coefficients, row)));
}

fn inner(coefficients: &[f64], row: &[f64]) -> f64 {
    coefficients.iter().zip(row).map(|(c, x)| c * x).sum()
}

fn huber_weight(u: f64, k: f64) -> f64 {
    if u.abs() <= k { 1.0 } else { k / u.abs() }
}

/// Median of |r| about zero, as a standard deviation. Reorders the residuals.
fn scale_of(residuals: &mut [f64]) -> f64 {
    if residuals.is_empty() {
        return 0.0;
    }
    let middle = residuals.len() / 2;
    let even = residuals.len().is_multiple_of(2);
    let (below, upper, _) =
        residuals.select_nth_unstable_by(middle, |a, b| a.abs().total_cmp(&b.abs()));
    let upper = upper.abs();
    let lower = if even {
        below.iter().fold(0.0, |most: f64, r| most.max(r.abs()))
    } else {
        upper
    };
    // Halved first: their sum may overflow.
    (0.5 * lower + 0.5 * upper) / NORMAL_MAD
}
