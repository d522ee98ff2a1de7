//! The channels of Table 2.1 in SI units.

use crate::clock::STRETCH;
use crate::{
    ChannelSource, ClockError, ClockSurvey, Issue, IssueKind, Table, TimeSource, Well, survey_clock,
};
use dgd_units::{PressureReference, Unit};
use std::fmt;

/// A rig recording: every series is in SI (pump speed in percent) and of the
/// length of `time_s`; NaN where nothing was recorded.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Recording {
    /// Seconds from the start of the recording.
    pub time_s: Vec<f64>,
    /// q_p.
    pub mud_pump_flow_m3_s: Vec<f64>,
    /// q_bp.
    pub booster_flow_m3_s: Vec<f64>,
    /// q_tf.
    pub topfill_flow_m3_s: Vec<f64>,
    /// q_MRL, as measured at the rig.
    pub return_flow_m3_s: Vec<f64>,
    /// Inlet pressure, Pa absolute, one series a transmitter; at least one.
    pub pump_inlet_pressure_pa: Vec<Vec<f64>>,
    /// Outlet pressure, Pa absolute, one series a transmitter; at least one.
    pub pump_outlet_pressure_pa: Vec<Vec<f64>>,
    /// Riser pressure (PT 5), Pa absolute, where there is a transmitter.
    pub riser_pressure_pa: Option<Vec<f64>>,
    /// ω_ssp, % of full speed.
    pub pump_speed_pct: Vec<f64>,
}

/// A channel of a recording; transmitters are counted from 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Channel {
    /// q_p.
    MudPumpFlow,
    /// q_bp.
    BoosterFlow,
    /// q_tf.
    TopfillFlow,
    /// q_MRL.
    ReturnFlow,
    /// Inlet transmitter.
    PumpInletPressure(usize),
    /// Outlet transmitter.
    PumpOutletPressure(usize),
    /// PT 5.
    RiserPressure,
    /// ω_ssp.
    PumpSpeed,
}

impl Channel {
    /// The channel's name in `well.toml`.
    pub fn name(self) -> &'static str {
        match self {
            Self::MudPumpFlow => "mud_pump_flow",
            Self::BoosterFlow => "booster_flow",
            Self::TopfillFlow => "topfill_flow",
            Self::ReturnFlow => "return_flow",
            Self::PumpInletPressure(_) => "pump_inlet_pressure",
            Self::PumpOutletPressure(_) => "pump_outlet_pressure",
            Self::RiserPressure => "riser_pressure",
            Self::PumpSpeed => "pump_speed",
        }
    }
}

impl fmt::Display for Channel {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::PumpInletPressure(n) | Self::PumpOutletPressure(n) => {
                write!(f, "{} {}", self.name(), n + 1)
            }
            other => f.write_str(other.name()),
        }
    }
}

/// Seconds without values between two recordings that are joined: longer than any
/// delay a flow meter has.
pub const SEAM_S: f64 = 120.0;

/// Why a table and a well description do not make a recording.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum RecordingError {
    /// A column that the well description names is not in the file.
    #[error(
        "channel `{channel}` is mapped to the tag `{tag}`, which the recording does not have; it has {present}"
    )]
    NoColumn {
        /// Channel name in the well description.
        channel: String,
        /// Tag looked for.
        tag: String,
        /// Tags in the file, shortened.
        present: String,
    },
    /// Columns of unequal length.
    #[error("tag `{tag}` has {found} samples, expected {expected} as the time has")]
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
    /// No samples.
    #[error("the recording has no samples")]
    Empty,
    /// The clock is beyond use.
    #[error(transparent)]
    Clock(#[from] ClockError),
}

/// Takes columns out of a table without copying them.
struct Columns {
    table: Table,
    taken: Vec<Option<String>>,
    rows: usize,
    issues: Vec<Issue>,
}

