//! The bytes of an HDF5 file, read by address and never past their end.

use crate::mat::Fault;

const SIGNATURE: &[u8; 8] = b"\x89HDF\r\n\x1a\n";

/// The file from its superblock on; addresses count from there.
#[derive(Debug, Clone, Copy)]
pub(super) struct File<'a> {
    pub(super) data: &'a [u8],
    /// Bytes before the superblock: MATLAB's text header.
    pub(super) base: usize,
    /// Bytes of an address.
    pub(super) offset_size: usize,
    /// Bytes of a length.
    pub(super) length_size: usize,
    /// Address of the root group's object header.
    pub(super) root: u64,
    /// Length that the file should have, from the superblock on.
    pub(super) end: u64,
}

/// Where the superblock begins: at 0, 512, 1024, 2048 and so on.
pub(super) fn signature(bytes: &[u8]) -> Option<usize> {
    let mut at = 0;
    loop {
        if bytes.get(at..at + 8)? == SIGNATURE {
            return Some(at);
        }
        at = if at == 0 { 512 } else { at.checked_mul(2)? };
    }
}

impl<'a> File<'a> {
    pub(super) fn open(bytes: &'a [u8]) -> Result<Self, Fault> {
        let base = signature(bytes)
            .ok_or_else(|| Fault::damaged("byte 512", "there is no HDF5 signature"))?;
        let mut file = File {
            data: &bytes[base..],
            base,
            offset_size: 8,
            length_size: 8,
            root: 0,
            end: 0,
        };
        let mut cursor = file.cursor(8, file.data.len().saturating_sub(8) as u64)?;
        let version = cursor.u8()?;
        match version {
            0 | 1 => {
                cursor.skip(4)?;
                file.sizes(&mut cursor)?;
                cursor.skip(if version == 0 { 9 } else { 13 })?;
                let mut cursor = Cursor { file, ..cursor };
                let _base = cursor.offset()?;
                let _free_space = cursor.offset()?;
                file.end = cursor.offset()?;
                let _driver = cursor.offset()?;
                let _name = cursor.offset()?;
                file.root = cursor.offset()?;
            }
            2 | 3 => {
                file.sizes(&mut cursor)?;
                cursor.skip(1)?;
                let mut cursor = Cursor { file, ..cursor };
                let _base = cursor.offset()?;
                let _extension = cursor.offset()?;
                file.end = cursor.offset()?;
                file.root = cursor.offset()?;
                let checked = &file.data[..cursor.at];
                if cursor.u32()? != lookup3(checked) && !cfg!(fuzzing) {
                    return Err(cursor.damaged("the checksum of the superblock is wrong"));
                }
            }
            _ => {
                return Err(
                    cursor.damaged(format!("superblock version {version}, expected 0 to 3"))
                );
            }
        }
        Ok(file)
    }

    fn sizes(&mut self, cursor: &mut Cursor<'a>) -> Result<(), Fault> {
        let (offset, length) = (cursor.u8()?, cursor.u8()?);
        if ![2, 4, 8].contains(&offset) || ![2, 4, 8].contains(&length) {
            return Err(cursor.damaged(format!(
                "addresses of {offset} and lengths of {length} bytes, expected 2, 4 or 8"
            )));
        }
        self.offset_size = offset.into();
        self.length_size = length.into();
        Ok(())
    }

    /// For messages: the byte of the file at this address.
    pub(super) fn place(&self, address: u64) -> String {
        format!("byte {}", address.saturating_add(self.base as u64))
    }

    /// `length` bytes at `address`.
    pub(super) fn bytes(&self, address: u64, length: u64) -> Result<&'a [u8], Fault> {
        let end = address.saturating_add(length);
        match (usize::try_from(address), usize::try_from(end)) {
            (Ok(start), Ok(end)) if end <= self.data.len() => Ok(&self.data[start..end]),
            _ => Err(Fault::truncated(
                self.place(address),
                format!(
                    "{length} bytes are expected there, the file has {}",
                    self.data.len() + self.base
                ),
            )),
        }
    }

    pub(super) fn cursor(&self, address: u64, length: u64) -> Result<Cursor<'a>, Fault> {
        let bytes = self.bytes(address, length)?;
        // `bytes` lies in `data`, so the address fits.
        let start = usize::try_from(address).unwrap_or(usize::MAX);
        Ok(Cursor {
            file: *self,
            at: start,
            end: start + bytes.len(),
        })
    }

    /// From `address` to the end of the file, for structures that say their own length.
    pub(super) fn cursor_from(&self, address: u64) -> Result<Cursor<'a>, Fault> {
        let left = (self.data.len() as u64).saturating_sub(address);
        if left == 0 {
            return Err(Fault::truncated(
                self.place(address),
                format!(
                    "something should stand there, the file has {} bytes",
                    self.data.len() + self.base
                ),
            ));
        }
        self.cursor(address, left)
    }

    /// The address that means "nowhere": all bits set.
    pub(super) fn undefined(&self, address: u64) -> bool {
        address == all_ones(self.offset_size)
    }
}

fn all_ones(bytes: usize) -> u64 {
    if bytes >= 8 {
        u64::MAX
    } else {
        (1 << (8 * bytes)) - 1
    }
}

/// Reads little-endian fields one after another.
#[derive(Debug, Clone)]
pub(super) struct Cursor<'a> {
    pub(super) file: File<'a>,
    /// Address of the next byte.
    pub(super) at: usize,
    end: usize,
}

