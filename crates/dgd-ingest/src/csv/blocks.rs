//! A text on disk, read in windows.

use super::events;
use super::layout::{self, Glimpse, Layout};
use super::plan::{Plan, Seen};
use super::rows::{self, Rows, Stop, Window};
use super::text;
use crate::blocks::{BlockError, BlockOptions, Opened, WHOLE_LINES, WHOLE_READINGS, WHOLE_TEXT};
use dgd_recording::Table;
use std::io::{Read, Seek, SeekFrom};

/// The rows of a text, in blocks.
pub(crate) struct TextBlocks {
    layout: Layout,
    plan: Plan,
    /// Where the rows begin and the text ends, in bytes of the file.
    rows_at: u64,
    end: u64,
    options: BlockOptions,
    pass: Pass,
    rows: usize,
}

/// Reading from the first row to the last.
struct Pass {
    rows: Rows,
    windows: Windows,
}

impl TextBlocks {
    /// Reads a text of so many bytes once, to know what becomes of its columns.
    ///
    /// # Errors
    /// What [`super::read`] says of it, or what the source does.
    pub(crate) fn open(
        source: &mut (impl Read + Seek),
        length: u64,
        options: BlockOptions,
    ) -> Result<Opened<Self>, BlockError> {
        let bytes = part(source, 0, length)?;
        let zeros = zeros_at_end(source, length)?;
        let end = length - zeros;
        let head = &bytes[..bytes.len().min(usize::try_from(end).unwrap_or(usize::MAX))];
        let begin = text::mark(head);
        let head = &head[begin..];
        text::check(&bytes, head)?;
        let begin = begin as u64;
        let Ok(bytes) = usize::try_from(end - begin) else {
            return Ok(Opened::Whole(WHOLE_TEXT));
        };
        // Line ends of old Macs, and blanks that may be all there is.
        if !head.contains(&b'\n') || head.iter().all(u8::is_ascii_whitespace) {
            return Ok(Opened::Whole(WHOLE_TEXT));
        }
        let middle_at = bytes / 2;
        let middle = part(source, begin + middle_at as u64, end)?;
        let glimpse = Glimpse {
            head,
            middle: &middle,
            middle_at,
        };
        if !glimpse.is_whole(bytes) {
            return Ok(Opened::Whole(WHOLE_LINES));
        }
        let Ok(mut layout) = layout::layout(&glimpse) else {
            // Why not is told from the whole text.
            return Ok(Opened::Whole(WHOLE_TEXT));
        };
        if layout.readings.is_some() || layout.pairs.is_some() {
            return Ok(Opened::Whole(WHOLE_READINGS));
        }
        let rows_at = begin + layout.start as u64;
        let columns = layout.columns.len();
        let mut pass = Pass::new(&layout, rows_at, end, options);
        let (mut seen, mut rows) = (Seen::new(columns), 0);
        loop {
            let lines = pass.windows.lines;
            if rows::check_size(lines, columns, bytes as u64).is_err() {
                let lines = pass.windows.count_lines(source)?;
                rows::check_size(lines, columns, bytes as u64)?;
            }
            match pass.next(source)? {
                Step::Block(read) => rows += read,
                Step::End if layout.take_for_minutes(&pass.rows.columns) => {
                    pass = Pass::new(&layout, rows_at, end, options);
                    (seen, rows) = (Seen::new(columns), 0);
                    continue;
                }
                Step::End => break,
                Step::Long => return Ok(Opened::Whole(WHOLE_LINES)),
            }
            seen.add(&pass.rows.columns);
        }
        if pass.rows.check_names().is_err() {
            return Ok(Opened::Whole(WHOLE_TEXT));
        }
        let cut_off = text::cut_off(length, zeros).into_iter().collect();
        let plan = Plan::new(&pass.rows, &seen, cut_off);
        if !plan.has_values(&seen) {
            return Ok(Opened::Whole(WHOLE_TEXT));
        }
        if events::read_apart(&plan, &seen).is_some() {
            return Ok(Opened::Whole(WHOLE_READINGS));
        }
        Ok(Opened::Blocks(Self {
            pass: Pass::new(&layout, rows_at, end, options),
            layout,
            plan,
            rows_at,
            end,
            options,
            rows,
        }))
    }

    pub(crate) fn head(&self) -> Table {
        self.plan.head()
    }

    pub(crate) fn rows(&self) -> usize {
        self.rows
    }

    pub(crate) fn rewind(&mut self) {
        self.pass = Pass::new(&self.layout, self.rows_at, self.end, self.options);
    }

