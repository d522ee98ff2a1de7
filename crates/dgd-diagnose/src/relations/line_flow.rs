//! The line's flow from the reading of its meter.

use super::Applied;
use crate::numbers::{mean, whole};
use crate::record::Record;
use dgd_effects::{MeterPath, STANDING_M3_S, shrunk};

/// To either side of a sample, s, the meter is smoothed for what it shows later.
const SMOOTHED_S: f64 = 4.0;
/// The same for its slope where its flow is calm, and half as long as a long lag: over less, its noise would make small stores look like delays.
const CALM_S: f64 = 8.0;
/// The same where its flow changes: over more, the edges of a change would.
const SHARP_S: f64 = 3.0;
/// Deviations of noise beyond which a slope tells of a change.
const GATE: f64 = 5.0;

/// E-folds an hour that a lag of the meter loses as it is turned round: through a slope over many seconds, which blurs what a delay keeps.
///
/// In 122 simulated recordings of 4 to 8 h of a delay or a store in which both stood out (PROOF-HISTORY.md) a delay that led by less than ten e-folds was a store
/// in all of 11, one that led by more than twenty a delay in 63 of 67; the odds were even here.
const BLURRED: f64 = 3.4;
/// Hours beyond which it loses no more, for none longer were among them: over 85 h of an independent rig a delay leads by less than this grows.
const MOST_HOURS: f64 = 8.0;

/// Value at a fractional index, NaN beyond the ends or beside a gap.
fn at(values: &[f64], position: f64) -> f64 {
    if position < 0.0 {
        return f64::NAN;
    }
    let low = whole(position.floor());
    let share = position - low as f64;
    match (values.get(low), values.get(low + 1)) {
        (Some(a), _) if share < 1e-9 => *a,
        (Some(a), Some(b)) => a + share * (b - a),
        _ => f64::NAN,
    }
}

/// Means of so many samples to either side.
fn smoothed(values: &[f64], half: usize) -> Vec<f64> {
    let n = values.len();
    (0..n)
        .map(|i| mean(&values[i.saturating_sub(half)..(i + half + 1).min(n)]))
        .collect()
}

/// What a lag holds back, `tau dq/dt`, over so many seconds to either side, and the deviation of its noise.
fn held_back<'a>(
    meter: &'a [f64],
    lag_s: f64,
    dt_s: f64,
    noise: f64,
    half_s: f64,
) -> (impl Fn(usize) -> f64 + 'a, f64) {
    let half = whole(half_s / dt_s).max(1);
    let steady = smoothed(meter, half);
    let over = 2.0 * half as f64;
    let window = over + 1.0;
    let left = noise * (2.0 * over).sqrt() / window * lag_s / (over * dt_s);
    let last = meter.len().saturating_sub(1);
    let held = move |i: usize| {
        let (a, b) = (i.saturating_sub(half), (i + half).min(last));
        lag_s * (steady[b] - steady[a]) / ((b - a).max(1) as f64 * dt_s)
    };
    (held, left)
}

/// A change, if it is more than noise.
fn cleared(change: f64, noise: f64) -> f64 {
    let [fourth, gate] = [change, GATE * noise].map(|v| v.powi(4));
    if fourth > 0.0 {
        change * fourth / (fourth + gate)
    } else {
        0.0
    }
}

/// The line's flow from its meter: the meter path inverted, a lag through the slope.
///
/// What is added is judged on a smoothed meter and cleared of noise: the relation's residual holds the meter's noise too. What a short slope
/// tells beyond a long one is added where it is far more than its noise: so calm flow gets none of it, and a sharp change stays sharp.
/// Nothing is added where the meter has a gap, or has ended, before it tells what the line did.
fn line_flow(meter: &[f64], path: MeterPath, dt_s: f64, noise: f64) -> Vec<f64> {
    let last = meter.len().saturating_sub(1);
    let shift = path.delay_s / dt_s;
    let half = whole(SMOOTHED_S / dt_s).max(1);
    let smooth = smoothed(meter, half);
    // Noise of the difference of two means.
    let of_means = noise * (2.0 / (2 * half + 1) as f64).sqrt();
    let slopes = (path.lag_s > 0.0).then(|| {
        let long = CALM_S.max(0.5 * path.lag_s);
        [long, SHARP_S].map(|half_s| held_back(meter, path.lag_s, dt_s, noise, half_s))
    });
    (meter.iter().enumerate())
        .map(|(i, q)| {
            let later = at(&smooth, i as f64 + shift) - smooth[i];
            // Standing mud has no store to fill: the meter's 0 is a valve's.
            let Some([(calm, calm_noise), (sharp, sharp_noise)]) =
                slopes.as_ref().filter(|_| *q > STANDING_M3_S)
            else {
                return q + shrunk(later, of_means);
            };
            let here = whole(i as f64 + shift).min(last);
            let held = calm(here);
            let more = if later.is_finite() {
                cleared(sharp(here) - held, *sharp_noise)
            } else {
                0.0
            };
            q + shrunk(later + held, of_means + calm_noise) + more
        })
        .collect()
}

/// Evidence that a meter's path loses over a span, s, as it is turned round where readings tell something new every so often, s.
pub(crate) fn blurred(path: MeterPath, span_s: (f64, f64), told_every_s: f64) -> f64 {
    let samples = |over_s: f64| whole(over_s / told_every_s).max(1);
    // Of slow readings a delay is had from values as far apart as a slope.
    if path.lag_s > 0.0 && samples(CALM_S) > samples(SMOOTHED_S) {
        BLURRED * ((span_s.1 - span_s.0) / 3600.0).min(MOST_HOURS)
    } else {
        0.0
    }
}

/// What lies between line and meter under a hypothesis.
pub(crate) fn meter_path(applied: &[Applied]) -> MeterPath {
    let mut path = MeterPath::default();
    for one in applied {
        let p = one.effect.meter_path(&one.parameters);
        path.delay_s += p.delay_s;
        path.lag_s += p.lag_s;
    }
    path
}

/// Flow of the line, as the meter's path under a hypothesis has it.
#[derive(Debug, Clone)]
pub(crate) struct LineFlow {
    path: MeterPath,
    /// With gaps, and without; `None` where nothing stands between line and meter.
    inverted: Option<(Vec<f64>, Vec<f64>)>,
}

impl LineFlow {
    /// The flow under a hypothesis.
    pub(crate) fn under(record: &Record, applied: &[Applied]) -> Self {
        let path = meter_path(applied);
        let inverted = (path != MeterPath::default()).then(|| {
            let noise = record.setting.noise.flow_m3_s;
            let flow = line_flow(&record.flow, path, record.dt_s, noise);
            let filled = crate::numbers::bridged(&flow);
            (flow, filled)
        });
        Self { path, inverted }
    }

    /// Whether it is that of another hypothesis, digit for digit.
    pub(crate) fn is(&self, other: &Self) -> bool {
        self.path == other.path
    }

    /// Flow of every sample with gaps, and without.
    pub(super) fn of<'a>(&'a self, record: &'a Record) -> (&'a [f64], &'a [f64]) {
        match &self.inverted {
            Some((flow, filled)) => (flow, filled),
            None => (&record.flow, &record.filled.flow),
        }
    }
}

#[cfg(test)]
mod tests;
