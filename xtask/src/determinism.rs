//! `cargo xtask determinism`: the same input, the same bytes, in debug and release, on one thread and on two.

use crate::tools;
use anyhow::{Context, Result, bail};
use serde_json::Value;
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// What is run, in order; later lines read what earlier ones wrote.
const LINES: [&str; 21] = [
    "inspect rig/recording.mat --propose proposed.toml --json",
    "convert rig/recording.mat rig.csv",
    "convert rig/recording.mat rig.mcap",
    "convert rig/recording.mat rig.mat",
    "convert rig/recording.mat rig73.mat --mat-v73",
    "fit rig/recording.mat --well rig/well.toml --figures figures --json",
    "fit rig/recording.mat --well rig/well.toml --out robust.toml --robust",
    "simulate rig/recording.mat --well rig/well.toml --out run.csv --figures figures --json",
    "simulate rig/recording.mat --well rig/well.toml --out run.mcap --solver dormand-prince",
    "simulate rig/recording.mat --well rig/well.toml --out run.mat --kind steady",
    "diagnose rig/recording.mat --well rig/well.toml --out diagnosed --json",
    "diagnose concealed/recording.mat --well concealed/well.toml --out explained --json",
    "mask rig/recording.mat --well rig/well.toml --out masked --references references.toml --json",
    "linearise --well rig/well.toml --at inflow.flow=0.05 pump.speed=70 --step 1 --out linear",
    "system check pump_loop.toml --draw system.svg --json",
    "system check return_line.toml --draw system.png",
    "fit pump_loop.csv --system pump_loop.toml --out fitted.toml",
    "simulate pump_loop.csv --system fitted.toml --out loop.csv",
    "diagnose pump_loop.csv --system pump_loop.toml --out revised",
    "catalogue --json",
    "sensitivities two_tanks.csv --system two_tanks.toml --out sensitivities",
];

/// Runs all lines four times and compares every file and every answer.
pub(crate) fn check() -> Result<()> {
    let release = tools::build("dgd-cli", "dgd")?;
    let debug = tools::build_debug("dgd-cli", "dgd")?;
    let mut first: Option<(String, Outputs)> = None;
    let mut differing = 0;
    for (profile, dgd) in [("release", &release), ("debug", &debug)] {
        for threads in ["1", "2"] {
            let name = format!("{profile}, {threads} threads");
            let outputs = outputs(dgd, threads).with_context(|| name.clone())?;
            println!("{name}: {} outputs", outputs.len());
            match &first {
                None => first = Some((name, outputs)),
                Some((other, expected)) => {
                    for difference in differences(expected, &outputs) {
                        println!("  {difference}, against {other}");
                        differing += 1;
                    }
                }
            }
        }
    }
    if differing > 0 {
        bail!("{differing} outputs differ");
    }
    Ok(())
}

/// Every file written and everything said, by name.
type Outputs = BTreeMap<String, Vec<u8>>;

fn outputs(dgd: &Path, threads: &str) -> Result<Outputs> {
    let folder = tempfile::tempdir().context("cannot make a temporary folder")?;
    let here = folder.path();
    for (fixture, to) in [("demo", "rig"), ("demo-concealed", "concealed")] {
        fs::create_dir(here.join(to))?;
        for name in ["recording.mat", "well.toml"] {
            let from = tools::root().join("fixtures").join(fixture).join(name);
            fs::copy(&from, here.join(to).join(name))
                .with_context(|| format!("cannot copy {}", from.display()))?;
        }
    }
    tools::run(
        Command::new(env!("CARGO"))
            .args([
                "run",
                "--quiet",
                "--package",
                "dgd-cli",
                "--example",
                "benches",
                "--",
            ])
            .arg(here)
            .current_dir(tools::root()),
    )?;
    let mut all = Outputs::new();
    for line in LINES {
        let ran = Command::new(dgd)
            .args(line.split_whitespace())
            .current_dir(here)
            .env("RAYON_NUM_THREADS", threads)
            .output()
            .with_context(|| format!("cannot run {}", dgd.display()))?;
        if !ran.status.success() {
            bail!("`dgd {line}`: {}", String::from_utf8_lossy(&ran.stderr));
        }
        all.insert(format!("what `dgd {line}` says"), timeless(ran.stdout));
    }
    collect(here, here, &mut all)?;
    Ok(all)
}

/// An answer in JSON without the seconds it took.
fn timeless(said: Vec<u8>) -> Vec<u8> {
    match serde_json::from_slice::<Value>(&said) {
        Ok(Value::Object(mut fields)) => {
            fields.retain(|name, _| !name.starts_with("seconds"));
            Value::Object(fields).to_string().into_bytes()
        }
        _ => said,
    }
}

fn collect(root: &Path, folder: &Path, into: &mut Outputs) -> Result<()> {
    let mut paths: Vec<PathBuf> = Vec::new();
    for entry in fs::read_dir(folder)? {
        paths.push(entry?.path());
    }
    for path in paths {
        if path.is_dir() {
            collect(root, &path, into)?;
        } else {
            let name = path.strip_prefix(root).unwrap_or(&path);
            into.insert(name.display().to_string(), fs::read(&path)?);
        }
    }
    Ok(())
}

fn differences(expected: &Outputs, found: &Outputs) -> Vec<String> {
    let mut differing = Vec::new();
    for (name, bytes) in expected {
        match found.get(name) {
            None => differing.push(format!("{name} is missing")),
            Some(other) if other != bytes => {
                let at = bytes.iter().zip(other).take_while(|(a, b)| a == b).count();
                differing.push(format!("{name} differs from byte {at} on"));
            }
            Some(_) => {}
        }
    }
    let more = found.keys().filter(|name| !expected.contains_key(*name));
    differing.extend(more.map(|name| format!("{name} is there too")));
    differing
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test may fail by panic")]
mod tests {
    use super::*;

    fn outputs_of(pairs: &[(&str, &str)]) -> Outputs {
        let owned = pairs
            .iter()
            .map(|(n, b)| ((*n).to_owned(), b.as_bytes().to_vec()));
        owned.collect()
    }

    #[test]
    fn every_kind_of_difference_is_named() {
        let expected = outputs_of(&[("same", "x"), ("other", "abc"), ("gone", "")]);
        let found = outputs_of(&[("same", "x"), ("other", "abd"), ("new", "")]);
        assert_eq!(differences(&expected, &expected), [""; 0]);
        assert_eq!(
            differences(&expected, &found),
            [
                "gone is missing",
                "other differs from byte 2 on",
                "new is there too"
            ]
        );
    }

    #[test]
    fn only_the_time_is_taken_from_an_answer() {
        let said = br#"{"seconds": 1.5, "seconds_by_stage": {}, "delay": 9}"#.to_vec();
        assert_eq!(timeless(said), br#"{"delay":9}"#);
        assert_eq!(timeless(b"9 s late".to_vec()), b"9 s late");
    }
}
