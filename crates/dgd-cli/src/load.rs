//! Files in: recordings, wells, models.

mod blocks;
mod joined;
mod screened;

pub(crate) use blocks::{CONVERTED, When, open as open_blocks};
pub(crate) use screened::open as open_screened;

use crate::args::{Source, Window};
use crate::failure::Failure;
use crate::output;
use crate::progress::Progress;
use crate::say;
use dgd_documents::{DocumentError, ModelDocument, Problem};
use dgd_identify::Model;
use dgd_ingest::{Format, ReadOptions};
use dgd_recording::{
    Channel, Events, Issue, IssueKind, Moment, Recording, RecordingError, Settle, Table,
    TimeSource, Well, survey,
};
use dgd_replay::ReplayError;
use dgd_screen::{ScreenOptions, Suspicion};
use dgd_units::Unit;
use joined::{Joint, Taken, UNDATED};
use std::fs::File;
use std::io::Read;
use std::ops::{Deref, Range};
use std::path::{Path, PathBuf};
use std::time::SystemTime;
use tracing::{debug, warn};

/// A recording on its even clock, and what was met on the way.
pub(crate) struct Loaded {
    pub(crate) recording: Recording,
    pub(crate) step_s: f64,
    pub(crate) formats: Vec<Format>,
    pub(crate) issues: Vec<(PathBuf, Issue)>,
    /// What the recordings make unlikely in the well description, with the line.
    pub(crate) suspicions: Vec<String>,
    /// Samples in the files, without those that fill gaps and seams of the even clock and those that repeat a time stamp.
    pub(crate) samples: usize,
    /// Where each recording after the first begins, s of the clock.
    pub(crate) begins: Vec<(PathBuf, f64)>,
    /// When the clock was at 0, or what keeps its times from being told in dates.
    dates: Result<Moment, &'static str>,
    /// What has been warned of while reading, and whoever reads the answer must know as well.
    pub(crate) told: Vec<String>,
}

/// A well description with its text, so that a warning can name the line.
pub(crate) struct Described {
    well: Well,
    path: PathBuf,
    text: String,
}

impl Deref for Described {
    type Target = Well;

    fn deref(&self) -> &Well {
        &self.well
    }
}

/// Reads a file whole; recordings are decoded from memory in one pass.
pub(crate) fn read_bytes(path: &Path, progress: &Progress) -> Result<Vec<u8>, Failure> {
    let file = File::open(path).map_err(|e| Failure::read(path, &e))?;
    output::protect(path);
    let size = file.metadata().map(|m| m.len()).unwrap_or(0);
    if file.metadata().is_ok_and(|m| m.is_dir()) {
        return Err(Failure::input(
            path,
            "is a folder; name the recording in it",
        ));
    }
    progress.stage("reading", &path.display().to_string());
    debug!(size, "reading {}", path.display());
    read_steady(path, &file, &file)
}

/// Reads to the end, and refuses what somebody wrote into meanwhile: half of it would be of one file, half of another.
fn read_steady(path: &Path, mut reader: impl Read, file: &File) -> Result<Vec<u8>, Failure> {
    let before = State::of(file);
    let mut bytes = Vec::new();
    (reader.read_to_end(&mut bytes)).map_err(|e| Failure::read(path, &e))?;
    State::compare(path, before, State::of(file))?;
    Ok(bytes)
}

/// What tells that a file was written into.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct State {
    length: u64,
    modified: Option<SystemTime>,
}

impl State {
    /// `None` of pipes and devices, which have no state to compare.
    fn of(file: &File) -> Option<Self> {
        let metadata = file.metadata().ok().filter(std::fs::Metadata::is_file)?;
        Some(Self {
            length: metadata.len(),
            modified: metadata.modified().ok(),
        })
    }

    fn compare(path: &Path, before: Option<Self>, after: Option<Self>) -> Result<(), Failure> {
        if before == after {
            return Ok(());
        }
        let [from, to] = [before, after].map(|s| s.map_or(0, |s| s.length));
        let sizes = if from == to {
            String::new()
        } else {
            format!(" (from {from} to {to} bytes)")
        };
        Err(Failure::Input {
            path: path.to_owned(),
            reason: format!("changed while it was read{sizes}"),
            help: Some("wait until it is complete, or read a copy of it".into()),
        })
    }
}

