//! A table's columns under the channel map of a well.

use super::{Channel, Recording};
use crate::survey_clock;
use crate::table::earliest;
use crate::{
    ChannelError, ChannelMap, ChannelSource, ClockError, Issue, IssueKind, Table, TimeSource, Well,
};
use dgd_units::{Dimension, PressureReference, Unit};
use rayon::prelude::*;

/// Why a table and a well description do not make a recording.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum RecordingError {
    /// Columns that the well description names are not in the file.
    #[error("channel {}; it has {present}", told(absent))]
    NoColumn {
        /// Every channel without its column, in the order of the description; one at least.
        absent: Vec<Absent>,
        /// Tags in the file, shortened.
        present: String,
    },
    /// A channel whose description is refused.
    #[error(transparent)]
    Channel(#[from] ChannelError),
    /// Columns of unequal length.
    #[error("tag `{tag}` has {found} samples, expected {expected} to match the time")]
    Length {
        /// The odd column.
        tag: String,
        /// Its length.
        found: usize,
        /// Length of the time column.
        expected: usize,
    },
    /// Two channels share one column.
    #[error("tag `{tag}` is mapped to both `{first}` and `{second}`")]
    SharedColumn {
        /// The column.
        tag: String,
        /// First channel.
        first: String,
        /// Second channel.
        second: String,
    },
    /// Rows that come in blocks do not reach as far as a channel's stamps are off.
    #[error("`{channel}` has its own clock: its recording must be read in full")]
    OffClock {
        /// The first such channel.
        channel: Channel,
    },
    /// Rows were to be put on a clock that has not been found yet.
    #[error(
        "the clock is not known yet: all stamps must be gone through before rows are put on it"
    )]
    NoClockYet,
    /// Rows that come in blocks are not in the order of their stamps.
    #[error("the rows are not in the order of their stamps: the recording must be read in full")]
    OutOfOrder,
    /// No samples.
    #[error("the recording has no samples")]
    Empty,
    /// A series that is not as long as the clock.
    #[error(transparent)]
    Unequal(#[from] Unequal),
    /// The step of a clock without stamps is no step.
    #[error("the step of the clock is {step_s} s, expected a positive number")]
    Step {
        /// The step given, s.
        step_s: f64,
    },
    /// Most of two recordings joined would hold nothing.
    #[error("{seam} samples without values between recordings of {samples} samples together")]
    Seam {
        /// Samples without values.
        seam: usize,
        /// Samples of both.
        samples: usize,
    },
    /// The clock is beyond use.
    #[error(transparent)]
    Clock(#[from] ClockError),
}

/// A channel whose column is not in the file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Absent {
    /// Channel name in the well description.
    pub channel: String,
    /// Tag looked for.
    pub tag: String,
    /// A tag of the file that differs in little, if there is just one.
    pub near: Option<String>,
}

fn told(absent: &[Absent]) -> String {
    let mut told = String::new();
    for (nth, Absent { channel, tag, near }) in absent.iter().enumerate() {
        told += &match nth {
            0 => format!(
                "`{channel}` is mapped to the tag `{tag}`, which the recording does not have"
            ),
            _ => format!(", nor `{tag}` of `{channel}`"),
        };
        if let Some(near) = near {
            told += &format!(" (did you mean `{near}`?)");
        }
    }
    told
}

impl RecordingError {
    /// Refuses a step that is none.
    pub(crate) fn unless_step(step_s: f64) -> Result<(), Self> {
        if step_s.is_finite() && step_s > 0.0 {
            return Ok(());
        }
        Err(Self::Step { step_s })
    }
}

/// A series that is not as long as its clock.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("`{channel}` has {found} samples, expected {expected} to match the time")]
pub struct Unequal {
    /// Whose series it is.
    pub channel: Channel,
    /// Its length.
    pub found: usize,
    /// Length of the time.
    pub expected: usize,
}

/// Where the clock of rows begins that follow others.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Origin {
    /// The first stamp that there is, s.
    first_s: Option<f64>,
    /// Rows before.
    rows: usize,
    /// Whether all rows come at once: the earliest stamp counts then, which rows in another order do not begin with.
    whole: bool,
}

impl Origin {
    /// Of a recording in one piece.
    pub(crate) fn whole() -> Self {
        Self {
            whole: true,
            ..Self::default()
        }
    }

