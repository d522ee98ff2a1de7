//! One variable of a MAT v5 file: flags, sides, name, and what hangs below.

use crate::mat::{
    Collector, Fault, Layout, MAX_COLUMNS, MAX_DEPTH, MAX_TEXT, Number, NumberKind, Sink, join,
};

use super::MI_MATRIX;
use super::source::Source;

const MI_INT32: u32 = 5;
const MI_UINT32: u32 = 6;
const COMPLEX: u32 = 0x0800;
/// MATLAB allows 63 characters; others write a few more.
const MAX_FIELD_NAME: u64 = 1024;
/// Bytes of all field names of one struct.
const MAX_FIELD_NAMES: u64 = 1 << 20;
const MAX_SIDES: u64 = 32;

/// Type and length of an element that is not a small one.
pub(super) fn element_tag(tag: &[u8], big_endian: bool) -> (u32, u32) {
    (word(tag, 0, big_endian), word(tag, 4, big_endian))
}

/// The 32-bit word at `at`; the callers have that many bytes, zero if not.
fn word(bytes: &[u8], at: usize, big_endian: bool) -> u32 {
    let four = bytes
        .get(at..)
        .and_then(|b| b.first_chunk::<4>())
        .copied()
        .unwrap_or_default();
    if big_endian {
        u32::from_be_bytes(four)
    } else {
        u32::from_le_bytes(four)
    }
}

/// A walk over one variable.
pub(super) struct Walk<'w, 'a> {
    pub(super) collector: &'w mut Collector,
    pub(super) source: &'w mut Source<'a>,
    pub(super) big_endian: bool,
    /// The variable or field being read, for messages.
    pub(super) reached: String,
    /// The element claims more bytes than the file has.
    pub(super) cut_short: bool,
    /// All values were read; only the checksum may still be missing.
    pub(super) complete: bool,
}

/// The opening of an element inside a variable.
struct Element {
    kind: u32,
    length: u64,
    /// A small element carries its data in its tag.
    small: Option<[u8; 4]>,
}

/// What a variable says of itself before its values.
struct Header {
    class: u32,
    complex: bool,
    dims: Vec<u64>,
    name: String,
}

impl Walk<'_, '_> {
    /// A compressed element: one variable, then the checksum.
    pub(super) fn compressed(&mut self) -> Result<(), Fault> {
        let mut tag = [0; 8];
        self.source.read_exact(&mut tag)?;
        let (kind, length) = element_tag(&tag, self.big_endian);
        if kind != MI_MATRIX {
            return Err(Fault::damaged(
                self.source.place(),
                format!("the compressed element holds type {kind}, expected {MI_MATRIX}"),
            ));
        }
        let length = u64::from(length);
        if length > self.source.remaining_at_most() && !self.cut_short {
            return Err(Fault::damaged(
                self.source.place(),
                format!(
                    "the variable claims {length} bytes, its compressed bytes hold at most {}",
                    self.source.remaining_at_most()
                ),
            ));
        }
        self.variable(length)?;
        self.complete = true;
        self.source.verify()
    }

    /// A top-level variable of `length` bytes.
    pub(super) fn variable(&mut self, length: u64) -> Result<(), Fault> {
        self.matrix("", length, 0)
    }

