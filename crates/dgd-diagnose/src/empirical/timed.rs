//! Corrections with times of their own, in place of what needs none: what comes again, and what sets in or passes.
//!
//! Whether there is something, and how likely, is found without them: with times it is told better what it is.

use super::{
    Correction, DRAWN, at_will, beside_riser, correction, episodic, hold_without_stops, hurdle,
    periodic,
};
use crate::layout::Section;
use crate::record::Record;
use crate::relations::{Applied, joined};
use crate::tangent::{Bend, Tangent};
use dgd_effects::{Curve, KNOTS, Place, Quantity};
use dgd_lsq::dot;
use tracing::debug;

/// Evidence by which what comes again, and what begins or ends, must be better than what needs no times: e-folds. Set by hand.
pub(super) const COMES_AGAIN: f64 = 10.0;
const BEGINS: f64 = 5.0;

/// A correction along the time of a period, or of an episode, that tells more than this one, in any place, if there is one.
pub(crate) fn instead_of(record: &Record, state: &[Applied], c: &Correction) -> Option<Correction> {
    if c.seen.is_some() || c.curve.quantity.is_timed() {
        return None;
    }
    let tangent = Tangent::beside(record, state, &[], Bend::Loose)?;
    let places = drawn_places(record, &tangent, state);
    // What was drawn on stiff curves shows more there than beside these.
    let here = at_will(record, &tangent, state, c);
    let shown = here.map_or(c.evidence, |here| here.evidence.min(c.evidence));
    let found = [
        periodic::best(record, &tangent, state, &places, shown),
        episodic::best(record, &tangent, state, &places),
    ];
    let mut found: Vec<Correction> = found.into_iter().flatten().collect();
    // Stops come nearly as regularly.
    hold_without_stops(record, tangent, state, &mut found);
    found.retain(|found| {
        told(found, shown);
        let by = match found.curve.quantity {
            Quantity::Period => COMES_AGAIN,
            _ => BEGINS,
        };
        found.evidence > (shown + by).max(hurdle(found))
    });
    found.sort_by(|a, b| b.evidence.total_cmp(&a.evidence));
    (found.into_iter()).find(|found| {
        found.curve.quantity == Quantity::Period
            || leaves_no_more(record, state, c, found) && is_all(record, state, found)
    })
}

/// The likeliest episode in any place.
///
/// Knots along time hardly follow twenty minutes of it, so that nothing else need stand out.
pub(super) fn sought(record: &Record, tangent: &Tangent, state: &[Applied]) -> Option<Correction> {
    let places = drawn_places(record, tangent, state);
    episodic::best(record, tangent, state, &places)
}

/// Leaves an episode out that does not tell more than what else there is in its place, or is not all that this is off by.
pub(super) fn keep_what_stands_out(record: &Record, state: &[Applied], out: &mut Vec<Correction>) {
    let is_episode = |c: &Correction| c.curve.quantity == Quantity::Episode;
    let Some(at) = out.iter().position(is_episode) else {
        return;
    };
    let episode = out.swap_remove(at);
    let there = out.iter().filter(|c| c.curve.place == episode.curve.place);
    let shown = there.map(|c| c.evidence).fold(0.0, f64::max);
    told(&episode, shown);
    let stands = episode.evidence > (shown + BEGINS).max(hurdle(&episode));
    if stands && is_all(record, state, &episode) {
        out.push(episode);
    }
}

/// Whether an episode is all that its place is off by: beside it a course along time has hardly anything left to tell.
fn is_all(record: &Record, state: &[Applied], episode: &Correction) -> bool {
    /// Share of its evidence that may be left over. Set by hand: that at which effects are as likely to resemble the cause as to be it.
    const LEFT: f64 = 0.12;
    let state = joined(state, &Applied::from(&episode.curve));
    let beside = Tangent::beside(record, &state, &[], Bend::Loose);
    let course = (episode.curve.place, Quantity::Time);
    let left = beside.and_then(|tangent| correction(record, &tangent, &state, &[], course));
    if let Some(left) = &left {
        debug!(
            "a course along time has {:.1} left beside it",
            left.evidence
        );
    }
    left.is_none_or(|left| left.evidence < (LEFT * episode.evidence).max(hurdle(&left)))
}

/// Whether an episode leaves no more over than a correction, of which every parameter takes half a square away.
pub(super) fn leaves_no_more(
    record: &Record,
    state: &[Applied],
    c: &Correction,
    episode: &Correction,
) -> bool {
    leaves_more(
        record,
        state,
        &joined(state, &Applied::from(&c.curve)),
        episode,
    )
    .is_some_and(|more| more < 0.5 * c.freedom)
}

/// An episode in any place that leaves less over than a state `with` an effect which only resembles the cause, and no more than a `rival` to that,
/// if there is one; with how much less it leaves, e-folds.
pub(crate) fn episode_like(
    record: &Record,
    state: &[Applied],
    with: &[Applied],
    rival: Option<&Correction>,
) -> Option<(Correction, f64)> {
    /// E-folds by which it must leave less, as its edges were chosen. Set by hand.
    const LESS: f64 = 10.0;
    let tangent = Tangent::beside(record, state, &[], Bend::Loose)?;
    let places = drawn_places(record, &tangent, state);
    let mut found = episodic::best(record, &tangent, state, &places)?;
    hold_without_stops(record, tangent, state, std::slice::from_mut(&mut found));
    let stands = |rival: &Correction| leaves_no_more(record, state, rival, &found);
    let less = -leaves_more(record, state, with, &found)?;
    let it = found.evidence > hurdle(&found)
        && less > LESS
        && rival.is_none_or(stands)
        && is_all(record, state, &found);
    it.then_some((found, less))
}

