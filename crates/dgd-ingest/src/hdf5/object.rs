//! Object headers: the messages that describe a group or a data set.

use crate::mat::{Fault, MAX_TEXT};

use super::dataset::Datatype;
use super::file::{Cursor, File, lookup3};

/// Most messages and continuation blocks of one object.
const MAX_MESSAGES: usize = 65_536;
const MAX_BLOCKS: usize = 4096;

pub(super) const DATASPACE: u16 = 0x01;
pub(super) const LINK_INFO: u16 = 0x02;
pub(super) const DATATYPE: u16 = 0x03;
pub(super) const FILL_VALUE: u16 = 0x05;
pub(super) const LINK: u16 = 0x06;
pub(super) const LAYOUT: u16 = 0x08;
pub(super) const FILTERS: u16 = 0x0B;
pub(super) const ATTRIBUTE: u16 = 0x0C;
const CONTINUATION: u16 = 0x10;
pub(super) const SYMBOL_TABLE: u16 = 0x11;

/// One message of an object header.
#[derive(Debug, Clone)]
pub(super) struct Message<'a> {
    pub(super) kind: u16,
    /// The body stands elsewhere in the file, shared with other objects.
    pub(super) shared: bool,
    pub(super) body: Cursor<'a>,
}

/// The messages of one object.
#[derive(Debug)]
pub(super) struct Object<'a> {
    pub(super) messages: Vec<Message<'a>>,
}

impl<'a> Object<'a> {
    pub(super) fn read(file: &File<'a>, address: u64) -> Result<Self, Fault> {
        let mut cursor = file.cursor_from(address)?;
        let mut object = Object {
            messages: Vec::new(),
        };
        if file.bytes(address, 4).is_ok_and(|b| b == b"OHDR") {
            object.version_2(&mut cursor)?;
        } else {
            object.version_1(&mut cursor)?;
        }
        Ok(object)
    }

    pub(super) fn message(&self, kind: u16) -> Option<&Message<'a>> {
        self.messages.iter().find(|m| m.kind == kind)
    }

    fn push(
        &mut self,
        kind: u16,
        flags: u8,
        mut body: Cursor<'a>,
        blocks: &mut Vec<(u64, u64)>,
    ) -> Result<(), Fault> {
        if kind == CONTINUATION {
            blocks.push((body.offset()?, body.length()?));
            if blocks.len() > MAX_BLOCKS {
                return Err(body.damaged("the object header goes on without end"));
            }
        } else if kind != 0 {
            if self.messages.len() >= MAX_MESSAGES {
                return Err(body.damaged(format!("more than {MAX_MESSAGES} messages")));
            }
            self.messages.push(Message {
                kind,
                shared: flags & 2 != 0,
                body,
            });
        }
        Ok(())
    }

    fn version_1(&mut self, cursor: &mut Cursor<'a>) -> Result<(), Fault> {
        let version = cursor.u8()?;
        if version != 1 {
            return Err(cursor.damaged(format!("object header version {version}, expected 1 or 2")));
        }
        cursor.skip(1)?;
        let mut count = cursor.u16()?;
        cursor.skip(4)?;
        let size = cursor.u32()?;
        cursor.skip(4)?;
        let mut block = cursor.part(to_usize(size.into()))?;
        let (mut blocks, mut done) = (Vec::new(), 0);
        loop {
            while count > 0 && block.left() >= 8 {
                count -= 1;
                let kind = block.u16()?;
                let size = block.u16()?;
                let flags = block.u8()?;
                block.skip(3)?;
                let body = block.part(size.into())?;
                self.push(kind, flags, body, &mut blocks)?;
            }
            let Some(&(address, length)) = blocks.get(done) else {
                return Ok(());
            };
            done += 1;
            block = cursor.file.cursor(address, length)?;
        }
    }

    fn version_2(&mut self, cursor: &mut Cursor<'a>) -> Result<(), Fault> {
        let start = cursor.at;
        cursor.expect(b"OHDR")?;
        let version = cursor.u8()?;
        if version != 2 {
            return Err(cursor.damaged(format!("object header version {version}, expected 2")));
        }
        let flags = cursor.u8()?;
        if flags & 0x20 != 0 {
            cursor.skip(16)?;
        }
        if flags & 0x10 != 0 {
            cursor.skip(4)?;
        }
        let size = cursor.unsigned(1 << (flags & 3))?;
        let mut block = cursor.part(to_usize(size))?;
        check(cursor, start)?;
        let (mut blocks, mut done) = (Vec::new(), 0);
        loop {
            let head = if flags & 4 != 0 { 6 } else { 4 };
            while block.left() >= head {
                let kind = block.u8()?;
                let size = block.u16()?;
                let message_flags = block.u8()?;
                block.skip(head - 4)?;
                let body = block.part(size.into())?;
                self.push(kind.into(), message_flags, body, &mut blocks)?;
            }
            let Some(&(address, length)) = blocks.get(done) else {
                return Ok(());
            };
            done += 1;
            let mut whole = cursor.file.cursor(address, length)?;
            let start = whole.at;
            whole.expect(b"OCHK")?;
            let inner = whole.left().saturating_sub(4);
            block = whole.part(inner)?;
            check(&mut whole, start)?;
        }
    }

    /// The attributes that stand in the header itself and can be understood.
    pub(super) fn attributes(&self) -> Vec<Attribute> {
        self.messages
            .iter()
            .filter(|m| m.kind == ATTRIBUTE && !m.shared)
            .filter_map(|m| attribute(m.body.clone()).ok().flatten())
            .collect()
    }
}

