//! Claims about the diagnosis, on recordings of the independent plant.
#![allow(clippy::unwrap_used, reason = "a test may fail by panic")]
mod naming;
mod passing;
mod refusals;
mod rig;
mod shape;
mod work;
