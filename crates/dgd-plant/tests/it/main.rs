//! What the plant's recordings promise.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod benches;
mod binary;
mod cases;
mod conceal;
mod faults;
mod files;
mod ladder;
mod physics;
mod refusals;
mod solver;
