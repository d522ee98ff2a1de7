//! The records of a log, as far as they can be trusted.

use super::records::{ChunkHead, op};
use crate::IngestError;
use ::mcap::sans_io::linear_reader::{LinearReadEvent, LinearReader, LinearReaderOptions};
use dgd_recording::{Issue, IssueKind};

pub(super) const MAGIC: usize = 8;
pub(super) const RECORD_HEAD: usize = 9;
/// Most that one chunk may hold once unpacked.
const MAX_CHUNK: u64 = 1 << 30;
/// A chunk may unpack to this, whatever its size ...
const SPARE_CHUNK: u64 = 4 << 20;
/// ... and to this many times its packed bytes; JSON samples reach about 30.
const MAX_EXPANSION: u64 = 1000;
/// All chunks together, beyond [`MAX_EXPANSION`] times the file.
const SPARE_FILE: u64 = 64 << 20;
/// Issues about single places; after that they are only counted.
const MAX_ISSUES: usize = 50;

/// What walking gave beside the records.
#[derive(Debug, Default)]
pub(super) struct Walked {
    pub(super) issues: Vec<Issue>,
    /// Where the log stops early, if it does.
    pub(super) truncated_at: Option<usize>,
    more_issues: usize,
    unpacked: u64,
}

/// Gives every schema, channel and message record to `sink`, chunk by chunk; a chunk
/// whose checksum is wrong is left out, and the walk goes on behind it.
///
/// # Errors
/// Those of `sink`, and [`IngestError::TooLarge`] when all chunks unpack to too much.
pub(super) fn walk(
    bytes: &[u8],
    sink: &mut impl FnMut(u8, &[u8]) -> Result<(), IngestError>,
) -> Result<Walked, IngestError> {
    let mut walked = Walked::default();
    let mut at = MAGIC;
    let mut last = at;
    loop {
        let Some(record) = Outer::at(bytes, at) else {
            // Cut off, or the last record's length is wrong and led astray.
            if let Some(next) = next_chunk(bytes, last + 1) {
                walked.tell(last as u64, format!("the record here, or the one after it, is damaged; reading continued at the next chunk, byte {next}"));
                (at, last) = (next, next);
                continue;
            }
            walked.truncated_at = Some(at);
            if let Some(rest @ [op::CHUNK, ..]) = bytes.get(at..) {
                walked.chunk(rest, at as u64, bytes.len() as u64, true, sink)?;
            }
            break;
        };
        match record.opcode {
            op::CHUNK => walked.chunk(record.bytes, at as u64, bytes.len() as u64, false, sink)?,
            op::SCHEMA | op::CHANNEL | op::MESSAGE => {
                sink(record.opcode, &record.bytes[RECORD_HEAD..])?;
            }
            op::FOOTER => break,
            _ => {}
        }
        last = at;
        at += record.bytes.len();
    }
    walked.close();
    Ok(walked)
}

/// A whole record outside of chunks, its head included.
struct Outer<'a> {
    opcode: u8,
    bytes: &'a [u8],
}

impl<'a> Outer<'a> {
    fn at(bytes: &'a [u8], at: usize) -> Option<Self> {
        let (opcode, length) = head(bytes, at)?;
        if !is_known(opcode) {
            return None;
        }
        let end = at
            .checked_add(RECORD_HEAD)?
            .checked_add(usize::try_from(length).ok()?)?;
        Some(Self {
            opcode,
            bytes: bytes.get(at..end)?,
        })
    }
}

/// Opcodes between the specified and the private ones are not in use yet.
pub(super) fn is_known(opcode: u8) -> bool {
    (op::HEADER..=op::DATA_END).contains(&opcode) || opcode >= 0x80
}

fn head(bytes: &[u8], at: usize) -> Option<(u8, u64)> {
    let head = bytes.get(at..at.checked_add(RECORD_HEAD)?)?;
    let length = head[1..].try_into().ok()?;
    Some((head[0], u64::from_le_bytes(length)))
}

/// The next place that is the head of a whole chunk in all its fields.
fn next_chunk(bytes: &[u8], from: usize) -> Option<usize> {
    (from..bytes.len()).find(|at| {
        bytes[*at] == op::CHUNK
            && Outer::at(bytes, *at).is_some_and(|chunk| {
                ChunkHead::read(&chunk.bytes[RECORD_HEAD..]).is_some_and(|head| {
                    let room = (chunk.bytes.len() - RECORD_HEAD - head.length) as u64;
                    head.known_compression && head.packed == room
                })
            })
    })
}

