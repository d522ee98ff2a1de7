//! Friction as a sum of powers of the flow.

use crate::FrictionError;

/// Most terms a law may have.
const MAX_TERMS: usize = 8;

/// Which powers of the flow make up the law.
#[derive(Debug, Clone, PartialEq)]
pub enum Terms {
    /// `C q + D q²`, thesis Eq. 3.14.
    Quadratic,
    /// `B + D q² + E q³`, thesis Eq. 3.26.
    OffsetCubic,
    /// Any 1 to 8 distinct powers of at least 0, whole or not, for example `[0.0, 1.75]`.
    Powers(Vec<f64>),
}

impl Terms {
    /// The powers, in the order of the coefficients.
    ///
    /// # Errors
    /// [`FrictionError::Powers`] on none, more than 8, a repeated, negative or non-finite power.
    pub fn powers(&self) -> Result<Vec<f64>, FrictionError> {
        let powers = match self {
            Self::Quadratic => vec![1.0, 2.0],
            Self::OffsetCubic => vec![0.0, 2.0, 3.0],
            Self::Powers(powers) => powers.clone(),
        };
        let legal = !powers.is_empty()
            && powers.len() <= MAX_TERMS
            && powers.iter().enumerate().all(|(i, n)| {
                n.is_finite() && *n >= 0.0 && powers[..i].iter().all(|other| other != n)
            });
        if legal {
            Ok(powers)
        } else {
            Err(FrictionError::Powers {
                found: powers.into_iter().take(MAX_TERMS + 1).collect(),
                limit: MAX_TERMS,
            })
        }
    }
}

/// A friction law `Σ c_j q^(n_j)` in SI, for flow of either sign.
///
/// Friction opposes flow, so powers are continued oddly: a term is `c · sign(q) |q|^n` (that is
/// `q`, `q|q|`, `q³`, ...). Power 0 is an offset of the pressure instruments, not friction, and
/// has no sign.
#[derive(Debug, Clone, PartialEq)]
pub struct Polynomial {
    /// Powers n_j of the flow.
    pub powers: Vec<f64>,
    /// Coefficients c_j, Pa/(m³/s)^(n_j), same shape.
    pub coefficients: Vec<f64>,
}

impl Polynomial {
    /// Friction in Pa at a flow in m³/s; NaN for a law of fewer coefficients than powers, or more.
    ///
    /// ```
    /// let law = dgd_friction::Polynomial { powers: vec![0.0, 2.0], coefficients: vec![10.0, 3.0] };
    /// assert_eq!(law.eval(2.0), 22.0);
    /// assert_eq!(law.eval(-2.0), -2.0);
    /// ```
    pub fn eval(&self, flow_m3_s: f64) -> f64 {
        if self.powers.len() != self.coefficients.len() {
            return f64::NAN;
        }
        self.terms().map(|(n, c)| c * term(flow_m3_s, n)).sum()
    }

    /// Its derivative in Pa·s/m³; even in the flow. Infinite at rest for a power between 0 and 1; NaN where [`Self::eval`] is.
    pub fn derivative(&self, flow_m3_s: f64) -> f64 {
        if self.powers.len() != self.coefficients.len() {
            return f64::NAN;
        }
        self.terms()
            .filter(|(n, _)| *n != 0.0)
            .map(|(n, c)| c * n * flow_m3_s.abs().powf(n - 1.0))
            .sum()
    }

    /// Coefficient of a power, if the law has it: `coefficient(0.0)` is B, 1 is C, 2 is D, 3 is E. The sum, as in [`Self::eval`], of a
    /// power that stands there more than once.
    pub fn coefficient(&self, power: f64) -> Option<f64> {
        let mut all = self.terms().filter(|(n, _)| *n == power);
        let (_, first) = all.next()?;
        Some(all.fold(first, |sum, (_, c)| sum + c))
    }

    /// `[B, C, D, E]` of `B + C q + D q² + E q³`, in Pa/(m³/s)^0 to Pa/(m³/s)³: 0 where the law lacks the power, and `None` where it has
    /// another, such as 1.75, or fewer coefficients than powers.
    ///
    /// That is what the friction of a simulation takes, field by field:
    ///
    /// ```
    /// use dgd_dynamics::return_line::Friction;
    /// use dgd_friction::Polynomial;
    /// let law = Polynomial { powers: vec![0.0, 2.0, 3.0], coefficients: vec![2e4, 1.2e8, 4e8] };
    /// let [b_pa, c_pa_s_m3, d_pa_s2_m6, e_pa_s3_m9] = law.cubic().ok_or("a power that no simulation has")?;
    /// let friction = Friction { b_pa, c_pa_s_m3, d_pa_s2_m6, e_pa_s3_m9 };
    /// for q in [-0.03, 0.0, 0.05] {
    ///     assert!((friction.loss_pa(q) - law.eval(q)).abs() < 1e-9);
    /// }
    /// # Ok::<(), &str>(())
    /// ```
    pub fn cubic(&self) -> Option<[f64; 4]> {
        const POWERS: [f64; 4] = [0.0, 1.0, 2.0, 3.0];
        let plain = self.powers.iter().all(|n| POWERS.contains(n));
        (plain && self.powers.len() == self.coefficients.len())
            .then(|| POWERS.map(|n| self.coefficient(n).unwrap_or(0.0)))
    }

    fn terms(&self) -> impl Iterator<Item = (f64, f64)> {
        self.powers
            .iter()
            .copied()
            .zip(self.coefficients.iter().copied())
    }
}

/// `sign(q) |q|^n`, and 1 for n = 0; whole powers without `powf`.
pub(crate) fn term(q: f64, n: f64) -> f64 {
    if n == 0.0 {
        1.0
    } else if n == 1.0 {
        q
    } else if n == 2.0 {
        q * q.abs()
    } else if n == 3.0 {
        q * q * q
    } else {
        q.abs().powf(n).copysign(q)
    }
}

/// [`term`] of a whole column; the power is looked at once, so the loops vectorise.
pub(crate) fn fill_terms(out: &mut [f64], q: &[f64], n: f64) {
    let pairs = out.iter_mut().zip(q);
    if n == 1.0 {
        pairs.for_each(|(x, q)| *x = *q);
    } else if n == 2.0 {
        pairs.for_each(|(x, q)| *x = q * q.abs());
    } else if n == 3.0 {
        pairs.for_each(|(x, q)| *x = q * q * q);
    } else {
        pairs.for_each(|(x, q)| *x = term(*q, n));
    }
}

/// Names of the columns, as they appear in refusals.
pub(crate) fn column_names(powers: &[f64]) -> Vec<String> {
    powers
        .iter()
        .map(|n| match *n {
            0.0 => "1".to_owned(),
            1.0 => "q".to_owned(),
            n => format!("q^{n}"),
        })
        .collect()
}
