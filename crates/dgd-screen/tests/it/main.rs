//! Claims about screening.
#![allow(clippy::unwrap_used, reason = "a test may fail by panic")]
mod blocks;
mod plausible;
mod redundant;
mod robust;
mod rules;
mod speed;
mod spikes;
mod stuck;
mod synthetic;
