//! The pipeline around the crates: `cargo xtask <command>`.
//!
//! Links none of the science, so it builds when the science does not; what it
//! needs of the product it asks the `dgd` command line for.
#![allow(clippy::print_stdout, reason = "a command line prints")]

mod bench;
mod ci;
mod figures;
mod layers;
mod prove;
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
    /// Measures time and memory of fit and simulation, beside SciPy where Python is present
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
        /// Folder for what is written on the way
        #[arg(long, default_value = "target/bench")]
        out: PathBuf,
    },
    /// Everything a submission must pass: `.ci/run`, which ends with the short proof
    Ci,
    /// Conceals effects in recordings, diagnoses them blind, and scores the answers
    #[command(after_help = PROVE_HELP)]
    Prove(prove::Settings),
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
after the last. Exit status is 1 on a broken rule (a crash, a bad form, a touched truth), whatever the scores.

Examples:
  cargo xtask prove --short
  cargo xtask prove --level 2 --count 200 --seed 4711 --out target/proof-4711
  cargo xtask prove --level 2 --count 200 --seed 4711 --only c017 --keep --out target/proof-again";

fn main() -> anyhow::Result<()> {
    match Arguments::parse().command {
        Command::Bench {
            recording,
            well,
            peer,
            out,
        } => bench::measure(&bench::Bench {
            recording,
            well,
            peer,
            out,
        }),
        Command::Ci => ci::run(),
        Command::Layers => layers::check(),
        Command::Prove(settings) => prove::run(settings),
        Command::Figures { out } => figures::draw(&out),
    }
}
