//! MAT v7.3 out: the same struct in HDF5, behind MATLAB's 512-byte header.
//!
//! Only HDF5's oldest structures are written (superblock 0, symbol tables, version 1
//! object headers and trees), which every reader knows.

use std::io::Write;

use dgd_recording::Table;
use flate2::Compression;
use flate2::write::ZlibEncoder;

use crate::error::ExportError;
use crate::mat::{ORIGIN, Struct, UNITS};

/// MATLAB's text header; addresses count from behind it.
const USER_BLOCK: usize = 512;
const SUPERBLOCK: usize = 96;
const UNDEFINED: u64 = u64::MAX;
/// Columns up to this length are stored as they are.
const SMALL: usize = 64;
/// MATLAB's own chunks are about this long.
const CHUNK: usize = 8192;
/// A tree node of HDF5's default size lists this many chunks; one node is enough for us.
const NODE_CHUNKS: usize = 64;
/// HDF5 counts the bytes of a chunk in 32 bits.
const MAX_CHUNK_BYTES: u64 = u32::MAX as u64;
const DEFLATE_LEVEL: u8 = 6;

/// Gives `table` as one struct named `root`, as MATLAB's `save -v7.3` would write it.
///
/// Each column becomes a field of n x 1 doubles under the name that
/// [`field_names`](crate::field_names) gives; units go to `root.units.<field>`, the start
/// time to `root.origin`. The fields come in the order of their names, for `MATLAB_fields`, which could say another, is not written.
/// The same table gives the same bytes. The file comes whole, for its header points to what follows.
///
/// # Errors
/// [`ExportError::NoColumns`], [`ExportError::Name`] if MATLAB would not take `root`,
/// [`ExportError::TooLarge`] for a column beyond 256 GiB.
pub fn write_mat73(table: &Table, root: &str) -> Result<Vec<u8>, ExportError> {
    let table = Struct::new(table, root)?;
    // One node holds all names of the largest group: half its places, as HDF5 counts.
    let most = table.fields.len() + 2;
    let half = most.div_ceil(2).max(4);
    let names_per_node = u16::try_from(half).map_err(|_| ExportError::TooLarge {
        what: "the number of columns".into(),
        bytes: most as u64,
        limit: 2 * u64::from(u16::MAX),
    })?;
    let mut file = Image {
        bytes: vec![0; USER_BLOCK + SUPERBLOCK],
        names_per_node: half * 2,
    };
    let mut fields = Vec::new();
    for (name, values) in &table.fields {
        fields.push((name.clone(), file.column(name, values)?));
    }
    if !table.units.is_empty() {
        let mut units = Vec::new();
        for (name, unit) in &table.units {
            units.push((name.clone(), file.text(unit)));
        }
        fields.push((UNITS.into(), file.group(units, true).header));
    }
    if let Some(origin) = table.origin {
        let origin = file.text(origin);
        fields.push((ORIGIN.into(), origin));
    }
    let variable = file.group(fields, true).header;
    let top = file.group(vec![(root.to_owned(), variable)], false);
    file.open(&top, names_per_node);
    Ok(file.bytes)
}

struct Image {
    bytes: Vec<u8>,
    names_per_node: usize,
}

struct Group {
    header: u64,
    tree: u64,
    heap: u64,
}

impl Image {
    /// Address of what is written next.
    fn here(&mut self) -> u64 {
        self.bytes.resize(self.bytes.len().next_multiple_of(8), 0);
        (self.bytes.len() - USER_BLOCK) as u64
    }

    fn put(&mut self, bytes: &[u8]) -> u64 {
        let at = self.here();
        self.bytes.extend_from_slice(bytes);
        at
    }

    /// The text header and the superblock, now that the root is known.
    fn open(&mut self, root: &Group, names_per_node: u16) {
        self.here();
        let end = self.bytes.len() as u64;
        let mut head = b"MATLAB 7.3 MAT-file, written by dgd-export, HDF5 schema 1.00 .".to_vec();
        head.resize(116, b' ');
        head.extend([0; 8]);
        head.extend([0, 2, b'I', b'M']);
        head.resize(USER_BLOCK, 0);
        head.extend(b"\x89HDF\r\n\x1a\n");
        // Versions of superblock, free space, root entry and shared headers; sizes.
        head.extend([0, 0, 0, 0, 0, 8, 8, 0]);
        head.extend(names_per_node.to_le_bytes());
        head.extend(16_u16.to_le_bytes());
        head.extend([0; 4]);
        head.extend((USER_BLOCK as u64).to_le_bytes());
        head.extend(UNDEFINED.to_le_bytes());
        head.extend(end.to_le_bytes());
        head.extend(UNDEFINED.to_le_bytes());
        head.extend(entry(0, root.header, Some((root.tree, root.heap))));
        self.bytes[..head.len()].copy_from_slice(&head);
    }

