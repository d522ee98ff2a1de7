//! Claims about units and masking.
#![allow(clippy::unwrap_used, reason = "a test may fail by panic")]
mod mask;
mod units;
