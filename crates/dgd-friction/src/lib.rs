//! Friction in a line: Darcy-Weisbach, polynomial fits and the delay of the flow meter.
//!
//! Start at [`delay_sweep`] for a recording, at [`fit`] if the delay is known, and at
//! [`observed_friction`] to get the friction out of an outlet pressure. [`Polynomial`] evaluates
//! a fitted law for flow of either sign. [`darcy_weisbach`] is the textbook law for a pipe of
//! known geometry and fluid.
//!
//! Everything is SI: flow in m³/s, pressure in Pa, length in m. This crate opens no file and
//! prints nothing. Absent: rules about which samples are trustworthy (the caller gives `keep`),
//! non-Newtonian fluids, and any dynamics.
#![deny(missing_docs)]

mod error;
mod fit;
mod pipe;
mod polynomial;
mod sums;
mod sweep;

pub use dgd_lsq::{LsqError, RobustOptions, RobustStatus};
pub use error::FrictionError;
pub use fit::{CONDITION_LIMIT, Loss, PolynomialFit, Reweighting, Samples, fit};
pub use pipe::{
    Pipe, RE_CRIT, bit_loss, darcy_weisbach, friction_factor, observed_friction, reynolds,
};
pub use polynomial::{Polynomial, Terms};
pub use sweep::{DelayScan, DelaySweep, Minimum, SweepOptions, delay_scan, delay_sweep};

/// The example of the README compiles.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
