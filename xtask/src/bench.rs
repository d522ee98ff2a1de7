//! `cargo xtask bench`: where the time of a fit goes, beside SciPy where Python is present and beside what the machine can do,
//! then what every command costs as recordings grow.

use crate::growth::{self, Growth};
use crate::tools::{self, run_json};
use anyhow::{Context, Result};
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::Command;

/// A run is timed this often; the best counts, as the machine has other things to do.
const REPEATS: usize = 5;
/// Seconds simulated: 6,000 with the pump on throughout in most recordings.
const WINDOW: &str = "10000:16000";

/// What to measure.
pub(crate) struct Bench {
    pub(crate) recording: Option<PathBuf>,
    pub(crate) well: Option<PathBuf>,
    pub(crate) peer: Option<PathBuf>,
    pub(crate) out: PathBuf,
    pub(crate) growth: Growth,
}

/// Measures and prints the tables.
pub(crate) fn measure(bench: &Bench) -> Result<()> {
    let dgd = tools::build("dgd-cli", "dgd")?;
    std::fs::create_dir_all(&bench.out)
        .with_context(|| format!("cannot make {}", bench.out.display()))?;
    let (recording, well) = match (&bench.recording, &bench.well) {
        (Some(recording), Some(well)) => (recording.clone(), well.clone()),
        _ => stand_in(&dgd, &bench.out)?,
    };
    let model = bench.out.join("model.toml");
    let mut fit = Command::new(&dgd);
    fit.arg("fit").arg(&recording).arg("--well").arg(&well);
    fit.args(["--json", "--quiet", "--out"]).arg(&model);
    let mut simulate = Command::new(&dgd);
    simulate
        .arg("simulate")
        .arg(&recording)
        .arg("--well")
        .arg(&well)
        .arg("--model")
        .arg(&model);
    simulate
        .args(["--window", WINDOW, "--json", "--quiet", "--out"])
        .arg(bench.out.join("run.csv"));

    let ours = best_of(REPEATS, &mut fit)?;
    let simulated = best_of(REPEATS, &mut simulate)?;
    let peer = bench
        .peer
        .as_deref()
        .and_then(|script| peer_of(script, &recording));
    stages(&ours, &simulated, peer.as_ref());
    limits(&ours, &simulated);
    growth::measure(&bench.growth)
}

/// The first of the stand-in's four series, some 22 h, as one MAT file.
fn stand_in(dgd: &Path, out: &Path) -> Result<(PathBuf, PathBuf)> {
    let plant = tools::build("dgd-plant", "dgd-plant")?;
    println!(
        "recording the stand-in into {}; its first series is measured",
        out.display()
    );
    tools::run(
        Command::new(plant)
            .args(["gom", "--seed", "5", "--out"])
            .arg(out),
    )?;
    let recording = out.join("gom1.mat");
    tools::run(
        Command::new(dgd)
            .args(["convert", "--quiet", "--root", "gom"])
            .arg(out.join("gom1.csv"))
            .arg(&recording),
    )?;
    Ok((recording, out.join("well.toml")))
}

/// The fastest of some runs, by the seconds it reports.
fn best_of(repeats: usize, command: &mut Command) -> Result<Value> {
    let runs = (0..repeats)
        .map(|_| run_json(command))
        .collect::<Result<Vec<_>>>()?;
    let seconds = |run: &Value| run["seconds"].as_f64().unwrap_or(f64::INFINITY);
    let best = runs
        .into_iter()
        .min_by(|a, b| seconds(a).total_cmp(&seconds(b)));
    best.context("nothing was run")
}

