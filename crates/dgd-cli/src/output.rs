//! Output files appear whole or not at all, those of one run together, and never in the place of an input.
//!
//! The one place that writes: every file goes under a hidden name beside its place ([`Outputs::add`]), and
//! [`Outputs::keep`] renames all of them at the end. A hidden file is locked while its run lives, so what a killed run
//! left is known by its open lock and removed by the next run that writes into the folder.

mod hidden;

use crate::failure::Failure;
use crate::interrupt;
use dgd_export::CsvOptions;
use dgd_recording::Table;
use hidden::{Hidden, Locked};
use std::error::Error;
use std::fs::File;
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

/// Refuses early what [`Outputs`] would refuse after the work: call it when all inputs have been read.
pub(crate) fn check(path: &Path) -> Result<(), Failure> {
    let target = target(path)?;
    // The folder need not be there yet; then the one above it that is must take it.
    let mut above = folder_of(&target).ancestors();
    let folder = match above.find(|f| f.exists()) {
        Some(folder) => folder,
        // `deep/file` in the current folder.
        None => Path::new("."),
    };
    if !folder.is_dir() {
        let reason = format!("{} is not a folder", folder.display());
        return Err(Failure::unwritten(path, reason));
    }
    Hidden::create(folder, true)
        .map(drop)
        .map_err(|e| Failure::write(path, &e))
}

/// The files of one run, written and waiting; dropped, they are gone.
#[derive(Default)]
pub(crate) struct Outputs {
    staged: Vec<Staged>,
    /// Folders that have been cleared of what killed runs left.
    cleared: Vec<PathBuf>,
}

struct Staged {
    path: PathBuf,
    target: PathBuf,
    hidden: Hidden,
    /// It must not be there yet.
    fresh: bool,
}

impl Outputs {
    pub(crate) fn new() -> Self {
        Self::default()
    }

    /// Writes a file beside its place. Whatever can fail but the renaming has then been done.
    pub(crate) fn add(
        &mut self,
        path: &Path,
        write: impl FnOnce(&mut BufWriter<&File>) -> Result<(), Box<dyn Error>>,
    ) -> Result<(), Failure> {
        self.stage(path, false, write)
    }

    /// [`Self::add`] with bytes at hand.
    pub(crate) fn add_bytes(
        &mut self,
        path: &Path,
        bytes: impl AsRef<[u8]>,
    ) -> Result<(), Failure> {
        self.add(path, |writer| Ok(writer.write_all(bytes.as_ref())?))
    }

    /// [`Self::add`] with a table as CSV.
    pub(crate) fn add_csv(&mut self, path: &Path, table: &Table) -> Result<(), Failure> {
        self.add(path, |writer| {
            Ok(dgd_export::write_csv(
                table,
                &CsvOptions::default(),
                writer,
            )?)
        })
    }

    /// A new file that only its owner may read; another run's is never replaced.
    pub(crate) fn add_private(&mut self, path: &Path, bytes: &[u8]) -> Result<(), Failure> {
        self.stage(path, true, |writer| Ok(writer.write_all(bytes)?))
    }

    fn stage(
        &mut self,
        path: &Path,
        private: bool,
        write: impl FnOnce(&mut BufWriter<&File>) -> Result<(), Box<dyn Error>>,
    ) -> Result<(), Failure> {
        let failed = |e: &std::io::Error| Failure::write(path, e);
        let target = target(path)?;
        let folder = folder_of(&target);
        std::fs::create_dir_all(folder).map_err(|e| failed(&e))?;
        if !self.cleared.iter().any(|f| f == folder) {
            hidden::clear(folder);
            self.cleared.push(folder.to_owned());
        }
        let hidden = Hidden::create(folder, private).map_err(|e| failed(&e))?;
        let mut writer = BufWriter::new(hidden.file());
        // What is written may still be being read.
        write(&mut writer).map_err(|e| match e.downcast::<Failure>() {
            Ok(failure) => *failure,
            Err(e) => Failure::write_source(path, e.as_ref()),
        })?;
        writer.flush().map_err(|e| failed(&e))?;
        drop(writer);
        // A file that its owner has closed to others stays closed.
        if let Ok(before) = std::fs::metadata(&target) {
            let permissions = before.permissions();
            let set = hidden.file().set_permissions(permissions);
            set.map_err(|e| failed(&e))?;
        }
        hidden.file().sync_all().map_err(|e| failed(&e))?;
        self.staged.push(Staged {
            path: path.to_owned(),
            target,
            hidden,
            fresh: private,
        });
        Ok(())
    }

    /// Puts all files in their places.
    ///
    /// The folders are locked meanwhile and a Ctrl-C waits, so that the files that stand side by side are one run's.
    /// If one cannot take its place, those before it are put back.
    pub(crate) fn keep(self) -> Result<(), Failure> {
        let mut folders: Vec<&Path> = self.staged.iter().map(|s| folder_of(&s.target)).collect();
        folders.sort_unstable();
        folders.dedup();
        // In the order of their names: two runs cannot each wait for the other.
        let locks: Vec<Locked> = folders.iter().map(|f| Locked::folder(f)).collect();
        let held = interrupt::hold();
        let mut undo = Vec::new();
        for staged in &self.staged {
            match staged.put() {
                Ok(before) => undo.push(before),
                Err(failure) => {
                    undo.into_iter().rev().for_each(Before::restore);
                    drop(held);
                    return Err(failure);
                }
            }
        }
        undo.into_iter().for_each(Before::forget);
        held.written(self.staged.len());
        folders.iter().for_each(|folder| hidden::sync(folder));
        drop(locks);
        Ok(())
    }
}

