//! What is in a table that nobody has described yet.

mod blocks;
mod column;
mod selection;

pub use blocks::BlockSurvey;
pub(crate) use selection::Selection;

use crate::{ClockError, ClockSurvey, Column, Rank, Table, quantile, survey_clock};
use column::ColumnPass;
use dgd_units::{Dimension, Unit};

/// Summary of a table.
#[derive(Debug, Clone, PartialEq)]
pub struct TableSurvey {
    /// One entry a column, in the table's order.
    pub columns: Vec<ColumnSurvey>,
    /// Index of the column taken for the clock, if one looks like it.
    pub time_column: Option<usize>,
    /// Its survey, or why it is none; stamps without a unit are taken for seconds.
    pub clock: Option<Result<ClockSurvey, ClockError>>,
}

impl TableSurvey {
    /// Whether the clock counts days, as those of MATLAB and of spreadsheets do, although no unit says so: no rig is recorded a thousand
    /// times a second, and a fraction of a second to a minute in days is a usual step.
    #[must_use]
    pub fn counts_days(&self) -> bool {
        let written = self.time_column.and_then(|index| self.columns[index].unit);
        self.steps_like_days() && written.is_none_or(|u| u.dimension != Dimension::Time)
    }

    /// Whether the clock's step is none of seconds, and one of days that is usual in seconds.
    pub(crate) fn steps_like_days(&self) -> bool {
        let Some(Ok(clock)) = &self.clock else {
            return false;
        };
        let seconds = 0.05..=61.0;
        clock.step_s < 1e-3 && seconds.contains(&(S_PER_DAY * clock.step_s))
    }

    /// [`Self::clock`] in seconds, also where it [counts days](Self::counts_days).
    #[must_use]
    pub fn clock_in_seconds(&self) -> Option<Result<ClockSurvey, ClockError>> {
        match &self.clock {
            Some(Ok(clock)) if self.counts_days() => Some(Ok(clock.in_units_of(S_PER_DAY))),
            clock => clock.clone(),
        }
    }
}

const S_PER_DAY: f64 = 86_400.0;

/// Summary of a column; values are in the column's own unit.
#[derive(Debug, Clone, PartialEq)]
pub struct ColumnSurvey {
    /// Name in the file.
    pub tag: String,
    /// Unit as written, beside the name or at its end (`flow_gpm`).
    pub unit_written: Option<String>,
    /// The unit, if it is a known one.
    pub unit: Option<Unit>,
    /// Values, missing ones included.
    pub samples: usize,
    /// Values that are not finite.
    pub missing: usize,
    /// Smallest, median and largest finite value.
    pub range: Option<(f64, f64, f64)>,
    /// Smallest step between different neighbouring values that occurs often: the quantisation.
    pub quantum: Option<f64>,
    /// Longest run of one and the same value, while the channel otherwise moves.
    pub longest_run: Option<Run>,
    /// Share of samples that repeat their predecessor exactly.
    pub repeated_share: f64,
}

/// A run of equal values.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Run {
    /// First sample.
    pub start: usize,
    /// Samples, at least 2.
    pub length: usize,
    /// The value.
    pub value: f64,
}

/// Summarises every column and the clock. Linear in the samples.
pub fn survey(table: &Table) -> TableSurvey {
    let mut columns = Vec::with_capacity(table.columns.len());
    let mut increases = Vec::with_capacity(table.columns.len());
    for column in &table.columns {
        let mut pass = ColumnPass::default();
        pass.add(&column.values);
        increases.push(pass.increases());
        let median = quantile(column.values.iter().copied(), Rank::MEDIAN);
        columns.push(summary(column, &pass, median));
    }
    let time_column = find_time(&columns, |index| increases[index]);
    let clock = time_column.map(|index| {
        let factor = time_factor(&columns[index]);
        let values = &table.columns[index].values;
        if factor == 1.0 {
            return survey_clock(values);
        }
        let time_s: Vec<f64> = values.iter().map(|t| t * factor).collect();
        survey_clock(&time_s)
    });
    TableSurvey {
        columns,
        time_column,
        clock,
    }
}