/// Reads a text document.
pub(crate) fn read_text(path: &Path) -> Result<String, Failure> {
    let file = File::open(path).map_err(|e| Failure::read(path, &e))?;
    output::protect(path);
    let bytes = read_steady(path, &file, &file)?;
    String::from_utf8(bytes).map_err(|e| {
        let at = e.utf8_error().valid_up_to();
        Failure::input(
            path,
            format!("is not UTF-8 text at byte {at}; save it as UTF-8"),
        )
    })
}

/// Reads a table of any format.
pub(crate) fn read_table(path: &Path, progress: &Progress) -> Result<(Format, Table), Failure> {
    let bytes = read_bytes(path, progress)?;
    progress.stage("decoding", &path.display().to_string());
    let name = path.file_name().map(|n| n.to_string_lossy().into_owned());
    let options = ReadOptions { name_hint: name };
    dgd_ingest::read(&bytes, &options).map_err(|e| Failure::input(path, e))
}

/// Reads `well.toml`, telling of keys that nobody reads.
pub(crate) fn read_well(path: &Path) -> Result<Described, Failure> {
    let text = read_text(path)?;
    let read = dgd_documents::read_well(&text);
    let well = told(path, text.clone(), read)?;
    Ok(Described {
        well,
        path: path.to_owned(),
        text,
    })
}

/// Reads `model.toml` with the effects it may hold, telling of keys that nobody reads.
pub(crate) fn read_model(path: &Path) -> Result<ModelDocument, Failure> {
    let source = read_text(path)?;
    let read = dgd_documents::read_model_document(&source);
    told(path, source, read)
}

/// Reads the two-state model of `model.toml`; one with effects is refused.
pub(crate) fn read_base_model(path: &Path) -> Result<Model, Failure> {
    let source = read_text(path)?;
    let read = dgd_documents::read_model(&source);
    told(path, source, read)
}

/// Warns of what was not read, or shows what is wrong.
fn told<T>(
    path: &Path,
    source: String,
    read: Result<(T, Vec<Problem>), DocumentError>,
) -> Result<T, Failure> {
    match read {
        Ok((value, warnings)) => {
            for problem in warnings {
                let (line, _) = dgd_documents::line_and_column(&source, problem.span.start);
                warn!("{}:{line}: {}", path.display(), problem.message);
            }
            Ok(value)
        }
        Err(error) => Err(Failure::Document {
            path: path.to_owned(),
            source,
            error,
        }),
    }
}

/// Warns of issues of files, and gives what whoever reads the answer must know as well: units that a file contradicts, readings that were left out, and
/// words for a pump that rests in a column that is used.
fn warn_of<'a>(well: &Well, issues: impl Iterator<Item = (&'a Path, &'a Issue)>) -> Vec<String> {
    let tags = well.channels.tags();
    let is_used = |place: &str| {
        let mut columns = tags
            .iter()
            .flat_map(|(_, tag)| [format!("`{tag}`"), format!(".{tag}`")]);
        columns.any(|column| place.ends_with(&column))
    };
    let mut told = Vec::new();
    for (path, issue) in issues {
        let warning = format!("{}: {issue}", path.display());
        warn!("{warning}");
        let matters = match issue.kind {
            IssueKind::UnitDisagrees | IssueKind::Stray => true,
            IssueKind::WordForZero => is_used(&issue.place),
            _ => false,
        };
        if matters {
            told.push(warning);
        }
    }
    told
}

/// Adds what is suspected: one line of the description is told once, however often it shows.
fn once(suspected: &mut Vec<Suspicion>, found: Vec<Suspicion>) {
    for suspicion in found {
        if suspected.iter().all(|s| s.place != suspicion.place) {
            suspected.push(suspicion);
        }
    }
}

