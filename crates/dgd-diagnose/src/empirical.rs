//! The competitor: a correction of one relation along one quantity, with no physics in it.

mod crosstalk;
mod drawn;
mod episodic;
mod periodic;
mod seen;
mod smooth;
mod straight;
mod timed;

pub(crate) use episodic::episode_may_be;
pub(crate) use timed::{anew, episode_like, instead_of};

use crate::ablation::Step;
use crate::error_budget::wander;
use crate::numbers::whole;
use crate::record::Record;
use crate::relations::Applied;
use crate::tangent::{Bend, Tangent};
use crate::twins::{Pair, Twins};
use crate::vectors::most_within;
use crosstalk::crosstalk;
use dgd_effects::{Curve, Place, Quantity, Relation};
use drawn::drawn;
use rayon::prelude::*;

/// Places that a curve through knots is drawn for. What two transmitters of one pressure tell of the others is [seen](seen::all).
const DRAWN: [Place; 6] = [
    Place::Friction,
    Place::Head,
    Place::Balance,
    Place::InletReading,
    Place::OutletReading,
    Place::MeterFactor,
];

/// A correction, weighed.
#[derive(Clone)]
pub(crate) struct Correction {
    pub curve: Curve,
    /// What it takes out of the residuals, off the tangent.
    pub signature: Vec<f64>,
    /// Logarithm of the Bayes factor against nothing.
    pub evidence: f64,
    /// The part of it that comes from the relations, which is what effects compete with: none could explain what two transmitters show by
    /// themselves.
    pub borne: f64,
    /// What the choice of its times cost, e-folds: both have paid for it.
    pub choice: f64,
    /// What errors of the flow and the relation's own curve would bring it beside that, e-folds: neither part has it.
    pub owed: f64,
    /// How many straight parameters its curve is worth.
    pub freedom: f64,
    /// How large its curve is, and the size up to which it may be the accuracy of instruments, in the unit of its place.
    pub size: f64,
    pub least: f64,
    /// The curve by block, or by row of the balance, of one that is seen: finer than knots.
    pub seen: Option<Curve>,
    /// By what its hurdle is multiplied, because the recording is longer than those it was set on.
    pub times: f64,
}

impl Correction {
    /// Evidence that it may claim against an effect: that pays for the freedom of the curve already, but a correction is less likely beforehand.
    pub(crate) fn claim(&self) -> f64 {
        /// E-folds by which it is less likely. Set by hand.
        const LN_PRIOR: f64 = 3.0;
        self.borne - LN_PRIOR
    }

    /// Pays for the choice of its times.
    fn pay(&mut self, choice: f64) {
        self.choice += choice;
        self.evidence -= choice;
        self.borne -= choice;
    }
}

/// What is corrected along which quantity.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Course {
    pub place: Place,
    pub quantity: Quantity,
    /// From when to when the first period goes, or the episode, s.
    pub timed_s: Option<(f64, f64)>,
}

impl From<&Curve> for Course {
    fn from(curve: &Curve) -> Self {
        Self {
            place: curve.place,
            quantity: curve.quantity,
            timed_s: curve.timed_s(),
        }
    }
}

impl From<(Place, Quantity)> for Course {
    fn from((place, quantity): (Place, Quantity)) -> Self {
        Self {
            place,
            quantity,
            timed_s: None,
        }
    }
}

/// Whether a correction is drawn where the curves bend no more than beside effects, not at will, as curves that bend at will take up most of
/// it: the head along the inlet pressure (METHOD.md, section 5).
fn is_drawn_stiff(course: Course) -> bool {
    (course.place, course.quantity) == (Place::Head, Quantity::InletPressure)
}

/// Every place that a curve through knots is drawn for, along every quantity that has no times of its own.
fn courses() -> impl Iterator<Item = (Place, Quantity)> {
    (Quantity::ALL.into_iter())
        .filter(|quantity| !quantity.is_timed())
        .flat_map(|quantity| DRAWN.map(|place| (place, quantity)))
}

