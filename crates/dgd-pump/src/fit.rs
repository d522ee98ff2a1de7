//! Least squares for known exponents.

use crate::curve::power;
use crate::{HeadCurve, PumpError};
use dgd_lsq::{Accumulator, Fit, Reduced};

/// Most the condition number of the column-scaled regressors may be.
///
/// Where speed and flow go together, as on a rig, about 100 is usual: three powers of two quantities that rise together are more alike than
/// the powers of one that is spread, so this is ten times what `dgd-friction` allows. [`dgd_lsq::CONDITION_LIMIT`] is where
/// digits end and knows of no noise.
pub const CONDITION_LIMIT: f64 = 1e5;

/// Names of the columns in refusals.
const NAMES: [&str; 3] = ["w^n0", "-w q", "-q^n2"];

/// Rows whose powers are taken together.
const BATCH: usize = 256;

/// Samples of a pump: what the fits read. Shift the flow by the meter's delay first (thesis
/// Eq. 3.30).
#[derive(Debug, Clone, Copy)]
pub struct Samples<'a> {
    /// Pump speed, percent of full, shape `(n,)`; at least 0 where kept.
    pub speed_pct: &'a [f64],
    /// Flow through the pump, m³/s, shape `(n,)`; at least 0 where kept.
    pub flow_m3_s: &'a [f64],
    /// Head `(P_out - P_in)/(ρ g)`, m (thesis Eq. 2.27 with the mud's density), shape `(n,)`.
    pub head_m: &'a [f64],
    /// Samples to use, shape `(n,)`; others are never read, so may be NaN.
    pub keep: &'a [bool],
}

impl Samples<'_> {
    pub(crate) fn check(&self) -> Result<(), PumpError> {
        let expected = self.speed_pct.len();
        for (name, found) in [
            ("flow_m3_s", self.flow_m3_s.len()),
            ("head_m", self.head_m.len()),
            ("keep", self.keep.len()),
        ] {
            if found != expected {
                return Err(PumpError::Length {
                    name,
                    found,
                    expected,
                });
            }
        }
        // No early exit and no branch: the compiler takes several rows at once. A NaN compares false.
        let usable = |v: &f64| (*v >= 0.0) & (*v <= f64::MAX);
        let measured = self.speed_pct.iter().zip(self.flow_m3_s);
        let rows = measured.zip(self.head_m.iter().zip(self.keep));
        let sound = rows.fold(true, |all, ((w, q), (h, keep))| {
            all & (!*keep | (usable(w) & usable(q) & (h.abs() <= f64::MAX)))
        });
        if sound { Ok(()) } else { Err(self.refusal()) }
    }

    #[cold]
    fn refusal(&self) -> PumpError {
        let series = [
            ("speed_pct", self.speed_pct, true),
            ("flow_m3_s", self.flow_m3_s, true),
            ("head_m", self.head_m, false),
        ];
        for index in (0..self.keep.len()).filter(|&i| self.keep[i]) {
            for (name, values, signed) in series {
                let found = values[index];
                if !found.is_finite() {
                    return PumpError::NonFinite { name, index };
                }
                if signed && found < 0.0 {
                    return PumpError::Negative { name, index, found };
                }
            }
        }
        PumpError::Solver
    }

    /// The samples from one on.
    pub(crate) fn from(&self, start: usize) -> Self {
        Self {
            speed_pct: &self.speed_pct[start..],
            flow_m3_s: &self.flow_m3_s[start..],
            head_m: &self.head_m[start..],
            keep: &self.keep[start..],
        }
    }

    /// The samples before one.
    pub(crate) fn to(&self, end: usize) -> Self {
        Self {
            speed_pct: &self.speed_pct[..end],
            flow_m3_s: &self.flow_m3_s[..end],
            head_m: &self.head_m[..end],
            keep: &self.keep[..end],
        }
    }

    /// Kept `(w, q, H)`, in order of time.
    pub(crate) fn rows(&self) -> impl Iterator<Item = (f64, f64, f64)> {
        self.speed_pct
            .iter()
            .zip(self.flow_m3_s)
            .zip(self.head_m.iter().zip(self.keep))
            .filter(|(_, (_, keep))| **keep)
            .map(|((w, q), (h, _))| (*w, *q, *h))
    }
}