/// Reads one or more consecutive recordings of a well onto one even clock.
///
/// Recordings with dates stand as far apart as they were taken, unless that were mostly nothing; others 120 s.
pub(crate) fn read_recordings(
    paths: &[PathBuf],
    well: &Described,
    progress: &Progress,
) -> Result<Loaded, Failure> {
    let mut loaded: Option<Loaded> = None;
    let mut suspected: Vec<Suspicion> = Vec::new();
    let mut joint = Joint::default();
    let mut units = Units::default();
    let mut warnings: Vec<String> = Vec::new();
    for (index, path) in paths.iter().enumerate() {
        let (format, mut table) = read_table(path, progress)?;
        let mut issues = std::mem::take(&mut table.issues);
        units.check(path, &table, well)?;
        warnings.extend(well.contradicted(path, &table));
        let began = table.began(&well.channels.time);
        let taken = Taken {
            path,
            began,
            first_stamp_s: table.first_stamp_s(&well.channels.time),
        };
        let (recording, mapping) =
            Recording::from_table(table, well).map_err(|e| well.unmapped(path, &e, &issues))?;
        let rows = recording.len();
        let (mut recording, step_s, clock) =
            recording.onto_grid().map_err(|e| Failure::input(path, e))?;
        Settle::default().add(&mut recording);
        if recording.has_few_readings() {
            let options = ScreenOptions::default();
            let strays = dgd_screen::blank_strays(&mut recording, step_s, &options);
            let strays = strays.map_err(|e| Failure::input(path, e))?;
            issues.extend(strays.into_iter().map(of_strays));
            warnings.extend((recording.join_events(step_s)).map(|events| by_events(path, events)));
        }
        // Rows that lie on one step, or on none, are no samples of their own.
        let samples = if clock.is_empty() {
            rows
        } else {
            recording.recorded()
        };
        issues.extend(mapping.into_iter().chain(clock));
        let found = dgd_screen::suspect(&recording, step_s, well);
        once(&mut suspected, found.map_err(|e| Failure::input(path, e))?);
        let issues: Vec<_> = issues
            .into_iter()
            .map(|issue| (path.clone(), issue))
            .collect();
        match &mut loaded {
            None => {
                joint = Joint::of(taken, &recording);
                loaded = Some(Loaded {
                    recording,
                    step_s,
                    formats: vec![format],
                    issues,
                    suspicions: Vec::new(),
                    samples,
                    begins: Vec::new(),
                    dates: began.ok_or(UNDATED),
                    told: Vec::new(),
                });
            }
            Some(all) => {
                if (step_s - all.step_s).abs() > 1e-6 * all.step_s {
                    let first = paths[0].display();
                    let reason = format!(
                        "is sampled every {step_s} s, {first} every {} s; fit them one by one",
                        all.step_s
                    );
                    return Err(Failure::input(path, reason));
                }
                let before = all.recording.len();
                let left_out = joint.append(&mut all.recording, recording, step_s, taken)?;
                let begin_s = all.recording.time_s.get(before).copied();
                all.begins.extend(begin_s.map(|s| (path.clone(), s)));
                if began.is_none() && left_out == 0 && paths[..index].contains(path) {
                    warn!("{} is given twice: its samples count twice", path.display());
                }
                all.samples += samples.saturating_sub(left_out);
                all.formats.push(format);
                all.issues.extend(issues);
            }
        }
    }
    let issues = loaded.iter().flat_map(|l| &l.issues);
    let disagreeing = warn_of(well, issues.map(|(path, issue)| (path.as_path(), issue)));
    let mut loaded = loaded.ok_or_else(|| Failure::Arguments {
        reason: "no recording was given".into(),
    })?;
    if let Some(keeps) = joint.keeps_dates() {
        loaded.dates = Err(keeps);
    }
    loaded.told = joint.into_warnings();
    loaded.told.extend(disagreeing);
    loaded.suspicions = suspected.iter().map(|s| well.pointing(s)).collect();
    loaded.suspicions.extend(warnings);
    Ok(loaded)
}

