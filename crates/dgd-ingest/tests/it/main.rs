//! Public behaviour of `dgd-ingest`.
#![allow(
    clippy::unwrap_used,
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "tests may panic"
)]

mod blocks;
mod csv;
mod front_door;
mod hostile;
mod mat5;
mod mat5_bytes;
mod mat73;
mod mcap;
mod mutate;
mod readings;
mod roundtrip;
mod seeds;

#[path = "../../../fuzz/src/recording.rs"]
#[allow(dead_code, unreachable_pub, reason = "the fuzz targets call the rest")]
mod claims;
#[path = "../../../fuzz/stable/mutation.rs"]
mod mutation;

use dgd_ingest::{IngestError, ReadOptions, read};
use dgd_recording::{Issue, IssueKind, Table};

/// Reads bytes without a name.
fn table_of(bytes: &[u8]) -> Result<Table, IngestError> {
    read(bytes, &ReadOptions::default()).map(|(_, table)| table)
}

fn values<'a>(table: &'a Table, tag: &str) -> &'a [f64] {
    let column = table.columns.iter().find(|c| c.tag == tag);
    let tags: Vec<&str> = table.columns.iter().map(|c| c.tag.as_str()).collect();
    &column
        .unwrap_or_else(|| panic!("no `{tag}` among {tags:?}"))
        .values
}

fn unit<'a>(table: &'a Table, tag: &str) -> Option<&'a str> {
    table.column(tag).and_then(|c| c.unit.as_deref())
}

/// The only issue of this kind.
fn issue(table: &Table, kind: IssueKind) -> &Issue {
    let mut found = table.issues.iter().filter(|i| i.kind == kind);
    match (found.next(), found.next()) {
        (Some(issue), None) => issue,
        _ => panic!("not one {kind:?} among {:?}", table.issues),
    }
}

/// Equal to the bit, NaN equal to NaN.
fn assert_same(found: &[f64], expected: &[f64]) {
    assert_eq!(found.len(), expected.len());
    for (index, (f, e)) in found.iter().zip(expected).enumerate() {
        let same = f.to_bits() == e.to_bits() || (f.is_nan() && e.is_nan());
        assert!(same, "sample {index}: {f} is not {e}");
    }
}

/// A small generator, so that every run sees the same cases (Knuth's MMIX constants).
struct Dice(u64);

impl Dice {
    fn next(&mut self) -> u64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        self.0 >> 33
    }

    fn below(&mut self, end: usize) -> usize {
        (self.next() % end.max(1) as u64) as usize
    }
}
