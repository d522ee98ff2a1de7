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
    /// No memory for that many bytes, as of a sparse file that claims more than there is.
    #[error("{} has {bytes} bytes, for which there is no memory; split the file", path.display())]
    TooLarge {
        /// The file.
        path: PathBuf,
        /// Its size.
        bytes: u64,
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
/// [`FileError`], which names the file: [`FileError::TooLarge`] if there is no memory for it.
pub fn read_file(
    path: impl AsRef<Path>,
    mut progress: impl FnMut(u64, u64),
) -> Result<(Format, Table), FileError> {
    const STEP: u64 = 4 << 20;
    let path = path.as_ref();
    let io = |source| FileError::Io {
        path: path.to_owned(),
        source,
    };
    let mut file = File::open(path).map_err(io)?;
    let size = file.metadata().map_err(io)?.len();
    let mut bytes = room(path, size)?;
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

/// An empty vector with room for a file, which may be larger than memory.
fn room(path: &Path, size: u64) -> Result<Vec<u8>, FileError> {
    let mut bytes = Vec::new();
    let room = usize::try_from(size).map(|size| bytes.try_reserve_exact(size));
    if matches!(room, Ok(Ok(()))) {
        return Ok(bytes);
    }
    Err(FileError::TooLarge {
        path: path.to_owned(),
        bytes: size,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_larger_than_memory_is_refused_by_its_name_and_does_not_abort() {
        let path = Path::new("sparse.mat");
        for size in [u64::MAX, 1 << 62] {
            let told = room(path, size).map_err(|e| e.to_string());
            let expected = format!(
                "sparse.mat has {size} bytes, for which there is no memory; split the file"
            );
            assert_eq!(told, Err(expected));
        }
        assert!(room(path, 1000).is_ok_and(|bytes| bytes.capacity() >= 1000));
    }
}
