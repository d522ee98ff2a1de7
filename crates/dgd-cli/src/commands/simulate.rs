//! `dgd simulate`: an identified model beside a recording.

mod blocks;
mod outcome;

use crate::args::{Global, KindArg, Simulate, SolverArg, Source, Subject, Window};
use crate::commands::carried::carry_over;
use crate::commands::convert::Target;
use crate::commands::fit::screening;
use crate::commands::{free_run, system_simulate};
use crate::failure::Failure;
use crate::output::{self, Outputs};
use crate::progress::Progress;
use crate::say;
use crate::{figures, load};
use dgd_documents::{Base, ModelDocument};
use dgd_dynamics::integrate::{Method, Status};
use dgd_dynamics::return_line::SimulationOptions;
use dgd_identify::{Model, prepare};
use dgd_recording::{Column, Geometry, Recording, Table};
use dgd_replay::{Kind, Replay, ReplayOptions, Start, replay};
use dgd_units::{FlowRate, Length, UnitError};
use outcome::{Outcome, signals};
use serde_json::json;
use std::path::{Path, PathBuf};

/// Bytes from which a recording is read, run and written block by block: it is gone through six to ten times and so
/// takes longer, but what is whole takes some five times its size in memory.
const LONG: u64 = 256 << 20;

pub(crate) fn run(arguments: &Simulate, global: &Global) -> Result<String, Failure> {
    let source = match arguments.source.subject() {
        Subject::Well(source) => source,
        Subject::System(system, recordings) => {
            return system_simulate::run(arguments, system, recordings, global);
        }
    };
    let progress = Progress::new(global);
    let target = Target::of(&arguments.out, false)?;
    let options_given = options(arguments)?;
    let well = load::read_well(&source.well)?;
    let document = load::read_model(&arguments.model)?;
    if document.augmented.is_some() {
        free_run::check(arguments)?;
    }
    let (density_kg_m3, geometry) = document.well();
    check_start(&options_given.start, geometry)?;
    if density_kg_m3 != well.mud_density_kg_m3 || *geometry != well.geometry {
        tracing::warn!(
            "{} was identified on a well with different mud or geometry from {}; those of the model are used",
            arguments.model.display(),
            source.well.display()
        );
    }
    let options = ReplayOptions {
        delay_s: document.model().map_or(0.0, |model| model.delay_s),
        ..options_given
    };
    let job = Job {
        arguments,
        source: &source,
        target,
        well: &well,
        document: &document,
        options,
    };
    let done = match blocks::run(&job, &progress)? {
        Some(done) => done,
        None => whole(&job, &progress)?,
    };
    let Done {
        outcome,
        drawn,
        warnings,
        effects,
    } = done;
    let (seconds, stages) = (progress.seconds(), progress.seconds_by_stage());
    drop(progress);
    if global.json {
        let mut value = outcome::as_json(&outcome, arguments, &drawn, seconds);
        if let Some(effects) = effects {
            value["effects"] = json!(effects);
        }
        value["warnings"] = json!(warnings);
        value["seconds_by_stage"] = stages;
        return Ok(say::json(&value));
    }
    Ok(
        say::again(&warnings)
            + &outcome::tell(&outcome, arguments, effects.as_deref(), drawn.len()),
    )
}

/// What is to be simulated.
struct Job<'a> {
    arguments: &'a Simulate,
    source: &'a Source,
    target: Target,
    well: &'a load::Described,
    document: &'a ModelDocument,
    options: ReplayOptions,
}

/// What was done.
struct Done {
    outcome: Outcome,
    drawn: Vec<PathBuf>,
    /// What is suspected of the well description, and of the model on this recording.
    warnings: Vec<String>,
    /// Ids of the effects that acted, of a model that has such.
    effects: Option<Vec<String>>,
}

impl Job<'_> {
    /// Refuses outputs early.
    fn check_outputs(&self) -> Result<(), Failure> {
        output::check(&self.arguments.out)?;
        self.arguments
            .figures
            .as_deref()
            .map_or(Ok(()), figures::check)
    }
}

fn whole(job: &Job<'_>, progress: &Progress) -> Result<Done, Failure> {
    let Job {
        arguments,
        source,
        well,
        document,
        options,
        ..
    } = job;
    let loaded = load::read_recordings(&source.recordings, well, progress)?;
    job.check_outputs()?;
    let first = &source.recordings[0];
    let options = &ReplayOptions {
        window_s: loaded.window_s(source)?,
        ..options.clone()
    };
    loaded.warn_of_suspicions();
    progress.stage("screening", "");
    let prepared = prepare(loaded.recording, loaded.step_s, &screening(source))
        .map_err(|e| Failure::input(first, e))?;
    let mut warnings = loaded.told;
    warnings.extend(loaded.suspicions);
    say::warn(&mut warnings, prepared.not_used());
    let mut document = (*document).clone();
    let (path, recordings) = (&arguments.model, &source.recordings);
    say::warn(
        &mut warnings,
        carry_over(&mut document, path, recordings, (well, &prepared)),
    );
    let (run, recording) = match (&document.augmented, &document.base) {
        (Some(model), _) => {
            progress.stage("simulating", "");
            let run = free_run::run(&document, model, well, &prepared, options, first)?;
            (run, None)
        }
        (None, Base::Identified(model)) => {
            let recording = prepared.averaged();
            progress.stage("simulating", "");
            let run = replay(&model.return_line(), &recording, options)
                .map_err(|e| Failure::input(first, e))?;
            (run, Some((recording, model)))
        }
        (None, Base::WellOnly { .. }) => {
            return Err(Failure::input(&arguments.model, "contains no model"));
        }
    };
    warn_of_end(run.status);
    progress.stage("writing", &arguments.out.display().to_string());
    let table = as_table(&run);
    let mut outputs = Outputs::new();
    outputs.add(&arguments.out, |writer| {
        job.target.write(&table, "simulation", writer)
    })?;
    let mut drawn = Vec::new();
    if let Some(folder) = &arguments.figures {
        progress.stage("drawing", "figures");
        drawn = match &recording {
            Some((recording, model)) => {
                let runs = all_kinds(model, recording, options, first)?;
                figures::draw_simulations(&mut outputs, folder, &runs)?
            }
            None => figures::draw_free_run(&mut outputs, folder, &run)?,
        };
    }
    outputs.keep()?;
    let effects = document.augmented.map(|model| {
        let ids = model.effects.into_iter().map(|e| e.id);
        ids.collect::<Vec<String>>()
    });
    Ok(Done {
        outcome: Outcome::of(&run),
        drawn,
        warnings,
        effects,
    })
}

