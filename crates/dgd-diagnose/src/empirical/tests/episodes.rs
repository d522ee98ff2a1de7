//! Claims about what sets in, or lasts for a while: found with its times and in its place, and not taken for what has a course of its own.

use super::{LENGTH_S, loose, made, off_by, size_in, waving};
use crate::empirical::drawn::range;
use crate::empirical::episodic::may_have_frozen;
use crate::empirical::timed::leaves_no_more;
use crate::empirical::{
    DRAWN, again, anew, correction, corrections, episode_like, episodic, instead_of,
};
use crate::record::Record;
use crate::relations::Applied;
use crate::tangent::{Bend, Tangent};
use crate::test_rig::{BLOCK_S, one};
use dgd_effects::{Curve, KNOTS, Place, Quantity};

/// Sets in, between knots of a curve along time, and goes on.
const ON: (f64, f64) = (2630.0, LENGTH_S);
/// Lasts for a while.
const WHILE: (f64, f64) = (1610.0, 2830.0);

/// One place is off by its size between two times.
fn off_between(place: Place, (from_s, to_s): (f64, f64)) -> Record {
    off_by(place, size_in(place), |record, i| {
        let t = record.t_s[i];
        if t >= from_s && t < to_s { 1.0 } else { 0.0 }
    })
}

/// A rig whose every reading moves from sample to sample.
fn alive() -> Record {
    let mut record = off_by(Place::Balance, 0.0, |_, _| 0.0);
    let stir = |reading: &mut Vec<f64>, size: f64| {
        for (i, v) in reading.iter_mut().enumerate() {
            *v += size * (2.4 * i as f64).sin();
        }
    };
    let flows = [
        &mut record.mud_pump,
        &mut record.booster,
        &mut record.topfill,
        &mut record.flow,
    ];
    flows.into_iter().for_each(|flow| stir(flow, 1e-5));
    record.inlets.iter_mut().for_each(|p| stir(p, 50.0));
    record
}

#[test]
fn a_reading_may_have_frozen_that_stands_for_half_an_episode_and_then_moves() {
    let (from, to) = WHILE;
    let half = from + 0.5 * (to - from);
    let frozen = |from_s: f64, to_s: f64| {
        let mut record = alive();
        let at = |t_s: f64| record.t_s.partition_point(|t| *t < t_s);
        let (first, end) = (at(from_s), at(to_s));
        record.booster[first..end].fill(1e-3);
        may_have_frozen(&record, WHILE)
    };
    assert!(!may_have_frozen(&alive(), WHILE));
    assert!(frozen(from, half + 20.0) && !frozen(from, half - 20.0));
    // It thaws as the episode ends, or stands for another reason.
    assert!(frozen(half, to + 60.0) && !frozen(half, to + 200.0));
    assert!(!frozen(half, LENGTH_S));
}

#[test]
fn a_missing_sample_neither_moves_a_reading_nor_lets_it_stand() {
    let (from, to) = WHILE;
    let booster = |until_s: f64, missing: &dyn Fn(usize) -> bool| {
        let mut record = alive();
        let end = record.t_s.partition_point(|t| *t < until_s);
        record.booster[..end].fill(1e-3);
        for (i, value) in record.booster.iter_mut().enumerate() {
            if missing(i) {
                *value = f64::NAN;
            }
        }
        may_have_frozen(&record, WHILE)
    };
    let near_end = alive().t_s.partition_point(|t| *t < to - 60.0);
    // One that never moves, but for a gap.
    assert!(!booster(LENGTH_S + 1.0, &|i| i == near_end));
    // One that is frozen, with gaps.
    assert!(booster(0.5 * (from + to) + 300.0, &|i| i % 7 == 0));
}

/// A course along time that explains next to nothing.
fn asked(place: Place) -> crate::empirical::Correction {
    made(place, Quantity::Time, &[0.0; KNOTS], 5.0)
}