fn summary(head: &Column, pass: &ColumnPass, median: Option<f64>) -> ColumnSurvey {
    let beside = head.unit.as_deref().filter(|u| !u.is_empty());
    let unit = beside.or(unit_in_name(&head.tag));
    ColumnSurvey {
        tag: head.tag.clone(),
        unit_written: unit.map(str::to_owned),
        unit: unit.and_then(|u| Unit::parse(u).ok()),
        samples: pass.samples,
        missing: pass.missing,
        range: pass
            .ends()
            .zip(median)
            .map(|((low, high), m)| (low, m, high)),
        quantum: pass.quantum(),
        longest_run: pass.longest_run(),
        repeated_share: pass.repeated_share(),
    }
}

/// Seconds in one of the column's units.
fn time_factor(column: &ColumnSurvey) -> f64 {
    let unit = column.unit.filter(|u| u.dimension == Dimension::Time);
    unit.map_or(1.0, |u| u.factor)
}

/// The unit that a name ends with, such as `flow_out_gpm`, `Booster m3/h` or `Flow Out %`.
///
/// Units that are also words (`in`, `min`, `a`) measure nothing that is looked for here, but for a clock.
pub(crate) fn unit_in_name(tag: &str) -> Option<&str> {
    let (name, unit) = tag.trim().rsplit_once([' ', '_'])?;
    let clock = || name.to_lowercase().trim_end().ends_with("time");
    let looked_for = match Unit::parse(unit).ok()?.dimension {
        Dimension::FlowRate
        | Dimension::Pressure
        | Dimension::Density
        | Dimension::Percent
        | Dimension::RotationalSpeed => true,
        Dimension::Time => clock(),
        _ => false,
    };
    looked_for.then_some(unit)
}

/// The quantisation step: the smallest difference of neighbours that at least one in
/// a hundred of the changes shows. `None` if the values hardly change.
///
/// Differences are compared within a relative 1e-6 of the range, so that decimal
/// steps (0.1 %) are found although they are no binary numbers.
pub fn quantum(values: &[f64]) -> Option<f64> {
    let steps = values
        .windows(2)
        .map(|w| (w[1] - w[0]).abs())
        .filter(|d| *d > 0.0 && d.is_finite())
        .take(QUANTUM_STEPS)
        .collect();
    quantum_of(steps)
}

/// Changes of a column that its quantum is told from, at most.
const QUANTUM_STEPS: usize = 20_000;

/// The quantum of a column that changes by so much, one change after the other.
fn quantum_of(mut steps: Vec<f64>) -> Option<f64> {
    if steps.len() < 20 {
        return None;
    }
    steps.sort_by(f64::total_cmp);
    let tolerance = 1e-6 * steps[steps.len() / 2];
    let often = steps.len().div_ceil(100);
    let mut start = 0;
    for index in 0..steps.len() {
        while steps[index] - steps[start] > tolerance {
            start += 1;
        }
        if index + 1 - start >= often && steps[start] > 1e-12 * steps[steps.len() - 1] {
            return Some(steps[start]);
        }
    }
    None
}

/// Whether a column of this name, up to its first sign that is neither letter nor digit, is a clock or its date.
///
/// ```
/// use dgd_recording::is_clock_name;
/// assert!(is_clock_name("Time (UTC)") && is_clock_name("tid") && is_clock_name("unix_s"));
/// assert!(!is_clock_name("timeout") && !is_clock_name("FT1"));
/// ```
#[must_use]
pub fn is_clock_name(name: &str) -> bool {
    const NAMES: [&str; 12] = [
        "t",
        "time",
        "timestamp",
        "datetime",
        "date",
        "epoch",
        "unix",
        "unixtime",
        "utc",
        "tid",
        "seconds",
        "elapsed",
    ];
    let name = name.to_lowercase();
    let stem = name.split(|c: char| !c.is_alphanumeric()).next();
    stem.is_some_and(|stem| NAMES.contains(&stem))
}

/// A column named or measured like time, or else one that only ever increases.
fn find_time(columns: &[ColumnSurvey], increases: impl Fn(usize) -> bool) -> Option<usize> {
    let named = |c: &ColumnSurvey| is_clock_name(c.tag.rsplit('.').next().unwrap_or_default());
    let measured = |c: &ColumnSurvey| c.unit.is_some_and(|u| u.dimension == Dimension::Time);
    let long = |index: usize| columns[index].samples > 1;
    let find = |test: &dyn Fn(usize) -> bool| (0..columns.len()).find(|i| long(*i) && test(*i));
    find(&|i| named(&columns[i]))
        .or_else(|| find(&|i| measured(&columns[i])))
        .or_else(|| find(&increases))
}
