//! The `dgd` command line: reads arguments, calls the libraries, tells the result.

mod args;
mod commands;
mod failure;
mod figures;
mod interrupt;
mod load;
mod output;
mod page;
mod progress;
mod say;
mod system;

use args::{Arguments, Command, Global, SystemAction};
use clap::Parser;
use failure::Failure;
use std::io::Write;
use std::process::ExitCode;
use tracing_subscriber::filter::LevelFilter;

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    start_tracing(&arguments.global);
    interrupt::watch();
    match run(&arguments) {
        Ok(said) => {
            let mut stdout = std::io::stdout();
            let written = stdout
                .write_all(said.as_bytes())
                .and_then(|()| stdout.flush());
            match written {
                // A closed pipe (`dgd inspect x | head`) is no failure.
                Err(error) if error.kind() != std::io::ErrorKind::BrokenPipe => {
                    let _ = writeln!(std::io::stderr(), "error: standard output: {error}");
                    ExitCode::from(1)
                }
                _ => ExitCode::SUCCESS,
            }
        }
        Err(failure) => {
            let _ = std::io::stderr().write_all(failure.render().as_bytes());
            ExitCode::from(failure.status())
        }
    }
}

/// Runs a command; its result is the text for standard output.
fn run(arguments: &Arguments) -> Result<String, Failure> {
    let global = &arguments.global;
    match &arguments.command {
        Command::Inspect(inspect) => commands::inspect::run(inspect, global),
        Command::Fit(fit) => commands::fit::run(fit, global),
        Command::Diagnose(diagnose) => commands::diagnose::run(diagnose, global),
        Command::Catalogue => commands::catalogue::run(global),
        Command::Simulate(simulate) => commands::simulate::run(simulate, global),
        Command::System(system) => match &system.action {
            SystemAction::Kinds(kinds) => commands::system_kinds::run(kinds, global),
            SystemAction::Check(check) => commands::system_check::run(check, global),
        },
        Command::Linearise(linearise) => commands::linearise::run(linearise, global),
        Command::Sensitivities(asked) => commands::sensitivities::run(asked, global),
        Command::Mask(mask) => commands::mask::run(mask, global),
        Command::Convert(convert) => commands::convert::run(convert, global),
        Command::Demo(demo) => commands::demo::run(demo, global),
    }
}

fn start_tracing(global: &Global) {
    let level = match (global.quiet, global.verbose) {
        (true, _) => LevelFilter::ERROR,
        (false, 0) => LevelFilter::WARN,
        (false, 1) => LevelFilter::INFO,
        (false, 2) => LevelFilter::DEBUG,
        (false, _) => LevelFilter::TRACE,
    };
    tracing_subscriber::fmt()
        .with_max_level(level)
        .with_writer(std::io::stderr)
        .with_ansi(say::in_colour())
        .with_target(false)
        .without_time()
        .init();
}
