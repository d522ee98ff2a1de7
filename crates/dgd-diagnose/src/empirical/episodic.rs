//! What sets in at some time and stays, or lasts for a while: a transmitter that shifts, a valve that was left open for ten minutes.
//!
//! Knots along time are too far apart for an edge. A place that is off by the same from one time to another needs three numbers,
//! tells when, and holds on windows that no fit has used.

use super::drawn::least;
use super::{BUSIEST_S, Correction, Course, busiest, plausible};
use crate::ablation::Step;
use crate::layout::Section;
use crate::numbers::whole;
use crate::record::Record;
use crate::relations::{Applied, joined};
use crate::tangent::Tangent;
use dgd_effects::{Curve, KNOTS, Place, Quantity};
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

/// Stretches that a recording is cut into; an episode begins and ends at their edges, before the edges are moved.
const STRETCHES: usize = 96;
/// Places of an edge that are tried within a stretch.
const ALL_OVER: i32 = 12;
/// The likeliest in any of some places; the choice of its times is paid for.
pub(super) fn best(
    record: &Record,
    tangent: &Tangent,
    state: &[Applied],
    places: &[Place],
) -> Option<Correction> {
    let search = Search::of(record, tangent, state);
    let found: Vec<Correction> = (places.par_iter())
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
    (from_s, to_s): (f64, f64),
) -> Option<Correction> {
    let course = Course {
        place,
        quantity: Quantity::Episode,
        timed_s: Some((from_s, to_s)),
    };
    let off_by =
        |value: f64| Curve::new(place, Quantity::Episode, (from_s, to_s), vec![value; KNOTS]);
    let with = |curve: &Curve| joined(state, &Applied::from(curve));
    let change = tangent.change(record, &with(&off_by(place.width())));
    let (gram, right) = tangent.normal_equations(record, std::slice::from_ref(&change));
    let one = Solved::of(gram[(0, 0)], right[0]);
    let curve = off_by(one.widths * place.width());
    // Rows are not linear in an error of the flow.
    let signature = if place == Place::MeterFactor {
        tangent.signature(record, &with(&curve))
    } else {
        let change: Vec<f64> = change.iter().map(|c| one.widths * c).collect();
        tangent.beyond(record, &change)
    };
    let owed = if record.takes(Step::Busiest) {
        busiest(record, tangent, &signature)
    } else {
        0.0
    };
    let evidence = one.evidence - owed;
    evidence.is_finite().then(|| Correction {
        size: size(record, &curve),
        curve,
        signature,
        evidence,
        borne: evidence,
        freedom: one.freedom,
        least: least(course),
        seen: None,
        times: Record::times_usual(record.lasts_s()),
    })
}

/// How large an episode is: its spread over the recording, or, in the mass balance, which holds no constant of its own, its size.
fn size(record: &Record, curve: &Curve) -> f64 {
    let (from, to) = record.setting.span_s;
    let (begins, ends) = curve.episode_s((from, to)).unwrap_or((from, to));
    let share = (ends - begins) / (to - from);
    let spread = if curve.place == Place::Balance {
        share
    } else {
        share * (1.0 - share)
    };
    curve.at(begins).abs() * spread.max(0.0).sqrt()
}

/// One number of unit prior width, solved for.
struct Solved {
    widths: f64,
    evidence: f64,
    freedom: f64,
}

impl Solved {
    /// From its energy and its product with what is left over.
    fn of(energy: f64, pull: f64) -> Self {
        let energy = energy.max(0.0);
        Self {
            widths: pull / (1.0 + energy),
            evidence: 0.5 * pull * pull / (1.0 + energy) - 0.5 * energy.ln_1p(),
            freedom: energy / (1.0 + energy),
        }
    }
}

/// What one place is off by between two edges, s from the recording's start.
struct Episode {
    place: Place,
    from: f64,
    to: f64,
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

/// How the rows answer a place that is off all the time by its width, and one that runs away by a width a second.
struct Answer {
    constant: Vec<f64>,
    rate: Vec<f64>,
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

