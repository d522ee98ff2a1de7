//! What comes and goes with a period of its own: day and night, a filter that clogs and is cleaned, a swell.
//!
//! A curve along time tells nothing of what was held out, and its knots do not follow what swings in less than an hour. One along
//! the time of a period does both.

use super::timed::Answer;
use super::{Correction, Course, drawn, plausible};
use crate::numbers::whole;
use crate::record::Record;
use crate::relations::Applied;
use crate::tangent::Tangent;
use dgd_effects::{Place, Quantity};
use dgd_lsq::dot;
use rayon::prelude::*;
use std::f64::consts::TAU;

/// Shortest period, s: what is shorter swings within a row of the mass balance.
const SHORTEST_S: f64 = 600.0;
/// Times that a period is seen, at the least.
const LEAST_TIMES: f64 = 2.5;
/// Frequencies that are sought at the most; in weeks of drilling the shortest period is longer.
const MOST: usize = 4096;
/// Steps of the frequency within what a recording of this length can part.
const STEPS: f64 = 3.0;
/// Steps from the best frequency to those beside it, one round after the other.
const FINER: [&[f64]; 3] = [&[-0.6, -0.3, 0.3, 0.6], &[-0.15, 0.15], &[-0.07, 0.07]];
/// Peaks of the spectrum that a curve is drawn for.
const PEAKS: usize = 2;
/// Frequencies at which the energy of a swing is asked for.
const COARSE: usize = 10;
/// Share of the most evidence from which on a place is asked more finely.
const NEAR: f64 = 0.4;

/// The likeliest in any of some places, if any comes near what is `shown` without a period; the choice of its period is paid for.
pub(super) fn best(
    record: &Record,
    tangent: &Tangent,
    state: &[Applied],
    places: &[Place],
    shown: f64,
) -> Option<Correction> {
    let search = Search::of(record, tangent, state);
    let coarse: Vec<Swing> = (places.par_iter())
        .filter_map(|place| search.coarse(*place))
        .filter(|found| plausible(&found.correction))
        .collect();
    // Of a period that is a little off the one place loses more than the other.
    let most = coarse.iter().map(Swing::evidence).fold(0.0, f64::max);
    let near = (coarse.into_par_iter())
        .filter(|found| found.evidence() > NEAR * most && found.evidence() > NEAR * shown);
    let mut found: Vec<Correction> = near.map(|found| search.finer(found)).collect();
    found.sort_by(|a, b| b.evidence.total_cmp(&a.evidence));
    found.into_iter().next()
}

/// The likeliest in one place; the choice of its period is paid for.
pub(super) fn in_place(
    record: &Record,
    tangent: &Tangent,
    state: &[Applied],
    place: Place,
) -> Option<Correction> {
    let search = Search::of(record, tangent, state);
    search.coarse(place).map(|found| search.finer(found))
}

/// What swings with a frequency, Hz.
struct Swing {
    frequency: f64,
    correction: Correction,
}

impl Swing {
    fn evidence(&self) -> f64 {
        self.correction.evidence
    }
}

/// The frequencies that are sought in a recording.
struct Search<'a> {
    record: &'a Record,
    tangent: &'a Tangent,
    state: &'a [Applied],
    frequencies: Vec<f64>,
    /// Between two of them, Hz.
    step: f64,
}

impl<'a> Search<'a> {
    fn of(record: &'a Record, tangent: &'a Tangent, state: &'a [Applied]) -> Self {
        let (from, to) = record.setting.span_s;
        let step = 1.0 / (STEPS * (to - from));
        let frequencies = (0..MOST)
            .map(|k| LEAST_TIMES / (to - from) + k as f64 * step)
            .take_while(|f| *f <= 1.0 / SHORTEST_S)
            .collect();
        Self {
            record,
            tangent,
            state,
            frequencies,
            step,
        }
    }

    /// The best of the peaks of the spectrum, its choice paid for.
    fn coarse(&self, place: Place) -> Option<Swing> {
        let power = self.spectrum(place)?;
        let peaks = peaks(&self.frequencies, &power);
        self.best(place, &peaks)
    }

    /// The same period as finely as the recording parts it.
    fn finer(&self, mut found: Swing) -> Correction {
        for apart in FINER {
            let near: Vec<f64> = (apart.iter())
                .map(|s| found.frequency + s * self.step)
                .filter(|f| *f >= LEAST_TIMES * STEPS * self.step && *f <= 1.0 / SHORTEST_S)
                .collect();
            let better = self.best(found.correction.curve.place, &near);
            if let Some(better) = better.filter(|b| b.evidence() > found.evidence()) {
                found = better;
            }
        }
        found.correction
    }

