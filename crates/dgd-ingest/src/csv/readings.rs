//! Texts with one reading a line, as historians and databases write them: time, tag, value.

mod series;

use super::layout::{Head, Layout, is_time_name};
use super::text::{cell, lines, words};
use super::{MAX_COLUMNS, plan};
use crate::tags::tell_columns_apart;
use crate::{IngestError, count};
use dgd_recording::{Column, Issue, IssueKind, Table};
pub(super) use series::Readings;
use std::collections::HashMap;

/// What the columns are called, small and without signs, that hold tags, values, units and judgements; what is likelier first.
const TAG: [&str; 30] = [
    "tag",
    "tagname",
    "tagid",
    "pitag",
    "pointname",
    "signalname",
    "channelname",
    "sensorid",
    "mnemonic",
    "point",
    "pointid",
    "signal",
    "channel",
    "variable",
    "sensor",
    "field",
    "metric",
    "parameter",
    "item",
    "itemid",
    "attribute",
    "series",
    "topic",
    "measurement",
    "path",
    "varname",
    "nodeid",
    "sensorname",
    "messstelle",
    "name",
];
/// Those of them that may be numbers.
const NUMBERED_TAG: [&str; 6] = ["tag", "tagid", "pointid", "sensorid", "itemid", "numericid"];
const VALUE: [&str; 15] = [
    "value",
    "numericvalue",
    "floatvalue",
    "doublevalue",
    "val",
    "pv",
    "reading",
    "data",
    "average",
    "avg",
    "mean",
    "varvalue",
    "samplevalue",
    "wert",
    "messwert",
];
const UNIT: [&str; 7] = [
    "unit",
    "units",
    "uom",
    "eu",
    "engunit",
    "engunits",
    "engineeringunits",
];
const QUALITY: [&str; 10] = [
    "qualitydetail",
    "opcquality",
    "quality",
    "status",
    "statuscode",
    "confidence",
    "valid",
    "good",
    "isgood",
    "dataintegrity",
];

/// Numbers beside the value that a line has at the most: a table with a channel a column has more. Beside a `Tag` and a `Value` any may stand.
const MOST_OTHERS: usize = 3;

/// Lines in which the quality 192 of OPC shows that it is written in numbers; and the least that is not bad.
const OPC_LINES: usize = 1000;
const OPC_GOOD: &[u8] = b"192";
const OPC_UNCERTAIN: u32 = 64;

/// Where a line has what tells its reading; indices of columns.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Places {
    times: Vec<usize>,
    tag: usize,
    value: usize,
    unit: Option<usize>,
    quality: Option<usize>,
    /// Numbers that are not read.
    others: Vec<usize>,
}

/// The tags of a text, in the order in which they come.
#[derive(Debug, Default)]
pub(super) struct Tags<'a> {
    names: Vec<String>,
    units: Vec<Option<String>>,
    numbers: HashMap<&'a [u8], usize>,
    /// Readings that are said to be bad, and the line of the first.
    bad: (u64, Option<u64>),
}

impl Places {
    /// The places in a text with a time, a tag and a value a line.
    pub(super) fn of(heads: &[Head], numeric: &[bool]) -> Option<Self> {
        let names: Vec<String> = heads.iter().map(plain).collect();
        let (numbers, texts): (Vec<usize>, Vec<usize>) = (0..heads.len())
            .filter(|i| heads[*i].named)
            .partition(|i| numeric[*i]);
        let is_time = |index: &usize| heads[*index].stamps || is_time_name(&heads[*index].tag);
        let (times, numbers): (Vec<usize>, Vec<usize>) = numbers.into_iter().partition(is_time);
        let find = |among: &[usize], wanted: &[&str]| {
            let called = |name: &&str| among.iter().copied().find(|i| names[*i] == **name);
            wanted.iter().find_map(called)
        };
        let numbered = || find(&numbers, &VALUE).and(find(&numbers, &NUMBERED_TAG));
        let tag = find(&texts, &TAG).or_else(numbered)?;
        let is_reading = |i: &&usize| **i != tag && !QUALITY.contains(&names[**i].as_str());
        let read: Vec<usize> = numbers.iter().filter(is_reading).copied().collect();
        let only = || read.first().filter(|_| read.len() == 1).copied();
        let value = find(&read, &VALUE).or_else(only)?;
        let others: Vec<usize> = read.into_iter().filter(|i| *i != value).collect();
        let is_plain = names[tag].starts_with("tag") && names[value] == "value";
        if others.len() > MOST_OTHERS && !is_plain {
            return None;
        }
        // Of a query's start, its end and the time, the time.
        let is_of_reading =
            |i: &usize| ["time", "date"].iter().any(|part| names[*i].contains(part));
        let (of_reading, rest): (Vec<usize>, Vec<usize>) =
            times.into_iter().partition(is_of_reading);
        let times = if of_reading.is_empty() {
            rest
        } else {
            of_reading
        };
        (!times.is_empty()).then(|| Self {
            times,
            tag,
            value,
            unit: find(&texts, &UNIT),
            quality: find(&texts, &QUALITY).or_else(|| find(&numbers, &QUALITY)),
            others,
        })
    }