    /// How the rows answer a place.
    fn answer(&self, place: Place) -> Answer {
        let span = self.record.setting.span_s;
        let change = |last: f64| -> Vec<f64> {
            let share = |k: usize| 1.0 + (last - 1.0) * k as f64 / (KNOTS - 1) as f64;
            let knots = (0..KNOTS).map(|k| place.width() * share(k)).collect();
            let curve = Curve::new(place, Quantity::Time, span, knots);
            let with = joined(self.state, &Applied::from(&curve));
            let finite = |v: f64| if v.is_finite() { v } else { 0.0 };
            (self.tangent.change(self.record, &with).into_iter())
                .map(finite)
                .collect()
        };
        let constant = change(1.0);
        let mut rate = vec![0.0; constant.len()];
        // The mass balance holds the rate of the inlets' reading.
        if place == Place::InletReading {
            let rising = change(2.0);
            for row in self.tangent.layout.rows(Section::Balance) {
                rate[row] = (rising[row] - constant[row]) * self.lasts_s();
            }
        }
        Answer { constant, rate }
    }

    /// What being off by a width between two edges changes in the rows.
    ///
    /// Of a reading whose rate the mass balance holds, that tells to the row when it jumps: `edged` or not.
    fn column(&self, answer: &Answer, from: f64, to: f64, edged: bool) -> Vec<f64> {
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
        let answer = self.answer(place);
        (self.coarse(place, &answer).into_iter().flatten())
            .filter_map(|e| self.finer(&answer, e))
            .max_by(|a, b| a.evidence.total_cmp(&b.evidence))
    }

    /// The best of the episodes that begin with a stretch and go on, and of those that end with one.
    fn coarse(&self, place: Place, answer: &Answer) -> [Option<Episode>; 2] {
        let edge = |k: usize| self.lasts_s() * k as f64 / STRETCHES as f64;
        let columns: Vec<Vec<f64>> = (0..STRETCHES)
            .map(|k| self.column(answer, edge(k), edge(k + 1), false))
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
                from: edge(a),
                to: edge(b),
                evidence: Solved::of(energy, pull).evidence - choice,
                choice,
            }
        };
        let least = 1 + whole((BUSIEST_S / edge(1)).floor());
        let best = |ends: bool| {
            let until = |a: usize| {
                let last = if ends { STRETCHES - 1 } else { STRETCHES };
                let from = if ends { a + least } else { STRETCHES };
                (from..=last).map(move |b| (a, b))
            };
            (first..STRETCHES.saturating_sub(least))
                .flat_map(until)
                .filter(|(a, b)| b - a < STRETCHES)
                .map(|(a, b)| of(a, b))
                .filter(|e| e.evidence > 0.0)
                .max_by(|a, b| a.evidence.total_cmp(&b.evidence))
        };
        [best(false), best(true)]
    }

    /// The same with its edges where they explain most, to the block.
    fn finer(&self, answer: &Answer, mut e: Episode) -> Option<Correction> {
        let end = self.lasts_s();
        let explains = |from: f64, to: f64| {
            let column = self.column(answer, from, to, true);
            let (gram, right) = (self.tangent).normal_equations(self.record, &[column]);
            Solved::of(gram[(0, 0)], right[0]).evidence
        };
        let mut most = explains(e.from, e.to);
        let mut moved = |e: &mut Episode, by: f64, first: bool| {
            let (from, to) = if first {
                (e.from + by, e.to)
            } else {
                (e.from, e.to + by)
            };
            let stays = if first { e.from <= 0.0 } else { e.to >= end };
            if stays || from <= 0.0 && first || to >= end && !first || to - from <= BUSIEST_S {
                return;
            }
            let there = explains(from, to);
            if there > most {
                (e.from, e.to, most) = (from, to, there);
            }
        };
        let stretch = end / STRETCHES as f64;
        // What jumps is told to the row: it is looked for all over the stretches beside.
        for first in [true, false] {
            let at = (e.from, e.to);
            for k in -ALL_OVER..=ALL_OVER {
                let to = f64::from(k) / f64::from(ALL_OVER) * stretch;
                let moved_so_far = if first { e.from - at.0 } else { e.to - at.1 };
                moved(&mut e, to - moved_so_far, first);
            }
        }
        let mut step = 0.5 * stretch / f64::from(ALL_OVER);
        while step >= 0.5 * self.record.block_s() {
            for (by, first) in [(-step, true), (step, true), (-step, false), (step, false)] {
                moved(&mut e, by, first);
            }
            step *= 0.5;
        }
        let begin = self.record.setting.span_s.0;
        let (from_s, to_s) = (begin + e.from, (e.to < end).then_some(begin + e.to));
        let curve = Curve::episode(e.place, (from_s, to_s), 0.0);
        let mut found = between(
            self.record,
            self.tangent,
            self.state,
            e.place,
            (curve.from, curve.to),
        )?;
        found.evidence -= e.choice;
        found.borne -= e.choice;
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