    /// Puts the next rows into the table; says whether there were any.
    pub(crate) fn next(
        &mut self,
        source: &mut (impl Read + Seek),
        table: &mut Table,
    ) -> Result<bool, BlockError> {
        match self.pass.next(source)? {
            Step::Block(_) => {
                self.plan.fill(&mut self.pass.rows.columns, table);
                Ok(true)
            }
            Step::End => Ok(false),
            // The first pass met no such line.
            Step::Long => Err(BlockError::Changed),
        }
    }
}

enum Step {
    /// The columns hold so many rows.
    Block(usize),
    End,
    /// A row is too long for a window.
    Long,
}

impl Pass {
    fn new(layout: &Layout, from: u64, to: u64, options: BlockOptions) -> Self {
        let width = layout.columns.len().max(1);
        Self {
            rows: Rows::new(layout, (options.cells / width).max(1)),
            windows: Windows {
                bytes: Vec::new(),
                at: 0,
                next: from,
                end: to,
                size: options.bytes.max(1),
                lines: 1,
            },
        }
    }

    fn next(&mut self, source: &mut (impl Read + Seek)) -> Result<Step, BlockError> {
        let Self { rows, windows } = self;
        rows.next_block();
        loop {
            let window = Window {
                text: &windows.bytes,
                last: windows.next >= windows.end,
            };
            match rows.read(window, windows.at) {
                Stop::Full(at) => windows.at = at,
                Stop::Long => return Ok(Step::Long),
                Stop::More(at) if !window.last => {
                    windows.at = at;
                    if !windows.refill(source)? {
                        return Ok(Step::Long);
                    }
                    continue;
                }
                Stop::More(at) => windows.at = at,
            }
            return Ok(match rows.in_block() {
                0 => Step::End,
                read => Step::Block(read),
            });
        }
    }
}

/// A part of a file after another, each beginning where the last was left.
struct Windows {
    bytes: Vec<u8>,
    /// What is left of them begins here.
    at: usize,
    /// Byte of the file behind them.
    next: u64,
    end: u64,
    size: usize,
    /// Line ends met so far, and one.
    lines: u64,
}

impl Windows {
    /// Moves on; `false` if the window was left where it began, and is full.
    fn refill(&mut self, source: &mut (impl Read + Seek)) -> Result<bool, BlockError> {
        self.bytes.drain(..self.at);
        self.at = 0;
        let old = self.bytes.len();
        let room = self.size.saturating_sub(old) as u64;
        source.seek(SeekFrom::Start(self.next))?;
        read_exactly(source, room.min(self.end - self.next), &mut self.bytes)?;
        let new = &self.bytes[old..];
        self.next += new.len() as u64;
        self.lines += new.iter().filter(|b| **b == b'\n').count() as u64;
        Ok(!new.is_empty())
    }

    /// Lines to the end of the text.
    fn count_lines(&mut self, source: &mut (impl Read + Seek)) -> Result<u64, BlockError> {
        while self.next < self.end {
            self.at = self.bytes.len();
            self.refill(source)?;
        }
        Ok(self.lines)
    }
}

/// Enough of a file for a sample of its lines, from a byte on, but not beyond its end.
fn part(source: &mut (impl Read + Seek), from: u64, end: u64) -> Result<Vec<u8>, BlockError> {
    let mut bytes = Vec::new();
    source.seek(SeekFrom::Start(from))?;
    let length = end.saturating_sub(from).min(Glimpse::ENOUGH as u64);
    read_exactly(source, length, &mut bytes)?;
    Ok(bytes)
}

fn zeros_at_end(source: &mut (impl Read + Seek), length: u64) -> Result<u64, BlockError> {
    const STEP: u64 = 1 << 16;
    let mut bytes = Vec::new();
    let mut end = length;
    while end > 0 {
        let from = end.saturating_sub(STEP);
        source.seek(SeekFrom::Start(from))?;
        bytes.clear();
        read_exactly(source, end - from, &mut bytes)?;
        let zeros = bytes.iter().rev().take_while(|b| **b == 0).count();
        end -= zeros as u64;
        if zeros < bytes.len() {
            break;
        }
    }
    Ok(length - end)
}

/// Appends the next bytes.
fn read_exactly(source: &mut impl Read, length: u64, into: &mut Vec<u8>) -> Result<(), BlockError> {
    let read = source.take(length).read_to_end(into)?;
    if (read as u64) < length {
        // It was longer a moment ago.
        return Err(BlockError::Changed);
    }
    Ok(())
}
