//! Transmitters, and the historian that files what they say.

use crate::noise::{Noise, Wander};

/// A transmitter's character, in the unit it reads in.
#[derive(Debug, Clone, PartialEq)]
pub struct Transmitter {
    /// Reading over truth.
    pub gain: f64,
    /// Share of the reading that is lost for each unit read: how far the meter droops at high flow.
    pub droop: f64,
    /// Constant offset.
    pub bias: f64,
    /// First-order lag, s.
    pub lag_s: f64,
    /// Standard deviation of the white noise of a reading.
    pub noise: f64,
    /// Standard deviation of the slow drift.
    pub drift: f64,
    /// Time constant of the drift, s.
    pub drift_time_s: f64,
    /// Smallest step of the reading.
    pub quantum: f64,
    /// Readings below this are filed as zero.
    pub low_cut: f64,
    /// Whether a true zero reads as an exact zero (counted strokes).
    pub counts: bool,
}

/// A transmitter at work.
#[derive(Debug, Clone)]
pub(crate) struct Working {
    kind: Transmitter,
    lagged: Option<f64>,
    drift: Wander,
    noise: Noise,
}

impl Working {
    pub(crate) fn new(kind: &Transmitter, seed: u64, stream: u64) -> Self {
        let mut noise = Noise::new(seed, stream);
        let drift = Wander::new(kind.drift, kind.drift_time_s.max(1.0), &mut noise);
        Self {
            kind: kind.clone(),
            lagged: None,
            drift,
            noise,
        }
    }

    /// The reading a second after the last one.
    pub(crate) fn read(&mut self, truth: f64) -> f64 {
        let k = &self.kind;
        let keep = if k.lag_s > 0.0 {
            (-1.0 / k.lag_s).exp()
        } else {
            0.0
        };
        let last = self.lagged.unwrap_or(truth);
        let lagged = truth + keep * (last - truth);
        self.lagged = Some(lagged);
        let wander = self.drift.step(1.0, &mut self.noise);
        let white = k.noise * self.noise.normal();
        if k.counts && lagged.abs() < k.quantum {
            return 0.0;
        }
        let raw = lagged * k.gain * (1.0 - k.droop * lagged.max(0.0)) + k.bias + wander + white;
        if raw < k.low_cut {
            0.0
        } else {
            quantise(raw, k.quantum)
        }
    }
}

/// The nearest multiple of `quantum`, free of the tail that binary fractions leave.
pub(crate) fn quantise(x: f64, quantum: f64) -> f64 {
    if quantum <= 0.0 {
        return x;
    }
    ((x / quantum).round() * quantum * 1e6).round() / 1e6
}

/// How often a channel fails, and how.
#[derive(Debug, Clone, PartialEq)]
pub struct FaultRates {
    /// Stuck stretches a day and channel.
    pub stuck_per_day: f64,
    /// Length of a stuck stretch, s: from, to.
    pub stuck_s: (f64, f64),
    /// Single wild values a day and channel.
    pub spikes_per_day: f64,
    /// How far a wild value is off, as a fraction of the value: from, to.
    pub spike_fraction: (f64, f64),
    /// Stretches without a value a day and channel.
    pub missing_per_day: f64,
    /// Length of a stretch without a value, s: from, to.
    pub missing_s: (f64, f64),
    /// Stretches filed as zero a day and channel.
    pub zeros_per_day: f64,
    /// Length of a stretch of zeros, s: from, to.
    pub zeros_s: (f64, f64),
}

/// The kind of an instrument fault.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FaultKind {
    /// The last value is repeated.
    Stuck,
    /// One wild value.
    Spike,
    /// No value.
    Missing,
    /// Zero in place of the value.
    Zero,
    /// The historian files by exception: a value is repeated until it has moved enough.
    Exception,
    /// The clock skips: rows are absent from the recording.
    Gap,
}

