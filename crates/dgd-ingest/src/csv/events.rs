//! Tables with a row for each instant at which some channel was read, as pivoting readings makes them: most cells are empty.

use super::plan::Seen;
use super::readings::Readings;
use super::rows::Reading;
use dgd_recording::Table;

/// Fewest columns of values that tell.
const FEWEST: usize = 3;

/// Of so many rows one at least must have a time that is shared, or no whole second: a row that is there twice makes no pivot.
const APART: usize = 20;
/// Rows may be out of order by less than this, s, as those of several sources are.
const OUT_OF_ORDER_S: f64 = 2.0;

/// Whether rows hold readings of an instant: most cells of the columns that have any are empty, none is full, and times are shared, or no whole seconds.
pub(super) fn are_read_apart(columns: &[Reading], seen: &Seen) -> bool {
    let of_values = columns.iter().zip(&seen.finite);
    let of_values = of_values.filter(|(column, finite)| !column.head.stamps && **finite > 0);
    let finite: Vec<usize> = of_values.map(|(_, finite)| *finite).collect();
    let empty = 2 * finite.iter().sum::<usize>() < finite.len() * seen.rows;
    let full = finite.contains(&seen.rows);
    finite.len() >= FEWEST && empty && !full && APART * seen.apart >= seen.rows
}

/// Puts the readings on one clock, as those of a text with one a line. A table whose stamps go back stays as it is: its clock is to be judged.
pub(super) fn onto_one_clock(table: &mut Table) {
    let Some(clock) = table.clock else {
        return;
    };
    let stamps = &table.columns[clock].values;
    let is_told = |i: &usize| stamps[*i].is_finite();
    let rows: Vec<usize> = (0..stamps.len()).filter(is_told).collect();
    let goes_back = |pair: &[usize]| stamps[pair[1]] <= stamps[pair[0]] - OUT_OF_ORDER_S;
    if rows.windows(2).any(goes_back) {
        return;
    }
    let channels = || (0..table.columns.len()).filter(|k| *k != clock);
    let names: Vec<String> = channels().map(|k| table.columns[k].tag.clone()).collect();
    let mut readings = Readings::new(names.len(), stamps);
    for (tag, k) in channels().enumerate() {
        let values = &table.columns[k].values;
        for i in rows.iter().filter(|i| values[**i].is_finite()) {
            readings.add(Some(tag), stamps[*i], values[*i]);
        }
    }
    let Some(issues) = readings.onto_one_clock(&names, "s") else {
        return;
    };
    table.issues.extend(issues);
    table.columns[clock].values = readings.stamps();
    let channels = table.columns.iter_mut().enumerate();
    let channels = channels.filter(|(k, _)| *k != clock);
    for ((_, column), values) in channels.zip(readings.columns()) {
        column.values = values;
    }
}
