//! Readings that are means of the seconds before them.
//!
//! The mean of `n` readings passes `(sin(π f n Δt) / (n sin(π f Δt)))²` of a power: nothing at the periods that its length is a multiple of. Between these
//! notches power stands over what is about it, as that of swell does.

use super::{colour, floor_about, mean, smooth};
use crate::numbers::{spread, whole};
use dgd_recording::{Rank, quantile};
use std::f64::consts::PI;

/// Longest mean that is looked for, s.
const LONGEST_S: f64 = 60.0;
/// Power over floor that some bin falls below if there are notches, and by how much less the bins must scatter without them. Set by hand.
const NOTCH: f64 = 0.3;
const SCATTER: f64 = 0.6;
/// Bins of which a mean passes less than this share of what it does between its notches tell nothing.
const PASSED: f64 = 0.1;
/// Noise that came after the mean, over that before it.
const NOISE: [f64; 5] = [0.0, 1e-3, 3e-3, 1e-2, 3e-2];

/// A mean, by what it does to the power of each bin.
struct Mean {
    /// What it passes and what is added to it.
    passed: Vec<f64>,
    /// Bins that tell something.
    told: Vec<bool>,
}

impl Mean {
    /// Of so many readings, in segments of `m`.
    fn of(readings: usize, noise: f64, bins: &[usize], m: usize) -> Self {
        let n = readings as f64;
        let angles = bins.iter().map(|k| PI * *k as f64 / m as f64);
        let (passed, told) = angles
            .map(|angle| {
                let share = (n * angle).sin().powi(2);
                (share / (n * angle.sin()).powi(2) + noise, share > PASSED)
            })
            .unzip();
        Self { passed, told }
    }

    /// What it tells, without what it does.
    fn undone(&self, power: &[f64]) -> Vec<f64> {
        let all = power.iter().zip(&self.passed).zip(&self.told);
        all.filter(|(_, told)| **told)
            .map(|((power, passed), _)| power / passed)
            .collect()
    }

    fn told(&self, bins: &[usize]) -> Vec<usize> {
        let all = bins.iter().zip(&self.told);
        all.filter_map(|(bin, told)| told.then_some(*bin)).collect()
    }
}

/// Spectra without what a mean of readings did to them, if one did, and the bins that are left of them.
pub(super) fn undone(
    spectra: Vec<Vec<f64>>,
    bins: Vec<usize>,
    (m, step_s): (usize, f64),
) -> (Vec<Vec<f64>>, Vec<usize>) {
    let power = smooth(&mean(&spectra));
    let whole_band = colourless(&power, &bins);
    let deep = |b: usize| whole_band[b] < NOTCH * floor_about(&whole_band, b);
    if !(0..power.len()).any(deep) {
        return (spectra, bins);
    }
    let scatter = |power: &[f64], bins: &[usize]| {
        let flat: Vec<f64> = (colourless(power, bins).iter()).map(|p| p.ln()).collect();
        let middle = quantile(flat.iter().copied(), Rank::MEDIAN).unwrap_or(f64::NAN);
        spread(flat.iter().map(|p| p - middle))
    };
    let means = (2..=whole(LONGEST_S / step_s))
        .flat_map(|n| NOISE.map(|noise| Mean::of(n, noise, &bins, m)));
    let best = means
        .map(|mean| (scatter(&mean.undone(&power), &mean.told(&bins)), mean))
        .min_by(|a, b| a.0.total_cmp(&b.0));
    match best {
        Some((left, mean)) if left < SCATTER * scatter(&power, &bins) => (
            spectra.iter().map(|s| mean.undone(s)).collect(),
            mean.told(&bins),
        ),
        _ => (spectra, bins),
    }
}

/// Powers over the straight line in logarithms that they go along.
fn colourless(power: &[f64], bins: &[usize]) -> Vec<f64> {
    let colour = colour(power, bins);
    let all = power.iter().zip(bins);
    all.map(|(p, k)| p / (*k as f64).powf(colour)).collect()
}
