//! Claims about what masked data say and what they do not.
#![allow(clippy::unwrap_used, reason = "a test may fail by panic")]
mod adversary;
mod masking;
mod rig;
mod scale;
