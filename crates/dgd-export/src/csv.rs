//! CSV text.

use crate::ExportError;
use crate::number::push;
use dgd_recording::{Column, Table};
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
/// cell, and so is what a shorter column lacks; rows without any value above the first one, and at the end, begin with `NaN`. Lines end in LF. `origin` and `issues`
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
    writer: impl Write,
) -> Result<(), ExportError> {
    let mut csv = CsvWriter::new(table, options, writer)?;
    csv.write(table)?;
    csv.finish()
}

/// A CSV file that is written block by block, as [`write_csv`] writes it at once.
///
/// Without [`Self::finish`] its last rows are lost.
#[must_use = "call `finish`"]
#[derive(Debug)]
pub struct CsvWriter<W> {
    writer: W,
    text: Vec<u8>,
    columns: usize,
    /// Where in the text its last row begins, which is written once the next one has come.
    last: Option<usize>,
    /// Whether a row had a value.
    begun: bool,
}

impl<W: Write> CsvWriter<W> {
    const FLUSHED_AT: usize = 1 << 16;

    /// Begins with the names and units of `head`, whose values are left out.
    ///
    /// # Errors
    /// [`ExportError::NoColumns`] or [`ExportError::NameTaken`].
    pub fn new(head: &Table, options: &CsvOptions, writer: W) -> Result<Self, ExportError> {
        crate::check_names(head)?;
        let mut text = Vec::with_capacity(Self::FLUSHED_AT + 4096);
        let unit = |c: &Column| c.unit.clone().unwrap_or_default();
        let units: Vec<String> = head.columns.iter().map(unit).collect();
        let tags = head.columns.iter().map(|c| c.tag.as_str());
        if !options.units_row || units.iter().all(String::is_empty) {
            line(&mut text, tags);
        } else if is_sample(head, &units) {
            let names = tags.zip(&units).map(|(tag, unit)| match unit.as_str() {
                "" => tag.to_owned(),
                unit => format!("{tag} [{unit}]"),
            });
            let names: Vec<String> = names.collect();
            line(&mut text, names.iter().map(String::as_str));
        } else {
            line(&mut text, tags);
            line(&mut text, units.iter().map(String::as_str));
        }
        Ok(Self {
            writer,
            text,
            columns: head.columns.len(),
            last: None,
            begun: false,
        })
    }

    /// Appends rows, in columns as those of the head.
    ///
    /// # Errors
    /// [`ExportError::Width`] or [`ExportError::Io`].
    pub fn write(&mut self, block: &Table) -> Result<(), ExportError> {
        crate::check_width(block, self.columns)?;
        let text = &mut self.text;
        for row in 0..block.rows() {
            if text.len() >= Self::FLUSHED_AT {
                self.writer.write_all(text)?;
                text.clear();
            }
            let start = text.len();
            let missing = |column: &Column| column.values.get(row).is_none_or(|v| v.is_nan());
            self.begun = self.begun || !block.columns.iter().all(missing);
            if !self.begun {
                // Readers take empty lines above the first value for none.
                text.extend_from_slice(b"NaN");
            }
            for (index, column) in block.columns.iter().enumerate() {
                if index > 0 {
                    text.push(b',');
                }
                match column.values.get(row) {
                    Some(value) if !value.is_nan() => push(text, *value),
                    _ => {}
                }
            }
            if text.len() == start {
                // The only column, and nothing in it: a blank line would be no row.
                text.extend_from_slice(b"NaN");
            }
            text.push(b'\n');
            self.last = Some(start);
        }
        Ok(())
    }

    /// Writes what is left.
    ///
    /// # Errors
    /// [`ExportError::Io`].
    pub fn finish(mut self) -> Result<(), ExportError> {
        let last = self.last.unwrap_or(self.text.len());
        let cells = self.text[last..].trim_ascii_end();
        if !cells.is_empty() && cells.iter().all(|b| *b == b',') {
            // Readers take an empty last line for none.
            self.text.splice(last..last, *b"NaN");
        }
        self.writer.write_all(&self.text)?;
        self.writer.flush()?;
        Ok(())
    }
}

/// Whether a row of these units would be read as one of values: it holds nothing but `1`.
fn is_sample(head: &Table, units: &[String]) -> bool {
    let named = head.columns.iter().all(|c| !c.tag.is_empty());
    named && units.iter().all(|unit| unit.is_empty() || unit == "1")
}

fn line<'a>(text: &mut Vec<u8>, cells: impl Iterator<Item = &'a str>) {
    for (index, cell) in cells.enumerate() {
        if index > 0 {
            text.push(b',');
        }
        push_quoted(text, cell);
    }
    text.push(b'\n');
}

/// Appends a text as one cell, within quotes where a reader would cut it otherwise.
pub(crate) fn push_quoted(text: &mut Vec<u8>, cell: &str) {
    let special = |c: char| matches!(c, ',' | ';' | '\t' | '"' | '\n' | '\r');
    if cell.contains(special) || cell.trim() != cell {
        text.push(b'"');
        text.extend_from_slice(cell.replace('"', "\"\"").as_bytes());
        text.push(b'"');
    } else {
        text.extend_from_slice(cell.as_bytes());
    }
}
