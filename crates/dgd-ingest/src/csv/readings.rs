//! Texts with one reading a line, as historians and databases write them: time, tag, value.

use super::layout::{Head, Layout, is_time_name};
use super::text::{cell, words};
use super::{MAX_COLUMNS, plan};
use crate::nearest::{left_out, median_step, nearest};
use crate::tags::tell_columns_apart;
use crate::{IngestError, count};
use dgd_recording::{Column, Issue, IssueKind, Table};
use std::collections::HashMap;

/// What the columns are called, small and without signs, that hold tags, values, units and judgements.
const TAG: [&str; 24] = [
    "tag",
    "tagname",
    "tagid",
    "name",
    "point",
    "pointname",
    "pointid",
    "signal",
    "signalname",
    "channel",
    "channelname",
    "variable",
    "sensor",
    "sensorid",
    "mnemonic",
    "series",
    "measurement",
    "metric",
    "parameter",
    "item",
    "itemid",
    "attribute",
    "topic",
    "field",
];
const VALUE: [&str; 11] = [
    "value",
    "val",
    "pv",
    "reading",
    "data",
    "numericvalue",
    "floatvalue",
    "doublevalue",
    "average",
    "avg",
    "mean",
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
const QUALITY: [&str; 5] = ["quality", "status", "statuscode", "confidence", "valid"];

/// Cells that the table may have for every byte of the text, and beyond: few of them are readings where each tag has its own times.
const CELLS_A_BYTE: u64 = 4;
const SPARE_CELLS: u64 = 1 << 20;

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
    /// Where a tag has another unit than above: line, tag and unit.
    other_unit: Option<(u64, usize, String)>,
}

/// The readings of a tag.
#[derive(Debug, Default)]
struct Series {
    at_ns: Vec<u64>,
    values: Vec<f64>,
}

/// The stamps of a table.
#[derive(Debug)]
struct Stamps {
    at_ns: Vec<u64>,
    /// Whether they are those of all tags, not of the busiest alone.
    of_all: bool,
}

