//! MAT v5 out: one compressed struct of columns.

use std::borrow::Cow;
use std::collections::BTreeSet;
use std::io::Write;

use dgd_recording::Table;
use flate2::Compression;
use flate2::write::ZlibEncoder;

use crate::error::ExportError;
use crate::mat::{ORIGIN, Struct, UNITS, is_name};

const MI_INT8: u32 = 1;
const MI_INT32: u32 = 5;
const MI_UINT32: u32 = 6;
const MI_DOUBLE: u32 = 9;
const MI_MATRIX: u32 = 14;
const MI_COMPRESSED: u32 = 15;
const MI_UTF8: u32 = 16;
const MX_CELL: u32 = 1;
const MX_STRUCT: u32 = 2;
const MX_CHAR: u32 = 4;
const MX_DOUBLE: u32 = 6;
/// A variable of MAT v5 stays below 4 GiB.
const LIMIT: u64 = u32::MAX as u64 - 7;
/// Values turned into bytes at a time.
const BLOCK: usize = 4096;

/// Writes `table` as one struct named `root`, as MATLAB's `save -v7` would.
///
/// Each column becomes a field of n x 1 doubles under the name that
/// [`field_names`](crate::field_names) gives; units go to `root.units.<field>`, the start
/// time to `root.origin`. The same table gives the same bytes.
///
/// # Errors
/// [`ExportError::NoColumns`], [`ExportError::Name`] if MATLAB would not take `root`,
/// [`ExportError::TooLarge`] from 4 GiB on, [`ExportError::Io`] from `out`.
pub fn write_mat5(table: &Table, root: &str, out: &mut impl Write) -> Result<(), ExportError> {
    let table = Struct::new(table, root)?;
    write_root(&struct_of(root, &table)?, out)
}

/// A value of a MATLAB struct.
#[derive(Debug, Clone, PartialEq)]
pub enum MatValue {
    /// A matrix of doubles.
    Matrix {
        /// Number of rows.
        rows: usize,
        /// Number of columns.
        columns: usize,
        /// `rows * columns` values, row by row.
        values: Vec<f64>,
    },
    /// A text.
    Text(String),
    /// A column cell array of texts, such as the names of states.
    Texts(Vec<String>),
    /// A struct.
    Fields(Vec<(String, MatValue)>),
}

/// Writes named values as one struct named `root`, as MATLAB's `save -v7` would: `s = load(file).root` and then
/// `ss(s.A, s.B, s.C, s.D)`.
///
/// # Errors
/// [`ExportError::NoColumns`] without values, [`ExportError::Name`] if MATLAB would not take a name,
/// [`ExportError::NameTaken`] on two fields of one name, [`ExportError::Shape`] on a matrix with another number of values than
/// its shape has, [`ExportError::TooLarge`] from 4 GiB on, [`ExportError::Io`] from `out`.
///
/// ```
/// use dgd_export::{MatValue, write_mat5_values};
/// let a = MatValue::Matrix { rows: 1, columns: 2, values: vec![-0.5, 0.25] };
/// let mut bytes = Vec::new();
/// write_mat5_values(&[("A".into(), a)], "linear", &mut bytes)?;
/// assert!(bytes.starts_with(b"MATLAB 5.0 MAT-file"));
/// # Ok::<(), dgd_export::ExportError>(())
/// ```
pub fn write_mat5_values(
    values: &[(String, MatValue)],
    root: &str,
    out: &mut impl Write,
) -> Result<(), ExportError> {
    if values.is_empty() {
        return Err(ExportError::NoColumns);
    }
    check_name(root)?;
    write_root(&fields_of(root.to_owned(), value_fields(values)?), out)
}

fn write_root(root: &Matrix<'_>, out: &mut impl Write) -> Result<(), ExportError> {
    let mut zlib = ZlibEncoder::new(Vec::new(), Compression::new(6));
    root.write(&mut zlib)?;
    let squashed = zlib.finish()?;
    let length = fits("the compressed struct", squashed.len() as u64)?;
    let mut header = b"MATLAB 5.0 MAT-file, written by dgd-export".to_vec();
    header.resize(116, b' ');
    header.extend([0; 8]);
    header.extend([0, 1, b'I', b'M']);
    out.write_all(&header)?;
    out.write_all(&MI_COMPRESSED.to_le_bytes())?;
    out.write_all(&length.to_le_bytes())?;
    out.write_all(&squashed)?;
    Ok(())
}

