//! The command line's grammar.

mod source;
mod values;
mod window;

pub(crate) use source::{AnySource, Described, Source, Subject};
pub(crate) use window::Window;

use clap::{Args, Parser, Subcommand, ValueEnum};
use dgd_diagnose::Step;
use std::path::PathBuf;
use values::{effects, parse_pair, parse_range, steps};

/// Hydraulic models of dual-gradient drilling rigs, identified from recordings
#[derive(Debug, Parser)]
#[command(name = "dgd", version, propagate_version = true, max_term_width = 100)]
#[command(after_help = "Examples:
  Everything on an embedded recording, with figures:
    dgd demo
  A recording of a rig, described in well.toml:
    dgd inspect rig.mat --propose well.toml
    dgd fit rig.mat --well well.toml
    dgd simulate rig.mat --well well.toml --model model.toml
    dgd diagnose rig.mat --well well.toml --out diagnosis
  Your own system, described in system.toml:
    dgd system kinds
    dgd system check system.toml --draw system.svg
    dgd fit bench.csv --system system.toml --out bench.toml

Exit status: 0 done, 2 the input or the arguments cannot be used, 1 an output or its folder cannot be written.")]
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
    #[arg(long, global = true, help_heading = "For every command")]
    pub(crate) json: bool,
    /// Print more on standard error (-vv: even more)
    #[arg(short, long, global = true, help_heading = "For every command", action = clap::ArgAction::Count)]
    pub(crate) verbose: u8,
    /// Print only errors on standard error
    #[arg(
        short,
        long,
        global = true,
        help_heading = "For every command",
        conflicts_with = "verbose"
    )]
    pub(crate) quiet: bool,
}

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Show what is in a file: channels, units, rate, gaps, stuck runs, ranges
    Inspect(Inspect),
    /// Identify friction, meter delay and pump curve from a recording
    Fit(Fit),
    /// Locate where model and recording differ, name the missing physics, show how the fit improves
    Diagnose(Diagnose),
    /// List the effects that a diagnosis of a return line can name, and the steps of its search
    #[command(after_help = "Examples:
  dgd catalogue
  dgd catalogue --json | jq '.effects[] | select(.effect == \"influx\")'")]
    Catalogue,
    /// Run an identified model beside a recording
    Simulate(Simulate),
    /// Check and draw the description of a system
    System(SystemCommand),
    /// Compute A, B, C, D at an operating point, with poles and time constants
    Linearise(Linearise),
    /// Rank parameters by their effect on the readings, and show which of them a recording can separate
    Sensitivities(Sensitivities),
    /// Write a recording and its model as percentages of undisclosed references
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
  dgd inspect rig.mat --propose well.toml
  dgd inspect years.csv --in-blocks

For each column the table gives the smallest, median and largest value, the quantisation step, the number of samples \
that repeat the one before, and the longest run of one value (`537 x 0` is 537 samples of 0).")]
pub(crate) struct Inspect {
    /// MAT v5 or v7.3, CSV or MCAP
    pub(crate) recording: PathBuf,
    /// Write the proposed channel map as the start of a well description
    #[arg(long, value_name = "FILE")]
    pub(crate) propose: Option<PathBuf>,
    /// Read CSV or MCAP in blocks, in constant memory (automatic from 1 GiB)
    #[arg(long)]
    pub(crate) in_blocks: bool,
}

#[derive(Debug, Args)]
#[command(after_help = "Examples:
  dgd fit rig.mat --well well.toml
  dgd fit day1.csv day2.csv day3.csv --well well.toml --figures figures
  dgd fit rig.mcap --well well.toml --delays 0:60 --robust --json
  dgd fit bench.mat --system system.toml --out bench.toml

