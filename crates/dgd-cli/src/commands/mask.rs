//! `dgd mask`: what may be passed on, in percent of references that stay behind.

use crate::args::{Global, Mask};
use crate::commands::fit;
use crate::failure::Failure;
use crate::output::{self, Outputs};
use crate::progress::Progress;
use crate::say::{self, count};
use crate::{load, page};
use dgd_identify::{IdentifyOptions, Series};
use dgd_mask::{MaskedRecording, choose_references, mask_model, mask_recording};
use dgd_recording::{Column, Table};
use dgd_units::MaskReferences;
use serde_json::json;
use std::path::{Component, Path, PathBuf};

pub(crate) fn run(arguments: &Mask, global: &Global) -> Result<String, Failure> {
    refuse_references_inside(&arguments.references, &arguments.out)?;
    let progress = Progress::new(global);
    let well = load::read_well(&arguments.source.well)?;
    let first = arguments.source.recordings[0].clone();
    let mut loaded = load::read_recordings(&arguments.source.recordings, &well, &progress)?
        .within(&arguments.source)?;
    // It has been told once.
    loaded.told.clear();
    if !loaded.suspicions.is_empty() {
        // What is suspected holds values and tags, which this command tells nobody.
        loaded.suspicions =
            vec!["the recording does not match its well description: `dgd fit` says where".into()];
    }
    output::check(&arguments.out.join("recording.csv"))?;
    let mut fitted = fit::fit(
        loaded,
        &well,
        &arguments.source,
        &IdentifyOptions::default(),
        false,
        &progress,
    )?;
    // They hold values, which this command tells nobody.
    if !fitted.identification.warnings.is_empty() {
        tracing::warn!("the identification raised warnings: `dgd fit` lists them");
    }
    if let Some(path) = &arguments.model {
        fitted.identification.model = load::read_base_model(path)?;
    }
    progress.stage("masking", "");
    let series = &fitted.identification.series;
    let chosen =
        choose_references(&fitted.prepared, series).map_err(|e| Failure::input(&first, e))?;
    // The references go first to their place: nothing masked is without what undoes it.
    let mut outputs = Outputs::new();
    let (references, kept_before) = references(&arguments.references, chosen, &mut outputs)?;
    let recording = mask_recording(&fitted.prepared, series, &references)
        .map_err(|e| Failure::input(&first, e))?;
    let table = as_table(&recording);
    outputs.add_csv(&arguments.out.join("recording.csv"), &table)?;
    let model = mask_model(&fitted.identification.model, &references);
    outputs.add_bytes(
        &arguments.out.join("model.toml"),
        dgd_documents::write_masked_model(&model),
    )?;
    // Figures are drawn from the dithered series: a figure's coordinates are data too.
    fitted.identification.series = unmasked(&recording, &references);
    fitted.prepared.recording.return_flow_m3_s = recording
        .return_flow_pct
        .iter()
        .map(|p| references.unmask_flow(*p))
        .collect();
    fitted.identification.pump_flow_m3_s = shifted_flow(&fitted);
    let html =
        page::masked(&fitted, &references).map_err(|e| Failure::unwritten(&arguments.out, e))?;
    outputs.add_bytes(&arguments.out.join("report.html"), html)?;
    outputs.keep()?;
    drop(progress);
    if global.json {
        return Ok(say::json(&json!({
            "schema": "dgd.mask/1",
            "out": arguments.out.display().to_string(),
            "samples": recording.time_s.len(),
            "references": arguments.references.display().to_string(),
            "references_read": kept_before,
        })));
    }
    let verb = if kept_before {
        "read"
    } else {
        "chosen and written to"
    };
    Ok(format!(
        "masked {} samples into {}: recording.csv, model.toml, report.html\nreferences {verb} {}: keep that file, it reverses the masking\n",
        count(recording.time_s.len()),
        arguments.out.display(),
        arguments.references.display()
    ))
}

/// The references must not travel with what they unmask.
fn refuse_references_inside(references: &Path, out: &Path) -> Result<(), Failure> {
    if resolved(references).starts_with(resolved(out)) {
        return Err(Failure::Arguments {
            reason: format!(
                "--references {} lies in the output folder {}, which will be shared; choose another place",
                references.display(),
                out.display()
            ),
        });
    }
    Ok(())
}

/// Where a path leads, links and `..` followed as far as it exists.
fn resolved(path: &Path) -> PathBuf {
    let absolute = std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
    let mut place = PathBuf::new();
    for part in absolute.components() {
        match part {
            Component::ParentDir => {
                place.pop();
            }
            part => place.push(part),
        }
        // What does not exist yet is no link.
        place = std::fs::canonicalize(&place).unwrap_or(place);
    }
    place
}

/// The references in the file, or the chosen ones, written there.
fn references(
    path: &Path,
    chosen: MaskReferences,
    outputs: &mut Outputs,
) -> Result<(MaskReferences, bool), Failure> {
    if path.exists() {
        let source = load::read_text(path)?;
        return match dgd_documents::read_references(&source) {
            Ok((references, _)) => Ok((references, true)),
            // Not rendered with its source: the lines hold what must stay secret.
            Err(error) => Err(Failure::input(path, error)),
        };
    }
    outputs.add_private(path, dgd_documents::write_references(&chosen).as_bytes())?;
    Ok((chosen, false))
}

fn as_table(recording: &MaskedRecording) -> Table {
    let column = |(tag, values): (&str, &[f64])| Column {
        tag: tag.to_owned(),
        unit: Some(if tag == "t" { "s" } else { "%" }.to_owned()),
        values: values.to_vec(),
    };
    let mut columns: Vec<Column> = recording.columns().into_iter().map(column).collect();
    let usable = recording
        .keep
        .iter()
        .map(|k| f64::from(u8::from(*k)))
        .collect();
    columns.push(Column {
        tag: "usable".into(),
        unit: Some("1".into()),
        values: usable,
    });
    Table {
        columns,
        ..Table::default()
    }
}

/// The dithered series, back in SI for the figures' own scaling.
fn unmasked(recording: &MaskedRecording, references: &MaskReferences) -> Series {
    let back = |values: &[f64], f: &dyn Fn(f64) -> f64| values.iter().map(|v| f(*v)).collect();
    Series {
        level_m: back(&recording.level_pct, &|p| references.unmask_level(p)),
        friction_pa: back(&recording.friction_pct, &|p| references.unmask_friction(p)),
        head_m: back(&recording.head_pct, &|p| references.unmask_head(p)),
    }
}

fn shifted_flow(fitted: &fit::Fitted) -> Vec<f64> {
    let id = &fitted.identification;
    dgd_identify::read_ahead(
        &fitted.prepared.recording.return_flow_m3_s,
        id.sweep.best_delay_samples,
    )
}
