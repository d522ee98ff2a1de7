//! The seeds of the fuzz targets and mutations of them: refused with reason and place, or written and read again the same.

use crate::claims;
use crate::mutation::{mutations, seeds};

const TOML: &[&[u8]] = &[
    b"[",
    b"]",
    b"{ ",
    b" }",
    b" = ",
    b"\n",
    b"\"",
    b"\"\"\"",
    b"#",
    b".",
    b"nan",
    b"-inf",
    b"1e308",
    b"1e999",
    b"-1",
    b"0",
    b"0.5",
    b"true",
    b"[]",
    b"{}",
    b"\"19 1/2 in\"",
    b"\"-1 m\"",
    b"\"0 m\"",
    b"\\u00e6",
    b"\xEF\xBB\xBF",
    b"9223372036854775807",
];

/// How many of the mutations were text, and how many of these documents.
#[track_caller]
fn hold(folder: &str, claim: fn(&str) -> bool, count: usize) {
    let (mut texts, mut documents) = (0, 0);
    mutations(&seeds(&[folder]), TOML, count, |bytes| {
        if let Ok(text) = std::str::from_utf8(bytes) {
            texts += 1;
            documents += usize::from(claim(text));
        }
    });
    // Else they test nothing.
    assert!(2 * texts > count, "{texts} texts");
    assert!(
        documents > 100 && documents < texts,
        "{documents} documents of {texts} texts"
    );
}

#[test]
fn mutated_wells_are_refused_or_read_back_the_same() {
    hold("../fuzz/seeds/well", claims::well, 6000);
}

#[test]
fn mutated_models_are_refused_or_read_back_the_same() {
    hold("../fuzz/seeds/model", claims::model, 4000);
}

#[test]
fn mutated_systems_are_refused_or_checked_and_read_back_the_same() {
    hold("../fuzz/seeds/system", claims::system, 4000);
}
