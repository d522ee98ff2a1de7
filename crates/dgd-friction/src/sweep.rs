//! The delay of the flow meter, found by fitting at every delay of a range.

use std::ops::RangeInclusive;

use crate::fit::fit_checked;
use crate::sums::{Problem, Sums};
use crate::{CONDITION_LIMIT, FrictionError, Loss, PolynomialFit, Samples, Terms};
use dgd_lsq::Reduced;

/// Of so many rows one is used to find the basis.
const THINNING: usize = 16;

/// What to sweep.
#[derive(Debug, Clone, PartialEq)]
pub struct SweepOptions {
    /// Delays to try, samples; negative means the meter leads. Default `0..=30`.
    pub delays: RangeInclusive<i64>,
    /// Sampling interval, s. Default 1.
    pub dt_s: f64,
    /// Loss of the reported fit at the best delay; the sweep itself is least squares. Default squared.
    pub loss: Loss,
}

impl Default for SweepOptions {
    fn default() -> Self {
        Self {
            delays: 0..=30,
            dt_s: 1.0,
            loss: Loss::Squared,
        }
    }
}

/// Where in the range the smallest error lies.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Minimum {
    /// Inside: both neighbours are worse (or equal).
    Interior,
    /// At the first delay: the range may be too short there.
    AtFirst,
    /// At the last delay: the range may be too short there.
    AtLast,
    /// Beside a delay that could not be fitted.
    BesideGap,
}

/// Errors of the fit against the assumed delay, and the full fit at the best.
#[derive(Debug, Clone, PartialEq)]
pub struct DelaySweep {
    /// Delays tried, s, rising, shape `(d,)`.
    pub delays_s: Vec<f64>,
    /// Mean squared error (over n - p) at each, Pa², shape `(d,)`: at `best` by QR of the rows, at the others by sums, rounded to 1e-12 of
    /// the mean of F² (see [`delay_sweep`]), and 0 where the error is less than that; NaN where no fit was possible, or of fewer than half of the rows of the
    /// delay that has most: rows differ from delay to delay, and a few fit any law.
    pub mse_pa2: Vec<f64>,
    /// Samples used at each, shape `(d,)`.
    pub n: Vec<u64>,
    /// Index of the smallest error (the earliest, on a tie).
    pub best: usize,
    /// The delay at `best`, samples.
    pub best_delay_samples: i64,
    /// Vertex of the parabola through the smallest error and its neighbours, s; equals
    /// `delays_s[best]` unless [`Minimum::Interior`].
    pub refined_delay_s: f64,
    /// Where the minimum lies.
    pub minimum: Minimum,
    /// The fit at the best delay, by QR.
    pub fit: PolynomialFit,
}

/// A sweep before the rows are fitted at its best delay: what [`delay_sweep`] does first.
///
/// For callers with other work for that delay, which then need not wait for the fit.
#[derive(Debug, Clone, PartialEq)]
pub struct DelayScan {
    /// The delay of the least error, samples.
    pub best_delay_samples: i64,
    powers: Vec<f64>,
    loss: Loss,
    delays_s: Vec<f64>,
    mse_pa2: Vec<f64>,
    n: Vec<u64>,
    best: usize,
    minimum: Minimum,
    refined_delay_s: f64,
}

impl DelayScan {
    /// Fits the rows at the best delay; `samples` are those that were scanned.
    ///
    /// # Errors
    /// [`FrictionError::Fit`] on too few rows, poor excitation or options of Huber's loss out of their domain, [`FrictionError::Length`] if they are not those that were
    /// scanned, as far as their number tells.
    pub fn fit(self, samples: &Samples) -> Result<DelaySweep, FrictionError> {
        samples.check()?;
        let fit = fit_checked(samples, self.best_delay_samples, &self.powers, self.loss)?;
        if fit.n != self.n[self.best] {
            let rows = |n: u64| usize::try_from(n).unwrap_or(usize::MAX);
            return Err(FrictionError::Length {
                name: "samples at the best delay",
                found: rows(fit.n),
                expected: rows(self.n[self.best]),
            });
        }
        // What is left of sums of much larger squares may be rounding.
        let mut mse_pa2 = self.mse_pa2;
        mse_pa2[self.best] = match self.loss {
            Loss::Squared => fit.mse_pa2,
            Loss::Huber(_) => {
                let delay = self.best_delay_samples;
                fit_checked(samples, delay, &self.powers, Loss::Squared)?.mse_pa2
            }
        };
        Ok(DelaySweep {
            delays_s: self.delays_s,
            mse_pa2,
            n: self.n,
            best: self.best,
            best_delay_samples: self.best_delay_samples,
            refined_delay_s: self.refined_delay_s,
            minimum: self.minimum,
            fit,
        })
    }
}

