//! `cargo xtask bench --growth`: what each command costs on a day, on ten and on a hundred, and what a sample of it costs.

use crate::tools;
use anyhow::{Context, Result, bail};
use serde_json::Value;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Commands whose cost is measured, with the format that each reads.
const MEASURED: [Measured; 14] = [
    Measured::plain("inspect", "csv"),
    Measured::in_blocks("inspect", "csv"),
    Measured::plain("inspect", "mat"),
    Measured::plain("convert", "csv"),
    Measured::in_blocks("convert", "csv"),
    Measured::plain("convert", "mcap"),
    Measured::in_blocks("convert", "mcap"),
    Measured::plain("fit", "csv"),
    Measured::plain("fit", "mat"),
    Measured::plain("simulate", "csv"),
    Measured::in_blocks("simulate", "csv"),
    Measured::plain("simulate", "mat"),
    Measured::plain("mask", "mat"),
    Measured::plain("diagnose", "mat"),
];
/// Up to so many days a command is run three times, and the run of the least processor time counts.
const SHORT_DAYS: f64 = 2.0;
/// Channels of the recordings, the clock among them.
const CHANNELS: f64 = 11.0;

/// A command and what it reads.
#[derive(Clone, Copy)]
struct Measured {
    command: &'static str,
    /// Ending of the recording's name.
    format: &'static str,
    /// Whether a block of it is asked to be in memory at a time; long ones are without asking.
    in_blocks: bool,
}

impl Measured {
    const fn plain(command: &'static str, format: &'static str) -> Self {
        Self {
            command,
            format,
            in_blocks: false,
        }
    }

    const fn in_blocks(command: &'static str, format: &'static str) -> Self {
        Self {
            in_blocks: true,
            ..Self::plain(command, format)
        }
    }
}

/// What to measure.
pub(crate) struct Growth {
    /// Lengths of the recordings.
    pub(crate) days: Vec<f64>,
    /// Commands; all if empty.
    pub(crate) only: Vec<String>,
    pub(crate) out: PathBuf,
}

/// One run under GNU time.
struct Run {
    wall_s: f64,
    cpu_s: f64,
    peak_mb: f64,
    /// Load of the machine as it began.
    load: String,
    printed: Value,
}

/// Makes the recordings, runs the commands, prints a table and writes it to `growth.md`.
pub(crate) fn measure(growth: &Growth) -> Result<()> {
    if let Some(word) = (growth.only.iter()).find(|o| MEASURED.iter().all(|m| m.command != *o)) {
        bail!(
            "`{word}` is not measured, expected inspect, convert, fit, simulate, mask or diagnose"
        );
    }
    let dgd = tools::build("dgd-cli", "dgd")?;
    let plant = tools::build("dgd-plant", "dgd-plant")?;
    std::fs::create_dir_all(&growth.out)
        .with_context(|| format!("cannot make {}", growth.out.display()))?;
    let mut page = String::from(
        "| command | format | days | samples | wall, s | processor, s | load | ns a sample | peak, MB | over the decoded data |\n\
         |---|---|---:|---:|---:|---:|---:|---:|---:|---:|\n",
    );
    print!("\n{page}");
    for &days in &growth.days {
        let recording = Recording::made(&dgd, &plant, &growth.out, days)?;
        for measured in MEASURED {
            let Measured {
                command, format, ..
            } = measured;
            if !(growth.only.is_empty() || growth.only.iter().any(|o| o == command)) {
                continue;
            }
            let run = recording.cost(&dgd, measured)?;
            let option = if measured.in_blocks {
                " --in-blocks"
            } else {
                ""
            };
            let samples = recording.samples as f64;
            let decoded_mb = samples * CHANNELS * 8.0 / 1e6;
            let line = format!(
                "| {command}{option} | {format} | {days} | {} | {:.2} | {:.2} | {} | {:.0} | {:.0} | {:.1} |",
                recording.samples,
                run.wall_s,
                run.cpu_s,
                run.load,
                1e9 * run.cpu_s / samples,
                run.peak_mb,
                run.peak_mb / decoded_mb,
            );
            println!("{line}");
            writeln!(page, "{line}")?;
            if let Some(stages) = run.printed["seconds_by_stage"].as_object() {
                let stages = stages
                    .iter()
                    .filter_map(|(name, s)| Some((name, s.as_f64()?)));
                let told: Vec<String> =
                    stages.map(|(name, s)| format!("{name} {s:.2} s")).collect();
                println!("  {}", told.join(", "));
            }
        }
    }
    tools::replace(&growth.out.join("growth.md"), page)
}

