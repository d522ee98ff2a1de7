//! `dgd fit --system`: the free values of any system from its recording.

mod linear;

use crate::args::{Fit as Arguments, Global};
use crate::failure::Failure;
use crate::output::{self, Outputs};
use crate::progress::Progress;
use crate::say::{self, TextTable, brief, count, number};
use crate::system::columns::{self, Recorded};
use crate::system::measure::Measure;
use crate::system::runs::{self, Run};
use crate::system::{self, bounds, diagram, ending, failed, gauges, page};
use dgd_assembly::{
    Assembly, Fit, FitOptions, FitStatus, Identifiability, Loss, RunStatus, SimulationOptions, fit,
    identifiability, sensitivities,
};
use dgd_documents::{FittedParameter, FittedSystem, write_fitted_system};
use dgd_report::{Page, ReportError};
use serde_json::{Value, json};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

/// Huber's constant: 95 % efficient on normal residuals.
const HUBER: f64 = 1.345;

/// What a fit is told from.
struct Done<'a> {
    title: String,
    recording: String,
    assembly: &'a Assembly,
    fit: &'a Fit,
    fitted: &'a FittedSystem,
    runs: &'a [Run],
    told: Option<Identifiability>,
    linear: Option<linear::Linear>,
    issues: &'a [String],
    robust: bool,
}

pub(crate) fn run(
    arguments: &Arguments,
    path: &Path,
    recordings: &[PathBuf],
    global: &Global,
) -> Result<String, Failure> {
    let progress = Progress::new(global);
    let (recording, document) = system::open(path, recordings)?;
    let assembly = &document.assembly;
    let recorded = columns::read(recording, path, assembly, &progress)?.measured()?;
    let files = Files::of(&arguments.out)?;
    progress.stage(
        "fitting",
        &format!(
            "{} parameters to {} samples",
            assembly.parameters().len(),
            count(recorded.samples())
        ),
    );
    let options = FitOptions {
        start: Some(document.theta()),
        more_starts: arguments.starts,
        loss: if arguments.robust {
            Loss::Huber(HUBER)
        } else {
            Loss::Square
        },
        ..FitOptions::default()
    };
    let found =
        fit(assembly, &recorded.train, &options).map_err(|e| failed(path, recording, &e))?;
    check(&found, path, recording)?;
    let fitted = FittedSystem {
        recording: system::file_name(recording),
        status: ending(found.status).into(),
        samples: found.samples,
        parameters: parameters(assembly, &found),
    };
    let model = write_fitted_system(assembly, &fitted).map_err(|e| failed(path, recording, &e))?;
    progress.stage("simulating", "the fitted system");
    // As `dgd simulate` will read it.
    let document = dgd_documents::read_system(&model)
        .map_err(|e| system::told(&arguments.out, model.clone(), e))?;
    let (assembly, theta) = (&document.assembly, document.theta());
    let simulation = SimulationOptions::default();
    let files_read = (path, recording);
    let runs = runs::simulate(assembly, &theta, &recorded, &simulation, files_read)?;
    let mut issues = recorded.issues.clone();
    for doubt in runs::worse_than_the_mean(assembly, &runs) {
        tracing::warn!("{}: {doubt}", recording.display());
        issues.push(doubt);
    }
    let linear = if arguments.linear {
        progress.stage("fitting", "the linear model");
        let robust = arguments.robust;
        Some(linear::of(assembly, &found, &recorded, robust, files_read)?)
    } else {
        None
    };
    progress.stage("comparing", "how the parameters affect the readings");
    let done = Done {
        title: system::title(assembly, path),
        recording: fitted.recording.clone(),
        told: told(assembly, &theta, &recorded, &simulation),
        linear,
        assembly,
        fit: &found,
        fitted: &fitted,
        runs: &runs,
        issues: &issues,
        robust: arguments.robust,
    };
    progress.stage("writing", &arguments.out.display().to_string());
    let html = html(&done).map_err(|e| Failure::unwritten(&files.report, e))?;
    let mut value = as_json(&done, &files);
    files.write(&model, &done, &html, &say::json(&value))?;
    let (seconds, stages) = (progress.seconds(), progress.seconds_by_stage());
    drop(progress);
    if global.json {
        value["seconds"] = json!(seconds);
        value["seconds_by_stage"] = stages;
        return Ok(say::json(&value));
    }
    Ok(tell(&done, &files))
}

