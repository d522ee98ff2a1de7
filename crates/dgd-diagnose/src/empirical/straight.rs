//! A correction of a given form, of which only the size is sought.

use super::drawn::least;
use super::{Correction, Course, size};
use crate::bayes::evidence;
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
    let curve = unit.scaled(times);
    if curve.place == Place::MeterFactor {
        // Rows are not linear in an error of the flow.
        signature = shown(&curve);
    } else {
        signature.iter_mut().for_each(|v| *v *= times);
    }
    let evidence = evidence(energy, score, 1.0, false);
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
