//! The documents: `well.toml` and `model.toml`, with every problem told at its line, and `diagnosis.json`.
//!
//! Text in, plain structs out, and back: [`read_well`], [`write_well`], [`read_model`],
//! [`write_model`], and with the effects of a diagnosis [`read_model_document`],
//! [`write_model_document`]; what a diagnosis says: [`write_diagnosis`]; and what masking passes on and
//! keeps: [`write_masked_model`], [`read_references`], [`write_references`]. A reader tells every problem of a document at
//! once, each with its byte range, and warns of keys that it does not read. The schemas
//! stand in the README. This crate opens no file and prints nothing.
#![deny(missing_docs)]

mod augmented;
mod diagnosis;
mod error;
mod json;
mod masked;
mod model;
mod reader;
mod well;

pub use diagnosis::{DIAGNOSIS_SCHEMA, write_diagnosis};
pub use error::{DocumentError, Problem, line_and_column};
pub use masked::{read_references, write_masked_model, write_references};
pub use model::{
    Base, MODEL_SCHEMA, ModelDocument, read_model, read_model_document, write_model,
    write_model_document,
};
pub use well::{read_well, write_well};

/// The README's examples are tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
