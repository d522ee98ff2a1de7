//! What parts two transmitters of one pressure: seen, so that it needs no knots, and put where the relations find it.

use super::{BUSIEST_S, Correction, owed, size};
use crate::ablation::Step;
use crate::bayes::evidence;
use crate::error_budget::wander;
use crate::layout::{BALANCE_BLOCKS, Section};
use crate::numbers::whole;
use crate::record::Record;
use crate::relations::{Applied, joined};
use crate::tangent::Tangent;
use crate::twins::{Pair, Twins, seen_curve};
use dgd_effects::{Curve, Place, Quantity};
use dgd_lsq::dot;
use std::ops::Range;
use tracing::debug;

/// Where what parts two transmitters may sit.
struct Suspect {
    place: Place,
    /// What the place is off by where the first reads one more than the second.
    sign: f64,
}

const fn suspect(place: Place, sign: f64) -> Suspect {
    Suspect { place, sign }
}

/// Those that enter the relations. The riser's reading enters none: it is at fault where nothing else is.
const SUSPECTS: [Suspect; 6] = [
    suspect(Place::FirstInlet, 1.0),
    suspect(Place::SecondInlet, -1.0),
    suspect(Place::FirstOutlet, 1.0),
    suspect(Place::SecondOutlet, -1.0),
    suspect(Place::InletReading, 1.0),
    suspect(Place::Suction, 1.0),
];

/// Share of what parts the two transmitters that the relations must find in the one where it sits. Of a redundant pair less is enough: either may be the
/// one at fault, with the other sign, and the slowest part of the difference may be wander.
const SITS: Range<f64> = 0.5..1.5;
const SITS_IN_ONE: Range<f64> = 0.25..1.5;

/// Evidence from which on the relations have found it.
const FOUND: f64 = 10.0;

/// Share up to which they find none of it in a place.
const NONE: f64 = 0.25;

/// Spread up to which a curve that is seen may be the accuracy of a transmitter, Pa.
const LEAST_PA: f64 = 2.5e3;

/// Width of the prior of that share.
const WIDTH: f64 = 1.0;

/// Knots of it that a model holds at the most: those of two days, minute by minute.
const MOST_KNOTS: usize = 2880;

/// Evidence that the relations would have for it, if it sat in a place: from so much on they can tell.
const TELLS: f64 = 25.0;

/// Corrections by what parts two transmitters, of the places where the relations find it; `excluded` blocks tell nothing.
///
/// One of two at the pump inlet or outlet enters the mean that the relations hold by half, either with its own sign. Of the inlets
/// beside the riser three things may be at fault: their reading, which enters head and balance; what is lost on the way between the two, which
/// enters the balance alone; and where the relations find it in neither, the riser's reading. A model holds a knot of the curve for every
/// row of the balance.
pub(super) fn all(
    record: &Record,
    tangent: &Tangent,
    state: &[Applied],
    excluded: &[bool],
) -> Vec<Correction> {
    // What parts two is told once.
    let told = |pair: &Pair| {
        let mut seen = state.iter().filter_map(seen_curve);
        seen.any(|curve| Pair::of(curve.place) == Some(*pair))
    };
    (Pair::ALL.into_iter())
        .filter(|pair| !told(pair))
        .flat_map(|pair| of(record, tangent, state, excluded, pair))
        .collect()
}

/// The same of one pair.
pub(super) fn of(
    record: &Record,
    tangent: &Tangent,
    state: &[Applied],
    excluded: &[bool],
    pair: Pair,
) -> Vec<Correction> {
    let busiest_blocks = if record.takes(Step::Busiest) {
        whole(BUSIEST_S / record.block_s()).max(1)
    } else {
        0
    };
    let beside = wander(record, &tangent.curves);
    let Some(twins) = Twins::of(record, pair, state, beside, excluded) else {
        return Vec::new();
    };
    let Some(parting) = twins.parting(busiest_blocks) else {
        return Vec::new();
    };
    let told = Told {
        edges: match pair {
            Pair::InletAndRiser => twins.at_edges(record, pair, &parting),
            Pair::Inlets | Pair::Outlets => Vec::new(),
        },
        blocks: parting.curve,
        beyond: parting.beyond,
        evidence: parting.evidence,
        creeps: parting.creeps,
        record,
    };
    let asked: Vec<(&Suspect, Asked)> = (SUSPECTS.iter())
        .filter(|s| Pair::of(s.place) == Some(pair))
        .map(|s| (s, Asked::of(record, tangent, state, &told, s)))
        .collect();
    for (s, a) in &asked {
        debug!(
            "{} part ({:.1}), of which {:.2} shows as {} ({:.1})",
            pair.name(),
            told.evidence,
            a.share,
            s.place.name(),
            a.evidence
        );
    }
    let mut out = Vec::new();
    // Where the relations could tell, they find none. Of what creeps on the way between the two they may not tell, and a transmitter creeps
    // sooner than that.
    let tells = |a: &Asked| a.energy > 2.0 * TELLS;
    let none = |(s, a): &(&Suspect, Asked)| {
        let untold = told.creeps && s.place == Place::Suction && !tells(a);
        untold || tells(a) && a.share.abs() < NONE
    };
    if pair == Pair::InletAndRiser && asked.iter().all(none) {
        let nowhere = vec![0.0; tangent.off.len()];
        out.push(told.correction((Place::RiserReading, -1.0), nowhere, 0.0));
    }
    let sits = match pair {
        Pair::InletAndRiser => SITS,
        Pair::Inlets | Pair::Outlets => SITS_IN_ONE,
    };
    let there = |(_, a): &(_, Asked)| sits.contains(&a.share) && a.evidence > FOUND;
    for (s, a) in asked.into_iter().filter(there) {
        let mut signature = a.signature;
        signature.iter_mut().for_each(|v| *v *= a.share);
        let owed = owed(record, tangent, &signature);
        out.push(told.correction((s.place, s.sign), signature, a.evidence - owed));
    }
    out
}

