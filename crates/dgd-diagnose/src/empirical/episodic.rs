//! What sets in at some time and stays, or lasts for a while: a transmitter that shifts, a valve that was left open for half an hour.
//!
//! Knots along time are too far apart for an edge. A place that is off by the same from one time to another needs three numbers,
//! tells when, and holds on windows that no fit has used.

use super::straight::sized;
use super::timed::Answer;
use super::{BUSIEST_S, Correction, owed, plausible};
use crate::bayes::evidence;
use crate::layout::Section;
use crate::numbers::whole;
use crate::record::{MEASURED_S, Record};
use crate::relations::Applied;
use crate::tangent::Tangent;
use dgd_effects::{Curve, KNOTS, Place, Quantity};
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

/// Stretches that a recording is cut into; an episode begins and ends at their edges, before the edges are moved.
const STRETCHES: usize = 96;
/// Places of an edge that are tried within a stretch.
const ALL_OVER: i32 = 12;

/// Whether the rows of a relation are off to one side, for longer than what happens once, by more than noise may be: then a search may pay.
pub(crate) fn episode_may_be(record: &Record, tangent: &Tangent) -> bool {
    /// E-folds. Set by hand, below what any episode must show beside the choice of its edges.
    const SHOWS: f64 = 12.0;
    let (layout, lasts_s) = (tangent.layout, record.lasts_s());
    let times_s = layout.times_s(record.block_s());
    let least = least_stretches(lasts_s);
    Section::ALL.into_iter().any(|section| {
        // Sum and number of the rows from the first on, stretch by stretch.
        let mut sums = [(0.0, 0.0); STRETCHES + 1];
        for row in layout
            .rows(section)
            .filter(|row| tangent.whitening.valid[*row])
        {
            let stretch = (times_s[row] / lasts_s * STRETCHES as f64).floor();
            let stretch = whole(stretch).min(STRETCHES - 1);
            sums[stretch + 1].0 += tangent.off[row];
            sums[stretch + 1].1 += 1.0;
        }
        for k in 0..STRETCHES {
            sums[k + 1].0 += sums[k].0;
            sums[k + 1].1 += sums[k].1;
        }
        let shows = |a: usize, b: usize| {
            let (sum, rows) = (sums[b].0 - sums[a].0, sums[b].1 - sums[a].1);
            0.5 * sum * sum > SHOWS * rows
        };
        (0..STRETCHES).any(|a| (a + least..=STRETCHES).any(|b| shows(a, b)))
    })
}

/// Stretches that last longer than what happens once.
fn least_stretches(lasts_s: f64) -> usize {
    1 + whole((BUSIEST_S * STRETCHES as f64 / lasts_s).floor())
}

/// The likeliest in any of some places; the choice of its times is paid for.
pub(super) fn best(
    record: &Record,
    tangent: &Tangent,
    state: &[Applied],
    places: &[Place],
) -> Option<Correction> {
    let search = Search::of(record, tangent, state);
    let found: Vec<Correction> = (places.par_iter().with_max_len(1))
        .filter_map(|place| search.likeliest(*place))
        .collect();
    (found.into_iter().filter(plausible)).max_by(|a, b| a.evidence.total_cmp(&b.evidence))
}

/// The likeliest in one place; the choice of its times is paid for.
pub(super) fn in_place(
    record: &Record,
    tangent: &Tangent,
    state: &[Applied],
    place: Place,
) -> Option<Correction> {
    Search::of(record, tangent, state).likeliest(place)
}

