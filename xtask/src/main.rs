//! The pipeline around the crates: `cargo xtask <command>`.
//!
//! Links none of the science, so it builds when the science does not; what it
//! needs of the product it asks the `dgd` command line for.
#![allow(clippy::print_stdout, reason = "a command line prints")]

mod figures;
mod layers;
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
    /// Reproduces the thesis's figures on the stand-in recording
    Figures {
        /// Folder for figures, data and the comparison
        #[arg(long, default_value = "figures")]
        out: PathBuf,
    },
}

fn main() -> anyhow::Result<()> {
    match Arguments::parse().command {
        Command::Layers => layers::check(),
        Command::Figures { out } => figures::draw(&out),
    }
}
