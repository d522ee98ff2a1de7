//! Runs that are ended from outside, and runs that meet in one folder.

use crate::bench::{Bench, run_in};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::collections::BTreeMap;
use std::fs::File;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

fn spawn(bench: &Bench, arguments: &str) -> Child {
    Command::new(env!("CARGO_BIN_EXE_dgd"))
        .args(arguments.split_whitespace())
        .current_dir(bench.path(""))
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap()
}

fn signal(child: &Child, name: &str) {
    let id = child.id().to_string();
    Command::new("kill")
        .args(["-s", name, &id])
        .status()
        .unwrap();
}

/// Every file in a folder with its bytes, those under hidden names apart.
fn files(folder: &Path) -> (BTreeMap<String, Vec<u8>>, Vec<String>) {
    let (mut whole, mut hidden) = (BTreeMap::new(), Vec::new());
    for entry in std::fs::read_dir(folder).into_iter().flatten() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        if name.starts_with(".dgd-") {
            hidden.push(name);
        } else if let Ok(bytes) = std::fs::read(&path) {
            whole.insert(name, bytes);
        }
    }
    (whole, hidden)
}

/// Waits until something is so; a test that waits in vain fails.
fn wait_for(what: &str, so: impl Fn() -> bool) {
    let started = Instant::now();
    while !so() {
        assert!(
            started.elapsed() < Duration::from_secs(60),
            "in vain: {what}"
        );
        std::thread::sleep(Duration::from_millis(1));
    }
}

fn with_model() -> Bench {
    let bench = Bench::new();
    bench.dgd("fit rig.mat --well well.toml").done();
    bench
}

fn simulate(window: &str) -> String {
    format!("simulate rig.mat --well well.toml --window {window} --out out/run.csv --figures out")
}

#[test]
fn a_run_killed_at_any_moment_leaves_no_part_of_a_file_under_its_name() {
    let bench = with_model();
    let out = bench.path("out");
    let started = Instant::now();
    bench.dgd(&simulate("0:2000")).done();
    let whole_run = started.elapsed();
    let (before, _) = files(&out);
    bench.dgd(&simulate("1000:4000")).done();
    let (after, _) = files(&out);
    assert!(
        before.len() == 9 && before.keys().eq(after.keys()),
        "{:?}",
        before.keys()
    );
    let mut random = ChaCha8Rng::seed_from_u64(9);
    let mut abandoned = 0;
    for round in 0..10 {
        std::fs::remove_dir_all(&out).unwrap();
        bench.dgd(&simulate("0:2000")).done();
        let mut child = spawn(&bench, &simulate("1000:4000"));
        std::thread::sleep(whole_run.mul_f64(random.random_range(0.05..1.1)));
        if round % 2 == 0 {
            // In the midst of the writing.
            while files(&out).1.is_empty() && child.try_wait().unwrap().is_none() {}
        }
        child.kill().unwrap();
        child.wait().unwrap();
        let (found, hidden) = files(&out);
        abandoned += usize::from(!hidden.is_empty());
        assert!(found.keys().eq(before.keys()), "{:?}", found.keys());
        for (name, bytes) in &found {
            assert!(
                bytes == &before[name] || bytes == &after[name],
                "{name} is neither the old file nor the new one"
            );
        }
        bench.dgd(&simulate("1000:4000")).done();
        let (found, hidden) = files(&out);
        assert_eq!(hidden, [""; 0], "left by the killed run");
        assert!(found == after);
    }
    assert!(abandoned > 0, "no run was met while it wrote");
}

#[test]
fn ctrl_c_ends_with_130_and_says_so() {
    let bench = Bench::new();
    let pipe = bench.path("rig.csv");
    assert!(
        Command::new("mkfifo")
            .arg(&pipe)
            .status()
            .unwrap()
            .success()
    );
    for (name, status, word) in [("INT", 130, "interrupted: "), ("TERM", 143, "terminated: ")] {
        let child = spawn(&bench, "convert rig.csv out.csv");
        // It reads when the pipe opens here; then it waits for more.
        let held = File::options().write(true).open(&pipe).unwrap();
        signal(&child, name);
        let ended = child.wait_with_output().unwrap();
        let said = String::from_utf8(ended.stderr).unwrap();
        assert_eq!(ended.status.code(), Some(status), "{said}");
        assert_eq!(
            said,
            format!("{word}no output was written, no temporary file is left\n")
        );
        drop(held);
    }
    assert_eq!(bench.names(), ["rig.csv", "rig.mat", "well.toml"]);
}

#[test]
fn ctrl_c_while_files_are_written_leaves_all_of_them_or_none() {
    let bench = with_model();
    let out = bench.path("out");
    let mut interrupted = 0;
    for _ in 0..12 {
        let _ = std::fs::remove_dir_all(&out);
        let mut child = spawn(&bench, &simulate("0:2000"));
        while files(&out).1.is_empty() && child.try_wait().unwrap().is_none() {}
        signal(&child, "INT");
        let ended = child.wait_with_output().unwrap();
        let (found, hidden) = files(&out);
        assert_eq!(hidden, [""; 0]);
        match ended.status.code() {
            Some(130) => interrupted += 1,
            Some(0) => assert_eq!(found.len(), 9),
            other => panic!("{other:?}"),
        }
        assert!(found.is_empty() || found.len() == 9, "{:?}", found.keys());
    }
    assert!(interrupted > 0, "no run was met while it wrote");
}

#[test]
fn a_run_waits_with_its_files_until_another_has_put_its_own_in_place() {
    let bench = with_model();
    let out = bench.path("out");
    std::fs::create_dir(&out).unwrap();
    let mut child = spawn(&bench, &simulate("0:2000"));
    wait_for("the first hidden file", || !files(&out).1.is_empty());
    // As another run holds it while it renames.
    let lock = File::open(&out).unwrap();
    lock.lock().unwrap();
    std::thread::sleep(Duration::from_millis(300));
    let found = files(&out).0;
    let ended = child.try_wait().unwrap();
    assert!(
        ended.is_none() && found.is_empty(),
        "{ended:?} {:?}",
        found.keys()
    );
    lock.unlock().unwrap();
    assert!(child.wait().unwrap().success());
    assert_eq!(files(&out).0.len(), 9);
}

#[test]
fn of_two_runs_into_one_folder_the_set_is_of_one() {
    let bench = with_model();
    let set = |window: &str| {
        bench.dgd(&simulate(window)).done();
        files(&bench.path("out")).0
    };
    let sets = [set("0:2000"), set("1000:4000")];
    for _ in 0..6 {
        let runs = ["0:2000", "1000:4000"].map(|w| spawn(&bench, &simulate(w)));
        for run in runs {
            let ended = run.wait_with_output().unwrap();
            assert!(
                ended.status.success(),
                "{}",
                String::from_utf8_lossy(&ended.stderr)
            );
        }
        let (found, hidden) = files(&bench.path("out"));
        assert!(sets.contains(&found), "files of both runs side by side");
        assert_eq!(hidden, [""; 0]);
    }
}

#[test]
fn what_has_no_length_is_no_file_that_changed() {
    let bench = Bench::new();
    let ran = run_in(&bench.path(""), ["convert", "/proc/self/status", "out.csv"]);
    // It is read as it is, and refused for what it holds.
    assert_eq!(ran.status, 2, "{ran:?}");
    assert!(!ran.err.contains("changed"), "{}", ran.err);
}
