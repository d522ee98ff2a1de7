//! Estimates of a polynomial law from samples at one delay.

use crate::polynomial::{column_names, fill_terms, term};
use crate::{FrictionError, Polynomial, Terms};
use dgd_lsq::{Accumulator, LsqError, RobustOptions, RobustStatus, fit_robust};

/// Most the condition number of a friction fit may be by default.
///
/// Flow spread evenly over 0 to its largest gives 8 for `C q + D q²` and 19 for `B + D q² + E q³`;
/// spread over 1 % either side of one value it gives 350 and 72,000. Past 1e4 the terms are not
/// told apart by the flow but by the noise.
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
        let bad = self
            .keep
            .iter()
            .zip(self.friction_pa)
            .position(|(keep, f)| *keep && !f.is_finite());
        bad.map_or(Ok(()), |index| Err(FrictionError::NonFinite { index }))
    }

    /// Whether the flow of a sample may be paired with a friction sample.
    pub(crate) fn flow_usable(&self, at: usize) -> bool {
        self.flow_m3_s[at].is_finite() && (!self.keep_delayed || self.keep[at])
    }

    /// Visits `(q(t + delay), F(t))` of every `stride`-th row used at a delay, in order of time.
    pub(crate) fn pairs(&self, delay: i64, stride: usize, mut visit: impl FnMut(f64, f64)) {
        let n = self.flow_m3_s.len();
        let shift = usize::try_from(delay.unsigned_abs()).unwrap_or(n).min(n);
        // Friction starts at `f0`, flow at `q0`; one of them is 0.
        let (f0, q0) = if delay >= 0 { (0, shift) } else { (shift, 0) };
        let m = n - shift;
        let flow = self.flow_m3_s[q0..][..m].iter().zip(&self.keep[q0..][..m]);
        let friction = self.friction_pa[f0..][..m]
            .iter()
            .zip(&self.keep[f0..][..m]);
        for ((q, kept_there), (f, kept)) in flow.zip(friction).step_by(stride) {
            if *kept && q.is_finite() && (*kept_there || !self.keep_delayed) {
                visit(*q, *f);
            }
        }
    }

    /// The rows of [`pairs`](Self::pairs) as a least-squares problem.
    pub(crate) fn accumulate(
        &self,
        delay: i64,
        stride: usize,
        powers: &[f64],
    ) -> Result<Accumulator, LsqError> {
        let mut rows = Accumulator::new(column_names(powers))?;
        let mut q = [0.0; BATCH];
        let mut f = [0.0; BATCH];
        let mut columns = vec![0.0; powers.len() * BATCH];
        let mut outcome = Ok(());
        let mut filled = 0;
        let mut flush = |q: &[f64], f: &[f64]| {
            for (column, n) in columns.chunks_exact_mut(BATCH).zip(powers) {
                fill_terms(&mut column[..q.len()], q, *n);
            }
            let views: Vec<&[f64]> = columns.chunks_exact(BATCH).map(|c| &c[..q.len()]).collect();
            if outcome.is_ok() {
                outcome = rows.push_columns(&views, f);
            }
        };
        self.pairs(delay, stride, |flow, friction| {
            q[filled] = flow;
            f[filled] = friction;
            filled += 1;
            if filled == BATCH {
                flush(&q, &f);
                filled = 0;
            }
        });
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
    /// Huber's, see [`dgd_lsq::fit_robust`].
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
/// [`FrictionError::Powers`], and [`FrictionError::Fit`] on too few rows or flow that varies too
/// little (condition above [`CONDITION_LIMIT`]).
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
                condition_limit: options.condition_limit.min(CONDITION_LIMIT),
                ..options
            };
            let replay = |visit: &mut dyn FnMut(&[f64], f64)| {
                let mut row = vec![0.0; powers.len()];
                samples.pairs(delay, 1, |q, f| {
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
