//! A log on disk, read chunk by chunk.

use super::records::op;
use super::streams::{Order, Stream};
use super::walk::{MAGIC, RECORD_HEAD, Walked, is_known};
use super::{Log, clock, column, origin, seconds};
use crate::blocks::{
    BlockError, BlockOptions, Opened, WHOLE_DAMAGED, WHOLE_ORDER, WHOLE_RECORDS, WHOLE_TOPICS,
};
use crate::tags::tell_columns_apart;
use dgd_recording::Table;
use std::io::{Read, Seek, SeekFrom};

/// Bytes of a record that is held.
const MAX_RECORD: u64 = 64 << 20;
/// Messages of a topic after which they are looked at and let go.
const SETTLED_AT: usize = 1 << 12;

/// The messages of the only topic with numbers, in blocks.
pub(crate) struct LogBlocks {
    head: Table,
    rows: usize,
    start_ns: u64,
    /// Which of the streams of the log has the numbers, and which of its members are columns.
    stream: usize,
    members: Vec<usize>,
    /// Messages of a block, at least.
    block: usize,
    length: u64,
    pass: Pass,
}

/// Reading from the first record to the last.
#[derive(Default)]
struct Pass {
    log: Log,
    walked: Walked,
    at: u64,
    record: Vec<u8>,
}

enum Step {
    Record,
    /// The footer, behind which nothing is read.
    End,
    /// No record begins here.
    Lost,
    /// A record of more than [`MAX_RECORD`].
    Large,
}

impl LogBlocks {
    /// Reads a log of so many bytes once, to know what is in it.
    ///
    /// # Errors
    /// What [`super::read`] says of it, or what the source does.
    pub(crate) fn open(
        source: &mut (impl Read + Seek),
        length: u64,
        options: BlockOptions,
    ) -> Result<Opened<Self>, BlockError> {
        let mut pass = Pass::new();
        loop {
            let step = pass.step(source, length)?;
            let ended = match step {
                Step::Record => false,
                Step::End => true,
                Step::Lost => return Ok(Opened::Whole(WHOLE_DAMAGED)),
                Step::Large => return Ok(Opened::Whole(WHOLE_RECORDS)),
            };
            let mut settled = ended;
            for stream in &mut pass.log.streams {
                if ended || stream.log_ns.len() >= SETTLED_AT {
                    stream.settle();
                    settled = true;
                }
            }
            if settled && pass.log.numeric().nth(1).is_some() {
                return Ok(Opened::Whole(WHOLE_TOPICS));
            }
            if ended {
                break;
            }
        }
        let Pass {
            mut log,
            mut walked,
            ..
        } = pass;
        walked.close();
        let mut issues = log.tell(&walked).issues;
        let Some(at) = log.numeric().next() else {
            return Ok(Opened::Whole(WHOLE_TOPICS));
        };
        let stream = &mut log.streams[at];
        if stream.sort() != Order::AsLogged {
            return Ok(Opened::Whole(WHOLE_ORDER));
        }
        let (rows, start_ns) = (stream.messages(), stream.first_ns().unwrap_or(0));
        let zoned = stream.zoned;
        let units = &mut log.units[at];
        let tag = stream.clock_tag();
        let mut columns = vec![clock(tag.clone(), Vec::new())];
        let of = |path: &[u8]| {
            let prefixed = path == tag.as_bytes();
            column(&stream.topic, prefixed, path, units, Vec::new())
        };
        columns.extend(stream.met().map(|m| m.path.as_slice()).map(of));
        let met: Vec<&[u8]> = stream.met().map(|m| m.path.as_slice()).collect();
        let members =
            (0..stream.members.len()).filter(|k| met.contains(&stream.members[*k].path.as_slice()));
        log.budget.check(rows, met.len())?;
        issues.extend(tell_columns_apart(&mut columns));
        Ok(Opened::Blocks(Self {
            rows,
            start_ns,
            stream: at,
            block: (options.cells / columns.len()).max(1),
            members: members.collect(),
            head: Table {
                columns,
                issues,
                origin: origin(start_ns, zoned),
                clock: Some(0),
            },
            length,
            pass: Pass::new(),
        }))
    }

