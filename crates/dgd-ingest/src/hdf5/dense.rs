//! Large groups of newer files: links in a fractal heap, listed by a version 2 B-tree.

use crate::mat::Fault;

use super::file::{Cursor, File};
use super::group::MAX_LINKS;
use super::object::{check, to_usize};

/// A fractal heap, as far as links need it.
struct Heap {
    id_size: usize,
    offset_bytes: usize,
    length_bytes: usize,
    width: u64,
    start_size: u64,
    max_direct: u64,
    root: u64,
    /// Rows of the root block; 0 if it is one direct block.
    rows: u16,
}

/// The records that a group's name index lists, each a link message.
pub(super) fn records<'a>(
    file: &File<'a>,
    heap: u64,
    index: u64,
) -> Result<Vec<Cursor<'a>>, Fault> {
    let heap = Heap::read(file, heap)?;
    let mut ids = Vec::new();
    tree(file, index, heap.id_size, &mut ids)?;
    ids.iter().map(|id| heap.record(file, id)).collect()
}

impl Heap {
    fn read(file: &File<'_>, address: u64) -> Result<Self, Fault> {
        let mut c = file.cursor_from(address)?;
        let start = c.at;
        c.expect(b"FRHP")?;
        c.skip(1)?;
        let id_size = c.u16()?;
        let filters = c.u16()?;
        c.skip(1)?;
        let max_managed = c.u32()?;
        c.skip(2 * file.length_size + 2 * file.offset_size)?;
        c.skip(8 * file.length_size)?;
        let width = c.u16()?;
        let start_size = c.length()?;
        let max_direct = c.length()?;
        let heap_bits = c.u16()?;
        c.skip(2)?;
        let root = c.offset()?;
        let rows = c.u16()?;
        if filters != 0 {
            return Err(c.damaged("a compressed heap of names, which is not read"));
        }
        check(&mut c, start)?;
        if !(1..=32).contains(&width)
            || rows > 64
            || start_size == 0
            || !start_size.is_power_of_two()
            || max_direct < start_size
            || !max_direct.is_power_of_two()
            || !(1..=64).contains(&heap_bits)
            || !(2..=64).contains(&id_size)
        {
            return Err(c.damaged("a heap of impossible shape"));
        }
        Ok(Heap {
            id_size: id_size.into(),
            offset_bytes: usize::from(heap_bits).div_ceil(8),
            length_bytes: bytes_for(max_direct).min(bytes_for(max_managed.into())),
            width: width.into(),
            start_size,
            max_direct,
            root,
            rows,
        })
    }

    fn row_size(&self, row: u16) -> Option<u64> {
        self.start_size
            .checked_shl(u32::from(row.saturating_sub(1)))
    }

    /// The object that this identifier names.
    fn record<'a>(&self, file: &File<'a>, id: &[u8]) -> Result<Cursor<'a>, Fault> {
        let at = file.place(self.root);
        let damaged = |reason: &str| Fault::damaged(at.clone(), reason);
        let number = |from: usize, count: usize| {
            let mut eight = [0; 8];
            for (to, from) in eight.iter_mut().zip(id.iter().skip(from).take(count)) {
                *to = *from;
            }
            u64::from_le_bytes(eight)
        };
        if id.first().is_none_or(|flags| flags & 0x30 != 0) {
            return Err(damaged("a name too long for its heap, which is not read"));
        }
        let offset = number(1, self.offset_bytes);
        let length = number(1 + self.offset_bytes, self.length_bytes);
        let (block, start) = if self.rows == 0 {
            (self.root, 0)
        } else {
            self.block(file, offset)?
        };
        let inside = offset
            .checked_sub(start)
            .ok_or_else(|| damaged("a name lies outside its heap"))?;
        file.cursor(block.saturating_add(inside), length)
    }

    /// Address and heap offset of the direct block under the root that holds `offset`.
    fn block(&self, file: &File<'_>, offset: u64) -> Result<(u64, u64), Fault> {
        let (mut address, mut base, mut rows) = (self.root, 0_u64, self.rows);
        // Each step goes one level down; there are no more levels than bits.
        for _ in 0..64 {
            let mut c = file.cursor_from(address)?;
            c.expect(b"FHIB")?;
            c.skip(1 + file.offset_size + self.offset_bytes)?;
            let mut found = None;
            'rows: for row in 0..rows {
                let size = self
                    .row_size(row)
                    .ok_or_else(|| c.damaged("a heap of impossible shape"))?;
                for _ in 0..self.width {
                    let child = c.offset()?;
                    let end = base.saturating_add(size);
                    if offset < end {
                        found = Some((child, size));
                        break 'rows;
                    }
                    base = end;
                }
            }
            let Some((child, size)) = found else {
                return Err(c.damaged("a name lies outside its heap"));
            };
            if size <= self.max_direct {
                return Ok((child, base));
            }
            address = child;
            // A child of `size` bytes has as many rows as fill it.
            let first_row = self.start_size.saturating_mul(self.width);
            let ratio = (size / first_row.max(1)).max(1);
            rows = u16::try_from(ratio.ilog2() + 1).unwrap_or(u16::MAX);
        }
        Err(Fault::damaged(
            file.place(self.root),
            "a heap without bottom",
        ))
    }
}

