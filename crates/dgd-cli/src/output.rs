//! Output files appear whole or not at all.

use crate::failure::Failure;
use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::Path;

/// Writes a file through a temporary one beside it, then renames: a reader sees
/// the old file or the new one, never a half.
pub(crate) fn replace(
    path: &Path,
    write: impl FnOnce(&mut BufWriter<File>) -> Result<(), String>,
) -> Result<(), Failure> {
    persist(path, write)?;
    make_readable(path)
}

fn persist(
    path: &Path,
    write: impl FnOnce(&mut BufWriter<File>) -> Result<(), String>,
) -> Result<(), Failure> {
    let folder = match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    };
    std::fs::create_dir_all(folder).map_err(|e| Failure::write(path, &e))?;
    let temporary = tempfile::Builder::new()
        .prefix(".dgd-")
        .tempfile_in(folder)
        .map_err(|e| Failure::write(path, &e))?;
    let (file, hidden) = temporary.into_parts();
    let mut writer = BufWriter::new(file);
    write(&mut writer).map_err(|e| Failure::Write {
        path: path.to_owned(),
        reason: e,
    })?;
    let file = writer
        .into_inner()
        .map_err(|e| Failure::write(path, e.error()))?;
    file.sync_all().map_err(|e| Failure::write(path, &e))?;
    drop(file);
    hidden
        .persist(path)
        .map(drop)
        .map_err(|e| Failure::write(path, &e.error))
}

/// [`replace_bytes`] for what only its owner may read.
pub(crate) fn replace_private(path: &Path, bytes: &[u8]) -> Result<(), Failure> {
    persist(path, |writer| {
        writer.write_all(bytes).map_err(|e| e.to_string())
    })
}

/// Temporary files are private to their owner; results are meant to be shared.
#[cfg(unix)]
fn make_readable(path: &Path) -> Result<(), Failure> {
    use std::os::unix::fs::PermissionsExt;
    let permissions = std::fs::Permissions::from_mode(0o644);
    std::fs::set_permissions(path, permissions).map_err(|e| Failure::write(path, &e))
}

#[cfg(not(unix))]
fn make_readable(_: &Path) -> Result<(), Failure> {
    Ok(())
}

/// [`replace`] with bytes at hand.
pub(crate) fn replace_bytes(path: &Path, bytes: &[u8]) -> Result<(), Failure> {
    replace(path, |writer| {
        writer.write_all(bytes).map_err(|e| e.to_string())
    })
}
