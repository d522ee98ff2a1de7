//! `dgd simulate`: an identified model beside a recording.

use crate::args::{Global, KindArg, Simulate, SolverArg, Subject};
use crate::commands::convert::Target;
use crate::commands::fit::screening;
use crate::commands::{free_run, system_simulate};
use crate::failure::Failure;
use crate::output::{self, Outputs};
use crate::progress::Progress;
use crate::say::{self, TextTable, count, number};
use crate::{figures, load};
use dgd_documents::Base;
use dgd_dynamics::integrate::{Method, Status};
use dgd_dynamics::return_line::SimulationOptions;
use dgd_identify::{Model, prepare};
use dgd_recording::{Column, Geometry, Recording, Table};
use dgd_replay::{Deviation, Kind, Pair, Replay, ReplayOptions, Start, replay};
use dgd_units::{FlowRate, Length, UnitError};
use serde_json::{Value, json};
use std::fmt::Write as _;
use std::path::Path;

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
            "{} was identified on a well of another mud or geometry than {}; the model's are used",
            arguments.model.display(),
            source.well.display()
        );
    }
    let loaded = load::read_recordings(&source.recordings, &well, &progress)?;
    output::check(&arguments.out)?;
    if let Some(folder) = &arguments.figures {
        figures::check(folder)?;
    }
    let first = &source.recordings[0];
    loaded.warn_of_suspicions();
    progress.stage("screening", "");
    let prepared = prepare(loaded.recording, loaded.step_s, &screening(&source))
        .map_err(|e| Failure::input(first, e))?;
    let warnings = loaded.suspicions;
    let options = ReplayOptions {
        delay_s: document.model().map_or(0.0, |model| model.delay_s),
        ..options_given
    };
    let (run, recording) = match (&document.augmented, &document.base) {
        (Some(model), _) => {
            progress.stage("simulating", "");
            let run = free_run::run(&document, model, &well, &prepared, &options, first)?;
            (run, None)
        }
        (None, Base::Identified(model)) => {
            let recording = prepared.averaged();
            progress.stage("simulating", "");
            let run = replay(&model.return_line(), &recording, &options)
                .map_err(|e| Failure::input(first, e))?;
            (run, Some((recording, model)))
        }
        (None, Base::WellOnly { .. }) => {
            return Err(Failure::input(&arguments.model, "holds no model"));
        }
    };
    if let Some(status) = run.status.filter(|s| *s != Status::Finished) {
        tracing::warn!("the integration stopped early: {}", why(status));
    }
    progress.stage("writing", &arguments.out.display().to_string());
    let table = as_table(&run);
    let mut outputs = Outputs::new();
    outputs.add(&arguments.out, |writer| {
        target.write(&table, "simulation", writer)
    })?;
    let mut drawn = Vec::new();
    if let Some(folder) = &arguments.figures {
        progress.stage("drawing", "figures");
        drawn = match &recording {
            Some((recording, model)) => {
                let runs = all_kinds(model, recording, &options, first)?;
                figures::draw_simulations(&mut outputs, folder, &runs)?
            }
            None => figures::draw_free_run(&mut outputs, folder, &run)?,
        };
    }
    outputs.keep()?;
    let effects = document.augmented.as_ref().map(|model| {
        let ids = model.effects.iter().map(|e| e.id.clone());
        ids.collect::<Vec<String>>()
    });
    let (seconds, stages) = (progress.seconds(), progress.seconds_by_stage());
    drop(progress);
    if global.json {
        let mut value = as_json(&run, arguments, &drawn, seconds);
        if let Some(effects) = effects {
            value["effects"] = json!(effects);
        }
        value["warnings"] = json!(warnings);
        value["seconds_by_stage"] = stages;
        return Ok(say::json(&value));
    }
    let warned: String = warnings.iter().map(|w| format!("warning: {w}\n")).collect();
    Ok(warned + &tell(&run, arguments, effects.as_deref(), drawn.len()))
}