/// Every correction that the recording excites, best first; `with_episode`, an episode among them if one stands out beside the others.
pub(crate) fn corrections(
    record: &Record,
    state: &[Applied],
    with_episode: bool,
) -> Vec<Correction> {
    let Some(whole) = Tangent::beside(record, state, &[], Bend::Loose) else {
        return Vec::new();
    };
    // No correction is made along what a relation's own curve depends on, as that is identification; nor of the mass balance along the
    // rate of the flow, as that is timing. Readings are corrected along what makes instruments wrong: time, another line's flow.
    let own = |place, quantity| {
        use Quantity::{BoosterFlow, FlowRate, MudPumpFlow, PumpSpeed, ReturnFlow, Time};
        match place {
            Place::Friction => quantity == ReturnFlow,
            Place::Head => matches!(quantity, ReturnFlow | PumpSpeed),
            Place::Balance => quantity == FlowRate,
            Place::InletReading => quantity != Time,
            Place::MeterFactor => !matches!(quantity, Time | ReturnFlow),
            _ => !matches!(quantity, MudPumpFlow | BoosterFlow),
        }
    };
    let places: Vec<(Place, Quantity)> = courses()
        .filter(|(place, quantity)| !own(*place, *quantity))
        .collect();
    let inlets_beside_riser = beside_riser(record, &whole, state, &[]);
    let stiff = whole.bending(record, Bend::Lean);
    let (drawn, seen) = rayon::join(
        || -> Vec<Correction> {
            let twins = inlets_beside_riser.as_ref();
            (places.par_iter().with_max_len(1))
                .filter_map(|place| {
                    along(record, [&whole, &stiff], state, twins, Course::from(*place))
                })
                .collect()
        },
        || seen::all(record, &whole, state, &[]),
    );
    drop(stiff);
    let mut out = merged(drawn, seen);
    let episode = with_episode
        .then(|| timed::sought(record, &whole, state))
        .flatten();
    out.extend(episode);
    hold_without_stops(record, whole, state, &mut out);
    timed::keep_what_stands_out(record, state, &mut out);
    out.sort_by(|a, b| b.evidence.total_cmp(&a.evidence));
    out
}

/// The plausible correction of a relation that tells most beside the curves of a tangent, which may bend no more than they do there; along what those
/// depend on as well. Not of the mass balance along the rate of the flow, as that is timing.
pub(crate) fn most_telling(
    record: &Record,
    tangent: &Tangent,
    state: &[Applied],
    relation: Relation,
) -> Option<Correction> {
    let places: Vec<(Place, Quantity)> = courses()
        .filter(|(place, _)| place.relation() == relation)
        .filter(|course| *course != (Place::Balance, Quantity::FlowRate))
        .collect();
    let drawn: Vec<Correction> = (places.par_iter().with_max_len(1))
        .filter_map(|place| drawn(record, tangent, state, None, Course::from(*place)))
        .collect();
    (drawn.into_iter().filter(plausible)).max_by(|a, b| a.evidence.total_cmp(&b.evidence))
}

/// Lowers corrections that stand out only because of stops, or while the pump changes to another head, to their evidence without these, if
/// that is below their hurdle. Takes the tangent to free its memory before others are made.
fn hold_without_stops(record: &Record, whole: Tangent, state: &[Applied], out: &mut [Correction]) {
    if !record.takes(Step::Flowing) {
        return;
    }
    let moving = whole.moving(record);
    let stops = (whole.rows.still.iter().zip(&moving)).map(|(still, moving)| *still || *moving);
    let stops: Vec<bool> = stops.collect();
    drop(whole);
    let (friction, head) = rayon::join(
        // A valve that closes late leaves the line lower at a stop, which is no friction; nor is what answers late on the way to the stop.
        || without(record, &stops, state, out, Relation::ReturnLineFriction),
        // A meter that answers half a second late gives the same error at each change of the head, as if that depended on level or inflow.
        || without(record, &moving, state, out, Relation::PumpHead),
    );
    for (k, alone) in friction.into_iter().chain(head) {
        hold_to(&mut out[k], alone);
    }
}

