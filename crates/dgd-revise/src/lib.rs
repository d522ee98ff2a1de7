//! What a hydraulic assembly leaves out: located, named, modelled, shown on held-out data; or nothing; or something that
//! the catalogue does not hold.
//!
//! Start at [`revise`]: an assembly and the columns of its record in, a [`Revision`] out. Its chain, each step with its
//! reason:
//!
//! 1. **Baseline**: all free parameters and initial states fitted again from several starts. What a re-fit removes needs
//!    no new physics.
//! 2. **Screening**: each effect on each component at a grid of strengths and shapes, as a change of the readings off the
//!    tangent of that fit.
//! 3. **Gate**: whether the greatest of all scores is more than chance, against the same residual with signs of blocks
//!    drawn anew.
//! 4. **Sets**: singles, all pairs of the best few and the pairs that promise most together, then greedily more, each
//!    re-fitted with all base parameters. Two effects can hide each other.
//! 5. **Choice** by left-out blocks inside the training part, the smallest set that a larger one does not clearly better. A
//!    cause that halves the training error and worsens left-out blocks is none.
//! 6. **Classes**: what does as well in a member's place cannot be told apart, and is said so.
//! 7. **Abstention**: a piecewise linear correction without physics competes; where it clearly wins the cause is `unknown`.
//! 8. **Confirmation**, once, on the test part; what does not stand there is not claimed.
//! 9. **Sections**, for relations: whether cause and parameters hold along the independent variable.
//!
//! Absent: reading of files, documents, reports; the catalogue itself (`dgd-assembly`). This crate opens no file, prints
//! nothing and knows no data set.
#![deny(missing_docs)]
#![allow(
    clippy::cast_precision_loss,
    reason = "counts of samples are far below 2^53"
)]

mod baseline;
mod belief;
mod blocks;
mod chain;
mod checks;
mod choice;
mod conclude;
mod confirm;
mod context;
mod draws;
mod empirical;
mod error;
mod estimates;
mod findings;
mod floor;
mod held;
mod locate;
mod noise;
mod parallel;
mod revision;
mod screen;
mod sections;
mod sets;
mod stack;
mod strength;
mod tangent;
mod validate;

pub use chain::revise;
pub use error::ReviseError;
pub use revision::{
    Check, Class, Contender, Estimate, Excuse, Finding, Model, Options, Outcome, OutputGain,
    Region, Revision, Section, Shape, Signal, Stage, Tested, Trace, Verdict,
};

/// The README's examples are tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
