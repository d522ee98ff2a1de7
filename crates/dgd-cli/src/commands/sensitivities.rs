//! `dgd sensitivities`: what moves the readings, and which parameters a recording tells apart.

mod profiles;

use crate::args::{Global, Sensitivities as Arguments};
use crate::commands::system_fit::identifiability_as_json;
use crate::failure::Failure;
use crate::output::{self, Outputs};
use crate::progress::Progress;
use crate::say::{self, TextTable, number};
use crate::system::{self, column, columns, failed, gauges, page, trouble};
use dgd_assembly::{
    Assembly, Identifiability, Sensitivities, SimulationOptions, identifiability, sensitivities,
};
use dgd_recording::Table;
use dgd_report::{Axis, Page, ReportError, Role, Series, TimePanel, series_over, time_series};
use serde_json::{Value, json};

/// Parameters drawn along the run.
const DRAWN: usize = 6;

pub(crate) fn run(arguments: &Arguments, global: &Global) -> Result<String, Failure> {
    let progress = Progress::new(global);
    let (path, recording) = (&arguments.system, &arguments.recording);
    let document = system::read(path)?;
    let assembly = &document.assembly;
    if assembly.parameters().is_empty() {
        return Err(Failure::Input {
            path: path.clone(),
            reason: "has no free parameters, so there are no sensitivities".into(),
            help: Some("name the parameters in question under [free], with their bounds".into()),
        });
    }
    let profiled = profiles::paths(assembly, &arguments.profile);
    let profiled = profiled.map_err(|e| failed(path, recording, &e))?;
    let recorded = columns::read(recording, path, assembly, &progress)?;
    let files = ["json", "csv", "html"].map(|e| arguments.out.join(format!("sensitivities.{e}")));
    files.iter().try_for_each(|file| output::check(file))?;
    let theta = document.theta();
    let parameters = assembly.parameters();
    progress.stage(
        "running",
        &format!("{} times, two for each parameter", 2 * parameters.len()),
    );
    let options = SimulationOptions::default();
    let moved = recorded
        .train
        .iter()
        .enumerate()
        .map(|(k, window)| sensitivities(assembly, &theta, window, k, &options))
        .collect::<Result<Vec<_>, _>>()
        .map_err(|e| failed(path, recording, &e))?;
    for (k, window) in moved.iter().enumerate() {
        if let Some(trouble) = trouble(window.status) {
            tracing::warn!(
                "window {} could not be simulated to its end: {trouble}",
                k + 1
            );
        }
    }
    let found = identifiability(&moved).map_err(|e| failed(path, recording, &e))?;
    if !profiled.is_empty() {
        progress.stage("profiling", &arguments.profile.join(", "));
    }
    let profiles = profiles::of(assembly, &theta, &recorded.train, &profiled)
        .map_err(|e| failed(path, recording, &e))?;
    progress.stage("writing", &arguments.out.display().to_string());
    let title = system::title(assembly, path);
    let name = system::file_name(recording);
    let mut value = as_json(assembly, &theta, &moved, &found);
    value["system"] = json!(title);
    value["recording"] = json!(name);
    value["profiles"] = profiles::as_json(&profiles);
    let html = html(assembly, &moved, &found, &profiles, [&title, &name])
        .map_err(|e| Failure::unwritten(&files[2], e))?;
    let table = table(assembly, &moved);
    let mut outputs = Outputs::new();
    outputs.add_bytes(&files[0], say::json(&value))?;
    outputs.add_csv(&files[1], &table)?;
    outputs.add_bytes(&files[2], &html)?;
    outputs.keep()?;
    let seconds = progress.seconds();
    drop(progress);
    if global.json {
        value["seconds"] = json!(seconds);
        return Ok(say::json(&value));
    }
    let mut said = tell(&title, &name, assembly, &moved, &found);
    if !profiles.is_empty() {
        said += &format!("\n{}", profiles::tell(&profiles));
    }
    Ok(said
        + &format!(
            "\nwrote sensitivities.json, sensitivities.csv and sensitivities.html into {}\n",
            arguments.out.display()
        ))
}

