//! The command line's grammar.

use clap::{Args, Parser, Subcommand, ValueEnum};
use std::path::PathBuf;

/// Hydraulic models of drilling rigs, identified from recordings.
#[derive(Debug, Parser)]
#[command(
    name = "dgd",
    version,
    about,
    propagate_version = true,
    max_term_width = 100
)]
#[command(after_help = "Examples:
  dgd demo                                     the whole job on an embedded recording, with pictures
  dgd inspect rig.mat                          what is in a file, and a proposed channel map
  dgd fit rig.mat --well well.toml             identify friction, delay and pump: writes model.toml
  dgd diagnose rig.mat --well well.toml --out diagnosis    what the model leaves out, and the report
  dgd simulate rig.mat --well well.toml --model model.toml --window 14000:20000

Exit status: 0 done, 2 the input cannot be used, 1 an output cannot be written.")]
pub(crate) struct Arguments {
    #[command(flatten)]
    pub(crate) global: Global,
    #[command(subcommand)]
    pub(crate) command: Command,
}

/// For every command.
#[derive(Debug, Args)]
pub(crate) struct Global {
    /// Print the result as JSON instead of text
    #[arg(long, global = true)]
    pub(crate) json: bool,
    /// Say more on standard error (-vv: even more)
    #[arg(short, long, global = true, action = clap::ArgAction::Count)]
    pub(crate) verbose: u8,
    /// Say nothing but errors on standard error
    #[arg(short, long, global = true, conflicts_with = "verbose")]
    pub(crate) quiet: bool,
}

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Tell what is in a file: channels, units, rate, gaps, stuck runs, ranges
    Inspect(Inspect),
    /// Identify friction, meter delay and pump of a recording
    Fit(Fit),
    /// Locate where model and recording differ, name the physics left out, show the fit improve
    Diagnose(Diagnose),
    /// Run an identified model beside a recording
    Simulate(Simulate),
    /// Write a recording and its model in percent of undisclosed references
    Mask(Mask),
    /// Write a recording in another format
    Convert(Convert),
    /// Fit one embedded recording, diagnose another, and draw the reports
    Demo(Demo),
}

#[derive(Debug, Args)]
#[command(after_help = "Examples:
  dgd inspect rig.mcap
  dgd inspect rig.csv --json | jq .columns
  dgd inspect rig.mat --propose well.toml      a well description to fill in")]
pub(crate) struct Inspect {
    /// MAT v5 or v7.3, CSV or MCAP
    pub(crate) recording: PathBuf,
    /// Write the proposed channel map as the start of a well description
    #[arg(long, value_name = "FILE")]
    pub(crate) propose: Option<PathBuf>,
}

/// The recordings and the well they were taken on.
#[derive(Debug, Args)]
pub(crate) struct Source {
    /// Recordings in order of time: MAT v5 or v7.3, CSV or MCAP
    #[arg(required = true)]
    pub(crate) recordings: Vec<PathBuf>,
    /// The well description
    #[arg(long, value_name = "FILE")]
    pub(crate) well: PathBuf,
    /// Screen as the thesis does: every long run of one speed rejected, restarts kept
    #[arg(long)]
    pub(crate) thesis_screening: bool,
}

#[derive(Debug, Args)]
#[command(after_help = "Examples:
  dgd fit rig.mat --well well.toml
  dgd fit gom1.csv gom2.csv gom3.csv gom4.csv --well well.toml --figures figures
  dgd fit rig.mcap --well well.toml --delays 0:60 --robust --json")]
pub(crate) struct Fit {
    #[command(flatten)]
    pub(crate) source: Source,
    /// Where the model goes
    #[arg(long, value_name = "FILE", default_value = "model.toml")]
    pub(crate) out: PathBuf,
    /// Draw Figures 3.2-3.7 and 3.9-3.11 into this folder, as SVG and PNG
    #[arg(long, value_name = "DIR")]
    pub(crate) figures: Option<PathBuf>,
    /// Delays of the return flow meter to try, seconds from:to
    #[arg(long, value_name = "FROM:TO", default_value = "0:30", value_parser = parse_range, allow_hyphen_values = true)]
    pub(crate) delays: (f64, f64),
    /// Weigh outliers down in the friction fits (Huber)
    #[arg(long)]
    pub(crate) robust: bool,
    /// Keep the pump's exponents at 2 and 2 (Eq. 3.31), with c1, c2 > 0
    #[arg(long)]
    pub(crate) fixed_exponents: bool,
}

#[derive(Debug, Args)]
#[command(after_help = "Examples:
  dgd diagnose rig.mat --well well.toml --out diagnosis
  dgd diagnose rig.mat --well well.toml --out again --model diagnosis/model.toml
  dgd diagnose day1.csv day2.csv --well well.toml --out both --json | jq .verdict
  dgd simulate rig.mat --well well.toml --model diagnosis/model.toml --window 9000:12000

Writes diagnosis.json, simulation.csv (measured beside the model before and after), report.html and model.toml
(with the effects found; `dgd simulate` runs it) into the folder. Exit status is 0 whatever the verdict:
consistent, explained, partly_explained or unexplained.")]
pub(crate) struct Diagnose {
    #[command(flatten)]
    pub(crate) source: Source,
    /// Folder for diagnosis.json, simulation.csv, report.html and model.toml
    #[arg(long, value_name = "DIR")]
    pub(crate) out: PathBuf,
    /// Start from the effects of this model; only what is left out of it too is a finding
    #[arg(long, value_name = "FILE")]
    pub(crate) model: Option<PathBuf>,
}