impl Places {
    /// The places in a text with a time, a tag in words and a value a line.
    pub(super) fn of(heads: &[Head], numeric: &[bool]) -> Option<Self> {
        let called = |names: &[&str], index: &usize| {
            let name = heads[*index].tag.chars().filter(|c| c.is_alphanumeric());
            names.contains(&name.collect::<String>().to_lowercase().as_str())
        };
        let is_time = |index: &usize| heads[*index].stamps || is_time_name(&heads[*index].tag);
        let (numbers, texts): (Vec<usize>, Vec<usize>) = (0..heads.len())
            .filter(|i| heads[*i].named)
            .partition(|i| numeric[*i]);
        let (times, numbers): (Vec<usize>, Vec<usize>) = numbers.into_iter().partition(is_time);
        let find = |among: &[usize], names: &[&str]| {
            among.iter().copied().find(|index| called(names, index))
        };
        let tag = find(&texts, &TAG)?;
        let quality = find(&texts, &QUALITY);
        let only = || {
            let mut read = numbers.iter().filter(|index| !called(&QUALITY, index));
            read.next().filter(|_| read.next().is_none()).copied()
        };
        let value = find(&numbers, &VALUE).or_else(only)?;
        if times.is_empty() {
            return None;
        }
        Some(Self {
            times,
            tag,
            value,
            unit: find(&texts, &UNIT),
            quality,
            others: numbers
                .into_iter()
                .filter(|index| *index != value)
                .collect(),
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
                bad |= Some(index) == self.quality && is_bad(cell.bytes);
                line += u64::from(cell.newlines);
                at = cell.end + 1;
                out.extend(text.get(cell.end));
                if text.get(cell.end) != Some(&layout.delimiter) {
                    break;
                }
            }
            if let (Some(tag), Some(unit)) = (tag, unit) {
                tags.measure(tag, unit, line);
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

    /// Whether cells of a column are kept as they are written.
    fn reads(&self, index: usize) -> bool {
        index == self.tag || index == self.value || self.times.contains(&index)
    }

    /// The table of a text whose tags were numbered, with a column a tag, on one clock.
    ///
    /// That is all stamps there are; where tags are polled each at its own instants, those of the tag that has most readings.
    ///
    /// # Errors
    /// [`IngestError`] if there is no reading, no date beside the times of the day, or too many stamps for so many tags.
    pub(super) fn beside_each_other(
        &self,
        table: Table,
        layout: &Layout,
        tags: Tags<'_>,
        bytes: usize,
    ) -> Result<Table, IngestError> {
        let head = |index: usize| &layout.columns[index];
        let of = |index: usize| {
            table
                .columns
                .iter()
                .find(|column| column.tag == head(index).tag)
        };
        let clock = table.clock.and_then(|clock| table.columns.get(clock));
        let clock = clock.or_else(|| self.times.iter().find_map(|index| of(*index)));
        let (Some(clock), Some(numbers), Some(values)) = (clock, of(self.tag), of(self.value))
        else {
            return Err(plan::nothing(table.columns.len()));
        };
        if table.origin.is_none() && self.times.iter().any(|index| head(*index).stamps) {
            return Err(IngestError::NotTabular {
                place: format!("column `{}`", clock.tag),
                reason: "times of the day without a date, in a text with one reading a line".into(),
                mend: "export the date with them".into(),
            });
        }
        let from_s = clock.values.iter().copied().fold(f64::INFINITY, f64::min);
        let mut series: Vec<Series> = tags.names.iter().map(|_| Series::default()).collect();
        let mut without_place = 0;
        for ((at_s, number), value) in clock.values.iter().zip(&numbers.values).zip(&values.values)
        {
            match series.get_mut(whole(*number)) {
                Some(series) if at_s.is_finite() && number.is_finite() => {
                    series.at_ns.push(nanoseconds(at_s - from_s));
                    series.values.push(*value);
                }
                _ => without_place += 1,
            }
        }
        let mut issues = table.issues.clone();
        issues.extend(tags.issues());
        if without_place > 0 {
            issues.push(Issue {
                kind: IssueKind::MissingTime,
                place: "text".into(),
                message: format!(
                    "{} without a time or a tag; left out",
                    count(without_place, "line")
                ),
            });
        }
        issues.extend(self.not_read(layout));
        for (series, name) in series.iter_mut().zip(&tags.names) {
            issues.extend(series.put_in_order(name));
        }
        let stamps = Stamps::of(&series);
        stamps.check(series.len(), bytes)?;
        let mut columns = vec![Column {
            tag: clock.tag.clone(),
            unit: clock.unit.clone(),
            values: (stamps.at_ns.iter())
                .map(|ns| from_s + *ns as f64 / 1e9)
                .collect(),
        }];
        let mut moved = Moved::default();
        for ((series, name), unit) in series.iter().zip(tags.names).zip(tags.units) {
            let values = series.at(&stamps, &name, &mut moved);
            columns.push(Column {
                tag: name,
                unit,
                values,
            });
        }
        issues.extend(moved.issues());
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

/// What became of readings on the stamps of another tag.
#[derive(Debug, Default)]
struct Moved {
    farthest_ns: u64,
    /// Tags whose readings were moved.
    tags: Vec<String>,
    left_out: usize,
}

impl Moved {
    fn add(&mut self, tag: &str, farthest_ns: u64, left_out: usize) {
        self.farthest_ns = self.farthest_ns.max(farthest_ns);
        self.left_out += left_out;
        if farthest_ns > 0 {
            self.tags.push(format!("`{tag}`"));
        }
    }

    fn issues(&self) -> impl Iterator<Item = Issue> {
        let place = || match self.tags.first() {
            Some(first) => format!("tag {first}"),
            None => "text".into(),
        };
        let others = match self.tags.len() {
            0 | 1 => String::new(),
            tags => format!(" and of {}", count(tags as u64 - 1, "other tag")),
        };
        let moved = (self.farthest_ns > 0).then(|| Issue {
            kind: IssueKind::Jitter,
            place: place(),
            message: format!(
                "its readings{others} were moved to the nearest ones of the busiest tag, by up to {} s",
                self.farthest_ns as f64 / 1e9
            ),
        });
        let left = (self.left_out > 0).then(|| Issue {
            kind: IssueKind::Crowded,
            place: place(),
            message: format!(
                "{}, those of all tags together, are not the nearest to any of the busiest tag; left out",
                count(self.left_out as u64, "reading")
            ),
        });
        moved.into_iter().chain(left)
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

    /// Takes the unit of a reading.
    fn measure(&mut self, tag: usize, unit: &[u8], line: u64) {
        match &self.units[tag] {
            None => self.units[tag] = Some(words(unit)),
            Some(own) if own.as_bytes() == unit => {}
            Some(own) => {
                let unit = words(unit);
                if *own != unit && self.other_unit.is_none() {
                    self.other_unit = Some((line, tag, unit));
                }
            }
        }
    }

    fn issues(&self) -> impl Iterator<Item = Issue> {
        let bad = self.bad.1.map(|line| Issue {
            kind: IssueKind::UnreadableValue,
            place: format!("line {line}"),
            message: format!(
                "{} of bad quality, of which this is the first; read as NaN",
                count(self.bad.0, "reading")
            ),
        });
        let other = self.other_unit.as_ref().map(|(line, tag, unit)| {
            let (name, own) = (&self.names[*tag], self.units[*tag].as_deref().unwrap_or_default());
            Issue {
                kind: IssueKind::UnitDisagrees,
                place: format!("line {line}"),
                message: format!("`{name}` is in `{unit}` here and in `{own}` above; all is read as `{own}`: export each tag in one unit"),
            }
        });
        bad.into_iter().chain(other)
    }
}

impl Series {
    /// Puts the readings in order of time; of those with one stamp the first stays.
    fn put_in_order(&mut self, tag: &str) -> Option<Issue> {
        let mut order: Vec<usize> = (0..self.at_ns.len()).collect();
        order.sort_by_key(|i| self.at_ns[*i]);
        order.dedup_by_key(|i| self.at_ns[*i]);
        let repeats = self.at_ns.len() - order.len();
        self.at_ns = order.iter().map(|i| self.at_ns[*i]).collect();
        self.values = order.iter().map(|i| self.values[*i]).collect();
        (repeats > 0).then(|| Issue {
            kind: IssueKind::DuplicateTime,
            place: format!("tag `{tag}`"),
            message: format!(
                "{} with the time of another; of each such time the first was kept",
                count(repeats as u64, "reading")
            ),
        })
    }

    /// Whether it is polled: most steps are as long as the usual one, give or take a half.
    fn is_polled(&self) -> bool {
        let usual = median_step(&self.at_ns);
        let steps = self.at_ns.windows(2).map(|pair| pair[1] - pair[0]);
        let even = steps
            .filter(|step| 2 * step.abs_diff(usual) <= usual)
            .count();
        self.at_ns.len() > 2 && 5 * even >= 4 * (self.at_ns.len() - 1)
    }

    /// The values at the stamps of the table, NaN where there is none.
    fn at(&self, stamps: &Stamps, tag: &str, moved: &mut Moved) -> Vec<f64> {
        if stamps.of_all {
            let mut own = self.at_ns.iter().zip(&self.values).peekable();
            let at = stamps.at_ns.iter();
            return at
                .map(|ns| {
                    own.next_if(|(own, _)| *own == ns)
                        .map_or(f64::NAN, |(_, v)| *v)
                })
                .collect();
        }
        let (sources, moved_ns) = nearest(&self.at_ns, &stamps.at_ns);
        moved.add(tag, moved_ns, left_out(self.at_ns.len(), &sources));
        sources
            .iter()
            .map(|source| source.map_or(f64::NAN, |i| self.values[i]))
            .collect()
    }
}

impl Stamps {
    fn of(series: &[Series]) -> Self {
        let busiest = series.iter().rev().max_by_key(|series| series.at_ns.len());
        let busiest = busiest.map_or(&[][..], |series| &series.at_ns);
        let mut all: Vec<u64> = series
            .iter()
            .flat_map(|series| series.at_ns.iter().copied())
            .collect();
        all.sort_unstable();
        all.dedup();
        let polled = series.iter().filter(|series| series.is_polled()).count();
        let of_all = 2 * all.len() <= 3 * busiest.len() || 2 * polled <= series.len();
        Self {
            at_ns: if of_all { all } else { busiest.to_vec() },
            of_all,
        }
    }

    /// # Errors
    /// [`IngestError::TooLarge`] if so many tags have more cells at the stamps than so many bytes may say.
    fn check(&self, tags: usize, bytes: usize) -> Result<(), IngestError> {
        let claimed = (self.at_ns.len() as u64).saturating_mul(tags as u64 + 1);
        let limit = CELLS_A_BYTE * bytes as u64 + SPARE_CELLS;
        if claimed <= limit {
            return Ok(());
        }
        Err(IngestError::TooLarge {
            what: format!("a table of {tags} tags at {} stamps", self.at_ns.len()),
            claimed,
            limit,
        })
    }
}

/// Whether a reading is said to be bad.
fn is_bad(cell: &[u8]) -> bool {
    cell.get(..3)
        .is_some_and(|begin| begin.eq_ignore_ascii_case(b"bad"))
}

#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "of tags that were numbered; NaN and others saturate and are none"
)]
fn whole(number: f64) -> usize {
    number as usize
}

#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "not below the first; beyond five centuries it saturates"
)]
fn nanoseconds(after_s: f64) -> u64 {
    (after_s * 1e9).round() as u64
}
