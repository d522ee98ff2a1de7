//! `dgd convert`: a recording in another format.

use crate::args::{Convert, Global};
use crate::failure::Failure;
use crate::progress::Progress;
use crate::say::{self, count};
use crate::{load, output};
use dgd_export::{CsvOptions, McapOptions};
use serde_json::json;
use std::io::Write;
use std::path::Path;
use std::time::Instant;

pub(crate) fn run(arguments: &Convert, global: &Global) -> Result<String, Failure> {
    let started = Instant::now();
    let target = Target::of(&arguments.output, arguments.mat_v73)?;
    let progress = Progress::new(global.json || global.quiet);
    let (format, table) = load::read_table(&arguments.input, &progress)?;
    for issue in &table.issues {
        tracing::warn!("{}: {issue}", arguments.input.display());
    }
    progress.stage("writing", &arguments.output.display().to_string());
    output::replace(&arguments.output, |writer| {
        match target {
            Target::Csv => dgd_export::write_csv(&table, &CsvOptions::default(), writer),
            Target::Mcap => dgd_export::write_mcap(&table, &McapOptions::default(), writer),
            Target::Mat5 => dgd_export::write_mat5(&table, &arguments.root, writer),
            Target::Mat73 => {
                let bytes =
                    dgd_export::write_mat73(&table, &arguments.root).map_err(|e| e.to_string())?;
                return writer.write_all(&bytes).map_err(|e| e.to_string());
            }
        }
        .map_err(|e| e.to_string())
    })?;
    let (rows, columns) = (table.rows(), table.columns.len());
    if global.json {
        return Ok(say::json(&json!({
            "schema": "dgd.convert/1",
            "input_format": format.to_string(),
            "output": arguments.output.display().to_string(),
            "rows": rows,
            "columns": columns,
            "issues": table.issues.iter().map(ToString::to_string).collect::<Vec<_>>(),
            "seconds": started.elapsed().as_secs_f64(),
        })));
    }
    Ok(format!(
        "{format} to {}: {} rows, {columns} columns\n",
        arguments.output.display(),
        count(rows)
    ))
}

/// Format of the output.
#[derive(Clone, Copy)]
pub(crate) enum Target {
    Csv,
    Mcap,
    Mat5,
    Mat73,
}

impl Target {
    /// By the ending of the name.
    pub(crate) fn of(path: &Path, mat_v73: bool) -> Result<Self, Failure> {
        let ending = path.extension().map(|e| e.to_string_lossy().to_lowercase());
        match ending.as_deref() {
            Some("csv" | "txt") => Ok(Self::Csv),
            Some("mcap") => Ok(Self::Mcap),
            Some("mat") if mat_v73 => Ok(Self::Mat73),
            Some("mat") => Ok(Self::Mat5),
            _ => Err(Failure::Arguments {
                reason: format!(
                    "{}: the ending says no format; name it .csv, .mcap or .mat",
                    path.display()
                ),
            }),
        }
    }
}
