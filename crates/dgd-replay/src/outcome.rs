//! What came out of a replay.

use dgd_dynamics::integrate::{Statistics, Status};
use dgd_dynamics::return_line::RiserBounds;

/// Measured and simulated values of one signal on the same clock.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Pair {
    /// Measured; NaN where the recording has nothing to be trusted.
    pub measured: Vec<f64>,
    /// Simulated; empty if the simulation does not give this signal.
    pub simulated: Vec<f64>,
}

/// How far simulated lies from measured.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Deviation {
    /// Root of the mean squared difference.
    pub rmse: f64,
    /// Mean of simulated less measured.
    pub bias: f64,
    /// Largest difference, either way.
    pub largest: f64,
    /// Samples compared.
    pub samples: usize,
}

impl Pair {
    /// Compares the two where both have values.
    pub fn deviation(&self) -> Option<Deviation> {
        let mut sums = DeviationSums::default();
        sums.add(self);
        sums.deviation()
    }
}

/// The deviation of a pair that comes in parts, which is that of the whole to the last bit.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct DeviationSums {
    squares: f64,
    sum: f64,
    largest: f64,
    samples: usize,
}

impl DeviationSums {
    /// Takes the next samples.
    pub fn add(&mut self, part: &Pair) {
        let both = part.measured.iter().zip(&part.simulated);
        for d in both.map(|(m, s)| s - m).filter(|d| d.is_finite()) {
            self.squares += d * d;
            self.sum += d;
            self.largest = self.largest.max(d.abs());
            self.samples += 1;
        }
    }

    /// The deviation so far; `None` without samples that have both values.
    pub fn deviation(&self) -> Option<Deviation> {
        let n = self.samples as f64;
        (self.samples > 0).then(|| Deviation {
            rmse: (self.squares / n).sqrt(),
            bias: self.sum / n,
            largest: self.largest,
            samples: self.samples,
        })
    }
}

/// A simulation beside its recording, all series of the length of `time_s`.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Replay {
    /// Seconds from the start of the recording.
    pub time_s: Vec<f64>,
    /// Riser level h_r, m below the rotary table (measured: Eq. 4.1).
    pub level_m: Pair,
    /// Flow at the rig's meter, m³/s: the simulated one is late by the model's delay.
    pub return_flow_m3_s: Pair,
    /// Flow through the pump, m³/s: the measured one is the meter's, read ahead (Eq. 3.30).
    pub pump_flow_m3_s: Pair,
    /// Pressure at the pump's inlet, Pa absolute.
    pub inlet_pressure_pa: Pair,
    /// Pressure at the pump's outlet, Pa absolute.
    pub outlet_pressure_pa: Pair,
    /// Pump head, m of mud.
    pub head_m: Pair,
    /// Inflow into the riser, m³/s; without gaps if the simulation reads it.
    pub inflow_m3_s: Vec<f64>,
    /// Pump speed, %; without gaps if the simulation reads it.
    pub speed_pct: Vec<f64>,
    /// Values of the inputs read that were interpolated.
    pub filled: usize,
    /// When the model left its range.
    pub bounds: RiserBounds,
    /// How the integration ended; `None` for the steady state, which integrates nothing.
    pub status: Option<Status>,
    /// What it cost.
    pub statistics: Statistics,
    /// Samples at which no steady state was found (steady state only).
    pub unsolved: usize,
}
