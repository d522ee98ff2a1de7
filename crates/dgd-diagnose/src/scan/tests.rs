//! Claims about what is tried, and what it weighs.
#![allow(clippy::unwrap_used, reason = "a test may fail by panic")]

mod places;
mod weights;
