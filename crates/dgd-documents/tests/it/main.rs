//! Claims about `well.toml`, `model.toml`, `diagnosis.json` and the references of a mask.
#![allow(clippy::unwrap_used, reason = "a test may fail by panic")]
mod augmented;
mod diagnosis;
mod fuzz;
mod masked;
mod mistaken;
mod model;
mod readme;
mod seeds;
mod system;
mod well;

#[path = "../../../fuzz/src/documents.rs"]
#[allow(unreachable_pub, reason = "the fuzz targets call it too")]
mod claims;
#[path = "../../../fuzz/stable/mutation.rs"]
mod mutation;
