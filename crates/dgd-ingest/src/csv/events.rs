//! Tables with a row for each instant at which some channel was read, as pivoting readings makes them: most cells are empty.

use super::plan::Seen;
use super::readings::Readings;
use super::rows::Reading;
use dgd_recording::Table;

/// Fewest columns of values that tell.
const FEWEST: usize = 3;

/// Whether rows hold readings of an instant: most cells of the columns that have any are empty, and dated stamps are shared, or no whole seconds.
pub(super) fn are_read_apart(columns: &[Reading], seen: &Seen) -> bool {
    let of_values = columns.iter().zip(&seen.finite);
    let of_values = of_values.filter(|(column, finite)| !column.head.stamps && **finite > 0);
    let (channels, cells) = of_values.fold((0, 0), |(channels, cells), (_, finite)| {
        (channels + 1, cells + finite)
    });
    channels >= FEWEST && 2 * cells < channels * seen.rows && seen.apart
}

/// Puts the readings on one clock, as those of a text with one a line. A table whose stamps are not in order stays as it is: its clock is to be judged.
pub(super) fn onto_one_clock(table: &mut Table) {
    let Some(clock) = table.clock else {
        return;
    };
    let stamps = &table.columns[clock].values;
    if !stamps.iter().filter(|t| t.is_finite()).is_sorted() {
        return;
    }
    let (_, columns): (Vec<_>, Vec<_>) =
        (table.columns.iter().enumerate()).partition(|(k, _)| *k == clock);
    let names: Vec<String> = columns.iter().map(|(_, c)| c.tag.clone()).collect();
    let mut readings = Readings::new(names.len(), stamps);
    for (tag, (_, column)) in columns.iter().enumerate() {
        let cells = stamps.iter().zip(&column.values);
        for (at, value) in cells.filter(|(_, value)| value.is_finite()) {
            readings.add(Some(tag), *at, *value);
        }
    }
    let Some(issues) = readings.onto_one_clock(&names, "s") else {
        return;
    };
    table.issues.extend(issues);
    table.columns[clock].values = readings.stamps();
    let columns = table
        .columns
        .iter_mut()
        .enumerate()
        .filter(|(k, _)| *k != clock);
    for ((_, column), values) in columns.zip(readings.columns()) {
        column.values = values;
    }
}
