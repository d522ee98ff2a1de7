//! Numbers with one derivative, so that a law is written once and Newton's slope is exact.

use std::ops::{Add, Div, Mul, Neg, Sub};

/// A value and its derivative by the law's argument (a flow, or a pressure rise).
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Dual {
    /// Value.
    pub v: f64,
    /// Derivative.
    pub d: f64,
}

impl Dual {
    /// The argument itself.
    #[must_use]
    #[inline(always)]
    pub const fn variable(v: f64) -> Self {
        Self { v, d: 1.0 }
    }

    /// A number that does not depend on the argument.
    #[must_use]
    #[inline(always)]
    pub const fn constant(v: f64) -> Self {
        Self { v, d: 0.0 }
    }

    /// Square root, of a positive number.
    #[must_use]
    #[inline(always)]
    pub fn sqrt(self) -> Self {
        let root = self.v.sqrt();
        Self {
            v: root,
            d: 0.5 * self.d / root,
        }
    }

    /// Absolute value.
    #[must_use]
    #[inline(always)]
    pub fn abs(self) -> Self {
        if self.v < 0.0 { -self } else { self }
    }

    /// `self^n` of a positive number.
    #[must_use]
    #[inline(always)]
    pub fn powf(self, n: f64) -> Self {
        let power = self.v.powf(n);
        let slope = if self.v > 0.0 {
            n * power / self.v
        } else if n == 1.0 {
            1.0
        } else {
            0.0
        };
        Self {
            v: power,
            d: slope * self.d,
        }
    }

    /// `|self|^n` with the sign of `self`.
    #[must_use]
    #[inline(always)]
    pub fn signed_pow(self, n: f64) -> Self {
        if self.v < 0.0 {
            -(-self).powf(n)
        } else {
            self.powf(n)
        }
    }

    /// Exponential.
    #[must_use]
    #[inline(always)]
    pub fn exp(self) -> Self {
        let e = self.v.exp();
        Self {
            v: e,
            d: e * self.d,
        }
    }

    /// Natural logarithm, of a positive number.
    #[must_use]
    #[inline(always)]
    pub fn ln(self) -> Self {
        Self {
            v: self.v.ln(),
            d: self.d / self.v,
        }
    }

    /// Hyperbolic tangent.
    #[must_use]
    #[inline(always)]
    pub fn tanh(self) -> Self {
        let t = self.v.tanh();
        Self {
            v: t,
            d: (1.0 - t * t) * self.d,
        }
    }
}

impl From<f64> for Dual {
    #[inline(always)]
    fn from(v: f64) -> Self {
        Self::constant(v)
    }
}

impl Neg for Dual {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self {
            v: -self.v,
            d: -self.d,
        }
    }
}

impl Add for Dual {
    type Output = Self;
    #[inline(always)]
    fn add(self, o: Self) -> Self {
        Self {
            v: self.v + o.v,
            d: self.d + o.d,
        }
    }
}

impl Sub for Dual {
    type Output = Self;
    #[inline(always)]
    fn sub(self, o: Self) -> Self {
        Self {
            v: self.v - o.v,
            d: self.d - o.d,
        }
    }
}

impl Mul for Dual {
    type Output = Self;
    #[inline(always)]
    fn mul(self, o: Self) -> Self {
        Self {
            v: self.v * o.v,
            d: self.d * o.v + self.v * o.d,
        }
    }
}

impl Div for Dual {
    type Output = Self;
    #[inline(always)]
    fn div(self, o: Self) -> Self {
        let v = self.v / o.v;
        Self {
            v,
            d: (self.d - v * o.d) / o.v,
        }
    }
}

macro_rules! with_number {
    ($($trait:ident $method:ident),*) => {$(
        impl $trait<f64> for Dual {
            type Output = Self;
            #[inline(always)]
            fn $method(self, o: f64) -> Self {
                $trait::$method(self, Self::constant(o))
            }
        }
        impl $trait<Dual> for f64 {
            type Output = Dual;
            #[inline(always)]
            fn $method(self, o: Dual) -> Dual {
                $trait::$method(Dual::constant(self), o)
            }
        }
    )*};
}
with_number!(Add add, Sub sub, Mul mul, Div div);

#[cfg(test)]
mod tests {
    use super::Dual;

    #[test]
    fn derivatives_agree_with_central_differences() {
        let f = |x: Dual| {
            (x * x + 3.0).sqrt() / (1.0 + (0.3 * x).exp()) + x.abs().powf(1.7) - (2.0 * x).tanh()
                + x.signed_pow(1.4) * (x * x + 1.0).ln()
        };
        for x in [-2.1, -0.4, 0.3, 1.9] {
            let h = 1e-6;
            let by_difference =
                (f(Dual::constant(x + h)).v - f(Dual::constant(x - h)).v) / (2.0 * h);
            assert!((f(Dual::variable(x)).d - by_difference).abs() < 1e-8, "{x}");
        }
    }
}
