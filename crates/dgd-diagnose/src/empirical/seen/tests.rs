//! Claims about what parts the inlets from the riser's transmitter: where it is put, and when it is nothing.
#![allow(clippy::unwrap_used, reason = "a test may fail by panic")]

use super::{Correction, all, knots};
use crate::ablation::Step;
use crate::contest::{Contender, contest};
use crate::empirical::{correction, hurdle, merged, plausible};
use crate::layout::BALANCE_BLOCKS;
use crate::record::Record;
use crate::relations::Applied;
use crate::relations::FINE_KNOTS;
use crate::tangent::{Bend, Tangent};
use crate::test_rig::{FLOW_M3_S, Hidden, SPEED_PCT, drilled, normals};
use crate::twins::seen_curve;
use dgd_effects::{Curve, KNOTS, Place, Quantity};
use dgd_lsq::dot;

/// Where what parts two transmitters may sit.
const PLACED: [Place; 7] = [
    Place::InletReading,
    Place::Suction,
    Place::RiserReading,
    Place::FirstInlet,
    Place::SecondInlet,
    Place::FirstOutlet,
    Place::SecondOutlet,
];

/// Grows for a quarter of an hour, and clears: six times in the recording.
fn saw(t: f64) -> f64 {
    3e4 * (t / 900.0).rem_euclid(1.0)
}

/// Drilling with a transmitter in the riser, 3 m of mud above the inlets, and two at either side of the pump.
fn beside_riser() -> Record {
    let mut record = drilled(Hidden::default());
    let n = record.t_s.len();
    let noise = normals(9, n);
    let riser = |(p, noise): (&f64, &f64)| p - 3.5e4 + 500.0 * noise;
    record.riser = Some(record.inlet.iter().zip(&noise).map(riser).collect());
    let two = |values: &[f64], seed: u64, by: f64| -> Vec<Vec<f64>> {
        let noise = normals(seed, n);
        let read = |sign: f64| {
            let one = |(p, noise): (&f64, &f64)| p + sign * by * noise;
            values.iter().zip(&noise).map(one).collect()
        };
        vec![read(1.0), read(-1.0)]
    };
    record.inlets = two(&record.inlet, 10, 300.0);
    record.outlets = two(&record.outlet, 11, 800.0);
    record
}

/// The same with one place off by a curve of time.
fn off(place: Place, curve: fn(f64) -> f64) -> Record {
    let mut record = beside_riser();
    for i in 0..record.t_s.len() {
        let by = curve(record.t_s[i]);
        let inlets = |record: &mut Record, by: f64| {
            record.inlet[i] += by;
            record.inlets.iter_mut().for_each(|p| p[i] += by);
        };
        match place {
            Place::InletReading => inlets(&mut record, by),
            Place::RiserReading => record.riser.as_mut().unwrap()[i] += by,
            Place::Suction => {
                // The pump turns faster for what it has to lift more.
                inlets(&mut record, -by);
                let square = (record.speed[i] / SPEED_PCT).powi(2) + by / 45e5;
                record.speed[i] = SPEED_PCT * square.sqrt();
            }
            Place::FirstInlet | Place::SecondInlet => {
                record.inlet[i] += 0.5 * by;
                record.inlets[usize::from(place == Place::SecondInlet)][i] += by;
            }
            _ => {
                record.outlet[i] += 0.5 * by;
                record.outlets[usize::from(place == Place::SecondOutlet)][i] += by;
            }
        }
    }
    record.filled.inlet.clone_from(&record.inlet);
    record.filled.outlet.clone_from(&record.outlet);
    record.filled.speed.clone_from(&record.speed);
    record
}

fn found(record: &Record) -> Vec<Correction> {
    let tangent = Tangent::at(record, &[], &[], Bend::Loose).unwrap();
    let mut out = all(record, &tangent, &[], &[]);
    out.sort_by(|a, b| b.evidence.total_cmp(&a.evidence));
    out
}

