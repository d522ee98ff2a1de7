//! A recording that comes in blocks lies on the clock of one that is there at once.

use crate::wells::{table, unit, well};
use dgd_recording::{BlockGrid, Recording, RecordingError, Table, TimeSource, Well};
use proptest::prelude::*;

fn cut(table: &Table, from: usize, to: usize) -> Table {
    let mut cut = table.clone();
    for column in &mut cut.columns {
        column.values = column.values[from..to].to_vec();
    }
    cut
}

fn joined(all: &[Recording]) -> Vec<Vec<u64>> {
    let mut series: Vec<Vec<u64>> = Vec::new();
    for part in all {
        let mine = part.series();
        series.resize_with(mine.len() + 1, Vec::new);
        let values = std::iter::once(part.time_s.as_slice()).chain(mine.iter().map(|s| s.1));
        for (mine, theirs) in series.iter_mut().zip(values) {
            mine.extend(theirs.iter().map(|v| v.to_bits()));
        }
    }
    series
}

/// What both ways give: the step, the issues and the series, or the refusal.
fn compare(table: &Table, rows: usize) {
    compare_of(&well(), table, rows);
}

fn compare_of(well: &Well, table: &Table, rows: usize) {
    let n = table.rows();
    let blocks: Vec<Table> = (0..n)
        .step_by(rows)
        .map(|from| cut(table, from, n.min(from + rows)))
        .collect();
    let whole = Recording::from_table(table.clone(), well).and_then(|(recording, mapping)| {
        let (recording, step_s, clock) = recording.onto_grid()?;
        Ok((recording, step_s, [mapping, clock].concat()))
    });
    let in_blocks = || -> Result<_, RecordingError> {
        let mut grid = BlockGrid::new(&cut(table, 0, 0), n, well)?;
        loop {
            blocks.iter().for_each(|block| grid.add(block));
            if !grid.next_pass()? {
                break;
            }
        }
        if !grid.is_in_order() {
            return Ok(None);
        }
        // As often as wanted.
        let mut parts = Vec::new();
        for _ in 0..2 {
            parts.clear();
            grid.rewind();
            for block in &blocks {
                grid.each(block, |part| {
                    parts.push(part);
                    Ok::<_, RecordingError>(())
                })?;
            }
        }
        Ok(Some((parts, grid)))
    };
    match (whole, in_blocks()) {
        (_, Ok(None)) => {}
        (Ok((recording, step_s, issues)), Ok(Some((parts, grid)))) => {
            assert_eq!(grid.step_s().to_bits(), step_s.to_bits());
            assert_eq!(grid.issues(), issues);
            assert_eq!(grid.samples(), recording.len());
            let ends = (recording.time_s.first(), recording.time_s.last());
            assert_eq!((Some(&grid.span_s().0), Some(&grid.span_s().1)), ends);
            assert!(joined(&parts) == joined(&[recording]));
        }
        (whole, blocks) => {
            let blocks = blocks.map(|_| ()).unwrap_err();
            assert_eq!(format!("{:?}", whole.unwrap_err()), format!("{blocks:?}"));
        }
    }
}

#[test]
fn a_gap_longer_than_a_part_is_filled_in_several() {
    let mut stamps: Vec<f64> = (0..10_000).map(f64::from).collect();
    stamps[5000..].iter_mut().for_each(|t| *t += 90_000.5);
    compare(&table(&stamps), 700);
}

#[test]
fn a_clock_that_a_reader_has_made_seconds_is_in_seconds_in_blocks_as_well() {
    let stamps: Vec<f64> = (0..100).map(|i| 3.0 + 2.0 * f64::from(i)).collect();
    let mut dated = table(&stamps);
    dated.clock = Some(0);
    let mut described = well();
    described.channels.time = TimeSource::Column {
        tag: "t".into(),
        unit: unit("ms"),
    };
    compare_of(&described, &dated, 7);
    let mut grid = BlockGrid::new(&cut(&dated, 0, 0), 100, &described).unwrap();
    grid.add(&dated);
    while grid.next_pass().unwrap() {
        grid.add(&dated);
    }
    assert_eq!(grid.step_s(), 2.0);
}

#[test]
fn a_missing_column_is_refused_before_anything_is_read() {
    let mut table = table(&[0.0, 1.0, 2.0]);
    table.columns.pop();
    compare(&table, 2);
}

#[test]
fn rows_that_cannot_be_put_on_a_clock_are_refused_and_not_dropped() {
    let well = well();
    for (stamps, expected) in [
        ([0.0, 1.0, 2.0, 3.0], None),
        ([0.0, 2.0, 1.0, 3.0], Some(RecordingError::OutOfOrder)),
    ] {
        let table = table(&stamps);
        let mut grid = BlockGrid::new(&cut(&table, 0, 0), 4, &well).unwrap();
        let each = |grid: &mut BlockGrid<'_>| {
            let mut samples = 0;
            let given = grid.each(&table, |part| {
                samples += part.len();
                Ok::<_, RecordingError>(())
            });
            given.map(|()| samples)
        };
        assert_eq!(each(&mut grid), Err(RecordingError::NoClockYet));
        grid.add(&table);
        while grid.next_pass().unwrap() {
            assert_eq!(each(&mut grid), Err(RecordingError::NoClockYet));
            grid.add(&table);
        }
        assert_eq!(grid.is_in_order(), expected.is_none());
        assert_eq!(each(&mut grid), expected.map_or(Ok(4), Err));
    }
}

proptest! {
    #[test]
    fn any_stamps_in_any_blocks(
        steps in proptest::collection::vec(
            prop_oneof![
                8 => Just(1.0),
                2 => Just(0.9),
                1 => Just(0.0),
                1 => 0.0..30.0_f64,
                1 => Just(f64::NAN),
            ],
            1..120,
        ),
        epoch in prop_oneof![Just(0.0), Just(1.6e9)],
        rows in 1..40_usize,
    ) {
        let mut at = epoch;
        let stamps: Vec<f64> = (steps.iter())
            .map(|step| {
                at += if step.is_finite() { *step } else { 1.0 };
                if step.is_finite() { at } else { f64::NAN }
            })
            .collect();
        compare(&table(&stamps), rows);
    }

    #[test]
    fn even_stamps_in_any_blocks(
        count in 1..200_u32,
        step in prop_oneof![Just(1.0), Just(5.0), Just(0.1)],
        rows in 1..40_usize,
    ) {
        let stamps: Vec<f64> = (0..count).map(|i| 3.0 + f64::from(i) * step).collect();
        compare(&table(&stamps), rows);
    }
}
