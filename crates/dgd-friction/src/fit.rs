//! Estimates of a polynomial law from samples at one delay.

use crate::polynomial::{column_names, fill_terms, term};
use crate::{FrictionError, Polynomial, Terms};
use dgd_lsq::{Accumulator, LsqError, RobustOptions, RobustStatus, fit_robust};

/// Most the condition number of the column-scaled regressors of a friction fit may be.
///
/// Flow spread evenly over 0 to its largest gives 8 for `C q + D q²` and 19 for `B + D q² + E q³`;
/// spread over 1 % either side of one value it gives 350 and 72,000. Past 1e4 the terms are not
/// told apart by the flow but by the noise. [`dgd_lsq::CONDITION_LIMIT`] is where digits end and knows of no noise; that of
/// `dgd-pump` is greater because its terms are more alike on any rig.
pub const CONDITION_LIMIT: f64 = 1e4;

/// Rows whose powers are taken together.
pub(crate) const BATCH: usize = 256;

/// A recording on a uniform grid: what [`fit`] and [`delay_sweep`](crate::delay_sweep) read.
#[derive(Debug, Clone, Copy)]
pub struct Samples<'a> {
    /// Measured flow, m³/s, shape `(n,)`; NaN in gaps.
    pub flow_m3_s: &'a [f64],
    /// Friction, Pa, shape `(n,)`; only read where kept.
    pub friction_pa: &'a [f64],
    /// Samples of the friction to use, shape `(n,)`.
    pub keep: &'a [bool],
    /// Also ask that `keep` holds at the delayed sample the flow is taken from. Default in the
    /// thesis' procedure: false, only a finite flow is asked for there.
    pub keep_delayed: bool,
}

/// Rows of flow and friction at one delay.
struct Shifted<'a> {
    flow: &'a [f64],
    keep_flow: &'a [bool],
    friction: &'a [f64],
    keep: &'a [bool],
}

impl Samples<'_> {
    pub(crate) fn check(&self) -> Result<(), FrictionError> {
        let expected = self.flow_m3_s.len();
        for (name, found) in [
            ("friction_pa", self.friction_pa.len()),
            ("keep", self.keep.len()),
        ] {
            if found != expected {
                return Err(FrictionError::Length {
                    name,
                    found,
                    expected,
                });
            }
        }
        let bad = |(keep, f): (&bool, &f64)| *keep & !f.is_finite();
        let rows = || self.keep.iter().zip(self.friction_pa);
        // Without an early exit the compiler takes several rows at once; which is bad is asked after.
        if !rows().fold(false, |any, row| any | bad(row)) {
            return Ok(());
        }
        let index = rows().position(bad).unwrap_or(0);
        Err(FrictionError::NonFinite { index })
    }

    /// Flow and friction so that a row of the one belongs to the same row of the other.
    fn shifted(&self, delay: i64) -> Shifted<'_> {
        let n = self.flow_m3_s.len();
        let shift = usize::try_from(delay.unsigned_abs()).unwrap_or(n).min(n);
        // Friction starts at `f0`, flow at `q0`; one of them is 0.
        let (f0, q0) = if delay >= 0 { (0, shift) } else { (shift, 0) };
        let m = n - shift;
        Shifted {
            flow: &self.flow_m3_s[q0..][..m],
            keep_flow: &self.keep[q0..][..m],
            friction: &self.friction_pa[f0..][..m],
            keep: &self.keep[f0..][..m],
        }
    }

    /// Visits `(q(t + delay), F(t))` of every row used at a delay, in order of time.
    pub(crate) fn pairs(&self, delay: i64, mut visit: impl FnMut(f64, f64)) {
        let shifted = self.shifted(delay);
        let flow = shifted.flow.iter().zip(shifted.keep_flow);
        let friction = shifted.friction.iter().zip(shifted.keep);
        for ((q, kept_there), (f, kept)) in flow.zip(friction) {
            if *kept && q.is_finite() && (*kept_there || !self.keep_delayed) {
                visit(*q, *f);
            }
        }
    }

    /// Every `stride`-th of the rows of [`pairs`](Self::pairs), used or not, as a least-squares problem.
    pub(crate) fn accumulate(
        &self,
        delay: i64,
        stride: usize,
        powers: &[f64],
    ) -> Result<Accumulator, LsqError> {
        let mut rows = Accumulator::new(column_names(powers))?;
        let mut columns = vec![0.0; powers.len() * BATCH];
        let mut outcome = Ok(());
        let mut flush = |q: &[f64], f: &[f64]| {
            for (column, n) in columns.chunks_exact_mut(BATCH).zip(powers) {
                fill_terms(&mut column[..q.len()], q, *n);
            }
            let views: Vec<&[f64]> = columns.chunks_exact(BATCH).map(|c| &c[..q.len()]).collect();
            if outcome.is_ok() {
                outcome = rows.push_columns(&views, f);
            }
        };
        // Room for a batch beyond the one that is filling up.
        let (mut q, mut f) = ([0.0; 2 * BATCH], [0.0; 2 * BATCH]);
        let mut filled = 0;
        let shifted = self.shifted(delay);
        let (flows, frictions) = (shifted.flow.chunks(BATCH), shifted.friction.chunks(BATCH));
        let (kept_there, kept) = (shifted.keep_flow.chunks(BATCH), shifted.keep.chunks(BATCH));
        let mut skip = 0;
        for ((flows, there), (frictions, kept)) in flows.zip(kept_there).zip(frictions.zip(kept)) {
            let of_flow = flows.iter().zip(there);
            let both = of_flow.zip(frictions.iter().zip(kept));
            // Every row is written, and the place moves on if it is used: no branch to foresee wrongly.
            let take = |((flow, there), (friction, kept)): ((&f64, &bool), (&f64, &bool))| {
                (q[filled], f[filled]) = (*flow, *friction);
                let used = *kept & flow.is_finite() & (*there | !self.keep_delayed);
                filled += usize::from(used);
            };
            if stride == 1 {
                both.for_each(take);
            } else {
                both.skip(skip).step_by(stride).for_each(take);
            }
            // How far the stride reaches into the next batch.
            let left = flows.len().saturating_sub(skip);
            skip = (skip + left.div_ceil(stride) * stride).saturating_sub(flows.len());
            if filled >= BATCH {
                flush(&q[..BATCH], &f[..BATCH]);
                q.copy_within(BATCH..filled, 0);
                f.copy_within(BATCH..filled, 0);
                filled -= BATCH;
            }
        }
        flush(&q[..filled], &f[..filled]);
        outcome.map(|()| rows)
    }
}

