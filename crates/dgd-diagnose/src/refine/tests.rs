//! Claims about how the parameters of named effects are moved.
#![allow(clippy::unwrap_used, reason = "a test may fail by panic")]

mod moves;
mod nearest;
mod starts;
