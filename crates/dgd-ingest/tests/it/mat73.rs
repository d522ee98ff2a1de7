//! MAT v7.3 and HDF5 files; the fixtures are told in `tests/data/mat/README.md`.

use dgd_ingest::{Format, IngestError, ReadOptions, read};
use dgd_recording::{IssueKind, Table};
use proptest::prelude::*;

use crate::mat5::{assert_same, channel, count, issue, sample, tags, values};
use crate::mutate::{apply, damage};

const STRUCT: &[u8] = include_bytes!("../data/mat/struct73.mat");
const ODD: &[u8] = include_bytes!("../data/mat/odd73.mat");
const PLAIN: &[u8] = include_bytes!("../data/mat/plain.h5");
const TREE: &[u8] = include_bytes!("../data/mat/tree.h5");
const LATEST: &[u8] = include_bytes!("../data/mat/latest.h5");
const PAGED: &[u8] = include_bytes!("../data/mat/paged.h5");

fn table(bytes: &[u8]) -> Table {
    let (format, table) = read(bytes, &ReadOptions::default()).unwrap();
    assert_eq!(format, Format::Mat73);
    table
}

fn error(bytes: &[u8]) -> IngestError {
    read(bytes, &ReadOptions::default()).unwrap_err()
}

/// Where `part` stands, if it stands there once.
fn find(bytes: &[u8], part: &[u8]) -> usize {
    let hits: Vec<usize> = (0..bytes.len())
        .filter(|&i| bytes[i..].starts_with(part))
        .collect();
    assert_eq!(hits.len(), 1, "{hits:?}");
    hits[0]
}

#[test]
fn matlabs_struct_reads_with_units_and_start() {
    let table = table(STRUCT);
    assert_eq!(
        tags(&table),
        ["Ts", "gom.FT1", "gom.PT1", "gom.pump.SPM", "gom.t"]
    );
    assert_eq!(values(&table, "gom.t"), count(200));
    assert_eq!(values(&table, "gom.FT1"), channel(1, 200));
    assert_eq!(values(&table, "gom.PT1"), channel(2, 200));
    assert_eq!(values(&table, "gom.pump.SPM"), channel(3, 200));
    assert_eq!(values(&table, "Ts"), [4.0]);
    let units: Vec<_> = table.columns.iter().map(|c| c.unit.as_deref()).collect();
    assert_eq!(units, [None, Some("gpm"), Some("psi"), None, Some("s")]);
    assert_eq!(table.origin.as_deref(), Some("2015-06-01T00:00:00Z"));
    assert_eq!(table.issues, []);
}

#[test]
fn matrices_in_overhanging_chunks_fall_into_columns() {
    let table = table(ODD);
    for (tag, c) in [
        ("tall(:,1)", 1),
        ("tall(:,2)", 2),
        ("wide(1,:)", 1),
        ("wide(2,:)", 2),
        ("wide(3,:)", 3),
    ] {
        assert_eq!(values(&table, tag), channel(c, 6), "{tag}");
    }
    assert_eq!(values(&table, "flag"), [1.0, 0.0, 1.0]);
}

#[test]
fn what_holds_no_channels_is_told() {
    let table = table(ODD);
    for (tag, word) in [
        ("cube", "3 sides"),
        ("none", "empty"),
        ("cplx", "complex"),
        ("thin", "sparse"),
        ("cells", "cell"),
        ("wells.depth", "references"),
        ("good", "second name"),
        ("lzf", "filter 32000"),
        ("the file", "soft links"),
    ] {
        assert!(
            issue(&table, tag).contains(word),
            "{tag}: {:?}",
            table.issues
        );
    }
    assert!(!tags(&table).iter().any(|t| t.contains("#refs#")));
    assert!(table.issues.iter().all(|i| i.kind == IssueKind::Skipped));
}

