//! Rig motion: a narrow peak of swell in the spectrum of the inlet pressure.

mod averages;

use crate::numbers::{bridged, spread, whole};
use dgd_recording::{Rank, held_for, quantile};
use dgd_units::STANDARD_GRAVITY_M_S2;
use std::borrow::Cow;

/// How far above the highest peak of noise alone swell is believed: floors of real spectra are not quite smooth.
const ABOVE_NOISE: f64 = 1.4;
/// Peak over floor from which swell is believed at the least, however many stretches are averaged.
const LEAST_RATIO: f64 = 2.0;

/// A peak found.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Swell {
    pub period_s: f64,
    /// One standard deviation of the period.
    pub period_sd_s: f64,
    pub amplitude_m: f64,
    /// One standard deviation of the amplitude.
    pub amplitude_sd_m: f64,
    /// Power of the peak over the floor about it.
    pub ratio: f64,
    /// That from which swell is believed.
    pub believed: f64,
    /// Natural logarithm of the likelihood ratio of the peak against its floor, less that of the places that it could have been.
    pub evidence: f64,
    /// The evidence of a peak that is just believed.
    pub hurdle: f64,
    /// The smallest amplitude that would be believed, whatever its period.
    pub limit_m: f64,
    /// A shorter period that shows as this one at the recording's sampling, unless something before the logger keeps it out.
    pub folded_s: Option<f64>,
}

/// The period about the Nyquist frequency that readings a step apart show as another one; `None` of one shorter than swell is.
fn folded(period_s: f64, step_s: f64) -> Option<f64> {
    /// Set by hand: wind sea is shorter, and moves no rig.
    const SHORTEST_S: f64 = 4.0;
    let folded_s = 1.0 / (1.0 / step_s - 1.0 / period_s);
    (folded_s > SHORTEST_S).then_some(folded_s)
}

/// Length of a segment of the periodogram, s, but for what is no whole sample.
const SEGMENT_S: f64 = 512.0;
/// Longest stretch of missing samples that is bridged, s: half of the shortest swell.
const BRIDGED_S: f64 = 2.5;
/// Share of a segment that may be bridged.
const MISSING: f64 = 0.1;

/// Segments that tell a peak from noise at the least.
const LEAST_SEGMENTS: usize = 6;

/// Why a recording cannot show swell.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Unseen {
    /// A period has too few samples.
    Slow,
    /// Too few segments are there, or have next to all their samples.
    Short,
    /// In too many segments one value is repeated.
    Still,
    /// An archive has drawn straight lines between a few readings.
    Archived,
}

impl Unseen {
    /// The reason in words.
    pub(crate) fn reason(self) -> &'static str {
        match self {
            Self::Slow => "the sampling is too slow to show swell",
            Self::Short => "too few nine-minute stretches have nearly all their inlet pressures",
            Self::Still => "the inlet pressure repeats one value",
            Self::Archived => "an archive kept too few of the pressures",
        }
    }
}

/// Looks for swell between 5 and 20 s.
pub(crate) fn swell(pressure_pa: &[f64], step_s: f64, density_kg_m3: f64) -> Result<Swell, Unseen> {
    let held = held_for(pressure_pa);
    if held > 1 && !passes_levels(pressure_pa, held) {
        // Readings that are repeated do not tell more of what lies between them.
        return spectral(
            &once(pressure_pa, held),
            step_s * held as f64,
            density_kg_m3,
        );
    }
    spectral(pressure_pa, step_s, density_kg_m3)
}

