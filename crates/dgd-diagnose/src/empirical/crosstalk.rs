//! What another line's flow adds to a reading: so much a unit of flow.
//!
//! A curve through knots is drawn where the relations' own curves bend at will. Those then take up what comes and goes with the mud in
//! the line, and of a booster that runs whenever mud flows nothing remains. A straight line through nought is weighed where effects are, and
//! like those without a look at its busiest ten minutes: a booster may stop for no longer.

use super::straight::sized;
use super::{Correction, Course};
use crate::record::Record;
use crate::relations::Applied;
use crate::tangent::Tangent;
use dgd_effects::{Curve, KNOTS, Place, Quantity};

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
    let knots = (0..KNOTS).map(|k| WIDTH_PA * k as f64 / (KNOTS - 1) as f64);
    let unit = Curve::new(course.place, course.quantity, (0.0, most), knots.collect());
    sized(record, tangent, state, &unit)
}