With --system the model is a system.toml with the fitted values, which --system accepts again. Next to it, under the same name, \
are the simulation of all windows (.csv), the report (.html) and the report data (.json).")]
pub(crate) struct Fit {
    #[command(flatten)]
    pub(crate) source: AnySource,
    /// File to write the model to
    #[arg(long, value_name = "FILE", default_value = "model.toml")]
    pub(crate) out: PathBuf,
    /// Draw Figures 3.2-3.7 and 3.9-3.11 into this folder, as SVG and PNG
    #[arg(long, value_name = "DIR", conflicts_with = "system")]
    pub(crate) figures: Option<PathBuf>,
    /// Range of return flow meter delays to try, s
    #[arg(long, value_name = "FROM:TO", default_value = "0:30", value_parser = parse_range, allow_hyphen_values = true, conflicts_with = "system")]
    pub(crate) delays: (f64, f64),
    /// Down-weight outliers (Huber), in the friction fits or in the readings of a system
    #[arg(long)]
    pub(crate) robust: bool,
    /// Keep the pump exponents at 2 and 2 (Eq. 3.31), with c1, c2 > 0
    #[arg(long, conflicts_with = "system")]
    pub(crate) fixed_exponents: bool,
    /// Additional starting points for a system fit, spread over the bounds
    #[arg(long, value_name = "N", default_value_t = 4, conflicts_with = "well")]
    pub(crate) starts: usize,
    /// Also estimate the values of a system on its linear model
    #[arg(long, conflicts_with = "well")]
    pub(crate) linear: bool,
}

#[derive(Debug, Args)]
#[command(after_help = "Examples:
  dgd diagnose rig.mat --well well.toml --out diagnosis
  dgd diagnose rig.mat --well well.toml --out again --model diagnosis/model.toml
  dgd diagnose a.csv b.csv --well well.toml --out both --json | jq .verdict
  dgd diagnose rig.mat --well well.toml --out noon --window 12h:14h
  dgd diagnose rig.csv --well well.toml --out d --window 2024-10-26T22:00/23:30
  dgd diagnose rig.mat --well well.toml --out gas --suspect gas_in_pump
  dgd diagnose bench.mat --system system.toml --out diagnosis

Writes diagnosis.json, simulation.csv (measured, and the model before and after), report.html and model.toml (with \
the effects found; `dgd simulate` runs it) into the folder. Exit status is 0 for every verdict: consistent, explained, \
partly_explained or unexplained; 2 if the input cannot be used, 1 if the folder or a file in it cannot be written. \
A terminal shows the current stage; -v prints a line as each stage begins.")]
pub(crate) struct Diagnose {
    #[command(flatten)]
    pub(crate) source: AnySource,
    /// Folder for diagnosis.json, simulation.csv, report.html and model.toml
    #[arg(long, value_name = "DIR")]
    pub(crate) out: PathBuf,
    /// Start from the effects in this model, re-fitted; report only what is missing besides them
    #[arg(long, value_name = "FILE", conflicts_with = "system")]
    pub(crate) model: Option<PathBuf>,
    /// Fit only these effects, whatever their evidence, and tell how likely each is (comma-separated; `dgd catalogue` lists them; with --well)
    #[arg(
        long,
        value_name = "EFFECT",
        value_delimiter = ',',
        value_parser = effects(),
        hide_possible_values = true,
        conflicts_with = "system"
    )]
    pub(crate) suspect: Vec<String>,
    /// Omit steps of the search, to see what each contributes
    #[arg(long, value_name = "STEP", value_delimiter = ',', value_parser = steps(), conflicts_with = "system")]
    pub(crate) without: Vec<Step>,
}

#[derive(Debug, Args)]
#[command(after_help = "Examples:
  dgd simulate rig.mat --well well.toml --model model.toml
  dgd simulate rig.mat --well well.toml --window 14000:20000 --kind riser
  dgd simulate rig.mat --well well.toml --out run.mcap --figures figures
  dgd simulate rig.mat --well well.toml --model diagnosis/model.toml
  dgd simulate bench.mat --system bench.toml --out run.csv