#[derive(Debug, Args)]
#[command(after_help = "Examples:
  dgd simulate rig.mat --well well.toml --model model.toml
  dgd simulate rig.mat --well well.toml --model model.toml --window 14000:20000 --kind riser
  dgd simulate rig.mat --well well.toml --model model.toml --out run.mcap --figures figures
  dgd simulate rig.mat --well well.toml --model diagnosis/model.toml

A model that `dgd diagnose` wrote runs with its effects, level and flow together: --kind, --solver and --tolerance
are for models that `dgd fit` wrote, and --figures draws Figure 4.4 alone.")]
pub(crate) struct Simulate {
    #[command(flatten)]
    pub(crate) source: Source,
    /// The identified model
    #[arg(long, value_name = "FILE", default_value = "model.toml")]
    pub(crate) model: PathBuf,
    /// Measured beside simulated: .csv or .mcap
    #[arg(long, value_name = "FILE", default_value = "simulation.csv")]
    pub(crate) out: PathBuf,
    /// Seconds from:to; the whole recording if absent
    #[arg(long, value_name = "FROM:TO", value_parser = parse_range, allow_hyphen_values = true)]
    pub(crate) window: Option<(f64, f64)>,
    /// Which equations are simulated, and which are driven by the recording
    #[arg(long, value_enum, default_value_t = KindArg::Coupled)]
    pub(crate) kind: KindArg,
    /// Riser level at the start, such as "140 m"; measured if absent
    #[arg(long, value_name = "LENGTH", allow_hyphen_values = true)]
    pub(crate) level: Option<String>,
    /// Flow through the pump at the start, such as "800 gpm"; measured if absent
    #[arg(long, value_name = "FLOW", allow_hyphen_values = true)]
    pub(crate) flow: Option<String>,
    /// Integration method
    #[arg(long, value_enum, default_value_t = SolverArg::Rodas)]
    pub(crate) solver: SolverArg,
    /// Relative tolerance of a step
    #[arg(long, value_name = "NUMBER", default_value_t = 1e-4)]
    pub(crate) tolerance: f64,
    /// Draw Figures 4.1-4.4 of the window into this folder, as SVG and PNG
    #[arg(long, value_name = "DIR")]
    pub(crate) figures: Option<PathBuf>,
}

/// Which simulation of chapter 4.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum KindArg {
    /// Level and flow together (4.3)
    Coupled,
    /// Level alone, driven by the measured flow (4.1)
    Riser,
    /// Flow alone, driven by the measured level (4.2)
    Flow,
    /// Steady flow at each sample (Eq. 4.2)
    Steady,
}

/// Which integrator.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum SolverArg {
    /// Rosenbrock method of order 4, L-stable: for stiff lines
    Rodas,
    /// Dormand-Prince 5(4), explicit
    DormandPrince,
}

#[derive(Debug, Args)]
#[command(after_help = "Examples:
  dgd mask rig.mat --well well.toml --model model.toml --out masked --references private/references.toml

The references file undoes the masking: keep it. It is never written into the output folder.")]
pub(crate) struct Mask {
    #[command(flatten)]
    pub(crate) source: Source,
    /// The identified model to mask along; fitted from the recording if absent
    #[arg(long, value_name = "FILE")]
    pub(crate) model: Option<PathBuf>,
    /// Folder for what may be passed on: recording.csv, model.toml, report.html
    #[arg(long, value_name = "DIR", default_value = "masked")]
    pub(crate) out: PathBuf,
    /// The 100 % values: read if the file exists, else chosen and written there
    #[arg(long, value_name = "FILE")]
    pub(crate) references: PathBuf,
}

#[derive(Debug, Args)]
#[command(after_help = "Examples:
  dgd convert rig.mat rig.csv
  dgd convert rig.csv rig.mcap                 JSON Schema channels that plot in Foxglove
  dgd convert rig.mcap rig.mat --mat-v73")]
pub(crate) struct Convert {
    /// MAT v5 or v7.3, CSV or MCAP
    pub(crate) input: PathBuf,
    /// .csv, .mcap or .mat
    pub(crate) output: PathBuf,
    /// Write MAT v7.3 (HDF5) instead of v5
    #[arg(long)]
    pub(crate) mat_v73: bool,
    /// Name of the struct in MAT files
    #[arg(long, default_value = "recording", value_name = "NAME")]
    pub(crate) root: String,
}

#[derive(Debug, Args)]
#[command(after_help = "Examples:
  dgd demo
  dgd demo --out elsewhere --json")]
pub(crate) struct Demo {
    /// Folder for the report, its pictures and the model
    #[arg(long, value_name = "DIR", default_value = "dgd-demo")]
    pub(crate) out: PathBuf,
}

fn parse_range(text: &str) -> Result<(f64, f64), String> {
    let (from, to) = text
        .split_once(':')
        .ok_or("write two numbers with a colon, such as 14000:20000")?;
    let number = |part: &str| {
        let parsed = part.trim().parse::<f64>().ok().filter(|x| x.is_finite());
        parsed.ok_or(format!("`{part}` is not a number"))
    };
    let (from, to) = (number(from)?, number(to)?);
    if from > to {
        Err(format!("{from} is after {to}"))
    } else {
        Ok((from, to))
    }
}