/// Lowers a correction to the evidence that it has without some blocks, if that is below its hurdle.
fn hold_to(c: &mut Correction, alone: f64) {
    if alone < hurdle(c) {
        c.evidence = c.evidence.min(alone);
        c.borne = c.borne.min(alone);
    }
}

/// Evidence that doubtful corrections of a relation have without some blocks, and which of those found they are.
fn without(
    record: &Record,
    blocks: &[bool],
    state: &[Applied],
    found: &[Correction],
    relation: Relation,
) -> Vec<(usize, f64)> {
    /// Share of its hurdle from which a correction is weighed again. Set by hand.
    const DOUBTFUL: f64 = 0.5;
    let doubtful =
        |c: &Correction| c.curve.place.relation() == relation && c.evidence > DOUBTFUL * hurdle(c);
    if !blocks.contains(&true) || !found.iter().any(doubtful) {
        return Vec::new();
    }
    let Some(others) = Tangent::beside(record, state, blocks, Bend::Loose) else {
        return Vec::new();
    };
    (found.iter().enumerate())
        .filter(|(_, c)| doubtful(c))
        .map(|(k, c)| {
            let again = correction(record, &others, state, blocks, &c.curve);
            (k, again.map_or(0.0, |again| again.evidence - c.choice))
        })
        .collect()
}

/// The correction of one relation or reading along one quantity, without the `excluded` blocks, which a tangent knows by itself;
/// `None` if the recording does not move the quantity, or the riser's transmitter shows no such drift.
pub(crate) fn correction(
    record: &Record,
    tangent: &Tangent,
    state: &[Applied],
    excluded: &[bool],
    course: impl Into<Course>,
) -> Option<Correction> {
    let course = course.into();
    let place = course.place;
    let seen = Pair::of(place).map_or_else(Vec::new, |pair| {
        seen::of(record, tangent, state, excluded, pair)
    });
    let twins = (place == Place::InletReading)
        .then(|| beside_riser(record, tangent, state, excluded))
        .flatten();
    let needed = is_drawn_stiff(course) || crosstalk::is_of(course);
    let stiff = needed.then(|| tangent.bending(record, Bend::Lean));
    let tangents = [tangent, stiff.as_ref().unwrap_or(tangent)];
    let drawn = along(record, tangents, state, twins.as_ref(), course);
    merged(drawn.into_iter().collect(), seen)
        .into_iter()
        .find(|c| (c.curve.place, c.curve.quantity) == (place, course.quantity))
}

/// What is drawn in one place along one quantity: a curve through knots, or the straight line of what a flow adds to a reading. The curves
/// of the first tangent bend at will, those of the second no more than beside effects.
fn along(
    record: &Record,
    [loose, stiff]: [&Tangent; 2],
    state: &[Applied],
    twins: Option<&Twins>,
    course: Course,
) -> Option<Correction> {
    if crosstalk::is_of(course) {
        return crosstalk(record, stiff, state);
    }
    if let (Quantity::Episode, Some(times_s)) = (course.quantity, course.timed_s) {
        return episodic::between(record, loose, state, course.place, times_s);
    }
    if !DRAWN.contains(&course.place) {
        return None;
    }
    if !is_drawn_stiff(course) {
        return drawn(record, loose, state, twins, course);
    }
    let mut found = drawn(record, stiff, state, twins, course)?;
    let least = LEAST_AT_WILL * found.times;
    if found.evidence > least {
        // A hump of the head's own curve, which stiff curves do not follow, shows along the level that goes with the flow; of a law of the
        // level itself something is left however the curves bend, whatever it is owed to.
        let left = at_will(record, loose, state, &found).map_or(0.0, |c| c.evidence + c.owed);
        if left < least {
            found.evidence = left;
            found.borne = found.borne.min(left);
        }
    }
    Some(found)
}