/// The four files, by the name of the model.
struct Files {
    model: PathBuf,
    simulation: PathBuf,
    report: PathBuf,
    json: PathBuf,
}

impl Files {
    fn of(model: &Path) -> Result<Self, Failure> {
        let files = Self {
            model: model.to_owned(),
            simulation: system::beside(model, "csv"),
            report: system::beside(model, "html"),
            json: system::beside(model, "json"),
        };
        let all = [&files.model, &files.simulation, &files.report, &files.json];
        if all[1..].contains(&all[0]) {
            let reason = format!(
                "--out {} would be replaced by the report; name the model .toml",
                model.display()
            );
            return Err(Failure::Arguments { reason });
        }
        all.into_iter().try_for_each(|path| output::check(path))?;
        Ok(files)
    }

    /// All or none.
    fn write(&self, model: &str, done: &Done<'_>, html: &str, json: &str) -> Result<(), Failure> {
        let table = runs::table(done.assembly, done.runs);
        let mut outputs = Outputs::new();
        outputs.add_bytes(&self.model, model)?;
        outputs.add_csv(&self.simulation, &table)?;
        outputs.add_bytes(&self.report, html)?;
        outputs.add_bytes(&self.json, json)?;
        outputs.keep()
    }
}

/// What a fit without a result is told as; a doubtful one is warned of.
fn check(found: &Fit, system: &Path, recording: &Path) -> Result<(), Failure> {
    let refuse = |path: &Path, reason: &str, help: &str| {
        Err(Failure::Input {
            path: path.to_owned(),
            reason: reason.into(),
            help: Some(help.into()),
        })
    };
    match found.status {
        FitStatus::NothingFree => refuse(
            system,
            "has no free parameters, so there is nothing to fit",
            "name the parameters to fit under [free], or run `dgd simulate --system`",
        ),
        FitStatus::NoStart => refuse(
            recording,
            "cannot be simulated from any start within the bounds",
            "check the units of the inputs, then the values under [free] and [initial]",
        ),
        FitStatus::Converged => Ok(()),
        other => {
            tracing::warn!("the fit {}", ending(other));
            Ok(())
        }
    }
}

fn parameters(assembly: &Assembly, found: &Fit) -> Vec<FittedParameter> {
    let known = assembly.parameters();
    known
        .iter()
        .enumerate()
        .map(|(k, p)| FittedParameter {
            path: p.path.clone(),
            value: found.theta[k],
            standard_error: found.standard_error[k],
            at_bound: found.at_bound[k],
        })
        .collect()
}

/// What the training part tells of the parameters; `None` if its runs do not.
fn told(
    assembly: &Assembly,
    theta: &[f64],
    recorded: &Recorded,
    options: &SimulationOptions,
) -> Option<Identifiability> {
    let windows = recorded.train.iter().enumerate();
    let moved: Result<Vec<_>, _> = windows
        .map(|(k, w)| sensitivities(assembly, theta, w, k, options))
        .collect();
    if let Ok(moved) = &moved
        && moved.iter().any(|m| m.status != RunStatus::Finished)
    {
        tracing::warn!(
            "beside the fitted values the system could not always be run, so what the readings show of the parameters holds for a part of the samples"
        );
    }
    let found = moved.and_then(|moved| identifiability(&moved));
    if let Err(error) = &found {
        tracing::warn!("the identifiability of the parameters is left out: {error}");
    }
    found.ok()
}