A model written by `dgd diagnose` runs with its effects, level and flow together: --kind, --solver and --tolerance are \
for models written by `dgd fit`, and --figures draws only Figure 4.4. With --system a report (.html) and its data \
(.json) are written next to the output, under the same name.")]
pub(crate) struct Simulate {
    #[command(flatten)]
    pub(crate) source: AnySource,
    /// The identified model
    #[arg(
        long,
        value_name = "FILE",
        default_value = "model.toml",
        conflicts_with = "system"
    )]
    pub(crate) model: PathBuf,
    /// Output file, measured and simulated: .csv, .mcap or .mat
    #[arg(long, value_name = "FILE", default_value = "simulation.csv")]
    pub(crate) out: PathBuf,
    /// Which equations are simulated and which are driven by the recording
    #[arg(long, value_enum, default_value_t = KindArg::Coupled, conflicts_with = "system")]
    pub(crate) kind: KindArg,
    /// Riser level at the start, as depth below the rotary table, such as "140 m"; measured if absent
    #[arg(
        long,
        value_name = "LENGTH",
        allow_hyphen_values = true,
        conflicts_with = "system"
    )]
    pub(crate) level: Option<String>,
    /// Flow through the pump at the start, such as "800 gpm"; measured if absent
    #[arg(
        long,
        value_name = "FLOW",
        allow_hyphen_values = true,
        conflicts_with = "system"
    )]
    pub(crate) flow: Option<String>,
    /// Integration method; rodas3, with --system rodas
    #[arg(long, value_enum)]
    pub(crate) solver: Option<SolverArg>,
    /// Relative tolerance of a step; 1e-4, with --system 1e-5
    #[arg(long, value_name = "NUMBER")]
    pub(crate) tolerance: Option<f64>,
    /// Draw Figures 4.1-4.4 of the window into this folder, as SVG and PNG
    #[arg(long, value_name = "DIR", conflicts_with = "system")]
    pub(crate) figures: Option<PathBuf>,
    /// From CSV or MCAP to CSV or MCAP: read, screen, run and write in blocks, in nearly constant memory (automatic from 256 MiB)
    #[arg(long, conflicts_with = "system")]
    pub(crate) in_blocks: bool,
}

/// Which simulation of chapter 4.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum KindArg {
    /// Level and flow together (thesis section 4.3)
    Coupled,
    /// Level alone, driven by the measured flow (section 4.1)
    Riser,
    /// Flow alone, driven by the measured level (section 4.2)
    Flow,
    /// Steady flow at each sample (Eq. 4.2)
    Steady,
}

/// Which integrator.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum SolverArg {
    /// Rosenbrock method of order 3, L-stable: for inputs that change at every sample
    Rodas3,
    /// Rosenbrock method of order 4, L-stable: for long steps and tight tolerances
    Rodas,
    /// Dormand-Prince 5(4), explicit
    DormandPrince,
}

#[derive(Debug, Args)]
#[command(after_help = "Examples:
  dgd mask rig.mat --well well.toml --references private/references.toml

The references file reverses the masking: keep it. It is never written into the output folder.")]
pub(crate) struct Mask {
    #[command(flatten)]
    pub(crate) source: Source,
    /// The identified model to mask as well; fitted from the recording if absent
    #[arg(long, value_name = "FILE")]
    pub(crate) model: Option<PathBuf>,
    /// Folder for the files that may be shared: recording.csv, model.toml, report.html
    #[arg(long, value_name = "DIR", default_value = "masked")]
    pub(crate) out: PathBuf,
    /// File of 100 % values: read if it exists, otherwise chosen and written
    #[arg(long, value_name = "FILE")]
    pub(crate) references: PathBuf,
}

#[derive(Debug, Args)]
#[command(after_help = "Examples:
  dgd convert rig.mat rig.csv
  dgd convert rig.csv rig.mcap
  dgd convert rig.mcap rig.mat --mat-v73

MCAP files hold JSON Schema channels, which plot in Foxglove.")]
pub(crate) struct Convert {
    /// MAT v5 or v7.3, CSV or MCAP
    pub(crate) input: PathBuf,
    /// .csv, .mcap or .mat
    pub(crate) output: PathBuf,
    /// Write MAT v7.3 (HDF5) instead of v5
    #[arg(long)]
    pub(crate) mat_v73: bool,
    /// Name of the struct in MAT files; by default the prefix of the column names up to a dot, or `recording`
    #[arg(long, value_name = "NAME")]
    pub(crate) root: Option<String>,
    /// From CSV or MCAP to CSV or MCAP: read and write in blocks, in constant memory (automatic from 64 MiB)
    #[arg(long)]
    pub(crate) in_blocks: bool,
}

#[derive(Debug, Args)]
#[command(after_help = "Examples:
  dgd demo
  dgd demo --out elsewhere --json")]
pub(crate) struct Demo {
    /// Folder for both reports, their figures and models, and the two recordings (some 40 files)
    #[arg(long, value_name = "DIR", default_value = "dgd-demo")]
    pub(crate) out: PathBuf,
}

#[derive(Debug, Args)]
#[command(after_help = "Examples:
  dgd system kinds tank
  dgd system check system.toml --draw system.svg")]
pub(crate) struct SystemCommand {
    #[command(subcommand)]
    pub(crate) action: SystemAction,
}

#[derive(Debug, Subcommand)]
pub(crate) enum SystemAction {
    /// List what a description may contain: component kinds, their properties, units, ranges and defaults
    Kinds(Kinds),
    /// Check whether it is well posed; list its states, inputs, free parameters and possible effects
    Check(Check),
}