#[test]
fn what_parts_the_two_is_put_where_the_relations_find_it() {
    for place in PLACED {
        let record = off(place, saw);
        let found = found(&record);
        let best = &found[0];
        let course = (place, Quantity::Time);
        assert_eq!((best.curve.place, best.curve.quantity), course);
        assert!(
            best.evidence > 100.0 + hurdle(best) && plausible(best),
            "{place:?}: {}",
            best.evidence
        );
        // Nothing that a curve of twelve knots could follow.
        assert!((best.size / 8.7e3 - 1.0).abs() < 0.2, "{}", best.size);
        // A riser's reading that is off is nobody else's; and only its own are asked of the others.
        let riser = found.iter().any(|c| c.curve.place == Place::RiserReading);
        assert_eq!(riser, place == Place::RiserReading);
        assert!(place != Place::RiserReading || found.len() == 1);
        let tangent = Tangent::at(&record, &[], &[], Bend::Loose).unwrap();
        // Of what it takes out of the residuals it leaves no more than the prior of its share holds back: that share squared.
        let left: Vec<f64> = (tangent.off.iter().zip(&best.signature))
            .map(|(off, taken)| off - taken)
            .collect();
        let left = dot(&best.signature, &left);
        assert!(riser || (0.06..2.25).contains(&left), "{place:?}: {left}");
        // So it is by the way that corrections are asked for.
        let asked = correction(&record, &tangent, &[], &[], course).unwrap();
        assert_eq!(asked.evidence, best.evidence);
        let curve = &asked.curve;
        assert_eq!((curve.place, curve.quantity), course);
        assert_eq!((curve.from, curve.to), (0.0, 5400.0));
        // A knot for every row of the balance, and one more.
        assert_eq!(curve.knots.len(), record.blocks / BALANCE_BLOCKS + 1);
        assert_eq!(seen_curve(&Applied::from(curve)).as_ref(), Some(curve));
    }
}

#[test]
fn a_drift_that_knots_can_follow_is_drawn_with_its_sign() {
    let slow = |t: f64| 8e4 * (t / 1500.0).sin();
    for place in PLACED {
        let best = found(&off(place, slow)).remove(0);
        assert_eq!(best.curve.place, place);
        // The pressure between the two falls by what is lost.
        let sign = if place == Place::Suction { -1.0 } else { 1.0 };
        let centred = |knots: Vec<f64>| -> Vec<f64> {
            let mean = knots.iter().sum::<f64>() / knots.len() as f64;
            knots.iter().map(|v| v - mean).collect()
        };
        let drawn = centred(best.curve.knots);
        let count = drawn.len();
        let at = |k: usize| 5400.0 * k as f64 / (count - 1) as f64;
        let truth = centred((0..count).map(|k| sign * slow(at(k))).collect());
        let whole = dot(&truth, &truth);
        let alike = dot(&drawn, &truth) / (dot(&drawn, &drawn) * whole).sqrt();
        let share = dot(&drawn, &truth) / whole;
        assert!(alike > 0.98, "{place:?}: {drawn:?} {truth:?}");
        // The slowest of it may be wander.
        assert!((0.5..1.1).contains(&share), "{place:?}: {share}");
    }
}

#[test]
fn transmitters_that_go_together_are_parted_by_nothing() {
    assert!(found(&beside_riser()).is_empty());
    // Nor is what wanders within accuracy a fault, what the suction loses with the flow, or a difference of their spans.
    assert!(found(&off(Place::RiserReading, |t| 3e3 * (t / 1500.0).sin())).is_empty());
    let mut suction = beside_riser();
    for i in 0..suction.t_s.len() {
        suction.riser.as_mut().unwrap()[i] += 1e4 * (suction.flow[i] / FLOW_M3_S).powi(2);
    }
    assert!(found(&suction).is_empty());
    let mut span = beside_riser();
    for p in span.riser.as_mut().unwrap() {
        *p *= 1.01;
    }
    assert!(found(&span).is_empty());
    // And without a transmitter in the riser nothing is seen.
    let mut alone = off(Place::InletReading, saw);
    alone.riser = None;
    let tangent = Tangent::at(&alone, &[], &[], Bend::Loose).unwrap();
    assert!(correction(&alone, &tangent, &[], &[], (Place::Suction, Quantity::Time)).is_none());
    assert!(
        correction(
            &alone,
            &tangent,
            &[],
            &[],
            (Place::RiserReading, Quantity::Time)
        )
        .is_none()
    );
}

