//! `dgd simulate --system`: a system, as described or as fitted, beside a recording.

use crate::args::{Global, Simulate};
use crate::commands::convert::Target;
use crate::commands::simulate::{method, tolerance};
use crate::commands::system_fit::errors;
use crate::failure::Failure;
use crate::output::{self, Outputs};
use crate::progress::Progress;
use crate::say::{self, count};
use crate::system::runs::{self, Run};
use crate::system::{self, columns, diagram, gauges, page};
use dgd_assembly::{Assembly, SimulationOptions};
use dgd_report::{Page, ReportError};
use serde_json::json;
use std::path::{Path, PathBuf};

pub(crate) fn run(
    arguments: &Simulate,
    path: &Path,
    recordings: &[PathBuf],
    global: &Global,
) -> Result<String, Failure> {
    let progress = Progress::new(global);
    let out = &arguments.out;
    let target = Target::of(out, false)?;
    let default = SimulationOptions::default();
    let options = SimulationOptions {
        method: arguments.solver.map_or(default.method, method),
        relative: tolerance(arguments.tolerance.unwrap_or(default.relative))?,
        ..default
    };
    let (recording, document) = system::open(path, recordings)?;
    let assembly = &document.assembly;
    let recorded = columns::read(recording, path, assembly, &progress)?;
    let (report, json_path) = (system::beside(out, "html"), system::beside(out, "json"));
    for file in [out, &report, &json_path] {
        output::check(file)?;
    }
    progress.stage(
        "simulating",
        &format!("{} samples", count(recorded.samples())),
    );
    let theta = document.theta();
    let runs = runs::simulate(assembly, &theta, &recorded, &options, (path, recording))?;
    progress.stage("writing", &out.display().to_string());
    let title = system::title(assembly, path);
    let name = system::file_name(recording);
    let fitted = document.fitted.is_some();
    let html =
        html(assembly, &runs, &title, &name, fitted).map_err(|e| Failure::unwritten(&report, e))?;
    let parameters = assembly.parameters();
    let mut value = json!({
        "schema": "dgd.system-simulation/1",
        "system": title,
        "recording": name,
        "fitted": fitted,
        "parameters": parameters.iter().zip(&theta)
            .map(|(p, value)| json!({ "path": p.path, "value": value })).collect::<Vec<_>>(),
        "outputs": runs::errors_as_json(assembly, &runs),
        "windows": runs::windows_as_json(&runs),
        "issues": recorded.issues,
        "simulation": system::file_name(out),
        "report": system::file_name(&report),
    });
    let table = runs::table(assembly, &runs);
    let mut outputs = Outputs::new();
    outputs.add(out, |writer| target.write(&table, "simulation", writer))?;
    outputs.add_bytes(&report, &html)?;
    outputs.add_bytes(&json_path, say::json(&value))?;
    outputs.keep()?;
    let (seconds, stages) = (progress.seconds(), progress.seconds_by_stage());
    drop(progress);
    if global.json {
        value["seconds"] = json!(seconds);
        value["seconds_by_stage"] = stages;
        return Ok(say::json(&value));
    }
    Ok(format!(
        "{title}, {}: {} windows of {name}\n\n{}\nwrote {}, {} and {}\n",
        if fitted { "as fitted" } else { "as described" },
        runs.len(),
        errors(assembly, &runs).render(),
        out.display(),
        report.display(),
        json_path.display()
    ))
}

fn html(
    assembly: &Assembly,
    runs: &[Run],
    title: &str,
    recording: &str,
    fitted: bool,
) -> Result<String, ReportError> {
    let gauges = gauges(assembly);
    let said: Vec<String> = [(false, "in training"), (true, "held out")]
        .into_iter()
        .flat_map(|(held_out, words)| {
            let each = gauges.iter().enumerate();
            each.filter_map(move |(o, gauge)| {
                page::off(runs, held_out, o, gauge).map(|off| format!("{off} {words}"))
            })
            .collect::<Vec<_>>()
        })
        .collect();
    let how = if fitted {
        "with the values of its fit"
    } else {
        "with the values of its description"
    };
    let off = if said.is_empty() {
        "No instrument was recorded.".to_owned()
    } else {
        format!("Error (root mean square): {}.", said.join("; "))
    };
    let mut page = Page::new(
        format!("Simulation of {title}"),
        format!("A free run beside {recording} {how}. {off}"),
    );
    page.section("The model beside the recording")
        .table(&page::errors(assembly, runs));
    for held_out in [false, true] {
        for figure in page::beside(assembly, runs, held_out)? {
            page.figure(&figure);
        }
    }
    let residuals = page::residuals(assembly, runs)?;
    if !residuals.is_empty() {
        page.section("Residuals");
    }
    for figure in residuals {
        page.figure(&figure);
    }
    page.section("The system")
        .figure(&diagram::draw(assembly.system())?);
    Ok(page.html())
}
