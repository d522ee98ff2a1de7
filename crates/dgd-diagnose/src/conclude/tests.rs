//! Claims about the curves that are run and about what is more likely there than not.
#![allow(clippy::unwrap_used, reason = "a test may fail by panic")]

mod answer;

use super::models::runnable;
use super::start::refitted;
use crate::record::Record;
use crate::relations::Applied;
use crate::selection::Named;
use crate::tangent::{Bend, Tangent};
use crate::test_rig::{Hidden, drilled, normals};
use dgd_effects::{Curves, find, unknown};

#[test]
fn a_cause_is_as_likely_there_as_it_and_what_cannot_be_told_from_it() {
    let one = Named {
        applied: Applied::new(find("influx").unwrap(), vec![1e-3, 0.0, 600.0, 0.15]),
        evidence: 20.0,
        bent: 0.0,
        hurdle: 10.0,
        probability: 0.3,
        alternatives: vec![("inflow_gain".to_owned(), 0.2), ("unknown".to_owned(), 0.1)],
        held: None,
        most: None,
    };
    assert!((one.likely() - 0.6).abs() < 1e-12);
}

/// Drilling with a stop of fifty minutes, in which the column is not as heavy as that of the model.
fn stopped(lighter_pa: f64) -> Record {
    let mut record = drilled(Hidden::default());
    let column = record.column_pa();
    let noise = normals(9, record.t_s.len());
    for i in 600..2100 {
        for series in [
            &mut record.mud_pump,
            &mut record.filled.mud_pump,
            &mut record.booster,
            &mut record.filled.booster,
            &mut record.flow,
            &mut record.filled.flow,
            &mut record.speed,
            &mut record.filled.speed,
        ] {
            series[i] = 0.0;
        }
        record.filled.pumping[i] = false;
        record.outlet[i] = column - lighter_pa + 1500.0 * noise[i];
        record.filled.outlet[i] = record.outlet[i];
    }
    record.outlets = vec![record.outlet.clone()];
    record
}

fn curves(record: &Record, excluded: &[bool]) -> Curves {
    let fit = Tangent::at(record, &[], excluded, Bend::Stiff).unwrap();
    fit.curves
}

/// The friction's intercept is pulled to 8 kPa and to 17: within three times its prior, and beyond.
#[test]
fn stops_count_unless_the_column_at_rest_is_not_that_of_the_model() {
    // Two blocks after the mud has come to rest, to the last but one.
    let stops: Vec<bool> = (0..540).map(|b| (122..419).contains(&b)).collect();
    let none = vec![false; 540];
    let early: Vec<bool> = (0..540).map(|b| b < 60).collect();
    let both: Vec<bool> = stops.iter().zip(&early).map(|(a, b)| *a || *b).collect();
    for (lighter_pa, counts) in [(0.0, true), (2e5, true), (4e5, false)] {
        let record = stopped(lighter_pa);
        for (excluded, without_stops) in [(&none, &stops), (&early, &both)] {
            let whole = curves(&record, excluded);
            let found = runnable(&record, &[], excluded).unwrap().curves;
            if counts {
                assert_eq!(found, whole);
            } else {
                assert_eq!(found, curves(&record, without_stops));
            }
            assert_ne!(whole, curves(&record, without_stops));
        }
    }
}

#[test]
fn an_effect_is_as_strong_here_from_half_its_strength_to_half_as_strong_again() {
    let gain = |strength| Applied::new(find("inflow_gain").unwrap(), vec![strength]);
    for (given, here, passed) in [
        (0.5, 0.75, true),
        (0.5, 0.25, true),
        (-0.5, -0.75, true),
        (0.5, 0.76, false),
        (0.5, 0.24, false),
        (-0.5, -0.24, false),
        (0.5, -0.5, false),
    ] {
        // A correction has no strength to compare.
        let knots =
            |value| Applied::new(unknown(), vec![value; unknown().about().parameters.len()]);
        let check = refitted(
            &[knots(1.0), gain(given)],
            &[Some(knots(9.0)), Some(gain(here))],
            (0.0, 5400.0),
        )
        .unwrap();
        assert_eq!(check.passed, passed, "{}", check.detail);
        let told = format!("unknown, a correction; inflow_gain: gain {given:.3e}, here {here:.3e}");
        assert_eq!(check.detail, told);
    }
    assert_eq!(refitted(&[], &[], (0.0, 5400.0)), None);
}

/// A recording of another time can neither confirm nor deny what has passed, or is to come.
#[test]
fn an_effect_that_acts_outside_the_recording_is_not_confirmed() {
    let influx = |from: f64| Applied::new(find("influx").unwrap(), vec![3e-3, from, 600.0, 0.15]);
    let leak = |from: f64| Applied::new(find("line_leak").unwrap(), vec![1e-3, from]);
    for (one, confirmed) in [
        (influx(2000.0), true),
        (influx(-500.0), true),
        (influx(-600.0), false),
        (influx(5400.0), false),
        (leak(-1e5), true),
        (leak(5400.0), false),
    ] {
        let here = [Some(one.clone())];
        let check = refitted(std::slice::from_ref(&one), &here, (0.0, 5400.0)).unwrap();
        assert_eq!(check.passed, confirmed, "{}", check.detail);
        let outside = check.detail.contains("lie outside this recording");
        assert_eq!(outside, !confirmed, "{}", check.detail);
    }
}