impl<'a> Cursor<'a> {
    pub(super) fn damaged(&self, reason: impl Into<String>) -> Fault {
        Fault::damaged(self.file.place(self.at as u64), reason)
    }

    pub(super) fn left(&self) -> usize {
        self.end - self.at
    }

    pub(super) fn take(&mut self, count: usize) -> Result<&'a [u8], Fault> {
        if count > self.left() {
            return Err(if self.end == self.file.data.len() {
                Fault::truncated(
                    self.file.place(self.at as u64),
                    format!("{count} bytes are expected there, {} are left", self.left()),
                )
            } else {
                self.damaged(format!(
                    "{count} bytes are expected there, {} are left",
                    self.left()
                ))
            });
        }
        let start = self.at;
        self.at += count;
        Ok(&self.file.data[start..self.at])
    }

    /// A cursor over the next `count` bytes.
    pub(super) fn part(&mut self, count: usize) -> Result<Cursor<'a>, Fault> {
        let start = self.at;
        self.take(count)?;
        Ok(Cursor {
            file: self.file,
            at: start,
            end: start + count,
        })
    }

    pub(super) fn skip(&mut self, count: usize) -> Result<(), Fault> {
        self.take(count).map(|_| ())
    }

    pub(super) fn unsigned(&mut self, size: usize) -> Result<u64, Fault> {
        let mut eight = [0; 8];
        let bytes = self.take(size)?;
        let count = size.min(8);
        eight[..count].copy_from_slice(&bytes[..count]);
        Ok(u64::from_le_bytes(eight))
    }

    pub(super) fn u8(&mut self) -> Result<u8, Fault> {
        Ok(self.take(1)?[0])
    }

    pub(super) fn u16(&mut self) -> Result<u16, Fault> {
        let bytes = self.take(2)?;
        Ok(u16::from_le_bytes([bytes[0], bytes[1]]))
    }

    pub(super) fn u32(&mut self) -> Result<u32, Fault> {
        let bytes = self.take(4)?;
        Ok(u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]))
    }

    pub(super) fn offset(&mut self) -> Result<u64, Fault> {
        self.unsigned(self.file.offset_size)
    }

    pub(super) fn length(&mut self) -> Result<u64, Fault> {
        self.unsigned(self.file.length_size)
    }

    /// The four letters that open a structure.
    pub(super) fn expect(&mut self, signature: &[u8; 4]) -> Result<(), Fault> {
        let at = self.at;
        let found = self.take(4)?;
        if found != signature {
            return Err(Fault::damaged(
                self.file.place(at as u64),
                format!(
                    "found `{}`, expected `{}`",
                    found.escape_ascii(),
                    signature.escape_ascii()
                ),
            ));
        }
        Ok(())
    }
}

/// Bob Jenkins' `lookup3` hash, the checksum of HDF5's newer structures.
pub(super) fn lookup3(bytes: &[u8]) -> u32 {
    let start = 0xdead_beef_u32.wrapping_add(u32::try_from(bytes.len()).unwrap_or(u32::MAX));
    let [mut a, mut b, mut c] = [start; 3];
    let word = |bytes: &[u8], i: usize| {
        let mut four = [0; 4];
        for (to, from) in four.iter_mut().zip(bytes.iter().skip(4 * i)) {
            *to = *from;
        }
        u32::from_le_bytes(four)
    };
    let mut rest = bytes;
    while rest.len() > 12 {
        a = a.wrapping_add(word(rest, 0));
        b = b.wrapping_add(word(rest, 1));
        c = c.wrapping_add(word(rest, 2));
        a = a.wrapping_sub(c) ^ c.rotate_left(4);
        c = c.wrapping_add(b);
        b = b.wrapping_sub(a) ^ a.rotate_left(6);
        a = a.wrapping_add(c);
        c = c.wrapping_sub(b) ^ b.rotate_left(8);
        b = b.wrapping_add(a);
        a = a.wrapping_sub(c) ^ c.rotate_left(16);
        c = c.wrapping_add(b);
        b = b.wrapping_sub(a) ^ a.rotate_left(19);
        a = a.wrapping_add(c);
        c = c.wrapping_sub(b) ^ b.rotate_left(4);
        b = b.wrapping_add(a);
        rest = &rest[12..];
    }
    if rest.is_empty() {
        return c;
    }
    a = a.wrapping_add(word(rest, 0));
    b = b.wrapping_add(word(rest, 1));
    c = c.wrapping_add(word(rest, 2));
    c = (c ^ b).wrapping_sub(b.rotate_left(14));
    a = (a ^ c).wrapping_sub(c.rotate_left(11));
    b = (b ^ a).wrapping_sub(a.rotate_left(25));
    c = (c ^ b).wrapping_sub(b.rotate_left(16));
    a = (a ^ c).wrapping_sub(c.rotate_left(4));
    b = (b ^ a).wrapping_sub(a.rotate_left(14));
    (c ^ b).wrapping_sub(b.rotate_left(24))
}

#[cfg(test)]
mod tests {
    use super::lookup3;

    #[test]
    fn lookup3_gives_the_values_its_author_published() {
        assert_eq!(lookup3(b""), 0xdead_beef);
        assert_eq!(lookup3(b"Four score and seven years ago"), 0x1777_0551);
    }
}