/// What one place is off by from one time to another, s: in the mass balance and in the factor of the meter from nothing, elsewhere from
/// the base curve, which has a constant of its own.
pub(super) fn between(
    record: &Record,
    tangent: &Tangent,
    state: &[Applied],
    place: Place,
    times_s: (f64, f64),
) -> Option<Correction> {
    /// Share of the recording from which on an episode is rather a course of its own. Set by hand.
    const MOSTLY: f64 = 0.5;
    let unit = Curve::new(
        place,
        Quantity::Episode,
        times_s,
        vec![place.width(); KNOTS],
    );
    let found = sized(record, tangent, state, &unit)?;
    let acts_s = acts_between_s(record, &found.curve);
    let happened = place == Place::Balance
        && record.told.between_s(acts_s) < MOSTLY * record.told_s()
        && !may_have_frozen(record, times_s)
        && outlasts_once(record, tangent, &found.signature);
    // It tells that there is something; against an effect, which pays for its form, it pays as any correction does.
    let owed = owed(record, tangent, &found.signature);
    let of_something = if happened { 0.0 } else { owed };
    Some(Correction {
        size: size(record, &found.curve),
        times: record.times_usual(acts_s),
        evidence: found.evidence - of_something,
        borne: found.borne - owed,
        ..found
    })
}

/// Whether the signature of an episode of the mass balance explains more there than ten minutes of it would by themselves: a jump of a
/// reading is a moment of the balance.
fn outlasts_once(record: &Record, tangent: &Tangent, signature: &[f64]) -> bool {
    /// E-folds. Set by hand.
    const MORE: f64 = 3.0;
    let rows = tangent.layout.rows(Section::Balance);
    let once = whole(BUSIEST_S / record.row_s()).max(1);
    let told: Vec<(f64, f64)> = (signature[rows.clone()].iter().zip(&tangent.off[rows]))
        .map(|(s, off)| (s * off, s * s))
        .collect();
    // The most that a strength of its own explains in some rows, from the first on.
    let explained = |(product, energy): (f64, f64)| 0.5 * product * product / energy.max(1e-300);
    let add = |sum: &mut (f64, f64), one: &(f64, f64)| {
        *sum = (sum.0 + one.0, sum.1 + one.1);
        Some(*sum)
    };
    let whole = told
        .iter()
        .scan((0.0, 0.0), add)
        .last()
        .map_or(0.0, explained);
    let within = |first: usize| {
        let some = told[first..].iter().take(once).scan((0.0, 0.0), add);
        some.map(explained).fold(0.0, f64::max)
    };
    (0..told.len()).all(|first| within(first) + MORE < whole)
}

/// Whether a reading of the mass balance stands still for half of an episode or more and moves again as it ends, or before: then it may have
/// frozen. One that never stands still has not, and what it tells of in ten minutes has happened.
pub(super) fn may_have_frozen(record: &Record, (from_s, to_s): (f64, f64)) -> bool {
    /// How much later than the episode ends a reading may move again, s: its edges are told to the row. Set by hand.
    const LATER_S: f64 = 120.0;
    let at = |t_s: f64| record.t_s.partition_point(|t| *t < t_s);
    let (first, end, last) = (at(from_s), at(to_s), at(to_s + LATER_S));
    let flows = [
        &record.mud_pump,
        &record.booster,
        &record.topfill,
        &record.flow,
    ];
    (flows.into_iter().chain(&record.inlets)).any(|reading| {
        let samples = reading.get(first..last.min(reading.len()));
        // One that is missing neither moves nor stands still.
        let told: Vec<f64> = (samples.into_iter().flatten().copied())
            .filter(|value| value.is_finite())
            .collect();
        let mut stands = 0;
        told.windows(2).any(|pair| {
            let moves = pair[0] != pair[1];
            let frozen = moves && 2 * stands >= end - first;
            stands = if moves { 0 } else { stands + 1 };
            frozen
        })
    })
}

/// When an episode acts within the recording, s.
fn acts_between_s(record: &Record, curve: &Curve) -> (f64, f64) {
    let span_s = record.setting.span_s;
    curve.episode_s(span_s).unwrap_or(span_s)
}

/// How large an episode is: its spread over the recording, of days over those about it, or, in the mass balance, which holds no constant of its
/// own, its size.
fn size(record: &Record, curve: &Curve) -> f64 {
    let acts_s = record.told.between_s(acts_between_s(record, curve));
    let about_s = record.told_s().min(MEASURED_S.max(2.0 * acts_s));
    let share = acts_s / about_s;
    let spread = if curve.place == Place::Balance {
        share
    } else {
        share * (1.0 - share)
    };
    curve.at(curve.from).abs() * spread.max(0.0).sqrt()
}