/// By how much the misfit of an episode beside a state exceeds that of the rival explanation, the state `with`, e-folds.
///
/// The evidence of the two is not on one scale: each is judged by the noise that is left without it, part of which is the other's effect, and a shift of an
/// instrument may pass for its wander. So each misfit is whitened by the noise that is left with the other in place.
fn leaves_more(
    record: &Record,
    state: &[Applied],
    with: &[Applied],
    episode: &Correction,
) -> Option<f64> {
    let without_it = Tangent::at(record, with, &[], Bend::Lean)?;
    let beside = joined(state, &Applied::from(&episode.curve));
    let with_it = without_it.left_over(record, &beside);
    let left = |off: &[f64]| 0.5 * dot(off, off);
    let more = left(&with_it) - left(&without_it.off);
    let Curve {
        place, from, to, ..
    } = &episode.curve;
    debug!(
        "an episode in {}, {from:.0} s to {to:.0} s, leaves {more:.1} more",
        place.name()
    );
    more.is_finite().then_some(more)
}

/// Tells in the log what a timed correction tells more.
fn told(found: &Correction, shown: f64) {
    let Curve {
        place,
        quantity,
        from,
        to,
        ..
    } = &found.curve;
    debug!(
        "{} in {}, {from:.0} s to {to:.0} s, brings it from {shown:.1} to {:.1}",
        quantity.name(),
        place.name(),
        found.evidence
    );
}

/// Places that a timed curve may be drawn for: of a reading that drifts, the riser's transmitter draws the curve.
fn drawn_places(record: &Record, tangent: &Tangent, state: &[Applied]) -> Vec<Place> {
    let witnessed = beside_riser(record, tangent, state, &[]).is_some();
    let drawn = |place: &Place| *place != Place::InletReading || !witnessed;
    DRAWN.into_iter().filter(drawn).collect()
}

/// A correction that was found, made anew without the excluded blocks, on which a tangent has no weight; the times of what is timed are not told by
/// them either. An episode of which the other rows do not tell nearly the same times is a course along time.
pub(crate) fn anew(
    record: &Record,
    tangent: &Tangent,
    state: &[Applied],
    excluded: &[bool],
    held: &Curve,
) -> Option<Correction> {
    /// Share of the time that either of two episodes acts in which both do, from which on they are the same. Set by hand.
    const SAME: f64 = 0.8;
    let (place, span_s) = (held.place, record.setting.span_s);
    let found = match held.quantity {
        Quantity::Period => periodic::in_place(record, tangent, state, place),
        Quantity::Episode => {
            let same = |found: &Correction| {
                let times = (found.curve.episode_s(span_s)).zip(held.episode_s(span_s));
                times.is_some_and(|(a, b)| in_common(a, b) > SAME)
            };
            episodic::in_place(record, tangent, state, place)
                .filter(same)
                .or_else(|| correction(record, tangent, state, excluded, (place, Quantity::Time)))
        }
        _ => return correction(record, tangent, state, excluded, held),
    };
    // The choice of times must pay.
    found.filter(|found| found.evidence > 0.0)
}

/// Of the time that lies in either of two intervals, the share that lies in both.
fn in_common(a: (f64, f64), b: (f64, f64)) -> f64 {
    let both = (a.1.min(b.1) - a.0.max(b.0)).max(0.0);
    both / (a.1 - a.0 + b.1 - b.0 - both)
}

/// How rows answer a place that is off by its width all the time, and one that runs away by a width a second. Only the balance answers a
/// rate, and only of the inlets' reading, whose rate it holds.
pub(super) struct Answer {
    pub(super) constant: Vec<f64>,
    pub(super) rate: Vec<f64>,
}

impl Answer {
    pub(super) fn of(record: &Record, tangent: &Tangent, state: &[Applied], place: Place) -> Self {
        let (from, to) = record.setting.span_s;
        let change = |knot: &dyn Fn(usize) -> f64| -> Vec<f64> {
            let knots = (0..KNOTS).map(|k| place.width() * knot(k)).collect();
            let curve = Curve::new(place, Quantity::Time, (from, to), knots);
            let with = joined(state, &Applied::from(&curve));
            let finite = |v: f64| if v.is_finite() { v } else { 0.0 };
            (tangent.change(record, &with).into_iter())
                .map(finite)
                .collect()
        };
        let constant = change(&|_| 1.0);
        let mut rate = vec![0.0; constant.len()];
        if place == Place::InletReading {
            let line = change(&|k| k as f64 / (KNOTS - 1) as f64);
            for row in tangent.layout.rows(Section::Balance) {
                rate[row] = line[row] * (to - from);
            }
        }
        Self { constant, rate }
    }
}
