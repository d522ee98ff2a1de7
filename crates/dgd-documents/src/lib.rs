//! The TOML documents: `well.toml` and `model.toml`, with every problem told at its line.
//!
//! Text in, plain structs out, and back: [`read_well`], [`write_well`], [`read_model`],
//! [`write_model`]; and what masking passes on and keeps: [`write_masked_model`],
//! [`read_references`], [`write_references`]. A reader tells every problem of a document at
//! once, each with its byte range, and warns of keys that it does not read. The schemas
//! stand in the README. This crate opens no file and prints nothing.
#![deny(missing_docs)]

mod error;
mod masked;
mod model;
mod reader;
mod well;

pub use error::{DocumentError, Problem, line_and_column};
pub use masked::{read_references, write_masked_model, write_references};
pub use model::{MODEL_SCHEMA, read_model, write_model};
pub use well::{read_well, write_well};

/// The README's examples are tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
