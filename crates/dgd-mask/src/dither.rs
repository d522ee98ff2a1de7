//! Noise that hides a transmitter's step from whoever averages, compares or measures the noise itself.

use dgd_recording::{Recording, quantum};
use dgd_units::MaskReferences;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use sha2::{Digest, Sha256};
use std::f64::consts::{FRAC_PI_2, TAU};

/// Standard deviation of each component, of the reference. It must not be taken from the step: a reader measures it
/// where the pump stands still, and would have the step.
const SHARE: f64 = 5e-4;
/// Coarser transmitters get the next of these multiples of [`SHARE`], which tells their step to this factor.
const RUNG: f64 = 4.0;
/// The least standard deviation of a component, in steps. A comb of pitch s is left at exp(-2 pi² (sd/s)²): here less
/// than 1e-2 of it in what one component covers, 1e-14 in all of them together.
const STEPS: f64 = 0.5;
/// A coarser common measure of a few changes, of the reference, is that of set-points and not a transmitter's step: noise that
/// hid it would hide the recording.
const SET_POINTS: f64 = 0.01;
/// Changes that [`step_of_plateaus`] looks at; of more than these a [`quantum`] is told.
const CHANGES: usize = 20;
/// The periods of the components, samples: whatever one averages over, one of them does not average out.
const PERIODS: [i64; 7] = [1, 4, 16, 64, 256, 1024, 4096];
/// Noises that are drawn: inflow, return flow, inlet, outlet.
pub(crate) const NOISES: usize = 4;

/// Standard deviation of a component for transmitters, as a share of what stands for 100 %.
///
/// `reference` is in the unit of the series.
pub(crate) fn share(transmitters: &[&[f64]], reference: f64) -> f64 {
    let step = |values: &&[f64]| quantum(values).or_else(|| step_of_plateaus(values, reference));
    let steps = transmitters.iter().filter_map(step);
    let coarsest = steps.fold(0.0, f64::max) / reference;
    let mut share = SHARE;
    // Ends: a step is finite, and so is what it is a share of.
    while share < STEPS * coarsest && share < 1.0 {
        share *= RUNG;
    }
    share
}

/// The step of a transmitter that changes too rarely for [`quantum`]: the largest one of which all changes are multiples, if it
/// is no more than [`SET_POINTS`].
fn step_of_plateaus(values: &[f64], reference: f64) -> Option<f64> {
    let told: Vec<f64> = values.iter().copied().filter(|v| v.is_finite()).collect();
    let changes = told.windows(2).map(|w| (w[1] - w[0]).abs());
    let rounding = 1e-9 * reference;
    let changes = changes.filter(|change| *change > rounding);
    let step = changes.take(CHANGES).fold(0.0, |step, change| {
        common_measure(step, change, 1e-6 * reference)
    });
    (step > 0.0 && step <= SET_POINTS * reference).then_some(step)
}

/// Euclid's greatest common measure of two lengths; what is shorter than `least` is none.
fn common_measure(a: f64, b: f64, least: f64) -> f64 {
    let (mut long, mut short) = (a.max(b), a.min(b));
    while short > least {
        // The nearest multiple, from either side: a remainder just below the step is rounding.
        let rest = (long - short * (long / short).round()).abs();
        (long, short) = (short, rest);
    }
    long
}

/// Noises of unit components, one for each of [`NOISES`], as long as the recording.
///
/// Every component is a row of normal draws a period apart, blended between neighbours at constant variance. A draw is
/// keyed by the references, its time and all values of the recording then: cut or joined elsewhere, a recording gets the
/// same noise, and no two recordings share it.
pub(crate) fn flicker(
    recording: &Recording,
    step_s: f64,
    references: &MaskReferences,
) -> [Vec<f64>; NOISES] {
    let len = recording.len();
    let mut noises: [Vec<f64>; NOISES] = std::array::from_fn(|_| vec![0.0; len]);
    if len == 0 {
        return noises;
    }
    let series = recording.series();
    let rows: Vec<&[f64]> = series.iter().map(|(_, values)| *values).collect();
    let mut key = Sha256::new_with_prefix(b"dither");
    for reference in references.disclose() {
        key.update(reference.to_le_bytes());
    }
    // Samples since the clock's zero, the same in every cut of a recording.
    let first = recording.time_s.first().copied().unwrap_or(0.0);
    let start = whole(first / step_s);
    let last = start + i64::try_from(len).unwrap_or(i64::MAX).min(1 << 52) - 1;
    for period in PERIODS {
        let (from, to) = (start.div_euclid(period), last.div_euclid(period) + 1);
        let knots: Vec<[f64; NOISES]> = (from..=to)
            .map(|knot| {
                // Beyond the ends there is no row; the nearest stands in.
                let at = (knot * period).clamp(start, last) - start;
                let at = usize::try_from(at).unwrap_or(0);
                draw(&key, period, knot, rows.iter().map(|values| values.get(at)))
            })
            .collect();
        for (noise, values) in noises.iter_mut().enumerate() {
            for (value, number) in values.iter_mut().zip(start..) {
                let knot = usize::try_from(number.div_euclid(period) - from).unwrap_or(0);
                let between = number.rem_euclid(period) as f64 / period as f64;
                let (after, before) = (FRAC_PI_2 * between).sin_cos();
                let [left, right] =
                    [knot, knot + 1].map(|k| knots.get(k).map_or(0.0, |g| g[noise]));
                *value += before * left + after * right;
            }
        }
    }
    noises
}

