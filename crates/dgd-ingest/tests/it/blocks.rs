//! Recordings that are read block by block are those that are read whole.

use crate::claims::in_blocks;
use crate::table_of;
use dgd_export::{CsvOptions, McapOptions, write_csv, write_mcap};
use dgd_ingest::{BlockError, BlockOptions, BlockReader, IngestError, Opened, ReadOptions};
use dgd_recording::{Column, Table};
use std::fmt::Write as _;
use std::io::Cursor;

/// Blocks that the text has, after each was compared.
fn blocks(text: &str) -> Option<usize> {
    in_blocks(text.as_bytes(), &table_of(text.as_bytes()))
}

fn rows(head: &str, rows: usize, row: impl Fn(usize) -> String) -> String {
    (0..rows).fold(head.to_owned(), |mut text, i| {
        let _ = writeln!(text, "{}", row(i));
        text
    })
}

/// Why the content must be read whole.
fn whole(bytes: &[u8]) -> &'static str {
    let source = Cursor::new(bytes);
    match BlockReader::open(source, &ReadOptions::default(), BlockOptions::default()) {
        Ok(Opened::Whole(reason)) => reason,
        other => panic!("{other:?}"),
    }
}

#[test]
fn a_block_ends_anywhere() {
    // Every length of the text gives windows and blocks of other sizes.
    for padding in 0..48 {
        let text = rows("t,FT4\ns,gpm\n", 900, |i| {
            let pad = if i == 0 { padding } else { 0 };
            format!("{i},{}{:pad$}", 0.1 * i as f64, "")
        });
        assert!(blocks(&text) >= Some(1), "padding {padding}");
    }
}

#[test]
fn what_only_later_rows_show_is_known_from_the_first_block_on() {
    let late = rows("t,a,b,c,,\n", 3000, |i| match i {
        0..2000 => format!("{i},,words,,,"),
        2500 => ",,,,,\n,,,,,\n2500.5,1,\"quoted\n2\",-999.25,,".into(),
        _ => format!("{i},{i}.5,words,,,"),
    });
    assert!(blocks(&late) > Some(1));
}

#[test]
fn clocks_run_on_from_block_to_block() {
    let clock = rows("time,a\n", 5000, |i| {
        let (h, m, s) = ((i / 360) % 24, (i / 6) % 60, (i % 6) * 10);
        format!("{h:02}:{m:02}:{s:02},{i}")
    });
    assert!(blocks(&clock) > Some(1));
    let both = rows("date,time,a\n", 5000, |i| {
        let (d, h, m) = (1 + i / 1440, (i / 60) % 24, i % 60);
        format!("2024-10-{d:02},{h:02}:{m:02}:00,{i}")
    });
    assert!(blocks(&both) > Some(1));
    let epoch = rows("time,a\n", 5000, |i| match i {
        0..300 => format!(",{i}"),
        _ => format!("{},{i}", 1_729_600_000_u64 + i as u64),
    });
    assert!(blocks(&epoch) > Some(1));
}

#[test]
fn rows_of_delimiters_fill_blocks_without_end() {
    let text = format!(
        "t,a\n0,1\n{}9,2\n{}",
        ",\n".repeat(20_000),
        ",\n".repeat(50)
    );
    assert!(blocks(&text) > Some(1));
}

#[test]
fn quotes_over_the_end_of_a_window_stay_together() {
    for shift in 0..200 {
        let text = rows("t,note,a\n", 400, |i| match i {
            0 => format!("0,{},1", "x".repeat(shift)),
            _ if i % 7 == 0 => format!("{i},\"two\nlines, \"\"quoted\"\"\",{i}"),
            _ if i % 11 == 0 => format!("{i},\"open,{i}"),
            _ => format!("{i},,{i}"),
        });
        blocks(&text);
    }
}

#[test]
fn a_log_of_many_chunks_comes_in_blocks() {
    let column = |tag: &str, unit: &str, slope: f64| Column {
        tag: tag.into(),
        unit: Some(unit.into()),
        values: (0..60_000).map(|i| f64::from(i) * slope).collect(),
    };
    let columns = vec![
        column("t", "s", 1.0),
        column("FT4", "gpm", 0.7),
        column("PT1", "psia", -3.1),
    ];
    let origin = Some("2014-10-07T06:30:00Z".to_owned());
    let table = Table {
        columns,
        origin,
        ..Table::default()
    };
    let mut log = Cursor::new(Vec::new());
    write_mcap(&table, &McapOptions::default(), &mut log).unwrap();
    let log = log.into_inner();
    assert!(in_blocks(&log, &table_of(&log)) > Some(2));
    // Cut off, it is searched for what is left of it.
    let reason = whole(&log[..log.len() / 2]);
    assert!(reason.contains("cut off"), "{reason}");

    // As a text, too, of which the default window holds all.
    let mut text = Vec::new();
    write_csv(&table, &CsvOptions::default(), &mut text).unwrap();
    assert!(in_blocks(&text, &table_of(&text)) > Some(2));
}

#[test]
fn what_must_be_read_whole_says_why() {
    let mac = whole(b"t,a\r0,1\r1,2\r");
    assert!(mac.contains("lines"), "{mac}");
    let long = format!(
        "t,a\n{}",
        rows("", 3, |i| format!("{i},\"{}\"", "x".repeat(3 << 20)))
    );
    let long = whole(long.as_bytes());
    assert!(long.contains("megabyte"), "{long}");
    let mut mat = Vec::new();
    let table = table_of(b"t,a\n0,1\n1,2\n").unwrap();
    dgd_export::write_mat5(&table, "rig", &mut mat).unwrap();
    assert!(whole(&mat).contains("column after another"));
}

#[test]
fn a_wide_table_of_short_rows_is_refused_before_it_is_written() {
    let wide = format!("{}\n{}", "1,".repeat(9000), "1\n".repeat(200_000));
    let expected = table_of(wide.as_bytes()).unwrap_err();
    assert!(matches!(expected, IngestError::TooLarge { .. }));
    let source = Cursor::new(wide.as_bytes());
    let found = BlockReader::open(source, &ReadOptions::default(), BlockOptions::default());
    assert!(matches!(found, Err(BlockError::Content(error)) if error == expected));
}