#[test]
fn a_reading_that_jumps_once_for_ten_minutes_is_no_fault_that_lasts() {
    let once = |t: f64| {
        if (2000.0..2580.0).contains(&t) {
            6e4
        } else {
            0.0
        }
    };
    let mut record = off(Place::RiserReading, once);
    assert!(found(&record).is_empty());
    record.without = vec![Step::Busiest];
    assert_eq!(found(&record).len(), 1);
}

#[test]
fn what_the_relations_bear_is_told_without_its_busiest_ten_minutes() {
    let mut record = off(Place::Suction, saw);
    let without = found(&record).remove(0).borne;
    record.without = vec![Step::Busiest];
    let whole = found(&record).remove(0).borne;
    // Ten minutes of ninety, in which it is largest.
    let owed = (whole - without) / whole;
    assert!((0.05..0.4).contains(&owed), "{owed}");
}

#[test]
fn a_riser_that_the_relations_could_not_tell_of_is_not_named_by_their_silence() {
    let mut record = off(Place::RiserReading, saw);
    assert_eq!(found(&record).len(), 1);
    // The mud moves so much that head and balance could not find the curve in the inlets; the two move with it alike.
    for (i, mud) in normals(12, record.t_s.len()).iter().enumerate() {
        let by = 2e5 * mud;
        record.inlet[i] += by;
        record.inlets.iter_mut().for_each(|p| p[i] += by);
        record.riser.as_mut().unwrap()[i] += by;
    }
    record.filled.inlet.clone_from(&record.inlet);
    assert!(found(&record).is_empty());
}

#[test]
fn of_a_curve_through_knots_and_one_that_is_seen_the_likelier_stands() {
    let found = found(&off(Place::Suction, saw)).remove(0);
    use Quantity::{ReturnFlow, Time};
    let one = |place: Place, quantity: Quantity, evidence: f64, seen: bool| Correction {
        evidence,
        curve: Curve {
            place,
            quantity,
            ..found.curve.clone()
        },
        seen: found.seen.clone().filter(|_| seen),
        ..found.clone()
    };
    let told = |drawn: f64, seen: f64| -> Vec<(Place, Quantity, f64, bool)> {
        let drawn = vec![
            one(Place::InletReading, ReturnFlow, 50.0, false),
            one(Place::InletReading, Time, drawn, false),
        ];
        let seen = vec![
            one(Place::InletReading, Time, seen, true),
            one(Place::Suction, Time, 30.0, true),
        ];
        (merged(drawn, seen).iter())
            .map(|c| {
                (
                    c.curve.place,
                    c.curve.quantity,
                    c.evidence,
                    c.seen.is_some(),
                )
            })
            .collect()
    };
    let others = [
        (Place::InletReading, ReturnFlow, 50.0, false),
        (Place::Suction, Time, 30.0, true),
    ];
    let drawn = (Place::InletReading, Time, 41.0, false);
    assert_eq!(told(41.0, 40.0), [others[0], drawn, others[1]]);
    let seen = (Place::InletReading, Time, 41.0, true);
    assert_eq!(told(40.0, 41.0), [others[0], seen, others[1]]);
}

/// A curve that corrects nothing, through so many values.
fn level(place: Place, quantity: Quantity, values: usize) -> Curve {
    Curve::new(place, quantity, (0.0, 5400.0), vec![0.0; values])
}

#[test]
fn a_curve_of_more_values_than_knots_is_one_that_is_seen() {
    let is_seen = |place: Place, quantity: Quantity, values: usize| {
        let curve = level(place, quantity, values);
        seen_curve(&Applied::from(&curve)).is_some()
    };
    let of_values = |values: usize| is_seen(Place::FirstInlet, Quantity::Time, values);
    assert!(!of_values(KNOTS) && !of_values(FINE_KNOTS) && of_values(FINE_KNOTS + 1));
    // No transmitters tell of the line's friction, and what they tell is along time.
    assert!(!is_seen(Place::Friction, Quantity::Time, 100));
    assert!(!is_seen(Place::FirstInlet, Quantity::InletPressure, 100));
}

