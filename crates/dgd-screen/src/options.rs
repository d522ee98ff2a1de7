//! The knobs of a screening.

use crate::ScreenError;

/// Lowest and highest value that a channel can take, SI.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limits {
    /// Values below are impossible.
    pub low: f64,
    /// Values above are impossible.
    pub high: f64,
}

/// What [`crate::screen`] rejects, and how sure it must be.
///
/// Lengths are in seconds and scale with the clock, except where a count of
/// samples is what makes the evidence.
#[derive(Debug, Clone, PartialEq)]
pub struct ScreenOptions {
    /// Speed above which the pump counts as on, %. Default 0.5: a noisy zero is no
    /// running pump. The thesis takes 0.
    pub pump_on_above_pct: f64,
    /// Seconds left out after the pump starts. Default 120: the line drains while the
    /// pump is off and refills afterwards, so that until then its hydrostatic column,
    /// and with it the friction of Eq. 3.13, is wrong. The thesis takes 0.
    pub settle_s: f64,
    /// Seconds before a stop of the pump within which its run-down is sought; samples there at less than seven tenths of the highest speed
    /// are left out. Default 120: the pump then lifts less than half of what it did, while a late meter still reads the flow of before, or
    /// flickers behind a check valve that has closed. The thesis takes 0.
    pub run_down_s: f64,
    /// Fewest equal return flows in a row that count as stuck, samples. Default 5.
    pub stuck_flow_samples: usize,
    /// Shortest run of one pressure that counts as stuck, s. Default 30.
    pub stuck_pressure_s: f64,
    /// Shortest run of one inflow that counts as stuck, s. Default 120: strokes of a
    /// steady pump may be counted alike for long.
    pub stuck_inflow_s: f64,
    /// Shortest run of one speed that is marked constant, s. Default 60.
    pub constant_speed_s: f64,
    /// Shortest run of one speed that is examined for being frozen, s. Default 20.
    pub frozen_speed_s: f64,
    /// Whether a constant speed is a reason for rejection, frozen or not. Default
    /// false: a set-point in manual mode rests honestly, and only a frozen reading
    /// (one that later catches up in a jump which the pump's outlet pressure does not
    /// follow) is rejected. The thesis rejects both.
    pub reject_constant_speed: bool,
    /// A run is stuck when the channel's own share of repeats makes one of its length
    /// less likely than this at a given sample. Default 1e-6; coarse quantisation
    /// repeats honestly and so asks for longer runs.
    pub stuck_chance: f64,
    /// Robust standard deviations beyond which an excursion is a spike. Default 6.
    pub spike_sigmas: f64,
    /// Longest excursion that is a spike, s; at least one sample and at most 50 are
    /// looked at. Default 3.
    pub spike_longest_s: f64,
    /// Longest dropout of an inflow that is taken for a spike, s: 0, or a number beyond twice its rate, repeated exactly while it pumps; at most 120 samples are
    /// looked at. Default 60: a pump is not stopped and started again at once, and a logger that has lost a signal writes 0.
    pub dropout_longest_s: f64,
    /// Robust standard deviations beyond which transmitters disagree. Default 6.
    pub disagree_sigmas: f64,
    /// Longest disagreement that is screened away, s; a longer one is a finding for a
    /// diagnosis and stays. Default 60.
    pub disagree_longest_s: f64,
    /// Possible pressures, Pa absolute. Default 1e4 to 1.5e8.
    pub pressure_pa: Limits,
    /// Possible return flows, m³/s. Default -0.02 to 0.3; a zero may read a little negative.
    pub flow_m3_s: Limits,
    /// Possible flows that are pumped in, m³/s. Default -0.002 to 0.3: no pump runs backwards, and what reads so is a code of the logger.
    pub inflow_m3_s: Limits,
    /// Possible speeds, %. Default -2 to 120.
    pub speed_pct: Limits,
}

impl Default for ScreenOptions {
    fn default() -> Self {
        Self {
            pump_on_above_pct: 0.5,
            settle_s: 120.0,
            run_down_s: 120.0,
            stuck_flow_samples: 5,
            stuck_pressure_s: 30.0,
            stuck_inflow_s: 120.0,
            constant_speed_s: 60.0,
            frozen_speed_s: 20.0,
            reject_constant_speed: false,
            stuck_chance: 1e-6,
            spike_sigmas: 6.0,
            spike_longest_s: 3.0,
            dropout_longest_s: 60.0,
            disagree_sigmas: 6.0,
            disagree_longest_s: 60.0,
            pressure_pa: Limits {
                low: 1e4,
                high: 1.5e8,
            },
            flow_m3_s: Limits {
                low: -0.02,
                high: 0.3,
            },
            inflow_m3_s: Limits {
                low: -0.002,
                high: 0.3,
            },
            speed_pct: Limits {
                low: -2.0,
                high: 120.0,
            },
        }
    }
}

impl ScreenOptions {
    /// The rules of section 3.3 of the thesis: pump on means above zero, restarts are
    /// kept, and every long run of one speed is rejected.
    pub fn thesis() -> Self {
        Self {
            pump_on_above_pct: 0.0,
            settle_s: 0.0,
            run_down_s: 0.0,
            reject_constant_speed: true,
            ..Self::default()
        }
    }

    pub(crate) fn check(&self) -> Result<(), ScreenError> {
        let refuse = |name, found, expected| {
            Err(ScreenError::Option {
                name,
                found,
                expected,
            })
        };
        for (name, found) in [
            ("settle_s", self.settle_s),
            ("run_down_s", self.run_down_s),
            ("stuck_pressure_s", self.stuck_pressure_s),
            ("stuck_inflow_s", self.stuck_inflow_s),
            ("constant_speed_s", self.constant_speed_s),
            ("frozen_speed_s", self.frozen_speed_s),
            ("spike_sigmas", self.spike_sigmas),
            ("spike_longest_s", self.spike_longest_s),
            ("dropout_longest_s", self.dropout_longest_s),
            ("disagree_sigmas", self.disagree_sigmas),
            ("disagree_longest_s", self.disagree_longest_s),
        ] {
            if !(found.is_finite() && found >= 0.0) {
                return refuse(name, found, "a finite number of at least 0");
            }
        }
        if !self.pump_on_above_pct.is_finite() {
            return refuse(
                "pump_on_above_pct",
                self.pump_on_above_pct,
                "a finite number",
            );
        }
        if !(self.stuck_chance > 0.0 && self.stuck_chance < 1.0) {
            return refuse(
                "stuck_chance",
                self.stuck_chance,
                "a number between 0 and 1",
            );
        }
        for (low, high, limits) in [
            ("pressure_pa.low", "pressure_pa.high", self.pressure_pa),
            ("flow_m3_s.low", "flow_m3_s.high", self.flow_m3_s),
            ("inflow_m3_s.low", "inflow_m3_s.high", self.inflow_m3_s),
            ("speed_pct.low", "speed_pct.high", self.speed_pct),
        ] {
            if limits.high.is_nan() {
                return refuse(high, limits.high, "a number");
            }
            if limits.low.is_nan() || limits.low >= limits.high {
                return refuse(low, limits.low, "a limit below the high one");
            }
        }
        Ok(())
    }
}

/// Samples in `seconds` at this step, at least `least` and never absurdly many.
pub(crate) fn samples(seconds: f64, step_s: f64, least: usize) -> usize {
    const MOST: f64 = 1e9;
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "bounded and non-negative"
    )]
    let count = (seconds / step_s).round().clamp(0.0, MOST) as usize;
    count.max(least)
}
