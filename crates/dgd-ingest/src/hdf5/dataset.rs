//! Data sets: what a value is, how many there are, where they lie.

use crate::mat::{Fault, Number, NumberKind};

use super::file::{Cursor, File};
use super::object::to_usize;

const MAX_RANK: u8 = 32;

/// What one element is, as far as channels and units need it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Datatype {
    Number(Number),
    /// Text of this many bytes in place.
    Text {
        size: u32,
    },
    /// Text in a heap.
    LongText,
    /// Something else, in words.
    Other(&'static str),
}

impl Datatype {
    pub(super) fn read(c: &mut Cursor<'_>) -> Result<Self, Fault> {
        let head = c.u8()?;
        let (class, version) = (head & 0x0F, head >> 4);
        let bits = [c.u8()?, c.u8()?, c.u8()?];
        let size = c.u32()?;
        let big_endian = bits[0] & 1 != 0;
        Ok(match class {
            0 => {
                let (offset, precision) = (c.u16()?, c.u16()?);
                let kind = match (size, bits[0] & 8 != 0) {
                    (1, true) => NumberKind::I8,
                    (1, false) => NumberKind::U8,
                    (2, true) => NumberKind::I16,
                    (2, false) => NumberKind::U16,
                    (4, true) => NumberKind::I32,
                    (4, false) => NumberKind::U32,
                    (8, true) => NumberKind::I64,
                    (8, false) => NumberKind::U64,
                    _ => return Ok(Self::Other("of integers of an odd size")),
                };
                if offset != 0 || u32::from(precision) != 8 * size {
                    return Ok(Self::Other("of packed integers"));
                }
                Self::Number(Number { kind, big_endian })
            }
            1 => {
                let layout = c.take(12)?;
                // Bit offset, precision, exponent at and of, mantissa at and of, bias.
                let single = [0, 0, 32, 0, 23, 8, 0, 23, 127, 0, 0, 0];
                let double = [0, 0, 64, 0, 52, 11, 0, 52, 255, 3, 0, 0];
                let kind = match size {
                    4 if layout == single => NumberKind::F32,
                    8 if layout == double => NumberKind::F64,
                    _ => return Ok(Self::Other("of floats of an odd size")),
                };
                if bits[0] & 0x40 != 0 {
                    return Ok(Self::Other("of VAX floats"));
                }
                Self::Number(Number { kind, big_endian })
            }
            3 => Self::Text { size },
            6 => Self::Other("complex or compound"),
            7 => Self::Other("a cell or struct array (references)"),
            // An enumeration begins with the type that stores it: Python's booleans.
            8 if version >= 1 => match Self::read_base(c)? {
                Self::Number(number) => Self::Number(number),
                _ => Self::Other("an enumeration"),
            },
            9 if bits[0] & 0x0F == 1 => Self::LongText,
            _ => Self::Other("of a type that holds no numbers"),
        })
    }

    /// The type below an enumeration, which must not be one itself.
    fn read_base(c: &mut Cursor<'_>) -> Result<Self, Fault> {
        let mut ahead = c.clone();
        if ahead.u8()? & 0x0F == 8 {
            return Ok(Self::Other("an enumeration"));
        }
        Self::read(c)
    }
}

/// The sides of a dataspace, slowest first; none for a scalar, one of 0 for "no data".
pub(super) fn dims(c: &mut Cursor<'_>) -> Result<Vec<u64>, Fault> {
    let (version, rank) = (c.u8()?, c.u8()?);
    if rank > MAX_RANK || !(1..=2).contains(&version) {
        return Err(c.damaged(format!(
            "a dataspace of version {version} and {rank} sides, expected version 1 or 2 and at most {MAX_RANK}"
        )));
    }
    let _flags = c.u8()?;
    let kind = c.u8()?;
    if version == 1 {
        c.skip(4)?;
    } else if kind == 2 {
        return Ok(vec![0]);
    }
    (0..rank).map(|_| c.length()).collect()
}

/// Where the values lie.
#[derive(Debug, Clone)]
pub(super) enum Storage<'a> {
    /// Inside the object header.
    Compact(&'a [u8]),
    /// In one piece; `None` if nothing was ever written.
    Contiguous(Option<(u64, u64)>),
    Chunked(Chunked),
}