fn warn_of_end(status: Option<Status>) {
    if let Some(status) = status.filter(|s| *s != Status::Finished) {
        tracing::warn!("the integration stopped early: {}", outcome::why(status));
    }
}

/// A level in the riser, and no flow against the valve.
fn check_start(start: &Start, geometry: &Geometry) -> Result<(), Failure> {
    let deepest = geometry.pump_inlet_depth_m;
    let reason = match (start.level_m, start.flow_m3_s) {
        (Some(level), _) if !(0.0..=deepest).contains(&level) => {
            format!("--level is {level} m, expected between 0 m and the pump inlet at {deepest} m")
        }
        (_, Some(flow)) if !(0.0..=1.0).contains(&flow) => {
            let flow = say::brief(flow);
            format!("--flow is {flow} m3/s, expected between 0 and 1 m3/s")
        }
        _ => return Ok(()),
    };
    Err(Failure::Arguments { reason })
}

/// A relative tolerance that can be one.
pub(crate) fn tolerance(relative: f64) -> Result<f64, Failure> {
    if relative > 0.0 && relative < 1.0 {
        return Ok(relative);
    }
    let reason = format!("--tolerance is {relative}, expected between 0 and 1");
    Err(Failure::Arguments { reason })
}

pub(crate) fn method(solver: SolverArg) -> Method {
    match solver {
        SolverArg::Rodas3 => Method::Rodas3,
        SolverArg::Rodas => Method::Rodasp,
        SolverArg::DormandPrince => Method::DormandPrince,
    }
}

fn options(arguments: &Simulate) -> Result<ReplayOptions, Failure> {
    let default = SimulationOptions::default();
    let relative = tolerance(arguments.tolerance.unwrap_or(default.relative))?;
    let wrong = |name: &str| {
        let name = name.to_owned();
        move |e: UnitError| Failure::Arguments {
            reason: format!("--{name}: {e}"),
        }
    };
    let level = arguments
        .level
        .as_deref()
        .map(Length::parse)
        .transpose()
        .map_err(wrong("level"))?;
    let flow = arguments
        .flow
        .as_deref()
        .map(FlowRate::parse)
        .transpose()
        .map_err(wrong("flow"))?;
    let kind = match arguments.kind {
        KindArg::Coupled => Kind::Coupled,
        KindArg::Riser => Kind::Riser,
        KindArg::Flow => Kind::Flow,
        KindArg::Steady => Kind::Steady,
    };
    Ok(ReplayOptions {
        kind,
        window_s: match &arguments.source.window {
            Some(Window::Clock(from, to)) => Some((*from, *to)),
            // Known with the recording.
            Some(Window::Dates(..)) | None => None,
        },
        start: Start {
            level_m: level.map(Length::si),
            flow_m3_s: flow.map(FlowRate::si),
        },
        delay_s: 0.0,
        solver: SimulationOptions {
            method: arguments.solver.map_or(default.method, method),
            relative,
            ..default
        },
    })
}

/// The four simulations of chapter 4 on the same window: riser, flow, steady, coupled.
pub(crate) fn all_kinds(
    model: &Model,
    recording: &Recording,
    options: &ReplayOptions,
    path: &Path,
) -> Result<[Replay; 4], Failure> {
    let one = |kind| {
        let options = ReplayOptions {
            kind,
            ..options.clone()
        };
        replay(&model.return_line(), recording, &options).map_err(|e| Failure::input(path, e))
    };
    Ok([
        one(Kind::Riser)?,
        one(Kind::Flow)?,
        one(Kind::Steady)?,
        one(Kind::Coupled)?,
    ])
}

pub(crate) fn as_table(run: &Replay) -> Table {
    let column = |tag: String, unit: &str, values: &[f64]| Column {
        tag,
        unit: Some(unit.to_owned()),
        values: values.to_vec(),
    };
    let mut columns = vec![column("t_s".into(), "s", &run.time_s)];
    for (name, unit, pair) in signals(run) {
        columns.push(column(format!("{name}_measured"), unit, &pair.measured));
        if !pair.simulated.is_empty() {
            columns.push(column(format!("{name}_simulated"), unit, &pair.simulated));
        }
    }
    columns.push(column("inflow_m3_s".into(), "m3/s", &run.inflow_m3_s));
    columns.push(column("pump_speed_pct".into(), "%", &run.speed_pct));
    Table {
        columns,
        ..Table::default()
    }
}
