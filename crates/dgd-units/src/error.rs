//! Why a written unit or value was refused.

use crate::Dimension;

/// Why a written unit or value was refused.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum UnitError {
    /// The unit is not in the table of [`crate::Unit::known`].
    #[error("unknown unit `{found}`{}", suggestion.map(|s| format!("; did you mean `{s}`?")).unwrap_or_default())]
    UnknownUnit {
        /// What was written.
        found: String,
        /// The nearest known spelling, if one is near.
        suggestion: Option<&'static str>,
    },
    /// The unit measures something else.
    #[error("`{found}` is a unit of {is}, expected a unit of {expected} such as `{example}`")]
    WrongDimension {
        /// What was written.
        found: String,
        /// What the unit measures.
        is: Dimension,
        /// What was needed.
        expected: Dimension,
        /// A unit that would do.
        example: &'static str,
    },
    /// The number in front of the unit cannot be read.
    #[error(
        "`{found}` does not begin with a number; write a value and its unit, such as `19.5 in`"
    )]
    NoNumber {
        /// What was written.
        found: String,
    },
    /// A comma in the number.
    #[error(
        "`{found}` has a comma in its number; write a decimal point and no thousands separator"
    )]
    Comma {
        /// What was written.
        found: String,
    },
    /// A number without a unit.
    #[error("`{found}` has no unit; write a value and its unit, such as `{example}`")]
    NoUnit {
        /// What was written.
        found: String,
        /// A value that would do.
        example: &'static str,
    },
    /// A volume that no stroke can have.
    #[error("a stroke displaces {found_m3} m3, expected a positive number")]
    Stroke {
        /// The volume, m³.
        found_m3: f64,
    },
    /// A reading that cannot stand for 100 %.
    #[error("100 % is {found}, expected a positive number")]
    Full {
        /// The reading.
        found: f64,
    },
}
