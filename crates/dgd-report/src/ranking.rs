//! Named values under one another: bars by size, and estimates between their bounds.

use crate::axis::{Axis, short};
use crate::color::{FRAME, GRID, INK, Role, SHADE, SOFT_INK, tone};
use crate::error::ReportError;
use crate::figure::Figure;
use crate::font::{shorten, text_width};
use crate::panel::WIDTH;
use crate::scene::{Anchor, Pen, Scene};

const ROW: f64 = 24.0;
const SIZE: f64 = 13.5;
const TOP: f64 = 10.0;
/// Rows of a [`ranking`] or of [`within_bounds`].
pub const MOST_ROWS: usize = 200;
/// Share of the width that names may take.
const NAMES: f64 = 0.42;

/// A named value of a [`ranking`].
#[derive(Debug, Clone, PartialEq)]
pub struct Ranked {
    /// Name.
    pub label: String,
    /// Value, at least 0; one that is not finite has no bar.
    pub value: f64,
    /// A word or two behind the value; may be empty.
    pub note: String,
}

/// Bars by size, largest above, drawn from zero.
///
/// # Errors
/// [`ReportError::TooMany`] above [`MOST_ROWS`].
///
/// ```
/// use dgd_report::{Axis, Ranked, ranking};
/// let row = |label: &str, value| Ranked { label: label.into(), value, note: String::new() };
/// let rows = [row("valve.opening", 0.2), row("line.roughness", 1.4)];
/// let figure = ranking(&rows, &Axis::new("Importance"))?;
/// assert!(figure.caption().contains("line.roughness"));
/// # Ok::<(), dgd_report::ReportError>(())
/// ```
pub fn ranking(rows: &[Ranked], axis: &Axis) -> Result<Figure, ReportError> {
    check(rows.len())?;
    let mut order: Vec<&Ranked> = rows.iter().collect();
    let size = |r: &Ranked| {
        if r.value.is_finite() {
            r.value.max(0.0)
        } else {
            0.0
        }
    };
    // Stable: equals stay as they were given.
    order.sort_by(|a, b| size(b).total_cmp(&size(a)));
    let largest = order.first().map_or(0.0, |r| size(r));
    let texts: Vec<String> = order
        .iter()
        .map(|r| {
            let value = if r.value.is_finite() {
                short(r.value)
            } else {
                "—".into()
            };
            format!("{value} {}", r.note).trim_end().to_owned()
        })
        .collect();
    let (left, names) = names_column(order.iter().map(|r| r.label.as_str()));
    let widest = texts
        .iter()
        .map(|t| text_width(t, SIZE, false))
        .fold(0.0, f64::max);
    let room = (WIDTH - left - widest - 24.0).max(60.0);
    let mut scene = Scene {
        width: WIDTH,
        height: TOP + ROW * order.len().max(1) as f64 + 30.0,
        ..Scene::default()
    };
    for (index, (row, text)) in order.iter().zip(&texts).enumerate() {
        let y = TOP + ROW * index as f64;
        scene.text(
            [left - 10.0, y + 16.0],
            &names[index],
            SIZE,
            INK,
            Anchor::End,
        );
        let width = if largest > 0.0 {
            room * size(row) / largest
        } else {
            0.0
        };
        scene.rect(
            [left, y + 4.0],
            [width.max(1.0), ROW - 8.0],
            tone(Role::Model.color(), 0.75),
        );
        scene.text(
            [left + width + 8.0, y + 16.0],
            text,
            SIZE,
            SOFT_INK,
            Anchor::Start,
        );
    }
    let bottom = TOP + ROW * order.len().max(1) as f64;
    scene.line([left, TOP], [left, bottom], Pen::new(FRAME, 1.0));
    let label = shorten(&axis.label, SIZE, WIDTH - left - 10.0);
    scene.text([left, bottom + 20.0], &label, SIZE, INK, Anchor::Start);
    let caption = match order.first() {
        Some(first) if largest > 0.0 => {
            format!(
                "{}. Largest: {}, {}.",
                axis.label,
                first.label,
                short(first.value)
            )
        }
        _ => format!("{}. Nothing to show.", axis.label),
    };
    Ok(Figure::of_scene(caption, scene))
}

