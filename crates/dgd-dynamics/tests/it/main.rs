//! Claims about the integrators, the inputs and the return line.
#![allow(
    clippy::unwrap_used,
    clippy::cast_precision_loss,
    reason = "tests fail by panicking, and count small numbers"
)]

mod against_diffsol;
mod common;
mod finished;
mod integrators;
mod parts;
mod refusals;
mod return_line;
mod steady;
mod steps;
