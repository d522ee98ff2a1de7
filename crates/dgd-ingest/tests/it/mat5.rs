//! MAT v5 files; the fixtures are told in `tests/data/mat/README.md`.

use dgd_ingest::{Format, IngestError, ReadOptions, read};
use dgd_recording::{Column, IssueKind, Table};
use flate2::Compression;
use proptest::prelude::*;

use crate::mat5_bytes::{element, matrix, words};
use crate::mutate::{apply, damage};

const COMPRESSED: &[u8] = include_bytes!("../data/mat/struct_compressed.mat");
const PLAIN: &[u8] = include_bytes!("../data/mat/struct_plain.mat");
const CLASSES: &[u8] = include_bytes!("../data/mat/classes.mat");
const ODD: &[u8] = include_bytes!("../data/mat/odd.mat");
const LITTLE: &[u8] = include_bytes!("../data/mat/shrunk_little.mat");
const BIG: &[u8] = include_bytes!("../data/mat/shrunk_big.mat");
const OBJECTS: &[u8] = include_bytes!("../data/mat/objects.mat");

/// The arithmetic of `make.py`.
pub(crate) fn channel(c: u32, n: u32) -> Vec<f64> {
    (0..n)
        .map(|i| f64::from((7 * i + 3 * c) % 13) / 4.0 + 100.0 * f64::from(c))
        .collect()
}

pub(crate) fn count(n: u32) -> Vec<f64> {
    (0..n).map(f64::from).collect()
}

pub(crate) fn values<'t>(table: &'t Table, tag: &str) -> &'t [f64] {
    let column = table.columns.iter().find(|c| c.tag == tag);
    let Some(column) = column else {
        panic!("no `{tag}` among {:?}", tags(table));
    };
    &column.values
}

pub(crate) fn tags(table: &Table) -> Vec<&str> {
    table.columns.iter().map(|c| c.tag.as_str()).collect()
}

pub(crate) fn issue<'t>(table: &'t Table, tag: &str) -> &'t str {
    let place = format!("`{tag}`");
    let found = table.issues.iter().find(|i| i.place.contains(&place));
    found.map_or("", |i| i.message.as_str())
}

fn table(bytes: &[u8]) -> Table {
    let (format, table) = read(bytes, &ReadOptions::default()).unwrap();
    assert_eq!(format, Format::Mat5);
    table
}

fn error(bytes: &[u8]) -> IngestError {
    read(bytes, &ReadOptions::default()).unwrap_err()
}

fn compress(variable: &[u8]) -> Vec<u8> {
    crate::mat5_bytes::compress(variable, Compression::fast())
}

fn doubles(sides: [u32; 2], name: &str, values: &[f64]) -> Vec<u8> {
    let bytes: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
    matrix(6, sides, name, &[element(9, &bytes)])
}

fn file(elements: &[Vec<u8>]) -> Vec<u8> {
    let mut bytes = PLAIN[..128].to_vec();
    bytes.extend(elements.concat());
    bytes
}

#[test]
fn compressed_and_plain_structs_read_alike() {
    for bytes in [COMPRESSED, PLAIN] {
        let table = table(bytes);
        assert_eq!(
            tags(&table),
            ["gom.t", "gom.FT1", "gom.PT1", "gom.pump.SPM", "Ts"]
        );
        assert_eq!(values(&table, "gom.t"), count(200));
        assert_eq!(values(&table, "gom.FT1"), channel(1, 200));
        assert_eq!(values(&table, "gom.PT1"), channel(2, 200));
        assert_eq!(values(&table, "gom.pump.SPM"), channel(3, 200));
        assert_eq!(values(&table, "Ts"), [4.0]);
    }
}

