//! A simulation of which a block is in memory at a time.

use super::outcome::Outcome;
use super::{Done, Job, LONG, as_table, warn_of_end};
use crate::args::Window;
use crate::commands::convert::Target;
use crate::commands::fit::screening;
use crate::failure::Failure;
use crate::figures::{self, Envelope};
use crate::load;
use crate::output::Outputs;
use crate::progress::Progress;
use dgd_documents::Base;
use dgd_export::{CsvOptions, CsvWriter, McapOptions, McapWriter};
use dgd_identify::Model;
use dgd_recording::Table;
use dgd_replay::{BlockReplay, Kind, Replay, ReplayError, ReplayOptions};
use std::error::Error;
use std::io::{Seek, Write};
use std::path::Path;

/// Runs in blocks; `None` where that cannot be, or the recording is short.
pub(super) fn run(job: &Job<'_>, progress: &Progress) -> Result<Option<Done>, Failure> {
    let arguments = job.arguments;
    let when = load::When::of(arguments.in_blocks, LONG);
    let model = match runs_in_blocks(job) {
        Ok(model) => model,
        Err(why) => {
            let recordings = job.source.recordings.iter();
            let sizes = recordings.filter_map(|path| std::fs::metadata(path).ok());
            when.say(sizes.map(|size| size.len()).sum(), &why);
            return Ok(None);
        }
    };
    let first = &job.source.recordings[0];
    let options = screening(job.source);
    let opened = load::open_screened(first, job.well, &options, when, progress)?;
    let Some(mut recording) = opened else {
        return Ok(None);
    };
    job.check_outputs()?;
    let warnings = recording.look_through(progress)?;
    progress.stage("simulating", "");
    let (samples, span_s) = (recording.samples(), recording.span_s());
    let refused = |e: ReplayError| load::refused(first, &e, job.source.window.as_ref());
    let line = model.return_line();
    let replay = |options: &ReplayOptions| {
        BlockReplay::new(&line, options, samples, span_s).map_err(refused)
    };
    let mut run = replay(&job.options)?;
    let mut drawings = Vec::new();
    if arguments.figures.is_some() {
        for kind in [Kind::Riser, Kind::Flow, Kind::Steady, Kind::Coupled] {
            let options = ReplayOptions {
                kind,
                ..job.options.clone()
            };
            let envelope = Envelope::new(in_window(job, samples, span_s));
            drawings.push((replay(&options)?, envelope));
        }
    }
    let mut outcome = Outcome::default();
    let mut outputs = Outputs::new();
    let mut runs = Vec::new();
    outputs.add(&arguments.out, |writer| {
        let mut rows = Rows::new(job.target, writer);
        recording.each(|block| {
            for (replay, envelope) in &mut drawings {
                envelope.add(&replay.add(block.clone()).map_err(refused)?);
            }
            let part = run.add(block).map_err(refused)?;
            outcome.add(&part);
            rows.write(&part)
        })?;
        let part = run.finish().map_err(refused)?;
        outcome.add(&part);
        rows.write(&part)?;
        for (replay, mut envelope) in drawings {
            envelope.add(&replay.finish().map_err(refused)?);
            runs.push(envelope.finish());
        }
        rows.finish()
    })?;
    warn_of_end(outcome.status);
    let mut drawn = Vec::new();
    if let (Some(folder), Ok(runs)) = (&arguments.figures, <[Replay; 4]>::try_from(runs)) {
        progress.stage("drawing", "figures");
        drawn = figures::draw_simulations(&mut outputs, folder, &runs)?;
    }
    outputs.keep()?;
    Ok(Some(Done {
        outcome,
        drawn,
        warnings,
        effects: None,
    }))
}

/// Samples of the window, or one or two more.
fn in_window(job: &Job<'_>, samples: usize, (start_s, end_s): (f64, f64)) -> usize {
    let (from_s, to_s) = job.options.window_s.unwrap_or((start_s, end_s));
    let share = (to_s.min(end_s) - from_s.max(start_s)) / (end_s - start_s);
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a share of a number of samples, and what is none becomes 0"
    )]
    let samples = (share.clamp(0.0, 1.0) * samples as f64).ceil() as usize;
    samples + 1
}

/// The model, or why it does not run in blocks.
fn runs_in_blocks<'a>(job: &'a Job<'_>) -> Result<&'a Model, String> {
    let recordings = &job.source.recordings;
    let shown = |path: &Path| path.display().to_string();
    if matches!(job.target, Target::Mat5 | Target::Mat73) {
        let output = shown(&job.arguments.out);
        return Err(format!(
            "{output} cannot be written in blocks: a MAT file stores one column after another; name it .csv or .mcap"
        ));
    }
    let whole = format!("{} is read in full", shown(&recordings[0]));
    if recordings.len() > 1 {
        return Err(format!(
            "{whole}: it is joined with the next recording; simulate them one by one"
        ));
    }
    if job.source.window.as_ref().is_some_and(Window::is_dated) {
        return Err(format!(
            "{whole}: the window is given by dates; give seconds of the clock"
        ));
    }
    if job.options.delay_s < 0.0 {
        return Err(format!(
            "{whole}: the flow meter of the model is ahead of the flow; fit it with --delays from 0"
        ));
    }
    match (&job.document.augmented, &job.document.base) {
        (None, Base::Identified(model)) => Ok(model),
        _ => Err(format!(
            "{whole}: a model with effects needs the whole recording; one written by `dgd fit` does not"
        )),
    }
}

/// Rows that are written as they come.
enum Rows<W: Write + Seek> {
    /// Which columns there are is known with the first rows.
    Waiting(Target, W),
    Csv(CsvWriter<W>),
    Mcap(Box<McapWriter<W>>),
    /// A row could not be written.
    Failed,
}

impl<W: Write + Seek> Rows<W> {
    fn new(target: Target, writer: W) -> Self {
        Self::Waiting(target, writer)
    }

    fn write(&mut self, part: &Replay) -> Result<(), Box<dyn Error>> {
        if part.time_s.is_empty() {
            return Ok(());
        }
        let table = as_table(part);
        *self = match std::mem::replace(self, Self::Failed) {
            Self::Waiting(target, writer) => Self::begin(target, &table, writer)?,
            begun => begun,
        };
        match self {
            Self::Csv(text) => text.write(&table)?,
            Self::Mcap(log) => log.write(&table)?,
            Self::Waiting(..) | Self::Failed => {}
        }
        Ok(())
    }

    fn begin(target: Target, table: &Table, writer: W) -> Result<Self, Box<dyn Error>> {
        if !matches!(target, Target::Mcap) {
            let options = CsvOptions::default();
            return Ok(Self::Csv(CsvWriter::new(table, &options, writer)?));
        }
        let options = McapOptions {
            time_tag: table.columns.first().map(|clock| clock.tag.clone()),
            ..McapOptions::default()
        };
        let log = McapWriter::new(table, &options, writer)?;
        Ok(Self::Mcap(Box::new(log)))
    }

    fn finish(self) -> Result<(), Box<dyn Error>> {
        match self {
            Self::Csv(text) => Ok(text.finish()?),
            Self::Mcap(log) => Ok(log.finish()?),
            Self::Waiting(..) | Self::Failed => Ok(()),
        }
    }
}
