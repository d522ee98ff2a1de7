//! What `dgd-export` writes comes back to the last bit.

use crate::{assert_same, table_of, unit, values};
use dgd_export::{CsvOptions, McapOptions, write_csv, write_mat5, write_mat73, write_mcap};
use dgd_ingest::{BlockOptions, BlockReader, Opened, ReadOptions};
use dgd_recording::{Column, IssueKind, Table};
use std::io::Cursor;

fn csv(table: &Table) -> Vec<u8> {
    let mut bytes = Vec::new();
    write_csv(table, &CsvOptions::default(), &mut bytes).unwrap();
    bytes
}

fn mcap(table: &Table) -> Vec<u8> {
    let mut bytes = Cursor::new(Vec::new());
    write_mcap(table, &McapOptions::default(), &mut bytes).unwrap();
    bytes.into_inner()
}

/// Awkward values on a clock of `step_s`.
fn sample(step_s: f64) -> Table {
    let mut dice = crate::Dice(11);
    let rows = 3000;
    let column = |tag: &str, unit: Option<&str>, values: Vec<f64>| Column {
        tag: tag.into(),
        unit: unit.map(Into::into),
        values,
    };
    let noise: Vec<f64> = (0..rows)
        .map(|_| {
            let size = 10_f64.powi(dice.below(40) as i32 - 20);
            (dice.next() as f64 / 3.0 - 3e8) * size
        })
        .collect();
    let gaps = (0..rows)
        .map(|i| {
            if i % 7 == 3 {
                f64::NAN
            } else {
                0.1 + f64::from(i) * 0.2
            }
        })
        .collect();
    let columns = vec![
        column(
            "t",
            Some("s"),
            (0..rows).map(|i| f64::from(i) * step_s).collect(),
        ),
        column("FT1", Some("gpm"), noise),
        column("PT1", Some("psia"), gaps),
        column("hook load, \"raw\"", None, vec![-0.0; rows as usize]),
        column("dead", Some("%"), vec![f64::NAN; rows as usize]),
    ];
    Table {
        columns,
        ..Table::default()
    }
}

fn assert_equal(found: &Table, expected: &Table) {
    assert_eq!(found.columns.len(), expected.columns.len());
    for column in &expected.columns {
        assert_same(values(found, &column.tag), &column.values);
        assert_eq!(
            unit(found, &column.tag),
            column.unit.as_deref(),
            "{}",
            column.tag
        );
    }
    assert!(found.issues.is_empty(), "{:?}", found.issues);
}

#[test]
fn csv_returns_every_bit() {
    for step in [1.0, 0.1, 1.0 / 3.0] {
        let table = sample(step);
        assert_equal(&table_of(&csv(&table)).unwrap(), &table);
    }
}

#[test]
fn mcap_returns_every_bit_of_values_and_whole_seconds() {
    let table = sample(1.0);
    assert_equal(&table_of(&mcap(&table)).unwrap(), &table);
}

#[test]
fn mcap_returns_tenths_of_seconds_as_their_nearest_numbers() {
    let found = table_of(&mcap(&sample(0.1))).unwrap();
    // `i * 0.1` is not always the number nearest to i tenths; the log's nanoseconds are.
    let expected: Vec<f64> = (0..3000).map(|i| f64::from(i) / 10.0).collect();
    assert_same(values(&found, "t"), &expected);
}

#[test]
fn an_origin_survives_in_a_log_and_so_does_an_unknown_zone() {
    for origin in ["2014-10-07T06:30:00.25Z", "2014-10-07T06:30:00.25-00:00"] {
        let table = Table {
            origin: Some(origin.to_owned()),
            ..sample(1.0)
        };
        let log = mcap(&table);
        let found = table_of(&log).unwrap();
        assert_eq!(found.origin.as_deref(), Some(origin));
        assert_same(values(&found, "t"), &table.columns[0].values);
        let options = ReadOptions::default();
        let opened = BlockReader::open(Cursor::new(log), &options, BlockOptions::default());
        let Ok(Opened::Blocks(blocks)) = opened else {
            panic!("one topic in order");
        };
        assert_eq!(blocks.head().origin.as_deref(), Some(origin));
    }
}