/// Normal draws for one knot.
fn draw<'a>(
    key: &Sha256,
    period: i64,
    knot: i64,
    row: impl Iterator<Item = Option<&'a f64>>,
) -> [f64; NOISES] {
    let mut digest = key.clone();
    digest.update(period.to_le_bytes());
    digest.update(knot.to_le_bytes());
    for value in row {
        // One NaN is as good as another.
        let value = value.filter(|v| !v.is_nan()).unwrap_or(&f64::NAN);
        digest.update(value.to_le_bytes());
    }
    let mut random = ChaCha8Rng::from_seed(digest.finalize().into());
    std::array::from_fn(|_| {
        // Box and Muller; 1 - u is never 0.
        let radius = (-2.0 * (1.0 - share_of_one(&mut random)).ln()).sqrt();
        radius * (TAU * share_of_one(&mut random)).cos()
    })
}

/// From 0 to below 1, in steps of 2^-53.
///
/// The generator's bits are specified, what `rand` makes of them may change from release to release: and then the noise.
fn share_of_one(random: &mut ChaCha8Rng) -> f64 {
    const STEP: f64 = 0.5 * f64::EPSILON;
    (random.next_u64() >> 11) as f64 * STEP
}

/// The nearest whole number; 0 of what has none, within what products of a period hold.
fn whole(value: f64) -> i64 {
    const BOUND: f64 = 1e12;
    let value = if value.is_finite() {
        value.round()
    } else {
        0.0
    };
    #[expect(clippy::cast_possible_truncation, reason = "bounded, and whole")]
    let whole = value.clamp(-BOUND, BOUND) as i64;
    whole
}

#[cfg(test)]
mod tests {
    use super::*;
    use dgd_units::FullScale;

    #[expect(clippy::unwrap_used, reason = "a test may fail by panic")]
    fn references() -> MaskReferences {
        MaskReferences::new(FullScale {
            flow_m3_s: 0.07,
            friction_pa: 6e5,
            head_m: 190.0,
            level_m: 200.0,
        })
        .unwrap()
    }

    fn recording(from: usize, to: usize) -> Recording {
        let row = |f: fn(f64) -> f64| (from..to).map(|i| f(i as f64)).collect::<Vec<f64>>();
        Recording {
            time_s: row(|t| 1e6 + t),
            mud_pump_flow_m3_s: row(|t| (t / 7.0).floor()),
            booster_flow_m3_s: row(|_| 0.0),
            topfill_flow_m3_s: row(|_| f64::NAN),
            return_flow_m3_s: row(|t| (t / 11.0).floor()),
            pump_speed_pct: row(|_| 70.0),
            ..Recording::default()
        }
    }

    #[test]
    fn a_cut_has_the_noise_of_the_whole_but_near_its_ends() {
        let whole = flicker(&recording(0, 20_000), 1.0, &references());
        let cut = flicker(&recording(5_000, 17_000), 1.0, &references());
        // Up to a period at each end leans on a row outside.
        let inner = 4_096..12_000 - 4_096;
        for (whole, cut) in whole.iter().zip(&cut) {
            assert_eq!(
                cut[inner.clone()],
                whole[inner.start + 5_000..inner.end + 5_000]
            );
        }
    }

