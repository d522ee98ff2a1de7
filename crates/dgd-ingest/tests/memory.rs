//! How much memory hostile MAT files can make the readers take.
//!
//! Apart from the other tests, for it counts all that its process allocates.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

#[path = "it/mutate.rs"]
mod mutate;
mod peak;

use mutate::{apply, damage};
use peak::peak;
use proptest::strategy::{Strategy, ValueTree};
use proptest::test_runner::TestRunner;

const FIXTURES: [&[u8]; 13] = [
    include_bytes!("data/mat/struct_compressed.mat"),
    include_bytes!("data/mat/struct_plain.mat"),
    include_bytes!("data/mat/classes.mat"),
    include_bytes!("data/mat/odd.mat"),
    include_bytes!("data/mat/shrunk_little.mat"),
    include_bytes!("data/mat/shrunk_big.mat"),
    include_bytes!("data/mat/objects.mat"),
    include_bytes!("data/mat/struct73.mat"),
    include_bytes!("data/mat/odd73.mat"),
    include_bytes!("data/mat/plain.h5"),
    include_bytes!("data/mat/tree.h5"),
    include_bytes!("data/mat/latest.h5"),
    include_bytes!("data/mat/paged.h5"),
];

#[test]
fn memory_is_bounded_by_the_file_whatever_it_claims() {
    // A first read sets up what the process keeps.
    _ = peak(FIXTURES[0]);
    let mut runner = TestRunner::deterministic();
    let damage = damage();
    for round in 0..4000 {
        let whole = FIXTURES[round % FIXTURES.len()];
        let acts = damage.new_tree(&mut runner).unwrap().current();
        let bytes = apply(whole, &acts, 128);
        let most = 512 * 1024 + 64 * bytes.len();
        let (_, found) = peak(&bytes);
        assert!(found < most, "{found} bytes for {}: {acts:?}", bytes.len());
    }

    // A sound file: the columns, three buffers of 256 KiB, and little else.
    let values: Vec<f64> = (0..200_000).map(|i| f64::from(i % 977)).collect();
    let column = |tag: &str| dgd_recording::Column {
        tag: tag.into(),
        unit: None,
        values: values.clone(),
    };
    let columns = ["gom.a", "gom.b", "gom.c", "gom.d"].map(column).to_vec();
    let table = dgd_recording::Table {
        columns,
        ..Default::default()
    };
    let decoded = 4 * 8 * values.len();
    let mut mat5 = Vec::new();
    dgd_export::write_mat5(&table, "gom", &mut mat5).unwrap();
    let mat73 = dgd_export::write_mat73(&table, "gom").unwrap();
    drop(table);
    for bytes in [mat5, mat73] {
        let (_, found) = peak(&bytes);
        let most = decoded + 3 * 256 * 1024 + 128 * 1024;
        assert!(found < most, "{found} bytes for {decoded} decoded");
    }
}