#[derive(Debug, Clone)]
pub(super) struct Chunked {
    /// Sides of a chunk, slowest first, without the element size.
    pub(super) sides: Vec<u64>,
    pub(super) index: Index,
    /// Address of the index; `None` if nothing was ever written.
    pub(super) address: Option<u64>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Index {
    Tree,
    /// One chunk holds all; its stored size and skipped filters, if filtered.
    Single(Option<(u64, u32)>),
    /// Unfiltered chunks one after another.
    Implicit,
    Fixed {
        page_bits: u8,
    },
}

impl<'a> Storage<'a> {
    /// `Ok(Err(..))` is a layout that is sound but not read, in words.
    pub(super) fn read(
        file: &File<'a>,
        c: &mut Cursor<'a>,
        rank: usize,
        element: usize,
    ) -> Result<Result<Self, &'static str>, Fault> {
        let version = c.u8()?;
        if !(3..=5).contains(&version) {
            return Ok(Err(
                "its storage layout is older than HDF5 1.6.3 or newer than 2.0",
            ));
        }
        let defined = |address: u64| (!file.undefined(address)).then_some(address);
        Ok(Ok(match (c.u8()?, version) {
            (0, _) => {
                let size = c.u16()?;
                Self::Compact(c.take(size.into())?)
            }
            (1, _) => {
                let (address, size) = (c.offset()?, c.length()?);
                Self::Contiguous(defined(address).map(|address| (address, size)))
            }
            (2, 3) => {
                let sides = usize::from(c.u8()?);
                let address = defined(c.offset()?);
                Self::Chunked(Chunked {
                    sides: chunk_sides(c, sides, 4, rank, element)?,
                    index: Index::Tree,
                    address,
                })
            }
            (2, _) => {
                let flags = c.u8()?;
                let sides = usize::from(c.u8()?);
                let width = usize::from(c.u8()?);
                if !(1..=8).contains(&width) {
                    return Err(c.damaged(format!("chunk sides of {width} bytes")));
                }
                let sides = chunk_sides(c, sides, width, rank, element)?;
                let index = match c.u8()? {
                    1 if flags & 2 != 0 => Index::Single(Some((c.length()?, c.u32()?))),
                    1 => Index::Single(None),
                    2 => Index::Implicit,
                    3 => Index::Fixed { page_bits: c.u8()? },
                    4 | 5 => {
                        return Ok(Err(
                            "it can grow and was saved for the newest readers only: save it again \
                             without `libver='latest'`",
                        ));
                    }
                    _ => return Err(c.damaged("an unknown chunk index")),
                };
                Self::Chunked(Chunked {
                    sides,
                    index,
                    address: defined(c.offset()?),
                })
            }
            (3, _) => return Ok(Err("it lies in other files (virtual)")),
            (class, _) => {
                return Err(c.damaged(format!("storage class {class}, expected 0 to 3")));
            }
        }))
    }
}

fn chunk_sides(
    c: &mut Cursor<'_>,
    found: usize,
    width: usize,
    rank: usize,
    element: usize,
) -> Result<Vec<u64>, Fault> {
    if found != rank + 1 {
        return Err(c.damaged(format!("chunks of {found} sides, expected {}", rank + 1)));
    }
    let mut sides = (0..found)
        .map(|_| c.unsigned(width))
        .collect::<Result<Vec<_>, _>>()?;
    let last = sides.pop().map(to_usize);
    if last != Some(element) || sides.contains(&0) {
        return Err(c.damaged("a chunk has no extent, or another element size than the data"));
    }
    Ok(sides)
}

/// The value of samples that were never written; 0 unless the file says otherwise.
pub(super) fn fill_value(mut c: Cursor<'_>, number: Number) -> f64 {
    let mut read = || -> Result<Option<f64>, Fault> {
        let version = c.u8()?;
        let defined = match version {
            1 | 2 => {
                c.skip(2)?;
                version == 1 || c.u8()? != 0
            }
            _ => c.u8()? & 0x20 != 0,
        };
        if version == 1 {
            c.skip(1)?;
        }
        if !defined || to_usize(c.u32()?.into()) != number.size() {
            return Ok(None);
        }
        let mut one = Vec::new();
        number.extend(c.take(number.size())?, &mut one);
        Ok(one.first().copied())
    };
    read().ok().flatten().unwrap_or(0.0)
}
