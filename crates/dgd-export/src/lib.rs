//! Recordings out: one [`Table`] to CSV, MCAP, MAT v5 or MAT v7.3.
//!
//! Start at [`write_csv`], [`write_mcap`], [`write_mat5`] or [`write_mat73`]; a [`CsvWriter`] and an [`McapWriter`]
//! take a table that comes in blocks; [`write_comparison_csv`] sets
//! measured beside two simulations, rounded; [`write_mat5_values`] writes matrices and names. Elsewhere numbers are written with
//! the digits that read back to the same `f64`, and the same table gives the same bytes
//! on every machine. Values keep their units; nothing is converted, and this crate
//! opens no file.
#![deny(missing_docs)]

mod comparison;
mod csv;
mod error;
mod mat;
mod mat5;
mod mat73;
mod mcap;
mod number;

pub use comparison::{ComparedSignal, Comparison, write_comparison_csv};
pub use csv::{CsvOptions, CsvWriter, write_csv};
pub use error::ExportError;
pub use mat::{field_names, struct_of};
pub use mat5::{MatValue, write_mat5, write_mat5_values};
pub use mat73::write_mat73;
pub use mcap::{McapOptions, McapWriter, write_mcap};

// What the functions here take, so that their user need not name the crate below.
pub use dgd_recording::{Column, Issue, Table};
use std::collections::BTreeSet;

/// Readers find a channel by its name.
pub(crate) fn check_names(table: &Table) -> Result<(), ExportError> {
    if table.columns.is_empty() {
        return Err(ExportError::NoColumns);
    }
    let mut seen = BTreeSet::new();
    match table.columns.iter().find(|c| !seen.insert(c.tag.as_str())) {
        Some(column) => Err(ExportError::NameTaken {
            tag: column.tag.clone(),
        }),
        None => Ok(()),
    }
}

/// Every block has the columns of its head.
pub(crate) fn check_width(block: &Table, expected: usize) -> Result<(), ExportError> {
    let found = block.columns.len();
    if found == expected {
        return Ok(());
    }
    Err(ExportError::Width { expected, found })
}

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;

/// A writer that nobody ends is told by the compiler.
///
/// ```compile_fail
/// #![deny(unused_must_use)]
/// # fn main() -> Result<(), dgd_export::ExportError> {
/// # let head = dgd_recording::Table::default();
/// dgd_export::CsvWriter::new(&head, &dgd_export::CsvOptions::default(), Vec::new())?;
/// # Ok(())
/// # }
/// ```
///
/// ```compile_fail
/// #![deny(unused_must_use)]
/// # fn main() -> Result<(), dgd_export::ExportError> {
/// # let head = dgd_recording::Table::default();
/// let log = std::io::Cursor::new(Vec::new());
/// dgd_export::McapWriter::new(&head, &dgd_export::McapOptions::default(), log)?;
/// # Ok(())
/// # }
/// ```
#[cfg(doctest)]
struct Unfinished;
