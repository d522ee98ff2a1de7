//! Claims about what another line's flow adds to a reading, and about what is drawn where the relations' own curves are stiff.

use super::{loose, off_by};
use crate::empirical::crosstalk::crosstalk;
use crate::empirical::drawn::{drawn, least, range};
use crate::empirical::{
    Correction, Course, LEAST_AT_WILL, again, at_will, correction, corrections, hurdle, plausible,
    rival_hurdle,
};
use crate::record::Record;
use crate::tangent::{Bend, Tangent};
use crate::test_rig::{Hidden, drilled, normals};
use dgd_effects::{Place, Quantity};
use dgd_lsq::dot;

const ALONG: (Place, Quantity) = (Place::OutletReading, Quantity::BoosterFlow);
const ALONG_LEVEL: (Place, Quantity) = (Place::Head, Quantity::InletPressure);

/// Flow of a booster that runs, m³/s.
const RUNS_M3_S: f64 = 0.012;

/// Drilling in which the booster runs now and then, for which the mud pump gives less; the outlets read `pa` more while it does.
fn boosted(pa: f64) -> Record {
    let runs = |t_s: f64| (1000.0..1900.0).contains(&t_s) || t_s > 3600.0;
    let mut record = off_by(Place::OutletReading, pa, |record, i| {
        f64::from(u8::from(runs(record.t_s[i])))
    });
    for i in 0..record.t_s.len() {
        let flow = if runs(record.t_s[i]) { RUNS_M3_S } else { 0.0 };
        // It pumped 0.01 all the time.
        record.mud_pump[i] += 0.01 - flow;
        record.booster[i] = flow;
    }
    record.filled.mud_pump.clone_from(&record.mud_pump);
    record.filled.booster.clone_from(&record.booster);
    record
}

#[test]
fn what_the_booster_adds_to_a_reading_is_a_straight_line_through_nought() {
    for pa in [2e4, -2e4] {
        let record = boosted(pa);
        let found = correction(&record, &loose(&record), &[], &[], ALONG).unwrap();
        assert!(found.evidence > hurdle(&found), "{}", found.evidence);
        assert!(plausible(&found));
        assert!(found.freedom <= 1.0);
        let curve = &found.curve;
        assert_eq!(curve.at(0.0), 0.0);
        let added = curve.at(RUNS_M3_S) / pa;
        assert!((added - 1.0).abs() < 0.1, "{added}");
        let halfway = curve.at(0.5 * RUNS_M3_S) / curve.at(RUNS_M3_S);
        assert!((halfway - 0.5).abs() < 1e-9);
        // It is among all that are weighed, and a model that holds it has it again.
        let all = corrections(&record, &[], false);
        let it = all.iter().find(|c| c.curve.is_alike(curve)).unwrap();
        assert_eq!(it.curve, *curve);
        assert_eq!(again(&record, &[], curve, &[]).unwrap().curve, *curve);
    }
}

#[test]
fn a_booster_adds_nothing_to_sound_readings_and_nothing_is_told_of_one_that_stays_as_it_is() {
    let record = boosted(0.0);
    let found = correction(&record, &loose(&record), &[], &[], ALONG).unwrap();
    assert!(found.evidence < 0.0, "{}", found.evidence);
    // It pumps the same all the time, or nearly.
    let mut steady = drilled(Hidden::default());
    assert!(correction(&steady, &loose(&steady), &[], &[], ALONG).is_none());
    let noise = normals(9, steady.t_s.len());
    let wavering = |noise: &f64| 0.01 + 5e-4 * noise;
    steady.filled.booster = noise.iter().map(wavering).collect();
    assert!(correction(&steady, &loose(&steady), &[], &[], ALONG).is_none());
}

#[test]
fn what_it_takes_out_of_the_residuals_is_what_it_explains() {
    let record = boosted(2e4);
    let stiff = Tangent::beside(&record, &[], &[], Bend::Lean).unwrap();
    let found = crosstalk(&record, &stiff, &[]).unwrap();
    let rest: Vec<f64> = (stiff.off.iter().zip(&found.signature))
        .map(|(off, signature)| off - signature)
        .collect();
    let explained = 0.5 * (dot(&stiff.off, &stiff.off) - dot(&rest, &rest));
    // The width beforehand costs some e-folds.
    let paid = explained - found.evidence;
    assert!((0.0..10.0).contains(&paid), "{explained} {paid}");
    assert!((0.9..1.0).contains(&found.freedom), "{}", found.freedom);
}