    fn best(&self, place: Place, frequencies: &[f64]) -> Option<Swing> {
        let from = self.record.setting.span_s.0;
        let choice = (self.frequencies.len() as f64 / STEPS).ln().max(0.0);
        let swing = |frequency: &f64| {
            let course = Course {
                place,
                quantity: Quantity::Period,
                timed_s: Some((from, from + 1.0 / frequency)),
            };
            let mut correction = drawn(self.record, self.tangent, self.state, None, course)?;
            correction.pay(choice);
            Some(Swing {
                frequency: *frequency,
                correction,
            })
        };
        (frequencies.iter().filter_map(swing)).max_by(|a, b| a.evidence().total_cmp(&b.evidence()))
    }

    /// What a swing of each frequency in a place takes out of the residuals, nearly: the tangent is not asked.
    fn spectrum(&self, place: Place) -> Option<Vec<f64>> {
        let (first, last) = (*self.frequencies.first()?, *self.frequencies.last()?);
        let (record, tangent) = (self.record, self.tangent);
        let layout = tangent.layout;
        let Answer {
            constant,
            rate: slope,
        } = Answer::of(record, tangent, self.state, place);
        let time_s = layout.times_s(record.block_s());

        // Noise is smooth in the frequency: a few tell of those between.
        let energy = |frequency: f64| -> f64 {
            let turn = TAU * frequency;
            // A wave and its rate.
            let of = |wave: fn(f64) -> f64, rate: fn(f64) -> f64| {
                let column: Vec<f64> = (0..layout.len())
                    .map(|row| {
                        let angle = turn * time_s[row];
                        constant[row] * wave(angle) + slope[row] * turn * rate(angle)
                    })
                    .collect();
                let white = tangent.whitening.apply(&column);
                dot(&white, &white)
            };
            0.5 * (of(f64::cos, |x| -x.sin()) + of(f64::sin, f64::cos))
        };
        let steps = (COARSE - 1) as f64;
        let energies: Vec<f64> = (0..COARSE)
            .map(|k| energy(first * (last / first).powf(k as f64 / steps)).ln())
            .collect();
        let between = |frequency: f64| -> f64 {
            let x = (frequency / first).ln() / (last / first).ln().max(1e-9) * steps;
            let x = x.clamp(0.0, steps);
            let low = whole(x.floor()).min(COARSE - 2);
            let share = x - low as f64;
            ((1.0 - share) * energies[low] + share * energies[low + 1]).exp()
        };

        // Within a twelfth of the shortest period nothing swings: the frequencies need not ask every row.
        let pull = tangent.pull();
        let bin_s = SHORTEST_S / 12.0;
        let bins = whole(time_s.iter().fold(0.0, |m, t| t.max(m)) / bin_s) + 1;
        // Of what a wave makes, and of what its rate does.
        let mut bins = vec![(0.0, 0.0); bins];
        for (row, t) in time_s.iter().enumerate() {
            let bin = &mut bins[whole((t / bin_s).floor())];
            bin.0 += constant[row] * pull[row];
            bin.1 += slope[row] * pull[row];
        }
        let power = |frequency: &f64| {
            let turn = TAU * frequency;
            let (mut real, mut imaginary) = (0.0, 0.0);
            // Bins are evenly spaced: it goes round from one to the next by the same angle.
            let (turn_sin, turn_cos) = (turn * bin_s).sin_cos();
            let (mut sin, mut cos) = (0.0, 1.0);
            for (wave, rate) in &bins {
                real += cos * wave - turn * sin * rate;
                imaginary += sin * wave + turn * cos * rate;
                (cos, sin) = (
                    cos * turn_cos - sin * turn_sin,
                    sin * turn_cos + cos * turn_sin,
                );
            }
            let power = 0.5 * (real * real + imaginary * imaginary) / between(*frequency);
            if power.is_finite() { power } else { 0.0 }
        };
        Some(self.frequencies.par_iter().map(power).collect())
    }
}

/// The highest peaks, by their frequency.
fn peaks(frequencies: &[f64], power: &[f64]) -> Vec<f64> {
    let at = |k: usize| power.get(k).copied().unwrap_or(0.0);
    let mut peaks: Vec<usize> = (0..power.len())
        .filter(|k| at(*k) >= at(k.wrapping_sub(1)) && at(*k) > at(k + 1))
        .collect();
    peaks.sort_by(|a, b| power[*b].total_cmp(&power[*a]));
    peaks.truncate(PEAKS);
    peaks.into_iter().map(|k| frequencies[k]).collect()
}

#[cfg(test)]
mod tests;
