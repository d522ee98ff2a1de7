//! The one place that opens a file.

use crate::{Format, IngestError, ReadOptions, read};
use dgd_recording::Table;
use std::fs::File;
use std::io::{self, Read};
use std::path::{Path, PathBuf};

/// Why a file gave no table; the message names the file.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum FileError {
    /// The file cannot be opened or read.
    #[error("cannot read {}: {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What the system says.
        source: io::Error,
    },
    /// The file was read, its content not understood.
    #[error("{}: {source}", path.display())]
    Content {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        source: IngestError,
    },
}

/// Reads a file into memory and then into a table.
///
/// `progress` is called with the bytes read so far and the size of the file, after every
/// few megabytes and at the end.
///
/// # Errors
/// [`FileError`], which names the file.
pub fn read_file(
    path: &Path,
    mut progress: impl FnMut(u64, u64),
) -> Result<(Format, Table), FileError> {
    const STEP: u64 = 4 << 20;
    let io = |source| FileError::Io {
        path: path.to_owned(),
        source,
    };
    let mut file = File::open(path).map_err(io)?;
    let size = file.metadata().map_err(io)?.len();
    let mut bytes = Vec::with_capacity(usize::try_from(size).unwrap_or(0));
    loop {
        let read = file
            .by_ref()
            .take(STEP)
            .read_to_end(&mut bytes)
            .map_err(io)?;
        let done = bytes.len() as u64;
        progress(done, size.max(done));
        if read == 0 {
            break;
        }
    }
    let name_hint = path.file_name().map(|n| n.to_string_lossy().into_owned());
    read(&bytes, &ReadOptions { name_hint }).map_err(|source| FileError::Content {
        path: path.to_owned(),
        source,
    })
}