#[test]
fn what_sets_in_and_what_passes_is_found_with_its_times_and_in_its_place() {
    // The head of this rig is off by running slower, which at one speed is its curve.
    for place in DRAWN.into_iter().filter(|p| *p != Place::Head) {
        for times in [ON, WHILE] {
            if (place, times) == (Place::InletReading, WHILE) {
                // In an hour and a half twenty minutes of head are too little to tell by.
                continue;
            }
            let record = off_between(place, times);
            let found = instead_of(&record, &[], &asked(place));
            let found = found.unwrap_or_else(|| panic!("{place:?} {times:?}"));
            let curve = &found.curve;
            let said = format!("{place:?} {times:?}: {curve:?}");
            assert_eq!(
                (curve.place, curve.quantity),
                (place, Quantity::Episode),
                "{said}"
            );
            let (from_s, to_s) = curve.episode_s((0.0, LENGTH_S)).unwrap();
            assert!((from_s - times.0).abs() <= BLOCK_S, "{said}");
            assert!((to_s - times.1).abs() <= BLOCK_S, "{said}");
            assert_eq!(curve.goes_on(), times == ON, "{said}");
            let size = curve.at(from_s) / size_in(place);
            assert!((size - 1.0).abs() < 0.15, "{size} {said}");
            // Made anew, as a model holds it, it keeps its times.
            let again = again(&record, &[], curve, &[]).unwrap();
            assert_eq!(again.curve.timed_s(), curve.timed_s(), "{said}");
            // And nothing of it is left beside it.
            let state = [Applied::from(curve)];
            let left = corrections(&record, &state, false).remove(0).evidence;
            assert!(left < 0.05 * found.evidence + 5.0, "{left} {said}");
        }
    }
}

#[test]
fn what_ends_within_ten_minutes_or_has_a_course_of_its_own_is_none() {
    let episode = |record: &Record, place: Place| {
        let best = corrections(record, &[], false)
            .into_iter()
            .find(|c| c.curve.place == place);
        let found = instead_of(record, &[], &best.unwrap())?;
        (found.curve.quantity == Quantity::Episode).then_some(found.curve)
    };
    for place in [Place::Friction, Place::Head, Place::Balance] {
        let short = off_between(place, (2630.0, 3130.0));
        assert_eq!(episode(&short, place), None, "{place:?}");
        assert_eq!(episode(&waving(place), place), None, "{place:?}");
        let ramp = off_by(place, size_in(place), |record, i| record.t_s[i] / LENGTH_S);
        assert_eq!(episode(&ramp, place), None, "{place:?}");
    }
}

#[test]
fn a_curve_that_leaves_less_is_told_from_an_episode() {
    // Friction goes with the level, which is high for a while: an episode explains some of that.
    let place = Place::Friction;
    let record = off_by(place, 2.0 * size_in(place), |record, i| {
        let (from, to) = range(record, Quantity::InletPressure).unwrap();
        f64::from(u8::from(record.filled.inlet[i] > from + 0.7 * (to - from)))
    });
    let along = (place, Quantity::InletPressure);
    let best = correction(&record, &loose(&record), &[], &[], along).unwrap();
    assert!(best.evidence > 100.0, "{}", best.evidence);
    let tangent = loose(&record);
    let episode = episodic::in_place(&record, &tangent, &[], place).unwrap();
    assert!(!leaves_no_more(&record, &[], &best, &episode));
    // Where it is one, a course along time leaves more.
    let record = off_between(place, WHILE);
    let tangent = loose(&record);
    let course = correction(&record, &tangent, &[], &[], (place, Quantity::Time)).unwrap();
    let episode = episodic::in_place(&record, &tangent, &[], place).unwrap();
    assert!(leaves_no_more(&record, &[], &course, &episode));
}

#[test]
fn its_times_are_told_by_what_is_not_held_out_alone() {
    let held_out = |t: f64| (3600.0..4800.0).contains(&t);
    // In the held-out window it is not there.
    let record = off_by(Place::Friction, size_in(Place::Friction), |record, i| {
        let t = record.t_s[i];
        if t >= ON.0 && !held_out(t) { 1.0 } else { 0.0 }
    });
    let excluded: Vec<bool> = (0..record.blocks)
        .map(|b| held_out((b as f64 + 0.5) * BLOCK_S))
        .collect();
    let tangent = Tangent::at(&record, &[], &excluded, Bend::Loose).unwrap();
    let made_anew = |held: &Curve| {
        let found = anew(&record, &tangent, &[], &excluded, held);
        found.map(|found| found.curve)
    };
    let found = made_anew(&Curve::episode(Place::Friction, (2900.0, None), 0.0)).unwrap();
    assert!(
        (found.from - ON.0).abs() <= BLOCK_S && found.goes_on(),
        "{found:?}"
    );
    // Where they tell other times than were found, it is a course along time, as what is not timed is.
    let other = (1000.0, Some(3000.0));
    let other = made_anew(&Curve::episode(Place::Friction, other, 0.0)).unwrap();
    assert_eq!(other.quantity, Quantity::Time);
    assert_eq!(made_anew(&other), Some(other));
}

