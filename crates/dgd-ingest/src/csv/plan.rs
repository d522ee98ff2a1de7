//! From the columns of a text to those of a table.

use super::layout::is_time_name;
use super::rows::{Reading, Rows};
use super::stamp::{self, StampKind};
use crate::tags::renamed;
use crate::{IngestError, count};
use dgd_recording::{Column, Issue, IssueKind, Table};
use dgd_units::{Dimension, Unit};

/// What becomes of each column of a text, once all of its rows were read.
#[derive(Debug)]
pub(super) struct Plan {
    columns: Vec<Planned>,
    /// A column of dates, whose seconds are added to those of a column of clock times.
    date: Option<Date>,
    issues: Vec<Issue>,
    origin: Option<String>,
    /// Which of the columns counts from it.
    clock: Option<usize>,
    /// Which of them tells the seconds of the rows, from whenever.
    seconds: Option<usize>,
}

#[derive(Debug)]
struct Planned {
    /// Column of the text.
    index: usize,
    tag: String,
    unit: Option<String>,
    epoch: Option<Epoch>,
}

#[derive(Debug, Clone, Copy)]
struct Date {
    at: usize,
    clock_at: usize,
}

/// Times from 1970.
#[derive(Debug, Clone, Copy)]
struct Epoch {
    first: f64,
    per_second: f64,
}

/// What the values of each column were, of which only the last block is there.
#[derive(Debug)]
pub(super) struct Seen {
    first_finite: Vec<Option<f64>>,
    /// How many cells of each column have a value.
    pub(super) finite: Vec<usize>,
    pub(super) rows: usize,
    /// Rows in which a time of each column has parts of a second, or is that of the row before.
    apart: Vec<usize>,
    /// How the values of each column go on.
    course: Vec<Course>,
}

/// How values go on from row to row.
#[derive(Debug, Clone, Copy)]
struct Course {
    last: f64,
    step: Option<f64>,
    /// Whether each is as far from the one before as the others are.
    even: bool,
}

impl Course {
    const NEW: Self = Self {
        last: f64::NAN,
        step: None,
        even: true,
    };

    /// Looks at values that follow; at none any more once they are uneven.
    fn add(&mut self, values: &[f64]) {
        for value in values {
            if !self.even {
                return;
            }
            let step = value - std::mem::replace(&mut self.last, *value);
            if step.is_finite() {
                self.even = *self.step.get_or_insert(step) == step;
            }
        }
    }
}

impl Seen {
    pub(super) fn new(columns: usize) -> Self {
        Self {
            first_finite: vec![None; columns],
            finite: vec![0; columns],
            rows: 0,
            apart: vec![0; columns],
            course: vec![Course::NEW; columns],
        }
    }

    /// Looks at the values that the columns hold.
    pub(super) fn add(&mut self, columns: &[Reading]) {
        self.rows += columns.first().map_or(0, |column| column.values.len());
        for (finite, column) in self.finite.iter_mut().zip(columns) {
            let there = column.values.iter().map(|v| usize::from(v.is_finite()));
            *finite += there.sum::<usize>();
        }
        for (first, column) in self.first_finite.iter_mut().zip(columns) {
            if first.is_none() {
                *first = column.values.iter().copied().find(|v| v.is_finite());
            }
        }
        for (index, column) in columns.iter().enumerate() {
            let course = &mut self.course[index];
            if let Some(per_second) = per_second(column, self.first_finite[index]) {
                for time in column.values.iter().filter(|t| t.is_finite()) {
                    let shared = std::mem::replace(&mut course.last, *time) == *time;
                    let apart = shared || (time / per_second).fract() != 0.0;
                    self.apart[index] += usize::from(apart);
                }
            } else {
                course.add(&column.values);
            }
        }
    }

    /// Whether each row has a value that is that of the row before, or one more, as the number of a well or of the row has: no instrument was read.
    pub(super) fn is_no_reading(&self, index: usize) -> bool {
        self.finite[index] == self.rows && self.course[index].even
    }
}

/// How many of its units a second has, of a column that tells the times of rows; `None` of any other.
fn per_second(column: &Reading, first: Option<f64>) -> Option<f64> {
    let head = &column.head;
    if head.stamps {
        // A day of its own is shared by all of it.
        let is_date = (column.clock.first()).is_some_and(|stamp| stamp.kind == StampKind::Date);
        return (!is_date).then_some(1.0);
    }
    let unit = head.unit.as_deref();
    let of_epoch = epoch(&head.tag, unit, first).map(|epoch| epoch.per_second);
    let in_seconds = is_time_name(&head.tag) && unit.and_then(per_second_of) == Some(1.0);
    of_epoch.or(in_seconds.then_some(1.0))
}

