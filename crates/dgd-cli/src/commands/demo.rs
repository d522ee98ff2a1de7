//! `dgd demo`: one embedded recording is fitted, another is diagnosed.

use crate::args::{Demo, Global, Source};
use crate::commands::convert::Target;
use crate::commands::{diagnose, fit, simulate};
use crate::failure::Failure;
use crate::output::Outputs;
use crate::progress::Progress;
use crate::say::{self, brief};
use crate::{figures, load, page};
use dgd_identify::IdentifyOptions;
use dgd_replay::ReplayOptions;
use serde_json::json;
use std::path::{Path, PathBuf};

/// A stand-in recording of two hours; `fixtures/demo/README.md` says how it was made.
const RECORDING: &[u8] = include_bytes!("../../../../fixtures/demo/recording.mat");
const WELL: &str = include_str!("../../../../fixtures/demo/well.toml");

/// Five hours in which something is concealed; `fixtures/demo-concealed/README.md` says what.
const CONCEALED: &[u8] = include_bytes!("../../../../fixtures/demo-concealed/recording.mat");
const CONCEALED_WELL: &str = include_str!("../../../../fixtures/demo-concealed/well.toml");

pub(crate) fn run(arguments: &Demo, global: &Global) -> Result<String, Failure> {
    let progress = Progress::new(global);
    let out = &arguments.out;
    // The user gets the input as files, to repeat every step by hand.
    let (recording_path, well_path) = (out.join("recording.mat"), out.join("well.toml"));
    write_inputs(&recording_path, RECORDING, &well_path, WELL)?;
    let well = load::read_well(&well_path)?;
    let source = Source {
        recordings: vec![recording_path.clone()],
        well: well_path,
        thesis_screening: false,
        window: None,
    };
    let loaded = load::read_recordings(&source.recordings, &well, &progress)?;
    let fitted = fit::fit(
        loaded,
        &well,
        &source,
        &IdentifyOptions::default(),
        true,
        &progress,
    )?;
    let model = &fitted.identification.model;
    let mut outputs = Outputs::new();
    outputs.add_bytes(&out.join("model.toml"), dgd_documents::write_model(model))?;
    progress.stage("simulating", "");
    let options = ReplayOptions {
        delay_s: model.delay_s,
        ..ReplayOptions::default()
    };
    let recording = fitted.prepared.clone().averaged();
    let runs = simulate::all_kinds(model, &recording, &options, &recording_path)?;
    let table = simulate::as_table(&runs[3]);
    outputs.add_csv(&out.join("simulation.csv"), &table)?;
    outputs.add(&out.join("simulation.mcap"), |w| {
        Target::Mcap.write(&table, "simulation", w)
    })?;
    progress.stage("drawing", "figures");
    let folder = out.join("figures");
    let mut drawn = figures::draw_identification(&mut outputs, &folder, &fitted)?;
    drawn.extend(figures::draw_simulations(&mut outputs, &folder, &runs)?);
    let provenance = "This recording is a stand-in: two hours from a simulated dual-gradient rig of higher fidelity than the model, with the \
                      faults of field data. No field data are shown.";
    let html = page::identified(
        "A return line identified from its recording",
        provenance,
        &fitted,
        &runs,
    )
    .map_err(|e| Failure::unwritten(out, e))?;
    outputs.add_bytes(&out.join("report.html"), html)?;
    outputs.keep()?;
    let (diagnosis_out, diagnosed) = diagnose_concealed(out, &progress)?;
    let seconds = progress.seconds();
    drop(progress);
    let [level, flow] = [&runs[3].level_m, &runs[3].pump_flow_m3_s]
        .map(|p| p.deviation().map_or(f64::NAN, |d| d.rmse));
    if global.json {
        return Ok(say::json(&json!({
            "schema": "dgd.demo/1",
            "out": out.display().to_string(),
            "delay_s": model.delay_s,
            "level_rmse_m": level,
            "flow_rmse_m3_s": flow,
            "figures": say::paths(&drawn),
            "diagnosis": {
                "verdict": diagnosed.diagnosis.verdict.name(),
                "effects": diagnosed.diagnosis.findings.iter().map(|f| &f.effect).collect::<Vec<_>>(),
                "report": diagnosis_out.join("report.html").display().to_string(),
            },
            "seconds": seconds,
        })));
    }
    let (shown, there) = (out.display(), diagnosis_out.display());
    Ok(format!(
        "{}\nfree run: level error {} m, flow error {} L/min (root mean square)\n\nA second recording, in which something is concealed, is \
         diagnosed:\n\n{}\nnext: dgd inspect {shown}/recording.mat\n      dgd fit {shown}/recording.mat --well {shown}/well.toml --out \
         {shown}/model.toml\n      dgd simulate {shown}/recording.mat --well {shown}/well.toml --model {shown}/model.toml --out {shown}/run.csv\n      \
         dgd diagnose {there}/recording.mat --well {there}/well.toml --out {there}\nthe fit: {shown}/report.html, with figures in \
         {shown}/figures\nthe diagnosis, to open first: {there}/report.html\n",
        fit::tell(&fitted),
        brief(level),
        brief(flow * 6e4),
        diagnose::tell(&diagnosed, &diagnosis_out),
    ))
}

fn write_inputs(
    recording: &Path,
    bytes: &[u8],
    well: &Path,
    described: &str,
) -> Result<(), Failure> {
    let mut outputs = Outputs::new();
    outputs.add_bytes(recording, bytes)?;
    outputs.add_bytes(well, described)?;
    outputs.keep()
}

/// Diagnoses the recording in which something is concealed, in a folder of its own.
fn diagnose_concealed(
    out: &Path,
    progress: &Progress,
) -> Result<(PathBuf, diagnose::Diagnosed), Failure> {
    let out = out.join("diagnosis");
    let source = Source {
        recordings: vec![out.join("recording.mat")],
        well: out.join("well.toml"),
        thesis_screening: false,
        window: None,
    };
    write_inputs(
        &source.recordings[0],
        CONCEALED,
        &source.well,
        CONCEALED_WELL,
    )?;
    let diagnosed = diagnose::carry_out(&source, diagnose::Search::default(), &out, progress)?;
    Ok((out, diagnosed))
}