/// What the residuals cost.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Loss {
    /// Least squares.
    #[default]
    Squared,
    /// Huber's, see [`dgd_lsq::fit_robust`]. A [`RobustOptions::condition_limit`] above [`CONDITION_LIMIT`], as its default is, counts as
    /// that: what noise blurs for least squares it blurs for Huber's loss.
    Huber(RobustOptions),
}

/// A friction law fitted to samples, with its doubt.
#[derive(Debug, Clone, PartialEq)]
pub struct PolynomialFit {
    /// The law.
    pub law: Polynomial,
    /// Standard error per coefficient, same shape and units; independent residuals assumed, so
    /// too small for rig data at 1 Hz.
    pub standard_errors: Vec<f64>,
    /// Covariance of the coefficients, shape `(p, p)`, row-major.
    pub covariance: Vec<f64>,
    /// Residual sum of squares over n - p, Pa² (unweighted for either loss).
    pub mse_pa2: f64,
    /// Share of the variance about the mean friction that the law explains, also for laws without
    /// an offset; may be negative for those. NaN if the friction is constant.
    pub r2: f64,
    /// Samples used.
    pub n: u64,
    /// Condition number of the column-scaled regressors: 1 is richly excited.
    pub condition: f64,
    /// Scale, mean weight and end of the reweighting, for [`Loss::Huber`].
    pub robust: Option<Reweighting>,
}

/// How a Huber fit weighed the samples.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reweighting {
    /// Scale of the residuals, Pa.
    pub scale_pa: f64,
    /// Mean weight, 0 to 1.
    pub weight_share: f64,
    /// Reweightings done.
    pub iterations: u32,
    /// How they ended.
    pub status: RobustStatus,
}

/// Fits a friction law at one delay: `F(t) = Σ c_j q(t + delay)^(n_j)`.
///
/// - `samples`: flow and friction on one uniform grid.
/// - `delay_samples`: how many samples later the meter shows the flow (thesis Eq. 3.22); may be
///   negative.
///
/// Rows used: `keep[t]`, with `t + delay` inside the recording and the flow there finite.
///
/// # Errors
/// [`FrictionError::Length`], [`FrictionError::NonFinite`] on the first bad kept friction,
/// [`FrictionError::Powers`], and [`FrictionError::Fit`] on too few rows, flow that varies too
/// little (condition above [`CONDITION_LIMIT`]) or options of Huber's loss out of their domain.
///
/// # Source
/// Thesis Eqs. 3.14-3.29; recovery of a known law: `tests/it/fit.rs`.
///
/// ```
/// use dgd_friction::{Loss, Samples, Terms, fit};
/// let flow_m3_s = [0.01, 0.02, 0.03, 0.04, 0.05];
/// let friction_pa = flow_m3_s.map(|q| 1e6 * q + 9e7 * q * q);
/// let samples = Samples {
///     flow_m3_s: &flow_m3_s, friction_pa: &friction_pa, keep: &[true; 5], keep_delayed: false,
/// };
/// let fit = fit(&samples, 0, &Terms::Quadratic, Loss::Squared)?;
/// assert!((fit.law.coefficient(2.0).unwrap() / 9e7 - 1.0).abs() < 1e-9);
/// # Ok::<(), dgd_friction::FrictionError>(())
/// ```
pub fn fit(
    samples: &Samples,
    delay_samples: i64,
    terms: &Terms,
    loss: Loss,
) -> Result<PolynomialFit, FrictionError> {
    samples.check()?;
    fit_checked(samples, delay_samples, &terms.powers()?, loss)
}