/// What two transmitters tell by themselves: by how much the first reads more than the second, but for a constant, Pa.
struct Told<'a> {
    blocks: Vec<f64>,
    /// Where rows of the mass balance meet, of a pair that tells of the suction.
    edges: Vec<f64>,
    /// By block, less what they may differ by.
    beyond: Vec<f64>,
    /// That they part.
    evidence: f64,
    /// As slowly as they wander.
    creeps: bool,
    record: &'a Record,
}

impl Told<'_> {
    /// The curve as what a place is off by, with its sign. Of what the balance alone holds it has the levels from edge to edge.
    fn fine(&self, (place, sign): (Place, f64)) -> Curve {
        let Record { t_s, dt_s, .. } = self.record;
        let start_s = t_s.first().copied().unwrap_or(0.0) - 0.5 * dt_s;
        let block_s = self.record.block_s();
        let (curve, from_s, step_s) = if place == Place::Suction {
            (&self.edges, start_s, block_s * BALANCE_BLOCKS as f64)
        } else {
            (&self.blocks, start_s + 0.5 * block_s, block_s)
        };
        let to_s = from_s + step_s * curve.len().saturating_sub(1) as f64;
        let knots = curve.iter().map(|v| sign * v).collect();
        Curve::new(place, Quantity::Time, (from_s, to_s), knots)
    }

    /// The correction of a place by the curve; the relations bear it out by so much.
    fn correction(
        &self,
        (place, sign): (Place, f64),
        signature: Vec<f64>,
        borne: f64,
    ) -> Correction {
        let (from, to) = self.record.setting.span_s;
        let count = (self.record.blocks / BALANCE_BLOCKS + 1).min(MOST_KNOTS);
        let knots = knots(&self.blocks, count).map(|knot| sign * knot);
        Correction {
            curve: Curve::new(place, Quantity::Time, (from, to), knots.collect()),
            signature,
            evidence: self.evidence + borne,
            choice: 0.0,
            owed: 0.0,
            borne,
            freedom: 1.0,
            size: size(place, &self.beyond),
            least: LEAST_PA,
            seen: Some(self.fine((place, sign))),
            times: self.record.times_usual((from, to)),
        }
    }
}

/// What the relations say of a curve in a place.
struct Asked {
    /// What the whole of it takes out of the residuals, off the tangent; nothing in those of two transmitters, which have told.
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
        told: &Told,
        suspect: &Suspect,
    ) -> Self {
        let one = told.fine((suspect.place, suspect.sign));
        let mut signature = tangent.signature(record, &joined(state, &Applied::from(&one)));
        let layout = tangent.layout;
        signature[layout.rows(Section::Outlets)].fill(0.0);
        let (energy, score) = (dot(&signature, &signature), dot(&signature, &tangent.off));
        Self {
            energy,
            share: score / (energy + WIDTH.powi(-2)),
            evidence: evidence(energy, score, WIDTH, false),
            signature,
        }
    }
}

/// Means of a curve about so many knots, of which the first and the last are its ends.
fn knots(curve: &[f64], count: usize) -> impl Iterator<Item = f64> {
    let apart = curve.len() as f64 / (count - 1) as f64;
    (0..count).map(move |k| {
        let hat = |i: usize| (1.0 - ((i as f64 + 0.5) / apart - k as f64).abs()).max(0.0);
        let (mut sum, mut weights) = (0.0, 0.0);
        let about = whole((k as f64 - 1.0) * apart)..whole((k as f64 + 1.0) * apart + 1.0);
        for (i, value) in (curve.iter().enumerate())
            .skip(about.start)
            .take(about.len())
        {
            sum += hat(i) * value;
            weights += hat(i);
        }
        if weights > 0.0 { sum / weights } else { 0.0 }
    })
}

#[cfg(test)]
mod tests;
