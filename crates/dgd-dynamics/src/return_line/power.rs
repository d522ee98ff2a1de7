//! `x^n` for `x ≥ 0` and a fixed exponent, cheap near a reference point.
//!
//! Within one second of a recording neither speed nor flow moves far, and the library power
//! function would take most of a simulation's time. Near a reference `r`,
//! `x^n = r^n·(1 + e)^n` with `e = x/r − 1`, and nine terms of the binomial series leave less than
//! one unit of round-off for `|e| ≤ 1/32`. Farther off the library function is called.

/// Terms beyond the constant one.
const TERMS: usize = 8;
const NEAR: f64 = 1.0 / 32.0;

/// An exponent with its binomial coefficients.
#[derive(Debug, Clone, Copy)]
pub(super) struct Power {
    exponent: f64,
    binomial: [f64; TERMS],
    near: f64,
}

/// A reference point of a [`Power`].
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Reference {
    inverse: f64,
    value: f64,
}

impl Power {
    pub(super) fn new(exponent: f64) -> Self {
        let mut binomial = [0.0; TERMS];
        let mut term = 1.0;
        let mut k = 0.0;
        for b in &mut binomial {
            term *= (exponent - k) / (k + 1.0);
            *b = term;
            k += 1.0;
        }
        // With larger exponents the ninth term no longer vanishes.
        let near = if exponent <= 5.0 { NEAR } else { 0.0 };
        Self {
            exponent,
            binomial,
            near,
        }
    }

    /// Moves the reference to `x` unless it is near already; at zero (or if `x^n` under- or
    /// overflows) there is none. Its value always comes from the library function, so that
    /// round-off cannot creep along a recording.
    #[inline(always)]
    pub(super) fn refer(&self, x: f64, reference: &mut Reference) {
        if (x * reference.inverse - 1.0).abs() <= 0.25 * self.near {
            return;
        }
        let value = x.powf(self.exponent);
        let inverse = 1.0 / x;
        *reference = if inverse.is_finite() && value.is_normal() {
            Reference { inverse, value }
        } else {
            Reference::default()
        };
    }

    /// `x^n`.
    #[inline(always)]
    pub(super) fn at(&self, x: f64, reference: &Reference) -> f64 {
        let off = self.off(x, reference);
        if self.is_near(off) {
            self.parts(off, reference).sum()
        } else {
            x.powf(self.exponent)
        }
    }

    /// How far `x` is off its reference, as a share of it; −1 without a reference.
    #[inline(always)]
    pub(super) fn off(&self, x: f64, reference: &Reference) -> f64 {
        x * reference.inverse - 1.0
    }

    /// Whether the series reaches there; never without a reference.
    #[inline(always)]
    pub(super) fn is_near(&self, off: f64) -> bool {
        off.abs() <= self.near
    }

    /// `x^n` in the parts of its series, where that [reaches](Self::is_near).
    #[inline(always)]
    pub(super) fn parts(&self, off: f64, reference: &Reference) -> Parts {
        let (b, e) = (&self.binomial, off);
        let square = e * e;
        Parts {
            value: reference.value,
            first: reference.value * e,
            square,
            low: b[0] + b[1] * e,
            middle: b[2] + b[3] * e,
            high: (b[4] + b[5] * e) + (b[6] + b[7] * e) * square,
        }
    }
}

/// A power is `value + first·(low + square·middle + square²·high)`.
///
/// The stages of a step wait for each other, and each waits for a power: whoever uses it takes in
/// each part as it comes.
#[derive(Debug, Clone, Copy)]
pub(super) struct Parts {
    pub(super) value: f64,
    pub(super) first: f64,
    pub(super) square: f64,
    pub(super) low: f64,
    pub(super) middle: f64,
    pub(super) high: f64,
}

impl Parts {
    #[inline(always)]
    pub(super) fn sum(&self) -> f64 {
        let low = self.low + self.middle * self.square;
        self.value + self.first * (low + self.high * (self.square * self.square))
    }
}

/// A [`Power`] whose reference follows a series.
pub(super) struct Following {
    power: Power,
    reference: Reference,
}

impl Following {
    pub(super) fn new(exponent: f64) -> Self {
        Self {
            power: Power::new(exponent),
            reference: Reference::default(),
        }
    }

    /// `x^n` of the next value.
    #[inline]
    pub(super) fn at(&mut self, x: f64) -> f64 {
        self.power.refer(x, &mut self.reference);
        self.power.at(x, &self.reference)
    }
}

#[cfg(test)]
mod tests {
    use super::{Following, Power, Reference};

    #[test]
    fn a_power_that_follows_a_series_agrees_with_the_library_over_jumps_and_standstill() {
        let mut power = Following::new(1.6243);
        for k in 0..2000 {
            let wave = 0.05 + 0.03 * (f64::from(k) * 0.01).sin();
            let x = if k % 500 < 20 { 0.0 } else { wave };
            let expected = x.powf(1.6243);
            let off = (power.at(x) - expected).abs();
            assert!(off <= 6.0 * f64::EPSILON * expected, "{x}: {off:e}");
        }
    }

    #[test]
    fn the_series_agrees_with_the_library_to_round_off() {
        for n in [1.0, 1.6243, 1.9546, 2.0, 2.5, 3.7, 5.0, 7.3] {
            let power = Power::new(n);
            for r in [0.057, 1.0, 63.0] {
                let mut reference = Reference::default();
                power.refer(r, &mut reference);
                for k in -40..=40 {
                    let x = r * (1.0 + f64::from(k) / 1000.0);
                    let (found, expected) = (power.at(x, &reference), x.powf(n));
                    let off = (found / expected - 1.0).abs();
                    assert!(off < 6.0 * f64::EPSILON, "n {n}, x {x}: {off:e}");
                }
            }
        }
    }

    #[test]
    fn a_reference_stays_until_the_base_has_left_its_quarter() {
        let power = Power::new(1.6);
        let mut reference = Reference::default();
        // A quarter of a 32nd is 0.0078.
        for (x, at) in [
            (2.0, 2.0_f64),
            (2.015, 2.0),
            (1.985, 2.0),
            (2.017, 2.017),
            (1.9, 1.9),
        ] {
            power.refer(x, &mut reference);
            assert_eq!(reference.value, at.powf(1.6), "{x}");
        }
        power.refer(0.0, &mut reference);
        assert_eq!((reference.value, reference.inverse), (0.0, 0.0));
    }

    #[test]
    fn far_from_its_reference_a_power_is_the_library_s() {
        let power = Power::new(1.6);
        for r in [0.02, 0.5, 1.0, 60.0, 1e250] {
            let mut reference = Reference::default();
            power.refer(r, &mut reference);
            for x in [0.0, 0.02, 0.5, 1.0 / r, 2.0, 60.0, 1e250_f64] {
                let (found, expected) = (power.at(x, &reference), x.powf(1.6));
                assert!(x == r || found == expected, "{x} from {r}: {found}");
            }
        }
        // What overflows has no reference.
        let mut reference = Reference::default();
        power.refer(1e250, &mut reference);
        assert_eq!(power.at(1e250, &reference), f64::INFINITY);
    }

    #[test]
    fn zero_and_tiny_bases_need_no_reference() {
        let power = Power::new(1.6);
        for x in [0.0, f64::MIN_POSITIVE, 5e-324] {
            let mut reference = Reference::default();
            power.refer(x, &mut reference);
            assert_eq!(power.at(x, &reference), x.powf(1.6));
            assert_eq!(power.at(0.02, &reference), 0.02_f64.powf(1.6));
        }
    }
}