#[test]
fn of_the_booster_in_an_outlet_reading_half_as_much_is_more_than_accuracy() {
    let of = |(place, quantity): (Place, Quantity)| {
        let course = Course::from((place, quantity));
        least(course) / place.least()
    };
    assert_eq!(of(ALONG), 0.5);
    for (place, quantity) in [
        (Place::OutletReading, Quantity::MudPumpFlow),
        (Place::Friction, Quantity::BoosterFlow),
        (Place::Head, Quantity::Time),
    ] {
        assert_eq!(of((place, quantity)), 1.0);
    }
}

#[test]
fn a_form_needs_less_to_be_held_against_an_effect_than_knots() {
    let record = boosted(2e4);
    let all = corrections(&record, &[], false);
    assert!(
        all.iter()
            .any(|c| (c.curve.place, c.curve.quantity) == ALONG)
    );
    for c in all {
        let form = (c.curve.place, c.curve.quantity) == ALONG;
        assert_eq!(rival_hurdle(&c) < hurdle(&c), form, "{:?}", c.curve);
        assert!(rival_hurdle(&c) > 0.5 * hurdle(&c));
    }
}

/// A head that is off by so much along a wave of one and a half lengths of its inlet pressure's range.
fn rippled(pa: f64) -> Record {
    off_by(Place::Head, pa, |record, i| {
        let (from, to) = range(record, Quantity::InletPressure).unwrap();
        let wave = 1.5 * std::f64::consts::TAU * (record.filled.inlet[i] - from) / (to - from);
        wave.sin()
    })
}

/// The head along the inlet pressure, drawn where the curves bend no more than beside effects.
fn on_stiff(record: &Record, loose: &Tangent) -> Correction {
    let stiff = loose.bending(record, Bend::Lean);
    drawn(record, &stiff, &[], None, ALONG_LEVEL.into()).unwrap()
}

#[test]
fn a_head_that_depends_on_the_level_shows_more_where_its_own_curve_is_stiff() {
    let record = rippled(2e4);
    let tangent = loose(&record);
    let stiff = on_stiff(&record, &tangent);
    let loose = at_will(&record, &tangent, &[], &stiff).unwrap();
    assert!(
        stiff.evidence > 1.2 * loose.evidence && loose.evidence > 0.0,
        "{} {}",
        stiff.evidence,
        loose.evidence
    );
    // What is drawn elsewhere bends at will.
    let along = (Place::Head, Quantity::SinceStart);
    let one = correction(&record, &tangent, &[], &[], along).unwrap();
    assert!(at_will(&record, &tangent, &[], &one).is_none());
}

#[test]
fn a_law_of_the_level_that_is_left_where_curves_bend_at_will_keeps_its_evidence() {
    let record = rippled(5e4);
    let loose = loose(&record);
    let found = correction(&record, &loose, &[], &[], ALONG_LEVEL).unwrap();
    let stiff = on_stiff(&record, &loose);
    assert!(found.evidence > 100.0, "{}", found.evidence);
    assert_eq!([found.evidence, found.borne], [stiff.evidence, stiff.borne]);
}

#[test]
fn a_hump_of_the_heads_own_curve_is_no_law_of_the_level_that_goes_with_the_flow() {
    for (pa, waves) in [(2e4, 1.0), (2e4, 1.5), (5e4, 0.75), (5e4, 1.0), (5e4, 1.5)] {
        let record = off_by(Place::Head, pa, |record, i| {
            let (from, to) = range(record, Quantity::ReturnFlow).unwrap();
            let share = (record.filled.flow[i] - from) / (to - from);
            (waves * std::f64::consts::TAU * share).sin()
        });
        let loose = loose(&record);
        let found = correction(&record, &loose, &[], &[], ALONG_LEVEL).unwrap();
        let stiff = on_stiff(&record, &loose);
        // Whatever it is owed to.
        let evidence = [stiff.evidence + stiff.owed, found.evidence];
        assert!(
            evidence[0] > 100.0 && evidence[1] < LEAST_AT_WILL,
            "{evidence:?}"
        );
        assert!(found.borne <= found.evidence);
    }
}
