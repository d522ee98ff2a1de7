//! Recordings that are longer than memory.

use super::State;
use crate::failure::Failure;
use crate::output;
use crate::progress::Progress;
use dgd_ingest::{BlockError, BlockOptions, BlockReader, Format, Opened, ReadOptions};
use dgd_recording::{BlockSurvey, Table, TableSurvey};
use std::fs::File;
use std::path::{Path, PathBuf};
use tracing::{debug, info, warn};

/// A recording on disk, read block by block as often as wanted.
pub(crate) struct Blocks {
    path: PathBuf,
    reader: BlockReader<File>,
    /// The same file, and what it was like before the first byte was read.
    file: File,
    before: Option<State>,
}

/// When a recording is read block by block.
#[derive(Debug, Clone, Copy)]
pub(crate) enum When {
    Always,
    /// From so many bytes on.
    Long(u64),
}

impl When {
    pub(crate) fn of(asked_for: bool, long: u64) -> Self {
        if asked_for {
            Self::Always
        } else {
            Self::Long(long)
        }
    }

    /// Says why recordings of so many bytes are not read in blocks: aloud to who asked for it, and where they may not fit
    /// into memory.
    pub(crate) fn say(self, bytes: u64, why: &str) {
        match self {
            Self::Always => warn!("{why}"),
            Self::Long(_) if bytes >= LARGE => {
                let times = "it takes several times its size in memory";
                warn!("{why} ({} MiB; {times})", bytes >> 20);
            }
            Self::Long(least) if bytes >= least => info!("{why}"),
            Self::Long(_) => debug!("{why}"),
        }
    }
}

/// Bytes from which what is read whole may not fit.
const LARGE: u64 = 256 << 20;

/// What helps where a recording's form keeps it from being read in blocks; not who converts it.
pub(crate) const CONVERTED: &str =
    "the CSV or MCAP file that `dgd convert` makes of it need not be";

/// Opens a recording for reading in blocks; `None` if it is to be read whole, which is said with the `mend`, if there is one.
pub(crate) fn open(
    path: &Path,
    when: When,
    mend: Option<&str>,
    progress: &Progress,
) -> Result<Option<Blocks>, Failure> {
    open_with(path, when, mend, BlockOptions::default(), progress)
}

/// The same, in blocks of another size.
pub(super) fn open_with(
    path: &Path,
    when: When,
    mend: Option<&str>,
    limits: BlockOptions,
    progress: &Progress,
) -> Result<Option<Blocks>, Failure> {
    let least = match when {
        When::Always => 0,
        When::Long(bytes) => bytes,
    };
    // A pipe gives its bytes once, and to whoever opens it first.
    let metadata = std::fs::metadata(path).map_err(|e| Failure::read(path, &e))?;
    if !metadata.is_file() || metadata.len() < least {
        return Ok(None);
    }
    let file = File::open(path).map_err(|e| Failure::read(path, &e))?;
    let before = State::of(&file);
    output::protect(path);
    progress.stage("looking through", &path.display().to_string());
    let name_hint = path.file_name().map(|n| n.to_string_lossy().into_owned());
    let again = file.try_clone().map_err(|e| Failure::read(path, &e))?;
    let opened = BlockReader::open(again, &ReadOptions { name_hint }, limits);
    match opened.map_err(|e| failed(path, &e))? {
        Opened::Blocks(reader) => Ok(Some(Blocks {
            path: path.to_owned(),
            reader,
            file,
            before,
        })),
        Opened::Whole(reason) => {
            let mend = mend.map_or_else(String::new, |mend| format!("; {mend}"));
            let why = format!("{} is read in full: {reason}{mend}", path.display());
            when.say(metadata.len(), &why);
            Ok(None)
        }
    }
}

fn failed(path: &Path, error: &BlockError) -> Failure {
    match error {
        BlockError::Io(error) => Failure::read(path, error),
        error => Failure::input(path, error),
    }
}

impl Blocks {
    pub(crate) fn format(&self) -> Format {
        self.reader.format()
    }

    /// The table without its values.
    pub(crate) fn head(&self) -> &Table {
        self.reader.head()
    }

    pub(crate) fn rows(&self) -> usize {
        self.reader.rows()
    }

    /// Length of the file.
    pub(super) fn bytes(&self) -> u64 {
        self.file.metadata().map_or(0, |metadata| metadata.len())
    }

    /// Goes through all blocks, from the first one on.
    ///
    /// At the end the file must be what it was at the start, or the blocks are of two recordings.
    pub(crate) fn each<E: From<Failure>>(
        &mut self,
        mut take: impl FnMut(&Table) -> Result<(), E>,
    ) -> Result<(), E> {
        self.reader.rewind();
        let mut blocks = 0;
        while let Some(block) = (self.reader.next_block()).map_err(|e| failed(&self.path, &e))? {
            blocks += 1;
            take(block)?;
        }
        debug!("{}: read in {blocks} blocks", self.path.display());
        State::compare(&self.path, self.before, State::of(&self.file))?;
        Ok(())
    }

    /// The survey of the whole recording.
    pub(crate) fn survey(&mut self, progress: &Progress) -> Result<TableSurvey, Failure> {
        let mut survey = BlockSurvey::new(self.reader.head());
        for pass in 1.. {
            progress.stage("surveying", &format!("the columns, pass {pass}"));
            self.each::<Failure>(|block| {
                survey.add(block);
                Ok(())
            })?;
            if !survey.next_pass() {
                break;
            }
        }
        Ok(survey.finish())
    }

    /// The column that is the clock, where the file names none and none is called `t`.
    pub(crate) fn time_tag(&mut self, progress: &Progress) -> Result<Option<String>, Failure> {
        let head = self.head();
        if head.clock.is_some() || head.columns.iter().any(|c| c.tag == "t") {
            return Ok(None);
        }
        let mut survey = BlockSurvey::new(self.reader.head());
        progress.stage("surveying", "the columns");
        self.each::<Failure>(|block| {
            survey.add(block);
            Ok(())
        })?;
        survey.next_pass();
        let index = survey.time_column();
        Ok(index.map(|index| self.head().columns[index].tag.clone()))
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test may fail by panic")]
mod tests {
    use super::*;
    use crate::args::Global;
    use std::io::Write;

    #[test]
    fn a_file_that_is_written_into_between_two_passes_is_refused() {
        let mut file = tempfile::NamedTempFile::new().unwrap();
        file.write_all(b"t,a\n0,1\n1,2\n").unwrap();
        let global = Global {
            json: false,
            quiet: true,
            verbose: 0,
        };
        let progress = Progress::new(&global);
        let mut blocks = open(file.path(), When::Always, None, &progress)
            .unwrap()
            .unwrap();
        let mut rows = 0;
        let mut pass = |blocks: &mut Blocks| {
            blocks.each::<Failure>(|block| {
                rows += block.rows();
                Ok(())
            })
        };
        pass(&mut blocks).unwrap();
        file.write_all(b"2,3\n").unwrap();
        let refused = pass(&mut blocks).unwrap_err();
        assert_eq!(refused.status(), 2);
        let said = refused.to_string();
        for part in ["changed while it was read", "12 to 16", "copy"] {
            assert!(said.contains(part), "{said}");
        }
    }
}
