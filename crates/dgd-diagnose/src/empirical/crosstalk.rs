//! What another line's flow adds to a reading: so much a unit of flow.
//!
//! A curve through knots is drawn where the relations' own curves bend at will. Those then take up what comes and goes with the mud in
//! the line, and of a booster that runs whenever mud flows nothing remains. A straight line through nought is weighed where effects are, and
//! like those without a look at its busiest ten minutes: a booster may stop for no longer.

use super::drawn::least;
use super::{Correction, Course, size};
use crate::bayes::evidence;
use crate::record::Record;
use crate::relations::{Applied, joined};
use crate::tangent::Tangent;
use dgd_effects::{Curve, KNOTS, Place, Quantity};
use dgd_lsq::dot;

/// Which reading is corrected along which flow.
const ALONG: (Place, Quantity) = (Place::OutletReading, Quantity::BoosterFlow);

/// Prior width of what is added at the largest flow, Pa. Set by hand.
const WIDTH_PA: f64 = 4e4;

/// Whether what a flow may add to a reading is corrected: the booster's to the outlets'.
pub(super) fn is_of(course: Course) -> bool {
    (course.place, course.quantity) == ALONG
}

/// The outlets' reading as it follows the booster; `None` of a booster that rests or hardly changes, and where nothing shows it. The curves of
/// the tangent bend no more than beside effects.
pub(super) fn crosstalk(
    record: &Record,
    tangent: &Tangent,
    state: &[Applied],
) -> Option<Correction> {
    /// Share of its largest flow that the booster must fall below at some time. Set by hand.
    const CHANGES: f64 = 0.5;
    let course = Course::from(ALONG);
    // To the largest flow, as beyond its last knot a curve stays where it is: this one has no bend.
    let flows = &record.filled.booster;
    let most = flows.iter().copied().fold(0.0, f64::max);
    // What is always added is an offset.
    if flows.iter().all(|flow| *flow >= CHANGES * most) {
        return None;
    }
    let through = |pa: f64| {
        let knots = (0..KNOTS).map(|k| pa * k as f64 / (KNOTS - 1) as f64);
        Curve::new(course.place, course.quantity, (0.0, most), knots.collect())
    };
    let with = joined(state, &Applied::from(&through(WIDTH_PA)));
    let mut signature = tangent.signature(record, &with);
    let energy = dot(&signature, &signature);
    let score = dot(&signature, &tangent.off);
    let widths = score / (1.0 + energy);
    signature.iter_mut().for_each(|v| *v *= widths);
    let evidence = evidence(energy, score, 1.0, false);
    let curve = through(WIDTH_PA * widths);
    // Neither where nothing shows it nor of a NaN.
    (energy > 0.0).then(|| Correction {
        size: size(course.place, &curve.knots),
        curve,
        signature,
        evidence,
        borne: evidence,
        freedom: energy / (1.0 + energy),
        least: least(course),
        seen: None,
        times: Record::times_usual(record.lasts_s()),
    })
}
