//! Decompression bombs are refused by their limit, and take little memory.
//!
//! Apart from the other tests, for it counts all that its process allocates.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

#[path = "it/mat5_bytes.rs"]
mod mat5_bytes;
mod peak;

use dgd_ingest::IngestError;
use dgd_recording::{Column, Table};
use flate2::Compression;
use mat5_bytes::{compress, element, matrix};
use mcap::WriteOptions;
use mcap::records::MessageHeader;
use peak::{MIB, peak};
use std::collections::BTreeMap;
use std::io::Cursor;

/// What reading says, and bytes allocated at the same time meanwhile.
fn refused(bytes: &[u8]) -> (IngestError, usize) {
    let (said, peak) = peak(bytes);
    (said.unwrap_err(), peak)
}

#[track_caller]
fn names_its_limit(name: &str, bytes: &[u8], most: usize) {
    let (error, found) = refused(bytes);
    assert!(
        error.to_string().contains("the limit is"),
        "{name}: {error}"
    );
    assert!(found < most, "{name}: {found} bytes for {}", bytes.len());
}

/// A MAT v5 file of one compressed array: its class, its rows, and what follows its name.
fn mat5(class: u32, rows: u32, body: Vec<u8>) -> Vec<u8> {
    let mut file = b"MATLAB 5.0 MAT-file".to_vec();
    file.resize(124, b' ');
    file.extend([0, 1, b'I', b'M']);
    let array = matrix(class, [rows, 1], "x", &[body]);
    file.extend(compress(&array, Compression::best()));
    file
}

/// A log of messages, each alone in its chunk, with this many blanks.
fn log(compression: mcap::Compression, messages: u64, blanks: usize) -> Vec<u8> {
    let mut log = WriteOptions::new()
        .compression(Some(compression))
        .compression_threads(0)
        .chunk_size(Some(1))
        .create(Cursor::new(Vec::new()))
        .unwrap();
    let channel_id = log
        .add_channel(0, "/rig", "json", &BTreeMap::new())
        .unwrap();
    let text = format!("{{\"a\":{}1}}", " ".repeat(blanks));
    for log_time in 0..messages {
        let header = MessageHeader {
            channel_id,
            sequence: 0,
            log_time,
            publish_time: log_time,
        };
        log.write_to_known_channel(&header, text.as_bytes())
            .unwrap();
    }
    log.finish().unwrap();
    log.into_inner().into_inner()
}

/// The same log, but its chunks claim to unpack to `claimed` bytes.
fn claiming(mut log: Vec<u8>, compression: &[u8], claimed: u64) -> Vec<u8> {
    let names: Vec<usize> = (16..log.len() - compression.len())
        .filter(|at| log[*at..].starts_with(compression))
        .collect();
    for name in names {
        log[name - 16..name - 8].copy_from_slice(&claimed.to_le_bytes());
    }
    log
}

/// A log of one message a topic, whose topics share a schema.
fn described(schema: &str, topics: &[String], message: &str) -> Vec<u8> {
    let mut log = WriteOptions::new()
        .compression(None)
        .create(Cursor::new(Vec::new()))
        .unwrap();
    let schema = log
        .add_schema("s", "jsonschema", schema.as_bytes())
        .unwrap();
    for topic in topics {
        let channel_id = log
            .add_channel(schema, topic, "json", &BTreeMap::new())
            .unwrap();
        let header = MessageHeader {
            channel_id,
            sequence: 0,
            log_time: 0,
            publish_time: 0,
        };
        log.write_to_known_channel(&header, message.as_bytes())
            .unwrap();
    }
    log.finish().unwrap();
    log.into_inner().into_inner()
}

/// `{` of this many members, each with `value`, and `}`.
fn members(count: usize, value: &str) -> String {
    let members = (0..count).map(|i| format!("\"m{i}\":{value}"));
    format!("{{{}}}", members.collect::<Vec<_>>().join(","))
}

