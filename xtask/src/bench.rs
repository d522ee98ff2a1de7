//! `cargo xtask bench`: where the time and the memory of a fit go, beside SciPy where Python is present.

use crate::tools::{self, run_json};
use anyhow::{Context, Result};
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::Command;

/// A run is timed this often; the best counts, as the machine has other things to do.
const REPEATS: usize = 5;
/// Copies of the recording joined for the table of growth: of 85 h, 3.5, 11 and 99 days.
const COPIES: [usize; 3] = [1, 3, 28];
/// Seconds simulated: 6,000 with the pump on throughout in most recordings.
const WINDOW: &str = "10000:16000";

/// What to measure.
pub(crate) struct Bench {
    pub(crate) recording: Option<PathBuf>,
    pub(crate) well: Option<PathBuf>,
    pub(crate) peer: Option<PathBuf>,
    pub(crate) out: PathBuf,
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
    let fit = |copies: usize| {
        let mut command = Command::new(&dgd);
        command
            .arg("fit")
            .args(std::iter::repeat_n(&recording, copies))
            .arg("--well")
            .arg(&well);
        command.args(["--json", "--quiet", "--out"]).arg(&model);
        command
    };
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

    let ours = best_of(REPEATS, &mut fit(1))?;
    let simulated = best_of(REPEATS, &mut simulate)?;
    let peer = bench
        .peer
        .as_deref()
        .and_then(|script| peer_of(script, &recording));
    stages(&ours, &simulated, peer.as_ref());
    growth(&fit)
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

/// Time and memory as the recording grows: both should be linear.
fn growth(fit: &impl Fn(usize) -> Command) -> Result<()> {
    println!(
        "\n| samples | fit, s | ns a sample | peak memory, MB | decoded data, MB | ratio |\n|---:|---:|---:|---:|---:|---:|"
    );
    for copies in COPIES {
        let (run, peak_kb) = with_memory(&fit(copies))?;
        let samples = run["samples"].as_f64().unwrap_or(f64::NAN);
        let seconds = run["seconds"].as_f64().unwrap_or(f64::NAN);
        // Eleven channels of eight bytes, the clock among them.
        let decoded_mb = samples * 11.0 * 8.0 / 1e6;
        let peak = peak_kb.map(|kb| kb * 1024.0 / 1e6);
        println!(
            "| {samples:.0} | {seconds:.3} | {:.0} | {} | {decoded_mb:.0} | {} |",
            1e9 * seconds / samples,
            peak.map_or("-".into(), |p| format!("{p:.0}")),
            peak.map_or("-".into(), |p| format!("{:.2}", p / decoded_mb)),
        );
    }
    Ok(())
}

/// Runs under GNU time where it is installed, for the peak resident size in kB.
fn with_memory(command: &Command) -> Result<(Value, Option<f64>)> {
    let mut timed = Command::new("/usr/bin/time");
    timed
        .args(["-f", "%M"])
        .arg(command.get_program())
        .args(command.get_args());
    match timed.output() {
        Ok(output) if output.status.success() => {
            let value = serde_json::from_slice(&output.stdout).context("dgd printed no JSON")?;
            let text = String::from_utf8_lossy(&output.stderr).into_owned();
            Ok((
                value,
                text.lines()
                    .last()
                    .and_then(|line| line.trim().parse().ok()),
            ))
        }
        _ => {
            let mut plain = Command::new(command.get_program());
            Ok((run_json(plain.args(command.get_args()))?, None))
        }
    }
}