/// What is said of readings of a channel that stand alone.
fn of_strays((channel, count): (Channel, usize)) -> Issue {
    Issue {
        kind: IssueKind::Stray,
        place: format!("`{channel}`"),
        message: format!(
            "{} far off those before and after; left out",
            say::counted(count, "reading")
        ),
    }
}

/// What is said of a recording whose channels were filed by events.
fn by_events(path: &Path, events: Events) -> String {
    let (least, most) = events.shares;
    let (path, channels) = (path.display(), events.channels);
    let shares = format!("{:.1} to {:.0} %", 100.0 * least, 100.0 * most);
    if events.of_all_changes {
        return format!(
            "{path}: its {channels} channels have readings at {shares} of the samples, hardly one of them equal to the one before: each is taken to stand until the next"
        );
    }
    format!(
        "{path}: its {channels} channels have readings at {shares} of the samples, at times of their own, as an archive files them. Straight lines are drawn \
         between them, and inflows and pump speed stand for longer than a minute as they were filed: this can produce false causes; confirm any finding on an export \
         with all readings"
    )
}

/// The units that the files of one job give their columns.
#[derive(Default)]
struct Units {
    /// Of each column, with the first file that tells it.
    of: Vec<(String, String, PathBuf)>,
}

impl Units {
    /// Refuses a file whose channels are in other units than those of the files before it: one description cannot suit both.
    fn check(&mut self, path: &Path, table: &Table, well: &Well) -> Result<(), Failure> {
        let units = well.channels.tags().into_iter().filter_map(|(_, tag)| {
            let unit = table.column(tag)?.unit.as_deref()?;
            Some((tag, unit, Unit::parse(unit).ok()?))
        });
        for (tag, unit, read) in units {
            let Some((_, before, first)) = self.of.iter().find(|(known, ..)| known == tag) else {
                self.of
                    .push((tag.to_owned(), unit.to_owned(), path.to_owned()));
                continue;
            };
            if Unit::parse(before).ok() != Some(read) {
                return Err(Failure::input(
                    path,
                    format!(
                        "column `{tag}` is in {unit} here but in {before} in {}: one description cannot fit both; convert one of them",
                        first.display()
                    ),
                ));
            }
        }
        Ok(())
    }
}

/// What is said where seconds were hardly meant.
const HOURS: &str = "for hours write 3h:5h";

/// A replay that was refused; of a window in seconds that holds nothing it says how hours are written.
pub(crate) fn refused(path: &Path, error: &ReplayError, window: Option<&Window>) -> Failure {
    let outside = matches!(error, ReplayError::Window { .. });
    let in_seconds = window.is_some_and(|window| !window.is_dated());
    Failure::Input {
        path: path.to_owned(),
        reason: error.to_string(),
        help: (outside && in_seconds).then(|| HOURS.to_owned()),
    }
}

/// Samples of a window of the clock, all if there is none.
pub(crate) fn window(
    recording: &Recording,
    window_s: Option<(f64, f64)>,
) -> Result<Range<usize>, ReplayError> {
    let time_s = &recording.time_s;
    let (start_s, end_s) = (
        time_s.first().copied().unwrap_or(0.0),
        time_s.last().copied().unwrap_or(0.0),
    );
    let (from_s, to_s) = window_s.unwrap_or((start_s, end_s));
    let kept = recording.between(from_s, to_s);
    if kept.len() >= 2 {
        return Ok(kept);
    }
    Err(ReplayError::Window {
        from_s,
        to_s,
        samples: kept.len(),
        start_s,
        end_s,
    })
}

impl Loaded {
    /// Keeps the window that was asked for; stamps stay as they are.
    pub(crate) fn within(mut self, source: &Source) -> Result<Self, Failure> {
        let Some(asked_for) = self.window_s(source)? else {
            return Ok(self);
        };
        let kept = window(&self.recording, Some(asked_for))
            .map_err(|e| Failure::input(&source.recordings[0], e))?;
        self.recording = self.recording.slice(kept.clone());
        // Fillers of gaps hold no value.
        self.samples = self.recording.recorded();
        Ok(self)
    }

