//! MCAP logs with JSON messages.
//!
//! The outer records are walked here and each chunk is handed to the library's reader
//! on its own, checksum first, so that damage costs one chunk. The clock is the log
//! time less the first log time; it is `t`, unless metadata of its channel name it ([`CLOCK_TAG`]).

mod blocks;
mod json;
mod records;
mod streams;
mod units;
mod walk;

pub(crate) use blocks::LogBlocks;

use crate::nearest::nearest;
use crate::tags::tell_columns_apart;
use crate::{IngestError, count};
use dgd_recording::{Column, Issue, IssueKind, Table};
use records::{Channel, Message, Schema, op};
use std::collections::{BTreeMap, HashMap};
use streams::{Budget, Order, Stream};
use units::Units;

/// Bytes of a topic's name; with several topics every column's name begins with it.
const MAX_TOPIC: usize = 1024;

/// Metadata of a channel that name the clock of its messages.
const CLOCK_TAG: &str = "time_tag";

/// Metadata of a channel, and their value, of log times whose zone nobody knows.
const ZONE: &str = "time_zone";
const UNKNOWN_ZONE: &str = "unknown";

/// Log times from 2001 on are wall-clock times; smaller ones count from the start of something.
const EPOCH_NS: u64 = 978_307_200_000_000_000;

/// What the records said so far.
#[derive(Default)]
struct Log {
    schemas: HashMap<u16, Units>,
    channels: HashMap<u16, Source>,
    streams: Vec<Stream>,
    /// Units of each stream's members.
    units: Vec<Units>,
    shelf: units::Shelf,
    /// Schemas that are too long to look for units in them.
    long_schemas: u64,
    by_topic: HashMap<String, usize>,
    budget: Budget,
    /// Messages that are no JSON, by topic and encoding.
    foreign: BTreeMap<(String, String), u64>,
    homeless: u64,
}

enum Source {
    Stream(usize),
    Foreign((String, String)),
}

/// Reads an MCAP log.
///
/// # Errors
/// [`IngestError`] if no message with a number in it can be had.
pub(crate) fn read(bytes: &[u8]) -> Result<Table, IngestError> {
    let mut log = Log::default();
    let walked = walk::walk(bytes, &mut |opcode, record| log.take(opcode, record))?;
    for stream in &mut log.streams {
        stream.close(&mut log.budget)?;
    }
    let Told {
        mut issues,
        messages,
    } = log.tell(&walked);
    let mut numeric: Vec<(Stream, Units)> = log
        .streams
        .into_iter()
        .zip(log.units)
        .filter(|(s, _)| !s.members.is_empty())
        .collect();
    if numeric.is_empty() {
        return Err(nothing(&issues, messages, walked.truncated_at));
    }
    // The busiest topic is the clock; of equals the first in the log.
    let busiest = (0..numeric.len())
        .rev()
        .max_by_key(|i| numeric[*i].0.log_ns.len())
        .unwrap_or(0);
    let log_ns = numeric[busiest].0.log_ns.clone();
    let starts = numeric
        .iter()
        .filter_map(|(s, _)| s.log_ns.iter().min().copied());
    let start_ns = starts.min().unwrap_or(0);
    let clock_tag = match &numeric[..] {
        [(only, _)] => only.clock_tag(),
        _ => "t".into(),
    };
    let mut columns = vec![clock(clock_tag.clone(), seconds(&log_ns, start_ns))];
    let several = numeric.len() > 1;
    let zoned = numeric.iter().all(|(stream, _)| stream.zoned);
    for (index, (stream, units)) in numeric.iter_mut().enumerate() {
        let sources = (index != busiest).then(|| nearest(&stream.log_ns, &log_ns));
        if let Some((_, moved_ns)) = sources.as_ref().filter(|(_, moved_ns)| *moved_ns > 0) {
            issues.push(Issue {
                kind: IssueKind::Jitter,
                place: format!("topic `{}`", stream.topic),
                message: format!(
                    "each of its messages was moved to the nearest one of the busiest topic, by up to {} s",
                    *moved_ns as f64 / 1e9
                ),
            });
        }
        issues.extend(
            sources
                .iter()
                .filter_map(|(sources, _)| left_out(stream, sources)),
        );
        for member in std::mem::take(&mut stream.members) {
            let values = match &sources {
                None => member.values,
                Some((sources, _)) => {
                    let at = |source: &Option<usize>| source.map_or(f64::NAN, |i| member.values[i]);
                    sources.iter().map(at).collect()
                }
            };
            let prefixed = several || member.path == clock_tag.as_bytes();
            columns.push(column(&stream.topic, prefixed, &member.path, units, values));
        }
    }
    issues.extend(tell_columns_apart(&mut columns));
    Ok(Table {
        columns,
        issues,
        origin: origin(start_ns, zoned),
        clock: Some(0),
    })
}

