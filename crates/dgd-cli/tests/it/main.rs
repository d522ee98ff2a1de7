//! Claims about the `dgd` binary: what it writes, what it refuses, what it never tells.
#![allow(clippy::unwrap_used, reason = "a test may fail by panic")]
#![allow(clippy::print_stdout, reason = "a skipped test says so")]
mod adversary;
mod bad_data;
mod bench;
mod blocks;
mod demo;
mod determinism;
mod diagnosing;
mod exam;
#[cfg(unix)]
mod faults;
mod formats;
#[cfg(unix)]
mod killed;
mod masking;
mod outputs;
mod profiles;
mod refusals;
mod simulating;
mod six_states;
mod systems;
mod words;
