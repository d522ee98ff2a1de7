//! Files under hidden names, and the locks that tell a living run's from a killed one's.

use crate::interrupt;
use std::fs::{File, Permissions};
use std::io;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};
use tempfile::NamedTempFile;

const PREFIX: &str = ".dgd-";
const SUFFIX: &str = ".part";
/// Names of what stood there before, while a set of files takes its places.
const OLD: &str = "-old.part";
/// How long a run waits for another to put its files in place; that takes milliseconds.
const PATIENCE: Duration = Duration::from_secs(30);

/// A file that is being written; dropped, it is gone.
pub(super) struct Hidden {
    // Its lock ends with it.
    file: NamedTempFile,
}

impl Hidden {
    /// Makes and locks a file in `folder`; `private` is for its owner alone.
    pub(super) fn create(folder: &Path, private: bool) -> io::Result<Self> {
        let mut builder = tempfile::Builder::new();
        builder.prefix(PREFIX).suffix(SUFFIX);
        // Temporary files are private to their owner as they are.
        if let Some(permissions) = shared().filter(|_| !private) {
            builder.permissions(permissions);
        }
        // Nobody clears the folder between the making and the locking.
        let folder_lock = Locked::folder(folder);
        let mut held = interrupt::hold();
        let file = builder.tempfile_in(folder)?;
        // Where files cannot be locked, nothing is cleared either.
        let _ = file.as_file().try_lock();
        held.remember(file.path());
        drop(folder_lock);
        Ok(Self { file })
    }

    pub(super) fn file(&self) -> &File {
        self.file.as_file()
    }

    pub(super) fn path(&self) -> &Path {
        self.file.path()
    }
}

impl Drop for Hidden {
    fn drop(&mut self) {
        interrupt::hold().forget(self.file.path());
        // Renamed, it has lost its hidden name, and `NamedTempFile` finds nothing to remove.
    }
}

/// A second name for what stands where the file of this hidden name will go.
pub(super) fn second_name(hidden: &Path) -> PathBuf {
    let name = hidden.file_name().unwrap_or_default().to_string_lossy();
    let stem = name.strip_suffix(SUFFIX).unwrap_or(&name);
    hidden.with_file_name(format!("{stem}{OLD}"))
}

/// Removes what killed runs left in a folder: hidden files that nobody holds locked.
pub(super) fn clear(folder: &Path) {
    let lock = Locked::folder(folder);
    let Ok(entries) = std::fs::read_dir(folder) else {
        return;
    };
    for entry in entries.flatten() {
        let name = entry.file_name();
        let name = name.to_string_lossy();
        if !(name.starts_with(PREFIX) && name.ends_with(SUFFIX)) {
            continue;
        }
        let abandoned = File::open(entry.path()).is_ok_and(|f| f.try_lock().is_ok());
        if abandoned && lock.held() && std::fs::remove_file(entry.path()).is_ok() {
            tracing::info!(
                "removed {}, left by a run that was killed",
                entry.path().display()
            );
        }
    }
}

/// Makes the names in a folder last through a power cut, where a folder can be asked for that.
pub(super) fn sync(folder: &Path) {
    let _ = File::open(folder).and_then(|f| f.sync_all());
}

/// The lock on a folder, if it could be had; the kernel opens it when the run ends, however it ends.
pub(super) struct Locked(Option<File>);

impl Locked {
    /// Waits a while for another run, then goes on without: a lock is no reason to lose a result.
    pub(super) fn folder(folder: &Path) -> Self {
        let Ok(file) = File::open(folder) else {
            return Self(None);
        };
        let started = Instant::now();
        loop {
            match file.try_lock() {
                Ok(()) => return Self(Some(file)),
                Err(std::fs::TryLockError::WouldBlock) if started.elapsed() < PATIENCE => {
                    std::thread::sleep(Duration::from_millis(5));
                }
                Err(_) => return Self(None),
            }
        }
    }

    fn held(&self) -> bool {
        self.0.is_some()
    }
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