/// A recording of the plant with its well and a model.
struct Recording {
    folder: PathBuf,
    samples: usize,
    days: f64,
}

impl Recording {
    /// Simulates a recording, unless a run before left it: the same arguments give the same bytes.
    fn made(dgd: &Path, plant: &Path, out: &Path, days: f64) -> Result<Self> {
        let folder = out.join(format!("days-{days}"));
        let csv = folder.join("short.csv");
        let [mat, log] = ["mat", "mcap"].map(|format| folder.join(format!("short.{format}")));
        if !log.exists() {
            println!("recording {days} days into {}", folder.display());
            tools::run(
                Command::new(plant)
                    .args(["short", "--hours", &(24.0 * days).to_string(), "--out"])
                    .arg(&folder),
            )?;
            for other in [&mat, &log] {
                let mut convert = Command::new(dgd);
                convert.args(["convert", "--quiet", "--in-blocks"]);
                tools::run(convert.arg(&csv).arg(other))?;
            }
        }
        let (well, model) = (folder.join("well.toml"), folder.join("model.toml"));
        let fitted = tools::run_json(
            Command::new(dgd)
                .args(["fit", "--json", "--quiet"])
                .arg(&mat)
                .arg("--well")
                .arg(well)
                .arg("--out")
                .arg(model),
        )?;
        let samples = fitted["samples"].as_u64().context("fit tells no samples")?;
        Ok(Self {
            folder,
            samples: usize::try_from(samples)?,
            days,
        })
    }

    /// The cost of a command; the cheapest of three on short recordings.
    fn cost(&self, dgd: &Path, measured: Measured) -> Result<Run> {
        let repeats = if self.days <= SHORT_DAYS { 3 } else { 1 };
        let runs = (0..repeats)
            .map(|_| timed(&mut self.command(dgd, measured)))
            .collect::<Result<Vec<_>>>()?;
        let least = (runs.into_iter()).min_by(|a, b| a.cpu_s.total_cmp(&b.cpu_s));
        least.context("nothing was run")
    }

    fn command(&self, dgd: &Path, measured: Measured) -> Command {
        let Measured {
            command,
            format,
            in_blocks,
        } = measured;
        let at = |name: &str| self.folder.join(name);
        let mut run = Command::new(dgd);
        run.args([command, "--json", "--quiet"])
            .arg(at(&format!("short.{format}")));
        if in_blocks {
            run.arg("--in-blocks");
        }
        if !matches!(command, "inspect" | "convert") {
            run.arg("--well").arg(at("well.toml"));
        }
        match command {
            "convert" => run.arg(at(if format == "csv" {
                "other.mcap"
            } else {
                "other.csv"
            })),
            "fit" => run.arg("--out").arg(at("fitted.toml")),
            "simulate" => {
                run.arg("--model").arg(at("model.toml"));
                run.arg("--out").arg(at("run.csv"))
            }
            "mask" => {
                run.arg("--model").arg(at("model.toml"));
                run.arg("--out").arg(at("masked"));
                run.arg("--references").arg(at("references.toml"))
            }
            "diagnose" => run.arg("--out").arg(at("diagnosis")),
            _ => &mut run,
        };
        run
    }
}

/// Runs a command under GNU time.
fn timed(command: &mut Command) -> Result<Run> {
    const TIME: &str = "/usr/bin/time";
    let load = std::fs::read_to_string("/proc/loadavg").unwrap_or_default();
    let load = load.split(' ').next().unwrap_or("-").to_owned();
    let output = Command::new(TIME)
        .args(["-f", "%e %U %S %M"])
        .arg(command.get_program())
        .args(command.get_args())
        .output()
        .with_context(|| format!("cannot run {TIME}: processor time and memory need GNU time"))?;
    let told = String::from_utf8_lossy(&output.stderr);
    if !output.status.success() {
        bail!("{command:?} ended with {}: {told}", output.status);
    }
    let last = told.lines().last().unwrap_or_default();
    let numbers: Vec<f64> = last.split(' ').filter_map(|n| n.parse().ok()).collect();
    let [wall_s, user_s, system_s, peak_kb] = numbers[..] else {
        bail!("{TIME} printed `{last}`, expected four numbers");
    };
    Ok(Run {
        wall_s,
        cpu_s: user_s + system_s,
        peak_mb: peak_kb * 1024.0 / 1e6,
        load,
        printed: serde_json::from_slice(&output.stdout).unwrap_or_default(),
    })
}
