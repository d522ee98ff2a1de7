//! Claims about the `dgd` binary: what it writes, what it refuses, what it never tells.
#![allow(clippy::unwrap_used, reason = "a test may fail by panic")]
#![allow(clippy::print_stdout, reason = "a skipped test says so")]
mod bad_data;
mod bench;
mod demo;
mod diagnosing;
mod exam;
mod formats;
mod masking;
mod outputs;
mod refusals;
mod simulating;
mod systems;
