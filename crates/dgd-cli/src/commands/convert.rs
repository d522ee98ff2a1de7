//! `dgd convert`: a recording in another format.

use crate::args::{Convert, Global};
use crate::failure::Failure;
use crate::load;
use crate::output::Outputs;
use crate::progress::Progress;
use crate::say::{self, count};
use dgd_export::{CsvOptions, McapOptions};
use dgd_recording::Table;
use serde_json::json;
use std::error::Error;
use std::io::{Seek, Write};
use std::path::Path;
use std::time::Instant;

pub(crate) fn run(arguments: &Convert, global: &Global) -> Result<String, Failure> {
    let started = Instant::now();
    let target = Target::of(&arguments.output, arguments.mat_v73)?;
    let progress = Progress::new(global);
    let (format, table) = load::read_table(&arguments.input, &progress)?;
    for issue in &table.issues {
        tracing::warn!("{}: {issue}", arguments.input.display());
    }
    progress.stage("writing", &arguments.output.display().to_string());
    let mut outputs = Outputs::new();
    outputs.add(&arguments.output, |writer| {
        target.write(&table, &arguments.root, writer)
    })?;
    outputs.keep()?;
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
    /// Writes a table; `root` is the name of the struct in MAT files.
    pub(crate) fn write(
        self,
        table: &Table,
        root: &str,
        writer: &mut (impl Write + Seek),
    ) -> Result<(), Box<dyn Error>> {
        match self {
            Self::Csv => dgd_export::write_csv(table, &CsvOptions::default(), writer)?,
            Self::Mcap => dgd_export::write_mcap(table, &McapOptions::default(), writer)?,
            Self::Mat5 => dgd_export::write_mat5(table, root, writer)?,
            Self::Mat73 => writer.write_all(&dgd_export::write_mat73(table, root)?)?,
        }
        Ok(())
    }

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