/// Bytes that hold values up to `max`.
fn bytes_for(max: u64) -> usize {
    (64 - max.leading_zeros() as usize).div_ceil(8).max(1)
}

/// Gathers the heap identifiers of a version 2 B-tree of link names.
fn tree(
    file: &File<'_>,
    address: u64,
    id_size: usize,
    ids: &mut Vec<Vec<u8>>,
) -> Result<(), Fault> {
    let mut c = file.cursor_from(address)?;
    let start = c.at;
    c.expect(b"BTHD")?;
    c.skip(1)?;
    let kind = c.u8()?;
    let node_size = c.u32()?;
    let record_size = usize::from(c.u16()?);
    let depth = c.u16()?;
    c.skip(2)?;
    let root = c.offset()?;
    let count = c.u16()?;
    c.skip(file.length_size)?;
    check(&mut c, start)?;
    if kind != 5 || record_size != id_size + 4 || depth > 16 {
        return Err(c.damaged(format!(
            "an index of type {kind}, {record_size} bytes and depth {depth}, expected the names of a group"
        )));
    }
    // Bytes of the record counts in inner nodes follow from how many fit below.
    let room = |pointer: usize| {
        (to_usize(node_size.into()).saturating_sub(10 + pointer)) / (record_size + pointer)
    };
    let count_bytes = bytes_for(room(0) as u64);
    let mut total_bytes = vec![0];
    let mut total = room(0) as u64;
    for level in 1..usize::from(depth) {
        let per_node = room(file.offset_size + count_bytes + total_bytes[level - 1]) as u64;
        total = total.saturating_mul(per_node + 1).saturating_add(per_node);
        total_bytes.push(bytes_for(total));
    }
    let tree = Tree {
        file: *file,
        record_size,
        count_bytes,
        total_bytes,
    };
    tree.node(root, count.into(), depth, ids)
}

struct Tree<'a> {
    file: File<'a>,
    record_size: usize,
    /// Bytes of a child's record count.
    count_bytes: usize,
    /// Bytes of the record total below a child, by the child's height over the leaves.
    total_bytes: Vec<usize>,
}

impl Tree<'_> {
    fn node(
        &self,
        address: u64,
        count: u64,
        depth: u16,
        ids: &mut Vec<Vec<u8>>,
    ) -> Result<(), Fault> {
        let mut c = self.file.cursor_from(address)?;
        let start = c.at;
        c.expect(if depth == 0 { b"BTLF" } else { b"BTIN" })?;
        c.skip(2)?;
        for _ in 0..count {
            if ids.len() > MAX_LINKS {
                return Err(c.damaged(format!("a group of more than {MAX_LINKS} names")));
            }
            let record = c.take(self.record_size)?;
            ids.push(record.get(4..).unwrap_or(&[]).to_vec());
        }
        if depth == 0 {
            return check(&mut c, start);
        }
        let total_bytes = self
            .total_bytes
            .get(usize::from(depth) - 1)
            .copied()
            .unwrap_or(0);
        let mut children = Vec::new();
        for _ in 0..=count {
            let child = c.offset()?;
            let records = c.unsigned(self.count_bytes)?;
            c.skip(total_bytes)?;
            children.push((child, records));
        }
        check(&mut c, start)?;
        for (child, records) in children {
            self.node(child, records, depth - 1, ids)?;
        }
        Ok(())
    }
}
