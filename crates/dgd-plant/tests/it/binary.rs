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
        (
            vec!["conceal", "--out", "x", "--viscosity", "0"],
            "expected a number from 0.1 to 100",
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

#[test]
fn conceal_writes_cases_apart_from_their_truths_and_seals_them() {
    let out = folder("plant-cases");
    let truth = folder("plant-truths");
    let arguments = [
        "conceal",
        "--out",
        out.to_str().unwrap(),
        "--truth",
        truth.to_str().unwrap(),
        "--seed",
        "4",
        "--count",
        "5",
        "--level",
        "2",
        "--sealed",
    ];
    let done = run(&arguments);
    assert!(done.status.success(), "{done:?}");
    let mut names: Vec<String> = fs::read_dir(&truth)
        .unwrap()
        .map(|f| f.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    assert_eq!(names.len(), 5);
    assert_eq!(names[0], "c000.truth.json");
    let mut all = Vec::new();
    for name in &names {
        let id = &name[..4];
        let mut files: Vec<String> = fs::read_dir(out.join(id))
            .unwrap()
            .map(|f| f.unwrap().file_name().into_string().unwrap())
            .collect();
        files.sort();
        assert!(files.len() == 2 && files[0].starts_with("recording."));
        assert_eq!(files[1], "well.toml");
        all.extend(fs::read(truth.join(name)).unwrap());
    }
    use sha2::{Digest, Sha256};
    let seal: String = Sha256::digest(&all)
        .iter()
        .map(|b| format!("{b:02x}"))
        .collect();
    assert_eq!(String::from_utf8(done.stdout).unwrap().trim(), seal);
    assert_eq!(
        run(&arguments).stdout,
        run(&arguments).stdout,
        "the same arguments give another seal"
    );
}

#[test]
fn conceal_refuses_what_it_does_not_know() {
    for (arguments, part) in [
        (vec!["conceal"], "expected `--out DIR`"),
        (
            vec!["conceal", "--out", "x", "--level", "3"],
            "expected 1 or 2",
        ),
        (
            vec!["conceal", "--out", "x", "--kind", "some"],
            "expected single, pair",
        ),
        (
            vec!["conceal", "--out", "x", "--severity", "huge"],
            "expected trace",
        ),
        (
            vec!["conceal", "--out", "x", "--effect", "gremlins"],
            "expected one of return_flow_delay",
        ),
        (
            vec![
                "conceal", "--out", "x", "--effect", "influx", "--kind", "foreign",
            ],
            "does not go with",
        ),
        (
            vec!["conceal", "--out", "x", "--fast"],
            "not an option of conceal",
        ),
    ] {
        let done = run(&arguments);
        assert_eq!(done.status.code(), Some(2), "{arguments:?}");
        let message = String::from_utf8(done.stderr).unwrap();
        assert!(message.contains(part), "{message}");
    }
}

#[test]
fn bench_writes_recordings_apart_from_their_truths_and_seals_them() {
    let (out, truth) = (folder("plant-benches"), folder("plant-bench-truths"));
    let (out_text, truth_text) = (out.to_str().unwrap(), truth.to_str().unwrap());
    let arguments = [
        "bench", "--out", out_text, "--truth", truth_text, "--seed", "3", "--count", "2",
        "--sealed",
    ];
    let done = run(&arguments);
    assert!(done.status.success(), "{done:?}");
    let mut all = Vec::new();
    for bench in ["surge-shaft", "glycol-loop"] {
        for id in ["c000", "c001"] {
            let case = out.join(bench).join(id);
            let mut files: Vec<String> = fs::read_dir(&case)
                .unwrap()
                .map(|f| f.unwrap().file_name().into_string().unwrap())
                .collect();
            files.sort();
            assert_eq!(files, ["recording.csv", "system.toml"]);
            all.extend(fs::read(truth.join(bench).join(format!("{id}.truth.json"))).unwrap());
        }
    }
    use sha2::{Digest, Sha256};
    let seal: String = Sha256::digest(&all)
        .iter()
        .map(|b| format!("{b:02x}"))
        .collect();
    assert_eq!(String::from_utf8(done.stdout).unwrap().trim(), seal);
    assert_eq!(run(&arguments).stdout, run(&arguments).stdout);
}

#[test]
fn bench_refuses_what_it_does_not_know() {
    for (arguments, part) in [
        (vec!["bench"], "expected `--out DIR`"),
        (
            vec!["bench", "--out", "x", "--bench", "tank"],
            "expected surge-shaft or glycol-loop",
        ),
        (
            vec!["bench", "--out", "x", "--thing", "pump_slip"],
            "needs `--bench`",
        ),
        (
            vec![
                "bench",
                "--out",
                "x",
                "--bench",
                "surge-shaft",
                "--thing",
                "pump_slip",
            ],
            "expected one of crest_overflow",
        ),
        (
            vec![
                "bench",
                "--out",
                "x",
                "--bench",
                "glycol-loop",
                "--thing",
                "pump_slip",
                "--kind",
                "clean",
            ],
            "does not go with",
        ),
        (
            vec!["bench", "--out", "x", "--severity", "huge"],
            "expected subtle, moderate or strong",
        ),
        (
            vec!["bench", "--out", "x", "--kind", "pair"],
            "expected single, clean, foreign or mix",
        ),
        (
            vec!["bench", "--out", "x", "--count", "two"],
            "expected a whole number",
        ),
        (
            vec!["bench", "--out", "x", "--fast"],
            "not an option of bench",
        ),
    ] {
        let done = run(&arguments);
        assert_eq!(done.status.code(), Some(2), "{arguments:?}");
        let message = String::from_utf8(done.stderr).unwrap();
        assert!(message.contains(part), "{message}");
    }
}