/// Fits a friction law at every delay of a range: thesis section 3.3.2, Eqs. 3.21-3.25.
///
/// - `samples`: flow and friction on one uniform grid, NaN flow in gaps.
/// - `terms`: the law.
///
/// Rows used at delay θ: `keep[t]`, with `t + θ` inside the recording and the flow there finite
/// (and kept, with [`Samples::keep_delayed`]).
///
/// The sweep does not solve one problem per delay. The regressors are rotated once into a basis
/// that is orthonormal at the delay of the range nearest 0 that can be fitted, so the normal equations at the others are
/// well conditioned; their Gram matrix changes from one delay to the next only at the ends of kept
/// runs; the cross terms are a correlation, 16 delays at a time. Sums are rounded to about 1e-12 of the mean of F², which is taken about
/// the mean of the friction where the law has an offset: an error of a thousandth of the friction, in its root, is met to 1e-6 of itself.
/// The fit and the error reported at the best delay are by QR of the rows.
///
/// # Errors
/// [`FrictionError::Length`], [`FrictionError::NonFinite`], [`FrictionError::Powers`],
/// [`FrictionError::Delays`] on an empty range or one that leaves the recording,
/// [`FrictionError::Domain`] on a sampling interval not above 0, and [`FrictionError::Fit`] on too
/// few rows or poor excitation (the condition is held against [`CONDITION_LIMIT`]).
///
/// # Source
/// Thesis section 3.3.2; against one QR per delay: `tests/it/sweep.rs`.
pub fn delay_sweep(
    samples: &Samples,
    terms: &Terms,
    options: &SweepOptions,
) -> Result<DelaySweep, FrictionError> {
    delay_scan(samples, terms, options)?.fit(samples)
}

/// The errors at every delay, without the fit at the best: see [`delay_sweep`].
///
/// # Errors
/// Those of [`delay_sweep`], but for a best delay at which the rows themselves are refused: [`DelayScan::fit`] says that.
pub fn delay_scan(
    samples: &Samples,
    terms: &Terms,
    options: &SweepOptions,
) -> Result<DelayScan, FrictionError> {
    samples.check()?;
    let powers = terms.powers()?;
    let (first, last) = (*options.delays.start(), *options.delays.end());
    let count = delay_count(first, last, samples.flow_m3_s.len())?;
    if !(options.dt_s.is_finite() && options.dt_s > 0.0) {
        return Err(FrictionError::Domain {
            name: "dt_s",
            found: options.dt_s,
            expected: "a finite interval above 0",
        });
    }
    let basis = Basis::near_rest(samples, first..=last, &powers)?;
    let shifted = powers.contains(&0.0).then(|| about_mean(samples));
    let samples = &Samples {
        friction_pa: shifted.as_deref().unwrap_or(samples.friction_pa),
        ..*samples
    };
    let problem = Problem {
        samples,
        powers: &powers,
        inverse: &basis.inverse,
        first,
        count,
    };
    let sums = Sums::of(problem, &basis.triangle);

    // A delay that shifts most rows out of the recording is fitted by what is left of them, and by few of them any law fits.
    let most = sums.n.iter().copied().max().unwrap_or(0);
    let tells = |d: usize| FEW * sums.n[d] >= most;
    let mse_pa2: Vec<f64> = (0..count)
        .map(|d| if tells(d) { sums.mse(d) } else { f64::NAN })
        .collect();
    let best = mse_pa2
        .iter()
        .enumerate()
        .filter(|(_, mse)| mse.is_finite())
        .fold(None, |best: Option<(usize, f64)>, (d, &mse)| match best {
            Some((_, least)) if least <= mse => best,
            _ => Some((d, mse)),
        });
    // The basis was solved at one delay of the range, so some delay is fitted; if rounding denies
    // it, the QR below says why.
    let best = best.map_or(0, |(d, _)| d);
    let delay = |d: usize| first.saturating_add(i64::try_from(d).unwrap_or(i64::MAX));
    #[expect(
        clippy::cast_precision_loss,
        reason = "delays stay far below 2^53 samples"
    )]
    let delays_s: Vec<f64> = (0..count).map(|d| delay(d) as f64 * options.dt_s).collect();
    let (minimum, offset) = refine(&mse_pa2, best);
    Ok(DelayScan {
        refined_delay_s: delays_s[best] + offset * options.dt_s,
        minimum,
        best,
        best_delay_samples: delay(best),
        n: sums.n,
        delays_s,
        mse_pa2,
        loss: options.loss,
        powers,
    })
}

/// Friction less the mean of what is kept: a law with an offset leaves the same errors of it, whose sums are rounded less.
fn about_mean(samples: &Samples) -> Vec<f64> {
    let pairs = || samples.friction_pa.iter().zip(samples.keep);
    let (sum, rows) = pairs().fold((0.0, 0.0), |(sum, rows), (f, keep)| {
        if *keep {
            (sum + f, rows + 1.0)
        } else {
            (sum, rows)
        }
    });
    let mean = sum / f64::max(rows, 1.0);
    samples.friction_pa.iter().map(|f| f - mean).collect()
}

/// A delay has at least so many-th part of the rows of the one that has most, or its error is not told.
const FEW: u64 = 2;