    /// A group of these names and object headers.
    fn group(&mut self, mut children: Vec<(String, u64)>, is_struct: bool) -> Group {
        children.sort();
        let mut names = vec![0; 8];
        let mut node = b"SNOD\x01\0".to_vec();
        node.extend(
            u16::try_from(children.len())
                .unwrap_or(u16::MAX)
                .to_le_bytes(),
        );
        let mut last = 0;
        for (name, header) in &children {
            last = names.len() as u64;
            node.extend(entry(last, *header, None));
            names.extend(name.as_bytes());
            names.push(0);
            names.resize(names.len().next_multiple_of(8), 0);
        }
        node.resize(8 + 40 * self.names_per_node, 0);
        let data = self.put(&names);
        let mut heap = b"HEAP\0\0\0\0".to_vec();
        heap.extend((names.len() as u64).to_le_bytes());
        // 1 stands for "no free room".
        heap.extend(1_u64.to_le_bytes());
        heap.extend(data.to_le_bytes());
        let heap = self.put(&heap);
        let node = self.put(&node);
        let mut tree = b"TREE\0\0\x01\0".to_vec();
        tree.extend(UNDEFINED.to_le_bytes());
        tree.extend(UNDEFINED.to_le_bytes());
        tree.extend(0_u64.to_le_bytes());
        tree.extend(node.to_le_bytes());
        tree.extend(last.to_le_bytes());
        tree.resize(24 + 32 * 16 + 8, 0);
        let tree = self.put(&tree);
        let mut table = tree.to_le_bytes().to_vec();
        table.extend(heap.to_le_bytes());
        let mut messages = vec![(0x11, table)];
        if is_struct {
            messages.push((0x0C, text_attribute("MATLAB_class", "struct")));
        }
        Group {
            header: self.object(&messages),
            tree,
            heap,
        }
    }

    fn object(&mut self, messages: &[(u16, Vec<u8>)]) -> u64 {
        let mut body = Vec::new();
        for (kind, message) in messages {
            let size = message.len().next_multiple_of(8);
            body.extend(kind.to_le_bytes());
            body.extend(u16::try_from(size).unwrap_or(u16::MAX).to_le_bytes());
            body.extend([0; 4]);
            body.extend(message);
            body.resize(body.len().next_multiple_of(8), 0);
        }
        let mut header = vec![1, 0];
        header.extend(
            u16::try_from(messages.len())
                .unwrap_or(u16::MAX)
                .to_le_bytes(),
        );
        header.extend(1_u32.to_le_bytes());
        header.extend(u32::try_from(body.len()).unwrap_or(u32::MAX).to_le_bytes());
        header.extend([0; 4]);
        header.extend(body);
        self.put(&header)
    }

    fn column(&mut self, name: &str, values: &[f64]) -> Result<u64, ExportError> {
        if values.is_empty() {
            return Ok(self.empty_column());
        }
        let class = (0x0C, text_attribute("MATLAB_class", "double"));
        let count = values.len() as u64;
        let space = (0x01, dataspace(&[1, count]));
        let kind = (0x03, double_type());
        let length = CHUNK
            .max(values.len().div_ceil(NODE_CHUNKS))
            .min(values.len());
        let chunk_bytes = u32::try_from(8 * length as u64).map_err(|_| ExportError::TooLarge {
            what: format!("a chunk of `{name}`"),
            bytes: 8 * length as u64,
            limit: MAX_CHUNK_BYTES,
        })?;
        if values.len() <= SMALL {
            let bytes: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
            let layout = self.contiguous(&bytes);
            return Ok(self.object(&[space, kind, (0x05, fill(2)), layout, class]));
        }
        let mut tree = b"TREE\x01\0".to_vec();
        let chunks = values.len().div_ceil(length);
        tree.extend(u16::try_from(chunks).unwrap_or(u16::MAX).to_le_bytes());
        tree.extend(UNDEFINED.to_le_bytes());
        tree.extend(UNDEFINED.to_le_bytes());
        let mut raw = Vec::new();
        for (index, chunk) in values.chunks(length).enumerate() {
            raw.clear();
            raw.extend(chunk.iter().flat_map(|v| v.to_le_bytes()));
            // HDF5 stores chunks whole, the last one too.
            raw.resize(8 * length, 0);
            let mut zlib = ZlibEncoder::new(Vec::new(), Compression::new(DEFLATE_LEVEL.into()));
            zlib.write_all(&raw)?;
            let squashed = zlib.finish()?;
            let address = self.put(&squashed);
            let stored = u32::try_from(squashed.len()).map_err(|_| ExportError::TooLarge {
                what: format!("a chunk of `{name}`"),
                bytes: squashed.len() as u64,
                limit: MAX_CHUNK_BYTES,
            })?;
            chunk_key(&mut tree, stored, (index * length) as u64);
            tree.extend(address.to_le_bytes());
        }
        chunk_key(&mut tree, 0, (chunks * length) as u64);
        tree.resize(24 + NODE_CHUNKS * 40 + 32, 0);
        let tree = self.put(&tree);
        let mut layout = vec![3, 2, 3];
        layout.extend(tree.to_le_bytes());
        layout.extend(1_u32.to_le_bytes());
        layout.extend((chunk_bytes / 8).to_le_bytes());
        layout.extend(8_u32.to_le_bytes());
        let mut filter = vec![1, 1, 0, 0, 0, 0, 0, 0];
        // Deflate: a name of 8 bytes, no flags, one value.
        filter.extend([1, 0, 8, 0, 0, 0, 1, 0]);
        filter.extend(b"deflate\0");
        filter.extend([DEFLATE_LEVEL, 0, 0, 0, 0, 0, 0, 0]);
        let messages = [
            space,
            kind,
            (0x05, fill(3)),
            (0x0B, filter),
            (0x08, layout),
            class,
        ];
        Ok(self.object(&messages))
    }