/// Root mean square of a scaled sensitivity over all windows, by parameter and instrument.
fn by_output(moved: &[Sensitivities], p: usize, m: usize) -> f64 {
    let scaled: Vec<f64> = moved
        .iter()
        .flat_map(|w| {
            w.values[p][m]
                .iter()
                .map(move |v| v * w.range[p] / w.size[m])
        })
        .filter(|v| v.is_finite())
        .collect();
    #[expect(clippy::cast_precision_loss, reason = "sample counts")]
    let mean = scaled.iter().map(|v| v * v).sum::<f64>() / scaled.len().max(1) as f64;
    mean.sqrt()
}

/// Parameters by falling importance.
fn order(found: &Identifiability) -> Vec<usize> {
    let mut order: Vec<usize> = (0..found.parameters.len()).collect();
    order.sort_by(|&a, &b| found.importance[b].total_cmp(&found.importance[a]));
    order
}

fn as_json(
    assembly: &Assembly,
    theta: &[f64],
    moved: &[Sensitivities],
    found: &Identifiability,
) -> Value {
    let outputs = assembly.outputs();
    let parameters: Vec<Value> = order(found)
        .into_iter()
        .map(|p| {
            let each: serde_json::Map<String, Value> = outputs
                .iter()
                .enumerate()
                .map(|(m, name)| (name.clone(), json!(by_output(moved, p, m))))
                .collect();
            json!({
                "path": found.parameters[p],
                "at": theta[p],
                "range": moved.first().map(|w| w.range[p]),
                "importance": found.importance[p],
                "by_output": each,
            })
        })
        .collect();
    json!({
        "schema": "dgd.sensitivities/1",
        "parameters": parameters,
        "sizes": moved.first().map(|w| outputs.iter().zip(&w.size)
            .map(|(name, size)| json!({ "output": name, "usual_size": size })).collect::<Vec<_>>()),
        "windows": moved.iter().map(|w| json!({
            "from": w.time.first(), "to": w.time.last(), "samples": w.time.len(),
            "ended": trouble(w.status).unwrap_or_else(|| "finished".into()),
        })).collect::<Vec<_>>(),
        "identifiability": identifiability_as_json(found),
    })
}

/// `output by parameter` along the windows: slope of the reading by the parameter, times its range.
fn table(assembly: &Assembly, moved: &[Sensitivities]) -> Table {
    let (clock, unit) = system::clock(assembly);
    let numbered = (1_u32..).zip(moved);
    let windows = numbered.flat_map(|(k, w)| std::iter::repeat_n(f64::from(k), w.time.len()));
    let mut columns = vec![
        column(
            clock,
            unit,
            moved.iter().flat_map(|w| w.time.clone()).collect(),
        ),
        column("window", None, windows.collect()),
    ];
    for (m, gauge) in gauges(assembly).iter().enumerate() {
        for (p, parameter) in assembly.parameters().iter().enumerate() {
            let along = moved.iter().flat_map(|w| {
                w.values[p][m]
                    .iter()
                    .map(move |v| gauge.difference(v * w.range[p]))
            });
            let unit = (!gauge.symbol.is_empty()).then(|| gauge.symbol.clone());
            let tag = format!("{} by {}", gauge.name, parameter.path);
            columns.push(column(&tag, unit, along.collect()));
        }
    }
    Table {
        columns,
        ..Table::default()
    }
}