#[derive(Debug, Args)]
#[command(after_help = "Examples:
  dgd system kinds
  dgd system kinds tank
  dgd system kinds --json | jq '.kinds[] | .name'")]
pub(crate) struct Kinds {
    /// Only this kind
    pub(crate) kind: Option<String>,
}

#[derive(Debug, Args)]
#[command(after_help = "Examples:
  dgd system check system.toml
  dgd system check system.toml --draw system.svg
  dgd system check system.toml --json | jq .effects

A system that is not well posed is refused with status 2: each problem with its line, what over-determines it, and the fix. \
It is still drawn.")]
pub(crate) struct Check {
    /// The description of the system
    pub(crate) system: PathBuf,
    /// Draw it: .svg or .png
    #[arg(long, value_name = "FILE")]
    pub(crate) draw: Option<PathBuf>,
}

#[derive(Debug, Args)]
#[command(after_help = "Examples:
  dgd linearise --system bench.toml --at pump.input=5 --step 4 --out lin
  dgd linearise --system bench.toml --at-time 90 --recording run.mat --out lin
  dgd linearise --well well.toml --out lin \\
    --at 'inflow.flow=800 gpm' pump.speed=72

Inputs and states are given by path (`dgd system check` lists them), in SI units or with a unit. States that are not \
given are set to the steady state. Writes linear.json and linear.mat, in MATLAB: l = load('linear.mat').linear; \
ss(l.A, l.B, l.C, l.D). With --well it also writes the model as system.toml.")]
pub(crate) struct Linearise {
    #[command(flatten)]
    pub(crate) described: Described,
    /// The identified model of the well
    #[arg(
        long,
        value_name = "FILE",
        default_value = "model.toml",
        conflicts_with = "system"
    )]
    pub(crate) model: PathBuf,
    /// Inputs and states of the operating point, in SI units or with a unit; every input, unless --at-time takes them from a recording
    #[arg(long, value_name = "KEY=VALUE", num_args = 1.., value_parser = parse_pair)]
    pub(crate) at: Vec<(String, String)>,
    /// Take the operating point from a recording at this time
    #[arg(long, value_name = "TIME", requires = "recording", conflicts_with_all = ["at", "well"], allow_hyphen_values = true)]
    pub(crate) at_time: Option<f64>,
    /// The recording for --at-time
    #[arg(long, value_name = "FILE", requires = "at_time")]
    pub(crate) recording: Option<PathBuf>,
    /// Also compute the discrete model, with inputs held over this step, s
    #[arg(long, value_name = "SECONDS")]
    pub(crate) step: Option<f64>,
    /// Folder for linear.json and linear.mat
    #[arg(long, value_name = "DIR")]
    pub(crate) out: PathBuf,
}

#[derive(Debug, Args)]
#[command(after_help = "Examples:
  dgd sensitivities bench.mat --system bench.toml --out sensitivities
  dgd sensitivities bench.mat --system model.toml --profile all --out told
  dgd sensitivities inputs.csv --system system.toml --out plan

Writes sensitivities.json, sensitivities.csv (along the run) and sensitivities.html into the folder. Instruments need \
not have been recorded: inputs alone are enough to plan an experiment.")]
pub(crate) struct Sensitivities {
    /// MAT v5 or v7.3, CSV or MCAP
    pub(crate) recording: PathBuf,
    /// The description of the system, or the file written by a fit
    #[arg(long, value_name = "FILE")]
    pub(crate) system: PathBuf,
    /// Also compute the profile likelihood of these parameters: each held, all others fitted (`all`: every one)
    #[arg(long, value_name = "PATH", num_args = 1..)]
    pub(crate) profile: Vec<String>,
    /// Folder for sensitivities.json, sensitivities.csv and sensitivities.html
    #[arg(long, value_name = "DIR")]
    pub(crate) out: PathBuf,
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn examples_fit_eighty_columns_so_that_they_can_be_copied() {
        fn walk(command: &clap::Command) {
            let help = command.get_after_help().map(ToString::to_string);
            for line in help.iter().flat_map(|h| h.lines()) {
                let example = line.starts_with("  ");
                assert!(!example || line.chars().count() <= 80, "{line}");
            }
            command.get_subcommands().for_each(walk);
        }
        walk(&Arguments::command());
    }
}
