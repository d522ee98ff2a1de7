//! Benches that the catalogue was not written for.
#![allow(
    missing_docs,
    clippy::unwrap_used,
    clippy::cast_precision_loss,
    reason = "tests"
)]

mod benches;
mod naming;
mod shape;
mod starts;