#[test]
fn every_numeric_type_reads_in_both_byte_orders() {
    let table = table(PLAIN);
    for name in ["i1", "u1", "i2", "u2", "i4", "u4", "i8", "u8", "f4", "f8"] {
        assert_eq!(values(&table, &format!("rig.{name}")), count(10), "{name}");
    }
    for name in ["i2", "u4", "i8", "f4", "f8"] {
        assert_eq!(
            values(&table, &format!("rig.{name}_big")),
            count(10),
            "{name}"
        );
    }
    assert_eq!(values(&table, "rig.flag"), [1.0, 0.0]);
    assert!(issue(&table, "rig.half").contains("odd size"));
}

#[test]
fn a_units_attribute_is_the_unit() {
    let table = table(PLAIN);
    let unit = |tag: &str| table.column(tag).and_then(|c| c.unit.as_deref());
    assert_eq!(unit("rig.f8"), Some("gpm"));
    assert_eq!(unit("rig.f4"), Some("psi"));
    assert_eq!(unit("rig.i4"), None);
}

#[test]
fn filters_are_undone_and_unwritten_chunks_hold_the_fill_value() {
    let table = table(PLAIN);
    assert_eq!(values(&table, "rig.checked"), channel(5, 200));
    let part = values(&table, "rig.part");
    assert_eq!(part.len(), 40);
    assert_eq!(
        (part[0], part[10], part[15], part[39]),
        (-1.0, -1.0, 7.0, -1.0)
    );
}

#[test]
fn trees_of_several_nodes_and_rings_end() {
    let table = table(TREE);
    assert_eq!(tags(&table), ["many"]);
    assert_eq!(values(&table, "many"), channel(4, 150));
    assert!(issue(&table, "many39").contains("second name"));
    assert!(issue(&table, "ring.again").contains("second name"));
}

#[test]
fn the_newest_layouts_read() {
    let table = table(LATEST);
    for c in 1..=12 {
        assert_eq!(values(&table, &format!("gom.CH{c:02}")), channel(c, 20));
    }
    for (tag, c) in [
        ("few.fixed", 1),
        ("few.single", 2),
        ("few.bare", 3),
        ("few.implicit", 5),
    ] {
        assert_eq!(values(&table, tag), channel(c, 200), "{tag}");
    }
    assert!(issue(&table, "few.grows").contains("libver='latest'"));
}

#[test]
fn long_lists_of_chunks_and_names_read() {
    let table = table(PAGED);
    let expected: Vec<f64> = (0..1100).map(|i| f64::from(i % 256)).collect();
    assert_eq!(values(&table, "pages"), expected);
    for k in 0..150 {
        assert!(issue(&table, &format!("crowd.name{k:03}")).contains("second name"));
    }
}

#[test]
fn a_damaged_chunk_becomes_nan_and_the_rest_stays() {
    // The first chunk of `t`: 64 counted doubles behind a zlib header.
    let whole = table(STRUCT);
    let mut lost = 0;
    for at in 512..STRUCT.len() - 2 {
        if STRUCT[at] != 0x78 || STRUCT[at + 1] != 0x5E {
            continue;
        }
        let mut bytes = STRUCT.to_vec();
        bytes[at + 20] ^= 0x10;
        let damaged = table(&bytes);
        assert_eq!(tags(&damaged), tags(&whole));
        assert_eq!(damaged.issues.len(), 1);
        assert_eq!(damaged.issues[0].kind, IssueKind::Damaged);
        let mut nan = 0;
        for (damaged, whole) in damaged.columns.iter().zip(&whole.columns) {
            for (damaged, whole) in damaged.values.iter().zip(&whole.values) {
                nan += usize::from(damaged.is_nan());
                assert!(damaged.is_nan() || damaged == whole);
            }
        }
        let told = format!("its {nan} values are NaN");
        assert!(
            damaged.issues[0].message.contains(&told),
            "{:?}",
            damaged.issues
        );
        assert!(nan == 64 || nan == 8, "{nan}");
        lost += 1;
    }
    assert_eq!(lost, 8, "two columns of four chunks");
}

