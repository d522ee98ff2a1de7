//! Nothing in the masked folder tells the rig's size.

use crate::bench::{Bench, DENSITY_KG_M3, DEPTH_M, TAGS, riser_area_m2};

const MASK: &str =
    "mask rig.mat --well well.toml --out masked --references private/references.toml";

fn masked() -> Bench {
    let bench = Bench::new();
    let said = bench.json(MASK, "dgd.mask/1");
    assert_eq!(said["references_read"], false);
    bench
}

/// Every number in a text, signs and exponents read.
fn numbers(text: &str) -> impl Iterator<Item = f64> {
    let bytes = text.as_bytes();
    let mut at = 0;
    std::iter::from_fn(move || {
        while at < bytes.len() {
            let start = at;
            while at < bytes.len() && (bytes[at].is_ascii_digit() || bytes[at] == b'.') {
                at += 1;
            }
            let exponent = at > start
                && at + 1 < bytes.len()
                && matches!(bytes[at], b'e' | b'E')
                && (bytes[at + 1].is_ascii_digit()
                    || (matches!(bytes[at + 1], b'-' | b'+')
                        && bytes.get(at + 2).is_some_and(u8::is_ascii_digit)));
            if exponent {
                at += 2;
                while at < bytes.len() && bytes[at].is_ascii_digit() {
                    at += 1;
                }
            }
            if at == start {
                at += 1;
            } else if let Ok(number) = text[start..at].parse() {
                return Some(number);
            }
        }
        None
    })
}

/// What a page says to its reader: the text between its tags, styles left out.
fn said_by(html: &str) -> String {
    let body = &html[html.find("<body").unwrap_or(0)..];
    body.split('<')
        .filter_map(|part| part.split_once('>'))
        .map(|(_, said)| format!("{said}\n"))
        .collect()
}

fn secrets(bench: &Bench) -> Vec<f64> {
    let references = bench.text("private/references.toml");
    let mut secrets: Vec<f64> = references
        .lines()
        .filter(|l| !l.starts_with('#') && !l.starts_with("schema"))
        .filter_map(|l| l.split_once('=').map(|(_, value)| value.to_owned()))
        .flat_map(|value| numbers(&value).collect::<Vec<_>>())
        // Of the unit m3/s.
        .filter(|v| *v != 3.0)
        .collect();
    assert_eq!(secrets.len(), 4, "{references}");
    let line_area_m2 = std::f64::consts::PI / 4.0 * 0.152_41f64.powi(2);
    let weight_pa_m = DENSITY_KG_M3 * 9.806_65;
    secrets.extend([
        DENSITY_KG_M3,
        DENSITY_KG_M3 / 1000.0,
        DEPTH_M,
        0.495_37,
        0.168_33,
        0.152_41,
    ]);
    secrets.extend([
        riser_area_m2(),
        line_area_m2,
        101_325.0,
        weight_pa_m,
        weight_pa_m * DEPTH_M,
    ]);
    secrets
}

fn found(secrets: &[f64], text: &str) -> Vec<f64> {
    numbers(text)
        .filter(|n| secrets.iter().any(|s| (n - s).abs() <= 1e-4 * s))
        .collect()
}

#[test]
fn no_secret_number_is_in_what_is_passed_on() {
    let bench = masked();
    let secrets = secrets(&bench);
    let html = bench.text("masked/report.html");
    for (name, text) in [
        ("recording.csv", bench.text("masked/recording.csv")),
        ("model.toml", bench.text("masked/model.toml")),
        ("words of the report", said_by(&html)),
    ] {
        assert!(numbers(&text).count() > 10, "{name}");
        assert_eq!(found(&secrets, &text), [0.0; 0], "{name}");
    }
    // Places on the page run from 1 to some hundreds and meet the secrets of that size by chance.
    let out_of_chance: Vec<f64> = secrets
        .iter()
        .copied()
        .filter(|s| !(1.0..2000.0).contains(s))
        .collect();
    assert!(out_of_chance.len() >= 8);
    assert_eq!(found(&out_of_chance, &html), [0.0; 0], "report");
}

