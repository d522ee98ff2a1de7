//! CSV text: sniffed, not configured.
//!
//! The bytes are cut by hand instead of by a CSV parser: a cell that is a plain decimal
//! is converted where it stands, in one pass, which is several times faster, and damage
//! (a quote that is never closed, a line of another length) costs one line.

mod layout;
pub(crate) mod number;
mod rows;
pub(crate) mod stamp;
mod text;

use crate::{IngestError, count};
use dgd_recording::{Column, Issue, IssueKind, Table};
use rows::Reading;
use stamp::StampKind;

/// Columns that a text may have.
pub(crate) const MAX_COLUMNS: usize = 10_000;

/// Reads a CSV text.
///
/// # Errors
/// [`IngestError`] if there is no table of numbers in it.
pub(crate) fn read(bytes: &[u8]) -> Result<Table, IngestError> {
    let mut issues = Vec::new();
    let text = text::decode(bytes, &mut issues)?;
    let layout = layout::layout(&text)?;
    let rows = rows::read(&text, layout)?;
    issues.extend(rows.issues);
    let mut readings = rows.columns;
    let mut origin = join_date_and_clock(&mut readings);
    let mut columns = Vec::with_capacity(readings.len());
    for reading in readings {
        let texts = reading.unreadable.count;
        if reading.readable == 0 && texts > 0 {
            issues.push(Issue {
                kind: IssueKind::Skipped,
                place: format!(
                    "line {}, column `{}`",
                    reading.unreadable.line, reading.head.tag
                ),
                message: format!(
                    "{} without a number (the first is `{}`); the column was passed over",
                    count(texts, "cell"),
                    reading.unreadable.shown
                ),
            });
            continue;
        }
        if reading.readable == 0 && !reading.head.named {
            continue; // trailing delimiters
        }
        issues.extend(reading.issues());
        let stamps = reading.head.stamps;
        origin = origin.or_else(|| reading.clock.origin());
        let mut column = reading.column();
        if stamps {
            column.unit = Some("s".into());
        } else if origin.is_none() {
            origin = epoch_to_seconds(&mut column);
        }
        columns.push(column);
    }
    if columns.iter().all(|c| c.values.iter().all(|v| v.is_nan())) {
        return Err(IngestError::NothingNumeric {
            format: "CSV",
            found: format!("{} columns without a single value", columns.len()),
        });
    }
    let origin = origin.map(|(ns, zoned)| stamp::rfc3339(ns, zoned));
    Ok(Table {
        columns,
        issues,
        origin,
    })
}

/// A column of dates and one of clock times are one clock: the latter gets both.
/// Returns nanoseconds from 1970 of the first stamp.
fn join_date_and_clock(readings: &mut Vec<Reading>) -> Option<(i64, bool)> {
    let clock_at = readings.iter().position(|r| r.clock.dated)?;
    let is_date = |r: &Reading| r.clock.first().is_some_and(|s| s.kind == StampKind::Date);
    let date_at = readings.iter().position(is_date)?;
    let (date, clock) = (
        readings[date_at].clock.first()?,
        readings[clock_at].clock.first()?,
    );
    let days = std::mem::take(&mut readings[date_at].values);
    for (value, day) in readings[clock_at].values.iter_mut().zip(days) {
        *value += day;
    }
    readings.remove(date_at);
    Some((date.ns + clock.ns, false))
}

/// Seconds, milli-, micro- or nanoseconds from 1970 to seconds from the first stamp.
///
/// Only a column named like time is touched, and only if its values lie between 2001
/// and 2100 in one of the four.
fn epoch_to_seconds(column: &mut Column) -> Option<(i64, bool)> {
    const FROM_TO_S: (f64, f64) = (978_307_200.0, 4_102_444_800.0);
    let name = column.tag.to_lowercase();
    let stem = name
        .split(|c: char| !c.is_alphanumeric())
        .next()
        .unwrap_or_default();
    if !matches!(
        stem,
        "t" | "time" | "timestamp" | "epoch" | "unix" | "unixtime" | "datetime" | "utc"
    ) {
        return None;
    }
    let first = column.values.iter().copied().find(|v| v.is_finite())?;
    let per_second = [1.0, 1e3, 1e6, 1e9]
        .into_iter()
        .find(|per_second| (FROM_TO_S.0..FROM_TO_S.1).contains(&(first / per_second)))?;
    for value in &mut column.values {
        *value = (*value - first) / per_second;
    }
    column.unit = Some("s".into());
    #[expect(
        clippy::cast_possible_truncation,
        reason = "below 2^63 by the range test"
    )]
    let ns = (first / per_second * 1e9) as i64;
    Some((ns, true))
}
