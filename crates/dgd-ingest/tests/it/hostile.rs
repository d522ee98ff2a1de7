//! No input makes the readers panic, and none makes them ask for much more than it is.

use crate::{Dice, table_of, values};
use dgd_export::{CsvOptions, McapOptions, write_csv, write_mcap};
use dgd_ingest::IngestError;
use dgd_recording::{Column, Table};
use mcap::{Compression, WriteOptions};
use std::collections::BTreeMap;
use std::io::Cursor;

fn small() -> Table {
    let column = |tag: &str, unit: &str, slope: f64| Column {
        tag: tag.into(),
        unit: Some(unit.into()),
        values: (0..60).map(|i| f64::from(i) * slope).collect(),
    };
    let columns = vec![
        column("t", "s", 1.0),
        column("FT4", "gpm", 0.7),
        column("PT1", "psia", -3.1),
    ];
    Table {
        columns,
        ..Table::default()
    }
}

/// Flips bits, cuts, repeats, and puts huge numbers where lengths may be.
fn mutated(bytes: &[u8], dice: &mut Dice) -> Vec<u8> {
    let mut bytes = bytes.to_vec();
    for _ in 0..=dice.below(3) {
        if bytes.is_empty() {
            break;
        }
        let at = dice.below(bytes.len());
        match dice.below(7) {
            0 | 1 => bytes[at] ^= 1 << dice.below(8),
            2 => bytes[at] = dice.next() as u8,
            3 => bytes.truncate(at),
            4 => {
                let end = at + dice.below(bytes.len() - at).min(64);
                let piece = bytes[at..end].to_vec();
                let to = dice.below(bytes.len());
                bytes.splice(to..to, piece);
            }
            5 => {
                let end = at + dice.below(bytes.len() - at).min(16);
                bytes.drain(at..end);
            }
            _ => {
                let huge = [u64::MAX, 1 << 40, 1 << 31, 0, 0x00ff_ffff_ffff_ffff][dice.below(5)];
                let end = bytes.len().min(at + 8);
                bytes[at..end].copy_from_slice(&huge.to_le_bytes()[..end - at]);
            }
        }
    }
    bytes
}

/// A table that came out of mutated bytes is still bounded by them.
fn survives(bytes: &[u8]) {
    if let Ok(table) = table_of(bytes) {
        let cells: usize = table.columns.iter().map(|c| c.values.len()).sum();
        assert!(
            cells <= 100 * bytes.len() + 1000,
            "{cells} cells of {} bytes",
            bytes.len()
        );
    }
}

#[test]
fn mutated_csv_never_panics() {
    let mut texts = vec![Vec::new()];
    write_csv(&small(), &CsvOptions::default(), &mut texts[0]).unwrap();
    texts.push(b"time;a\n59:59,9;1,5\n00:00,0;\"2,5\"\n00:00,1;-999,25\n".to_vec());
    texts.push(b"Date,Time,x\n2024-10-22,23:59:59,1\n2024-10-23,00:00:00,2\n".to_vec());
    texts.push("\u{feff}T [°C];\"a \"\"b\"\"\"\r\n2024-10-22T00:00:00.5Z;1\r\n;\r\n".into());
    let mut dice = Dice(1);
    for text in &texts {
        for _ in 0..4000 {
            survives(&mutated(text, &mut dice));
        }
    }
}