/// Timings of the SciPy script, best of three; `None`, and said so, where it cannot run.
fn peer_of(script: &Path, recording: &Path) -> Option<Value> {
    let run = || run_json(Command::new("python3").arg(script).arg(recording));
    let runs: Result<Vec<Value>> = (0..3).map(|_| run()).collect();
    match runs {
        Ok(runs) => {
            let total = |run: &Value| run["total"].as_f64().unwrap_or(f64::INFINITY);
            runs.into_iter()
                .min_by(|a, b| total(a).total_cmp(&total(b)))
        }
        Err(reason) => {
            println!("no comparison with SciPy: {reason}");
            None
        }
    }
}

fn stages(ours: &Value, simulated: &Value, peer: Option<&Value>) {
    let stage = |run: &Value, names: &[&str]| -> f64 {
        names
            .iter()
            .filter_map(|name| run["seconds_by_stage"][*name].as_f64())
            .sum()
    };
    let theirs =
        |names: &[&str]| peer.map(|p| names.iter().filter_map(|n| p[*n].as_f64()).sum::<f64>());
    println!(
        "\nmilliseconds, best of {REPEATS} (SciPy: best of 3), {} samples",
        ours["samples"]
    );
    println!("| stage | dgd | SciPy | times faster |\n|---|---:|---:|---:|");
    let line = |name: &str, ours: f64, theirs: Option<f64>| {
        let (theirs, ratio) = match theirs {
            Some(t) => (format!("{:.1}", 1e3 * t), format!("{:.0}", t / ours)),
            None => ("-".into(), "-".into()),
        };
        println!("| {name} | {:.1} | {theirs} | {ratio} |", 1e3 * ours);
    };
    let load = ["reading", "decoding"];
    let fit = ["reading", "decoding", "screening", "identifying"];
    line("load", stage(ours, &load), theirs(&["load"]));
    line("screen", stage(ours, &["screening"]), theirs(&["screen"]));
    line(
        "friction sweep and pump search",
        stage(ours, &["identifying"]),
        theirs(&["friction", "pump"]),
    );
    line(
        "fit: all of the above",
        stage(ours, &fit),
        theirs(&["load", "screen", "friction", "pump"]),
    );
    line(
        "simulate 6,000 s (the peer: 6,000 s of its own choice)",
        stage(simulated, &["simulating"]),
        theirs(&["simulate"]),
    );
}

/// Where the time goes beside what the machine can do: bytes decoded against bytes copied, and right-hand sides.
fn limits(fitted: &Value, simulated: &Value) {
    let seconds = |run: &Value, stage: &str| {
        let spent = &run["seconds_by_stage"][stage];
        spent.as_f64().unwrap_or(f64::NAN)
    };
    let samples = fitted["samples"].as_f64().unwrap_or(f64::NAN);
    // Eleven channels of eight bytes, the clock among them.
    let gigabytes = samples * 11.0 * 8.0 / 1e9;
    let copied = copied_gb_s();
    println!("\n| stage | GB/s of decoded data | passes of a copy |\n|---|---:|---:|");
    for stage in ["decoding", "screening", "identifying"] {
        let rate = gigabytes / seconds(fitted, stage);
        println!("| {stage} | {rate:.2} | {:.0} |", copied / rate);
    }
    println!("| copying memory | {copied:.1} | 1 |");
    let evaluations = simulated["statistics"]["rhs"].as_f64().unwrap_or(f64::NAN);
    println!(
        "\nsimulation: {evaluations:.0} right-hand sides, {:.1} ns each with all that is about them",
        1e9 * seconds(simulated, "simulating") / evaluations
    );
}

/// How fast memory is copied, GB/s of what is copied.
fn copied_gb_s() -> f64 {
    const WORDS: usize = 1 << 24;
    let from = vec![1_u64; WORDS];
    let mut to = vec![0_u64; WORDS];
    let once = |_| {
        let begun = std::time::Instant::now();
        to.copy_from_slice(std::hint::black_box(&from));
        std::hint::black_box(&mut to);
        begun.elapsed().as_secs_f64()
    };
    let least = (0..REPEATS).map(once).fold(f64::INFINITY, f64::min);
    (WORDS * 8) as f64 / 1e9 / least
}