/// A head curve fitted to samples, with its doubt.
#[derive(Debug, Clone, PartialEq)]
pub struct CurveFit {
    /// The curve.
    pub curve: HeadCurve,
    /// Standard errors of c0, c1, c2 in their units, exponents taken as known; `None` for a
    /// coefficient that is held at a bound. Independent residuals assumed, so too small for rig data at 1 Hz.
    pub standard_errors: [Option<f64>; 3],
    /// Residual sum of squares over n less the coefficients that are free, m².
    pub mse_m2: f64,
    /// Share of the variance about the mean head that the curve explains. The model has no constant
    /// term, so it may be negative. NaN if the head is constant.
    pub r2: f64,
    /// Samples used.
    pub n: u64,
    /// Condition number of the column-scaled regressors: 1 is richly excited.
    pub condition: f64,
}

impl CurveFit {
    pub(crate) fn from_free(fit: &Fit, n0: f64, n2: f64) -> Self {
        Self::from_held(fit, &[], n0, n2)
    }

    /// From the fit of the coefficients that are not held; the held ones are pairs of index and
    /// value.
    pub(crate) fn from_held(fit: &Fit, held: &[(usize, f64)], n0: f64, n2: f64) -> Self {
        let mut free = fit.coefficients.iter().zip(&fit.standard_errors);
        let [c0, c1, c2] = [0, 1, 2].map(|j| match held.iter().find(|(h, _)| *h == j) {
            Some((_, value)) => (*value, None),
            None => free
                .next()
                .map_or((f64::NAN, None), |(c, se)| (*c, Some(*se))),
        });
        Self {
            curve: HeadCurve {
                c0: c0.0,
                c1: c1.0,
                c2: c2.0,
                n0,
                n2,
            },
            standard_errors: [c0.1, c1.1, c2.1],
            mse_m2: fit.mse,
            r2: fit.r2,
            n: fit.n,
            condition: fit.condition,
        }
    }
}

/// Fits c0, c1, c2 for given exponents by least squares, signs as they come: thesis Eq. 3.31 with
/// `n0 = n2 = 2`.
///
/// - `samples`: speed, flow, head and which to use.
/// - `n0`, `n2`: exponents, above 0.
///
/// # Errors
/// [`PumpError::Length`], [`PumpError::NonFinite`], [`PumpError::Negative`],
/// [`PumpError::Domain`] on an exponent, [`PumpError::Fit`] on too few rows or poor excitation
/// (condition above [`CONDITION_LIMIT`]).
///
/// # Source
/// Thesis Eqs. 3.31-3.37; recovery of a known curve: `tests/it/fit.rs`.
pub fn fit_unconstrained(samples: &Samples, n0: f64, n2: f64) -> Result<CurveFit, PumpError> {
    samples.check()?;
    check_exponents(n0, n2)?;
    let fit = reduce(samples, n0, n2)?.solve(CONDITION_LIMIT)?;
    Ok(CurveFit::from_free(&fit, n0, n2))
}

pub(crate) fn check_exponents(n0: f64, n2: f64) -> Result<(), PumpError> {
    for (name, found) in [("n0", n0), ("n2", n2)] {
        if !(found.is_finite() && found > 0.0) {
            return Err(PumpError::Domain {
                name,
                found,
                expected: "a finite exponent above 0",
            });
        }
    }
    Ok(())
}

/// Refuses a head of 0 throughout, told by any measure of its size: it says nothing of a pump, and has no scale.
pub(crate) fn check_head(size: f64) -> Result<(), PumpError> {
    if size > 0.0 {
        return Ok(());
    }
    Err(PumpError::Domain {
        name: "head_m",
        found: 0.0,
        expected: "a head other than 0 in some kept sample",
    })
}

/// The triangle of `[w^n0, -w q, -q^n2 | H]`.
pub(crate) fn reduce(samples: &Samples, n0: f64, n2: f64) -> Result<Reduced, PumpError> {
    reduce_powers(samples, |_, w, q| (power(w, n0), power(q, n2)))
}

/// The same, with the powers of the k-th kept row looked up by the caller.
pub(crate) fn reduce_powers(
    samples: &Samples,
    powers: impl Fn(usize, f64, f64) -> (f64, f64),
) -> Result<Reduced, PumpError> {
    let mut rows = Accumulator::new(NAMES)?;
    let [mut a, mut b, mut d, mut h] = [[0.0; BATCH]; 4];
    let mut filled = 0;
    let mut outcome = Ok(());
    samples.rows().enumerate().for_each(|(k, (w, q, head))| {
        let (wn, qn) = powers(k, w, q);
        (a[filled], b[filled], d[filled], h[filled]) = (wn, -w * q, -qn, head);
        filled += 1;
        if filled == BATCH && outcome.is_ok() {
            outcome = rows.push_columns(&[&a, &b, &d], &h);
            filled = 0;
        }
        filled %= BATCH;
    });
    outcome?;
    rows.push_columns(&[&a[..filled], &b[..filled], &d[..filled]], &h[..filled])?;
    Ok(rows.reduce())
}
