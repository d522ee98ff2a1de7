//! Written values such as `"19.5 in"`, typed by what they measure.

use crate::{Dimension, Unit, UnitError};
use std::fmt;
use std::str::FromStr;

/// Splits `"13 5/8 in"` into the number 13.625 and the unit `"in"`.
///
/// The number may be a decimal (`19.5`, `-1e3`), a fraction (`5/8`) or a whole
/// number and a fraction, as pipe sizes are written (Table 2.2).
///
/// # Errors
/// [`UnitError::NoNumber`] if the text does not begin with a finite number,
/// [`UnitError::Comma`] if a comma stands in it: `1,080` is 1.08 to some and 1080 to others.
pub fn split_number(text: &str) -> Result<(f64, &str), UnitError> {
    let no_number = || UnitError::NoNumber {
        found: text.chars().take(40).collect(),
    };
    let trimmed = text.trim();
    let (whole, rest) = take_decimal(trimmed).ok_or_else(no_number)?;
    if rest
        .strip_prefix(',')
        .is_some_and(|after| after.starts_with(|c: char| c.is_ascii_digit()))
    {
        return Err(UnitError::Comma {
            found: text.chars().take(40).collect(),
        });
    }
    if let Some((denominator, rest)) = rest.strip_prefix('/').and_then(take_decimal)
        && denominator != 0.0
    {
        return Ok((whole / denominator, rest.trim()));
    }
    let after_space = rest.trim_start();
    if let Some((numerator, tail)) = take_decimal(after_space)
        && after_space.len() < rest.len()
        && let Some((denominator, rest)) = tail.strip_prefix('/').and_then(take_decimal)
        && denominator != 0.0
    {
        let fraction = numerator / denominator;
        return Ok((
            // `-0 1/2` too.
            if whole.is_sign_negative() {
                whole - fraction
            } else {
                whole + fraction
            },
            rest.trim(),
        ));
    }
    Ok((whole, rest.trim()))
}

/// The longest decimal at the start of `text`, and what follows it.
fn take_decimal(text: &str) -> Option<(f64, &str)> {
    let bytes = text.as_bytes();
    let digits = |mut i: usize| {
        while bytes.get(i).is_some_and(u8::is_ascii_digit) {
            i += 1;
        }
        i
    };
    let sign = usize::from(bytes.first().is_some_and(|b| matches!(b, b'+' | b'-')));
    let mut end = digits(sign);
    if bytes.get(end) == Some(&b'.') {
        end = digits(end + 1);
    }
    if bytes.get(end).is_some_and(|b| matches!(b, b'e' | b'E')) {
        let exponent =
            end + 1 + usize::from(bytes.get(end + 1).is_some_and(|b| matches!(b, b'+' | b'-')));
        if digits(exponent) > exponent {
            end = digits(exponent);
        }
    }
    let value: f64 = text[..end].parse().ok()?;
    value.is_finite().then_some((value, &text[end..]))
}

fn parse_si(text: &str, dimension: Dimension, example: &'static str) -> Result<f64, UnitError> {
    let (number, unit) = split_number(text)?;
    if unit.is_empty() {
        return Err(UnitError::NoUnit {
            found: text.chars().take(40).collect(),
            example,
        });
    }
    Ok(Unit::parse_as(unit, dimension)?.to_si(number))
}

macro_rules! quantity {
    ($(#[$doc:meta])* $name:ident, $dimension:ident, $example:literal) => {
        $(#[$doc])*
        #[derive(Debug, Clone, Copy, PartialEq, PartialOrd)]
        pub struct $name(f64);

        impl $name {
            /// From a value in SI units.
            pub const fn from_si(si: f64) -> Self {
                Self(si)
            }

            /// The value in SI units.
            pub const fn si(self) -> f64 {
                self.0
            }

            #[doc = concat!("Reads a written value such as `\"", $example, "\"`.")]
            ///
            /// # Errors
            /// [`UnitError`], saying whether the number, the unit or its dimension is off.
            pub fn parse(text: &str) -> Result<Self, UnitError> {
                parse_si(text, Dimension::$dimension, $example).map(Self)
            }

            /// The value in `unit`.
            ///
            /// # Errors
            /// [`UnitError::WrongDimension`] if `unit` measures something else.
            pub fn to_unit(self, unit: Unit) -> Result<f64, UnitError> {
                Ok(unit.of(Dimension::$dimension)?.from_si(self.0))
            }
        }

        impl FromStr for $name {
            type Err = UnitError;

            fn from_str(text: &str) -> Result<Self, UnitError> {
                Self::parse(text)
            }
        }

        impl fmt::Display for $name {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                fmt::Display::fmt(&self.0, f)?;
                write!(f, " {}", Dimension::$dimension.si_symbol())
            }
        }
    };
}

quantity!(
    /// A length or depth, held in m.
    Length, Length, "19.5 in"
);
quantity!(
    /// A pressure, held in Pa absolute.
    Pressure, Pressure, "14.7 psia"
);
quantity!(
    /// A volume flow rate, held in m³/s.
    FlowRate, FlowRate, "600 gpm"
);
quantity!(
    /// A density, held in kg/m³.
    Density, Density, "1.08 sg"
);
