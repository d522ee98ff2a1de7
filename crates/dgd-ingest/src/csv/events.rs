//! Tables with a row for each instant at which some channel was read, as pivoting readings makes them: most cells are empty.

use super::plan::{Plan, Seen};
use super::readings::Readings;
use dgd_recording::Table;

/// Fewest columns of values that tell.
const FEWEST: usize = 3;

/// Of so many rows one at least must have a time that is shared, or no whole second: a row that is there twice makes no pivot.
const APART: usize = 20;
/// Rows may be out of order by less than this, s, as those of several sources are.
const OUT_OF_ORDER_S: f64 = 2.0;

/// Columns of a table whose rows hold readings of an instant.
pub(super) struct ReadApart {
    clock: usize,
    /// Those of which an instrument was read.
    read: Vec<usize>,
}

/// The columns that were read apart: most cells of those that have any are empty, none is full, and times are shared, or no whole seconds.
pub(super) fn read_apart(plan: &Plan, seen: &Seen) -> Option<ReadApart> {
    let (clock, apart) = plan.seconds(seen)?;
    let read = plan.read(seen, clock);
    let cells: usize = read.iter().map(|(_, finite)| finite).sum();
    let empty = 2 * cells < read.len() * seen.rows;
    let full = read.iter().any(|(_, finite)| *finite == seen.rows);
    let is_one = read.len() >= FEWEST && empty && !full && APART * apart >= seen.rows;
    is_one.then(|| ReadApart {
        clock,
        read: read.into_iter().map(|(at, _)| at).collect(),
    })
}

impl ReadApart {
    /// Puts the readings on one clock, as those of a text with one a line; what is no reading is held. A table whose stamps go back stays as it is: its clock is
    /// to be judged.
    pub(super) fn onto_one_clock(&self, table: &mut Table) {
        let stamps = &table.columns[self.clock].values;
        let is_told = |i: &usize| stamps[*i].is_finite();
        let rows: Vec<usize> = (0..stamps.len()).filter(is_told).collect();
        let goes_back = |pair: &[usize]| stamps[pair[1]] <= stamps[pair[0]] - OUT_OF_ORDER_S;
        if rows.windows(2).any(goes_back) {
            return;
        }
        let tag = |at: &usize| table.columns[*at].tag.clone();
        let names: Vec<String> = self.read.iter().map(tag).collect();
        let mut readings = Readings::new(names.len(), stamps);
        for (tag, at) in self.read.iter().enumerate() {
            let values = &table.columns[*at].values;
            for i in rows.iter().filter(|i| values[**i].is_finite()) {
                readings.add(Some(tag), stamps[*i], values[*i]);
            }
        }
        let Some(issues) = readings.onto_one_clock(&names, "s") else {
            return;
        };
        table.issues.extend(issues);
        let clock = readings.stamps();
        let of_rows: Vec<f64> = rows.iter().map(|i| stamps[*i]).collect();
        let mut read = readings.columns();
        for (at, column) in table.columns.iter_mut().enumerate() {
            if self.read.contains(&at) {
                column.values = read.next().unwrap_or_default();
            } else if at != self.clock {
                let values: Vec<f64> = rows.iter().map(|i| column.values[*i]).collect();
                column.values = held(&of_rows, &values, &clock);
            }
        }
        drop(read);
        table.columns[self.clock].values = clock;
    }
}

/// The values of rows at the times of a clock: each those of the last row that is not later, or of the first.
fn held(rows: &[f64], values: &[f64], clock: &[f64]) -> Vec<f64> {
    let last = |at: &f64| rows.partition_point(|row| row <= at).saturating_sub(1);
    let value = |at: &f64| values.get(last(at)).copied().unwrap_or(f64::NAN);
    clock.iter().map(value).collect()
}