/// The clock's column.
fn clock(tag: String, values: Vec<f64>) -> Column {
    Column {
        tag,
        unit: Some("s".into()),
        values,
    }
}

/// Log times in s after the start.
fn seconds(log_ns: &[u64], start_ns: u64) -> Vec<f64> {
    let after = log_ns.iter().map(|ns| (ns - start_ns) as f64 / 1e9);
    after.collect()
}

/// The column of a member of a topic's messages, behind the topic's name if that must tell it from others; its unit is taken from `units`.
fn column(topic: &str, prefixed: bool, path: &[u8], units: &mut Units, values: Vec<f64>) -> Column {
    let path = match path {
        b"" => "value".to_owned(),
        path => String::from_utf8_lossy(path).into_owned(),
    };
    let tag = if prefixed {
        let topic = topic.trim_matches('/').replace('/', ".");
        format!("{topic}.{path}")
    } else {
        path.clone()
    };
    Column {
        tag,
        unit: units.remove(&path),
        values,
    }
}

/// The start as a wall-clock time, if it is one.
fn origin(start_ns: u64, zoned: bool) -> Option<String> {
    let wall_clock = i64::try_from(start_ns).ok()?;
    (start_ns >= EPOCH_NS).then(|| dgd_recording::rfc3339(wall_clock, zoned))
}

/// What was met beside the numbers.
struct Told {
    issues: Vec<Issue>,
    /// Messages of JSON topics.
    messages: usize,
}

impl Log {
    fn take(&mut self, opcode: u8, record: &[u8]) -> Result<(), IngestError> {
        match opcode {
            op::SCHEMA => {
                if let Some(schema) = Schema::read(record)
                    && !self.schemas.contains_key(&schema.id)
                {
                    let is_json = schema.encoding.eq_ignore_ascii_case("jsonschema");
                    let is_short = schema.data.len() <= units::MAX_SCHEMA;
                    self.long_schemas += u64::from(is_json && !is_short);
                    let units = if is_json && is_short {
                        units::from_schema(schema.data, &mut self.shelf)
                    } else {
                        Units::new()
                    };
                    self.schemas.insert(schema.id, units);
                }
            }
            op::CHANNEL => {
                if let Some(channel) = Channel::read(record)
                    && channel.topic.len() <= MAX_TOPIC
                    && !self.channels.contains_key(&channel.id)
                {
                    let source = self.announce(&channel);
                    self.channels.insert(channel.id, source);
                }
            }
            op::MESSAGE => {
                let message = Message::read(record);
                let source = message.and_then(|m| self.channels.get(&m.channel));
                match (message, source) {
                    (Some(message), Some(Source::Stream(index))) => {
                        let stream = &mut self.streams[*index];
                        stream.add(message.log_ns, message.data, &mut self.budget)?;
                    }
                    (Some(_), Some(Source::Foreign(key))) => {
                        // Looked up first: the key is cloned once, not for every message.
                        match self.foreign.get_mut(key) {
                            Some(count) => *count += 1,
                            None => _ = self.foreign.insert(key.clone(), 1),
                        }
                    }
                    _ => self.homeless += 1,
                }
            }
            _ => {}
        }
        Ok(())
    }

    /// The streams that have a number.
    fn numeric(&self) -> impl Iterator<Item = usize> {
        (0..self.streams.len()).filter(|at| self.streams[*at].met().next().is_some())
    }

    /// Puts every stream in order, and says what was wrong with the log.
    fn tell(&mut self, walked: &walk::Walked) -> Told {
        let mut issues = walked.issues.clone();
        let mut messages = 0;
        for stream in &mut self.streams {
            messages += stream.messages();
            tell(stream, &mut issues);
        }
        for ((topic, encoding), messages) in &self.foreign {
            issues.push(Issue {
                kind: IssueKind::Skipped,
                place: format!("topic `{topic}`"),
                message: format!(
                    "{} in `{encoding}`, not in `json`; passed over",
                    count(*messages, "message")
                ),
            });
        }
        let mut tell = |kind, place: String, message| {
            issues.push(Issue {
                kind,
                place,
                message,
            });
        };
        if self.homeless > 0 {
            let message = format!(
                "{} of a channel that the log does not describe, or with more than {MAX_TOPIC} bytes of topic; left out",
                count(self.homeless, "message")
            );
            tell(IssueKind::Damaged, "log".into(), message);
        }
        if self.long_schemas > 0 {
            let message = format!(
                "{} above the limit of {} bytes; their units were left out",
                count(self.long_schemas, "schema"),
                units::MAX_SCHEMA
            );
            tell(IssueKind::Skipped, "log".into(), message);
        }
        if let Some(message) = self.shelf.message() {
            tell(IssueKind::Skipped, "log".into(), message);
        }
        if let Some(at) = walked.truncated_at {
            let message = format!(
                "the log ends without its closing records; {} recovered",
                count(messages as u64, "message")
            );
            tell(IssueKind::Truncated, format!("byte {at}"), message);
        }
        Told { issues, messages }
    }

