//! What a recording in blocks is told of its readings holds for that recording at once.

use crate::wells::{table, well};
use dgd_recording::{ReadingSurvey, Recording, Table};

/// A table of 4000 s, in which channel `k` has at second `i` the reading `of(k, i)`.
fn recorded(of: impl Fn(usize, usize) -> f64) -> Table {
    let time_s: Vec<f64> = (0..4000).map(f64::from).collect();
    let mut table = table(&time_s);
    for (k, column) in table.columns.iter_mut().enumerate().skip(1) {
        column.values = (0..time_s.len()).map(|i| of(k, i)).collect();
    }
    table
}

/// Whether the blocks tell that readings may be joined, and whether those of the recording at once are, or are read apart.
fn told_and_true(table: &Table) -> (bool, bool) {
    let well = well();
    let mut survey = ReadingSurvey::default();
    for from in (0..table.rows()).step_by(37) {
        let mut block = table.clone();
        for column in &mut block.columns {
            let to = column.values.len().min(from + 37);
            column.values = column.values[from..to].to_vec();
        }
        survey.add(&block, &well);
    }
    let (mut recording, _) = Recording::from_table(table.clone(), &well).unwrap();
    let apart = !recording.read_apart().is_empty();
    let joined = recording.join_events(1.0).is_some();
    (survey.may_be_joined(), apart || joined)
}

/// Noise of few digits.
fn noise(k: usize, i: usize) -> f64 {
    let mut x = (i as u64 + 1_000_000 * k as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    x ^= x >> 27;
    (x % 20) as f64
}

#[test]
fn readings_that_are_joined_at_once_are_told_in_blocks() {
    let lacks = |is: bool, value: f64| if is { f64::NAN } else { value };
    let whole = recorded(noise);
    let one_slow = recorded(|k, i| lacks(k == 4 && i % 10 > 0, noise(k, i)));
    let each_apart = recorded(|k, i| lacks(i % 10 != k % 10, noise(k, i)));
    let by_events =
        recorded(|k, i| lacks(noise(k + 50, i) > (2 + 4 * (k % 2)) as f64, noise(k, i)));
    let changes = recorded(|k, i| {
        let set = |i: usize| if k < 4 { (i / 400) as f64 } else { noise(k, i) };
        lacks(i > 0 && set(i) == set(i - 1), set(i))
    });
    for (what, table, joined) in [
        ("whole", whole, false),
        ("one slow channel", one_slow, false),
        ("each at its own instants", each_apart, true),
        ("by events", by_events, true),
        ("all changes", changes, true),
    ] {
        assert_eq!(told_and_true(&table), (joined, joined), "{what}");
    }
}