/// Bytes allocated at the same time while a sound table is read.
fn taken(bytes: &[u8]) -> usize {
    let (said, peak) = peak(bytes);
    said.unwrap();
    peak
}

fn names_are_not_repeated_without_end() {
    let long = "x".repeat(100_000);
    let units = members(2000, r#"{"unit":"gpm"}"#);
    // The path of a member holds the names above it: 200 MB of them.
    let schema = format!(r#"{{"properties":{{"{long}":{{"properties":{units}}}}}}}"#);
    let log = described(&schema, &["/a".into()], r#"{"a":1}"#);
    let found = taken(&log);
    assert!(found < 4 * MIB, "schema with a long name: {found} bytes");

    // Each topic takes the units of its schema: a million.
    let topics: Vec<String> = (0..500).map(|i| format!("/{i}")).collect();
    let log = described(
        &format!(r#"{{"properties":{units}}}"#),
        &topics,
        r#"{"a":1}"#,
    );
    let found = taken(&log);
    assert!(found < 8 * MIB, "schema of many topics: {found} bytes");

    // Each column's name begins with its topic: 100 MB of them.
    let topics = ["/a".into(), "/b".into(), format!("/{long}")];
    let log = described("{}", &topics, &members(1000, "1"));
    let found = taken(&log);
    assert!(found < 4 * MIB, "long topic: {found} bytes");

    // A schema that is parsed to a tree of thirty times its size.
    let schema = format!(r#"{{"a":[{}0]}}"#, "0,".repeat(4 << 20));
    let log = described(&schema, &["/a".into()], r#"{"a":1}"#);
    let found = taken(&log);
    // Its chunk is unpacked, and nothing else.
    assert!(found < log.len() + MIB, "long schema: {found} bytes");
}

#[test]
fn every_bomb_is_refused_by_its_limit_and_takes_little_memory() {
    // Ten million zeros of one byte each are 10 kB in the file and would be 80 MB of columns.
    let zeros = vec![0; 10_000_000];
    let bomb = mat5(6, 10_000_000, element(2, &zeros));
    assert!(bomb.len() < 20_000);
    names_its_limit("MAT v5, values", &bomb, MIB);
    // A million fields of one letter.
    let names = [
        element(5, &1_u32.to_le_bytes()),
        element(1, &zeros[..1_000_000]),
    ]
    .concat();
    names_its_limit("MAT v5, fields", &mat5(2, 1, names), 3 * MIB);

    let values = vec![0.0; 13_000_000];
    let columns = vec![Column {
        tag: "x".into(),
        unit: None,
        values,
    }];
    let table = Table {
        columns,
        ..Table::default()
    };
    let bomb = dgd_export::write_mat73(&table, "gom").unwrap();
    drop(table);
    assert!(bomb.len() < 500_000);
    names_its_limit("MAT v7.3, values", &bomb, 2 * MIB);

    // Thirty megabytes of blanks in one message.
    let zstd = log(mcap::Compression::Zstd, 1, 30_000_000);
    assert!(zstd.len() < 20_000);
    names_its_limit("MCAP, zstd", &zstd, MIB);
    let lz4 = log(mcap::Compression::Lz4, 1, 30_000_000);
    names_its_limit("MCAP, lz4", &claiming(lz4.clone(), b"lz4", 1 << 40), MIB);
    // Each chunk within its limit, all together not.
    let many = log(mcap::Compression::Zstd, 40, 4_000_000);
    assert!(many.len() < 60_000);
    names_its_limit("MCAP, all chunks", &many, 20 * MIB);
    // The claim is small, what comes out is not: the checksum cannot hold, nor the length.
    for (log, name) in [(zstd, &b"zstd"[..]), (lz4, b"lz4")] {
        let (error, found) = refused(&claiming(log, name, 1000));
        assert!(matches!(error, IngestError::Damaged { .. }), "{error}");
        assert!(found < 2 * MIB, "{found} bytes: {error}");
    }

    names_are_not_repeated_without_end();
}
