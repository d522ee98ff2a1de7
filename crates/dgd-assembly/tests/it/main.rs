//! Public behaviour of the crate.
#![allow(clippy::unwrap_used, reason = "tests")]

mod common;
mod composed;
mod dual_gradient;
mod effects;
mod fitting;
mod hostile;
mod local;
mod physics;
mod running;
mod structure;