#[test]
fn a_sibling_struct_of_texts_gives_the_units() {
    let table = table(COMPRESSED);
    let units: Vec<_> = table.columns.iter().map(|c| c.unit.as_deref()).collect();
    assert_eq!(units, [Some("s"), Some("gpm"), Some("psi"), None, None]);
    assert_eq!(table.origin.as_deref(), Some("2015-06-01T00:00:00Z"));
    // The one text that is no unit is told, the others are not.
    assert_eq!(table.issues.len(), 1, "{:?}", table.issues);
    assert!(issue(&table, "gom.pump.note").contains("text"));
}

#[test]
fn every_numeric_class_becomes_doubles() {
    let table = table(CLASSES);
    for tag in [
        "int8", "uint8", "int16", "uint16", "int32", "uint32", "int64", "uint64", "float32",
        "float64",
    ] {
        assert_eq!(values(&table, tag), count(10), "{tag}");
    }
    assert_eq!(values(&table, "negative"), [-1.0, -2.0, -3.0]);
    assert_eq!(values(&table, "logical"), [1.0, 0.0, 1.0]);
    assert_eq!(table.issues, []);
}

#[test]
fn doubles_shrunk_to_any_type_read_alike_in_both_byte_orders() {
    let little = table(LITTLE);
    assert_eq!(little.columns.len(), 41);
    for kind in [1, 2, 3, 4, 5, 6, 7, 9, 12, 13] {
        for n in [1, 2, 3, 9] {
            let expected: Vec<f64> = (0..n).map(|i| 5.0 + f64::from(i)).collect();
            assert_eq!(values(&little, &format!("as{kind}_{n}")), expected);
        }
    }
    assert_eq!(little.columns[40].unit.as_deref(), Some("gpm"));
    assert_eq!(table(BIG), little);
}

#[test]
fn matrices_fall_into_columns_along_their_longer_side() {
    let table = table(ODD);
    for (tag, c) in [
        ("tall(:,1)", 1),
        ("tall(:,2)", 2),
        ("wide(1,:)", 1),
        ("wide(3,:)", 3),
    ] {
        assert_eq!(values(&table, tag), channel(c, 6), "{tag}");
    }
}

#[test]
fn cells_and_struct_arrays_are_numbered() {
    let table = table(ODD);
    assert_eq!(values(&table, "cells{1}"), channel(1, 5));
    assert_eq!(values(&table, "cells{3}"), channel(2, 6));
    assert_eq!(values(&table, "wells(2).depth"), channel(2, 4));
}

#[test]
fn what_holds_no_channels_is_told() {
    let table = table(ODD);
    for (tag, word) in [
        ("cube", "3 sides"),
        ("none", "empty"),
        ("cplx", "complex"),
        ("thin", "sparse"),
        ("page", "text"),
        ("cells{2}", "text"),
    ] {
        assert!(
            issue(&table, tag).contains(word),
            "{tag}: {:?}",
            table.issues
        );
    }
    assert!(table.issues.iter().all(|i| i.kind == IssueKind::Skipped));
}

#[test]
fn objects_are_passed_over_and_what_follows_is_read() {
    let table = table(OBJECTS);
    assert_eq!(tags(&table), ["good"]);
    assert_eq!(values(&table, "good"), [1.5, -2.5]);
    assert!(issue(&table, "f").contains("function handle"));
    assert!(table.issues.iter().any(|i| i.message.contains("timetable")));
}

#[test]
fn a_cut_file_gives_only_columns_that_are_whole() {
    for whole in [COMPRESSED, PLAIN] {
        let expected = table(whole);
        let mut partial = 0;
        for length in 0..whole.len() {
            match read(&whole[..length], &ReadOptions::default()) {
                Ok((Format::Mat5, cut)) => {
                    assert!(expected.columns.len() >= cut.columns.len());
                    for (cut, whole) in cut.columns.iter().zip(&expected.columns) {
                        assert_eq!((&cut.tag, &cut.values), (&whole.tag, &whole.values));
                    }
                    partial +=
                        usize::from(cut.issues.iter().any(|i| i.kind == IssueKind::Truncated));
                }
                Ok((Format::Csv, _)) => assert!(length < 128),
                Ok(other) => panic!("{length}: {other:?}"),
                Err(IngestError::Damaged { mend, .. }) => assert!(mend.contains("ends early")),
                Err(IngestError::NothingNumeric { .. }) => assert!(length <= 128, "{length}"),
                Err(error) => assert!(length < 128, "{length}: {error}"),
            }
        }
        assert!(partial > 200, "{partial} cuts left something");
    }
}

