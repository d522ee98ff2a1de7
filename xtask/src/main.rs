//! The pipeline around the crates: `cargo xtask <command>`.
//!
//! Links none of the science, so it builds when the science does not; what it
//! needs of the product it asks the `dgd` command line for.
#![allow(clippy::print_stdout, reason = "a command line prints")]

mod bench;
mod benches;
mod calibrate;
mod ci;
mod determinism;
mod figures;
mod growth;
mod layers;
mod prove;
mod real;
mod tools;

use clap::{Parser, Subcommand};
use std::path::PathBuf;

#[derive(Parser)]
#[command(name = "cargo xtask", about = "The pipeline around the crates")]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Fails on a dependency that points up or sideways
    Layers,
    /// Measures time and memory: fit and simulation beside SciPy where Python is present, then every command on longer and longer
    /// recordings
    Bench {
        /// A long recording; the first series of the stand-in if absent
        #[arg(long, requires = "well")]
        recording: Option<PathBuf>,
        /// Its well description
        #[arg(long, requires = "recording")]
        well: Option<PathBuf>,
        /// A Python script that does the same with SciPy and prints its timings as one JSON line
        #[arg(long)]
        peer: Option<PathBuf>,
        /// Lengths of the recordings for the table of growth
        #[arg(
            long,
            value_name = "DAYS",
            value_delimiter = ',',
            default_value = "1,10,100"
        )]
        days: Vec<f64>,
        /// Commands in that table: inspect, convert, fit, simulate, mask, diagnose; all if absent
        #[arg(long, value_name = "COMMAND", value_delimiter = ',')]
        only: Vec<String>,
        /// Folder for what is written on the way
        #[arg(long, default_value = "target/bench")]
        out: PathBuf,
    },
    /// Derives hurdles and probabilities from ensembles that prove nothing, beside the constants now
    #[command(after_help = CALIBRATE_HELP)]
    Calibrate(calibrate::Settings),
    /// Everything a submission must pass: `.ci/run`, which ends with the short proof
    Ci,
    /// Runs every command in debug and release, on one thread and on two, and compares the bytes
    Determinism,
    /// Conceals effects in recordings, diagnoses them blind, and scores the answers
    #[command(after_help = PROVE_HELP)]
    Prove {
        #[command(flatten)]
        settings: prove::Settings,
        /// Diagnose the real recordings below this folder instead (fixtures/real/README.md says where they come from)
        #[arg(long, value_name = "DIR", conflicts_with_all = ["short", "ablate", "only", "floors"])]
        real: Option<PathBuf>,
        /// Diagnose the plant's two benches instead, 40 recordings each unless told otherwise
        #[arg(long, conflicts_with_all = ["real", "short", "level", "ablate", "blind", "floors"])]
        benches: bool,
    },
    /// Reproduces the thesis's figures on the stand-in recording
    Figures {
        /// Folder for figures, data and the comparison
        #[arg(long, default_value = "figures")]
        out: PathBuf,
    },
}

const PROVE_HELP: &str = "\
Writes proof.html (the page), proof.json (every score and case) and failures.md (every case that was not answered rightly, with \
the command that repeats it) into the folder. The SHA-256 of what is concealed is printed before the first diagnosis and checked \
after the last. Exit status is 1 on a broken rule (a crash, a bad form, a touched truth), and on a score below a floor: a count \
given by --floor, of recordings without an answer (silent), clean recordings with a finding (alarms), recordings confidently wrong \
(sure), or strong and moderate single effects named exactly (named, at least). --short has its own floors, \
chosen on its own recordings: with the default seed, both levels and no --only; elsewhere none but those given are in force.

Examples:
  cargo xtask prove --short
  cargo xtask prove --short --floor named=6
  cargo xtask prove --level 2 --count 200 --seed 4711 --out target/proof-4711
  cargo xtask prove --level 2 --count 200 --seed 4711 --only c017 --keep --out target/proof-again
  cargo xtask prove --level 2 --count 200 --seed 4711 --ablate --steps edges,form --out target/ablation
  cargo xtask prove --real ~/recordings --out target/proof
  cargo xtask prove --benches --count 10 --seed 5005 --out target/benches";

const CALIBRATE_HELP: &str = "\
Hurdles: the evidence that clean recordings exceed at the rate given, each effect its even part of it, by an exponential tail above \
the 80 % quantile. Probabilities: the logistic regression behind dgd-diagnose's belief.rs, checked seed by seed on the others. \
Prints both beside the constants now, writes calibration.html and calibration.json, and edits no source. Every seed is one ensemble: \
give several.

Examples:
  cargo xtask calibrate --seeds 11,12,13
  cargo xtask calibrate --seeds 11,12,13 --level 2 --count 200 --clean 100 --jobs 2 --out target/calibration-2";

fn main() -> anyhow::Result<()> {
    match Arguments::parse().command {
        Command::Bench {
            recording,
            well,
            peer,
            days,
            only,
            out,
        } => bench::measure(&bench::Bench {
            recording,
            well,
            peer,
            growth: growth::Growth {
                days,
                only,
                out: out.clone(),
            },
            out,
        }),
        Command::Calibrate(settings) => calibrate::run(settings),
        Command::Ci => ci::run(),
        Command::Determinism => determinism::check(),
        Command::Layers => layers::check(),
        Command::Prove {
            settings,
            real: Some(from),
            ..
        } => real::run(&from, settings.out()),
        Command::Prove {
            settings,
            benches: true,
            ..
        } => benches::run(settings.for_benches()),
        Command::Prove { settings, .. } => prove::run(settings),
        Command::Figures { out } => figures::draw(&out),
    }
}
