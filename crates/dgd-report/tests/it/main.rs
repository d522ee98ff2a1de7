//! What the figures and the page promise.
#![allow(
    clippy::unwrap_used,
    reason = "a failed unwrap fails the test, as it should"
)]

#[path = "../../examples/gallery/figures.rs"]
mod figures;
#[path = "../../examples/gallery/synthetic.rs"]
mod synthetic;

mod caption;
mod hostile;
mod page;
mod png;
mod refusal;
mod svg;