/// One fault that was put into the recording: the truth that no estimator may see.
#[derive(Debug, Clone, PartialEq)]
pub struct Fault {
    /// Index into [`crate::CHANNELS`]; `None` when all channels are hit.
    pub channel: Option<usize>,
    /// What happened.
    pub kind: FaultKind,
    /// First sample hit; for a gap, the first sample after it.
    pub first: usize,
    /// Number of samples hit; for a gap, seconds lost.
    pub count: usize,
}

/// Report by exception: a value is looked at every `poll_s` and filed when it has moved by more than the
/// deadband since the last one filed, or when that one is older than the longest silence.
#[derive(Debug, Clone, Default)]
pub(crate) struct Exception {
    filed: Option<f64>,
    age_s: f64,
    since_poll_s: f64,
}

impl Exception {
    pub(crate) fn file(&mut self, value: f64, poll_s: f64, deadband: f64, silence_s: f64) -> f64 {
        self.age_s += 1.0;
        self.since_poll_s += 1.0;
        let polled = self.since_poll_s >= poll_s;
        let moved = self
            .filed
            .is_none_or(|last| polled && (value - last).abs() > deadband);
        if polled {
            self.since_poll_s = 0.0;
        }
        if moved || self.age_s >= silence_s {
            self.filed = Some(value);
            self.age_s = 0.0;
        }
        self.filed.unwrap_or(value)
    }

    pub(crate) fn forget(&mut self) {
        self.filed = None;
    }
}

/// Puts stuck, wild, missing and zero values into one channel, and reports each.
pub(crate) fn spoil(
    values: &mut [f64],
    channel: usize,
    rates: &FaultRates,
    noise: &mut Noise,
) -> Vec<Fault> {
    let days = values.len() as f64 / 86_400.0;
    let plan = [
        (FaultKind::Stuck, rates.stuck_per_day, rates.stuck_s),
        (FaultKind::Zero, rates.zeros_per_day, rates.zeros_s),
        (FaultKind::Spike, rates.spikes_per_day, (1.0, 1.0)),
        (FaultKind::Missing, rates.missing_per_day, rates.missing_s),
    ];
    let mut faults = Vec::new();
    for (kind, per_day, (shortest, longest)) in plan {
        for _ in 0..draw_count(per_day * days, noise) {
            let length = noise.between(shortest, longest.max(shortest)).round();
            let first = crate::constants::index(
                noise.unit() * values.len() as f64,
                values.len().saturating_sub(1),
            );
            let count = crate::constants::index(length, values.len() - first).max(1);
            let wild =
                1.0 + noise.sign() * noise.between(rates.spike_fraction.0, rates.spike_fraction.1);
            let held = values[first];
            for v in &mut values[first..first + count] {
                *v = match kind {
                    FaultKind::Stuck => held,
                    FaultKind::Zero => 0.0,
                    FaultKind::Spike => quantise(*v * wild, 0.5),
                    _ => f64::NAN,
                };
            }
            faults.push(Fault {
                channel: Some(channel),
                kind,
                first,
                count,
            });
        }
    }
    faults
}

/// A Poisson number of events by counting exponential waits.
fn draw_count(mean: f64, noise: &mut Noise) -> usize {
    let mut count = 0;
    let mut waited = -(1.0 - noise.unit()).ln();
    while waited < mean && count < 100_000 {
        count += 1;
        waited -= (1.0 - noise.unit()).ln();
    }
    count
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exception_reporting_repeats_until_the_deadband_is_passed() {
        let mut e = Exception::default();
        let filed: Vec<f64> = [10.0, 11.0, 12.5, 16.0, 16.5]
            .iter()
            .map(|&v| e.file(v, 1.0, 4.0, 600.0))
            .collect();
        assert_eq!(filed, [10.0, 10.0, 10.0, 16.0, 16.0]);
    }

    #[test]
    fn quantised_readings_are_exact_multiples() {
        assert_eq!(quantise(0.3000000004, 0.1).to_string(), "0.3");
        assert_eq!(quantise(100.26, 0.5), 100.5);
    }
}