#[test]
fn impossible_sides_leave_out_that_column_alone() {
    // The sides of `gom.t`, 1 x 200 in chunks of 64, stand behind rank 2 of its dataspace.
    let mut sides = vec![1, 2, 1, 0, 0, 0, 0, 0];
    sides.extend(1_u64.to_le_bytes());
    sides.extend(200_u64.to_le_bytes());
    let places: Vec<usize> = (0..STRUCT.len())
        .filter(|&i| STRUCT[i..].starts_with(&sides))
        .map(|i| i + 16)
        .collect();
    assert_eq!(places.len(), 4);
    for place in places {
        for claim in [1_u64 << 40, u64::MAX, 1 << 62] {
            let mut bytes = STRUCT.to_vec();
            bytes[place..place + 8].copy_from_slice(&claim.to_le_bytes());
            let table = table(&bytes);
            assert_eq!(table.columns.len(), 4);
            assert_eq!(table.issues[0].kind, IssueKind::Damaged);
        }
    }
}

#[test]
fn more_than_the_bytes_can_inflate_to_is_too_large() {
    let mut expected = sample();
    expected.columns.truncate(1);
    let mut bytes = dgd_export::write_mat73(&expected, "gom").unwrap();
    let mut sides = vec![1, 2, 0, 0, 0, 0, 0, 0];
    sides.extend(1_u64.to_le_bytes());
    sides.extend(20_000_u64.to_le_bytes());
    let place = find(&bytes, &sides) + 16;
    bytes[place..place + 8].copy_from_slice(&(1_u64 << 36).to_le_bytes());
    let found = error(&bytes);
    assert!(matches!(found, IngestError::TooLarge { .. }), "{found}");
    assert!(found.to_string().contains("gom.FT1"), "{found}");
}

#[test]
fn a_wrong_metadata_checksum_is_damage() {
    let place = (0..LATEST.len())
        .find(|&i| LATEST[i..].starts_with(b"OHDR"))
        .unwrap();
    let mut bytes = LATEST.to_vec();
    bytes[place + 8] ^= 1;
    let found = error(&bytes).to_string();
    assert!(found.contains("checksum"), "{found}");
    assert!(found.contains(&format!("byte {place}")), "{found}");
}

#[test]
fn a_cut_file_is_told_as_cut() {
    let mut tables = 0;
    for length in (0..STRUCT.len()).step_by(7) {
        match read(&STRUCT[..length], &ReadOptions::default()) {
            Ok((Format::Mat73, cut)) => {
                assert_eq!(cut.issues[0].kind, IssueKind::Truncated, "{length}");
                tables += 1;
            }
            Ok((format, _)) => assert!(length < 520, "{length}: {format}"),
            Err(IngestError::Damaged { place, .. }) => assert!(place.contains("byte"), "{place}"),
            Err(error) => assert!(length < 520, "{length}: {error}"),
        }
    }
    assert!(tables > 100, "{tables}");
}

#[test]
fn a_file_without_signature_says_so() {
    let mut bytes = STRUCT.to_vec();
    bytes[512] = 0;
    assert!(matches!(
        error(&bytes),
        IngestError::Damaged { .. } | IngestError::Unrecognised { .. }
    ));
}

#[test]
fn what_the_writer_wrote_comes_back_bit_by_bit() {
    let expected = sample();
    let bytes = dgd_export::write_mat73(&expected, "gom").unwrap();
    assert_same(&table(&bytes), &expected);
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 10_000, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn no_damage_makes_it_panic(
        which in 0_usize..6,
        header in any::<bool>(),
        acts in damage(),
    ) {
        let whole = [STRUCT, ODD, PLAIN, TREE, LATEST, PAGED][which];
        let bytes = apply(whole, &acts, if header { 0 } else { 520 });
        let _ = read(&bytes, &ReadOptions::default());
    }
}