    /// The window that is asked for, s of the clock: it holds samples.
    pub(crate) fn window_s(&self, source: &Source) -> Result<Option<(f64, f64)>, Failure> {
        /// A window of fewer seconds was hardly meant in seconds, s.
        const SHORT_S: f64 = 60.0;
        let Some(asked_for) = &source.window else {
            return Ok(None);
        };
        let path = &source.recordings[0];
        let began = self.dated_from();
        let (from_s, to_s) = asked_for
            .seconds(self.dates)
            .map_err(|e| Failure::input(path, e))?;
        match window(&self.recording, Some((from_s, to_s))) {
            Ok(kept) => {
                let short = to_s - from_s < SHORT_S && kept.len() < self.recording.len();
                if short && !asked_for.is_dated() {
                    warn!("--window {asked_for} is {} s long; {HOURS}", to_s - from_s);
                }
                Ok(Some((from_s, to_s)))
            }
            Err(error) => Err(Failure::Input {
                path: path.clone(),
                reason: error.to_string(),
                help: Some(match began.filter(|_| asked_for.is_dated()) {
                    Some(began) => self.in_dates(began, asked_for),
                    None => HOURS.to_owned(),
                }),
            }),
        }
    }

    /// What the recording spans, for who asked by dates for what it does not hold.
    fn in_dates(&self, began: Moment, asked_for: &Window) -> String {
        let time_s = &self.recording.time_s;
        let ends = [time_s.first(), time_s.last()].map(|end| {
            let at = end.and_then(|end| began.after(*end));
            at.map_or_else(|| "?".to_owned(), |at| at.local())
        });
        let zone = if began.zoned && !asked_for.is_zoned() {
            "; dates without a zone are read as UTC, the zone of this recording's time stamps"
        } else {
            ""
        };
        format!("it spans {} to {}{zone}", ends[0], ends[1])
    }

    /// When the clock was at 0, where all its times become dates by that.
    pub(crate) fn dated_from(&self) -> Option<Moment> {
        self.dates.ok()
    }

    /// Warns of what is suspected, before anything is made of it.
    pub(crate) fn warn_of_suspicions(&self) {
        for suspicion in &self.suspicions {
            warn!("{suspicion}");
        }
    }
}

impl Described {
    /// A recording that the channel map does not fit, with the line of the map; a column that the reader passed over is there, and
    /// its issue says why it was.
    fn unmapped(&self, recording: &Path, error: &RecordingError, issues: &[Issue]) -> Failure {
        let channels: Vec<&str> = match error {
            RecordingError::NoColumn { absent, .. } => {
                absent.iter().map(|a| a.channel.as_str()).collect()
            }
            RecordingError::SharedColumn { second, .. } => vec![second],
            _ => Vec::new(),
        };
        let lines: Vec<String> = (channels.iter())
            .filter_map(|channel| {
                // `pump_inlet_pressure 2` is the second of its list.
                let (key, number) = channel.split_once(' ').unwrap_or((channel, ""));
                let transmitter = number.parse().ok().and_then(|n: usize| n.checked_sub(1));
                dgd_documents::well_line(&self.text, "channels", key, transmitter)
            })
            .map(|line| line.to_string())
            .collect();
        let description = self.path.display();
        let passed_over = match error {
            RecordingError::NoColumn { absent, .. } => {
                let of = |issue: &&Issue| {
                    let (_, column) = issue.place.rsplit_once("column `")?;
                    let column = column.trim_end_matches('`');
                    let last = column.rsplit('.').next();
                    let mut tags = absent.iter().map(|a| a.tag.as_str());
                    tags.find(|tag| *tag == column || Some(*tag) == last)
                };
                let mut skipped = issues.iter().filter(|i| i.kind == IssueKind::Skipped);
                skipped.find(|issue| of(issue).is_some())
            }
            _ => None,
        };
        Failure::Input {
            path: recording.to_owned(),
            reason: passed_over
                .map_or_else(|| error.to_string(), |told| format!("{told}; {error}")),
            help: match lines.as_slice() {
                [] => None,
                [line] => Some(format!("it is mapped in {description}, line {line}")),
                lines => Some(format!(
                    "they are mapped in {description}, lines {}",
                    lines.join(", ")
                )),
            },
        }
    }