    /// The text with the number of its tag in place of each tag and with nothing in cells that are not read, line by line; and the tags.
    ///
    /// # Errors
    /// [`IngestError::TooLarge`] for more tags than a table may have columns.
    pub(super) fn number<'a>(
        &self,
        text: &'a [u8],
        layout: &Layout,
    ) -> Result<(Vec<u8>, Tags<'a>), IngestError> {
        let header = layout.columns[self.tag].written.as_bytes();
        let mut out = Vec::with_capacity(text.len());
        out.extend_from_slice(&text[..layout.start]);
        let mut tags = Tags::default();
        let by_opc = self.has_opc_quality(text, layout);
        let (mut at, mut line) = (layout.start, layout.line);
        while at < text.len() {
            let (mut tag, mut unit, mut value, mut bad) = (None, None, 0..0, false);
            for index in 0.. {
                let cell = cell(text, at, layout.delimiter);
                let begin = out.len();
                let is_name = index == self.tag && cell.newlines == 0 && !cell.bytes.is_empty();
                if is_name && cell.bytes != header {
                    let number = tags.number(cell.bytes)?;
                    out.extend_from_slice(number.to_string().as_bytes());
                    tag = Some(number);
                } else if self.reads(index) || cell.newlines > 0 {
                    out.extend_from_slice(&text[at..cell.end]);
                }
                if index == self.value {
                    value = begin..out.len();
                }
                if Some(index) == self.unit && !cell.bytes.is_empty() {
                    unit = Some(cell.bytes);
                }
                bad |= Some(index) == self.quality && is_bad(cell.bytes, by_opc);
                line += u64::from(cell.newlines);
                at = cell.end + 1;
                out.extend(text.get(cell.end));
                if text.get(cell.end) != Some(&layout.delimiter) {
                    break;
                }
            }
            if let (Some(tag), Some(unit)) = (tag, unit) {
                tags.measure(tag, unit, line)?;
            }
            if bad && tag.is_some() {
                out[value].fill(b' ');
                tags.bad.0 += 1;
                tags.bad.1.get_or_insert(line);
            }
            line += 1;
        }
        Ok((out, tags))
    }

    /// Whether a good quality among the first lines is that of OPC: there are numbers in which 0 is good.
    fn has_opc_quality(&self, text: &[u8], layout: &Layout) -> bool {
        let Some(quality) = self.quality else {
            return false;
        };
        lines(text, layout.start, layout.line, layout.delimiter)
            .take(OPC_LINES)
            .any(|line| line.cells.get(quality) == Some(&OPC_GOOD))
    }

    /// Whether cells of a column are kept as they are written.
    fn reads(&self, index: usize) -> bool {
        index == self.tag || index == self.value || self.times.contains(&index)
    }

    /// The table of a text whose tags were numbered, with a column a tag, on one clock.
    ///
    /// # Errors
    /// [`IngestError`] if there is no reading, no date beside the times of the day, if most readings have the tag and the time of another, or for too many
    /// stamps of so many tags in so many `bytes`.
    pub(super) fn beside_each_other(
        &self,
        table: Table,
        layout: &Layout,
        tags: Tags<'_>,
        bytes: usize,
    ) -> Result<Table, IngestError> {
        let head = |index: usize| &layout.columns[index];
        let of = |index: usize| {
            let mut columns = table.columns.iter();
            columns.find(|column| column.tag == head(index).tag)
        };
        let clock = table.clock.and_then(|clock| table.columns.get(clock));
        let clock = clock.or_else(|| self.times.iter().find_map(|index| of(*index)));
        let (Some(clock), Some(numbers), Some(values)) = (clock, of(self.tag), of(self.value))
        else {
            return Err(plan::nothing(table.columns.len()));
        };
        let refused = |reason: String, mend: &str| IngestError::NotTabular {
            place: format!("column `{}`", clock.tag),
            reason,
            mend: mend.into(),
        };
        if table.origin.is_none() && self.times.iter().any(|index| head(*index).stamps) {
            return Err(refused(
                "times of the day without a date, in a text with one reading a line".into(),
                "export the date with them",
            ));
        }
        let mut readings = Readings::new(tags.names.len(), &clock.values);
        for ((at, number), value) in clock.values.iter().zip(&numbers.values).zip(&values.values) {
            readings.add(whole(*number), *at, *value);
        }
        let mut issues = table.issues.clone();
        issues.extend(tags.bad_issue());
        issues.extend(self.not_read(layout));
        let unit = clock.unit.as_deref().unwrap_or("s");
        let Some(told) = readings.onto_one_clock(&tags.names, unit) else {
            return Err(refused(
                format!(
                    "most readings have the time and the tag of another, with `{}` for the tags",
                    head(self.tag).tag
                ),
                "remove the column if it is not that of the tags or of the times",
            ));
        };
        issues.extend(told);
        readings.check(bytes)?;
        let mut columns = vec![Column {
            tag: clock.tag.clone(),
            unit: clock.unit.clone(),
            values: readings.stamps(),
        }];
        // Words of a second header are no tags.
        let named = tags.names.into_iter().zip(tags.units);
        let read = named.zip(readings.columns()).enumerate();
        for (_, ((tag, unit), values)) in read.filter(|(tag, _)| readings.has(*tag)) {
            columns.push(Column { tag, unit, values });
        }
        issues.extend(tell_columns_apart(&mut columns));
        Ok(Table {
            columns,
            issues,
            origin: table.origin,
            clock: table.clock.map(|_| 0),
        })
    }

    /// What to say of numbers beside the value.
    fn not_read(&self, layout: &Layout) -> Option<Issue> {
        let names = self
            .others
            .iter()
            .map(|index| format!("`{}`", layout.columns[*index].tag));
        let names: Vec<String> = names.collect();
        (!names.is_empty()).then(|| Issue {
            kind: IssueKind::Skipped,
            place: format!("line {}", layout.line),
            message: format!(
                "there is one reading a line, and it is taken from `{}`; not read: {}",
                layout.columns[self.value].tag,
                names.join(", ")
            ),
        })
    }
}

