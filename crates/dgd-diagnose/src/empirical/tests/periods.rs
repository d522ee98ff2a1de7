//! Claims about what swings with a period: found with it, in its place, and nowhere else.

use super::{LENGTH_S, made, off_by, size_in};
use crate::empirical::{Correction, Course, again, anew, corrections, hurdle, instead_of, without};
use crate::record::Record;
use crate::relations::Applied;
use crate::relations::FINE_KNOTS;
use crate::tangent::{Bend, Tangent};
use crate::test_rig::BLOCK_S;
use dgd_effects::{Curve, KNOTS, Place, Quantity, Relation};
use std::f64::consts::TAU;

/// Seven and a half times in the recording; between knots of a curve along time.
const PERIOD_S: f64 = 720.0;

fn swinging(place: Place, period_s: f64) -> Record {
    off_by(place, size_in(place), |record, i| {
        (TAU * record.t_s[i] / period_s).sin()
    })
}

#[test]
fn what_swings_is_found_with_its_period_and_in_its_place() {
    for place in [
        Place::Friction,
        Place::Balance,
        Place::InletReading,
        Place::OutletReading,
    ] {
        let record = swinging(place, PERIOD_S);
        let best = corrections(&record, &[], false).remove(0);
        let found = instead_of(&record, &[], &best).unwrap();
        let curve = &found.curve;
        assert_eq!((curve.place, curve.quantity), (place, Quantity::Period));
        assert!(found.evidence > best.evidence + 10.0, "{place:?}");
        assert_eq!(curve.knots.len(), FINE_KNOTS);
        assert!(
            (curve.knots[0] - curve.knots[FINE_KNOTS - 1]).abs() < 1e-3 * size_in(place),
            "it ends where it begins"
        );
        let period_s = curve.to - curve.from;
        assert!((period_s - PERIOD_S).abs() < 8.0, "{place:?}: {period_s}");
        // Knots go round the period once, with the size and the phase of what is hidden.
        for (k, knot) in curve.knots.iter().enumerate() {
            let truth = size_in(place) * (TAU * k as f64 / (FINE_KNOTS - 1) as f64).sin();
            assert!(
                (knot - truth).abs() < 0.3 * size_in(place),
                "{place:?} {k}: {knot} of {truth}"
            );
        }
        // Made anew, as a model holds it, it keeps its period.
        let again = again(&record, &[], curve, &[]).unwrap();
        assert_eq!(again.curve.period_s(), curve.period_s());
        assert_eq!(again.curve.place, place);
        // But for the price of its choice, among frequencies of which a third can be parted.
        let choice = (LENGTH_S / 600.0 - 2.5).ln();
        let paid = again.evidence - found.evidence;
        assert!((paid - choice).abs() < 0.1, "{paid} {choice}");
        assert!((found.choice - choice).abs() < 0.1, "{}", found.choice);
        assert_eq!(Course::from(curve).timed_s, Some((curve.from, curve.to)));
    }
}

#[test]
fn what_swings_pays_for_its_period_without_stops_too() {
    let record = swinging(Place::Friction, PERIOD_S);
    let best = corrections(&record, &[], false).remove(0);
    let mut found = instead_of(&record, &[], &best).unwrap();
    // Doubtful, so that it is weighed again without some blocks.
    found.evidence = hurdle(&found);
    let stops: Vec<bool> = (0..record.blocks).map(|block| block < 5).collect();
    let alone = |c: &Correction| {
        let found = std::slice::from_ref(c);
        let [(0, alone)] = without(&record, &stops, &[], found, Relation::ReturnLineFriction)[..]
        else {
            panic!("it is not weighed again");
        };
        alone
    };
    let unpaid = Correction {
        choice: 0.0,
        owed: 0.0,
        ..found.clone()
    };
    let paid = alone(&unpaid) - alone(&found);
    assert!(
        found.choice > 1.0 && (paid - found.choice).abs() < 1e-9,
        "{paid}"
    );
}

#[test]
fn what_does_not_come_again_has_no_period() {
    // Once and a half in the recording, a step, and nothing.
    for curve in [
        |t: f64| (1.5 * TAU * t / LENGTH_S).sin(),
        |t: f64| if t > 2700.0 { 1.0 } else { 0.0 },
        |_: f64| 0.0,
    ] {
        let record = off_by(Place::Friction, size_in(Place::Friction), |record, i| {
            curve(record.t_s[i])
        });
        let best = corrections(&record, &[], false).remove(0);
        let found = instead_of(&record, &[], &best);
        assert!(found.is_none_or(|c| c.curve.quantity != Quantity::Period));
    }
}

#[test]
fn a_period_must_be_better_than_what_needs_none_and_not_be_seen() {
    let record = swinging(Place::Friction, PERIOD_S);
    let found = instead_of(
        &record,
        &[],
        &made(Place::Friction, Quantity::Time, &[0.0; KNOTS], 20.0),
    )
    .unwrap();
    let other = |evidence: f64| {
        instead_of(
            &record,
            &[],
            &made(Place::Friction, Quantity::Time, &[0.0; KNOTS], evidence),
        )
    };
    assert!(other(found.evidence - 10.1).is_some() && other(found.evidence - 9.9).is_none());
    let mut seen = made(Place::Friction, Quantity::Time, &[0.0; KNOTS], 20.0);
    seen.seen = Some(seen.curve.clone());
    assert!(instead_of(&record, &[], &seen).is_none());
}

#[test]
fn what_is_held_is_left_out() {
    let record = swinging(Place::Friction, PERIOD_S);
    let best = corrections(&record, &[], false).remove(0);
    let found = instead_of(&record, &[], &best).unwrap();
    let state = [Applied::from(&found.curve)];
    let left = corrections(&record, &state, false).remove(0);
    assert!(left.evidence < 0.02 * best.evidence, "{}", left.evidence);
    assert!(instead_of(&record, &state, &left).is_none());
}

#[test]
fn the_period_is_told_by_what_is_not_held_out_alone() {
    let held_out = |t: f64| (1800.0..3600.0).contains(&t);
    let record = off_by(Place::Friction, size_in(Place::Friction), |record, i| {
        let t = record.t_s[i];
        let period_s = if held_out(t) { 1100.0 } else { PERIOD_S };
        (TAU * t / period_s).sin()
    });
    let excluded: Vec<bool> = (0..record.blocks)
        .map(|b| held_out((b as f64 + 0.5) * BLOCK_S))
        .collect();
    let tangent = Tangent::at(&record, &[], &excluded, Bend::Loose).unwrap();
    let swings = Curve::new(Place::Friction, Quantity::Period, (0.0, 1.0), Vec::new());
    let found = anew(&record, &tangent, &[], &excluded, &swings).unwrap();
    let period_s = found.curve.to - found.curve.from;
    assert!((period_s - PERIOD_S).abs() < 8.0, "{period_s}");
}
