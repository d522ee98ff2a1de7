//! Units of the rig floor, converted to SI once, and the masking of
//! confidential values.
//!
//! Start at [`Unit::parse`] and [`Unit::to_si`] for a column of numbers, at
//! [`Length::parse`] (or another quantity) for a written value such as
//! `"19.5 in"`, at [`MaskReferences`] for percentages of undisclosed values, and at
//! [`Legible`] for how people read what is held in SI.
//! This crate opens no file, prints nothing and knows no channel names.
//!
//! ```
//! use dgd_units::{Length, Unit};
//! let psi = Unit::parse("psia")?;
//! assert_eq!(psi.to_si(1.0), 6894.75729);
//! assert!((Length::parse("13 5/8 in")?.si() - 0.346_075).abs() < 1e-12);
//! # Ok::<(), dgd_units::UnitError>(())
//! ```
#![deny(missing_docs)]

mod error;
mod legible;
mod mask;
mod quantity;
mod unit;

pub use error::UnitError;
pub use legible::Legible;
pub use mask::{FullScale, MaskError, MaskReferences};
pub use quantity::{Density, FlowRate, Length, Pressure, split_number};
#[doc(hidden)]
pub use unit::edit_distance;
pub use unit::{Dimension, PressureReference, Unit};

/// Standard atmosphere, Pa: the p0 of the thesis and the zero of gauge pressure.
pub const STANDARD_ATMOSPHERE_PA: f64 = 101_325.0;

/// Standard gravity, m/s² (CGPM 1901).
pub const STANDARD_GRAVITY_M_S2: f64 = 9.806_65;

/// Density of the water that specific gravity refers to, kg/m³.
pub const WATER_DENSITY_KG_M3: f64 = 1000.0;

/// The example of the README compiles.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
