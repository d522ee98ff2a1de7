//! The line's flow from the reading of its meter.

use super::Applied;
use crate::record::{Record, mean, whole};
use dgd_effects::{MeterPath, STANDING_M3_S, shrunk};

/// To either side of a sample, s, the meter is smoothed for what it shows later.
const SMOOTHED_S: f64 = 4.0;
/// The same for its slope, which is taken over as long again: half as far, its noise makes small stores look like delays in simulated
/// recordings.
const SLOPE_S: f64 = 8.0;

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

/// The line's flow from its meter: the meter path inverted, a lag through the slope over some seconds.
///
/// What is added is judged on a smoothed meter and cleared of noise: the relation's residual holds the meter's noise too.
/// Nothing is added where the meter has a gap, or has ended, before it tells what the line did.
fn line_flow(meter: &[f64], path: MeterPath, dt_s: f64, noise: f64) -> Vec<f64> {
    let n = meter.len();
    let shift = path.delay_s / dt_s;
    let half = whole(SMOOTHED_S / dt_s).max(1);
    let slope_half = whole(SLOPE_S / dt_s).max(1);
    let smooth = smoothed(meter, half);
    let steady = if path.lag_s > 0.0 {
        smoothed(meter, slope_half)
    } else {
        Vec::new()
    };
    let reach = whole(path.lag_s.min(SLOPE_S) / dt_s).max(1);
    let slope = |i: usize| -> f64 {
        let (a, b) = (i.saturating_sub(reach), (i + reach).min(n - 1));
        (steady[b] - steady[a]) / ((b - a).max(1) as f64 * dt_s)
    };
    // Noise of the difference of two means, which may share samples.
    let of_two = |half: usize, apart: usize| {
        let window = 2 * half + 1;
        noise * (2.0 * window.min(apart) as f64).sqrt() / window as f64
    };
    let over_s = 2.0 * reach as f64 * dt_s;
    let floor = of_two(half, usize::MAX) + of_two(slope_half, 2 * reach) * path.lag_s / over_s;
    (0..n)
        .map(|i| {
            let mut ahead = at(&smooth, i as f64 + shift) - smooth[i];
            if path.lag_s > 0.0 && meter[i] > STANDING_M3_S {
                // Standing mud has no store to fill: the meter's 0 is a valve's.
                let here = whole(i as f64 + shift).min(n - 1);
                ahead += path.lag_s * slope(here);
            }
            meter[i] + shrunk(ahead, floor)
        })
        .collect()
}

/// Flow of the line, as the meter's path under a hypothesis has it.
#[derive(Debug, Clone)]
pub(crate) struct LineFlow {
    /// With gaps, and without; `None` where nothing stands between line and meter.
    inverted: Option<(Vec<f64>, Vec<f64>)>,
}

impl LineFlow {
    /// The flow under a hypothesis.
    pub(crate) fn under(record: &Record, applied: &[Applied]) -> Self {
        let mut path = MeterPath::default();
        for one in applied {
            let p = one.effect.meter_path(&one.parameters);
            path.delay_s += p.delay_s;
            path.lag_s += p.lag_s;
        }
        let inverted = (path != MeterPath::default()).then(|| {
            let noise = record.setting.noise.flow_m3_s;
            let flow = line_flow(&record.flow, path, record.dt_s, noise);
            let filled = crate::record::bridged(&flow);
            (flow, filled)
        });
        Self { inverted }
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
