//! A correction of a given form, of which only the size is sought.

use super::drawn::least;
use super::{Correction, Course, size};
use crate::bayes::{evidence, evidence_at};
use crate::cores::apiece;
use crate::record::Record;
use crate::relations::{Applied, joined};
use crate::tangent::Tangent;
use dgd_effects::{Curve, Place};
use dgd_lsq::dot;

/// The `unit` of a form, which is its prior width, as many times as rows show it; `None` where none shows it.
pub(super) fn sized(
    record: &Record,
    tangent: &Tangent,
    state: &[Applied],
    unit: &Curve,
) -> Option<Correction> {
    let shown = |curve: &Curve| {
        let with = joined(state, &Applied::from(curve));
        tangent.signature(record, &with)
    };
    let mut signature = shown(unit);
    let energy = dot(&signature, &signature);
    let score = dot(&signature, &tangent.off);
    let times = score / (1.0 + energy);
    let mut curve = unit.scaled(times);
    let mut evidence = evidence(energy, score, 1.0, false);
    if curve.place == Place::MeterFactor {
        // Rows are not linear in an error of the flow.
        signature = shown(&curve);
        if let Some(far) = far(record, tangent, state, &curve)
            && far.evidence > evidence
        {
            (curve, signature, evidence) = (far.curve, far.signature, far.evidence);
        }
    } else {
        signature.iter_mut().for_each(|v| *v *= times);
    }
    // Neither where nothing shows it nor of a NaN.
    (energy > 0.0).then(|| Correction {
        size: size(curve.place, &curve.knots),
        least: least(Course::from(&curve)),
        curve,
        signature,
        evidence,
        choice: 0.0,
        owed: 0.0,
        borne: evidence,
        freedom: energy / (1.0 + energy),
        seen: None,
        times: record.times_usual(record.setting.span_s),
    })
}

/// A factor of the meter that is far from 1, with the curves fitted again.
struct Far {
    curve: Curve,
    signature: Vec<f64>,
    evidence: f64,
}

/// The best of some sizes of a large error of the meter, of one that is `near` on a straight line: curves that were fitted to half of the flow for
/// a while bend, and what is off about them is not in proportion. `None` of a small one.
fn far(record: &Record, tangent: &Tangent, state: &[Applied], near: &Curve) -> Option<Far> {
    /// Error of the flow from which on it is far, as a share. Set by hand.
    const LARGE: f64 = 0.1;
    /// Factors of the flow that are tried, and then a half and a quarter as far from the best as the next. Set by hand.
    const TRIED: [f64; 8] = [0.4, 0.5, 0.65, 0.8, 1.25, 1.5, 2.0, 2.5];
    const NEXT: f64 = 0.25;
    let largest = (near.knots.iter()).fold(
        0.0_f64,
        |most, k| if k.abs() > most.abs() { *k } else { most },
    );
    if largest.abs() < LARGE {
        return None;
    }
    let misfit = |off: &[f64]| 0.5 * dot(off, off);
    let of = |factor: f64| {
        let curve = near.scaled((factor - 1.0) / largest);
        record.tally.weighed();
        let left = tangent.left_over(record, &joined(state, &Applied::from(&curve)));
        let widths = (factor - 1.0) / curve.place.width();
        let signature: Vec<f64> = tangent.off.iter().zip(&left).map(|(a, b)| a - b).collect();
        let energy = dot(&signature, &signature) / (widths * widths);
        let evidence = evidence_at(widths, energy, misfit(&tangent.off) - misfit(&left));
        (
            factor,
            Far {
                curve,
                signature,
                evidence,
            },
        )
    };
    let more = |a: &(f64, Far), b: &(f64, Far)| a.1.evidence.total_cmp(&b.1.evidence);
    let finite = |tried: &(f64, Far)| tried.1.evidence.is_finite();
    let mut best = (apiece(TRIED.to_vec(), of).into_iter().filter(finite)).max_by(more)?;
    for share in [0.5, 0.25] {
        let from = best.0;
        let about = [1.0 - NEXT * share, 1.0 + NEXT * share].map(|by| of(from * by));
        best = (about.into_iter().filter(finite))
            .chain([best])
            .max_by(more)?;
    }
    Some(best.1)
}