fn delay_count(first: i64, last: i64, samples: usize) -> Result<usize, FrictionError> {
    let n = i64::try_from(samples).unwrap_or(i64::MAX);
    let inside = first <= last && first > -n && last < n;
    let count = inside.then(|| usize::try_from(last - first + 1).ok());
    count.flatten().ok_or(FrictionError::Delays {
        first,
        last,
        samples,
    })
}

/// Place and sub-sample offset of a minimum, from its neighbours.
fn refine(mse: &[f64], best: usize) -> (Minimum, f64) {
    if best == 0 {
        return (Minimum::AtFirst, 0.0);
    }
    if best + 1 == mse.len() {
        return (Minimum::AtLast, 0.0);
    }
    let (before, at, after) = (mse[best - 1], mse[best], mse[best + 1]);
    if !(before.is_finite() && after.is_finite()) {
        return (Minimum::BesideGap, 0.0);
    }
    // The earliest of the least errors: `before` is larger, so the parabola bends up.
    let curvature = before - 2.0 * at + after;
    (Minimum::Interior, 0.5 * (before - after) / curvature)
}

/// Inverse of the triangle of the regressors at one delay: columns of a basis that is orthonormal there.
struct Basis {
    /// p×p, row-major, upper triangle.
    inverse: Vec<f64>,
    /// The triangle itself, which takes the basis back to the regressors.
    triangle: Vec<f64>,
}

impl Basis {
    /// At the delay nearest 0 that can be fitted: a dead meter may leave no rows at some.
    fn near_rest(
        samples: &Samples,
        delays: std::ops::RangeInclusive<i64>,
        powers: &[f64],
    ) -> Result<Self, FrictionError> {
        let (first, last) = (*delays.start(), *delays.end());
        let nearest = 0_i64.clamp(first, last);
        let refused = match Self::at(samples, nearest, powers) {
            Err(FrictionError::Fit(refused)) => FrictionError::Fit(refused),
            done => return done,
        };
        let mut others: Vec<i64> = delays.filter(|delay| *delay != nearest).collect();
        others.sort_by_key(|delay| delay.abs_diff(nearest));
        (others.into_iter())
            .find_map(|delay| Self::at(samples, delay, powers).ok())
            .ok_or(refused)
    }

    fn at(samples: &Samples, delay: i64, powers: &[f64]) -> Result<Self, FrictionError> {
        // A sixteenth of the rows gives a basis that is orthonormal enough, unless it misses the
        // few rows that excite. Poor excitation is refused by name before anything is inverted.
        let mut reduced = samples.accumulate(delay, THINNING, powers)?.reduce();
        if reduced.solve(CONDITION_LIMIT).is_err() {
            reduced = samples.accumulate(delay, 1, powers)?.reduce();
            reduced.solve(CONDITION_LIMIT)?;
        }
        let p = powers.len();
        Ok(Self {
            inverse: invert(&reduced, p),
            triangle: (0..p * p).map(|k| reduced.r(k / p, k % p)).collect(),
        })
    }
}

fn invert(r: &Reduced, p: usize) -> Vec<f64> {
    let mut inverse = vec![0.0; p * p];
    for j in 0..p {
        inverse[j * p + j] = 1.0 / r.r(j, j);
        for i in (0..j).rev() {
            let sum: f64 = (i + 1..=j).map(|k| r.r(i, k) * inverse[k * p + j]).sum();
            inverse[i * p + j] = -sum / r.r(i, i);
        }
    }
    inverse
}

#[cfg(test)]
mod tests {
    use super::*;
    use dgd_lsq::Accumulator;

    #[test]
    fn the_basis_is_the_inverse_of_the_triangle() {
        let mut rows = Accumulator::new(["a", "b", "c", "d"]).expect("four names");
        for i in 0..20 {
            let x = f64::from(i) / 7.0;
            let row = [1.0, x.sin(), x * x, (1.3 * x).cos()];
            rows.push(&row, x).expect("finite rows");
        }
        let r = rows.reduce();
        let inverse = invert(&r, 4);
        for i in 0..4 {
            for j in 0..4 {
                let product: f64 = (i..4).map(|k| r.r(i, k) * inverse[k * 4 + j]).sum();
                let identity = if i == j { 1.0 } else { 0.0 };
                assert!((product - identity).abs() < 1e-13, "{i}, {j}: {product}");
            }
        }
    }

    #[test]
    fn the_vertex_of_a_parabola_is_met_exactly() {
        // (d - 1.25)² + 3 at 0, 1, 2.
        let (minimum, offset) = refine(&[4.5625, 3.0625, 3.5625], 1);
        assert_eq!((minimum, offset), (Minimum::Interior, 0.25));
        // A tie with the delay after: the vertex lies halfway.
        assert_eq!(refine(&[2.0, 1.0, 1.0], 1).1, 0.5);
    }

    #[test]
    fn one_delay_that_cannot_be_fitted_is_a_gap_on_either_side() {
        for mse in [[f64::NAN, 1.0, 2.0], [2.0, 1.0, f64::NAN]] {
            assert_eq!(refine(&mse, 1), (Minimum::BesideGap, 0.0));
        }
    }
}