    /// Reads one array; `tag` is its joined name, empty at the top.
    fn matrix(&mut self, tag: &str, length: u64, depth: usize) -> Result<(), Fault> {
        self.reached.clear();
        self.reached.push_str(tag);
        let end = self.source.position() + length;
        if length == 0 {
            if !tag.is_empty() {
                self.collector.skip(tag, "it is empty");
            }
            return Ok(());
        }
        let Some(header) = self.header(end)? else {
            // An object of MATLAB's newer kind gives no sides.
            self.collector.skip(
                if tag.is_empty() { "an object" } else { tag },
                "it is a MATLAB object (table, timetable, string, datetime), which only \
                 MATLAB can open: save its columns as doubles",
            );
            return self.leave(end);
        };
        let own;
        let tag = if depth == 0 {
            own = header.name.clone();
            self.reached.push_str(&own);
            own.as_str()
        } else {
            tag
        };
        match header.class {
            // The unnamed top-level bytes behind MATLAB's objects.
            _ if tag.is_empty() => {}
            1 => self.cell(tag, &header, end, depth)?,
            2 => self.structure(tag, &header, end, depth)?,
            4 => self.text(tag, &header, end)?,
            6..=15 if header.complex => {
                self.collector.skip(tag, "it is complex, channels are real");
            }
            6..=15 => self.numeric(tag, &header, end)?,
            3 => self.collector.skip(tag, "it is an object"),
            5 => self
                .collector
                .skip(tag, "it is sparse, save it as `full(x)`"),
            16 | 17 => self
                .collector
                .skip(tag, "it is a function handle or object"),
            class => {
                return Err(Fault::damaged(
                    self.source.place(),
                    format!("array class {class} is unknown, expected 1 to 17"),
                ));
            }
        }
        self.leave(end)
    }

    /// Moves to the end of the array.
    fn leave(&mut self, end: u64) -> Result<(), Fault> {
        self.source.skip(end.saturating_sub(self.source.position()))
    }

    /// `None` for the newer objects, whose header says nothing of use here.
    fn header(&mut self, end: u64) -> Result<Option<Header>, Fault> {
        let flags = self.element(end)?;
        if flags.kind != MI_UINT32 || flags.length != 8 {
            return Err(Fault::damaged(
                self.source.place(),
                format!(
                    "array flags of type {} and {} bytes, expected type {MI_UINT32} and 8 bytes",
                    flags.kind, flags.length
                ),
            ));
        }
        let flags = self.bytes(&flags, 8)?;
        let flags = word(&flags, 0, self.big_endian);
        let class = flags & 0xFF;
        if class == 17 {
            return Ok(None);
        }
        let sides = self.element(end)?;
        if sides.kind != MI_INT32
            || sides.length % 4 != 0
            || !(4..=MAX_SIDES * 4).contains(&sides.length)
        {
            return Err(Fault::damaged(
                self.source.place(),
                format!(
                    "array sides of type {} and {} bytes, expected type {MI_INT32} and 4 bytes a side",
                    sides.kind, sides.length
                ),
            ));
        }
        let sides = self.bytes(&sides, MAX_SIDES * 4)?;
        let mut dims = Vec::new();
        for at in (0..sides.len()).step_by(4) {
            let side = word(&sides, at, self.big_endian);
            if side > i32::MAX.unsigned_abs() {
                return Err(Fault::damaged(
                    self.source.place(),
                    format!("an array side is {}", side.cast_signed()),
                ));
            }
            dims.push(u64::from(side));
        }
        let name = self.element(end)?;
        let name = self.bytes(&name, MAX_FIELD_NAME)?;
        Ok(Some(Header {
            class,
            complex: flags & COMPLEX != 0,
            dims,
            name: String::from_utf8_lossy(trim(&name)).into_owned(),
        }))
    }

    fn numeric(&mut self, tag: &str, header: &Header, end: u64) -> Result<(), Fault> {
        let layout = match Layout::of(&header.dims) {
            Ok(layout) if self.collector.has_room(tag, layout) => layout,
            Ok(_) => return Ok(()),
            Err(reason) => {
                self.collector.skip(tag, reason);
                return Ok(());
            }
        };
        let values = self.element(end)?;
        let Some(number) = stored(values.kind, self.big_endian) else {
            return Err(Fault::damaged(
                self.source.place(),
                format!("values of type {}, expected a numeric type", values.kind),
            ));
        };
        let (count, size) = (layout.len() as u64, number.size() as u64);
        if count.checked_mul(size) != Some(values.length) {
            return Err(Fault::damaged(
                self.source.place(),
                format!(
                    "{count} values of {size} bytes by its sides, but {} bytes of values",
                    values.length
                ),
            ));
        }
        self.collector.charge(tag, count)?;
        if let Some(small) = values.small {
            let mut sink = Sink::new(layout, 4);
            sink.append(
                &small[..usize::try_from(values.length).unwrap_or(0).min(4)],
                number,
            );
            self.collector.array(tag, sink);
            return Ok(());
        }
        // Believe the count as far as the bytes at hand make it plausible: the element's
        // size and what came out of it so far. Beyond, columns grow as values come.
        let shown = (self.source.element_bytes() as u64).max(self.source.position() / 8);
        let allowance = shown.max(1024).min(count);
        let mut sink = Sink::new(layout, usize::try_from(allowance).unwrap_or(0));
        self.source.numbers(layout.len(), number, &mut sink)?;
        self.pad(values.length, end)?;
        self.collector.array(tag, sink);
        Ok(())
    }