    pub(crate) fn head(&self) -> Table {
        self.head.clone()
    }

    pub(crate) fn rows(&self) -> usize {
        self.rows
    }

    pub(crate) fn rewind(&mut self) {
        self.pass = Pass::new();
    }

    /// Puts the next messages into the table; says whether there were any.
    pub(crate) fn next(
        &mut self,
        source: &mut (impl Read + Seek),
        table: &mut Table,
    ) -> Result<bool, BlockError> {
        loop {
            match self.pass.step(source, self.length)? {
                Step::Record => {}
                Step::End => break,
                // The first pass came through.
                Step::Lost | Step::Large => return Err(BlockError::Changed),
            }
            let mut read = 0;
            for (at, stream) in self.pass.log.streams.iter_mut().enumerate() {
                if at == self.stream {
                    read = stream.log_ns.len();
                } else {
                    stream.settle();
                }
            }
            if read >= self.block {
                break;
            }
        }
        let Some(stream) = self.pass.log.streams.get_mut(self.stream) else {
            return Ok(false);
        };
        if stream.log_ns.is_empty() {
            return Ok(false);
        }
        if table.columns.len() != self.head.columns.len() {
            *table = self.head.clone();
        }
        fill(stream, &self.members, self.start_ns, table)?;
        stream.settle();
        Ok(true)
    }
}

/// Moves the messages that the stream holds into the table.
fn fill(
    stream: &mut Stream,
    members: &[usize],
    start_ns: u64,
    table: &mut Table,
) -> Result<(), BlockError> {
    let rows = stream.log_ns.len();
    if stream.log_ns.iter().any(|ns| *ns < start_ns) {
        return Err(BlockError::Changed);
    }
    let Some((time, columns)) = table.columns.split_first_mut() else {
        return Ok(());
    };
    time.values = seconds(&stream.log_ns, start_ns);
    for (column, member) in columns.iter_mut().zip(members) {
        column.values.clear();
        // A member that comes later has no value yet.
        if let Some(member) = stream.members.get(*member) {
            column.values.extend_from_slice(&member.values);
        }
        column.values.resize(rows, f64::NAN);
    }
    Ok(())
}

impl Pass {
    fn new() -> Self {
        Self {
            at: MAGIC as u64,
            ..Self::default()
        }
    }

    /// Takes the record that comes next.
    fn step(&mut self, source: &mut (impl Read + Seek), length: u64) -> Result<Step, BlockError> {
        let Self {
            log,
            walked,
            at,
            record,
        } = self;
        let mut head = [0; RECORD_HEAD];
        if length.saturating_sub(*at) < RECORD_HEAD as u64 {
            return Ok(Step::Lost);
        }
        source.seek(SeekFrom::Start(*at))?;
        source.read_exact(&mut head)?;
        let [opcode, bytes @ ..] = head;
        let begin = *at;
        let size = u64::from_le_bytes(bytes).saturating_add(RECORD_HEAD as u64);
        if !is_known(opcode) || size > length - begin {
            return Ok(Step::Lost);
        }
        if opcode == op::FOOTER {
            return Ok(Step::End);
        }
        *at += size;
        if !matches!(opcode, op::CHUNK | op::SCHEMA | op::CHANNEL | op::MESSAGE) {
            return Ok(Step::Record);
        }
        if size > MAX_RECORD {
            return Ok(Step::Large);
        }
        record.clear();
        record.extend_from_slice(&head);
        let rest = size - RECORD_HEAD as u64;
        if source.take(rest).read_to_end(record)? as u64 != rest {
            return Err(BlockError::Changed);
        }
        match opcode {
            op::CHUNK => walked.chunk(record, begin, length, false, &mut |opcode, record| {
                log.take(opcode, record)
            })?,
            _ => log.take(opcode, &record[RECORD_HEAD..])?,
        }
        Ok(Step::Record)
    }
}