    /// Stamps in the file's unit to seconds from the start: epoch seconds would cost every later step its digits.
    pub(crate) fn shift(&mut self, stamps: &mut [f64], unit: Unit) {
        let whole = self.whole;
        let first = || {
            let first = if whole {
                earliest(stamps)
            } else {
                stamps.iter().copied().find(|t| t.is_finite())
            };
            first.map(|t| unit.to_si(t)).filter(|t| t.is_finite())
        };
        self.first_s = self.first_s.or_else(first);
        let first_s = self.first_s.unwrap_or(0.0);
        (stamps.iter_mut()).for_each(|t| *t = unit.to_si(*t) - first_s);
        self.rows += stamps.len();
    }

    /// Stamps of so many rows where the file has none, s.
    pub(crate) fn even(&mut self, rows: usize, step_s: f64) -> Vec<f64> {
        let from = self.rows;
        self.rows += rows;
        (from..self.rows).map(|i| i as f64 * step_s).collect()
    }
}

/// The tags of a map that a table does not have, if there are any.
fn absent(table: &Table, map: &ChannelMap) -> Option<RecordingError> {
    let mut tags: Vec<(String, &str)> = Vec::new();
    if let TimeSource::Column { tag, .. } = &map.time {
        tags.push(("time".to_owned(), tag));
    }
    let channels = map.tags().into_iter();
    tags.extend(channels.map(|(channel, tag)| (channel.to_string(), tag)));
    let absent: Vec<Absent> = (tags.into_iter())
        .filter(|(_, tag)| table.find(tag).is_none())
        .map(|(channel, tag)| Absent {
            channel,
            tag: tag.to_owned(),
            near: near(table, tag),
        })
        .collect();
    (!absent.is_empty()).then(|| RecordingError::NoColumn {
        absent,
        present: self::tags(table),
    })
}

/// Takes columns out of a table without copying them.
struct Columns {
    table: Table,
    taken: Vec<Option<String>>,
    rows: usize,
    issues: Vec<Issue>,
    /// Of each channel taken, in order; `None` for SI.
    units: Vec<Option<Unit>>,
    /// Of each channel taken, s.
    late_s: Vec<f64>,
}

impl Columns {
    fn find(&self, channel: &str, tag: &str) -> Result<usize, RecordingError> {
        self.table
            .find(tag)
            .ok_or_else(|| RecordingError::NoColumn {
                absent: vec![Absent {
                    channel: channel.into(),
                    tag: tag.into(),
                    near: near(&self.table, tag),
                }],
                present: tags(&self.table),
            })
    }

    /// The column as it is in the file.
    fn take(&mut self, channel: &str, tag: &str, unit: Unit) -> Result<Vec<f64>, RecordingError> {
        let index = self.find(channel, tag)?;
        if let Some(first) = &self.taken[index] {
            return Err(RecordingError::SharedColumn {
                tag: tag.into(),
                first: first.clone(),
                second: channel.into(),
            });
        }
        self.taken[index] = Some(channel.to_owned());
        let column = &mut self.table.columns[index];
        if let Some(issue) = disagreement(channel, column.unit.as_deref(), unit) {
            self.issues.push(issue);
        }
        Ok(std::mem::take(&mut column.values))
    }

    /// A channel's series, as it is in the file; `units` tells what it is in.
    fn source(
        &mut self,
        channel: Channel,
        source: &ChannelSource,
    ) -> Result<Vec<f64>, RecordingError> {
        self.late_s.push(source.late_s());
        match source {
            ChannelSource::Constant { si } => {
                self.units.push(None);
                Ok(vec![*si; self.rows])
            }
            ChannelSource::Column {
                tag, unit, added, ..
            } => {
                let mut values = self.whole(channel, tag, *unit)?;
                if added.is_empty() {
                    self.units.push(Some(*unit));
                    return Ok(values);
                }
                self.units.push(None);
                unit.column_to_si(&mut values);
                for one in added {
                    let further = self.whole(channel, &one.tag, one.unit)?;
                    let further = further.into_iter().map(|value| one.unit.to_si(value));
                    values.iter_mut().zip(further).for_each(|(v, f)| *v += f);
                }
                Ok(values)
            }
        }
    }