/// `level 0.01 m in training, 0.02 m held out`
fn sentence(done: &Done<'_>) -> String {
    let mut parts = Vec::new();
    for (o, gauge) in gauges(done.assembly).iter().enumerate() {
        let value = |held_out: bool| {
            let (rms, samples) = runs::rms(done.runs, held_out, o);
            (samples > 0).then(|| gauge.with_unit(&brief(gauge.difference(rms))))
        };
        match (value(false), value(true)) {
            (Some(train), Some(test)) => {
                parts.push(format!(
                    "{} {train} in training and {test} held out",
                    gauge.name
                ));
            }
            (Some(train), None) => parts.push(format!("{} {train} in training", gauge.name)),
            (None, Some(test)) => parts.push(format!("{} {test} held out", gauge.name)),
            (None, None) => {}
        }
    }
    parts.join("; ")
}

fn html(done: &Done<'_>) -> Result<String, ReportError> {
    let lead = format!(
        "{} free parameters fitted to {} readings of {}: the fit {}. Error (root mean square): {}.",
        done.fitted.parameters.len(),
        count(done.fit.samples),
        done.recording,
        done.fitted.status,
        sentence(done)
    );
    let mut page = Page::new(format!("Fit of {}", done.title), lead);
    page.section("The system")
        .figure(&diagram::draw(done.assembly.system())?);
    page.section("The model beside the recording")
        .table(&page::errors(done.assembly, done.runs));
    for held_out in [false, true] {
        for figure in page::beside(done.assembly, done.runs, held_out)? {
            page.figure(&figure);
        }
    }
    page.section("Parameters");
    let parameters: Vec<page::Parameter<'_>> = (done.fitted.parameters.iter())
        .map(|p| page::Parameter {
            fitted: p,
            ci95: page::interval(p, bounds(done.assembly, &p.path)),
        })
        .collect();
    let includes = "the noise and its autocorrelation, not model error";
    page::parameters(&mut page, done.assembly, &parameters, includes)?;
    page.section("How well the recording determines them");
    match &done.told {
        Some(told) => page::identifiable(&mut page, told)?,
        None => {
            page.paragraph("The runs needed for this could not be made, so it is not known.");
        }
    }
    if let Some(linear) = &done.linear {
        linear.draw(&mut page, done.assembly, &done.fitted.parameters);
    }
    page.section("Residuals");
    for figure in page::residuals(done.assembly, done.runs)? {
        page.figure(&figure);
    }
    page.section("Settings").list(&[
        format!(
            "Steps tried: {}; simulations of a window: {}.",
            done.fit.iterations, done.fit.runs
        ),
        format!(
            "Loss: {}. Variances are widened {} times for the autocorrelation of the residuals.",
            if done.robust { "Huber" } else { "squares" },
            brief(done.fit.inflation)
        ),
    ]);
    if !done.issues.is_empty() {
        page.paragraph("Faults in the recording:").list(done.issues);
    }
    Ok(page.html())
}

fn as_json(done: &Done<'_>, files: &Files) -> Value {
    let system = done.assembly.system();
    let known = done.assembly.parameters();
    let parameters: Vec<Value> = done
        .fitted
        .parameters
        .iter()
        .zip(&known)
        .map(|(p, bounds)| {
            let measure = Measure::of(system, &p.path);
            let within = (bounds.low, bounds.high);
            let ci95 = measure.ends(page::interval(p, within));
            let (low, high) = measure.ends(within);
            json!({
                "path": p.path,
                "value": measure.shown(p.value),
                "standard_error": measure.shown(p.standard_error),
                "ci95": [ci95.0, ci95.1],
                "low": low,
                "high": high,
                "at_bound": p.at_bound,
                "initial": bounds.initial,
                "unit": measure.symbol,
            })
        })
        .collect();
    json!({
        "schema": "dgd.system-fit/1",
        "system": done.title,
        "recording": done.recording,
        "status": done.fitted.status,
        "converged": done.fit.status == FitStatus::Converged,
        "samples": done.fit.samples,
        "cost": done.fit.cost,
        "inflation": done.fit.inflation,
        "iterations": done.fit.iterations,
        "runs": done.fit.runs,
        "outputs": runs::errors_as_json(done.assembly, done.runs),
        "windows": runs::windows_as_json(done.runs),
        "parameters": parameters,
        "covariance": done.fit.covariance.chunks(known.len().max(1)).collect::<Vec<_>>(),
        "identifiability": done.told.as_ref().map(identifiability_as_json),
        "linear": done.linear.as_ref().map(|l| l.as_json(done.assembly)),
        "issues": done.issues,
        "model": system::file_name(&files.model),
        "simulation": system::file_name(&files.simulation),
        "report": system::file_name(&files.report),
    })
}