pub(super) fn to_usize(value: u64) -> usize {
    usize::try_from(value).unwrap_or(usize::MAX)
}

/// Verifies the checksum at the cursor over everything since `start`.
pub(super) fn check(cursor: &mut Cursor<'_>, start: usize) -> Result<(), Fault> {
    let expected = lookup3(&cursor.file.data[start..cursor.at]);
    if cursor.u32()? != expected && !cfg!(fuzzing) {
        return Err(Fault::damaged(
            cursor.file.place(start as u64),
            "the checksum of this structure is wrong",
        ));
    }
    Ok(())
}

/// A small attribute.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Attribute {
    pub(super) name: String,
    pub(super) value: Value,
}

#[derive(Debug, Clone, PartialEq)]
pub(super) enum Value {
    Text(String),
    Number(f64),
    Other,
}

fn attribute(mut body: Cursor<'_>) -> Result<Option<Attribute>, Fault> {
    let version = body.u8()?;
    if !(1..=3).contains(&version) {
        return Ok(None);
    }
    let flags = body.u8()?;
    let (name, datatype, dataspace) = (body.u16()?, body.u16()?, body.u16()?);
    if version == 3 {
        body.skip(1)?;
    }
    let padded = |n: u16| {
        let n = usize::from(n);
        if version == 1 {
            n.next_multiple_of(8)
        } else {
            n
        }
    };
    let name = text(body.take(padded(name))?);
    let mut datatype = body.part(padded(datatype))?;
    let mut dataspace = body.part(padded(dataspace))?;
    let other = Attribute {
        name: name.clone(),
        value: Value::Other,
    };
    if version > 1 && flags & 3 != 0 {
        return Ok(Some(other));
    }
    let Ok(datatype) = Datatype::read(&mut datatype) else {
        return Ok(Some(other));
    };
    let dims = super::dataset::dims(&mut dataspace)?;
    if dims.iter().any(|&d| d != 1) {
        return Ok(Some(other));
    }
    let value = match datatype {
        Datatype::Number(number) => {
            let mut one = Vec::new();
            number.extend(body.take(number.size())?, &mut one);
            one.first().map_or(Value::Other, |&v| Value::Number(v))
        }
        Datatype::Text { size } if u64::from(size) <= MAX_TEXT => {
            Value::Text(text(body.take(to_usize(size.into()))?))
        }
        Datatype::LongText => {
            let length = body.u32()?;
            let (heap, index) = (body.offset()?, body.u32()?);
            Value::Text(text(global_heap(&body.file, heap, index, length)?))
        }
        _ => Value::Other,
    };
    Ok(Some(Attribute { name, value }))
}

/// Object `index` of the global heap collection at `address`.
fn global_heap<'a>(
    file: &File<'a>,
    address: u64,
    index: u32,
    length: u32,
) -> Result<&'a [u8], Fault> {
    let mut cursor = file.cursor_from(address)?;
    cursor.expect(b"GCOL")?;
    cursor.skip(4)?;
    let size = cursor.length()?;
    let header = 8 + file.length_size;
    let mut cursor = cursor.part(to_usize(size.saturating_sub(header as u64)))?;
    loop {
        let id = cursor.u16()?;
        cursor.skip(6)?;
        let size = to_usize(cursor.length()?);
        if id == 0 || u64::from(length) > MAX_TEXT {
            return Err(cursor.damaged(format!("the text {index} is not in its heap")));
        }
        let mut object = cursor.part(size.checked_next_multiple_of(8).unwrap_or(size))?;
        if u32::from(id) == index {
            return object.take(to_usize(length.into()).min(size));
        }
    }
}

/// Text up to the first zero byte.
pub(super) fn text(bytes: &[u8]) -> String {
    let end = bytes.iter().position(|&b| b == 0).unwrap_or(bytes.len());
    String::from_utf8_lossy(&bytes[..end]).into_owned()
}
