//! What comes and goes with a period of its own: day and night, a filter that clogs and is cleaned, a swell.
//!
//! A curve along time tells nothing of what was held out, and its knots do not follow what swings in less than an hour. One along
//! the time of a period does both.

use super::{Correction, Course, DRAWN, beside_riser, drawn, plausible};
use crate::noise::Layout;
use crate::record::{MASS_BLOCKS, Record, whole};
use crate::relations::Applied;
use crate::scan::joined;
use crate::tangent::{Bend, Tangent, dot};
use dgd_effects::{INLET_READING, KNOTS, PERIOD, PLACES, unknown};
use rayon::prelude::*;
use std::f64::consts::TAU;
use tracing::debug;

/// Shortest period, s: what is shorter swings within a row of the mass balance.
const SHORTEST_S: f64 = 600.0;
/// Times that a period is seen, at the least.
const LEAST_TIMES: f64 = 2.5;
/// Steps of the frequency within what a recording of this length can part.
const STEPS: f64 = 3.0;
/// Steps from the best frequency to those beside it, one round after the other.
const FINER: [&[f64]; 3] = [&[-0.6, -0.3, 0.3, 0.6], &[-0.15, 0.15], &[-0.07, 0.07]];
/// Peaks of the spectrum that a curve is drawn for.
const PEAKS: usize = 2;
/// Frequencies at which the energy of a swing is asked for.
const COARSE: usize = 10;
/// Evidence by which it must be better than what needs no period: e-folds.
const BETTER: f64 = 10.0;

/// A correction along the time of a period that tells more than this one, in any place, if there is one.
pub(crate) fn instead_of(record: &Record, state: &[Applied], c: &Correction) -> Option<Correction> {
    if c.seen.is_some() {
        return None;
    }
    let tangent = Tangent::beside(record, state, &[], Bend::Loose)?;
    let witnessed = beside_riser(record, &tangent, state, &[]).is_some();
    // Of a reading that drifts, the riser's transmitter draws the curve.
    let places = (0..DRAWN).filter(|place| !(witnessed && *place == INLET_READING));
    let places: Vec<usize> = places.collect();
    (places.par_iter())
        .filter_map(|place| in_place(record, &tangent, state, *place))
        .filter(|found| plausible(found) && found.evidence > c.evidence + BETTER)
        .max_by(|a, b| a.evidence.total_cmp(&b.evidence))
}

/// The likeliest in one place; the choice of its period is paid for.
pub(crate) fn in_place(
    record: &Record,
    tangent: &Tangent,
    state: &[Applied],
    place: usize,
) -> Option<Correction> {
    let span = record.setting.span_s;
    let length = span.1 - span.0;
    let step = 1.0 / (STEPS * length);
    let frequencies: Vec<f64> = (0..)
        .map(|k| LEAST_TIMES / length + k as f64 * step)
        .take_while(|f| *f <= 1.0 / SHORTEST_S)
        .collect();
    let drawn = |frequency: &f64| {
        let course = Course {
            place,
            quantity: PERIOD,
            period: Some((span.0, span.0 + 1.0 / frequency)),
        };
        drawn(record, tangent, state, None, course).map(|found| (*frequency, found))
    };
    let best = |found: Vec<(f64, Correction)>| {
        (found.into_iter()).max_by(|a, b| a.1.evidence.total_cmp(&b.1.evidence))
    };
    let peaks = peaks(
        &frequencies,
        &spectrum(record, tangent, state, place, &frequencies),
    );
    let (mut frequency, mut found) = best(peaks.iter().filter_map(drawn).collect())?;
    for apart in FINER {
        let near = apart.iter().map(|s| frequency + s * step);
        let near = near.filter_map(|f| drawn(&f)).collect();
        if let Some(finer) = best(near).filter(|(_, one)| one.evidence > found.evidence) {
            (frequency, found) = finer;
        }
    }
    let choice = (frequencies.len() as f64 / STEPS).ln().max(0.0);
    debug!(
        "correction of {} by the time of a period of {:.0} s {:.1}",
        PLACES[place].name,
        1.0 / frequency,
        found.evidence - choice
    );
    found.evidence -= choice;
    found.borne -= choice;
    Some(found)
}

/// What a swing of each frequency in a place takes out of the residuals, nearly: the tangent is not asked.
fn spectrum(
    record: &Record,
    tangent: &Tangent,
    state: &[Applied],
    place: usize,
    frequencies: &[f64],
) -> Vec<f64> {
    let layout = tangent.layout;
    let constant = {
        let mut parameters = vec![place as f64, 0.0, 0.0, 1.0];
        parameters.extend([PLACES[place].width; KNOTS]);
        let change = tangent.change(record, &joined(state, &Applied::new(unknown(), parameters)));
        let finite = |v: f64| if v.is_finite() { v } else { 0.0 };
        change.into_iter().map(finite).collect::<Vec<f64>>()
    };
    let pull = (tangent.whitening).transpose(&tangent.off[..layout.len()]);
    let block_s = record.block_s();
    let energy = |frequency: f64| -> f64 {
        let mut column = [vec![0.0; layout.len()], vec![0.0; layout.len()]];
        swing(layout, block_s, frequency, |row, cos, sin| {
            (column[0][row], column[1][row]) = (cos * constant[row], sin * constant[row]);
        });
        let energy = |column: &Vec<f64>| {
            let white = tangent.whitening.apply(column);
            dot(&white, &white)
        };
        0.5 * column.iter().map(energy).sum::<f64>()
    };
    // Noise is smooth in the frequency: a few tell of those between.
    let (Some(first), Some(last)) = (frequencies.first(), frequencies.last()) else {
        return Vec::new();
    };
    let at = |k: usize| first * (last / first).powf(k as f64 / (COARSE - 1) as f64);
    let energies: Vec<f64> = (0..COARSE).map(|k| energy(at(k)).ln()).collect();
    let between = |frequency: f64| -> f64 {
        let x = (frequency / first).ln() / (last / first).ln().max(1e-9) * (COARSE - 1) as f64;
        let x = x.clamp(0.0, (COARSE - 1) as f64);
        let low = whole(x.floor()).min(COARSE - 2);
        let share = x - low as f64;
        ((1.0 - share) * energies[low] + share * energies[low + 1]).exp()
    };
    (frequencies.par_iter())
        .map(|frequency| {
            let (mut real, mut imaginary) = (0.0, 0.0);
            swing(layout, block_s, *frequency, |row, cos, sin| {
                let weight = constant[row] * pull[row];
                real += cos * weight;
                imaginary += sin * weight;
            });
            let power = 0.5 * (real * real + imaginary * imaginary) / between(*frequency);
            if power.is_finite() { power } else { 0.0 }
        })
        .collect()
}

/// Tells of every row the cosine and the sine of a frequency, in its middle.
fn swing(layout: Layout, block_s: f64, frequency: f64, mut told: impl FnMut(usize, f64, f64)) {
    for (k, section) in layout.sections().into_iter().enumerate() {
        let apart_s = block_s * if k == 3 { MASS_BLOCKS as f64 } else { 1.0 };
        // Rows of a section are evenly spaced: it goes round from one to the next by the same angle.
        let (turn_sin, turn_cos) = (TAU * frequency * apart_s).sin_cos();
        let (mut sin, mut cos) = (0.5 * TAU * frequency * apart_s).sin_cos();
        for row in section {
            told(row, cos, sin);
            (cos, sin) = (
                cos * turn_cos - sin * turn_sin,
                sin * turn_cos + cos * turn_sin,
            );
        }
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
