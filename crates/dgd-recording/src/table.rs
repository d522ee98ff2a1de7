//! What a reader found in a file: columns of numbers, and what was wrong with it.

use crate::origin::nanoseconds;
use crate::{Moment, TimeSource};
use dgd_units::{Dimension, Unit};
use std::fmt;

/// One column as the file has it.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Column {
    /// Name in the file; nested MAT structs are joined with dots (`gom.FT1`).
    pub tag: String,
    /// Unit as written in the file, if it says one.
    pub unit: Option<String>,
    /// Values in that unit; NaN where the file has none.
    pub values: Vec<f64>,
}

/// The columns of one file, which need not be of equal length.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Table {
    /// In the order of the file.
    pub columns: Vec<Column>,
    /// What the reader found wrong and lived with.
    pub issues: Vec<Issue>,
    /// Wall-clock time at 0 of the clock where the file knows it, RFC 3339; `-00:00` where it does not tell the zone.
    pub origin: Option<String>,
    /// Index of the column that is this clock, in s; `None` where the file does not tell which one is.
    pub clock: Option<usize>,
}

impl Table {
    /// [`Self::origin`] in nanoseconds from 1970; `None` if it is not told, or is no RFC 3339 time from 1970 to 2200.
    ///
    /// ```
    /// # let mut table = dgd_recording::Table::default();
    /// table.origin = Some("1970-01-02T00:00:00.5Z".to_owned());
    /// assert_eq!(table.origin_ns(), Some(86_400_500_000_000));
    /// ```
    #[must_use]
    pub fn origin_ns(&self) -> Option<u64> {
        self.origin.as_deref().and_then(nanoseconds)
    }

    /// When the earliest row was taken, on the clock that a channel map names; `None` where the origin is not told, or
    /// is that of another column.
    ///
    /// ```
    /// use dgd_recording::{Column, Table, TimeSource};
    /// let clock = Column { tag: "t".into(), values: vec![f64::NAN, 2.0, 3.0], ..Column::default() };
    /// let mut table = Table { columns: vec![clock], ..Table::default() };
    /// table.origin = Some("1970-01-02T00:00:00-00:00".to_owned());
    /// let time = TimeSource::Column { tag: "t".into(), unit: dgd_units::Unit::parse("s")? };
    /// let began = table.began(&time).expect("a dated clock");
    /// assert_eq!((began.unix_ns, began.zoned), (86_402_000_000_000, false));
    /// assert_eq!(began.to_string(), "1970-01-02 00:00:02 (time zone unknown)");
    /// # Ok::<(), dgd_units::UnitError>(())
    /// ```
    #[must_use]
    pub fn began(&self, time: &TimeSource) -> Option<Moment> {
        let origin = Moment::of_rfc3339(self.origin.as_deref()?)?;
        let first = |index: usize| self.earliest(index);
        let after_s = match (time, self.clock) {
            (TimeSource::Column { tag, unit }, clock) => {
                let mapped = self.find(tag)?;
                if clock.is_some_and(|index| index != mapped) {
                    return None;
                }
                self.time_unit(mapped, *unit).to_si(first(mapped)?)
            }
            (TimeSource::Interval { .. }, Some(index)) => first(index)?,
            (TimeSource::Interval { .. }, None) => 0.0,
        };
        origin.after(after_s)
    }

    /// What the clock that a channel map names reads at the earliest row, s, whatever it counts from; `None` where the map names no
    /// column, or one that is not there or has no value.
    ///
    /// ```
    /// use dgd_recording::{Column, Table, TimeSource};
    /// let clock = Column { tag: "t".into(), values: vec![f64::NAN, 61.0, 60.0], ..Column::default() };
    /// let table = Table { columns: vec![clock], ..Table::default() };
    /// let time = TimeSource::Column { tag: "t".into(), unit: dgd_units::Unit::parse("min")? };
    /// assert_eq!(table.first_stamp_s(&time), Some(3600.0));
    /// assert_eq!(table.first_stamp_s(&TimeSource::Interval { step_s: 1.0 }), None);
    /// # Ok::<(), dgd_units::UnitError>(())
    /// ```
    #[must_use]
    pub fn first_stamp_s(&self, time: &TimeSource) -> Option<f64> {
        match time {
            TimeSource::Column { tag, unit } => {
                let mapped = self.find(tag)?;
                let unit = self.time_unit(mapped, *unit);
                Some(unit.to_si(self.earliest(mapped)?))
            }
            TimeSource::Interval { .. } => None,
        }
    }

