//! `dgd convert`: a recording in another format.

use crate::args::{Convert, Global};
use crate::failure::Failure;
use crate::load;
use crate::output::Outputs;
use crate::progress::Progress;
use crate::say::{self, count};
use dgd_export::{CsvOptions, CsvWriter, McapOptions, McapWriter, struct_of};
use dgd_ingest::Format;
use dgd_recording::{Issue, Table};
use serde_json::json;
use std::error::Error;
use std::io::{Seek, Write};
use std::path::Path;
use std::time::Instant;

/// Bytes from which a recording is read and written block by block, which takes hardly longer.
const LONG: u64 = 64 << 20;

pub(crate) fn run(arguments: &Convert, global: &Global) -> Result<String, Failure> {
    let started = Instant::now();
    let target = Target::of(&arguments.output, arguments.mat_v73)?;
    let progress = Progress::new(global);
    let written = match in_blocks(arguments, target, &progress)? {
        Some(written) => written,
        None => whole(arguments, target, &progress)?,
    };
    let Written {
        format,
        issues,
        rows,
        columns,
    } = written;
    if global.json {
        return Ok(say::json(&json!({
            "schema": "dgd.convert/1",
            "input_format": format.to_string(),
            "output": arguments.output.display().to_string(),
            "rows": rows,
            "columns": columns,
            "issues": issues.iter().map(ToString::to_string).collect::<Vec<_>>(),
            "seconds": started.elapsed().as_secs_f64(),
        })));
    }
    Ok(format!(
        "{format} to {}: {} rows, {columns} columns\n",
        arguments.output.display(),
        count(rows)
    ))
}

/// What was written.
struct Written {
    /// Of the input.
    format: Format,
    issues: Vec<Issue>,
    rows: usize,
    columns: usize,
}

fn whole(arguments: &Convert, target: Target, progress: &Progress) -> Result<Written, Failure> {
    let (format, mut table) = load::read_table(&arguments.input, progress)?;
    warn_of(arguments, target, &table);
    if matches!(target, Target::Csv | Target::Mcap) {
        keep_rows(arguments, &mut table);
    }
    progress.stage("writing", &arguments.output.display().to_string());
    let mut outputs = Outputs::new();
    // A description of the one file then suits the other.
    let root = (arguments.root.as_deref()).or_else(|| struct_of(&table));
    outputs.add(&arguments.output, |writer| {
        target.write(&table, root.unwrap_or("recording"), writer)
    })?;
    outputs.keep()?;
    Ok(Written {
        format,
        rows: table.rows(),
        columns: table.columns.len(),
        issues: table.issues,
    })
}

/// The same, of which a block is in memory at a time; `None` where that cannot be.
fn in_blocks(
    arguments: &Convert,
    target: Target,
    progress: &Progress,
) -> Result<Option<Written>, Failure> {
    let when = load::When::of(arguments.in_blocks, LONG);
    if matches!(target, Target::Mat5 | Target::Mat73) {
        let why = format!(
            "{} cannot be written in blocks: a MAT file stores one column after another; name it .csv or .mcap",
            arguments.output.display()
        );
        let bytes = std::fs::metadata(&arguments.input).map_or(0, |input| input.len());
        when.say(bytes, &why);
        return Ok(None);
    }
    let Some(mut blocks) = load::open_blocks(&arguments.input, when, None, progress)? else {
        return Ok(None);
    };
    let head = blocks.head().clone();
    warn_of(arguments, target, &head);
    let mut options = McapOptions::default();
    if matches!(target, Target::Mcap) {
        options.time_tag = blocks.time_tag(progress)?;
    }
    progress.stage("writing", &arguments.output.display().to_string());
    let mut outputs = Outputs::new();
    outputs.add(&arguments.output, |writer| {
        match target {
            Target::Mcap => {
                let mut log = McapWriter::new(&head, &options, writer)?;
                blocks.each(|block| Ok::<_, Box<dyn Error>>(log.write(block)?))?;
                log.finish()?;
            }
            _ => {
                let mut text = CsvWriter::new(&head, &CsvOptions::default(), writer)?;
                blocks.each(|block| Ok::<_, Box<dyn Error>>(text.write(block)?))?;
                text.finish()?;
            }
        }
        Ok(())
    })?;
    outputs.keep()?;
    Ok(Some(Written {
        format: blocks.format(),
        rows: blocks.rows(),
        columns: head.columns.len(),
        issues: head.issues,
    }))
}

fn warn_of(arguments: &Convert, target: Target, table: &Table) {
    for issue in &table.issues {
        tracing::warn!("{}: {issue}", arguments.input.display());
    }
    if let (Some(origin), Target::Csv) = (&table.origin, target) {
        tracing::warn!(
            "{}: a CSV counts from 0 s and does not keep the date of 0 s, {origin}; MCAP and MAT do",
            arguments.output.display()
        );
    }
}

/// Takes columns of another length than the longest out of a table that becomes rows: in which of them their values belong, nothing says.
fn keep_rows(arguments: &Convert, table: &mut Table) {
    /// Columns that are named.
    const NAMED: usize = 5;
    let rows = table.rows();
    let clock = table.clock.map(|index| table.columns[index].tag.clone());
    let (kept, other): (Vec<_>, Vec<_>) = std::mem::take(&mut table.columns)
        .into_iter()
        .partition(|column| column.values.len() == rows);
    table.clock = kept.iter().position(|c| Some(&c.tag) == clock.as_ref());
    table.columns = kept;
    if other.is_empty() {
        return;
    }
    let named = other.iter().take(NAMED).map(|column| {
        let length = count(column.values.len());
        format!("`{}` of {length}", column.tag)
    });
    let more = match other.len().saturating_sub(NAMED) {
        0 => String::new(),
        more => format!(" and {more} more"),
    };
    tracing::warn!(
        "{}: left out, because the other columns have {} values and the rows of these are unknown: {}{more}; a MAT file keeps them",
        arguments.output.display(),
        count(rows),
        named.collect::<Vec<_>>().join(", ")
    );
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
                    "{}: the extension gives no format; name it .csv, .mcap or .mat",
                    path.display()
                ),
            }),
        }
    }
}