/// What one place is off by between two edges.
struct Episode {
    place: Place,
    /// s from the recording's start.
    edges: [f64; 2],
    evidence: f64,
    /// What the choice of its edges costs, which is taken off.
    choice: f64,
}

struct Search<'a> {
    record: &'a Record,
    tangent: &'a Tangent,
    state: &'a [Applied],
    times: Times,
}

/// When the rows are: their middle and their length, s.
struct Times {
    middle_s: Vec<f64>,
    length_s: Vec<f64>,
}

impl<'a> Search<'a> {
    fn of(record: &'a Record, tangent: &'a Tangent, state: &'a [Applied]) -> Self {
        let (layout, block_s) = (tangent.layout, record.block_s());
        let length = |row: usize| layout.place(row).0.blocks_per_row() as f64 * block_s;
        let times = Times {
            middle_s: layout.times_s(block_s),
            length_s: (0..layout.len()).map(length).collect(),
        };
        Self {
            record,
            tangent,
            state,
            times,
        }
    }

    fn lasts_s(&self) -> f64 {
        self.record.lasts_s()
    }

    /// What being off by a width between two edges changes in the rows.
    ///
    /// Of a reading whose rate the mass balance holds, that tells to the row when it jumps: `edged` or not.
    fn column(&self, answer: &Answer, [from, to]: [f64; 2], edged: bool) -> Vec<f64> {
        let end = self.lasts_s();
        let Times { middle_s, length_s } = &self.times;
        (0..middle_s.len())
            .map(|row| {
                let (begins, lasts) = (middle_s[row] - 0.5 * length_s[row], length_s[row]);
                let until = |edge: f64| (edge - begins).clamp(0.0, lasts) / lasts;
                // An edge is a jump of the reading: its rate is that over the row. At the ends of the recording there is none.
                let jump = |edge: f64| {
                    let within =
                        edge > begins && edge <= begins + lasts && edge > 0.0 && edge < end;
                    f64::from(u8::from(within)) / lasts
                };
                let jumps = if edged { jump(from) - jump(to) } else { 0.0 };
                answer.constant[row] * (until(to) - until(from)) + answer.rate[row] * jumps
            })
            .collect()
    }

    /// The likeliest episode in a place. What goes on and what ends are nearly as likely where only its edges tell them apart.
    fn likeliest(&self, place: Place) -> Option<Correction> {
        let answer = Answer::of(self.record, self.tangent, self.state, place);
        (self.coarse(place, &answer).into_iter().flatten())
            .filter_map(|e| self.finer(&answer, e))
            .max_by(|a, b| a.evidence.total_cmp(&b.evidence))
    }

    /// The best of the episodes that begin with a stretch and go on, and of those that end with one.
    fn coarse(&self, place: Place, answer: &Answer) -> [Option<Episode>; 2] {
        let edge = |k: usize| self.lasts_s() * k as f64 / STRETCHES as f64;
        let columns: Vec<Vec<f64>> = (0..STRETCHES)
            .map(|k| self.column(answer, [edge(k), edge(k + 1)], false))
            .collect();
        let (gram, right) = self.tangent.normal_equations(self.record, &columns);
        let sums = Sums::of(&gram, &right);
        // What is off until some time is as much off from then on, except where there is no constant to set one off against the other.
        let first = usize::from(place != Place::Balance && place != Place::MeterFactor);
        let of = |a: usize, b: usize| {
            let choice = choice(a > 0, b < STRETCHES);
            let (energy, pull) = sums.between(a, b);
            Episode {
                place,
                edges: [edge(a), edge(b)],
                evidence: evidence(energy, pull, 1.0, false) - choice,
                choice,
            }
        };
        let least = least_stretches(self.lasts_s());
        let best = |ends: bool| {
            let until = |a: usize| {
                let last = if ends {
                    a + least..STRETCHES
                } else {
                    STRETCHES..STRETCHES + 1
                };
                last.map(move |b| of(a, b))
            };
            // From beginning to end it is no episode.
            let begins = first.max(usize::from(!ends))..STRETCHES.saturating_sub(least);
            (begins.flat_map(until))
                .filter(|e| e.evidence > 0.0)
                .max_by(|a, b| a.evidence.total_cmp(&b.evidence))
        };
        [best(false), best(true)]
    }

