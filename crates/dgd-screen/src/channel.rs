//! What is wrong with one transmitter, sample by sample.

use dgd_recording::{Channel, Run};
use dgd_units::Dimension;
use std::ops::{BitOr, BitOrAssign};

/// A set of faults of one transmitter at one sample; empty if it may be trusted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub struct Faults(u8);

impl Faults {
    /// No fault.
    pub const NONE: Self = Self(0);
    /// No value.
    pub const MISSING: Self = Self(1);
    /// An impossible value.
    pub const OUT_OF_RANGE: Self = Self(1 << 1);
    /// A few samples far off, with the same level before and after; of an inflow also a dropout of up to a minute.
    pub const SPIKE: Self = Self(1 << 2);
    /// One value repeated for longer than this channel repeats by chance; of the pump
    /// speed: frozen.
    pub const STUCK: Self = Self(1 << 3);
    /// Left its twin for a short while.
    pub const DISAGREES: Self = Self(1 << 4);
    /// Pump speed only: did not change for long. No fault by itself.
    pub const CONSTANT: Self = Self(1 << 5);
    /// Flows only: read here, and repeated from the next sample on, which is stuck. No fault by itself, but no sample for a fit.
    pub const HELD: Self = Self(1 << 6);

    /// Whether every fault in `other` is among these.
    pub fn contains(self, other: Self) -> bool {
        self.0 & other.0 == other.0
    }

    /// Whether the value may be trusted: no fault, or merely a constant speed or the first of a stuck run.
    pub fn trusted(self) -> bool {
        self.0 & !(Self::CONSTANT | Self::HELD).0 == 0
    }
}

impl BitOr for Faults {
    type Output = Self;
    fn bitor(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }
}

impl BitOrAssign for Faults {
    fn bitor_assign(&mut self, other: Self) {
        self.0 |= other.0;
    }
}

/// One transmitter, screened.
#[derive(Debug, Clone, PartialEq)]
pub struct ChannelScreen {
    /// Which.
    pub channel: Channel,
    /// One set of faults a sample.
    pub faults: Vec<Faults>,
    /// Runs of one value that are stuck (pump speed: frozen), in order.
    pub stuck: Vec<Run>,
    /// Pump speed only: runs marked constant, the frozen ones included.
    pub constant: Vec<Run>,
    /// Inflows only: runs of one value, 0 or beyond all rates, where the signal was lost. Spikes among the faults.
    pub dropouts: Vec<Run>,
    /// Fewest equal samples that would count as stuck (pump speed: as constant).
    pub shortest_stuck: usize,
    /// Quantisation step, SI; 0 if the channel never changes.
    pub quantum: f64,
    /// Standard deviation of the noise from sample to sample, SI, robust.
    pub noise: f64,
    /// Share of samples that repeat their predecessor outside stuck runs.
    pub repeat_share: f64,
}

impl ChannelScreen {
    /// Mask of the samples at which this transmitter may be trusted: for what looks at it alone, as [`crate::Screening::keep`] looks at all
    /// that a fit needs.
    ///
    /// ```
    /// use dgd_recording::Channel;
    /// use dgd_screen::Screening;
    ///
    /// /// The booster's flow where its meter may be trusted, and NaN where not.
    /// fn trusted_booster(screening: &Screening, mut flow_m3_s: Vec<f64>) -> Vec<f64> {
    ///     let valid = screening.channel(Channel::BoosterFlow).map(|screen| screen.valid());
    ///     for (flow, valid) in flow_m3_s.iter_mut().zip(valid.unwrap_or_default()) {
    ///         *flow = if valid { *flow } else { f64::NAN };
    ///     }
    ///     flow_m3_s
    /// }
    /// ```
    pub fn valid(&self) -> Vec<bool> {
        self.faults.iter().map(|f| f.trusted()).collect()
    }

    /// Samples with this fault.
    pub fn count(&self, fault: Faults) -> usize {
        self.faults.iter().filter(|f| f.contains(fault)).count()
    }
}

/// Whether a channel is a transmitter of pressure.
pub(crate) fn is_pressure(channel: Channel) -> bool {
    channel.dimension() == Dimension::Pressure
}