impl<'a> Tags<'a> {
    /// The number of a tag.
    ///
    /// # Errors
    /// [`IngestError::TooLarge`] for one too many.
    fn number(&mut self, name: &'a [u8]) -> Result<usize, IngestError> {
        if let Some(number) = self.numbers.get(name) {
            return Ok(*number);
        }
        let number = self.names.len();
        if number == MAX_COLUMNS {
            return Err(IngestError::TooLarge {
                what: "a text with one reading a line: its tags".into(),
                claimed: number as u64 + 1,
                limit: MAX_COLUMNS as u64,
            });
        }
        self.numbers.insert(name, number);
        self.names.push(words(name));
        self.units.push(None);
        Ok(number)
    }

    /// Whether there is one.
    pub(super) fn is_any(&self) -> bool {
        !self.names.is_empty()
    }

    /// Takes the unit of a reading.
    ///
    /// # Errors
    /// [`IngestError::NotTabular`] if it is another one than above: the readings of a tag are one column.
    fn measure(&mut self, tag: usize, unit: &[u8], line: u64) -> Result<(), IngestError> {
        let Some(own) = &self.units[tag] else {
            self.units[tag] = Some(words(unit));
            return Ok(());
        };
        if own.as_bytes() == unit || *own == words(unit) {
            return Ok(());
        }
        Err(IngestError::NotTabular {
            place: format!("line {line}"),
            reason: format!(
                "the tag `{}` is in `{}` here and in `{own}` above",
                self.names[tag],
                words(unit)
            ),
            mend: "export each tag in one unit".into(),
        })
    }

    fn bad_issue(&self) -> Option<Issue> {
        self.bad.1.map(|line| Issue {
            kind: IssueKind::UnreadableValue,
            place: format!("line {line}"),
            message: format!(
                "{} of bad quality, of which this is the first; read as NaN",
                count(self.bad.0, "reading")
            ),
        })
    }
}

/// The name of a column, small and without signs.
fn plain(head: &Head) -> String {
    let name = head.tag.chars().filter(|c| c.is_alphanumeric());
    name.collect::<String>().to_lowercase()
}

/// Whether a reading is said to be bad: in words, or in numbers of OPC.
fn is_bad(cell: &[u8], by_opc: bool) -> bool {
    const BAD: [&[u8]; 7] = [
        b"bad",
        b"invalid",
        b"false",
        b"i/o timeout",
        b"comm fail",
        b"not connected",
        b"no data",
    ];
    let number = || std::str::from_utf8(cell).ok()?.parse::<u32>().ok();
    let begins = |word: &&[u8]| {
        let begin = cell.get(..word.len());
        begin.is_some_and(|begin| begin.eq_ignore_ascii_case(word))
    };
    BAD.iter().any(begins) || by_opc && number().is_some_and(|number| number < OPC_UNCERTAIN)
}

/// The number of a tag, if it is one.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "of tags that were numbered, and not negative; others are none"
)]
fn whole(number: f64) -> Option<usize> {
    (number >= 0.0).then_some(number as usize)
}