/// An estimate between its bounds.
#[derive(Debug, Clone, PartialEq)]
pub struct WithinBounds {
    /// Name.
    pub label: String,
    /// Estimate.
    pub value: f64,
    /// Interval; infinite if nothing is known.
    pub interval: (f64, f64),
    /// Bounds within which it was sought.
    pub bounds: (f64, f64),
    /// What is written behind it, such as value and unit.
    pub note: String,
}

/// Estimates with their intervals, each on its own scale from its lower to its upper bound.
///
/// # Errors
/// [`ReportError::TooMany`] above [`MOST_ROWS`].
pub fn within_bounds(rows: &[WithinBounds]) -> Result<Figure, ReportError> {
    check(rows.len())?;
    let (left, names) = names_column(rows.iter().map(|r| r.label.as_str()));
    let widest = rows
        .iter()
        .map(|r| text_width(&r.note, SIZE, false))
        .fold(0.0, f64::max);
    let room = (WIDTH - left - widest - 30.0).max(80.0);
    let bottom = TOP + ROW * rows.len().max(1) as f64;
    let mut scene = Scene {
        width: WIDTH,
        height: bottom + 30.0,
        ..Scene::default()
    };
    for share in [0.0, 0.25, 0.5, 0.75, 1.0] {
        let x = left + room * share;
        scene.line([x, TOP], [x, bottom], Pen::new(GRID, 1.0));
    }
    for (index, row) in rows.iter().enumerate() {
        let y = TOP + ROW * (index as f64 + 0.5);
        scene.text(
            [left - 10.0, y + 4.5],
            &names[index],
            SIZE,
            INK,
            Anchor::End,
        );
        let span = row.bounds.1 - row.bounds.0;
        let place = |v: f64| {
            let share = (v - row.bounds.0) / span;
            left + room
                * if share.is_nan() {
                    0.5
                } else {
                    share.clamp(0.0, 1.0)
                }
        };
        let (a, b) = (place(row.interval.0), place(row.interval.1));
        scene.rect([a, y - 5.0], [(b - a).max(1.5), 10.0], SHADE);
        let pen = Pen::new(Role::Model.color(), 2.0);
        scene.line([a, y], [b.max(a + 1.5), y], pen);
        scene.dot([place(row.value), y], 4.0, Role::Model.color());
        scene.text(
            [left + room + 14.0, y + 4.5],
            &row.note,
            SIZE,
            SOFT_INK,
            Anchor::Start,
        );
    }
    for (x, word, anchor) in [
        (left, "lower bound", Anchor::Start),
        (left + room, "upper bound", Anchor::End),
    ] {
        scene.line([x, TOP], [x, bottom], Pen::new(FRAME, 1.0));
        scene.text([x, bottom + 18.0], word, SIZE, SOFT_INK, anchor);
    }
    let caption =
        "Estimates (dots) and their 95 % intervals (bars) between the bounds of each parameter.";
    Ok(Figure::of_scene(caption.to_owned(), scene))
}

fn check(found: usize) -> Result<(), ReportError> {
    if found > MOST_ROWS {
        return Err(ReportError::TooMany {
            what: "rows",
            found,
            most: MOST_ROWS,
        });
    }
    Ok(())
}

/// Where the bars begin, and the names as short as they must be.
fn names_column<'a>(names: impl Iterator<Item = &'a str>) -> (f64, Vec<String>) {
    let names: Vec<String> = names.map(|n| shorten(n, SIZE, NAMES * WIDTH)).collect();
    let widest = names
        .iter()
        .map(|n| text_width(n, SIZE, false))
        .fold(40.0, f64::max);
    (widest + 18.0, names)
}