    /// Pinned: the mean of two different noises on one recording has less noise than either.
    #[test]
    fn the_noise_is_pinned() {
        let noises = flicker(&recording(0, 5_000), 1.0, &references());
        let found = noises.map(|noise| [noise[0], noise[4_321]]);
        let expected = [
            [-1.669_410_166_706_860_2, 2.402_951_252_847_018],
            [-7.098_673_269_746_592, 3.863_517_463_743_485_3],
            [2.259_880_324_674_797, -2.150_671_473_102_296],
            [1.240_895_065_974_454_9, 0.981_862_035_468_833_9],
        ];
        let mut pairs = found.iter().flatten().zip(expected.iter().flatten());
        // Logarithm and cosine may differ by a last digit between platforms.
        assert!(pairs.all(|(a, b)| (a - b).abs() < 1e-9), "{found:?}");
    }

    #[test]
    fn another_recording_or_other_references_have_other_noise() {
        let plain = flicker(&recording(0, 5_000), 1.0, &references());
        let mut other = recording(0, 5_000);
        other.pump_speed_pct.fill(70.1);
        let other = flicker(&other, 1.0, &references());
        #[expect(clippy::unwrap_used, reason = "a test may fail by panic")]
        let references = MaskReferences::new(FullScale {
            flow_m3_s: 0.07,
            friction_pa: 6e5,
            head_m: 190.0,
            level_m: 201.0,
        })
        .unwrap();
        let elsewhere = flicker(&recording(0, 5_000), 1.0, &references);
        for noises in [other, elsewhere] {
            for (a, b) in plain.iter().zip(&noises) {
                assert!(a.iter().zip(b).all(|(a, b)| a != b));
            }
        }
    }

    #[test]
    fn however_long_one_averages_neighbouring_means_stay_apart() {
        let noises = flicker(&recording(0, 400_000), 1.0, &references());
        for length in [1, 3, 10, 30, 100, 300, 1000, 3000] {
            let (mut squares, mut count) = (0.0, 0.0);
            for noise in &noises {
                let means: Vec<f64> = noise
                    .chunks_exact(length)
                    .map(|part| part.iter().sum::<f64>() / length as f64)
                    .collect();
                squares += means.windows(2).map(|w| (w[1] - w[0]).powi(2)).sum::<f64>();
                count += (means.len() - 1) as f64;
            }
            let apart = (squares / count).sqrt();
            // In standard deviations of a component, which are half a step or more.
            assert!(apart > 1.0, "{length}: {apart}");
        }
    }

    #[test]
    fn a_clock_or_step_out_of_all_bounds_is_no_trouble() {
        for (first, step) in [
            (f64::NAN, 1.0),
            (1e300, 1.0),
            (-1e300, 0.0),
            (0.0, f64::NAN),
        ] {
            let mut odd = recording(0, 10);
            odd.time_s[0] = first;
            let noises = flicker(&odd, step, &references());
            assert!(noises.iter().flatten().all(|v| v.is_finite()));
        }
        let none = flicker(&Recording::default(), 1.0, &references());
        assert!(none.iter().all(Vec::is_empty));
    }

    #[test]
    fn the_noise_is_a_share_of_the_reference_and_tells_a_coarse_step_to_a_factor() {
        let saw = |step: f64| -> Vec<f64> { (0..200).map(|i| f64::from(i % 5) * step).collect() };
        for (step, expected) in [
            (1e-5, 5e-4),
            (9e-4, 5e-4),
            (1.1e-3, 2e-3),
            (3.9e-3, 2e-3),
            (0.1, 0.128),
        ] {
            let found = share(&[&saw(step * 0.07)], 0.07);
            assert!((found - expected).abs() < 1e-9, "{step}: {found}");
        }
        assert!((share(&[&[0.0; 50]], 0.07) - 5e-4).abs() < 1e-12);
    }

    #[test]
    fn a_few_plateaus_tell_their_step_and_two_set_points_are_none() {
        let plateaus = |steps: &[f64], step: f64| -> Vec<f64> {
            let held = steps.iter().map(|n| [n * step * 0.07, f64::NAN]);
            held.flatten().collect()
        };
        for (steps, step, expected) in [
            (&[150.0, 163.0, 155.0][..], 3.9e-3, 2e-3),
            (&[150.0, 240.0, 171.0, 203.0], 3.9e-3, 2e-3),
            (&[0.0, 1.0, 0.0], 0.025, 5e-4),
            (&[6.0, 7.0, 8.0], 0.1, 5e-4),
        ] {
            let found = share(&[&plateaus(steps, step)], 0.07);
            assert!((found - expected).abs() < 1e-9, "{steps:?}: {found}");
        }
    }
}