/// An array, with the length of everything in it.
struct Matrix<'t> {
    class: u32,
    rows: u32,
    columns: u32,
    name: String,
    body: Body<'t>,
}

enum Body<'t> {
    Values(Cow<'t, [f64]>),
    Text(&'t str),
    Cells(Vec<Matrix<'t>>),
    Fields(Vec<(String, Matrix<'t>)>),
}

fn check_name(name: &str) -> Result<(), ExportError> {
    if !is_name(name) {
        return Err(ExportError::Name { name: name.into() });
    }
    Ok(())
}

fn value_fields(values: &[(String, MatValue)]) -> Result<Vec<(String, Matrix<'_>)>, ExportError> {
    let mut seen = BTreeSet::new();
    values
        .iter()
        .map(|(name, value)| {
            check_name(name)?;
            if !seen.insert(name) {
                return Err(ExportError::NameTaken { tag: name.clone() });
            }
            Ok((name.clone(), value_of(name, value)?))
        })
        .collect()
}

fn value_of<'t>(name: &str, value: &'t MatValue) -> Result<Matrix<'t>, ExportError> {
    let side = |length: usize| {
        u32::try_from(length)
            .ok()
            .filter(|length| i32::try_from(*length).is_ok())
            .ok_or_else(|| too_large(name, 8 * length as u64))
    };
    Ok(match value {
        MatValue::Matrix {
            rows,
            columns,
            values,
        } => {
            let expected = rows.saturating_mul(*columns);
            if values.len() != expected {
                return Err(ExportError::Shape {
                    name: name.into(),
                    rows: *rows,
                    columns: *columns,
                    found: values.len(),
                });
            }
            // MATLAB goes down the columns.
            let turned = (0..*columns)
                .flat_map(|j| (0..*rows).map(move |i| values[i * columns + j]))
                .collect();
            Matrix {
                class: MX_DOUBLE,
                rows: side(*rows)?,
                columns: side(*columns)?,
                name: String::new(),
                body: Body::Values(Cow::Owned(turned)),
            }
        }
        MatValue::Text(text) => text_of(text)?,
        MatValue::Texts(texts) => Matrix {
            class: MX_CELL,
            rows: side(texts.len())?,
            columns: 1,
            name: String::new(),
            body: Body::Cells(texts.iter().map(|t| text_of(t)).collect::<Result<_, _>>()?),
        },
        MatValue::Fields(fields) => fields_of(String::new(), value_fields(fields)?),
    })
}

fn struct_of<'t>(root: &str, table: &Struct<'t>) -> Result<Matrix<'t>, ExportError> {
    let mut fields = Vec::new();
    for (name, values) in &table.fields {
        let rows = u32::try_from(values.len())
            .ok()
            .filter(|rows| i32::try_from(*rows).is_ok())
            .ok_or_else(|| too_large(name, 8 * values.len() as u64))?;
        fields.push((
            name.clone(),
            Matrix {
                class: MX_DOUBLE,
                rows,
                columns: 1,
                name: String::new(),
                body: Body::Values(Cow::Borrowed(values)),
            },
        ));
    }
    if !table.units.is_empty() {
        let units = table
            .units
            .iter()
            .map(|(name, unit)| Ok((name.clone(), text_of(unit)?)))
            .collect::<Result<_, ExportError>>()?;
        fields.push((UNITS.into(), fields_of(String::new(), units)));
    }
    if let Some(origin) = table.origin {
        fields.push((ORIGIN.into(), text_of(origin)?));
    }
    Ok(fields_of(root.to_owned(), fields))
}