/// Whether values that change after so many samples as a rule are those of a coarse instrument, each of which swell passes in its turn,
/// rather than held readings: all changes are by one level, and next to none comes as late as one behind a reading that is repeated.
fn passes_levels(values: &[f64], held: usize) -> bool {
    let mut last: Option<(usize, f64)> = None;
    let (mut steps, mut late) = (Vec::new(), 0);
    for (i, v) in values.iter().enumerate().filter(|(_, v)| v.is_finite()) {
        if let Some((at, before)) = last.filter(|(_, before)| before != v) {
            steps.push((v - before).abs());
            late += usize::from(2 * (i - at) > 3 * held);
        }
        if last.is_none_or(|(_, before)| before != *v) {
            last = Some((i, *v));
        }
    }
    let level = steps.iter().copied().fold(f64::INFINITY, f64::min);
    let single = steps.iter().filter(|step| **step < 1.5 * level).count();
    20 * single >= 19 * steps.len() && 10 * late < steps.len()
}

/// Each reading once, of those that are held for so many samples.
fn once(values: &[f64], held: usize) -> Vec<f64> {
    let read = |held: &[f64]| held.iter().copied().find(|v| v.is_finite());
    (values.chunks(held))
        .map(|held| read(held).unwrap_or(f64::NAN))
        .collect()
}

/// The same of readings that are each there once.
fn spectral(pressure_pa: &[f64], step_s: f64, density_kg_m3: f64) -> Result<Swell, Unseen> {
    let m = whole(SEGMENT_S / step_s);
    let highest = (1.0 / 5.0_f64).min(0.48 / step_s);
    let lowest = 1.0 / 20.0;
    if m < 32 || highest < 1.5 * lowest {
        return Err(Unseen::Slow);
    }
    // As long as it is in whole samples.
    let segment_s = m as f64 * step_s;
    let bins: Vec<usize> =
        (whole((lowest * segment_s).ceil())..=whole((highest * segment_s).floor())).collect();
    let angles: Vec<f64> = bins
        .iter()
        .map(|k| 2.0 * std::f64::consts::PI * *k as f64 / m as f64)
        .collect();
    // All segments are of one length, and sines are dear: window and turns, bin by bin at each sample.
    let n = (m - 1) as f64;
    let window: Vec<f64> = (0..m - 1)
        .map(|i| 0.5 - 0.5 * (2.0 * std::f64::consts::PI * i as f64 / n).cos())
        .collect();
    let turns: Vec<(f64, f64)> = (0..m - 1)
        .flat_map(|i| angles.iter().map(move |angle| (angle * i as f64).sin_cos()))
        .collect();
    let mut spectra: Vec<Vec<f64>> = Vec::new();
    let mut still = 0;
    for segment in pressure_pa.chunks_exact(m) {
        let Some(segment) = without_gaps(segment, step_s) else {
            continue;
        };
        // A level in motion is no swell: the difference of neighbours whitens it, and its gain is known.
        let rate: Vec<f64> = segment.windows(2).map(|w| w[1] - w[0]).collect();
        let Some(typical) = typical(&rate) else {
            still += 1;
            continue;
        };
        let mut sums = vec![(0.0, 0.0); bins.len()];
        let tapered = rate.iter().zip(&window);
        for ((v, window), turns) in tapered.zip(turns.chunks_exact(bins.len())) {
            let clipped = v.clamp(-6.0 * typical, 6.0 * typical) * window;
            for ((re, im), (sin, cos)) in sums.iter_mut().zip(turns) {
                *re += clipped * cos;
                *im += clipped * sin;
            }
        }
        let power = (sums.iter().zip(&angles))
            .map(|((re, im), angle)| {
                let gain = 2.0 * (angle / 2.0).sin();
                (re * re + im * im) / (gain * gain)
            })
            .collect();
        spectra.push(power);
    }
    if spectra.len() < LEAST_SEGMENTS {
        let enough = spectra.len() + still >= LEAST_SEGMENTS;
        return Err(if enough { Unseen::Still } else { Unseen::Short });
    }
    let (spectra, bins) = averages::undone(spectra, bins, (m, step_s));
    peak(&spectra, &bins, m, step_s, density_kg_m3).ok_or(Unseen::Short)
}

