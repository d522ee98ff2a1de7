//! The channels of Table 2.1 in SI units.

mod blocks;
mod mapping;

pub use blocks::BlockGrid;
pub use mapping::{Absent, RecordingError, Unequal};

use crate::clock::{STRETCH, most_steps};
use crate::{ClockError, ClockSurvey, Issue, Uneven, check_even, survey_clock};
use dgd_units::Dimension;
use std::fmt;
use std::ops::Range;

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
    /// Whether it is set by somebody rather than measured: an inflow, or the pump's speed.
    pub fn is_set(self) -> bool {
        matches!(
            self,
            Self::MudPumpFlow | Self::BoosterFlow | Self::TopfillFlow | Self::PumpSpeed
        )
    }

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

    /// What the channel measures, and so what its unit must.
    ///
    /// ```
    /// # use dgd_recording::Channel;
    /// # use dgd_units::Dimension;
    /// assert_eq!(Channel::ReturnFlow.dimension(), Dimension::FlowRate);
    /// assert_eq!(Channel::PumpSpeed.dimension(), Dimension::Percent);
    /// ```
    pub fn dimension(self) -> Dimension {
        match self {
            Self::MudPumpFlow | Self::BoosterFlow | Self::TopfillFlow | Self::ReturnFlow => {
                Dimension::FlowRate
            }
            Self::PumpInletPressure(_) | Self::PumpOutletPressure(_) | Self::RiserPressure => {
                Dimension::Pressure
            }
            Self::PumpSpeed => Dimension::Percent,
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

/// Below this flow, m³/s, mud stands in the return line, and so may its meter and the pressures.
pub const STANDING_M3_S: f64 = 1e-3;

/// Seconds without values between two recordings that are joined: longer than any
/// delay a flow meter has.
const SEAM_S: f64 = 120.0;

impl Recording {
    /// Samples.
    pub fn len(&self) -> usize {
        self.time_s.len()
    }

    /// Whether there is no sample.
    pub fn is_empty(&self) -> bool {
        self.time_s.is_empty()
    }

    /// Checks that every series is as long as the clock.
    ///
    /// # Errors
    /// [`Unequal`] names the first that is not.
    pub fn check(&self) -> Result<(), Unequal> {
        let expected = self.len();
        let odd = self.series().into_iter().find(|s| s.1.len() != expected);
        odd.map_or(Ok(()), |(channel, values)| {
            Err(Unequal {
                channel,
                found: values.len(),
                expected,
            })
        })
    }

    /// Checks that the samples are so many seconds apart, as [`Self::onto_grid`] puts them: [`check_even`] of `time_s`.
    ///
    /// # Errors
    /// [`Uneven`], with the first place where they are not.
    pub fn check_even(&self, step_s: f64) -> Result<(), Uneven> {
        check_even(&self.time_s, step_s)
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

    /// Every channel with what `map` makes of its series, on the clock `time_s`.
    ///
    /// - `map`: gives series of the length of `time_s`; it is called for the channels in the order of [`Self::series`].
    ///
    /// ```
    /// # use dgd_recording::Recording;
    /// # let recording = Recording { time_s: vec![0.0, 1.0, 2.0, 3.0], pump_speed_pct: vec![60.0, 61.0, 62.0, 63.0], ..Recording::default() };
    /// let every_other = |values: &[f64]| values.iter().step_by(2).copied().collect::<Vec<f64>>();
    /// let thinned = recording.map_channels(every_other(&recording.time_s), every_other);
    /// assert_eq!(thinned.pump_speed_pct, [60.0, 62.0]);
    /// ```
    #[must_use]
    pub fn map_channels(&self, time_s: Vec<f64>, mut map: impl FnMut(&[f64]) -> Vec<f64>) -> Self {
        Self {
            time_s,
            mud_pump_flow_m3_s: map(&self.mud_pump_flow_m3_s),
            booster_flow_m3_s: map(&self.booster_flow_m3_s),
            topfill_flow_m3_s: map(&self.topfill_flow_m3_s),
            return_flow_m3_s: map(&self.return_flow_m3_s),
            pump_inlet_pressure_pa: (self.pump_inlet_pressure_pa.iter())
                .map(|values| map(values))
                .collect(),
            pump_outlet_pressure_pa: (self.pump_outlet_pressure_pa.iter())
                .map(|values| map(values))
                .collect(),
            riser_pressure_pa: self.riser_pressure_pa.as_deref().map(&mut map),
            pump_speed_pct: map(&self.pump_speed_pct),
        }
    }

    /// The samples of a range.
    ///
    /// # Panics
    /// If the range does not lie within the recording, as a slice does.
    #[must_use]
    pub fn slice(&self, range: Range<usize>) -> Self {
        let part = |values: &[f64]| values[range.clone()].to_vec();
        self.map_channels(part(&self.time_s), part)
    }

    /// The samples whose times lie within `from_s..=to_s`; none if an end is no number.
    ///
    /// By bisection: the times must ascend.
    ///
    /// ```
    /// # let recording = dgd_recording::Recording { time_s: vec![0.0, 1.0, 2.0, 3.0], ..Default::default() };
    /// assert_eq!(recording.between(0.5, 2.0), 1..3);
    /// ```
    #[must_use]
    pub fn between(&self, from_s: f64, to_s: f64) -> Range<usize> {
        // Negated, so that a window from NaN begins after the end.
        let first = self.time_s.partition_point(|t| !(*t >= from_s));
        let last = self.time_s.partition_point(|t| *t <= to_s);
        first..last.max(first)
    }

    /// Samples at which some transmitter has a value: those of gaps have none.
    pub fn recorded(&self) -> usize {
        let series = self.series();
        let recorded = |i: &usize| series.iter().any(|(_, values)| values[*i].is_finite());
        (0..self.len()).filter(recorded).count()
    }

    /// Every series, in the order of [`Self::series`].
    pub(crate) fn series_mut(&mut self) -> impl Iterator<Item = &mut Vec<f64>> {
        [
            &mut self.mud_pump_flow_m3_s,
            &mut self.booster_flow_m3_s,
            &mut self.topfill_flow_m3_s,
            &mut self.return_flow_m3_s,
        ]
        .into_iter()
        .chain(&mut self.pump_inlet_pressure_pa)
        .chain(&mut self.pump_outlet_pressure_pa)
        .chain(&mut self.riser_pressure_pa)
        .chain([&mut self.pump_speed_pct])
    }

    /// Puts the samples on an even clock ([`crate::ClockSurvey::step_s`]): in order, duplicates
    /// dropped, gaps filled with NaN, jittering stamps moved to the nearest step.
    ///
    /// A recording that is even already is returned untouched. Returns the step, s,
    /// and what had to be mended.
    ///
    /// # Errors
    /// [`RecordingError::Clock`] if there is no clock to be found, or it was set back on the way;
    /// [`RecordingError::Unequal`] if a series is not as long as the clock.
    pub fn onto_grid(mut self) -> Result<(Self, f64, Vec<Issue>), RecordingError> {
        self.check()?;
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
    /// 120 seconds without values, so that no delay reaches from one into the other.
    ///
    /// For recordings of which nothing tells how far they are apart, else [`Self::append_after`].
    ///
    /// # Errors
    /// [`RecordingError::Step`] if the step is no positive number; nothing is appended.
    pub fn append(&mut self, later: Self, step_s: f64) -> Result<usize, RecordingError> {
        RecordingError::unless_step(step_s)?;
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "positive and small"
        )]
        let seam = (SEAM_S / step_s).ceil().clamp(1.0, 1e6) as usize;
        Ok(self.appended(later, step_s, seam))
    }

    /// Appends a recording taken later on the same well and step, after so many samples without values, or none.
    ///
    /// A transmitter that only one of the two has is NaN in the other. The seam takes memory as samples do. Returns the index
    /// of the first appended sample.
    ///
    /// # Errors
    /// [`RecordingError::Step`] if the step is no positive number, [`RecordingError::Seam`] if the seam is longer than a gap of a
    /// recording of as many samples may be; nothing is appended.
    pub fn append_after(
        &mut self,
        later: Self,
        step_s: f64,
        seam: usize,
    ) -> Result<usize, RecordingError> {
        RecordingError::unless_step(step_s)?;
        let samples = self.len() + later.len();
        if seam as f64 > most_steps(samples) {
            return Err(RecordingError::Seam { seam, samples });
        }
        Ok(self.appended(later, step_s, seam))
    }

    /// The index of the first appended sample.
    fn appended(&mut self, later: Self, step_s: f64, seam: usize) -> usize {
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

    /// Mean of the inlet transmitters at each sample, over those that have a value; NaN where none has. Shape of `time_s`.
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

/// Redundant transmitters are averaged (thesis section 2.6); one that is silent leaves the mean to the others, and so does
/// one whose series has ended.
fn mean_of_present(series: &[Vec<f64>], rows: usize) -> Vec<f64> {
    match series {
        [only] if only.len() == rows => only.clone(),
        [a, b] if a.len() == rows && b.len() == rows => a
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
                let present = many
                    .iter()
                    .filter_map(|s| s.get(i))
                    .filter(|v| v.is_finite());
                let (sum, count) =
                    present.fold((0.0, 0.0), |(sum, count), v| (sum + v, count + 1.0));
                sum / count
            })
            .collect(),
    }
}
