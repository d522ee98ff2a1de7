//! Claims about `well.toml`, `model.toml`, `diagnosis.json` and the references of a mask.
#![allow(clippy::unwrap_used, reason = "a test may fail by panic")]
mod augmented;
mod diagnosis;
mod fuzz;
mod masked;
mod model;
mod readme;
mod system;
mod well;
