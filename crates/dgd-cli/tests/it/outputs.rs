//! Outputs appear whole or not at all, and the same twice.

use crate::bench::{Bench, mat5, recording};
use serde_json::Value;

#[test]
fn a_failed_fit_leaves_the_old_model_and_no_temporary_file() {
    let bench = Bench::new();
    bench.write("model.toml", "kept");
    bench.write("bad.mat", &bench.bytes("rig.mat")[..900]);
    let before = bench.names();
    bench
        .dgd("fit bad.mat --well well.toml")
        .refused(&["bad.mat"]);
    assert_eq!(bench.text("model.toml"), "kept");
    assert_eq!(bench.names(), before);
}

#[test]
fn a_done_fit_replaces_the_old_model_and_leaves_no_temporary_file() {
    let bench = Bench::new();
    bench.write("model.toml", "old");
    let before = bench.names();
    bench.dgd("fit rig.mat --well well.toml").done();
    assert!(bench.text("model.toml").contains("schema"));
    assert_eq!(bench.names(), before);
}

#[test]
fn no_result_replaces_what_it_was_made_from() {
    let bench = Bench::new();
    let (recording, well) = (bench.bytes("rig.mat"), bench.text("well.toml"));
    for arguments in [
        "fit rig.mat --well well.toml --out rig.mat",
        "fit rig.mat --well well.toml --out ./well.toml",
        "convert rig.mat rig.mat",
    ] {
        bench.dgd(arguments).refused(&["input of this run"]);
    }
    assert_eq!(bench.bytes("rig.mat"), recording);
    assert_eq!(bench.text("well.toml"), well);
}

#[cfg(unix)]
#[test]
fn a_closed_file_stays_closed_and_a_link_stays_a_link() {
    use std::os::unix::fs::{PermissionsExt, symlink};
    let bench = Bench::new();
    bench.write("real.toml", "old");
    let closed = std::fs::Permissions::from_mode(0o600);
    std::fs::set_permissions(bench.path("real.toml"), closed).unwrap();
    symlink("real.toml", bench.path("model.toml")).unwrap();
    bench.dgd("fit rig.mat --well well.toml").done();
    assert!(bench.path("model.toml").is_symlink());
    assert!(bench.text("real.toml").contains("schema"));
    let mode = std::fs::metadata(bench.path("real.toml"))
        .unwrap()
        .permissions()
        .mode();
    assert_eq!(mode & 0o777, 0o600);
}

#[test]
fn an_output_that_cannot_be_written_gives_status_1_and_leaves_nothing() {
    let bench = Bench::new();
    // Not by permission: a test may be run by a user who may write everywhere.
    bench.write("file", "not a folder");
    std::fs::create_dir(bench.path("folder.csv")).unwrap();
    let before = bench.names();
    for arguments in [
        "fit rig.mat --well well.toml --out file/model.toml",
        "convert rig.mat file/rig.csv",
        "convert rig.mat folder.csv",
    ] {
        let ran = bench.dgd(arguments);
        assert_eq!(ran.status, 1, "{arguments}: {ran:?}");
        assert!(ran.err.contains("cannot be written"), "{}", ran.err);
        assert!(
            ran.err.contains("file/") || ran.err.contains("folder.csv"),
            "{}",
            ran.err
        );
    }
    assert_eq!(bench.names(), before);
    assert_eq!(bench.text("file"), "not a folder");
}

#[cfg(unix)]
#[test]
fn results_may_be_read_by_others() {
    use std::os::unix::fs::PermissionsExt;
    let bench = Bench::new();
    bench.dgd("convert rig.mat rig.csv").done();
    let mode = std::fs::metadata(bench.path("rig.csv"))
        .unwrap()
        .permissions()
        .mode();
    assert_eq!(mode & 0o777, 0o644);
}

#[test]
fn two_runs_write_the_same_bytes() {
    let bench = Bench::new();
    let run = |n: u8| {
        let said = [
            bench.json(
                &format!("fit rig.mat --well well.toml --out m{n}.toml --figures f{n}"),
                "dgd.fit/1",
            ),
            bench.json(
                &format!("simulate rig.mat --well well.toml --model m{n}.toml --out s{n}.csv"),
                "dgd.simulate/1",
            ),
            bench.json(
                &format!("simulate rig.mat --well well.toml --model m{n}.toml --out s{n}.mcap"),
                "dgd.simulate/1",
            ),
            bench.json(
                &format!("mask rig.mat --well well.toml --out k{n} --references r{n}.toml"),
                "dgd.mask/1",
            ),
        ];
        let mut files = vec![
            format!("m{n}.toml"),
            format!("s{n}.csv"),
            format!("s{n}.mcap"),
            format!("r{n}.toml"),
        ];
        for folder in [format!("f{n}"), format!("k{n}")] {
            let entries = std::fs::read_dir(bench.path(&folder)).unwrap();
            files.extend(
                entries.map(|e| format!("{folder}/{}", e.unwrap().file_name().to_string_lossy())),
            );
        }
        files.sort();
        let bytes: Vec<Vec<u8>> = files.iter().map(|f| bench.bytes(f)).collect();
        (said.map(without_time_and_paths), bytes, files)
    };
    let (first, second) = (run(1), run(2));
    assert!(first.0 == second.0, "standard output differs");
    assert_eq!(first.1.len(), second.1.len());
    assert!(first.1.len() > 20, "{:?}", first.2);
    for ((a, b), name) in first.1.iter().zip(&second.1).zip(&first.2) {
        assert!(a == b, "{name} differs");
    }
}

fn without_time_and_paths(mut value: Value) -> Value {
    let paths = ["out", "figures", "references", "model", "model_file"];
    let fields = value.as_object_mut().unwrap();
    fields.retain(|name, _| !name.starts_with("seconds") && !paths.contains(&name.as_str()));
    value
}

#[test]
fn one_recording_given_twice_is_refused() {
    let bench = Bench::new();
    bench.write("a.mat", mat5(&recording(4000)));
    bench
        .dgd("fit a.mat a.mat --well well.toml")
        .refused(&["contains nothing that", "give each stretch of time once"]);
}

#[test]
fn consecutive_recordings_are_fitted_as_one() {
    let bench = Bench::new();
    let whole = recording(4000);
    let part = |range: std::ops::Range<usize>| {
        let mut part = whole.clone();
        for column in &mut part.columns {
            column.values = column.values[range.clone()].to_vec();
        }
        mat5(&part)
    };
    bench.write("a.mat", part(0..2000));
    bench.write("b.mat", part(2000..4000));
    let fit = bench.json("fit a.mat b.mat --well well.toml", "dgd.fit/1");
    assert_eq!(fit["delay"]["best_s"], crate::bench::DELAY_S);
    let model = bench.text("model.toml");
    assert!(
        model.contains("a.mat") && model.contains("b.mat"),
        "{model}"
    );
    assert!(!model.contains("/a.mat"), "a folder went into the model");
}

#[test]
fn quiet_says_nothing_on_standard_error() {
    let bench = Bench::new();
    let ran = bench.dgd("fit rig.mat --well well.toml --quiet");
    assert_eq!(ran.err, "");
    assert!(ran.done().contains("wrote model.toml"));
}