/// Size of usual differences of neighbours: of a coarse reading, most of which are 0, their root mean square; `None` if all are.
fn typical(rate: &[f64]) -> Option<f64> {
    let core = spread(rate.iter().copied());
    if core > 0.0 {
        return Some(core);
    }
    let square = rate.iter().map(|v| v * v).sum::<f64>() / rate.len() as f64;
    (square > 0.0).then(|| square.sqrt())
}

/// A segment with its few short gaps bridged; `None` if it has more, or longer ones.
fn without_gaps(segment: &[f64], step_s: f64) -> Option<Cow<'_, [f64]>> {
    let missing = segment.iter().filter(|v| !v.is_finite()).count();
    if missing == 0 {
        return Some(Cow::Borrowed(segment));
    }
    let longest = (segment.split(|v| v.is_finite())).map(<[f64]>::len).max()?;
    let few = missing as f64 <= MISSING * segment.len() as f64;
    (few && longest as f64 * step_s <= BRIDGED_S).then(|| Cow::Owned(bridged(segment)))
}

/// The highest peak of the mean of some spectra, of segments of `m` samples, over its floor; `None` if nothing is above that.
fn peak(
    spectra: &[Vec<f64>],
    bins: &[usize],
    m: usize,
    step_s: f64,
    density_kg_m3: f64,
) -> Option<Swell> {
    let segment_s = m as f64 * step_s;
    let mean = mean(spectra);
    let smooth = smooth(&mean);
    // The floor falls with frequency where noise is coloured: a straight line in logarithms, at the height of what is near.
    let colour = colour(&smooth, bins);
    let line: Vec<f64> = bins.iter().map(|k| (*k as f64).powf(colour)).collect();
    let flat: Vec<f64> = smooth.iter().zip(&line).map(|(p, line)| p / line).collect();
    let ratio = |b: usize| flat[b] / floor_about(&flat, b);
    let top = (0..flat.len()).max_by(|a, b| ratio(*a).total_cmp(&ratio(*b)))?;
    let (ratio, level) = (ratio(top), floor_about(&flat, top));
    let near = top.saturating_sub(4)..(top + 5).min(mean.len());
    let (mut weight, mut moment, mut second) = (0.0, 0.0, 0.0);
    for b in near.clone() {
        let above = (mean[b] - level * line[b]).max(0.0);
        let f = bins[b] as f64 / segment_s;
        weight += above;
        moment += above * f;
        second += above * f * f;
    }
    if weight <= 0.0 {
        return None;
    }
    let frequency = moment / weight;
    let width = (second / weight - frequency * frequency).max(0.0).sqrt();
    let sd = (width / (spectra.len() as f64).sqrt()).max(0.1 / segment_s);
    // Power of a windowed sine of amplitude a: a² (sum of window)² / 4, spread over the peak.
    let window = 0.5 * (m - 1) as f64;
    let energy = weight / 1.5;
    let amplitude = 2.0 * energy.sqrt() / window;
    // Swell comes in groups: stretches differ in power by more than noise makes them.
    let each = spectra.iter().map(|s| s[near.clone()].iter().sum::<f64>());
    let amplitude_error = 0.5 * standard_error(each) / weight;
    // Of a narrow peak's power a third stands in the mean of three bins.
    let floors = (0..flat.len()).map(|b| floor_about(&flat, b) * line[b]);
    let highest = (floors.filter(|f| f.is_finite())).fold(level * line[top], f64::max);
    let believed = (ABOVE_NOISE * highest_of_noise(spectra.len(), bins.len())).max(LEAST_RATIO);
    let seen = 3.0 * (believed - 1.0) * highest / 1.5;
    let per_metre = density_kg_m3 * STANDARD_GRAVITY_M_S2;
    Some(Swell {
        period_s: 1.0 / frequency,
        period_sd_s: sd / (frequency * frequency),
        amplitude_m: amplitude / per_metre,
        amplitude_sd_m: amplitude_error * amplitude / per_metre,
        ratio,
        believed,
        evidence: evidence_of(ratio, spectra.len(), bins.len()),
        hurdle: evidence_of(believed, spectra.len(), bins.len()),
        limit_m: 2.0 * seen.sqrt() / window / per_metre,
        folded_s: folded(1.0 / frequency, step_s),
    })
}

