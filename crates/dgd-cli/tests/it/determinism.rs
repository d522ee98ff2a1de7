//! The same input gives the same bytes, on one thread and on several.

use crate::bench::Bench;
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::Path;
use std::process::Command;

const RECORDING: &[u8] = include_bytes!("../../../../fixtures/demo/recording.mat");
const RIG_WELL: &str = include_str!("../../../../fixtures/demo/well.toml");

const LINES: [&str; 8] = [
    "fit rig.mat --well well.toml --figures figures --json",
    "simulate rig.mat --well well.toml --out run.csv --figures figures --json",
    "simulate rig.mat --well well.toml --out run.mcap",
    "diagnose rig.mat --well well.toml --out diagnosed --json",
    "mask rig.mat --well well.toml --out masked --references private/references.toml --json",
    "fit two_tanks.csv --system two_tanks.toml --out tanks.toml --json",
    "diagnose two_tanks.csv --system two_tanks.toml --out tanks --json",
    "sensitivities two_tanks.csv --system two_tanks.toml --out tanks --json",
];

/// Everything below a folder, and what the commands said but for the seconds.
fn outputs(threads: &str) -> BTreeMap<String, Vec<u8>> {
    let bench = crate::systems::benches();
    bench.write("rig.mat", RECORDING);
    bench.write("well.toml", RIG_WELL);
    let mut all = BTreeMap::new();
    for line in LINES {
        let ran = Command::new(env!("CARGO_BIN_EXE_dgd"))
            .args(line.split(' '))
            .current_dir(bench.path(""))
            .env("RAYON_NUM_THREADS", threads)
            .output()
            .unwrap();
        assert!(
            ran.status.success(),
            "{line}: {}",
            String::from_utf8_lossy(&ran.stderr)
        );
        if line.ends_with("--json") {
            let mut said: Value = serde_json::from_slice(&ran.stdout).unwrap();
            let fields = said.as_object_mut().unwrap();
            fields.retain(|name, _| !name.starts_with("seconds"));
            all.insert(line.to_owned(), said.to_string().into_bytes());
        } else {
            all.insert(line.to_owned(), ran.stdout);
        }
    }
    collect(&bench, &bench.path(""), &mut all);
    all
}

fn collect(bench: &Bench, folder: &Path, into: &mut BTreeMap<String, Vec<u8>>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            collect(bench, &path, into);
        } else {
            let name = path
                .strip_prefix(bench.path(""))
                .unwrap()
                .display()
                .to_string();
            into.insert(name, std::fs::read(&path).unwrap());
        }
    }
}

#[test]
fn one_thread_or_several_give_the_same_bytes() {
    let first = outputs("1");
    assert!(first.len() > 45, "{:?}", first.keys());
    for threads in ["2", "5"] {
        let again = outputs(threads);
        assert!(first.keys().eq(again.keys()), "{:?}", again.keys());
        for (name, bytes) in &first {
            assert!(&again[name] == bytes, "{name} differs on {threads} threads");
        }
    }
}