/// A correction that is drawn on stiff curves as it would be on those of a `loose` tangent, to be held against what is drawn there; `None` of any
/// other.
pub(crate) fn at_will(
    record: &Record,
    loose: &Tangent,
    state: &[Applied],
    c: &Correction,
) -> Option<Correction> {
    let course = Course::from(&c.curve);
    is_drawn_stiff(course)
        .then(|| drawn(record, loose, state, None, course))
        .flatten()
}

/// Curves that are drawn and those that are seen; of both in one place, the likelier.
fn merged(drawn: Vec<Correction>, seen: Vec<Correction>) -> Vec<Correction> {
    let mut out = drawn;
    for seen in seen {
        match (out.iter_mut()).find(|c| c.curve.is_alike(&seen.curve)) {
            Some(drawn) if drawn.evidence > seen.evidence => {}
            Some(drawn) => *drawn = seen,
            None => out.push(seen),
        }
    }
    out
}

/// The inlets beside the riser's transmitter, if it has one.
fn beside_riser(
    record: &Record,
    tangent: &Tangent,
    state: &[Applied],
    excluded: &[bool],
) -> Option<Twins> {
    let wander = wander(record, &tangent.curves);
    Twins::of(record, Pair::InletAndRiser, state, wander, excluded)
}

/// A correction that a model holds, made anew beside the `others`; `None` where the recording does not show it.
pub(crate) fn again(
    record: &Record,
    others: &[Applied],
    held: &Curve,
    excluded: &[bool],
) -> Option<Correction> {
    let found = held_on(Bend::Loose, record, others, held, excluded)?;
    (found.evidence > rival_hurdle(&found)).then_some(found)
}

/// The same as the model runs with it: whether there is a correction is told where curves bend at will, its values beside stiff ones.
pub(crate) fn again_as_it_runs(
    record: &Record,
    others: &[Applied],
    held: &Curve,
    excluded: &[bool],
) -> Option<Curve> {
    let found = again(record, others, held, excluded)?;
    let stiff = held_on(Bend::Stiff, record, others, held, excluded);
    Some(stiff.unwrap_or(found).curve)
}

/// A correction that a model holds, beside curves that bend so freely.
fn held_on(
    bend: Bend,
    record: &Record,
    others: &[Applied],
    held: &Curve,
    excluded: &[bool],
) -> Option<Correction> {
    let tangent = Tangent::at(record, others, excluded, bend)?;
    correction(record, &tangent, others, excluded, held)
}

/// What must be left, once curves bend at will, of a correction that is drawn where they do not, e-folds. Set by hand: a hump of half a bar
/// leaves up to 26.
const LEAST_AT_WILL: f64 = 30.0;

/// Evidence that a correction reaches on sound recordings of this one's length, e-folds. Set by hand, like the hurdles of effects above what
/// nearly all simulated sound recordings reach (METHOD.md, section 6).
pub(crate) fn hurdle(c: &Correction) -> f64 {
    let of_hours = match (c.curve.place.relation(), c.curve.quantity) {
        // Transmitters and drives answer late: what is left follows how fast things move.
        (Relation::PumpHead, Quantity::FlowRate) => 60.0,
        // What errors of the flow do to a fitted curve, too.
        (Relation::PumpHead, Quantity::InletPressure) => 130.0,
        (Relation::PumpHead, Quantity::BoosterFlow) => 25.0,
        (Relation::PumpHead, _) => 20.0,
        // Speed stands for flow without its meter's noise.
        (Relation::ReturnLineFriction, Quantity::PumpSpeed) => 110.0,
        (Relation::ReturnLineFriction, Quantity::FlowRate) => 45.0,
        (Relation::ReturnLineFriction, Quantity::InletPressure) => 30.0,
        (Relation::ReturnLineFriction, _) => 14.0,
        (Relation::Instrument, Quantity::Time | Quantity::Episode) => 15.0,
        (Relation::Instrument, _) => 25.0,
        _ => 10.0,
    };
    of_hours * c.times
}