#[test]
fn the_search_finds_a_secret_that_is_there() {
    let bench = masked();
    let secrets = secrets(&bench);
    bench.dgd("fit rig.mat --well well.toml").done();
    assert!(found(&secrets, &bench.text("model.toml")).len() > 4);
    assert_eq!(
        numbers("a1.5e3,-2e-2;x=.5<p>7e</p>").collect::<Vec<_>>(),
        [1500.0, 0.02, 0.5, 7.0]
    );
}

#[test]
fn no_tag_and_no_file_name_is_in_what_is_passed_on() {
    let bench = masked();
    for name in ["recording.csv", "model.toml", "report.html"] {
        let text = bench.text(&format!("masked/{name}"));
        for word in TAGS
            .iter()
            .chain(&["rig.mat", "well.toml", "references.toml"])
        {
            assert!(!text.contains(word), "{word} in {name}");
        }
    }
    let mut names: Vec<String> = std::fs::read_dir(bench.path("masked"))
        .unwrap()
        .map(|e| e.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    assert_eq!(names, ["model.toml", "recording.csv", "report.html"]);
}

#[test]
fn the_words_to_the_user_hold_no_reference() {
    let bench = Bench::new();
    let ran = bench.dgd(&format!("{MASK} -vv"));
    let secrets = secrets(&bench);
    assert_eq!(found(&secrets[..4], &ran.err), [0.0; 0]);
    assert_eq!(found(&secrets[..4], &ran.done()), [0.0; 0]);
}

#[cfg(unix)]
#[test]
fn the_references_are_private_to_their_owner() {
    use std::os::unix::fs::PermissionsExt;
    let bench = masked();
    let mode = std::fs::metadata(bench.path("private/references.toml"))
        .unwrap()
        .permissions()
        .mode();
    assert_eq!(mode & 0o777, 0o600);
}

#[test]
fn references_at_hand_are_read_and_left_as_they_are() {
    let bench = masked();
    let (references, first) = (
        bench.text("private/references.toml"),
        bench.text("masked/recording.csv"),
    );
    let said = bench.json(MASK, "dgd.mask/1");
    assert_eq!(said["references_read"], true);
    assert_eq!(bench.text("private/references.toml"), references);
    assert!(bench.text("masked/recording.csv") == first);
}

#[test]
fn references_inside_the_folder_that_is_passed_on_are_refused() {
    let bench = Bench::new();
    std::fs::create_dir_all(bench.path("masked")).unwrap();
    std::fs::create_dir_all(bench.path("elsewhere")).unwrap();
    for place in [
        "masked/references.toml",
        "./masked/deep/references.toml",
        "elsewhere/../masked/references.toml",
    ] {
        let ran = bench.dgd(&format!(
            "mask rig.mat --well well.toml --out masked --references {place}"
        ));
        ran.refused(&["references.toml", "will be shared"]);
    }
    let out = bench
        .dgd("mask rig.mat --well well.toml --out elsewhere/../masked --references masked/r.toml");
    out.refused(&["r.toml", "will be shared"]);
    assert_eq!(std::fs::read_dir(bench.path("masked")).unwrap().count(), 0);
}

#[cfg(unix)]
#[test]
fn references_that_reach_the_folder_through_a_link_are_refused() {
    let bench = Bench::new();
    std::fs::create_dir_all(bench.path("masked")).unwrap();
    std::os::unix::fs::symlink(bench.path("masked"), bench.path("private")).unwrap();
    bench
        .dgd(MASK)
        .refused(&["references.toml", "will be shared"]);
}

#[test]
fn a_broken_references_file_is_refused_without_its_lines() {
    let bench = masked();
    let broken = bench
        .text("private/references.toml")
        .replace(" m", " furlong");
    bench.write("private/references.toml", &broken);
    let ran = bench.dgd(MASK);
    let secrets = secrets(&bench);
    ran.refused(&["references.toml"]);
    assert_eq!(found(&secrets[..4], &ran.err), [0.0; 0], "{}", ran.err);
}
