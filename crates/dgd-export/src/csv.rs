//! CSV text.

use crate::ExportError;
use crate::number::push;
use dgd_recording::Table;
use std::io::Write;

/// How to write a CSV file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct CsvOptions {
    /// Write a second row with the units, if any column has one. Default: yes.
    pub units_row: bool,
}

impl Default for CsvOptions {
    fn default() -> Self {
        Self { units_row: true }
    }
}

/// Writes a table as comma separated text: names, units, then one line a sample.
///
/// Numbers have the fewest digits that read back to the same `f64`; NaN is an empty
/// cell, and so is what a shorter column lacks. Lines end in LF. `origin` and `issues`
/// have no place in the format and are left out.
///
/// # Errors
/// [`ExportError::NoColumns`], [`ExportError::NameTaken`] or [`ExportError::Io`].
///
/// ```
/// use dgd_export::{CsvOptions, write_csv};
/// use dgd_recording::{Column, Table};
/// let column = |tag: &str, unit: &str, values: &[f64]| Column {
///     tag: tag.into(), unit: Some(unit.into()), values: values.to_vec(),
/// };
/// let columns = vec![column("t", "s", &[0.0, 1.0]), column("FT4", "gpm", &[796.5, f64::NAN])];
/// let table = Table { columns, ..Table::default() };
/// let mut text = Vec::new();
/// write_csv(&table, &CsvOptions::default(), &mut text)?;
/// assert_eq!(text, b"t,FT4\ns,gpm\n0,796.5\n1,\n");
/// # Ok::<(), dgd_export::ExportError>(())
/// ```
pub fn write_csv(
    table: &Table,
    options: &CsvOptions,
    mut writer: impl Write,
) -> Result<(), ExportError> {
    const FLUSHED_AT: usize = 1 << 16;
    crate::check_names(table)?;
    let mut text = Vec::with_capacity(FLUSHED_AT + 4096);
    let tags = table.columns.iter().map(|c| c.tag.as_str());
    line(&mut text, tags);
    let has_units = table.columns.iter().any(|c| c.unit.is_some());
    if options.units_row && has_units {
        line(
            &mut text,
            table
                .columns
                .iter()
                .map(|c| c.unit.as_deref().unwrap_or_default()),
        );
    }
    for row in 0..table.rows() {
        let start = text.len();
        for (index, column) in table.columns.iter().enumerate() {
            if index > 0 {
                text.push(b',');
            }
            match column.values.get(row) {
                Some(value) if !value.is_nan() => push(&mut text, *value),
                _ => {}
            }
        }
        if text.len() == start {
            // The only column, and nothing in it: a blank line would be no row.
            text.extend_from_slice(b"NaN");
        } else if row + 1 == table.rows() && text[start..].iter().all(|b| *b == b',') {
            // Readers take an empty last line for none.
            text.splice(start..start, *b"NaN");
        }
        text.push(b'\n');
        if text.len() >= FLUSHED_AT {
            writer.write_all(&text)?;
            text.clear();
        }
    }
    writer.write_all(&text)?;
    writer.flush()?;
    Ok(())
}

fn line<'a>(text: &mut Vec<u8>, cells: impl Iterator<Item = &'a str>) {
    for (index, cell) in cells.enumerate() {
        if index > 0 {
            text.push(b',');
        }
        let special = |c: char| matches!(c, ',' | ';' | '\t' | '"' | '\n' | '\r');
        if cell.contains(special) || cell.trim() != cell {
            text.push(b'"');
            text.extend_from_slice(cell.replace('"', "\"\"").as_bytes());
            text.push(b'"');
        } else {
            text.extend_from_slice(cell.as_bytes());
        }
    }
    text.push(b'\n');
}
