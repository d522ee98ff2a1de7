//! Chunks: the index that lists them and the filters they went through.

use flate2::{Decompress, FlushDecompress, Status};

use crate::mat::Fault;

use super::dataset::{Chunked, Index};
use super::file::{Cursor, File};
use super::object::{check, to_usize};

const DEFLATE: u16 = 1;
const SHUFFLE: u16 = 2;
const FLETCHER32: u16 = 3;

/// One stored chunk.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Chunk {
    /// First element, slowest side first.
    pub(super) start: Vec<u64>,
    pub(super) address: u64,
    /// Stored bytes.
    pub(super) size: u64,
    /// Filters that this chunk skipped, by bit.
    pub(super) skipped: u32,
}

/// The chunks of a data set, at most one for each cell of its grid.
pub(super) fn list(
    file: &File<'_>,
    chunked: &Chunked,
    dims: &[u64],
    chunk_bytes: u64,
    filtered: bool,
) -> Result<Vec<Chunk>, Fault> {
    let Some(address) = chunked.address else {
        return Ok(Vec::new());
    };
    let grid: Vec<u64> = dims
        .iter()
        .zip(&chunked.sides)
        .map(|(&d, &side)| d.div_ceil(side))
        .collect();
    let cells = grid.iter().fold(1_u64, |n, &g| n.saturating_mul(g));
    let mut chunks = Vec::new();
    let start_of = |cell: u64| {
        let mut start = vec![0; grid.len()];
        let mut rest = cell;
        for side in (0..grid.len()).rev() {
            start[side] = rest % grid[side].max(1) * chunked.sides[side];
            rest /= grid[side].max(1);
        }
        start
    };
    match chunked.index {
        Index::Tree => {
            let mut nodes = file.data.len() / 16;
            // No more entries than the file has room for.
            let entry = 16 + 8 * dims.len() + file.offset_size;
            let most = cells.min((file.data.len() / entry) as u64);
            tree(
                file,
                address,
                None,
                dims.len(),
                most,
                &mut nodes,
                &mut chunks,
            )?;
        }
        Index::Single(stored) => {
            let (size, skipped) = stored.unwrap_or((chunk_bytes, 0));
            chunks.push(Chunk {
                start: vec![0; dims.len()],
                address,
                size,
                skipped,
            });
        }
        Index::Implicit => {
            // Stored whole, so the file bounds their number.
            file.bytes(address, cells.saturating_mul(chunk_bytes))?;
            chunks.extend((0..cells).map(|cell| Chunk {
                start: start_of(cell),
                address: address + cell * chunk_bytes,
                size: chunk_bytes,
                skipped: 0,
            }));
        }
        Index::Fixed { page_bits } => {
            fixed(
                file,
                address,
                page_bits,
                cells,
                filtered,
                |cell, address, size, skipped| {
                    chunks.push(Chunk {
                        start: start_of(cell),
                        address,
                        size: size.unwrap_or(chunk_bytes),
                        skipped,
                    });
                },
            )?;
        }
    }
    Ok(chunks)
}

/// Walks the version 1 B-tree; `level` strictly falls, so that no loop is endless.
fn tree(
    file: &File<'_>,
    address: u64,
    below: Option<u8>,
    rank: usize,
    cells: u64,
    nodes: &mut usize,
    chunks: &mut Vec<Chunk>,
) -> Result<(), Fault> {
    let mut c = file.cursor_from(address)?;
    c.expect(b"TREE")?;
    let (kind, level, count) = (c.u8()?, c.u8()?, c.u16()?);
    if kind != 1 || below.is_some_and(|below| level >= below) || *nodes == 0 {
        return Err(c.damaged("the tree of the chunks is tangled"));
    }
    *nodes -= 1;
    c.skip(2 * file.offset_size)?;
    for _ in 0..count {
        let (size, skipped) = (c.u32()?, c.u32()?);
        let start = (0..rank)
            .map(|_| c.unsigned(8))
            .collect::<Result<Vec<_>, _>>()?;
        c.skip(8)?;
        let child = c.offset()?;
        if level > 0 {
            tree(file, child, Some(level), rank, cells, nodes, chunks)?;
        } else if chunks.len() as u64 >= cells {
            return Err(c.damaged(format!(
                "more than the {cells} chunks that its sides and the file have room for"
            )));
        } else {
            chunks.push(Chunk {
                start,
                address: child,
                size: size.into(),
                skipped,
            });
        }
    }
    Ok(())
}

