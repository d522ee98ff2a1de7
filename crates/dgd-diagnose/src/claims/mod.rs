//! What the arithmetic of single files promises, on records made for it.
#![allow(clippy::unwrap_used, reason = "a test may fail by panic")]

mod answer;
mod belief;
pub(crate) mod fixture;
mod names;
mod refine;
mod search;
mod slack;
mod unrest;
mod vectors;