    fn text(&mut self, tag: &str, header: &Header, end: u64) -> Result<(), Fault> {
        let count: u64 = header.dims.iter().fold(1, |n, &d| n.saturating_mul(d));
        let rows = header.dims.first().copied().unwrap_or(0);
        let length = self.element(end)?;
        if rows > 1 || count > MAX_TEXT || length.length > MAX_TEXT * 4 {
            self.collector.skip(tag, "it is a block of text");
            return Ok(());
        }
        let kind = length.kind;
        let bytes = self.bytes(&length, MAX_TEXT * 4)?;
        let text = match kind {
            // 16-bit characters, as UTF-16 or as plain numbers.
            4 | 17 => {
                let (pairs, _) = bytes.as_chunks::<2>();
                let units = pairs.iter().map(|b| {
                    if self.big_endian {
                        u16::from_be_bytes(*b)
                    } else {
                        u16::from_le_bytes(*b)
                    }
                });
                char::decode_utf16(units)
                    .map(|c| c.unwrap_or(char::REPLACEMENT_CHARACTER))
                    .collect()
            }
            1 | 2 | 16 => String::from_utf8_lossy(&bytes).into_owned(),
            _ => {
                self.collector.skip(tag, "it is text of an unknown coding");
                return Ok(());
            }
        };
        self.collector.text(tag, text);
        Ok(())
    }

    fn structure(
        &mut self,
        tag: &str,
        header: &Header,
        end: u64,
        depth: usize,
    ) -> Result<(), Fault> {
        let width = self.element(end)?;
        let width = match (width.kind, self.bytes(&width, 4)?) {
            (MI_INT32, bytes) if bytes.len() == 4 => u64::from(word(&bytes, 0, self.big_endian)),
            _ => 0,
        };
        if !(1..=MAX_FIELD_NAME).contains(&width) {
            return Err(Fault::damaged(
                self.source.place(),
                format!("field names of {width} bytes, expected 1 to {MAX_FIELD_NAME}"),
            ));
        }
        let names = self.element(end)?;
        let names = self.bytes(&names, MAX_FIELD_NAMES)?;
        let width = usize::try_from(width).unwrap_or(usize::MAX);
        // A kilobyte inflates to a million names of one letter.
        if names.len() / width > MAX_COLUMNS {
            return Err(Fault::too_large(
                format!("the number of fields of `{tag}`"),
                (names.len() / width) as u64,
                MAX_COLUMNS as u64,
            ));
        }
        let names: Vec<String> = names
            .chunks_exact(width)
            .map(|name| String::from_utf8_lossy(trim(name)).into_owned())
            .collect();
        let count: u64 = header.dims.iter().fold(1, |n, &d| n.saturating_mul(d));
        if names.is_empty() || count == 0 {
            self.collector.skip(tag, "the struct is empty");
            return Ok(());
        }
        for element in 1..=count {
            let indexed;
            let head = if count == 1 {
                tag
            } else {
                indexed = format!("{tag}({element})");
                &indexed
            };
            for name in &names {
                self.child(join(head, name), end, depth)?;
            }
        }
        Ok(())
    }