impl Plan {
    /// The plan for rows that were read to their end, with the issues so far.
    pub(super) fn new(rows: &Rows, seen: &Seen, mut issues: Vec<Issue>) -> Self {
        issues.extend(rows.issues());
        let readings = &rows.columns;
        let date = date_and_clock(readings);
        let mut origin = date.and_then(|date| {
            let first = |at: usize| readings[at].clock.first();
            Some((first(date.at)?.ns + first(date.clock_at)?.ns, false))
        });
        let (mut clock, mut seconds) = (None, None);
        let mut columns = Vec::with_capacity(readings.len());
        for (index, reading) in readings.iter().enumerate() {
            if date.is_some_and(|date| date.at == index) {
                continue;
            }
            let texts = reading.texts();
            if reading.readable == 0 && texts > 0 {
                issues.push(Issue {
                    kind: IssueKind::Skipped,
                    place: format!(
                        "line {}, column `{}`",
                        reading.first_text().line,
                        reading.head.tag
                    ),
                    message: format!(
                        "{} without a number (the first is `{}`); the column was skipped{}",
                        count(texts, "cell"),
                        reading.first_text().shown,
                        mend(reading)
                    ),
                });
                continue;
            }
            if reading.readable == 0 && !reading.head.named {
                continue; // trailing delimiters
            }
            issues.extend(reading.issues(rows.points));
            if reading.head.named && reading.head.tag != reading.head.written {
                let head = &reading.head;
                issues.push(renamed(index, &head.written, &head.tag));
            }
            if date.is_some_and(|date| date.clock_at == index) {
                clock = Some(columns.len());
            } else if origin.is_none() {
                origin = reading.clock.origin();
                clock = origin.map(|_| columns.len());
            }
            let mut planned = Planned {
                index,
                tag: reading.head.tag.clone(),
                unit: reading.head.unit.clone(),
                epoch: None,
            };
            if reading.head.stamps {
                planned.unit = Some("s".into());
            } else if origin.is_none() {
                let unit = planned.unit.as_deref();
                planned.epoch = epoch(&planned.tag, unit, seen.first_finite[index]);
            }
            if let Some(epoch) = planned.epoch {
                planned.unit = Some("s".into());
                origin = Some(epoch.origin());
                clock = Some(columns.len());
            }
            if per_second(reading, seen.first_finite[index]).is_some() {
                seconds = seconds.or(Some(columns.len()));
            }
            columns.push(planned);
        }
        Self {
            columns,
            date,
            issues,
            origin: origin.map(|(ns, zoned)| dgd_recording::rfc3339(ns, zoned)),
            clock,
            seconds: clock.or(seconds),
        }
    }

    /// Takes the values that the columns of the text hold into the table; those that it held are lost.
    pub(super) fn fill(&self, readings: &mut [Reading], table: &mut Table) {
        if let Some(Date { at, clock_at }) = self.date {
            let days = std::mem::take(&mut readings[at].values);
            let Reading { values, joined, .. } = &mut readings[clock_at];
            for (value, day) in values.iter_mut().zip(&days) {
                *value = joined.seconds(*value, *day);
            }
            readings[at].values = days;
        }
        if table.columns.len() != self.columns.len() {
            *table = self.head();
        }
        for (planned, column) in self.columns.iter().zip(&mut table.columns) {
            std::mem::swap(&mut column.values, &mut readings[planned.index].values);
            if let Some(Epoch { first, per_second }) = planned.epoch {
                for value in &mut column.values {
                    *value = (*value - first) / per_second;
                }
            }
        }
    }

    /// The table without its values.
    pub(super) fn head(&self) -> Table {
        let columns = self.columns.iter().map(|planned| Column {
            tag: planned.tag.clone(),
            unit: planned.unit.clone(),
            values: Vec::new(),
        });
        Table {
            columns: columns.collect(),
            issues: self.issues.clone(),
            origin: self.origin.clone(),
            clock: self.clock,
        }
    }

    /// The column of the table that tells the seconds of its rows, and how many of these share theirs with the row before, or have parts of one.
    pub(super) fn seconds(&self, seen: &Seen) -> Option<(usize, usize)> {
        let seconds = self.seconds?;
        Some((seconds, seen.apart[self.columns[seconds].index]))
    }

    /// The columns of the table of which an instrument was read in some rows, and in how many; `clock` is its clock.
    pub(super) fn read(&self, seen: &Seen, clock: usize) -> Vec<(usize, usize)> {
        let columns = self.columns.iter().enumerate();
        let is_read = |(at, planned): &(usize, &Planned)| {
            let index = planned.index;
            *at != clock && seen.finite[index] > 0 && !seen.is_no_reading(index)
        };
        let read = columns.filter(is_read);
        read.map(|(at, planned)| (at, seen.finite[planned.index]))
            .collect()
    }

    /// Whether a column with a value is left, as far as its own cells tell.
    pub(super) fn has_values(&self, seen: &Seen) -> bool {
        let joined = self.date.map(|date| date.clock_at);
        let mut own = self.columns.iter().filter(|p| joined != Some(p.index));
        own.any(|planned| seen.first_finite[planned.index].is_some())
    }
}

