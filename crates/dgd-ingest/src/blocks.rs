//! A recording on disk, block after block, in memory that does not grow with it.

use crate::csv::TextBlocks;
use crate::mcap::LogBlocks;
use crate::{Format, IngestError, detect, mislabelled};
use dgd_recording::Table;
use std::fmt;
use std::io::{self, Read, Seek, SeekFrom};

/// How much of a recording is held at a time.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct BlockOptions {
    /// Bytes of a text that are held, beside its samples of 4 MiB; a line must not be longer than an eighth of
    /// them. At least 1. Default: 8 MiB.
    pub bytes: usize,
    /// Values of a block, rows times columns; at least a row, and a chunk of a log is not parted. Default: 2^20, 8 MiB.
    pub cells: usize,
}

impl Default for BlockOptions {
    fn default() -> Self {
        Self {
            bytes: 8 << 20,
            cells: 1 << 20,
        }
    }
}

/// Whether a recording can be read in blocks.
#[derive(Debug)]
pub enum Opened<B> {
    /// It can.
    Blocks(B),
    /// It must be read whole, with [`crate::read`], for the reason here.
    Whole(&'static str),
}

pub(crate) const WHOLE_MAT: &str = "MAT files hold one column after another";
pub(crate) const WHOLE_TEXT: &str = "its lines tell only together what they are";
pub(crate) const WHOLE_READINGS: &str =
    "its readings have times of their own, and those of a time are put beside each other";
pub(crate) const WHOLE_LINES: &str = "it has a line too long for a window, normally a megabyte";
pub(crate) const WHOLE_RECORDS: &str = "it has a record of more than 64 MiB";
pub(crate) const WHOLE_TOPICS: &str =
    "a log of several topics, or of none, is brought onto one clock";
pub(crate) const WHOLE_ORDER: &str = "its messages must be put in order";
pub(crate) const WHOLE_DAMAGED: &str =
    "the log is damaged or cut off, and is searched for what is left";

/// Why a block was not read.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum BlockError {
    /// The source failed.
    #[error(transparent)]
    Io(#[from] io::Error),
    /// The content was not understood.
    #[error(transparent)]
    Content(#[from] IngestError),
    /// Another content than on the first reading.
    #[error("changed while it was read; wait until it is complete, or read a copy of it")]
    Changed,
}

/// A CSV text, or an MCAP log of one topic, that is read block by block as often as wanted.
///
/// It is read once when it is opened, because which columns there are shows only at the end. Blocks, put
/// one behind the other, are what [`crate::read`] gives, to the last bit, where that does not refuse the content as too large:
/// of a log it counts the cells as they come, here they are counted at the end.
///
/// ```
/// use dgd_ingest::{BlockOptions, BlockReader, Opened, ReadOptions};
/// let file = std::io::Cursor::new("t,FT4\ns,gpm\n0,796.5\n1,797\n2,798\n");
/// let opened = BlockReader::open(file, &ReadOptions::default(), BlockOptions::default())?;
/// let Opened::Blocks(mut recording) = opened else {
///     return Ok(()); // not this one
/// };
/// assert_eq!(recording.head().columns[1].unit.as_deref(), Some("gpm"));
/// let mut sum = 0.0;
/// while let Some(block) = recording.next_block()? {
///     sum += block.columns[1].values.iter().sum::<f64>();
/// }
/// assert_eq!(sum, 2391.5);
/// # Ok::<(), dgd_ingest::BlockError>(())
/// ```
pub struct BlockReader<R> {
    source: R,
    blocks: Blocks,
    head: Table,
    block: Table,
    /// Rows of the blocks so far.
    read: usize,
}

enum Blocks {
    Text(Box<TextBlocks>),
    Log(Box<LogBlocks>),
}

impl<R> fmt::Debug for BlockReader<R> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut shown = f.debug_struct("BlockReader");
        shown.field("head", &self.head).finish_non_exhaustive()
    }
}

impl<R: Read + Seek> BlockReader<R> {
    /// Looks through a recording.
    ///
    /// # Errors
    /// [`BlockError`] if the source fails, or if the content is none or too large; other content that [`crate::read`] would
    /// refuse must be read whole, for it to say why.
    pub fn open(
        mut source: R,
        options: &crate::ReadOptions,
        limits: BlockOptions,
    ) -> Result<Opened<Self>, BlockError> {
        let length = source.seek(SeekFrom::End(0))?;
        source.rewind()?;
        let mut begin = Vec::new();
        source
            .by_ref()
            .take(detect::BYTES)
            .read_to_end(&mut begin)?;
        let format = detect::detect(&begin)?;
        let blocks = match format {
            Format::Mat5 | Format::Mat73 => Opened::Whole(WHOLE_MAT),
            Format::Csv => TextBlocks::open(&mut source, length, limits)?
                .map(|text| Blocks::Text(Box::new(text))),
            Format::Mcap => {
                LogBlocks::open(&mut source, length, limits)?.map(|log| Blocks::Log(Box::new(log)))
            }
        };
        Ok(blocks.map(|blocks| {
            let mut head = match &blocks {
                Blocks::Text(text) => text.head(),
                Blocks::Log(log) => log.head(),
            };
            let name = options.name_hint.as_deref();
            let mislabelled = name.and_then(|name| mislabelled(name, format));
            head.issues.splice(0..0, mislabelled);
            Self {
                source,
                blocks,
                head,
                block: Table::default(),
                read: 0,
            }
        }))
    }

    /// The format of the recording.
    pub fn format(&self) -> Format {
        match self.blocks {
            Blocks::Text(_) => Format::Csv,
            Blocks::Log(_) => Format::Mcap,
        }
    }

    /// The table without its values.
    pub fn head(&self) -> &Table {
        &self.head
    }

    /// Samples of every column.
    pub fn rows(&self) -> usize {
        match &self.blocks {
            Blocks::Text(text) => text.rows(),
            Blocks::Log(log) => log.rows(),
        }
    }

    /// Goes back to the first block.
    pub fn rewind(&mut self) {
        self.read = 0;
        match &mut self.blocks {
            Blocks::Text(text) => text.rewind(),
            Blocks::Log(log) => log.rewind(),
        }
    }

    /// The next rows, in columns as those of [`BlockReader::head`]; `None` at the end.
    ///
    /// # Errors
    /// [`BlockError`] if the source fails, or if it has not the rows any more that it had when it was opened.
    pub fn next_block(&mut self) -> Result<Option<&Table>, BlockError> {
        let (source, block) = (&mut self.source, &mut self.block);
        let some = match &mut self.blocks {
            Blocks::Text(text) => text.next(source, block)?,
            Blocks::Log(log) => log.next(source, block)?,
        };
        if some {
            self.read += self.block.rows();
            return Ok(Some(&self.block));
        }
        if self.read == self.rows() {
            Ok(None)
        } else {
            Err(BlockError::Changed)
        }
    }
}

impl<B> Opened<B> {
    fn map<C>(self, into: impl FnOnce(B) -> C) -> Opened<C> {
        match self {
            Self::Blocks(blocks) => Opened::Blocks(into(blocks)),
            Self::Whole(reason) => Opened::Whole(reason),
        }
    }
}
