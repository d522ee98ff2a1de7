//! What the figures and the page promise.
#![allow(
    clippy::unwrap_used,
    reason = "a failed unwrap fails the test, as it should"
)]

#[path = "../../examples/gallery/diagnoses.rs"]
mod diagnoses;
#[path = "../../examples/gallery/figures.rs"]
mod figures;
#[path = "../../examples/gallery/synthetic.rs"]
mod synthetic;

mod assembly;
mod caption;
mod diagnosis;
mod hostile;
mod page;
mod png;
mod refusal;
mod svg;