/// There is a table, but nothing in it.
pub(super) fn nothing(columns: usize) -> IngestError {
    IngestError::NothingNumeric {
        format: "CSV",
        found: format!("{columns} columns without a single value"),
    }
}

/// What to do about a column of which no cell can be read, where its cells hold units or begin as dates do.
fn mend(reading: &Reading) -> String {
    let shown = &reading.first_text().shown;
    if let Some(unit) = unit_behind(shown) {
        return format!(": remove `{unit}` from its cells; a unit belongs in the header");
    }
    if let Some(zone) = zone_behind(shown) {
        return format!(
            ": `{zone}` does not tell a time zone for certain; write its offset, as in 2024-10-26 15:27:49+02:00"
        );
    }
    let shown = shown.as_bytes();
    if reading.head.first.is_none() && stamp::is_slashed(shown) {
        return ": none of the dates examined distinguishes day from month; write the year first, as in 2024-10-26".into();
    }
    let mut parts = shown.splitn(3, |b| matches!(b, b'/' | b'-' | b'.' | b' '));
    let mut short = || {
        let part = parts.next()?;
        (1..=2)
            .contains(&part.len())
            .then(|| part.iter().all(u8::is_ascii_digit))
    };
    if short() == Some(true) && short() == Some(true) {
        ": write times with the year in four digits and first, as in 2024-10-26 15:27:49".into()
    } else {
        String::new()
    }
}

/// The letters behind a date and a clock time that stand for a time zone, as `CEST` does.
fn zone_behind(cell: &str) -> Option<&str> {
    let (time, zone) = cell.rsplit_once(' ')?;
    let is_one = (3..=5).contains(&zone.len()) && zone.bytes().all(|b| b.is_ascii_uppercase());
    let stamp = stamp::parse(time.trim_end().as_bytes(), None)?;
    let timed = matches!(stamp.kind, StampKind::DateTime { .. } | StampKind::Clock);
    (is_one && timed).then_some(zone)
}

/// The unit that a cell holds behind its number, if it does.
fn unit_behind(cell: &str) -> Option<&str> {
    let of_number = |c: char| c.is_ascii_digit() || matches!(c, '.' | ',' | '+' | '-');
    let ends = cell.find(|c: char| !of_number(c))?;
    let (number, unit) = (&cell[..ends], cell[ends..].trim());
    let is_one = number.contains(|c: char| c.is_ascii_digit());
    (is_one && Unit::parse(unit).is_ok()).then_some(unit)
}

/// A column of dates and one of clock times are one clock: the latter gets both.
fn date_and_clock(readings: &[Reading]) -> Option<Date> {
    let clock_at = readings.iter().position(|r| r.clock.dated)?;
    let is_date = |r: &Reading| r.clock.first().is_some_and(|s| s.kind == StampKind::Date);
    let at = readings.iter().position(is_date)?;
    readings[clock_at].clock.first()?;
    Some(Date { at, clock_at })
}

/// Seconds, milli-, micro- or nanoseconds from 1970, which become seconds from the first.
///
/// Only a column named like time is taken, and only if its values lie between 2001
/// and 2100 in one of the four: the one that the file states, if it does.
fn epoch(tag: &str, unit: Option<&str>, first: Option<f64>) -> Option<Epoch> {
    const FROM_TO_S: (f64, f64) = (978_307_200.0, 4_102_444_800.0);
    if !is_time_name(tag) {
        return None;
    }
    let first = first?;
    let per_second = [1.0, 1e3, 1e6, 1e9]
        .into_iter()
        .find(|per_second| (FROM_TO_S.0..FROM_TO_S.1).contains(&(first / per_second)))?;
    let stated = unit.and_then(per_second_of);
    // A counter in ms reaches what would be the seconds of a date after eleven days.
    stated
        .is_none_or(|stated| stated == per_second)
        .then_some(Epoch { first, per_second })
}

/// How many of a unit a second has; `None` for what is no unit at all, such as `[UTC]`.
fn per_second_of(unit: &str) -> Option<f64> {
    match unit {
        "us" | "µs" | "μs" => return Some(1e6),
        "ns" => return Some(1e9),
        _ => {}
    }
    let unit = Unit::parse(unit).ok()?;
    Some(match unit.dimension {
        Dimension::Time => unit.from_si(1.0).round(),
        _ => f64::NAN,
    })
}

impl Epoch {
    /// Nanoseconds from 1970; the zone is known.
    fn origin(self) -> (i64, bool) {
        #[expect(
            clippy::cast_possible_truncation,
            reason = "below 2^63, for it lies before 2100"
        )]
        let ns = (self.first / self.per_second * 1e9) as i64;
        (ns, true)
    }
}