/// The mean of some spectra.
fn mean(spectra: &[Vec<f64>]) -> Vec<f64> {
    let bins = spectra.first().map_or(0, Vec::len);
    (0..bins)
        .map(|b| spectra.iter().map(|s| s[b]).sum::<f64>() / spectra.len() as f64)
        .collect()
}

/// The mean of each bin and its neighbours.
fn smooth(mean: &[f64]) -> Vec<f64> {
    (0..mean.len())
        .map(|b| {
            let r = b.saturating_sub(1)..(b + 2).min(mean.len());
            mean[r.clone()].iter().sum::<f64>() / r.len() as f64
        })
        .collect()
}

/// Independent powers of the three neighbours that each bin is averaged over: by Hann's window, neighbours share 4/9 of their power, those
/// beyond 1/36.
const INDEPENDENT: f64 = 1.86;

/// Natural logarithm of the likelihood ratio of a peak against its floor in the mean of some spectra, less that of the bins.
///
/// A power is an exponential variate about its mean (Whittle 1953), so `k` of them with a mean of `ratio` floors say `k (ratio - 1 - ln ratio)`.
fn evidence_of(ratio: f64, stretches: usize, bins: usize) -> f64 {
    INDEPENDENT * stretches as f64 * (ratio - 1.0 - ratio.ln()) - (bins as f64).ln()
}

/// Standard error of the mean of some values; 0 of fewer than two.
fn standard_error(values: impl Iterator<Item = f64> + Clone) -> f64 {
    let n = values.clone().count().max(2) as f64;
    let mean = values.clone().sum::<f64>() / n;
    let squares: f64 = values.map(|v| (v - mean).powi(2)).sum();
    (squares / (n - 1.0) / n).sqrt()
}

/// Power over floor that the highest of some bins exceeds in one recording of a thousand, of noise alone.
///
/// The mean of `k` independent powers is a gamma variate of shape `k`, whose cube root is nearly normal (Wilson and Hilferty 1931).
fn highest_of_noise(stretches: usize, bins: usize) -> f64 {
    const RATE: f64 = 1e-3;
    // Of the normal distribution's tail (Abramowitz and Stegun 26.2.23, to 5e-4).
    let t = (-2.0 * (RATE / bins as f64).ln()).sqrt();
    let z = t
        - (2.515_517 + t * (0.802_853 + t * 0.010_328))
            / (1.0 + t * (1.432_788 + t * (0.189_269 + t * 0.001_308)));
    let ninth = 1.0 / (9.0 * INDEPENDENT * stretches as f64);
    (1.0 - ninth + z * ninth.sqrt()).powi(3)
}

/// Power of the frequency that a floor goes with: the median over all pairs of bins, which a peak hardly moves (Theil and Sen).
fn colour(power: &[f64], bins: &[usize]) -> f64 {
    let slope =
        |i: usize, j: usize| (power[j] / power[i]).ln() / (bins[j] as f64 / bins[i] as f64).ln();
    let pairs = (0..bins.len()).flat_map(|i| (i + 1..bins.len()).map(move |j| (i, j)));
    quantile(pairs.map(|(i, j)| slope(i, j)), Rank::MEDIAN)
        .filter(|slope| slope.is_finite())
        .unwrap_or(0.0)
}

/// Median of the bins a little away from one.
fn floor_about(power: &[f64], b: usize) -> f64 {
    let around = (0..power.len())
        .filter(|k| (6..=22).contains(&k.abs_diff(b)))
        .map(|k| power[k]);
    quantile(around, Rank::MEDIAN).unwrap_or(f64::INFINITY)
}

#[cfg(test)]
mod tests;
