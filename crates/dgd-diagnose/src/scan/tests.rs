//! Claims about what is tried before anything is weighed.
#![allow(clippy::unwrap_used, reason = "a test may fail by panic")]

mod allowances;
mod places;