    fn announce(&mut self, channel: &Channel<'_>) -> Source {
        if !channel.encoding.eq_ignore_ascii_case("json") {
            return Source::Foreign((channel.topic.to_owned(), channel.encoding.to_owned()));
        }
        let mut units = Units::new();
        if let Some(schema) = self.schemas.get(&channel.schema) {
            self.shelf.copy(schema, &mut units);
        }
        units::add_metadata(channel, &mut units, &mut self.shelf);
        if let Some(index) = self.by_topic.get(channel.topic) {
            self.units[*index].extend(units);
            return Source::Stream(*index);
        }
        let metadata = |key: &str| {
            let mut all = channel.metadata.iter();
            all.find(|(k, _)| *k == key).map(|(_, value)| *value)
        };
        self.by_topic
            .insert(channel.topic.to_owned(), self.streams.len());
        let mut stream = Stream::new(channel.topic.to_owned());
        stream.named_clock = metadata(CLOCK_TAG)
            .filter(|tag| !tag.is_empty() && tag.len() <= MAX_TOPIC)
            .map(str::to_owned);
        stream.zoned = metadata(ZONE) != Some(UNKNOWN_ZONE);
        self.streams.push(stream);
        self.units.push(units);
        Source::Stream(self.streams.len() - 1)
    }
}

/// Puts a stream in order and says what was wrong with it.
fn tell(stream: &mut Stream, issues: &mut Vec<Issue>) {
    let place = format!("topic `{}`", stream.topic);
    let mut tell = |kind, message| {
        issues.push(Issue {
            kind,
            place: place.clone(),
            message,
        })
    };
    let (places, done) = match stream.sort() {
        Order::AsLogged => (0, ""),
        Order::Sorted(places) => (places, "the messages were put in order"),
        Order::SetBack(places) => (
            places,
            "two stretches share one time and were left as logged",
        ),
    };
    if places > 0 {
        tell(
            IssueKind::BackwardTime,
            format!(
                "log time runs backwards in {}; {done}",
                count(places as u64, "place")
            ),
        );
    }
    if let Some((number, byte)) = stream.first_refused {
        tell(
            IssueKind::Damaged,
            format!(
                "{} not in JSON, the first is number {number}, wrong at its byte {byte}; left out",
                count(stream.refused, "message")
            ),
        );
    }
    for member in stream.met() {
        if let Some((number, said)) = member.nulls.told() {
            let path = String::from_utf8_lossy(&member.path);
            let message = format!("member `{path}`: {said}, from message {number} on");
            tell(IssueKind::UnreadableValue, message);
        }
    }
    if stream.cut_arrays > 0 {
        tell(
            IssueKind::Skipped,
            format!(
                "{} with arrays of more than {} elements; the rest of those was skipped",
                count(stream.cut_arrays, "message"),
                json::MAX_ELEMENTS
            ),
        );
    }
}

/// How many messages of a stream are nobody's nearest.
fn left_out(stream: &Stream, sources: &[Option<usize>]) -> Option<Issue> {
    let mut used = vec![false; stream.log_ns.len()];
    for source in sources.iter().flatten() {
        used[*source] = true;
    }
    let left = used.iter().filter(|used| !**used).count();
    (left > 0).then(|| Issue {
        kind: IssueKind::Crowded,
        place: format!("topic `{}`", stream.topic),
        message: format!(
            "{left} of its {} are not the nearest to any of the busiest topic; left out",
            count(used.len() as u64, "message")
        ),
    })
}

fn nothing(issues: &[Issue], messages: usize, truncated_at: Option<usize>) -> IngestError {
    let damaged = issues.iter().find(|i| i.kind == IssueKind::Damaged);
    if let Some(issue) = damaged {
        return IngestError::Damaged {
            format: "MCAP",
            place: issue.place.clone(),
            reason: issue.message.clone(),
            mend: "copy the log from the recorder again".into(),
        };
    }
    if let Some(at) = truncated_at {
        return IngestError::Damaged {
            format: "MCAP",
            place: format!("byte {at}"),
            reason: "the log ends before its first message with a number".into(),
            mend: "copy the log from the recorder again".into(),
        };
    }
    let skipped = issues.iter().find(|i| i.kind == IssueKind::Skipped);
    IngestError::NothingNumeric {
        format: "MCAP",
        found: skipped.map_or_else(
            || format!("{messages} JSON messages without a number"),
            |issue| format!("{issue}; record them as JSON"),
        ),
    }
}