    /// A channel's column, which must be as long as the clock.
    fn whole(
        &mut self,
        channel: Channel,
        tag: &str,
        unit: Unit,
    ) -> Result<Vec<f64>, RecordingError> {
        let values = self.take(&channel.to_string(), tag, unit)?;
        if values.len() == self.rows {
            return Ok(values);
        }
        Err(RecordingError::Length {
            tag: tag.to_owned(),
            found: values.len(),
            expected: self.rows,
        })
    }

    /// Redundant transmitters of one place.
    fn sources(
        &mut self,
        channel: fn(usize) -> Channel,
        sources: &[ChannelSource],
    ) -> Result<Vec<Vec<f64>>, RecordingError> {
        let numbered = sources.iter().enumerate();
        numbered
            .map(|(n, source)| self.source(channel(n), source))
            .collect()
    }
}

/// The well description's unit wins; a unit in the file that says otherwise is told,
/// unless it only leaves open what the description says (`psi` for `psia`).
fn disagreement(channel: &str, in_file: Option<&str>, described: Unit) -> Option<Issue> {
    let written = in_file?;
    let found = Unit::parse(written).ok()?;
    let same_scale = found.dimension == described.dimension && found.factor == described.factor;
    let reference_open = matches!(
        (found.pressure_reference, described.pressure_reference),
        (Some(PressureReference::Unstated), _) | (_, Some(PressureReference::Unstated))
    );
    // A tachometer in percent of its full reading keeps its symbol, and so do strokes; `1/min` is `rpm` and `spm`.
    let turns = Unit::parse_as(described.symbol, Dimension::RotationalSpeed);
    let of_turns = described.dimension != found.dimension
        && turns.is_ok_and(|turns| {
            found.dimension == Dimension::RotationalSpeed && found.factor == turns.factor
        });
    if of_turns || same_scale && (found.offset == described.offset || reference_open) {
        return None;
    }
    Some(Issue {
        kind: IssueKind::UnitDisagrees,
        place: channel.to_owned(),
        message: format!(
            "the file gives `{written}`, the well description `{described}`; the description was used"
        ),
    })
}

/// The one tag that is `tag` but for case, marks and what stands before or after it.
fn near(table: &Table, tag: &str) -> Option<String> {
    let plain = |tag: &str| -> String {
        // Structs and groups before the name are no part of it.
        let last = tag.rsplit('.').next().unwrap_or(tag);
        let letters = last.chars().filter(|c| c.is_alphanumeric());
        letters.flat_map(char::to_lowercase).collect()
    };
    let wanted = plain(tag);
    let alike = |found: &str| {
        let found = plain(found);
        // Two letters are part of many a name.
        let part = |a: &str, b: &str| b.chars().count() > 2 && a.contains(b);
        found == wanted || part(&found, &wanted) || part(&wanted, &found)
    };
    let mut found = (table.columns.iter().map(|c| c.tag.as_str())).filter(|tag| alike(tag));
    let first = found.next()?;
    found.next().is_none().then(|| first.to_owned())
}

fn tags(table: &Table) -> String {
    const SHOWN: usize = 24;
    let mut names: Vec<&str> = table
        .columns
        .iter()
        .take(SHOWN)
        .map(|c| c.tag.as_str())
        .collect();
    let more = format!("and {} more", table.columns.len().saturating_sub(SHOWN));
    if table.columns.len() > SHOWN {
        names.push(&more);
    }
    names.join(", ")
}

impl Recording {
    /// Joins a file's columns with the well's channel map; columns are moved, not copied.
    ///
    /// Returns the recording on the file's own clock, and the issues found on the way.
    ///
    /// # Errors
    /// [`RecordingError`] if a channel is refused by [`ChannelMap::check`], a mapped column is missing, of another length or
    /// mapped twice, or the interval of a clock without stamps is no positive number.
    pub fn from_table(table: Table, well: &Well) -> Result<(Self, Vec<Issue>), RecordingError> {
        well.channels.check()?;
        Self::from_rows(table, well, &mut Origin::whole())
    }

