//! What parts the inlets from the riser's transmitter: seen, so that it needs no knots, and placed by what the relations side with.

use super::{BUSIEST_S, Correction, busiest, size};
use crate::record::{Record, whole};
use crate::relations::Applied;
use crate::scan::{evidence, joined};
use crate::step::Step;
use crate::tangent::{Tangent, dot};
use crate::witness::Witness;
use dgd_effects::{INLET_READING, KNOTS, PLACES, RISER_READING, SUCTION, unknown};
use std::ops::Range;
use tracing::debug;

/// Share of what parts the two that the relations find in the place where it sits.
const SITS: Range<f64> = 0.5..1.5;

/// Share up to which they find none of it in a place.
const NONE: f64 = 0.25;

/// Prior width of that share.
const WIDTH: f64 = 1.0;

/// Evidence that the relations would have for it, if it sat in a place: from so much on they can tell.
const TELLS: f64 = 25.0;

/// The correction of a place by what parts the inlets from the riser's transmitter, if that place is where it sits.
///
/// Three things may: the inlets' reading, which enters head and balance; what is lost on the way between the two, which enters
/// the balance alone; and where the relations find it in neither, the riser's reading. What a model can hold of the curve are its knots.
pub(super) fn seen(
    record: &Record,
    tangent: &Tangent,
    state: &[Applied],
    witness: &Witness,
    place: usize,
) -> Option<Correction> {
    let takes = record.takes(Step::Busiest);
    let window = if takes {
        whole(BUSIEST_S / record.block_s()).max(1)
    } else {
        0
    };
    let (curve, parting) = witness.parting(window)?;
    let asked = |place| Asked::of(record, tangent, state, (witness, &curve), place);
    let (share, signature, more) = if place == RISER_READING {
        let elsewhere = [INLET_READING, SUCTION].map(asked);
        if !(elsewhere.iter()).all(|a| a.energy > 2.0 * TELLS && a.share.abs() < NONE) {
            return None;
        }
        // The inlets less the riser's is what it is off by, the other way round.
        (-1.0, vec![0.0; tangent.off.len()], 0.0)
    } else {
        let asked = asked(place);
        debug!(
            "the inlets part from the riser ({parting:.1}), of which {:.2} shows as {} ({:.1})",
            asked.share, PLACES[place].name, asked.evidence
        );
        if !SITS.contains(&asked.share) {
            return None;
        }
        let mut signature = asked.signature;
        signature.iter_mut().for_each(|v| *v *= asked.share);
        let owed = if takes {
            busiest(record, tangent, &signature)
        } else {
            0.0
        };
        (asked.share, signature, asked.evidence - owed)
    };
    let (from, to) = record.setting.span_s;
    let mut parameters = vec![place as f64, 0.0, from, to];
    parameters.extend(knots(&curve).map(|knot| share * knot));
    Some(Correction {
        applied: Applied::new(unknown(), parameters),
        signature,
        evidence: parting + more,
        freedom: 1.0,
        size: share.abs() * size(place, &curve),
        place,
        quantity: 0,
    })
}

/// What the relations say of a curve in a place.
struct Asked {
    /// What the whole of it takes out of the residuals, off the tangent.
    signature: Vec<f64>,
    energy: f64,
    /// How much of it they find.
    share: f64,
    evidence: f64,
}

impl Asked {
    fn of(
        record: &Record,
        tangent: &Tangent,
        state: &[Applied],
        (witness, curve): (&Witness, &[f64]),
        place: usize,
    ) -> Self {
        let t_s = witness.t_s();
        let ends = [t_s.first(), t_s.last()].map(|t| t.copied().unwrap_or(0.0));
        // One knot a block.
        let mut parameters = vec![place as f64, 0.0, ends[0], ends[1]];
        parameters.extend(curve);
        let one = Applied::new(unknown(), parameters);
        let signature = tangent.signature(record, &joined(state, &one));
        let (energy, score) = (dot(&signature, &signature), dot(&signature, &tangent.off));
        Self {
            energy,
            share: score / (energy + WIDTH.powi(-2)),
            evidence: evidence(energy, score, WIDTH, false),
            signature,
        }
    }
}

/// Means of a curve about the knots of a correction.
fn knots(curve: &[f64]) -> impl Iterator<Item = f64> {
    let apart = curve.len() as f64 / (KNOTS - 1) as f64;
    (0..KNOTS).map(move |k| {
        let hat = |i: usize| (1.0 - ((i as f64 + 0.5) / apart - k as f64).abs()).max(0.0);
        let (mut sum, mut weights) = (0.0, 0.0);
        for (i, value) in curve.iter().enumerate() {
            sum += hat(i) * value;
            weights += hat(i);
        }
        if weights > 0.0 { sum / weights } else { 0.0 }
    })
}

#[cfg(test)]
mod tests;