#[test]
fn no_flipped_bit_in_a_compressed_file_gives_other_values() {
    let expected = table(COMPRESSED);
    let mut refused = 0;
    for bit in 8 * 128..8 * COMPRESSED.len() {
        let mut bytes = COMPRESSED.to_vec();
        bytes[bit / 8] ^= 1 << (bit % 8);
        match read(&bytes, &ReadOptions::default()) {
            Ok((_, table)) => {
                for column in &table.columns {
                    let whole = expected.columns.iter().find(|c| c.tag == column.tag);
                    assert_eq!(Some(&column.values), whole.map(|c| &c.values), "bit {bit}");
                }
                if table.columns.len() < expected.columns.len() {
                    assert!(!table.issues.is_empty(), "bit {bit}");
                }
            }
            Err(_) => refused += 1,
        }
    }
    // Other variables stand beside the struct, so that most flips leave something.
    assert!(refused < 500, "{refused} flips left nothing");
}

#[test]
fn a_wrong_checksum_drops_the_whole_variable() {
    let mut one = compress(&doubles([2, 1], "x", &[1.0, 2.0]));
    let two = compress(&doubles([2, 1], "y", &[3.0, 4.0]));
    let last = one.len() - 1;
    one[last] ^= 1;
    let alone = error(&file(std::slice::from_ref(&one)));
    assert!(alone.to_string().contains("damaged MAT v5 at"), "{alone}");
    let both = table(&file(&[one, two]));
    assert_eq!(tags(&both), ["y"]);
    assert_eq!(both.issues[0].kind, IssueKind::Damaged);
    assert!(
        both.issues[0]
            .message
            .contains("the whole variable was left out")
    );
}

#[test]
fn sides_that_disagree_with_the_values_are_damage() {
    let huge = doubles([0x7FFF_FFFF, 1000], "x", &[1.0, 2.0]);
    for bytes in [huge.clone(), compress(&huge)] {
        let found = error(&file(&[bytes])).to_string();
        assert!(found.contains("16 bytes of values"), "{found}");
        assert!(found.contains("`x`"), "{found}");
    }
}

#[test]
fn a_variable_larger_than_its_stream_can_inflate_to_is_damage() {
    let mut variable = doubles([2, 1], "x", &[1.0, 2.0]);
    variable[4..8].copy_from_slice(&0xFFFF_FFF0_u32.to_le_bytes());
    let found = error(&file(&[compress(&variable)])).to_string();
    assert!(found.contains("4294967280 bytes"), "{found}");
}

#[test]
fn structs_nested_without_end_are_passed_over() {
    let mut inner = doubles([1, 1], "", &[1.0]);
    for _ in 0..200 {
        let names = [element(5, &words(&[8])), element(1, b"a\0\0\0\0\0\0\0")];
        inner = matrix(2, [1, 1], "", &[names.concat(), inner]);
    }
    // The outermost one is a variable and needs a name.
    let names = [element(5, &words(&[8])), element(1, b"a\0\0\0\0\0\0\0")];
    let variable = matrix(2, [1, 1], "deep", &[names.concat(), inner]);
    let bytes = file(&[variable, doubles([1, 1], "x", &[2.0])]);
    let table = table(&bytes);
    assert_eq!(tags(&table), ["x"]);
    assert!(table.issues[0].message.contains("deeper than 24 levels"));
}

