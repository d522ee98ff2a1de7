//! A table that is written block by block gives the bytes of one that is written at once.

use crate::{column, table};
use dgd_export::{
    CsvOptions, CsvWriter, ExportError, McapOptions, McapWriter, write_csv, write_mcap,
};
use dgd_recording::Table;
use std::io::Cursor;

const ROWS: usize = 20_000;

fn long() -> Table {
    let values = |f: fn(f64) -> f64| (0..ROWS).map(|i| f(i as f64)).collect::<Vec<_>>();
    table(vec![
        column("t", Some("s"), &values(|t| t)),
        column("FT4", Some("gpm"), &values(|t| (0.01 * t).sin() * 800.0)),
        column(
            "PT1",
            None,
            &values(|t| if t % 9.0 < 2.0 { f64::NAN } else { t / 7.0 }),
        ),
    ])
}

/// The table in blocks of so many rows.
fn blocks(table: &Table, rows: usize) -> impl Iterator<Item = Table> {
    (0..table.rows()).step_by(rows).map(move |from| {
        let mut block = table.clone();
        for column in &mut block.columns {
            let to = column.values.len().min(from + rows);
            column.values = column.values[from..to].to_vec();
        }
        block
    })
}

fn in_blocks(table: &Table, rows: usize) -> [Vec<u8>; 2] {
    let (mut text, mut log) = (Vec::new(), Cursor::new(Vec::new()));
    let mut csv = CsvWriter::new(table, &CsvOptions::default(), &mut text).unwrap();
    let mut mcap = McapWriter::new(table, &McapOptions::default(), &mut log).unwrap();
    for block in blocks(table, rows) {
        csv.write(&block).unwrap();
        mcap.write(&block).unwrap();
    }
    csv.finish().unwrap();
    mcap.finish().unwrap();
    [text, log.into_inner()]
}

fn at_once(table: &Table) -> [Vec<u8>; 2] {
    let (mut text, mut log) = (Vec::new(), Cursor::new(Vec::new()));
    write_csv(table, &CsvOptions::default(), &mut text).unwrap();
    write_mcap(table, &McapOptions::default(), &mut log).unwrap();
    [text, log.into_inner()]
}

#[test]
fn the_bytes_are_those_of_the_whole_table() {
    let table = long();
    let expected = at_once(&table);
    for rows in [1, 999, ROWS, ROWS + 1] {
        assert!(
            in_blocks(&table, rows) == expected,
            "in blocks of {rows} rows"
        );
    }
}

#[test]
fn only_the_last_row_of_all_is_kept_from_being_empty() {
    let nothing = [1.0, f64::NAN, f64::NAN];
    let table = table(vec![
        column("a", None, &nothing),
        column("b", None, &nothing),
    ]);
    let mut text = Vec::new();
    let mut csv = CsvWriter::new(&table, &CsvOptions::default(), &mut text).unwrap();
    blocks(&table, 1).for_each(|block| csv.write(&block).unwrap());
    csv.finish().unwrap();
    assert_eq!(text, b"a,b\n1,1\n,\nNaN,\n");
}

#[test]
fn a_block_of_other_columns_is_refused() {
    let (head, other) = (long(), table(vec![column("t", None, &[0.0])]));
    let refused = |error: ExportError| {
        matches!(
            error,
            ExportError::Width {
                expected: 3,
                found: 1
            }
        )
    };
    let mut csv = CsvWriter::new(&head, &CsvOptions::default(), Vec::new()).unwrap();
    assert!(refused(csv.write(&other).unwrap_err()));
    let log = Cursor::new(Vec::new());
    let mut mcap = McapWriter::new(&head, &McapOptions::default(), log).unwrap();
    assert!(refused(mcap.write(&other).unwrap_err()));
}