    /// MATLAB keeps the sides of an empty array as its values.
    fn empty_column(&mut self) -> u64 {
        let mut sides = 0_u64.to_le_bytes().to_vec();
        sides.extend(1_u64.to_le_bytes());
        let layout = self.contiguous(&sides);
        self.object(&[
            (0x01, dataspace(&[2])),
            (0x03, integer_type(8, false)),
            (0x05, fill(2)),
            layout,
            (0x0C, text_attribute("MATLAB_class", "double")),
            (
                0x0C,
                attribute("MATLAB_empty", &integer_type(1, false), &[1]),
            ),
        ])
    }

    /// Text as MATLAB keeps it: a row of 16-bit characters.
    fn text(&mut self, text: &str) -> u64 {
        let units: Vec<u8> = text.encode_utf16().flat_map(u16::to_le_bytes).collect();
        let layout = self.contiguous(&units);
        self.object(&[
            (0x01, dataspace(&[units.len() as u64 / 2, 1])),
            (0x03, integer_type(2, false)),
            (0x05, fill(2)),
            layout,
            (0x0C, text_attribute("MATLAB_class", "char")),
            (
                0x0C,
                attribute(
                    "MATLAB_int_decode",
                    &integer_type(4, true),
                    &2_i32.to_le_bytes(),
                ),
            ),
        ])
    }

    fn contiguous(&mut self, bytes: &[u8]) -> (u16, Vec<u8>) {
        let address = self.put(bytes);
        let mut layout = vec![3, 1];
        layout.extend(address.to_le_bytes());
        layout.extend((bytes.len() as u64).to_le_bytes());
        (0x08, layout)
    }
}

/// A symbol table entry; `cached` holds the tree and heap of a group.
fn entry(name: u64, header: u64, cached: Option<(u64, u64)>) -> Vec<u8> {
    let mut entry = name.to_le_bytes().to_vec();
    entry.extend(header.to_le_bytes());
    entry.extend(u64::from(cached.is_some()).to_le_bytes());
    let (tree, heap) = cached.unwrap_or((0, 0));
    entry.extend(tree.to_le_bytes());
    entry.extend(heap.to_le_bytes());
    entry
}

/// Stored bytes, no skipped filters, and the first element of a chunk.
fn chunk_key(tree: &mut Vec<u8>, stored: u32, start: u64) {
    tree.extend(stored.to_le_bytes());
    tree.extend([0; 4]);
    tree.extend(0_u64.to_le_bytes());
    tree.extend(start.to_le_bytes());
    tree.extend(0_u64.to_le_bytes());
}

fn dataspace(dims: &[u64]) -> Vec<u8> {
    let mut space = vec![1, u8::try_from(dims.len()).unwrap_or(u8::MAX)];
    space.extend([0; 6]);
    space.extend(dims.iter().flat_map(|d| d.to_le_bytes()));
    space
}

/// IEEE doubles, little-endian.
fn double_type() -> Vec<u8> {
    let mut kind = vec![0x11, 0x20, 63, 0];
    kind.extend(8_u32.to_le_bytes());
    kind.extend([0, 0, 64, 0, 52, 11, 0, 52, 255, 3, 0, 0]);
    kind
}

fn integer_type(size: u8, signed: bool) -> Vec<u8> {
    let mut kind = vec![0x10, if signed { 8 } else { 0 }, 0, 0];
    kind.extend(u32::from(size).to_le_bytes());
    kind.extend([0, 0, 8 * size, 0]);
    kind
}

/// The default fill value, allocated late (2) or as chunks come (3), written if set.
fn fill(allocation: u8) -> Vec<u8> {
    vec![2, allocation, 2, 1, 0, 0, 0, 0]
}

fn text_attribute(name: &str, text: &str) -> Vec<u8> {
    let mut kind = vec![0x13, 0, 0, 0];
    kind.extend(u32::try_from(text.len()).unwrap_or(u32::MAX).to_le_bytes());
    attribute(name, &kind, text.as_bytes())
}

fn attribute(name: &str, kind: &[u8], value: &[u8]) -> Vec<u8> {
    let space = dataspace(&[]);
    let size = |n: usize| u16::try_from(n).unwrap_or(u16::MAX).to_le_bytes();
    let mut attribute = vec![1, 0];
    attribute.extend(size(name.len() + 1));
    attribute.extend(size(kind.len()));
    attribute.extend(size(space.len()));
    for part in [&[name.as_bytes(), &[0]].concat(), kind, &space] {
        attribute.extend(part);
        attribute.resize(attribute.len().next_multiple_of(8), 0);
    }
    attribute.extend(value);
    attribute
}
