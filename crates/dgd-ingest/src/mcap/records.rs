//! The few records that matter here, read within their bounds.

pub(super) use ::mcap::records::op;

/// Message encoding and layout of a topic's messages.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Schema<'a> {
    pub(super) id: u16,
    pub(super) encoding: &'a str,
    pub(super) data: &'a [u8],
}

/// A topic, as one of the log's publishers announced it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Channel<'a> {
    pub(super) id: u16,
    pub(super) schema: u16,
    pub(super) topic: &'a str,
    pub(super) encoding: &'a str,
    pub(super) metadata: Vec<(&'a str, &'a str)>,
}

/// A message.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Message<'a> {
    pub(super) channel: u16,
    pub(super) log_ns: u64,
    pub(super) data: &'a [u8],
}

/// What stands before the packed bytes of a chunk.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct ChunkHead {
    /// Bytes of the head itself.
    pub(super) length: usize,
    pub(super) unpacked: u64,
    pub(super) packed: u64,
    pub(super) known_compression: bool,
}

struct Fields<'a>(&'a [u8]);

impl<'a> Fields<'a> {
    fn bytes(&mut self, count: usize) -> Option<&'a [u8]> {
        let (bytes, rest) = self.0.split_at_checked(count)?;
        self.0 = rest;
        Some(bytes)
    }

    fn u16(&mut self) -> Option<u16> {
        Some(u16::from_le_bytes(self.bytes(2)?.try_into().ok()?))
    }

    fn u32(&mut self) -> Option<u32> {
        Some(u32::from_le_bytes(self.bytes(4)?.try_into().ok()?))
    }

    fn u64(&mut self) -> Option<u64> {
        Some(u64::from_le_bytes(self.bytes(8)?.try_into().ok()?))
    }

    fn block(&mut self) -> Option<&'a [u8]> {
        let length = usize::try_from(self.u32()?).ok()?;
        self.bytes(length)
    }

    fn text(&mut self) -> Option<&'a str> {
        std::str::from_utf8(self.block()?).ok()
    }
}

impl<'a> Schema<'a> {
    pub(super) fn read(record: &'a [u8]) -> Option<Self> {
        let mut fields = Fields(record);
        let (id, _name) = (fields.u16()?, fields.text()?);
        Some(Self {
            id,
            encoding: fields.text()?,
            data: fields.block()?,
        })
    }
}

impl<'a> Channel<'a> {
    pub(super) fn read(record: &'a [u8]) -> Option<Self> {
        let mut fields = Fields(record);
        let (id, schema) = (fields.u16()?, fields.u16()?);
        let (topic, encoding) = (fields.text()?, fields.text()?);
        let mut pairs = Fields(fields.block()?);
        let mut metadata = Vec::new();
        while !pairs.0.is_empty() {
            metadata.push((pairs.text()?, pairs.text()?));
        }
        Some(Self {
            id,
            schema,
            topic,
            encoding,
            metadata,
        })
    }
}

impl<'a> Message<'a> {
    pub(super) fn read(record: &'a [u8]) -> Option<Self> {
        let mut fields = Fields(record);
        let (channel, _sequence) = (fields.u16()?, fields.u32()?);
        let (log_ns, _publish_ns) = (fields.u64()?, fields.u64()?);
        Some(Self {
            channel,
            log_ns,
            data: fields.0,
        })
    }
}

impl ChunkHead {
    /// From behind the record's opcode and length.
    pub(super) fn read(record: &[u8]) -> Option<Self> {
        let mut fields = Fields(record);
        fields.bytes(16)?; // first and last log time
        let unpacked = fields.u64()?;
        fields.u32()?; // checksum
        let known_compression = matches!(fields.block()?, b"" | b"lz4" | b"zstd");
        let packed = fields.u64()?;
        let length = record.len() - fields.0.len();
        Some(Self {
            length,
            unpacked,
            packed,
            known_compression,
        })
    }
}