/// A level in the riser, and no flow against the valve.
fn check_start(start: &Start, geometry: &Geometry) -> Result<(), Failure> {
    let deepest = geometry.pump_inlet_depth_m;
    let reason = match (start.level_m, start.flow_m3_s) {
        (Some(level), _) if !(0.0..=deepest).contains(&level) => {
            format!("--level is {level} m, expected between 0 m and the pump inlet at {deepest} m")
        }
        (_, Some(flow)) if !(0.0..=1.0).contains(&flow) => {
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
        SolverArg::Rodas => Method::Rodas,
        SolverArg::DormandPrince => Method::DormandPrince,
    }
}

fn options(arguments: &Simulate) -> Result<ReplayOptions, Failure> {
    let relative = tolerance(arguments.tolerance.unwrap_or(1e-4))?;
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
        window_s: arguments.window,
        start: Start {
            level_m: level.map(Length::si),
            flow_m3_s: flow.map(FlowRate::si),
        },
        delay_s: 0.0,
        solver: SimulationOptions {
            method: method(arguments.solver),
            relative,
            ..SimulationOptions::default()
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

/// Signals with their names and units, measured beside simulated.
fn signals(run: &Replay) -> [(&'static str, &'static str, &Pair); 6] {
    [
        ("riser_level_m", "m", &run.level_m),
        ("return_flow_m3_s", "m3/s", &run.return_flow_m3_s),
        ("pump_flow_m3_s", "m3/s", &run.pump_flow_m3_s),
        ("pump_inlet_pressure_pa", "Pa", &run.inlet_pressure_pa),
        ("pump_outlet_pressure_pa", "Pa", &run.outlet_pressure_pa),
        ("pump_head_m", "m", &run.head_m),
    ]
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

fn why(status: Status) -> String {
    match status {
        Status::Finished => "it had finished".into(),
        Status::StepTooSmall { t } => format!(
            "at {} s no step meets the tolerance; raise --tolerance",
            number(t)
        ),
        Status::TooManySteps { t } => {
            format!("at {} s the steps ran out; raise --tolerance", number(t))
        }
        Status::NonFinite { t } => format!(
            "at {} s the model gives no finite rate; check model.toml",
            number(t)
        ),
        _ => format!("{status:?}"),
    }
}

/// What went wrong or deserves notice in the run.
fn notes(run: &Replay) -> Vec<String> {
    let mut notes = Vec::new();
    match run.status {
        None | Some(Status::Finished) => {}
        Some(status) => notes.push(format!("the integration stopped early: {}", why(status))),
    }
    if run.filled > 0 {
        notes.push(format!(
            "{} input values were missing or not trusted and were interpolated",
            count(run.filled)
        ));
    }
    if let Some(at) = run.bounds.full_s {
        notes.push(format!("the simulated riser was full at {} s", number(at)));
    }
    if let Some(at) = run.bounds.empty_s {
        notes.push(format!(
            "the simulated riser was empty down to the pump at {} s",
            number(at)
        ));
    }
    if run.unsolved > 0 {
        notes.push(format!(
            "no steady flow was found at {} samples",
            count(run.unsolved)
        ));
    }
    notes
}

fn tell(run: &Replay, arguments: &Simulate, effects: Option<&[String]>, drawn: usize) -> String {
    let mut text = String::new();
    let (from, to) = (run.time_s[0], run.time_s[run.time_s.len() - 1]);
    let _ = writeln!(
        text,
        "{:?} simulation, {} s to {} s, {} samples",
        arguments.kind,
        number(from),
        number(to),
        count(run.time_s.len())
    );
    let s = &run.statistics;
    let _ = match effects {
        Some([]) => writeln!(text, "model of a diagnosis, without effects\n"),
        Some(effects) => writeln!(text, "with {}\n", effects.join(", ")),
        None => writeln!(
            text,
            "{} steps, {} rejected, {} evaluations\n",
            count(s.steps),
            count(s.rejected),
            count(s.rhs)
        ),
    };
    let mut table = TextTable::new([
        "simulated less measured",
        "root mean square",
        "mean",
        "largest",
        "unit",
    ]);
    for (name, unit, pair) in signals(run) {
        let Some(Deviation {
            rmse,
            bias,
            largest,
            ..
        }) = pair.deviation()
        else {
            continue;
        };
        let scale = if unit == "Pa" {
            (1e-5, "bar")
        } else if unit == "m3/s" {
            (6e4, "L/min")
        } else {
            (1.0, unit)
        };
        let stem = name
            .trim_end_matches("_m3_s")
            .trim_end_matches("_pa")
            .trim_end_matches("_m");
        table.row([
            stem.replace('_', " "),
            number(rmse * scale.0),
            number(bias * scale.0),
            number(largest * scale.0),
            scale.1.into(),
        ]);
    }
    text.push_str(&table.render());
    for note in notes(run) {
        let _ = writeln!(text, "note: {note}");
    }
    let _ = writeln!(text, "\nwrote {}", arguments.out.display());
    if let Some(folder) = &arguments.figures {
        let _ = writeln!(text, "drew {} figures into {}", drawn / 2, folder.display());
    }
    text
}

fn as_json(
    run: &Replay,
    arguments: &Simulate,
    drawn: &[std::path::PathBuf],
    seconds: f64,
) -> Value {
    let deviation = |pair: &Pair| {
        pair.deviation().map(|d| json!({ "rmse": d.rmse, "bias": d.bias, "largest": d.largest, "samples": d.samples }))
    };
    let s = &run.statistics;
    json!({
        "schema": "dgd.simulate/1",
        "kind": format!("{:?}", arguments.kind).to_lowercase(),
        "from_s": run.time_s.first(),
        "to_s": run.time_s.last(),
        "samples": run.time_s.len(),
        "finished": matches!(run.status, None | Some(Status::Finished)),
        "deviation": signals(run).iter().map(|(name, _, pair)| ((*name).to_owned(), json!(deviation(pair)))).collect::<serde_json::Map<_, _>>(),
        "filled": run.filled,
        "notes": notes(run),
        "statistics": { "steps": s.steps, "rejected": s.rejected, "rhs": s.rhs, "jacobians": s.jacobians },
        "out": arguments.out.display().to_string(),
        "figures": say::paths(drawn),
        "seconds": seconds,
    })
}