    /// A warning where the samples are said to be evenly apart, and the file has a clock that says otherwise.
    fn contradicted(&self, path: &Path, table: &Table) -> Option<String> {
        let TimeSource::Interval { step_s } = self.channels.time else {
            return None;
        };
        let found = survey(table);
        let column = &table.columns[found.time_column?];
        let step = found.clock?.ok()?.step_s;
        let unit = column.unit.as_deref().and_then(|u| Unit::parse(u).ok());
        let told_s = unit.map_or(step, |unit| unit.to_si(step));
        if (0.99..1.01).contains(&(told_s / step_s)) {
            return None;
        }
        let said = format!(
            "the samples of {} are taken to be {step_s} s apart, but its column `{}` gives {told_s:.6} s",
            path.file_name()
                .unwrap_or(path.as_os_str())
                .to_string_lossy(),
            column.tag
        );
        let line = dgd_documents::well_line(&self.text, "channels", "time", None);
        Some(self.told(line, &said))
    }

    /// A suspicion with the line that it is about.
    pub(crate) fn pointing(&self, suspicion: &Suspicion) -> String {
        let place = suspicion.place;
        let at = dgd_documents::well_line(&self.text, place.section, place.key, place.transmitter);
        self.told(at, &suspicion.to_string())
    }

    /// What is said of a line of the description.
    fn told(&self, line: Option<usize>, said: &str) -> String {
        // The name without its folder: reports travel, folders do not.
        let name = self.path.file_name().unwrap_or(self.path.as_os_str());
        let name = name.to_string_lossy();
        match line {
            Some(line) => format!("{name}:{line}: {said}"),
            None => format!("{name}: {said}"),
        }
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test may fail by panic")]
mod tests {
    use super::*;
    use std::io::Write;

    /// Writes into the file before the first bytes are read.
    struct Meddled<'a> {
        file: &'a File,
        by: &'a [u8],
    }

    impl Read for Meddled<'_> {
        fn read(&mut self, into: &mut [u8]) -> std::io::Result<usize> {
            if !self.by.is_empty() {
                self.file.write_all(self.by)?;
                self.by = &[];
            }
            self.file.read(into)
        }
    }

    #[test]
    fn a_file_that_grows_while_it_is_read_is_refused_with_both_sizes() {
        let mut file = tempfile::tempfile().unwrap();
        file.write_all(b"t,q\n0,1\n").unwrap();
        let meddled = Meddled {
            file: &file,
            by: b"1,2\n",
        };
        let failed = read_steady(Path::new("rig.csv"), meddled, &file).unwrap_err();
        assert_eq!(failed.status(), 2);
        let said = failed.to_string();
        for part in ["rig.csv", "changed while it was read", "8 to 12", "copy"] {
            assert!(said.contains(part), "{said}");
        }
    }

    #[test]
    fn a_file_that_is_left_alone_is_read_whole() {
        let mut file = tempfile::tempfile().unwrap();
        file.write_all(b"t,q\n0,1\n").unwrap();
        std::io::Seek::rewind(&mut file).unwrap();
        let bytes = read_steady(Path::new("rig.csv"), &file, &file).unwrap();
        assert_eq!(bytes, b"t,q\n0,1\n");
    }

    #[test]
    fn a_file_written_over_at_the_same_length_is_refused_by_its_time() {
        let mut file = tempfile::tempfile().unwrap();
        file.write_all(b"t,q\n0,1\n").unwrap();
        let long_ago = std::time::SystemTime::UNIX_EPOCH;
        file.set_modified(long_ago).unwrap();
        std::io::Seek::rewind(&mut file).unwrap();
        let meddled = Meddled {
            file: &file,
            by: b"t,q\n9,1\n",
        };
        let failed = read_steady(Path::new("rig.csv"), meddled, &file).unwrap_err();
        assert!(failed.to_string().contains("read\n"), "{failed}");
    }
}