impl Walked {
    /// Says how many damaged places were not listed.
    pub(super) fn close(&mut self) {
        if self.more_issues > 0 {
            let message = format!("{} more damaged places", self.more_issues);
            self.issues.push(Issue {
                kind: IssueKind::Damaged,
                place: "log".into(),
                message,
            });
        }
    }

    fn tell(&mut self, at: u64, message: String) {
        if self.issues.len() == MAX_ISSUES {
            self.more_issues += 1;
            return;
        }
        self.issues.push(Issue {
            kind: IssueKind::Damaged,
            place: format!("byte {at}"),
            message,
        });
    }

    /// Reads one chunk; of a truncated one as much as can be unpacked, without its checksum.
    pub(super) fn chunk(
        &mut self,
        record: &[u8],
        at: u64,
        file: u64,
        truncated: bool,
        sink: &mut impl FnMut(u8, &[u8]) -> Result<(), IngestError>,
    ) -> Result<(), IngestError> {
        let head = ChunkHead::read(&record[RECORD_HEAD.min(record.len())..]);
        let Some(head) = head else {
            if !truncated {
                self.tell(
                    at,
                    "the head of this chunk is damaged; its messages were left out".into(),
                );
            }
            return Ok(());
        };
        let packed = head.packed.min(record.len() as u64);
        let limit = MAX_CHUNK.min(SPARE_CHUNK.saturating_add(packed.saturating_mul(MAX_EXPANSION)));
        if head.unpacked > limit {
            let found = head.unpacked;
            self.tell(at, format!("this chunk claims to unpack to {found} bytes, the limit is {limit}; its messages were left out"));
            return Ok(());
        }
        // Counted as claimed: the buffer is that large, however little comes out.
        self.unpacked += head.unpacked;
        let file_limit = SPARE_FILE.saturating_add(MAX_EXPANSION.saturating_mul(file));
        if self.unpacked > file_limit {
            return Err(IngestError::TooLarge {
                what: "all chunks, unpacked,".into(),
                claimed: self.unpacked,
                limit: file_limit,
            });
        }
        let options = LinearReaderOptions::default()
            .with_skip_start_magic(true)
            .with_skip_end_magic(true)
            .with_prevalidate_chunk_crcs(!truncated)
            .with_record_length_limit(usize::try_from(limit).unwrap_or(usize::MAX));
        let mut reader = LinearReader::new_with_options(options);
        // Without bytes behind the packed ones: the reader trusts lengths inside a chunk up to
        // the end of the record.
        let length = (head.length as u64).saturating_add(head.packed);
        let end = length.saturating_add(RECORD_HEAD as u64);
        let end = usize::try_from(end).unwrap_or(usize::MAX).min(record.len());
        let mut own_head = [op::CHUNK; RECORD_HEAD];
        own_head[1..].copy_from_slice(&length.to_le_bytes());
        reader.insert(RECORD_HEAD).copy_from_slice(&own_head);
        reader.notify_read(RECORD_HEAD);
        let mut rest = &record[RECORD_HEAD..end];
        let mut records = 0_u64;
        while let Some(event) = reader.next_event() {
            match event {
                Ok(LinearReadEvent::ReadRequest(wanted)) => {
                    let (now, later) = rest.split_at(wanted.min(rest.len()));
                    if !now.is_empty() {
                        reader.insert(now.len()).copy_from_slice(now);
                    }
                    reader.notify_read(now.len());
                    rest = later;
                }
                Ok(LinearReadEvent::Record { opcode, data }) => {
                    records += 1;
                    sink(opcode, data)?;
                }
                Err(_) if truncated => break,
                Err(error) => {
                    let kept = match records {
                        0 => "its messages were left out".to_owned(),
                        n => format!("what follows its first {n} records was left out"),
                    };
                    self.tell(at, format!("damaged chunk: {}; {kept}", plain(&error)));
                    break;
                }
            }
        }
        Ok(())
    }
}

/// The library's message as part of a sentence.
fn plain(error: &::mcap::McapError) -> String {
    let text = error.to_string();
    let mut letters = text.chars();
    let first = letters
        .next()
        .map(|c| c.to_lowercase().to_string())
        .unwrap_or_default();
    first + letters.as_str().trim_end_matches('.')
}
