//! CSV text: sniffed, not configured.
//!
//! The bytes are cut by hand instead of by a CSV parser: a cell that is a plain decimal
//! is converted where it stands, in one pass, which is several times faster, and damage
//! (a quote that is never closed, a line of another length) costs one line.

mod blocks;
mod events;
mod layout;
pub(crate) mod number;
mod pairs;
mod plan;
mod readings;
mod rows;
pub(crate) mod stamp;
mod text;

pub(crate) use blocks::TextBlocks;

use crate::IngestError;
use dgd_recording::{Issue, Table};
use layout::{Glimpse, Layout};
use plan::{Plan, Seen};

/// Columns that a text may have.
pub(crate) const MAX_COLUMNS: usize = 10_000;

/// Reads a CSV text.
///
/// # Errors
/// [`IngestError`] if there is no table of numbers in it.
pub(crate) fn read(bytes: &[u8]) -> Result<Table, IngestError> {
    let mut issues = Vec::new();
    let text = text::decode(bytes, &mut issues)?;
    let mut layout = layout::layout(&Glimpse::of(&text))?;
    if let Some(places) = layout.readings.clone() {
        let (numbered, tags) = places.number(&text, &layout)?;
        if tags.is_any() {
            let table = table(&numbered, &mut layout, issues)?;
            return places.beside_each_other(table, &layout, tags, bytes.len());
        }
    }
    layout.readings = None;
    table(&text, &mut layout, issues)
}

/// The table of a text of this layout, row by row.
fn table(text: &[u8], layout: &mut Layout, issues: Vec<Issue>) -> Result<Table, IngestError> {
    let mut rows = rows::read(text, layout)?;
    if layout.take_for_minutes(&rows.columns) {
        rows = rows::read(text, layout)?;
    }
    rows.check_names()?;
    if let Some(pairs) = &layout.pairs {
        return pairs.beside_each_other(&rows, issues, text.len());
    }
    if layout.readings.is_some() {
        let clocks = rows.columns.iter_mut();
        clocks.for_each(|column| column.joined.take_as_they_are());
    }
    let mut seen = Seen::new(rows.columns.len());
    seen.add(&rows.columns);
    let plan = Plan::new(&rows, &seen, issues);
    let mut table = Table::default();
    plan.fill(&mut rows.columns, &mut table);
    let apart = events::read_apart(&plan, &seen);
    if let Some(apart) = apart.filter(|_| layout.readings.is_none()) {
        apart.onto_one_clock(&mut table);
    }
    if table
        .columns
        .iter()
        .all(|c| c.values.iter().all(|v| v.is_nan()))
    {
        return Err(plan::nothing(table.columns.len()));
    }
    Ok(table)
}
