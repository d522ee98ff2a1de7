//! Claims about the effects of a model to start from.

use crate::record::Record;
use crate::refine::{fitted_here, unshown};
use crate::relations::Applied;
use crate::tangent::{Bend, Tangent};
use crate::test_rig::{Hidden, INFLUX_S, drilled};
use dgd_effects::{Curve, KNOTS, Place, Quantity, find};
use dgd_lsq::dot;

fn hiding(influx_m3_s: f64) -> Record {
    drilled(Hidden {
        influx_m3_s,
        ..Hidden::default()
    })
}

fn influx(rate_m3_s: f64) -> [Applied; 1] {
    let (from, lasts, rise) = INFLUX_S;
    [Applied::new(
        find("influx").unwrap(),
        vec![rate_m3_s, from, lasts, rise],
    )]
}

/// By how much the misfit falls with an effect: half of the squares.
fn saved(record: &Record, start: &[Applied]) -> f64 {
    let without = Tangent::at(record, &[], &[], Bend::Stiff).unwrap();
    let with = without.refitted(record, start);
    0.5 * (dot(&without.off, &without.off) - dot(&with.off, &with.off))
}

#[test]
fn what_the_recording_shows_is_fitted_to_it() {
    let (record, start) = (hiding(3e-3), influx(2e-3));
    assert!(saved(&record, &start) > 50.0);
    let found = fitted_here(&record, &start, &[]);
    assert_eq!(found.len(), 1);
    let p = &found[0].as_ref().unwrap().parameters;
    assert!((p[0] / 3e-3 - 1.0).abs() < 0.1, "{p:?}");
}

/// Eight e-folds either way.
#[test]
fn what_it_hardly_shows_stays_as_it_was_given_and_what_it_speaks_against_goes() {
    for (hidden, given, saves, stays) in [
        (1.5e-4, 1.5e-4, 4.5..7.5, true),
        (0.0, 1e-4, -7.5..0.0, true),
        (0.0, 1e-3, -1e3..-8.0, false),
    ] {
        let (record, start) = (hiding(hidden), influx(given));
        let saved = saved(&record, &start);
        assert!(saves.contains(&saved), "{saved}");
        let found = fitted_here(&record, &start, &[]);
        let kept = found[0].as_ref().map(|a| &a.parameters);
        assert_eq!(kept, stays.then_some(&start[0].parameters));
    }
}

/// What goes does not take along what stays, whichever comes first.
#[test]
fn of_two_effects_the_one_that_is_there_stays() {
    let record = hiding(3e-3);
    let [there] = influx(3e-3);
    let absent = Applied::new(find("return_flow_gain").unwrap(), vec![0.05]);
    for start in [
        [there.clone(), absent.clone()],
        [absent.clone(), there.clone()],
    ] {
        let found = fitted_here(&record, &start, &[]);
        let ids: Vec<_> = found.iter().flatten().map(|a| a.id()).collect();
        assert_eq!(ids, ["influx"]);
        assert_eq!(found.len(), 2);
    }
}

/// The held-out windows have no say.
#[test]
fn what_lies_in_left_out_rows_stays_as_it_was_given() {
    let (record, start) = (hiding(3e-3), influx(2e-3));
    let (from, lasts, _) = INFLUX_S;
    let acts = |b: usize| {
        let at_s = record.setting.span_s.0 + b as f64 * record.block_s();
        at_s > from - 600.0 && at_s < from + lasts + 600.0
    };
    let excluded: Vec<bool> = (0..record.blocks).map(acts).collect();
    let found = fitted_here(&record, &start, &excluded);
    assert_eq!(found[0].as_ref().unwrap().parameters, start[0].parameters);
}

#[test]
fn a_curve_along_time_that_the_recording_does_not_show_goes_and_one_along_the_speed_stays() {
    let record = hiding(0.0);
    for (quantity, (from, to), stays) in [
        (Quantity::Time, record.setting.span_s, false),
        (Quantity::PumpSpeed, (40.0, 70.0), true),
    ] {
        let given = Applied::from(&Curve::new(
            Place::Friction,
            quantity,
            (from, to),
            (0..KNOTS).map(|k| 2e3 * (k % 2) as f64).collect(),
        ));
        let found = fitted_here(&record, std::slice::from_ref(&given), &[]);
        assert_eq!(found[0].is_some(), stays, "{quantity:?}");
        // On the training rows it adds nothing then.
        let flat = unshown(given).curve().unwrap();
        assert!(flat.is_flat() && flat.knots.len() == KNOTS);
    }
    let [gain] = [Applied::new(find("return_flow_gain").unwrap(), vec![0.05])];
    assert_eq!(unshown(gain).parameters, [0.05]);
}