    /// The same with its edges where they explain most, to the block.
    fn finer(&self, answer: &Answer, mut e: Episode) -> Option<Correction> {
        let end = self.lasts_s();
        let explains = |edges: [f64; 2]| {
            let column = self.column(answer, edges, true);
            let (gram, right) = (self.tangent).normal_equations(self.record, &[column]);
            evidence(gram[(0, 0)], right[0], 1.0, false)
        };
        let mut most = explains(e.edges);
        let inside = |edge: f64| edge > 0.0 && edge < end;
        let mut try_at = |edges: &mut [f64; 2], which: usize, at: f64| {
            let mut there = *edges;
            there[which] = at;
            // An end of the recording is no edge, and does not move.
            if inside(edges[which]) && inside(at) && there[1] - there[0] > BUSIEST_S {
                let explained = explains(there);
                if explained > most {
                    (*edges, most) = (there, explained);
                }
            }
        };
        let stretch = end / STRETCHES as f64;
        // What jumps is told to the row: it is looked for all over the stretches beside.
        for which in [0, 1] {
            let from = e.edges[which];
            for k in -ALL_OVER..=ALL_OVER {
                let by = f64::from(k) / f64::from(ALL_OVER) * stretch;
                try_at(&mut e.edges, which, from + by);
            }
        }
        let mut step = 0.5 * stretch / f64::from(ALL_OVER);
        while step >= 0.5 * self.record.block_s() {
            for (which, by) in [(0, -step), (0, step), (1, -step), (1, step)] {
                let at = e.edges[which] + by;
                try_at(&mut e.edges, which, at);
            }
            step *= 0.5;
        }
        let [from_s, to_s] = e.edges.map(|edge| self.record.setting.span_s.0 + edge);
        let times = Curve::episode(e.place, (from_s, inside(e.edges[1]).then_some(to_s)), 0.0);
        let mut found = between(
            self.record,
            self.tangent,
            self.state,
            e.place,
            (times.from, times.to),
        )?;
        found.pay(e.choice);
        Some(found)
    }
}

/// What the choice of the edges costs, e-folds.
fn choice(begins: bool, ends: bool) -> f64 {
    let places = STRETCHES as f64;
    match (begins, ends) {
        (true, true) => (0.5 * places * places).ln(),
        _ => places.ln(),
    }
}

/// Energies and products of the stretches, summed from the first on: those of any that follow one another are differences.
struct Sums {
    energy: DMatrix<f64>,
    pull: Vec<f64>,
}

impl Sums {
    fn of(gram: &DMatrix<f64>, right: &DVector<f64>) -> Self {
        let n = right.len();
        let mut energy = DMatrix::zeros(n + 1, n + 1);
        let mut pull = vec![0.0; n + 1];
        for a in 0..n {
            pull[a + 1] = pull[a] + right[a];
            for b in 0..n {
                energy[(a + 1, b + 1)] =
                    gram[(a, b)] + energy[(a, b + 1)] + energy[(a + 1, b)] - energy[(a, b)];
            }
        }
        Self { energy, pull }
    }

    /// Energy and product of the stretches from `a` to before `b`.
    fn between(&self, a: usize, b: usize) -> (f64, f64) {
        let e = &self.energy;
        let energy = e[(b, b)] - e[(a, b)] - e[(b, a)] + e[(a, a)];
        (energy, self.pull[b] - self.pull[a])
    }
}
