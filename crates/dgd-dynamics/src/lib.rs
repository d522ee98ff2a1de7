//! Return-line dynamics: integrators for stiff models with sampled inputs, and the two-state
//! riser-and-pump model of Slettebø (2015) that uses them.
//!
//! Start at [`return_line::simulate_coupled`] for the thesis's model or at
//! [`integrate::integrate()`] for a model of your own. SI units inside, pump speed in percent. This
//! crate estimates no parameters, reads no files and prints nothing.
#![deny(missing_docs)]

mod error;
pub mod inputs;
pub mod integrate;
pub mod return_line;

pub use error::DynamicsError;

/// Compiles the example of the README.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