    fn cell(&mut self, tag: &str, header: &Header, end: u64, depth: usize) -> Result<(), Fault> {
        let count: u64 = header.dims.iter().fold(1, |n, &d| n.saturating_mul(d));
        for element in 1..=count {
            self.child(Some(format!("{tag}{{{element}}}")), end, depth)?;
        }
        Ok(())
    }

    /// A field or a cell: an array of its own.
    fn child(&mut self, tag: Option<String>, end: u64, depth: usize) -> Result<(), Fault> {
        self.collector
            .count_part(tag.as_deref().unwrap_or("a field"))?;
        let element = self.element(end)?;
        if element.kind != MI_MATRIX || element.small.is_some() {
            return Err(Fault::damaged(
                self.source.place(),
                format!(
                    "`{}` opens with type {}, expected {MI_MATRIX}",
                    tag.as_deref().unwrap_or("a field"),
                    element.kind
                ),
            ));
        }
        match tag {
            Some(tag) if depth + 1 < MAX_DEPTH => self.matrix(&tag, element.length, depth + 1)?,
            tag => {
                let tag = tag.unwrap_or_else(|| "a field".into());
                self.collector
                    .skip(&tag, format!("it lies deeper than {MAX_DEPTH} levels"));
                self.source.skip(element.length)?;
            }
        }
        self.pad(element.length, end)
    }

    /// Reads the tag of an element that must end within the array.
    fn element(&mut self, end: u64) -> Result<Element, Fault> {
        let place = self.source.place();
        if self.source.position() + 8 > end {
            return Err(Fault::damaged(place, "the array ends before its parts do"));
        }
        let mut tag = [0; 8];
        self.source.read_exact(&mut tag)?;
        let (first, second) = element_tag(&tag, self.big_endian);
        if first >> 16 != 0 {
            let length = u64::from(first >> 16);
            if length > 4 {
                return Err(Fault::damaged(
                    place,
                    format!("a small element of {length} bytes, expected at most 4"),
                ));
            }
            return Ok(Element {
                kind: first & 0xFFFF,
                length,
                small: Some([tag[4], tag[5], tag[6], tag[7]]),
            });
        }
        let length = u64::from(second);
        let left = end - self.source.position();
        if length > left {
            return Err(Fault::damaged(
                place,
                format!("an element claims {length} bytes, {left} are left in its array"),
            ));
        }
        Ok(Element {
            kind: first,
            length,
            small: None,
        })
    }

    /// The data of a short element, with its padding.
    fn bytes(&mut self, element: &Element, limit: u64) -> Result<Vec<u8>, Fault> {
        if let Some(small) = element.small {
            let length = usize::try_from(element.length).unwrap_or(0).min(4);
            return Ok(small[..length].to_vec());
        }
        if element.length > limit {
            return Err(Fault::damaged(
                self.source.place(),
                format!(
                    "{} bytes where at most {limit} are expected",
                    element.length
                ),
            ));
        }
        let bytes = self.source.read_vec(element.length)?;
        self.pad(element.length, u64::MAX)?;
        Ok(bytes)
    }

    /// Skips the padding after `length` bytes, as far as the array reaches.
    fn pad(&mut self, length: u64, end: u64) -> Result<(), Fault> {
        let padding = length.next_multiple_of(8) - length;
        self.source
            .skip(padding.min(end.saturating_sub(self.source.position())))
    }
}

fn trim(name: &[u8]) -> &[u8] {
    let end = name.iter().position(|&b| b == 0).unwrap_or(name.len());
    &name[..end]
}

/// The stored type: MATLAB shrinks doubles to the smallest integers that hold them.
fn stored(kind: u32, big_endian: bool) -> Option<Number> {
    let kind = match kind {
        1 => NumberKind::I8,
        2 => NumberKind::U8,
        3 => NumberKind::I16,
        4 => NumberKind::U16,
        5 => NumberKind::I32,
        6 => NumberKind::U32,
        7 => NumberKind::F32,
        9 => NumberKind::F64,
        12 => NumberKind::I64,
        13 => NumberKind::U64,
        _ => return None,
    };
    Some(Number { kind, big_endian })
}