#[test]
fn an_episode_takes_the_place_of_an_effect_only_if_it_leaves_less() {
    let heavier = one("mud_density_change", &[20.0, ON.0, 0.1, 0.3]);
    let shifted = off_between(Place::OutletReading, ON);
    let (found, _) = episode_like(&shifted, &[], std::slice::from_ref(&heavier), None).unwrap();
    assert_eq!(found.curve.place, Place::OutletReading);
    // Not beside a curve that leaves as little: itself, with the freedom of a curve.
    let mut rival = found.clone();
    rival.freedom = 0.0;
    assert!(episode_like(&shifted, &[], std::slice::from_ref(&heavier), Some(&rival)).is_none());
    rival.curve.knots.fill(0.0);
    assert!(episode_like(&shifted, &[], std::slice::from_ref(&heavier), Some(&rival)).is_some());
    // Nor where the effect is what it is told as.
    let lasting = Applied::from(&found.curve);
    assert!(episode_like(&shifted, &[], std::slice::from_ref(&lasting), None).is_none());
}

#[test]
fn a_meter_that_jumps_to_a_part_of_the_flow_is_found_by_curves_that_are_fitted_again() {
    // What flows over what is read: half of the meters in parallel are lost, or counted twice.
    for more in [1.0, 0.5, -0.35] {
        let record = off_by(Place::MeterFactor, more, |record, i| {
            f64::from(u8::from(record.t_s[i] >= ON.0))
        });
        let found = instead_of(&record, &[], &asked(Place::MeterFactor)).unwrap();
        let curve = &found.curve;
        assert_eq!(curve.place, Place::MeterFactor);
        assert!(
            (curve.from - ON.0).abs() <= BLOCK_S && curve.goes_on(),
            "{curve:?}"
        );
        let size = (1.0 + curve.at(curve.from)) / (1.0 + more);
        assert!((size - 1.0).abs() < 0.07, "{more} {size}");
    }
}

#[test]
fn what_passes_competes_from_the_start_where_rows_look_like_it() {
    let beside = |record: &Record| {
        let gate = Tangent::at(record, &[], &[], Bend::Lean).unwrap();
        let all = corrections(record, &[], episodic::episode_may_be(record, &gate));
        (all.into_iter()).find(|c| c.curve.quantity == Quantity::Episode)
    };
    for place in [Place::Friction, Place::Balance, Place::MeterFactor] {
        let record = off_between(place, WHILE);
        let found = beside(&record).unwrap_or_else(|| panic!("{place:?}"));
        assert_eq!(found.curve.place, place);
        let (from_s, to_s) = found.curve.episode_s((0.0, LENGTH_S)).unwrap();
        assert!((from_s - WHILE.0).abs() <= BLOCK_S && (to_s - WHILE.1).abs() <= BLOCK_S);
        // Ten minutes alone are none.
        assert!(beside(&off_between(place, (2630.0, 3130.0))).is_none());
        // Nor is what has a course of its own.
        assert!(beside(&waving(place)).is_none(), "{place:?}");
    }
    // Of sound drilling no row looks like it, so that none is sought.
    let sound = off_by(Place::Balance, 0.0, |_, _| 0.0);
    let gate = Tangent::at(&sound, &[], &[], Bend::Lean).unwrap();
    assert!(!episodic::episode_may_be(&sound, &gate));
}

#[test]
fn of_days_an_episode_of_hours_is_asked_no_more_than_of_hours() {
    let record = off_between(Place::Friction, WHILE);
    let weighed = |hours: f64| {
        let mut longer = record.clone();
        let (from, _) = record.setting.span_s;
        longer.setting.span_s = (from, from + hours * 3600.0);
        let found = episodic::between(&longer, &loose(&record), &[], Place::Friction, WHILE);
        let found = found.unwrap();
        (found.times, found.size)
    };
    // What it is compared with are the eight hours about it, however many days there are.
    let (times, size) = weighed(8.0);
    assert_eq!(times, 1.0);
    assert_eq!(weighed(72.0), (times, size));
    // What goes on for days is asked more.
    let mut days = record.clone();
    days.setting.span_s.1 = 72.0 * 3600.0;
    let on = (WHILE.0, f64::INFINITY);
    let on = episodic::between(&days, &loose(&record), &[], Place::Friction, on).unwrap();
    assert!(on.times > 8.0, "{}", on.times);
}