/// Reads a fixed array, giving each cell that was written.
fn fixed(
    file: &File<'_>,
    address: u64,
    page_bits: u8,
    cells: u64,
    filtered: bool,
    mut found: impl FnMut(u64, u64, Option<u64>, u32),
) -> Result<(), Fault> {
    let mut c = file.cursor_from(address)?;
    let start = c.at;
    c.expect(b"FAHD")?;
    c.skip(1)?;
    let client = c.u8()?;
    let entry = usize::from(c.u8()?);
    c.skip(1)?;
    let count = c.length()?;
    let block = c.offset()?;
    check(&mut c, start)?;
    let expected = if filtered {
        file.offset_size + 5
    } else {
        file.offset_size
    };
    if client != u8::from(filtered)
        || entry < expected
        || entry > file.offset_size + 12
        || count < cells
    {
        return Err(c.damaged(format!(
            "a chunk list of {count} entries of {entry} bytes, expected {cells} of at least {expected}"
        )));
    }
    if file.undefined(block) {
        return Ok(());
    }
    let mut c = file.cursor_from(block)?;
    let start = c.at;
    c.expect(b"FADB")?;
    c.skip(2 + file.offset_size)?;
    let mut entry_of = |c: &mut Cursor<'_>, cell: u64| -> Result<(), Fault> {
        let address = c.offset()?;
        let (size, skipped) = if filtered {
            (Some(c.unsigned(entry - file.offset_size - 4)?), c.u32()?)
        } else {
            c.skip(entry - file.offset_size)?;
            (None, 0)
        };
        if !file.undefined(address) && cell < cells {
            found(cell, address, size, skipped);
        }
        Ok(())
    };
    let page = 1_u64
        .checked_shl(page_bits.into())
        .unwrap_or(u64::MAX)
        .max(1);
    if count <= page {
        for cell in 0..count {
            entry_of(&mut c, cell)?;
        }
        return check(&mut c, start);
    }
    let pages = count.div_ceil(page);
    let written = c.take(to_usize(pages.div_ceil(8)))?;
    check(&mut c, start)?;
    for index in 0..pages {
        let first = index * page;
        let last = count.min(first.saturating_add(page));
        let bit = written[to_usize(index / 8)] >> (7 - index % 8) & 1;
        if bit == 0 {
            // Never written: its room is there all the same.
            c.skip(
                to_usize(last - first)
                    .saturating_mul(entry)
                    .saturating_add(4),
            )?;
            continue;
        }
        let start = c.at;
        for cell in first..last {
            entry_of(&mut c, cell)?;
        }
        check(&mut c, start)?;
    }
    Ok(())
}

/// The filters of a data set in the order of writing.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(super) struct Filters {
    ids: Vec<u16>,
}

impl Filters {
    /// `Ok(Err(..))` names a filter that is not read.
    pub(super) fn read(mut c: Cursor<'_>) -> Result<Result<Self, String>, Fault> {
        let (version, count) = (c.u8()?, c.u8()?);
        if !(1..=2).contains(&version) || count > 32 {
            return Err(c.damaged(format!(
                "{count} filters of version {version}, expected at most 32 of version 1 or 2"
            )));
        }
        if version == 1 {
            c.skip(6)?;
        }
        let mut ids = Vec::new();
        for _ in 0..count {
            let id = c.u16()?;
            let name = if version == 1 || id >= 256 {
                usize::from(c.u16()?)
            } else {
                0
            };
            let _flags = c.u16()?;
            let values = usize::from(c.u16()?);
            let padded = if version == 1 {
                name.next_multiple_of(8)
            } else {
                name
            };
            c.skip(padded)?;
            c.skip(4 * values)?;
            if version == 1 && values % 2 == 1 {
                c.skip(4)?;
            }
            if ![DEFLATE, SHUFFLE, FLETCHER32].contains(&id) {
                return Ok(Err(format!(
                    "it went through filter {id}, only gzip, shuffle and fletcher32 are read"
                )));
            }
            ids.push(id);
        }
        Ok(Ok(Filters { ids }))
    }

    pub(super) fn is_empty(&self) -> bool {
        self.ids.is_empty()
    }

    pub(super) fn deflates(&self) -> bool {
        self.ids.contains(&DEFLATE)
    }
}

