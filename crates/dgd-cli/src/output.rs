//! Output files appear whole or not at all, and never in the place of an input.

use crate::failure::Failure;
use std::fs::{File, Permissions};
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::Mutex;

/// What this run has read: results must not replace it.
static INPUTS: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

/// Notes a file that was read.
pub(crate) fn protect(path: &Path) {
    if let (Ok(path), Ok(mut inputs)) = (path.canonicalize(), INPUTS.lock()) {
        inputs.push(path);
    }
}

/// Writes a file through a temporary one beside it, then renames: a reader sees
/// the old file or the new one, never a half.
pub(crate) fn replace(
    path: &Path,
    write: impl FnOnce(&mut BufWriter<File>) -> Result<(), String>,
) -> Result<(), Failure> {
    persist(path, shared(), write)
}

/// [`replace`] with bytes at hand.
pub(crate) fn replace_bytes(path: &Path, bytes: &[u8]) -> Result<(), Failure> {
    replace(path, |writer| {
        writer.write_all(bytes).map_err(|e| e.to_string())
    })
}

/// [`replace_bytes`] for what only its owner may read.
pub(crate) fn replace_private(path: &Path, bytes: &[u8]) -> Result<(), Failure> {
    // Temporary files are private to their owner as they are.
    persist(path, None, |writer| {
        writer.write_all(bytes).map_err(|e| e.to_string())
    })
}

fn persist(
    path: &Path,
    permissions: Option<Permissions>,
    write: impl FnOnce(&mut BufWriter<File>) -> Result<(), String>,
) -> Result<(), Failure> {
    stage_with(path, permissions, write)?.keep()
}

/// A file that is written and waits under a hidden name; dropped, it is gone.
pub(crate) struct Staged {
    path: PathBuf,
    target: PathBuf,
    hidden: tempfile::TempPath,
}

impl Staged {
    /// Puts it in its place.
    pub(crate) fn keep(self) -> Result<(), Failure> {
        let Self {
            path,
            target,
            hidden,
        } = self;
        hidden
            .persist(&target)
            .map_err(|e| Failure::write(&path, &e.error))
    }
}

/// Writes a file beside its place, for files that must appear together: whatever can fail but the renaming has
/// then been done.
pub(crate) fn stage(
    path: &Path,
    write: impl FnOnce(&mut BufWriter<File>) -> Result<(), String>,
) -> Result<Staged, Failure> {
    stage_with(path, shared(), write)
}

/// Refuses early what [`replace`] would refuse after the work: call it when all inputs have been read.
pub(crate) fn check(path: &Path) -> Result<(), Failure> {
    target(path).map(drop)
}

fn stage_with(
    path: &Path,
    permissions: Option<Permissions>,
    write: impl FnOnce(&mut BufWriter<File>) -> Result<(), String>,
) -> Result<Staged, Failure> {
    let target = target(path)?;
    let folder = match target.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    };
    std::fs::create_dir_all(folder).map_err(|e| Failure::write(path, &e))?;
    let mut builder = tempfile::Builder::new();
    builder.prefix(".dgd-");
    if let Some(permissions) = permissions {
        builder.permissions(permissions);
    }
    let temporary = builder
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
    // A file that its owner has closed to others stays closed.
    if let Ok(before) = std::fs::metadata(&target) {
        file.set_permissions(before.permissions())
            .map_err(|e| Failure::write(path, &e))?;
    }
    file.sync_all().map_err(|e| Failure::write(path, &e))?;
    Ok(Staged {
        path: path.to_owned(),
        target,
        hidden,
    })
}

/// The file behind links, if it may be replaced: a regular one that was not read.
fn target(path: &Path) -> Result<PathBuf, Failure> {
    let Ok(target) = path.canonicalize() else {
        return Ok(path.to_owned());
    };
    if !target.is_file() {
        return Err(Failure::Write {
            path: path.to_owned(),
            reason: "it is no regular file".into(),
        });
    }
    if INPUTS.lock().is_ok_and(|inputs| inputs.contains(&target)) {
        let reason = format!(
            "{} is an input of this run and would be replaced; name another output",
            path.display()
        );
        return Err(Failure::Arguments { reason });
    }
    Ok(target)
}

/// Results are shared as the user's umask says.
#[cfg(unix)]
fn shared() -> Option<Permissions> {
    use std::os::unix::fs::PermissionsExt;
    Some(Permissions::from_mode(0o666))
}

#[cfg(not(unix))]
fn shared() -> Option<Permissions> {
    None
}
