//! Readings without the dust that arithmetic leaves on them.

use crate::{Channel, Recording};
use dgd_units::Dimension;
use rayon::prelude::*;

/// Takes out of readings what no transmitter tells, so that one that is held is known by being equal.
///
/// Conversion, filtering and interpolation leave rounding errors; a frozen reading then never repeats itself in every bit. A
/// value within 1 Pa, 10⁻⁸ m³/s or 10⁻⁵ % of the last that was taken as new becomes equal to it. That is less than a hundredth
/// of what the transmitters of a rig resolve. What is settled already stays as it is. The recording may come in blocks.
///
/// ```
/// use dgd_recording::{Recording, Settle};
///
/// let mut recording = Recording {
///     pump_speed_pct: vec![60.0, 60.0 + 1e-9, 60.0 - 1e-9, 60.1],
///     ..Recording::default()
/// };
/// Settle::default().add(&mut recording);
/// assert_eq!(recording.pump_speed_pct, [60.0, 60.0, 60.0, 60.1]);
/// ```
#[derive(Debug, Clone, Default)]
pub struct Settle {
    /// The last new value of each series.
    last: Vec<(Channel, f64)>,
}

impl Settle {
    /// Settles the next samples, in place; with other transmitters than before it begins anew.
    pub fn add(&mut self, block: &mut Recording) {
        let channels: Vec<Channel> = block.series().iter().map(|(channel, _)| *channel).collect();
        if !channels
            .iter()
            .eq(self.last.iter().map(|(channel, _)| channel))
        {
            self.last = channels
                .into_iter()
                .map(|channel| (channel, f64::NAN))
                .collect();
        }
        let each: Vec<_> = block.series_mut().zip(&mut self.last).collect();
        each.into_par_iter().for_each(|(values, (channel, last))| {
            settle(values, resolved(channel.dimension()), last);
        });
    }
}

/// What no transmitter resolves, SI.
fn resolved(dimension: Dimension) -> f64 {
    match dimension {
        Dimension::Pressure => 1.0,
        Dimension::FlowRate => 1e-8,
        _ => 1e-5,
    }
}

/// Compares with the first value of a run: a slow drift is no run.
fn settle(values: &mut [f64], least: f64, last: &mut f64) {
    /// Samples looked at together.
    const STRETCH: usize = 64;
    for stretch in values.chunks_mut(STRETCH) {
        let [first, .., end] = stretch else {
            settle_each(stretch, least, last);
            continue;
        };
        let (first, end) = (*first, *end);
        if stays(*last, first, least) & all_stay(stretch, least) {
            *last = end;
        } else {
            settle_each(stretch, least, last);
        }
    }
}

/// Whether a value stays as it is after one that does: it is equal in every bit, or moves on. Neither NaN nor infinity moves on.
fn stays(before: f64, after: f64, least: f64) -> bool {
    let step = (after - before).abs();
    ((step >= least) & (step < f64::INFINITY)) | (before.to_bits() == after.to_bits())
}

/// Whether every value of a stretch stays, if the first does; without an early exit, so that the compiler can vectorise it.
fn all_stay(stretch: &[f64], least: f64) -> bool {
    let strays = |(before, after): (&f64, &f64)| u64::from(!stays(*before, *after, least));
    stretch.iter().zip(&stretch[1..]).map(strays).sum::<u64>() == 0
}

/// The same, sample by sample.
fn settle_each(values: &mut [f64], least: f64, last: &mut f64) {
    for value in values {
        // A missing value compares false and is not a new one.
        if (*value - *last).abs() < least {
            *value = *last;
        } else if value.is_finite() {
            *last = *value;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn recording(flow: &[f64], inlet: &[f64]) -> Recording {
        Recording {
            return_flow_m3_s: flow.to_vec(),
            pump_inlet_pressure_pa: vec![inlet.to_vec()],
            ..Recording::default()
        }
    }

    #[test]
    fn dust_goes_and_what_a_transmitter_tells_stays() {
        let mut one = recording(
            &[0.03, 0.03 + 1e-12, f64::NAN, 0.03 - 1e-12, 0.03 + 1e-6],
            &[24e5, 24e5 + 0.4, 24e5 - 0.4, 24e5 + 10.0, f64::INFINITY],
        );
        Settle::default().add(&mut one);
        assert_eq!(one.return_flow_m3_s[..2], [0.03; 2]);
        assert!(one.return_flow_m3_s[2].is_nan());
        assert_eq!(one.return_flow_m3_s[3..], [0.03, 0.03 + 1e-6]);
        let inlet = [24e5, 24e5, 24e5, 24e5 + 10.0, f64::INFINITY];
        assert_eq!(one.pump_inlet_pressure_pa[0], inlet);
    }

    #[test]
    fn a_slow_drift_goes_on_and_blocks_settle_as_the_whole() {
        let drift: Vec<f64> = (0..1000).map(|i| 24e5 + 0.3 * f64::from(i)).collect();
        let mut whole = recording(&drift, &drift);
        Settle::default().add(&mut whole);
        let settled = &whole.pump_inlet_pressure_pa[0];
        let off = |(a, b): (&f64, &f64)| (a - b).abs();
        assert!(settled.iter().zip(&drift).map(off).all(|d| d < 1.0));
        assert!(settled.windows(5).all(|w| w[0] != w[4]));
        let mut again = whole.clone();
        Settle::default().add(&mut again);
        assert_eq!(again, whole);
        let mut settle = Settle::default();
        let mut parts = Recording::default();
        for part in drift.chunks(7) {
            let mut part = recording(part, part);
            settle.add(&mut part);
            parts.return_flow_m3_s.extend(part.return_flow_m3_s);
            let inlet = part.pump_inlet_pressure_pa.remove(0);
            parts.pump_inlet_pressure_pa.resize(1, Vec::new());
            parts.pump_inlet_pressure_pa[0].extend(inlet);
        }
        assert_eq!(parts, whole);
    }

    #[test]
    fn a_stretch_at_a_time_settles_as_a_sample_at_a_time() {
        let mut state = 7_u64;
        let mut random = move || {
            state = state.wrapping_mul(6_364_136_223_846_793_005);
            state = state.wrapping_add(1_442_695_040_888_963_407);
            state >> 59
        };
        // Of 1000 samples a few repeat, drift or are missing; some stretches hold none of them.
        let values: Vec<f64> = (0..1000)
            .map(|i| match (i / 100 % 3, random()) {
                (1, 0) => f64::NAN,
                (1, 1) => f64::INFINITY,
                (1, k) => 1e5 + 0.4 * k as f64,
                (2, _) => f64::from(i / 3) * 100.0,
                (_, k) => f64::from(i % 7) * 100.0 + k as f64,
            })
            .chain([f64::NAN; 200])
            .chain([f64::INFINITY; 100])
            .chain([-0.0, 0.0, -0.0])
            .collect();
        let bits = |values: &[f64]| values.iter().map(|v| v.to_bits()).collect::<Vec<_>>();
        let (mut fast, mut slow) = (values.clone(), values);
        let (mut of_fast, mut of_slow) = (f64::NAN, f64::NAN);
        settle(&mut fast, 1.0, &mut of_fast);
        settle_each(&mut slow, 1.0, &mut of_slow);
        assert_eq!(bits(&fast), bits(&slow));
        assert_eq!(of_fast.to_bits(), of_slow.to_bits());
    }
}