impl Columns {
    fn find(&self, channel: &str, tag: &str) -> Result<usize, RecordingError> {
        self.table
            .find(tag)
            .ok_or_else(|| RecordingError::NoColumn {
                channel: channel.into(),
                tag: tag.into(),
                present: tags(&self.table),
            })
    }

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
        let mut values = std::mem::take(&mut column.values);
        unit.column_to_si(&mut values);
        Ok(values)
    }

    fn source(
        &mut self,
        channel: Channel,
        source: &ChannelSource,
    ) -> Result<Vec<f64>, RecordingError> {
        match source {
            ChannelSource::Constant { si } => Ok(vec![*si; self.rows]),
            ChannelSource::Column { tag, unit } => {
                let values = self.take(&channel.to_string(), tag, *unit)?;
                if values.len() == self.rows {
                    return Ok(values);
                }
                Err(RecordingError::Length {
                    tag: tag.clone(),
                    found: values.len(),
                    expected: self.rows,
                })
            }
        }
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
    if same_scale && (found.offset == described.offset || reference_open) {
        return None;
    }
    Some(Issue {
        kind: IssueKind::UnitDisagrees,
        place: channel.to_owned(),
        message: format!(
            "the file says `{written}`, the well description `{described}`; the description was used"
        ),
    })
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
    /// [`RecordingError`] if a mapped column is missing, of another length or mapped twice.
    pub fn from_table(table: Table, well: &Well) -> Result<(Self, Vec<Issue>), RecordingError> {
        let map = &well.channels;
        let taken = vec![None; table.columns.len()];
        let mut columns = Columns {
            rows: 0,
            taken,
            table,
            issues: Vec::new(),
        };
        let time_s = match &map.time {
            TimeSource::Column { tag, unit } => {
                let mut time_s = columns.take("time", tag, *unit)?;
                // Seconds from the start: epoch seconds would cost every later step its digits.
                if let Some(first) = time_s.iter().copied().find(|t| t.is_finite()) {
                    time_s.iter_mut().for_each(|t| *t -= first);
                }
                time_s
            }
            TimeSource::Interval { step_s } => {
                let rows = match &map.return_flow {
                    ChannelSource::Column { tag, .. } => {
                        let index = columns.find(Channel::ReturnFlow.name(), tag)?;
                        columns.table.columns[index].values.len()
                    }
                    ChannelSource::Constant { .. } => columns.table.rows(),
                };
                (0..rows).map(|i| i as f64 * step_s).collect()
            }
        };
        if time_s.is_empty() {
            return Err(RecordingError::Empty);
        }
        columns.rows = time_s.len();
        let recording = Self {
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
        Ok((recording, columns.issues))
    }

    /// Samples.
    pub fn len(&self) -> usize {
        self.time_s.len()
    }

    /// Whether there is no sample.
    pub fn is_empty(&self) -> bool {
        self.time_s.is_empty()
    }

    /// Every channel with its series, in the order of Table 2.1.
    pub fn series(&self) -> Vec<(Channel, &[f64])> {
        let mut all: Vec<(Channel, &[f64])> = vec![
            (Channel::MudPumpFlow, &self.mud_pump_flow_m3_s),
            (Channel::BoosterFlow, &self.booster_flow_m3_s),
            (Channel::TopfillFlow, &self.topfill_flow_m3_s),
            (Channel::ReturnFlow, &self.return_flow_m3_s),
        ];
        let inlet = self.pump_inlet_pressure_pa.iter().enumerate();
        all.extend(inlet.map(|(n, v)| (Channel::PumpInletPressure(n), v.as_slice())));
        let outlet = self.pump_outlet_pressure_pa.iter().enumerate();
        all.extend(outlet.map(|(n, v)| (Channel::PumpOutletPressure(n), v.as_slice())));
        all.extend(
            self.riser_pressure_pa
                .iter()
                .map(|v| (Channel::RiserPressure, v.as_slice())),
        );
        all.push((Channel::PumpSpeed, &self.pump_speed_pct));
        all
    }

    /// The series of a channel, to blank values in; `None` if the recording does not have it.
    pub fn channel_mut(&mut self, channel: Channel) -> Option<&mut [f64]> {
        match channel {
            Channel::MudPumpFlow => Some(&mut self.mud_pump_flow_m3_s),
            Channel::BoosterFlow => Some(&mut self.booster_flow_m3_s),
            Channel::TopfillFlow => Some(&mut self.topfill_flow_m3_s),
            Channel::ReturnFlow => Some(&mut self.return_flow_m3_s),
            Channel::PumpInletPressure(n) => self
                .pump_inlet_pressure_pa
                .get_mut(n)
                .map(Vec::as_mut_slice),
            Channel::PumpOutletPressure(n) => self
                .pump_outlet_pressure_pa
                .get_mut(n)
                .map(Vec::as_mut_slice),
            Channel::RiserPressure => self.riser_pressure_pa.as_deref_mut(),
            Channel::PumpSpeed => Some(&mut self.pump_speed_pct),
        }
    }

    fn series_mut(&mut self) -> impl Iterator<Item = &mut Vec<f64>> {
        [
            &mut self.mud_pump_flow_m3_s,
            &mut self.booster_flow_m3_s,
            &mut self.topfill_flow_m3_s,
            &mut self.return_flow_m3_s,
            &mut self.pump_speed_pct,
        ]
        .into_iter()
        .chain(&mut self.pump_inlet_pressure_pa)
        .chain(&mut self.pump_outlet_pressure_pa)
        .chain(&mut self.riser_pressure_pa)
    }

    /// Puts the samples on an even clock ([`crate::ClockSurvey::step_s`]): in order, duplicates
    /// dropped, gaps filled with NaN, jittering stamps moved to the nearest step.
    ///
    /// A recording that is even already is returned untouched. Returns the step, s,
    /// and what had to be mended.
    ///
    /// # Errors
    /// [`RecordingError::Clock`] if there is no clock to be found, or it was set back on the way.
    pub fn onto_grid(mut self) -> Result<(Self, f64, Vec<Issue>), RecordingError> {
        let clock = survey_clock(&self.time_s)?;
        if clock.even {
            return Ok((self, clock.step_s, Vec::new()));
        }
        let sources = clock.sources(&self.time_s);
        if clock.backward > 0 {
            self.refuse_set_back(&clock, &sources)?;
        }
        for values in self.series_mut() {
            *values = sources
                .iter()
                .map(|s| s.map_or(f64::NAN, |i| values[i as usize]))
                .collect();
        }
        self.time_s = (0..sources.len())
            .map(|i| clock.span_s.0 + i as f64 * clock.step_s)
            .collect();
        Ok((self, clock.step_s, clock.issues()))
    }

    /// Refuses a recording of which two stretches lie on the same steps of the clock with other values.
    ///
    /// A stretch that is there twice alike, as where files overlap, is no trouble.
    fn refuse_set_back(
        &self,
        clock: &ClockSurvey,
        sources: &[Option<u32>],
    ) -> Result<(), ClockError> {
        let series = self.series();
        let other = |i: usize| {
            let taken = clock
                .step_of(self.time_s[i])
                .and_then(|step| sources.get(step).copied());
            let Some(first) = taken.flatten().map(|first| first as usize) else {
                return false;
            };
            let differs = |(_, values): &(Channel, &[f64])| {
                let (a, b) = (values[first], values[i]);
                a.is_finite() && b.is_finite() && a != b
            };
            first != i && series.iter().any(differs)
        };
        let (mut run, mut longest, mut samples) = (0, 0, 0);
        for i in 0..self.len() {
            run = if other(i) { run + 1 } else { 0 };
            longest = longest.max(run);
            samples += usize::from(run > 0);
        }
        if longest < STRETCH {
            return Ok(());
        }
        let finite: Vec<f64> = self
            .time_s
            .iter()
            .copied()
            .filter(|t| t.is_finite())
            .collect();
        let jumps = finite.windows(2).map(|w| (w[0], w[0] - w[1]));
        let furthest = jumps.max_by(|a, b| a.1.total_cmp(&b.1));
        let (jump_s, back_s) = furthest.unwrap_or_default();
        Err(ClockError::SetBack {
            jump_s,
            back_s,
            samples,
        })
    }

    /// Appends a recording taken later on the same well and step, after a seam of
    /// [`SEAM_S`] seconds without values, so that no delay reaches from one into the other.
    ///
    /// A transmitter that only one of the two has is NaN in the other. Returns the index
    /// of the first appended sample.
    pub fn append(&mut self, later: Self, step_s: f64) -> usize {
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "positive and small"
        )]
        let seam = (SEAM_S / step_s).ceil().clamp(1.0, 1e6) as usize;
        let (before, added) = (self.len(), later.len());
        let start = before + seam;
        let end_s = self.time_s.last().copied().unwrap_or(0.0);
        self.time_s
            .extend((1..=seam + added).map(|i| end_s + i as f64 * step_s));
        let join = |mine: &mut Vec<f64>, theirs: Vec<f64>| {
            mine.resize(start, f64::NAN);
            mine.extend(theirs);
            mine.resize(start + added, f64::NAN);
        };
        let join_all = |mine: &mut Vec<Vec<f64>>, theirs: Vec<Vec<f64>>| {
            mine.resize_with(mine.len().max(theirs.len()), || vec![f64::NAN; before]);
            let theirs = theirs.into_iter().chain(std::iter::repeat_with(Vec::new));
            mine.iter_mut().zip(theirs).for_each(|(m, t)| join(m, t));
        };
        join(&mut self.mud_pump_flow_m3_s, later.mud_pump_flow_m3_s);
        join(&mut self.booster_flow_m3_s, later.booster_flow_m3_s);
        join(&mut self.topfill_flow_m3_s, later.topfill_flow_m3_s);
        join(&mut self.return_flow_m3_s, later.return_flow_m3_s);
        join(&mut self.pump_speed_pct, later.pump_speed_pct);
        join_all(
            &mut self.pump_inlet_pressure_pa,
            later.pump_inlet_pressure_pa,
        );
        join_all(
            &mut self.pump_outlet_pressure_pa,
            later.pump_outlet_pressure_pa,
        );
        if self.riser_pressure_pa.is_some() || later.riser_pressure_pa.is_some() {
            let mine = self
                .riser_pressure_pa
                .get_or_insert_with(|| vec![f64::NAN; before]);
            join(mine, later.riser_pressure_pa.unwrap_or_default());
        }
        start
    }

    /// Mean of the inlet transmitters at each sample, over those that have a value.
    pub fn mean_inlet_pressure_pa(&self) -> Vec<f64> {
        mean_of_present(&self.pump_inlet_pressure_pa, self.len())
    }

    /// Mean of the outlet transmitters at each sample, over those that have a value.
    pub fn mean_outlet_pressure_pa(&self) -> Vec<f64> {
        mean_of_present(&self.pump_outlet_pressure_pa, self.len())
    }

    /// q_in = q_p + q_bp + q_tf, m³/s (Eq. 3.45).
    pub fn inflow_m3_s(&self) -> Vec<f64> {
        let rest = self.booster_flow_m3_s.iter().zip(&self.topfill_flow_m3_s);
        self.mud_pump_flow_m3_s
            .iter()
            .zip(rest)
            .map(|(p, (b, t))| p + b + t)
            .collect()
    }
}

/// Redundant transmitters are averaged (thesis section 2.6); one that is silent leaves the mean to the others.
fn mean_of_present(series: &[Vec<f64>], rows: usize) -> Vec<f64> {
    match series {
        [only] => only.clone(),
        [a, b] => a
            .iter()
            .zip(b)
            .map(|(a, b)| match (a.is_finite(), b.is_finite()) {
                (true, true) => 0.5 * (a + b),
                (true, false) => *a,
                _ => *b,
            })
            .collect(),
        many => (0..rows)
            .map(|i| {
                let present = many.iter().map(|s| s[i]).filter(|v| v.is_finite());
                let (sum, count) =
                    present.fold((0.0, 0.0), |(sum, count), v| (sum + v, count + 1.0));
                sum / count
            })
            .collect(),
    }
}
