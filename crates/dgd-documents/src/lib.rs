//! The documents: `well.toml` and `model.toml`, with every problem told at its line, and `diagnosis.json`.
//!
//! Text in, plain structs out, and back: [`read_well`], [`write_well`], [`read_model`],
//! [`write_model`], and with the effects of a diagnosis [`read_model_document`],
//! [`write_model_document`]; what a diagnosis says: [`write_diagnosis`]; and what masking passes on and
//! keeps: [`write_masked_model`], [`read_references`], [`write_references`]. Systems of any components, with their fit:
//! [`read_system`], [`write_fitted_system`]. A reader tells every problem of a document at
//! once, each with its byte range, and warns of keys that it does not read. The schemas
//! stand in the README. This crate opens no file and prints nothing.
#![deny(missing_docs)]

mod augmented;
mod diagnosis;
mod error;
mod json;
mod masked;
mod mistaken;
mod model;
mod reader;
mod system;
mod well;

pub use diagnosis::{DIAGNOSIS_SCHEMA, write_diagnosis};
pub use error::{DocumentError, Problem, line_and_column};
pub use masked::{read_references, write_masked_model, write_references};
pub use model::{
    Base, MODEL_SCHEMA, ModelDocument, read_model, read_model_document, write_model,
    write_model_document,
};
pub use system::{
    FITTED_SCHEMA, FittedParameter, FittedSystem, SystemDocument, read_system, read_system_types,
    return_line_system, write_fitted_system,
};
pub use well::{read_well, well_line, write_well};

/// The README's examples are tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
