//! How much memory CSV and MCAP files can make the readers take.
//!
//! Apart from the other tests, for it counts all that its process allocates.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

#[path = "it/mutate.rs"]
mod mutate;
mod peak;

use dgd_export::{CsvOptions, McapOptions, write_csv, write_mcap};
use dgd_ingest::{BlockOptions, BlockReader, Opened, ReadOptions};
use dgd_recording::{Column, Table};
use mutate::{apply, damage};
use peak::{MIB, peak, peak_of};
use proptest::strategy::{Strategy, ValueTree};
use proptest::test_runner::TestRunner;
use std::io::Cursor;

fn both(rows: i32) -> [Vec<u8>; 2] {
    let column = |tag: &str, unit: &str, slope: f64| Column {
        tag: tag.into(),
        unit: Some(unit.into()),
        values: (0..rows).map(|i| f64::from(i) * slope).collect(),
    };
    let columns = vec![
        column("t", "s", 1.0),
        column("FT4", "gpm", 0.7),
        column("PT1", "psia", -3.1),
    ];
    let table = Table {
        columns,
        ..Table::default()
    };
    let mut text = Vec::new();
    write_csv(&table, &CsvOptions::default(), &mut text).unwrap();
    let mut log = Cursor::new(Vec::new());
    write_mcap(&table, &McapOptions::default(), &mut log).unwrap();
    [text, log.into_inner()]
}

/// One test, for two would count each other's.
#[test]
fn memory_is_bounded() {
    by_the_file_whatever_it_claims();
    by_the_file_with_one_reading_a_line();
    whatever_the_length_in_blocks();
}

fn by_the_file_whatever_it_claims() {
    let small = both(60);
    small.iter().for_each(|bytes| _ = peak(bytes));
    let mut runner = TestRunner::deterministic();
    let damage = damage();
    for round in 0..4000 {
        let acts = damage.new_tree(&mut runner).unwrap().current();
        let bytes = apply(&small[round % 2], &acts, 8);
        let (_, found) = peak(&bytes);
        assert!(
            found < 20 * MIB + 64 * bytes.len(),
            "{found} bytes for {}: {acts:?}",
            bytes.len()
        );
    }

    // The worst that short rows of a wide table can do before they are refused or filled.
    let wide = format!("{}1\n{}", "1,".repeat(900), "1\n".repeat(1100));
    let (_, found) = peak(wide.as_bytes());
    assert!(found < 20 * MIB, "{found} bytes");

    // Sound files: the columns, for MCAP with room to grow, and little else.
    let rows = 200_000;
    let decoded = 3 * 8 * 200_000;
    let [text, log] = both(rows);
    let (_, found) = peak(&text);
    assert!(
        found < decoded + decoded / 10,
        "{found} bytes for {decoded} decoded"
    );
    let (_, found) = peak(&log);
    assert!(
        found < 2 * decoded + 4 * MIB,
        "{found} bytes for {decoded} decoded"
    );
}

/// As many tags as are let through, each with its own times.
fn by_the_file_with_one_reading_a_line() {
    let tag = |i: u32| (i.wrapping_mul(2_654_435_761) >> 8) % 100;
    let line = |i: u32| format!("{i}.{i:05},t{},{i}\n", tag(i));
    let rows: String = (0..40_000).map(line).collect();
    let text = format!("time,tag,value\n{rows}");
    let (table, found) = peak(text.as_bytes());
    assert_eq!(table.unwrap().1.rows(), 40_000);
    assert!(
        found < 20 * MIB + 64 * text.len(),
        "{found} bytes for {}",
        text.len()
    );
}

fn whatever_the_length_in_blocks() {
    let options = BlockOptions {
        bytes: 1 << 20,
        cells: 1 << 14,
    };
    let taken = |bytes: &[u8]| {
        let (rows, taken) = peak_of(|| {
            let file = Cursor::new(bytes);
            let opened = BlockReader::open(file, &ReadOptions::default(), options).unwrap();
            let Opened::Blocks(mut reader) = opened else {
                panic!("it is not read in blocks");
            };
            let mut rows = 0;
            while let Some(block) = reader.next_block().unwrap() {
                rows += block.rows();
            }
            rows
        });
        assert!(rows >= 200_000);
        taken
    };
    let (short, long) = (both(200_000), both(800_000));
    for (short, long) in short.iter().zip(&long) {
        let [short, long] = [short, long].map(|bytes| taken(bytes));
        // The columns of the longer one alone are 19 MB.
        assert!(long < 16 * MIB, "{long} bytes");
        assert!(long < short + MIB / 4, "{short} bytes, then {long}");
    }
}