pub(crate) fn fit_checked(
    samples: &Samples,
    delay: i64,
    powers: &[f64],
    loss: Loss,
) -> Result<PolynomialFit, FrictionError> {
    match loss {
        Loss::Squared => {
            let rows = samples.accumulate(delay, 1, powers)?;
            let fit = rows.reduce().solve(CONDITION_LIMIT)?;
            Ok(PolynomialFit {
                law: law(powers, fit.coefficients),
                standard_errors: fit.standard_errors,
                covariance: fit.covariance,
                mse_pa2: fit.mse,
                r2: fit.r2,
                n: fit.n,
                condition: fit.condition,
                robust: None,
            })
        }
        Loss::Huber(options) => {
            let options = RobustOptions {
                condition_limit: if options.condition_limit > CONDITION_LIMIT {
                    CONDITION_LIMIT
                } else {
                    // One that is none is refused: not `min`, which would hide a NaN.
                    options.condition_limit
                },
                ..options
            };
            let replay = |visit: &mut dyn FnMut(&[f64], f64)| {
                let mut row = vec![0.0; powers.len()];
                samples.pairs(delay, |q, f| {
                    for (x, n) in row.iter_mut().zip(powers) {
                        *x = term(q, *n);
                    }
                    visit(&row, f);
                });
            };
            let fit = fit_robust(column_names(powers), replay, &options)?;
            let plain = &fit.least_squares;
            Ok(PolynomialFit {
                law: law(powers, fit.coefficients),
                standard_errors: fit.standard_errors,
                covariance: fit.covariance,
                mse_pa2: fit.mse,
                r2: if plain.mse > 0.0 {
                    1.0 - (1.0 - plain.r2) * fit.mse / plain.mse
                } else {
                    plain.r2
                },
                n: plain.n,
                condition: plain.condition,
                robust: Some(Reweighting {
                    scale_pa: fit.scale,
                    weight_share: fit.weight_share,
                    iterations: fit.iterations,
                    status: fit.status,
                }),
            })
        }
    }
}

fn law(powers: &[f64], coefficients: Vec<f64>) -> Polynomial {
    Polynomial {
        powers: powers.to_vec(),
        coefficients,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The rows one by one, in the plainest way.
    fn one_by_one(samples: &Samples, delay: i64, stride: usize) -> Accumulator {
        let mut rows = Accumulator::new(["q", "q^2"]).expect("two columns");
        let n = i64::try_from(samples.keep.len()).expect("a short recording");
        let pairs = (0..n).filter(|t| (0..n).contains(&(t + delay)));
        let index = |t: i64| usize::try_from(t).expect("inside");
        for t in pairs.step_by(stride) {
            let (t, there) = (index(t), index(t + delay));
            let q = samples.flow_m3_s[there];
            if samples.keep[t] && q.is_finite() && (samples.keep[there] || !samples.keep_delayed) {
                rows.push(&[q, q * q.abs()], samples.friction_pa[t])
                    .expect("finite");
            }
        }
        rows
    }

    #[test]
    fn rows_gathered_in_batches_are_those_taken_one_by_one() {
        const SAMPLES: u32 = 1500;
        let mut flow: Vec<f64> = (0..SAMPLES).map(|i| f64::from(i % 97) - 20.0).collect();
        let friction: Vec<f64> = (0..SAMPLES).map(|i| f64::from(i % 89)).collect();
        let keep: Vec<bool> = (0..SAMPLES).map(|i| i % 7 != 3 && i / 300 != 2).collect();
        flow[40..300].fill(f64::NAN);
        flow[1400] = f64::INFINITY;
        for keep_delayed in [false, true] {
            let samples = Samples {
                flow_m3_s: &flow,
                friction_pa: &friction,
                keep: &keep,
                keep_delayed,
            };
            for delay in [-300, -1, 0, 9, 1499] {
                for stride in [1, 3, 16, 256, 700] {
                    let expected = one_by_one(&samples, delay, stride);
                    let found = samples
                        .accumulate(delay, stride, &[1.0, 2.0])
                        .expect("rows");
                    assert_eq!(found.rows(), expected.rows(), "{delay} {stride}");
                    let (found, expected) = (found.reduce(), expected.reduce());
                    for k in 0..9 {
                        let (a, b) = (found.r(k / 3, k % 3), expected.r(k / 3, k % 3));
                        assert_eq!(a.to_bits(), b.to_bits(), "{delay} {stride} {k}");
                    }
                }
            }
        }
    }
}
