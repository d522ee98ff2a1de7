//! The binary as the pipeline calls it.

use std::fs;
use std::path::PathBuf;
use std::process::{Command, Output};

fn run(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_dgd-plant"))
        .args(arguments)
        .output()
        .unwrap()
}

fn folder(name: &str) -> PathBuf {
    let path = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(name);
    let _ = fs::remove_dir_all(&path);
    path
}

#[test]
fn gom_writes_four_series_that_continue_each_other() {
    let out = folder("plant-gom");
    let done = run(&[
        "gom",
        "--out",
        out.to_str().unwrap(),
        "--seed",
        "2",
        "--hours",
        "0.5",
    ]);
    assert!(done.status.success(), "{done:?}");
    let mut next = 0.0;
    for i in 1..=4 {
        let text = fs::read_to_string(out.join(format!("gom{i}.csv"))).unwrap();
        for line in text.lines().skip(2) {
            let t: f64 = line.split(',').next().unwrap().parse().unwrap();
            assert_eq!(t, next);
            next += 1.0;
        }
    }
    assert_eq!(next, 1800.0);
    assert!(out.join("well.toml").exists());
    assert!(
        fs::read_to_string(out.join("PROVENANCE.md"))
            .unwrap()
            .contains("seed 2")
    );
}

#[test]
fn short_writes_one_series() {
    let out = folder("plant-short");
    assert!(
        run(&["short", "--out", out.to_str().unwrap()])
            .status
            .success()
    );
    assert_eq!(
        fs::read_to_string(out.join("short.csv"))
            .unwrap()
            .lines()
            .count(),
        7202
    );
}

#[test]
fn bad_arguments_exit_with_2_and_say_what_was_expected() {
    for (arguments, part) in [
        (vec!["gom"], "expected `--out DIR`"),
        (vec!["--out", "x"], "expected gom or short"),
        (vec!["gom", "--out"], "`--out` needs a value"),
        (
            vec!["gom", "--out", "x", "--seed", "-1"],
            "expected a whole number",
        ),
        (
            vec!["gom", "--out", "x", "--hours", "nan"],
            "expected a number up to 2400",
        ),
        (vec!["gim"], "`gim` is not understood"),
    ] {
        let done = run(&arguments);
        assert_eq!(done.status.code(), Some(2), "{arguments:?}");
        let message = String::from_utf8(done.stderr).unwrap();
        assert!(message.contains(part), "{message}");
    }
}

#[test]
fn help_goes_to_standard_output() {
    let done = run(&["--help"]);
    assert!(done.status.success());
    assert!(
        String::from_utf8(done.stdout)
            .unwrap()
            .contains("usage: dgd-plant")
    );
}
