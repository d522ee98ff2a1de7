//! Claims about the simulations beside a recording.
#![allow(clippy::unwrap_used, reason = "a test may fail by panic")]
mod blocks;
mod closed_loop;
mod fill;
mod rig;
mod symmetries;
mod window;