    /// What a column of times counts that a channel map says to be in a unit: that of the file, which a reader has made seconds in the [clock](Self::clock).
    pub(crate) fn time_unit(&self, index: usize, described: Unit) -> Unit {
        if self.clock == Some(index) {
            Unit::si(Dimension::Time)
        } else {
            described
        }
    }

    /// The least value of a column.
    fn earliest(&self, index: usize) -> Option<f64> {
        earliest(&self.columns.get(index)?.values)
    }
}

/// The least finite value.
pub(crate) fn earliest(stamps: &[f64]) -> Option<f64> {
    // In lanes: none waits for the one before. NaN compares false.
    const LANES: usize = 8;
    let mut least = [f64::INFINITY; LANES];
    for stamps in stamps.chunks(LANES) {
        for (least, t) in least.iter_mut().zip(stamps) {
            *least = if (*t < *least) & (*t >= f64::MIN) {
                *t
            } else {
                *least
            };
        }
    }
    let least = least.into_iter().fold(f64::INFINITY, f64::min);
    least.is_finite().then_some(least)
}

/// Something wrong in a file that still could be read.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Issue {
    /// What sort of trouble.
    pub kind: IssueKind,
    /// Where: a line, a byte offset, a column, a sample.
    pub place: String,
    /// What it means for the data, with counts.
    pub message: String,
}

/// What sort of trouble an [`Issue`] tells of.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[non_exhaustive]
pub enum IssueKind {
    /// The file ends early; what came before was kept.
    Truncated,
    /// A part is damaged and was left out.
    Damaged,
    /// A value is not a number; it became NaN.
    UnreadableValue,
    /// A word such as `Off`, which may stand for 0, became NaN.
    WordForZero,
    /// Readings far off those before and after; they became NaN.
    Stray,
    /// A variable of a kind that holds no numbers was passed over.
    Skipped,
    /// Two columns have one name; the later one got another.
    Renamed,
    /// A time stamp is missing or not finite; its sample was dropped.
    MissingTime,
    /// Two samples share a time stamp; the later one was dropped.
    DuplicateTime,
    /// Time runs backwards; the samples were put in order.
    BackwardTime,
    /// Samples are missing; the gap was filled with NaN.
    Gap,
    /// Time steps vary; each sample was moved to the nearest even step.
    Jitter,
    /// Samples lie closer than the even clock steps; of those on one step the first was kept.
    Crowded,
    /// A channel's stamps are late by no whole number of steps; it was moved by the nearest.
    LateStamps,
    /// The file's unit and the well description disagree; the description was used.
    UnitDisagrees,
}

impl fmt::Display for Issue {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.place, self.message)
    }
}

impl Table {
    /// The column of this name: an exact match, else the only one that ends in `.tag`.
    pub fn column(&self, tag: &str) -> Option<&Column> {
        self.find(tag).map(|index| &self.columns[index])
    }

    /// Index of the column that [`Table::column`] gives.
    pub fn find(&self, tag: &str) -> Option<usize> {
        if let Some(index) = self.columns.iter().position(|c| c.tag == tag) {
            return Some(index);
        }
        let ends = |c: &Column| {
            c.tag
                .strip_suffix(tag)
                .is_some_and(|head| head.ends_with('.'))
        };
        let mut hits = self.columns.iter().enumerate().filter(|(_, c)| ends(c));
        match (hits.next(), hits.next()) {
            (Some((index, _)), None) => Some(index),
            _ => None,
        }
    }

    /// Length of the longest column.
    pub fn rows(&self) -> usize {
        self.columns
            .iter()
            .map(|c| c.values.len())
            .max()
            .unwrap_or(0)
    }
}