#[test]
fn a_column_without_a_name_keeps_its_unit_in_text() {
    let column = |tag: &str, unit: &str| Column {
        tag: tag.into(),
        unit: Some(unit.into()),
        values: vec![0.0, 1.0],
    };
    let columns = vec![column("t", "s"), column("", "psi"), column("FT4", "gpm")];
    let table = Table {
        columns,
        ..Table::default()
    };
    let found = table_of(&csv(&table)).unwrap();
    assert_eq!(unit(&found, "c2"), Some("psi"));
    assert_same(values(&found, "FT4"), &[0.0, 1.0]);
}

#[test]
fn the_same_table_gives_the_same_bytes() {
    let table = sample(1.0);
    assert_eq!(csv(&table), csv(&table));
    assert_eq!(mcap(&table), mcap(&table));
}

#[test]
fn formats_chain_without_loss() {
    let table = sample(1.0);
    let through_csv = table_of(&csv(&table)).unwrap();
    let through_both = table_of(&mcap(&through_csv)).unwrap();
    assert_equal(&through_both, &table);
}

#[test]
fn single_columns_with_holes_keep_their_rows() {
    for values in [vec![f64::NAN, 1.0, f64::NAN], vec![1.0, f64::NAN]] {
        let columns = vec![Column {
            tag: "a".into(),
            unit: None,
            values: values.clone(),
        }];
        let table = Table {
            columns,
            ..Table::default()
        };
        assert_same(
            crate::values(&table_of(&csv(&table)).unwrap(), "a"),
            &values,
        );
    }
}

#[test]
fn names_that_differ_in_case_alone_keep_their_units_in_mat_files() {
    let column = |tag: &str, unit: Option<&str>| Column {
        tag: tag.into(),
        unit: unit.map(Into::into),
        values: vec![0.0, 1.0],
    };
    for (small, large) in [
        (Some("s"), Some("degC")),
        (Some("s"), None),
        (None, Some("degC")),
    ] {
        let table = Table {
            columns: vec![column("t", small), column("T", large)],
            ..Table::default()
        };
        let mut old = Vec::new();
        write_mat5(&table, "rig", &mut old).unwrap();
        for bytes in [old, write_mat73(&table, "rig").unwrap()] {
            let found = table_of(&bytes).unwrap();
            assert_eq!((unit(&found, "t"), unit(&found, "T")), (small, large));
        }
    }
}

#[test]
fn rows_without_a_value_keep_their_place_in_text() {
    let column = |tag: &str, unit: Option<&str>| Column {
        tag: tag.into(),
        unit: unit.map(Into::into),
        values: vec![f64::NAN, f64::NAN, 1.5, f64::NAN, 2.5, f64::NAN],
    };
    for unit in [Some("gpm"), None] {
        let table = Table {
            columns: vec![column("FT1", unit), column("FT4", unit)],
            ..Table::default()
        };
        assert_equal(&table_of(&csv(&table)).unwrap(), &table);
    }
}

#[test]
fn log_nulls_are_missing_and_told_in_every_format() {
    let column = |tag: &str, values: &[f64]| Column {
        tag: tag.into(),
        unit: None,
        values: values.to_vec(),
    };
    let table = Table {
        columns: vec![
            column("t", &[0.0, 1.0, 2.0, 3.0]),
            column("a", &[1.0, -999.25, -9999.0, -999.0]),
        ],
        ..Table::default()
    };
    let mut old = Vec::new();
    write_mat5(&table, "rig", &mut old).unwrap();
    let new = write_mat73(&table, "rig").unwrap();
    for bytes in [csv(&table), mcap(&table), old, new] {
        let found = table_of(&bytes).unwrap();
        let a = &found.column("a").unwrap().values;
        assert_same(a, &[1.0, f64::NAN, f64::NAN, -999.0]);
        let told = crate::issue(&found, IssueKind::UnreadableValue).to_string();
        assert!(told.contains("`a`") || told.contains("`rig.a`"), "{told}");
        assert!(told.contains("2 cells with -999.25"), "{told}");
    }
}

#[test]
fn units_of_one_beside_none_come_back_in_text() {
    let rows = || (0..100).map(f64::from);
    let column = |tag: &str, unit: Option<&str>, values: Vec<f64>| Column {
        tag: tag.into(),
        unit: unit.map(Into::into),
        values,
    };
    let table = Table {
        columns: vec![
            column("t", None, rows().collect()),
            column("valve", Some("1"), rows().map(|i| i / 100.0).collect()),
            column("p[0]", Some("1"), rows().collect()),
        ],
        ..Table::default()
    };
    assert_equal(&table_of(&csv(&table)).unwrap(), &table);
}