#[test]
fn mutated_mcap_never_panics() {
    let mut log = Cursor::new(Vec::new());
    write_mcap(&small(), &McapOptions::default(), &mut log).unwrap();
    let mut logs = vec![log.into_inner()];
    for compression in [None, Some(Compression::Lz4), Some(Compression::Zstd)] {
        for checksums in [true, false] {
            let mut log = WriteOptions::new()
                .compression(compression)
                .compression_threads(0)
                .calculate_chunk_crcs(checksums)
                .chunk_size(Some(400))
                .create(Cursor::new(Vec::new()))
                .unwrap();
            let schema = log
                .add_schema("s", "jsonschema", br#"{"properties":{"a":{"unit":"gpm"}}}"#)
                .unwrap();
            let channels = ["/a", "/b"].map(|topic| {
                log.add_channel(schema, topic, "json", &BTreeMap::new())
                    .unwrap()
            });
            for i in 0..40 {
                let channel_id = channels[usize::from(i % 3 == 0)];
                let header = mcap::records::MessageHeader {
                    channel_id,
                    sequence: 0,
                    log_time: i * 1000,
                    publish_time: 0,
                };
                let text = format!(r#"{{"a":{i},"b":[1,2,{{"c":null}}],"s":"x\"y"}}"#);
                log.write_to_known_channel(&header, text.as_bytes())
                    .unwrap();
            }
            log.finish().unwrap();
            logs.push(log.into_inner().into_inner());
        }
    }
    let mut dice = Dice(2);
    for log in &logs {
        for _ in 0..2000 {
            survives(&mutated(log, &mut dice));
        }
    }
}

#[test]
fn every_cut_of_a_file_is_survived() {
    let mut text = Vec::new();
    write_csv(&small(), &CsvOptions::default(), &mut text).unwrap();
    let mut log = Cursor::new(Vec::new());
    write_mcap(&small(), &McapOptions::default(), &mut log).unwrap();
    for bytes in [text, log.into_inner()] {
        for end in 0..bytes.len() {
            survives(&bytes[..end]);
        }
    }
}

#[test]
fn a_million_columns_are_refused() {
    let text = format!("{}1\n{}1\n", "1,".repeat(999_999), "2,".repeat(999_999));
    let error = table_of(text.as_bytes()).unwrap_err();
    assert!(matches!(error, IngestError::TooLarge { .. }), "{error}");
}

#[test]
fn short_rows_of_a_wide_table_are_refused_before_they_are_filled() {
    let text = format!("{}1\n{}", "1,".repeat(5000), "1\n".repeat(500_000));
    let error = table_of(text.as_bytes()).unwrap_err();
    assert!(
        matches!(error, IngestError::TooLarge { limit, .. } if limit < 4_000_000),
        "{error}"
    );
}

#[test]
fn endless_lines_and_open_quotes_cost_one_line() {
    let digits = [b"0.".to_vec(), b"7".repeat(1_000_000)].concat();
    assert!(table_of(&digits).is_ok_and(|t| t.rows() == 1));
    assert!(table_of(&digits[2..]).is_err(), "no f64 is so large");
    assert!(table_of(&b"x".repeat(1_000_000)).is_err());
    let text = format!("t,a\n0,1\n1,\"2\n{}", "2,3\n".repeat(1000));
    let table = table_of(text.as_bytes()).unwrap();
    assert_eq!(values(&table, "a").len(), 1002);
}

#[test]
fn many_open_quotes_are_read_in_one_pass() {
    let text = format!("t,a\n{}", "1,\"2\n".repeat(50_000));
    let table = table_of(text.as_bytes()).unwrap();
    assert!(values(&table, "t").len() >= 5_000);
}

#[test]
fn zeros_in_the_middle_of_a_text_cost_their_lines() {
    let mut text = b"t,a\n".to_vec();
    for i in 0..2000 {
        text.extend(format!("{i},{i}.5\n").bytes());
    }
    let at = text.len() / 2;
    text[at..at + 600].fill(0);
    let table = table_of(&text).unwrap();
    assert!(values(&table, "a").len() > 1850);
    assert_eq!(values(&table, "a").last(), Some(&1999.5));
}

#[test]
fn mislabelled_starts_are_refused_or_read_but_never_trusted() {
    for magic in [
        &b"\x89MCAP0\r\n"[..],
        b"\x89HDF\r\n\x1a\n",
        b"MATLAB 5.0 MAT-file",
    ] {
        let bytes = [magic, b"t,a\n0,1\n1,2\n"].concat();
        assert!(table_of(&bytes).is_err());
        assert!(table_of(magic).is_err());
    }
}