/// Evidence from which on a correction may be what an effect that stands out only resembles, e-folds: there is something then.
pub(crate) fn rival_hurdle(c: &Correction) -> f64 {
    /// Share of its hurdle for what another line's flow adds to a reading, which has a form, as effects have. Set by hand: one or two in
    /// 330 simulated sound recordings show more.
    const OF_A_FORM: f64 = 0.6;
    let share = if crosstalk::is_of(Course::from(&c.curve)) {
        OF_A_FORM
    } else {
        1.0
    };
    share * hurdle(c)
}

/// Length of what happens once, s.
const BUSIEST_S: f64 = 600.0;

/// Evidence that a signature may not count: what it owes to its busiest ten minutes.
fn owed(record: &Record, tangent: &Tangent, signature: &[f64]) -> f64 {
    if record.takes(Step::Busiest) {
        busiest(record, tangent, signature)
    } else {
        0.0
    }
}

/// Evidence that a signature owes to its busiest ten minutes: a reading that freezes once is no law of the rig.
fn busiest(record: &Record, tangent: &Tangent, signature: &[f64]) -> f64 {
    let gained: Vec<f64> = (gained_by_block(record, tangent, signature, 1.0).iter())
        .map(|block| block.0)
        .collect();
    most_within(&gained, once(record)).1
}

/// Evidence that a signature of so much strength has in ten minutes beyond what it would show there were it the cause, e-folds.
///
/// Of a signature with energy E in a window, rows that hold it with white noise gain `E/2`, give or take `sqrt(E)`.
pub(crate) fn excess(record: &Record, tangent: &Tangent, signature: &[f64], strength: f64) -> f64 {
    /// Energies that a window may gain: twice what it would, for a form that is not quite right. Set by hand.
    const ENERGIES: f64 = 1.0;
    /// Deviations: the busiest of many windows is looked at. Set by hand.
    const DEVIATIONS: f64 = 3.0;
    let by_block = gained_by_block(record, tangent, signature, strength);
    let reach = once(record);
    let (mut gained, mut energy, mut most) = (0.0, 0.0, 0.0_f64);
    for (k, one) in by_block.iter().enumerate() {
        gained += one.0;
        energy += one.1;
        if let Some(gone) = k.checked_sub(reach) {
            gained -= by_block[gone].0;
            energy -= by_block[gone].1;
        }
        let would = ENERGIES * energy + DEVIATIONS * energy.max(0.0).sqrt();
        most = most.max(gained - would);
    }
    most
}

/// What a signature of so much strength gains in each block, e-folds, and its energy there.
fn gained_by_block(
    record: &Record,
    tangent: &Tangent,
    signature: &[f64],
    strength: f64,
) -> Vec<(f64, f64)> {
    let mut by_block = vec![(0.0, 0.0); record.blocks];
    let rows = signature.iter().zip(&tangent.off);
    for (row, (s, off)) in rows.enumerate().take(tangent.layout.len()) {
        let s = strength * s;
        let (gained, energy) = &mut by_block[tangent.layout.block(row)];
        *gained += s * (off - 0.5 * s);
        *energy += s * s;
    }
    by_block
}

/// Blocks in what happens once.
fn once(record: &Record) -> usize {
    whole(BUSIEST_S / record.block_s()).max(1)
}

/// How large a curve is: its spread over the recording, and in the mass balance, which holds no constant of its own, its size.
fn size(place: Place, curve: &[f64]) -> f64 {
    let n = curve.len() as f64;
    let mean = if place == Place::Balance {
        0.0
    } else {
        curve.iter().sum::<f64>() / n
    };
    (curve.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / n).sqrt()
}

/// Whether a correction is more than the accuracy of instruments.
pub(crate) fn plausible(c: &Correction) -> bool {
    c.size > c.least
}

#[cfg(test)]
mod tests;
