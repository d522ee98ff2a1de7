//! Claims about the ladder from a recording to a model.
#![allow(clippy::unwrap_used, reason = "a test may fail by panic")]
mod excitation;
mod preparation;
mod recovery;
mod refusals;
mod rig;
mod symmetries;
