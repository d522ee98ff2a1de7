//! Readings that are means of the seconds before them.
//!
//! The mean of `n` readings passes `(sin(π f n Δt) / (n sin(π f Δt)))²` of a power: nothing at the periods that its length is a multiple of. Between these
//! notches power stands over what is about it, as that of swell does.

use super::{colour, floor_about, mean, smooth};
use crate::numbers::{spread, whole};
use dgd_recording::{Rank, quantile};
use std::f64::consts::{FRAC_PI_2, PI};

/// Longest mean that is looked for, s.
const LONGEST_S: f64 = 40.0;
/// Power over floor that each notch must lie below, and by how much less the bins must scatter without them. Set by hand.
const NOTCH: f64 = 0.5;
const SCATTER: f64 = 0.75;
/// Beyond its first half a lobe, bins of which a mean passes less than this share of what it does between its notches tell nothing.
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
                let told = share > PASSED || n * angle < FRAC_PI_2;
                (share / (n * angle.sin()).powi(2) + noise, told)
            })
            .unzip();
        Self { passed, told }
    }

    /// Of the values of all bins those that tell something.
    fn of_told<T: Copy>(&self, values: &[T]) -> Vec<T> {
        let all = values.iter().zip(&self.told);
        all.filter_map(|(value, told)| told.then_some(*value))
            .collect()
    }

    /// A spectrum without what it does, where it tells something.
    fn undone(&self, power: &[f64]) -> Vec<f64> {
        let all = power.iter().zip(&self.passed);
        let undone: Vec<f64> = all.map(|(power, passed)| power / passed).collect();
        self.of_told(&undone)
    }

    /// Whether enough is left to tell a floor.
    fn leaves_half(&self) -> bool {
        2 * self.told.iter().filter(|told| **told).count() > self.told.len()
    }
}

/// Spectra without what a mean of readings did to them, if one did, and the bins that are left of them.
pub(super) fn undone(
    spectra: Vec<Vec<f64>>,
    bins: Vec<usize>,
    (m, step_s): (usize, f64),
) -> (Vec<Vec<f64>>, Vec<usize>) {
    let power = smooth(&mean(&spectra));
    let flat = colourless(&power, &bins);
    let deep: Vec<bool> = (0..flat.len())
        .map(|b| flat[b] < NOTCH * floor_about(&flat, b))
        .collect();
    // Where a notch of a mean of so many readings lies in the band, and whether power is low at each.
    let has_notches = |readings: &usize| {
        let spacing = m as f64 / *readings as f64;
        let places = (1..=readings / 2).map(|k| whole(k as f64 * spacing));
        let mut notches = places
            .filter_map(|place| bins.iter().position(|k| *k == place))
            .peekable();
        notches.peek().is_some() && notches.all(|b| deep[b])
    };
    let scatter = |power: &[f64], bins: &[usize]| {
        let flat: Vec<f64> = (colourless(power, bins).iter()).map(|p| p.ln()).collect();
        let middle = quantile(flat.iter().copied(), Rank::MEDIAN).unwrap_or(f64::NAN);
        spread(flat.iter().map(|p| p - middle))
    };
    let means = (2..=whole(LONGEST_S / step_s))
        .filter(has_notches)
        .flat_map(|n| NOISE.map(|noise| Mean::of(n, noise, &bins, m)))
        .filter(Mean::leaves_half);
    let judged = means.map(|mean| {
        let told = mean.of_told(&bins);
        let left = scatter(&mean.undone(&power), &told);
        (left / scatter(&mean.of_told(&power), &told), mean)
    });
    match judged.min_by(|a, b| a.0.total_cmp(&b.0)) {
        Some((left, mean)) if left < SCATTER => (
            spectra.iter().map(|s| mean.undone(s)).collect(),
            mean.of_told(&bins),
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