    /// [`Self::from_table`] of rows that follow others.
    pub(crate) fn from_rows(
        table: Table,
        well: &Well,
        origin: &mut Origin,
    ) -> Result<(Self, Vec<Issue>), RecordingError> {
        let map = &well.channels;
        if let Some(error) = absent(&table, map) {
            return Err(error);
        }
        let taken = vec![None; table.columns.len()];
        let mut columns = Columns {
            rows: 0,
            taken,
            table,
            issues: Vec::new(),
            units: Vec::new(),
            late_s: Vec::new(),
        };
        let time_s = match &map.time {
            TimeSource::Column { tag, unit } => {
                let index = columns.find("time", tag)?;
                let unit = columns.table.time_unit(index, *unit);
                let mut time_s = columns.take("time", tag, unit)?;
                origin.shift(&mut time_s, unit);
                time_s
            }
            TimeSource::Interval { step_s } => {
                RecordingError::unless_step(*step_s)?;
                let rows = match &map.return_flow {
                    ChannelSource::Column { tag, .. } => {
                        let index = columns.find(Channel::ReturnFlow.name(), tag)?;
                        columns.table.columns[index].values.len()
                    }
                    ChannelSource::Constant { .. } => columns.table.rows(),
                };
                origin.even(rows, *step_s)
            }
        };
        if time_s.is_empty() {
            return Err(RecordingError::Empty);
        }
        columns.rows = time_s.len();
        let mut recording = Self {
            mud_pump_flow_m3_s: columns.source(Channel::MudPumpFlow, &map.mud_pump_flow)?,
            booster_flow_m3_s: columns.source(Channel::BoosterFlow, &map.booster_flow)?,
            topfill_flow_m3_s: columns.source(Channel::TopfillFlow, &map.topfill_flow)?,
            return_flow_m3_s: columns.source(Channel::ReturnFlow, &map.return_flow)?,
            pump_inlet_pressure_pa: columns
                .sources(Channel::PumpInletPressure, &map.pump_inlet_pressure)?,
            pump_outlet_pressure_pa: columns
                .sources(Channel::PumpOutletPressure, &map.pump_outlet_pressure)?,
            riser_pressure_pa: map
                .riser_pressure
                .as_ref()
                .map(|source| columns.source(Channel::RiserPressure, source))
                .transpose()?,
            pump_speed_pct: columns.source(Channel::PumpSpeed, &map.pump_speed)?,
            time_s,
        };
        // The channels were taken in the order of the series.
        let series: Vec<_> = recording.series_mut().zip(columns.units).collect();
        series.into_par_iter().for_each(|(values, unit)| {
            if let Some(unit) = unit {
                unit.column_to_si(values);
            }
        });
        let moved = recording.retime(&columns.late_s)?;
        columns.issues.extend(moved);
        Ok((recording, columns.issues))
    }

    /// Gives each sample the value that a channel has where its late stamps say so; NaN where it has none there.
    ///
    /// - `late_s`: of each channel, in the order of the series.
    fn retime(&mut self, late_s: &[f64]) -> Result<Vec<Issue>, RecordingError> {
        let mut issues = Vec::new();
        if late_s.iter().all(|late_s| *late_s == 0.0) {
            return Ok(issues);
        }
        let time_s = std::mem::take(&mut self.time_s);
        let clock = survey_clock(&time_s)?;
        let sources = clock.sources(&time_s);
        let places: Vec<Channel> = self
            .series()
            .into_iter()
            .map(|(channel, _)| channel)
            .collect();
        for ((values, late_s), channel) in self.series_mut().zip(late_s).zip(places) {
            let steps = (late_s / clock.step_s).round();
            let moved_s = steps * clock.step_s;
            if (moved_s - late_s).abs() > 1e-6 * clock.step_s {
                issues.push(Issue {
                    kind: IssueKind::LateStamps,
                    place: channel.to_string(),
                    message: format!(
                        "is {late_s} s late; its samples were moved by {moved_s} s, whole steps of the clock"
                    ),
                });
            }
            if steps == 0.0 {
                continue;
            }
            let value = |stamp_s: &f64| {
                let step = clock.step_of(stamp_s + moved_s)?;
                Some(values[sources[step]? as usize])
            };
            let moved = time_s.iter().map(|t| value(t).unwrap_or(f64::NAN));
            *values = moved.collect();
        }
        self.time_s = time_s;
        Ok(issues)
    }
}