#[test]
fn knots_are_means_of_what_lies_about_them() {
    let line: Vec<f64> = (0..1100).map(|i| f64::from(i) + 0.5).collect();
    let found: Vec<f64> = knots(&line, KNOTS).collect();
    assert_eq!(found.len(), KNOTS);
    for (k, knot) in found.iter().enumerate() {
        // At the ends of one side alone.
        let expected = match k {
            0 => 100.0 / 3.0,
            11 => 1100.0 - 100.0 / 3.0,
            _ => 100.0 * k as f64,
        };
        assert!((knot - expected).abs() < 0.1, "{k}: {knot}");
    }
    // A knot with nothing about it is 0.
    assert_eq!(knots(&[3.0], KNOTS).sum::<f64>(), 6.0);
}

#[test]
fn what_parts_two_transmitters_is_told_once() {
    for place in PLACED {
        let record = off(place, saw);
        let state = [Applied::from(&found(&record).remove(0).seen.unwrap())];
        let tangent = Tangent::at(&record, &state, &[], Bend::Loose).unwrap();
        assert!(all(&record, &tangent, &state, &[]).is_empty(), "{place:?}");
    }
    // What parts two others, or is drawn through knots, is another thing.
    let record = off(Place::FirstInlet, saw);
    let curve = |place, values| [Applied::from(&level(place, Quantity::Time, values))];
    for state in [
        curve(Place::FirstOutlet, 540),
        curve(Place::FirstInlet, KNOTS),
    ] {
        let tangent = Tangent::at(&record, &state, &[], Bend::Loose).unwrap();
        let found = all(&record, &tangent, &state, &[]);
        assert!(found.iter().any(|c| c.curve.place == Place::FirstInlet));
    }
}

/// Drilling with a suction that clogs and clears: it loses with the square of the flow, here of what is pumped in.
fn clogged() -> Record {
    let mut record = beside_riser();
    for i in 0..record.t_s.len() {
        let flow = record.filled.mud_pump[i] + 0.01;
        let lost = 5.0 * saw(record.t_s[i]) * (flow / FLOW_M3_S).powi(2);
        record.inlet[i] -= lost;
        record.inlets.iter_mut().for_each(|p| p[i] -= lost);
        let square = (record.speed[i] / SPEED_PCT).powi(2) + lost / 45e5;
        record.speed[i] = SPEED_PCT * square.sqrt();
    }
    record.filled.inlet.clone_from(&record.inlet);
    record.filled.speed.clone_from(&record.speed);
    record
}

#[test]
fn a_suction_that_clogs_leaves_nothing_over_for_the_area() {
    let record = clogged();
    let best = found(&record).remove(0);
    assert_eq!(best.curve.place, Place::Suction);
    let area = |state: &[Applied]| {
        let gate = Tangent::beside(&record, state, &[], Bend::Lean).unwrap();
        let all = contest(&record, &gate, state);
        let of = |c: &&Contender| c.id() == "annulus_area";
        all.iter().find(of).map_or(0.0, |c| c.evidence)
    };
    let (before, after) = (area(&[]), area(&[Applied::from(&best.seen.unwrap())]));
    assert!(before > 100.0 && after < 5.0, "{before} {after}");
}

#[test]
fn what_blocks_show_that_are_not_looked_at_changes_nothing() {
    let record = clogged();
    let excluded: Vec<bool> = (0..record.blocks)
        .map(|b| (200..300).contains(&b))
        .collect();
    let told = |record: &Record| {
        let tangent = Tangent::at(record, &[], &excluded, Bend::Loose).unwrap();
        let found = correction(
            record,
            &tangent,
            &[],
            &excluded,
            (Place::Suction, Quantity::Time),
        )
        .unwrap();
        (found.evidence, found.seen)
    };
    let mut other = record.clone();
    for (i, p) in other.riser.as_mut().unwrap().iter_mut().enumerate() {
        *p += if excluded[i / other.per_block] {
            1e3 * i as f64
        } else {
            0.0
        };
    }
    assert_eq!(told(&record), told(&other));
}