/// Ranking, rank and directions, for machines.
pub(crate) fn identifiability_as_json(found: &Identifiability) -> Value {
    let mut ranked: Vec<(&String, f64)> = found
        .parameters
        .iter()
        .zip(found.importance.iter().copied())
        .collect();
    ranked.sort_by(|a, b| b.1.total_cmp(&a.1));
    json!({
        "rank": found.rank,
        "of": found.parameters.len(),
        "collinearity_index": found.collinearity,
        "ranking": ranked.iter().map(|(path, value)| json!({ "path": path, "importance": value })).collect::<Vec<_>>(),
        "eigenvalues": found.eigenvalues,
        "gram": found.gram.chunks(found.parameters.len().max(1)).collect::<Vec<_>>(),
        "gram_order": found.parameters,
        "pairs": found.pairs.iter().map(|(a, b, index)| json!({ "of": [a, b], "collinearity_index": index })).collect::<Vec<_>>(),
        "near_null": found.near_null.iter().map(|n| json!({
            "relative": n.relative,
            "shares": n.shares.iter().map(|(path, share)| json!({ "path": path, "share": share })).collect::<Vec<_>>(),
        })).collect::<Vec<_>>(),
    })
}

fn tell(done: &Done<'_>, files: &Files) -> String {
    let mut text = String::new();
    // Writing to a String cannot fail.
    let _ = tell_into(&mut text, done, files);
    text
}

fn tell_into(text: &mut String, done: &Done<'_>, files: &Files) -> std::fmt::Result {
    writeln!(
        text,
        "{}: the fit of {} values to {} readings of {} {}\n",
        done.title,
        done.fitted.parameters.len(),
        count(done.fit.samples),
        done.recording,
        done.fitted.status
    )?;
    write!(text, "{}", errors(done.assembly, done.runs).render())?;
    writeln!(text)?;
    let mut table = TextTable::new(["parameter", "estimate", "95 % from", "to", "unit", "note"]);
    for p in &done.fitted.parameters {
        let told = page::Told::of_fitted(done.assembly, p);
        let [from, to] = told.ends.unwrap_or_default();
        table.row([
            p.path.clone(),
            told.value,
            from,
            to,
            Measure::of(done.assembly.system(), &p.path).symbol,
            told.note.into(),
        ]);
    }
    write!(text, "{}", table.render())?;
    if let Some(told) = &done.told {
        writeln!(text, "\n{}", page::rank_sentence(told))?;
        for direction in &told.near_null {
            writeln!(text, "{}", page::near_null_sentence(direction))?;
        }
    }
    if let Some(linear) = &done.linear {
        write!(
            text,
            "{}",
            linear.tell(done.assembly, &done.fitted.parameters)
        )?;
    }
    writeln!(
        text,
        "\nwrote {}, {}, {} and {}",
        files.model.display(),
        files.simulation.display(),
        files.report.display(),
        files.json.display()
    )
}

/// Errors by instrument, for the terminal.
pub(crate) fn errors(assembly: &Assembly, runs: &[Run]) -> TextTable {
    let mut table = TextTable::new(["off by, rms", "training", "held out", "unit"]);
    for (o, gauge) in gauges(assembly).iter().enumerate() {
        let cell = |held_out: bool| {
            let (rms, samples) = runs::rms(runs, held_out, o);
            if samples == 0 {
                String::new()
            } else {
                number(gauge.difference(rms))
            }
        };
        table.row([
            gauge.name.clone(),
            cell(false),
            cell(true),
            gauge.symbol.clone(),
        ]);
    }
    table
}
