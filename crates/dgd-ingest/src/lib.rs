//! Recordings in: MAT v5 and v7.3, CSV and MCAP files to one [`Table`].
//!
//! Start at [`read`] with the bytes of a file, at [`read_file`] with its path, or at
//! [`BlockReader`] for one that is longer than memory. The
//! format is told from the content. What can be read is read: everything that was wrong
//! on the way is an [`Issue`] in the table, with its place; an error means that no
//! table came out.
//!
//! Values stay in the units of the file. Which column is which channel, and in which
//! unit, is for a well description to say (`dgd_recording::Well`). Nothing is filled,
//! resampled or screened here, with three exceptions that are told as issues: MCAP
//! messages out of order are sorted, several MCAP topics are brought onto one clock, and
//! so are texts whose readings have times of their own.
#![deny(missing_docs)]

mod blocks;
mod csv;
mod detect;
mod error;
mod file;
mod hdf5;
mod mat;
mod mat5;
mod mcap;
mod nearest;
mod nulls;
mod tags;

pub use blocks::{BlockError, BlockOptions, BlockReader, Opened};
pub use detect::detect;
pub use error::IngestError;
pub use file::{FileError, read_file};

// What the functions here return, so that their user need not name the crate below.
pub use dgd_recording::{Column, Issue, IssueKind, Table};
use std::fmt;

/// A file format.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[non_exhaustive]
pub enum Format {
    /// MATLAB v5 to v7, compressed or not.
    Mat5,
    /// MATLAB v7.3, which is HDF5.
    Mat73,
    /// Text with commas, semicolons or tabs.
    Csv,
    /// MCAP with JSON messages.
    Mcap,
}

impl Format {
    /// File name extension without the point.
    pub fn extension(self) -> &'static str {
        match self {
            Self::Mat5 | Self::Mat73 => "mat",
            Self::Csv => "csv",
            Self::Mcap => "mcap",
        }
    }
}

impl fmt::Display for Format {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Mat5 => "MAT v5",
            Self::Mat73 => "MAT v7.3",
            Self::Csv => "CSV",
            Self::Mcap => "MCAP",
        })
    }
}

/// What a caller knows about the file.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct ReadOptions {
    /// The file's name. It changes nothing in what is read; an extension that says
    /// otherwise than the content becomes an issue. Default: none.
    pub name_hint: Option<String>,
}

/// Reads a file's bytes, whatever its format.
///
/// # Errors
/// [`IngestError`] if the bytes are none of the formats, or hold no column of numbers.
///
/// ```
/// use dgd_ingest::{Format, ReadOptions, Table, read};
/// let bytes = b"t,FT4\ns,gpm\n0,796.5\n1,797\n";
/// let (format, table): (Format, Table) = read(bytes, &ReadOptions::default())?;
/// assert_eq!(format, Format::Csv);
/// assert_eq!(table.columns[1].unit.as_deref(), Some("gpm"));
/// assert_eq!(table.columns[1].values, [796.5, 797.0]);
/// # Ok::<(), dgd_ingest::IngestError>(())
/// ```
pub fn read(bytes: &[u8], options: &ReadOptions) -> Result<(Format, Table), IngestError> {
    let format = detect(bytes)?;
    let mut table = match format {
        Format::Mat5 => mat5::read(bytes)?,
        Format::Mat73 => hdf5::read(bytes)?,
        Format::Csv => csv::read(bytes)?,
        Format::Mcap => mcap::read(bytes)?,
    };
    if let Some(issue) = options
        .name_hint
        .as_deref()
        .and_then(|name| mislabelled(name, format))
    {
        table.issues.insert(0, issue);
    }
    Ok((format, table))
}

/// `1 cell`, `2 cells`.
pub(crate) fn count(number: u64, noun: &str) -> String {
    let plural = if number == 1 { "" } else { "s" };
    format!("{number} {noun}{plural}")
}

/// The extension of a known format, of another one than the content's.
fn mislabelled(name: &str, format: Format) -> Option<Issue> {
    let (_, extension) = name.rsplit_once('.')?;
    let known = ["mat", "csv", "mcap"]
        .into_iter()
        .find(|e| extension.eq_ignore_ascii_case(e))?;
    (known != format.extension()).then(|| Issue {
        kind: IssueKind::Skipped,
        place: "file name".into(),
        message: format!(
            "it ends in `.{extension}`, but the content is {format} and was read as that"
        ),
    })
}

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