fn html(
    assembly: &Assembly,
    moved: &[Sensitivities],
    found: &Identifiability,
    profiles: &[profiles::Profile],
    [title, recording]: [&str; 2],
) -> Result<String, ReportError> {
    let mut page = Page::new(
        format!("Sensitivities of {title}"),
        format!(
            "How the readings along {recording} change with each free parameter. {}",
            page::rank_sentence(found)
        ),
    );
    page.section("Which parameters matter");
    page::identifiable(&mut page, found)?;
    if !profiles.is_empty() {
        profiles::draw(&mut page, profiles)?;
    }
    page.section("By instrument")
        .table(&shares(assembly, moved, found));
    page.section("Along the run");
    let strongest: Vec<usize> = order(found).into_iter().take(DRAWN).collect();
    let along = page::independent(assembly);
    for (k, window) in moved.iter().enumerate() {
        for (m, gauge) in gauges(assembly).iter().enumerate() {
            let scaled: Vec<Vec<f64>> = strongest
                .iter()
                .map(|&p| {
                    let along = window.values[p][m].iter();
                    along
                        .map(|v| gauge.difference(v * window.range[p]))
                        .collect()
                })
                .collect();
            let moves = |values: &Vec<f64>| values.iter().any(|v| v.abs() > 0.0);
            // An instrument that nothing moves is left out, a parameter that does not move it too.
            let series: Vec<Series<'_>> = strongest
                .iter()
                .zip(&scaled)
                .filter(|(_, values)| moves(values))
                .enumerate()
                .map(|(n, (&p, values))| Series {
                    label: &found.parameters[p],
                    role: color(n),
                    time_s: &window.time,
                    value: values,
                })
                .collect();
            if series.is_empty() {
                continue;
            }
            let panel = [TimePanel {
                axis: Axis::new(format!("Change of {}", gauge.label())),
                title: "",
                series: &series,
            }];
            let figure = match &along {
                None => time_series(&panel, &[])?,
                Some(axis) => series_over(axis, &panel, &[], "")?,
            };
            let which = if moved.len() > 1 {
                format!(", window {}", k + 1)
            } else {
                String::new()
            };
            page.figure(&figure.with_caption(format!(
                "Derivative of {} with respect to a parameter at the present values, times the range of the parameter{which}.",
                gauge.name
            )));
        }
    }
    Ok(page.html())
}

fn color(n: usize) -> Role {
    match n {
        0 => Role::Model,
        1 => Role::Before,
        2 => Role::Measured,
        3 => Role::Input(0),
        4 => Role::Input(1),
        _ => Role::Input(2),
    }
}

fn shares(
    assembly: &Assembly,
    moved: &[Sensitivities],
    found: &Identifiability,
) -> dgd_report::Table {
    let outputs = assembly.outputs();
    let mut head = vec!["Parameter".to_owned()];
    head.extend(outputs.iter().cloned());
    let row = |p: usize| {
        let mut row = vec![found.parameters[p].clone()];
        row.extend((0..outputs.len()).map(|m| number(by_output(moved, p, m))));
        row
    };
    dgd_report::Table {
        caption: "Root mean square of the derivative of each reading with respect to a parameter at the present values, times the range of the \
                  parameter, in the usual size of the reading".into(),
        head,
        rows: order(found).into_iter().map(row).collect(),
    }
}

fn tell(
    title: &str,
    recording: &str,
    assembly: &Assembly,
    moved: &[Sensitivities],
    found: &Identifiability,
) -> String {
    let mut table = TextTable::new(["parameter", "importance", "moves most"]);
    let outputs = assembly.outputs();
    for p in order(found) {
        let most = (0..outputs.len())
            .map(|m| (by_output(moved, p, m), &outputs[m]))
            .filter(|(size, _)| *size > 0.0)
            .max_by(|a, b| a.0.total_cmp(&b.0));
        table.row([
            found.parameters[p].clone(),
            number(found.importance[p]),
            most.map_or("nothing".into(), |(_, name)| name.clone()),
        ]);
    }
    let mut text = format!(
        "{title} along {recording}\n\n{}\n{}\n",
        table.render(),
        page::rank_sentence(found)
    );
    for direction in &found.near_null {
        text.push_str(&format!("{}\n", page::near_null_sentence(direction)));
    }
    for (a, b, index) in &found.pairs {
        text.push_str(&format!(
            "alike: {a} and {b}, collinearity index {}\n",
            say::brief(*index)
        ));
    }
    text
}
