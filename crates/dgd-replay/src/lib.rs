//! A model run beside a recording: inputs from the recording, simulated beside
//! measured.
//!
//! [`replay`] runs one of the four simulations of chapter 4 over a window of a
//! recording and returns measured and simulated series on the same clock. The
//! recording's untrusted samples are NaN; where an input is missing it is
//! interpolated, and the result says how much. This crate opens no file.
#![deny(missing_docs)]

mod blocks;
mod fill;
mod outcome;
mod run;

pub use blocks::BlockReplay;
// What the functions here take and return, so that their user need not name the crates below.
pub use dgd_dynamics::DynamicsError;
pub use dgd_dynamics::integrate::{Method, Statistics, Status};
pub use dgd_dynamics::return_line::{
    Friction, PumpHead, ReturnLine, RiserBounds, SimulationOptions,
};
pub use dgd_recording::Recording;
pub use fill::fill_gaps;
pub use outcome::{Deviation, DeviationSums, Pair, Replay};
pub use run::{Kind, ReplayError, ReplayOptions, Start, replay};

/// The README's examples are tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