/// Undoes filters, keeping its buffers from chunk to chunk.
#[derive(Debug)]
pub(super) struct Unfilter {
    inflater: Decompress,
    now: Vec<u8>,
    next: Vec<u8>,
}

impl Unfilter {
    pub(super) fn new() -> Self {
        Self {
            inflater: Decompress::new(true),
            now: Vec::new(),
            next: Vec::new(),
        }
    }

    /// The `length` bytes of a chunk; the caller has bounded `length`.
    pub(super) fn undo<'s>(
        &'s mut self,
        stored: &'s [u8],
        filters: &Filters,
        skipped: u32,
        element: usize,
        length: usize,
    ) -> Result<&'s [u8], String> {
        let mut untouched = true;
        for (i, &id) in filters.ids.iter().enumerate().rev() {
            if skipped >> i & 1 == 1 {
                continue;
            }
            let input: &[u8] = if untouched { stored } else { &self.now };
            match id {
                DEFLATE => {
                    // A checksum may have come between values and deflate.
                    let room = length + 4;
                    self.next.resize(room, 0);
                    self.inflater.reset(true);
                    let status = self
                        .inflater
                        .decompress(input, &mut self.next, FlushDecompress::Finish)
                        .map_err(|error| format!("it does not inflate: {error}"))?;
                    let written = usize::try_from(self.inflater.total_out()).unwrap_or(room);
                    if status != Status::StreamEnd {
                        return Err(format!("it does not inflate to {length} bytes"));
                    }
                    self.next.truncate(written);
                }
                SHUFFLE => {
                    self.next.clear();
                    let count = input.len() / element;
                    self.next.resize(input.len(), 0);
                    for (byte, plane) in input.chunks_exact(count.max(1)).take(element).enumerate()
                    {
                        for (to, from) in
                            self.next.iter_mut().skip(byte).step_by(element).zip(plane)
                        {
                            *to = *from;
                        }
                    }
                    let whole = count * element;
                    self.next[whole..].copy_from_slice(&input[whole..]);
                }
                _ => {
                    let (values, sum) = input
                        .split_last_chunk::<4>()
                        .ok_or("it is too short for its checksum")?;
                    if fletcher32(values) != u32::from_le_bytes(*sum) && !cfg!(fuzzing) {
                        return Err("its checksum is wrong".into());
                    }
                    self.next.clear();
                    self.next.extend_from_slice(values);
                }
            }
            std::mem::swap(&mut self.now, &mut self.next);
            untouched = false;
        }
        let out: &[u8] = if untouched { stored } else { &self.now };
        if out.len() != length {
            return Err(format!("it holds {} bytes, expected {length}", out.len()));
        }
        Ok(out)
    }
}

/// HDF5's Fletcher checksum, over big-endian pairs.
fn fletcher32(bytes: &[u8]) -> u32 {
    let (mut a, mut b) = (0_u32, 0_u32);
    let (pairs, rest) = bytes.as_chunks::<2>();
    // 360 pairs cannot overflow 32 bits.
    for block in pairs.chunks(360) {
        for pair in block {
            a += u32::from(u16::from_be_bytes(*pair));
            b += a;
        }
        a = (a & 0xFFFF) + (a >> 16);
        b = (b & 0xFFFF) + (b >> 16);
    }
    if let [last] = rest {
        a += u32::from(*last) << 8;
        b += a;
        a = (a & 0xFFFF) + (a >> 16);
        b = (b & 0xFFFF) + (b >> 16);
    }
    a = (a & 0xFFFF) + (a >> 16);
    b = (b & 0xFFFF) + (b >> 16);
    b << 16 | a
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test may panic")]
mod tests {
    use super::*;
    use flate2::{Compression, write::ZlibEncoder};
    use std::io::Write;

    #[test]
    fn a_chunk_that_inflates_beyond_its_length_is_refused_there() {
        let mut zlib = ZlibEncoder::new(Vec::new(), Compression::best());
        zlib.write_all(&vec![0; 10_000_000]).unwrap();
        let packed = zlib.finish().unwrap();
        let mut unfilter = Unfilter::new();
        let filters = Filters { ids: vec![DEFLATE] };
        let refused = unfilter.undo(&packed, &filters, 0, 8, 800).unwrap_err();
        assert_eq!(refused, "it does not inflate to 800 bytes");
        assert!(unfilter.next.capacity() + unfilter.now.capacity() < 4096);
    }
}
