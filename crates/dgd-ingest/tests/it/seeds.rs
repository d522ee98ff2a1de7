//! The seeds of the fuzz targets and mutations of them, read to the product's structure.

use crate::claims::{in_blocks, structure, table};
use crate::mutation::{mutations, seeds};
use dgd_ingest::Format;

const MAT: &[&[u8]] = &[
    b"IM",
    b"MI",
    &[14, 0, 0, 0],
    &[15, 0, 0, 0],
    &[9, 0, 0, 0, 8, 0, 0, 0],
    &[6, 0, 0, 0, 8, 0, 0, 0],
    &[2, 0, 0, 0, 0, 0, 0, 0],
];
const HDF5: &[&[u8]] = &[
    b"OHDR", b"TREE", b"SNOD", b"FRHP", b"FADB", &[0xFF; 8], &[0; 8],
];
const CSV: &[&[u8]] = &[
    b",",
    b";",
    b"\t",
    b"\"",
    b"\r\n",
    b"\n",
    b"NaN",
    b"-999.25",
    b"59:59.9",
    b"2024-02-29",
    b"1e308",
    b"1729600000",
    b"[gpm]",
    b"\xEF\xBB\xBF",
];
const MCAP: &[&[u8]] = &[
    b"lz4",
    b"zstd",
    b"json",
    b"null",
    b"1e999",
    b"[[",
    b"\\u00e6",
    &[6, 0, 1],
    &[5, 23, 0],
];

/// Some mutations must be read and some refused: else they test nothing.
#[track_caller]
fn hold(format: Format, folders: &[&str], tokens: &[&[u8]]) {
    let (mut told, mut tables, mut block_wise) = (0, 0, 0);
    mutations(&seeds(folders), tokens, 6000, |bytes| {
        if let Some(result) = table(bytes, format) {
            told += 1;
            block_wise += usize::from(in_blocks(bytes, &result).is_some());
            if let Ok(table) = result {
                tables += 1;
                structure(table);
            }
        }
    });
    assert!(told > 1500, "{told} are {format}");
    assert!(
        tables > 500 && tables < told,
        "{tables} tables of {told} files"
    );
    let may = matches!(format, Format::Csv | Format::Mcap);
    assert!(block_wise > 200 || !may, "{block_wise} of {told} files");
}

#[test]
fn mutated_mat_v5_is_refused_or_read() {
    hold(Format::Mat5, &["../fuzz/seeds/mat5", "tests/data/mat"], MAT);
}

#[test]
fn mutated_mat_v73_is_refused_or_read() {
    hold(
        Format::Mat73,
        &["../fuzz/seeds/mat73", "tests/data/mat"],
        HDF5,
    );
}

#[test]
fn mutated_csv_is_refused_or_read() {
    hold(Format::Csv, &["../fuzz/seeds/csv"], CSV);
}

#[test]
fn mutated_mcap_is_refused_or_read() {
    hold(
        Format::Mcap,
        &["../fuzz/seeds/mcap", "tests/data/mcap"],
        MCAP,
    );
}