#[test]
fn a_broken_header_says_where() {
    let mut order = COMPRESSED.to_vec();
    order[126] = b'X';
    assert!(error(&order).to_string().contains("byte 126"));
    assert!(error(&COMPRESSED[..100]).to_string().contains("byte 100"));
    let mut newer = PLAIN[..600].to_vec();
    newer[125] = 2;
    assert!(error(&newer).to_string().contains("no HDF5 signature"));
}

#[test]
fn a_file_of_texts_says_what_it_holds() {
    let text = matrix(4, [1, 3], "note", &[element(16, b"abc")]);
    let found = error(&file(&[text]));
    assert!(
        matches!(found, IngestError::NothingNumeric { .. }),
        "{found}"
    );
    assert!(
        found.to_string().contains("only text, as in `note`"),
        "{found}"
    );
}

#[test]
fn mat_v4_is_named_with_its_mend() {
    let mut bytes = words(&[0, 2, 1, 0, 2]);
    bytes.extend(b"x\0");
    bytes.extend([0; 16]);
    let found = error(&bytes);
    assert!(matches!(found, IngestError::Unsupported { .. }), "{found}");
    assert!(found.to_string().contains("MAT v4"));
}

/// Columns and units as a writer should carry them over.
pub(crate) fn sample() -> Table {
    let column = |tag: &str, unit: Option<&str>, values: Vec<f64>| Column {
        tag: tag.into(),
        unit: unit.map(String::from),
        values,
    };
    let mut wild = channel(3, 20_000);
    for (at, value) in [
        f64::NAN,
        f64::INFINITY,
        -0.0,
        f64::MIN_POSITIVE / 2.0,
        f64::MAX,
    ]
    .into_iter()
    .enumerate()
    {
        wild[1000 * at] = value;
    }
    Table {
        columns: vec![
            column("gom.FT1", Some("gpm"), channel(1, 20_000)),
            column("gom.PT1", Some("bar µ"), wild),
            column("gom.Ts", None, vec![4.0]),
            column("gom.t", Some("s"), count(20_000)),
        ],
        issues: Vec::new(),
        origin: Some("2015-06-01T00:00:00Z".into()),
        clock: None,
    }
}

/// Bit by bit, for NaN equals nothing.
pub(crate) fn assert_same(found: &Table, expected: &Table) {
    assert_eq!(tags(found), tags(expected));
    for (found, expected) in found.columns.iter().zip(&expected.columns) {
        assert_eq!(found.unit, expected.unit, "{}", found.tag);
        let bits = |c: &Column| c.values.iter().map(|v| v.to_bits()).collect::<Vec<_>>();
        assert_eq!(bits(found), bits(expected), "{}", found.tag);
    }
    assert_eq!(found.origin, expected.origin);
    assert_eq!(found.issues, expected.issues);
}

#[test]
fn what_the_writer_wrote_comes_back_bit_by_bit() {
    let expected = sample();
    let mut bytes = Vec::new();
    dgd_export::write_mat5(&expected, "gom", &mut bytes).unwrap();
    assert_same(&table(&bytes), &expected);
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 10_000, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn no_damage_makes_it_panic(
        which in 0_usize..7,
        header in any::<bool>(),
        acts in damage(),
    ) {
        let whole = [COMPRESSED, PLAIN, CLASSES, ODD, LITTLE, BIG, OBJECTS][which];
        let bytes = apply(whole, &acts, if header { 0 } else { 128 });
        let _ = read(&bytes, &ReadOptions::default());
    }

    #[test]
    fn no_damage_inside_a_compressed_variable_makes_it_panic(
        which in 0_usize..3,
        acts in damage(),
    ) {
        let whole = [PLAIN, ODD, LITTLE][which];
        let damaged = apply(&whole[128..], &acts, 8);
        let bytes = file(&[compress(&damaged), doubles([1, 1], "x", &[1.0])]);
        // What stands behind a sound element is read whatever was inside it.
        let table = table(&bytes);
        prop_assert_eq!(values(&table, "x"), [1.0]);
    }
}