fn fields_of(name: String, fields: Vec<(String, Matrix<'_>)>) -> Matrix<'_> {
    Matrix {
        class: MX_STRUCT,
        rows: 1,
        columns: 1,
        name,
        body: Body::Fields(fields),
    }
}

fn text_of(text: &str) -> Result<Matrix<'_>, ExportError> {
    // MATLAB counts 16-bit characters, whatever the coding in the file.
    let units = text.encode_utf16().count() as u64;
    Ok(Matrix {
        class: MX_CHAR,
        rows: u32::from(units > 0),
        columns: fits("a text", units)?,
        name: String::new(),
        body: Body::Text(text),
    })
}

fn too_large(what: &str, bytes: u64) -> ExportError {
    ExportError::TooLarge {
        what: format!("`{what}`"),
        bytes,
        limit: LIMIT,
    }
}

fn fits(what: &str, bytes: u64) -> Result<u32, ExportError> {
    u32::try_from(bytes)
        .ok()
        .filter(|_| bytes <= LIMIT)
        .ok_or_else(|| too_large(what, bytes))
}

/// Tag, data and padding.
fn padded(data: u64) -> u64 {
    8 + data.next_multiple_of(8)
}

/// Bytes of one field name with its closing zeros, as MATLAB chooses them.
fn name_width(fields: &[(String, Matrix<'_>)]) -> u32 {
    if fields.iter().all(|(name, _)| name.len() < 32) {
        32
    } else {
        64
    }
}

impl Matrix<'_> {
    /// Bytes after the tag of this array.
    fn length(&self) -> u64 {
        let head = padded(8) + padded(8) + padded(self.name.len() as u64);
        head + match &self.body {
            Body::Values(values) => padded(8 * values.len() as u64),
            Body::Text(text) => padded(text.len() as u64),
            Body::Cells(cells) => cells.iter().map(|child| 8 + child.length()).sum(),
            Body::Fields(fields) => {
                let width = u64::from(name_width(fields));
                let children: u64 = fields.iter().map(|(_, child)| 8 + child.length()).sum();
                8 + padded(width * fields.len() as u64) + children
            }
        }
    }

    fn write(&self, out: &mut impl Write) -> Result<(), ExportError> {
        let length = fits(&self.name, self.length())?;
        word(out, MI_MATRIX)?;
        word(out, length)?;
        word(out, MI_UINT32)?;
        word(out, 8)?;
        word(out, self.class)?;
        word(out, 0)?;
        word(out, MI_INT32)?;
        word(out, 8)?;
        word(out, self.rows)?;
        word(out, self.columns)?;
        data(out, MI_INT8, self.name.as_bytes())?;
        match &self.body {
            Body::Values(values) => {
                word(out, MI_DOUBLE)?;
                word(out, fits(&self.name, 8 * values.len() as u64)?)?;
                let mut bytes = Vec::with_capacity(8 * BLOCK.min(values.len()));
                for block in values.chunks(BLOCK) {
                    bytes.clear();
                    bytes.extend(block.iter().flat_map(|v| v.to_le_bytes()));
                    out.write_all(&bytes)?;
                }
            }
            Body::Text(text) => data(out, MI_UTF8, text.as_bytes())?,
            Body::Cells(cells) => cells.iter().try_for_each(|child| child.write(out))?,
            Body::Fields(fields) => {
                // The width of the names is a small element: length and type share a word.
                let width = name_width(fields);
                word(out, 4 << 16 | MI_INT32)?;
                word(out, width)?;
                let mut names = Vec::new();
                for (name, _) in fields {
                    let end = names.len() + usize::try_from(width).unwrap_or(usize::MAX);
                    names.extend(name.as_bytes());
                    names.resize(end, 0);
                }
                data(out, MI_INT8, &names)?;
                for (_, child) in fields {
                    child.write(out)?;
                }
            }
        }
        Ok(())
    }
}

fn word(out: &mut impl Write, value: u32) -> Result<(), ExportError> {
    Ok(out.write_all(&value.to_le_bytes())?)
}

fn data(out: &mut impl Write, kind: u32, bytes: &[u8]) -> Result<(), ExportError> {
    word(out, kind)?;
    word(out, fits("a name", bytes.len() as u64)?)?;
    out.write_all(bytes)?;
    let padding = bytes.len().next_multiple_of(8) - bytes.len();
    Ok(out.write_all(&[0; 8][..padding])?)
}