/// What stood in the place of a file, until the whole set stands.
struct Before {
    target: PathBuf,
    /// A second name of the old file; `None` if there was none, or if the disk has no second names.
    old: Option<PathBuf>,
    was_there: bool,
}

impl Staged {
    fn put(&self) -> Result<Before, Failure> {
        let was_there = self.target.exists();
        if self.fresh && was_there {
            let reason = "another run has written it in the meantime; run again to use it";
            return Err(Failure::unwritten(&self.path, reason));
        }
        let second = hidden::second_name(self.hidden.path());
        let old = std::fs::hard_link(&self.target, &second)
            .is_ok()
            .then_some(second);
        let before = Before {
            target: self.target.clone(),
            old,
            was_there,
        };
        match std::fs::rename(self.hidden.path(), &self.target) {
            Ok(()) => Ok(before),
            Err(error) => {
                before.forget();
                Err(Failure::write(&self.path, &error))
            }
        }
    }
}

impl Before {
    fn restore(self) {
        // Nothing more can be done about what cannot be put back.
        let _ = match &self.old {
            Some(old) => std::fs::rename(old, &self.target),
            None if self.was_there => Ok(()),
            None => std::fs::remove_file(&self.target),
        };
    }

    fn forget(self) {
        if let Some(old) = &self.old {
            let _ = std::fs::remove_file(old);
        }
    }
}

/// The file behind links, if it may be replaced: a regular one that was not read.
fn target(path: &Path) -> Result<PathBuf, Failure> {
    let Ok(target) = path.canonicalize() else {
        return Ok(path.to_owned());
    };
    if !target.is_file() {
        return Err(Failure::unwritten(path, "it is not a regular file"));
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

fn folder_of(target: &Path) -> &Path {
    match target.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test may fail by panic")]
mod tests {
    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let entries = std::fs::read_dir(folder).unwrap();
        let mut names: Vec<String> = entries
            .map(|e| e.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        names
    }

    fn two(folder: &Path) -> Outputs {
        let mut outputs = Outputs::new();
        outputs.add_bytes(&folder.join("a"), "new a").unwrap();
        outputs.add_bytes(&folder.join("b"), "new b").unwrap();
        outputs
    }

    #[test]
    fn nothing_stands_until_all_are_kept() {
        let folder = tempfile::tempdir().unwrap();
        let outputs = two(folder.path());
        assert!(names(folder.path()).iter().all(|n| n.starts_with(".dgd-")));
        outputs.keep().unwrap();
        assert_eq!(names(folder.path()), ["a", "b"]);
        drop(two(folder.path()));
        assert_eq!(names(folder.path()), ["a", "b"]);
    }

    #[test]
    fn if_one_cannot_take_its_place_the_others_are_put_back() {
        let folder = tempfile::tempdir().unwrap();
        for old in [true, false] {
            if old {
                std::fs::write(folder.path().join("a"), "old a").unwrap();
            }
            let outputs = two(folder.path());
            std::fs::create_dir(folder.path().join("b")).unwrap();
            let failed = outputs.keep().unwrap_err();
            assert_eq!(failed.status(), 1);
            if old {
                assert_eq!(names(folder.path()), ["a", "b"]);
                let text = std::fs::read_to_string(folder.path().join("a")).unwrap();
                assert_eq!(text, "old a");
                std::fs::remove_file(folder.path().join("a")).unwrap();
            } else {
                assert_eq!(names(folder.path()), ["b"]);
            }
            std::fs::remove_dir(folder.path().join("b")).unwrap();
        }
    }

    #[test]
    fn what_a_killed_run_left_is_removed_and_what_a_living_run_writes_is_not() {
        let folder = tempfile::tempdir().unwrap();
        let living = two(folder.path());
        std::fs::write(folder.path().join(".dgd-killed.part"), "half").unwrap();
        std::fs::write(folder.path().join(".dgd-notes"), "somebody's").unwrap();
        let mut next = Outputs::new();
        next.add_bytes(&folder.path().join("c"), "c").unwrap();
        next.keep().unwrap();
        living.keep().unwrap();
        assert_eq!(names(folder.path()), [".dgd-notes", "a", "b", "c"]);
    }

    #[test]
    fn a_private_file_that_came_meanwhile_is_not_replaced() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("references.toml");
        let mut outputs = Outputs::new();
        outputs.add_private(&path, b"mine").unwrap();
        std::fs::write(&path, "theirs").unwrap();
        let failed = outputs.keep().unwrap_err().to_string();
        assert!(failed.contains("another run"), "{failed}");
        assert_eq!(std::fs::read_to_string(&path).unwrap(), "theirs");
        assert_eq!(names(folder.path()), ["references.toml"]);
    }
}
