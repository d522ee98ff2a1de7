//! Claims about the curves that are run and about what is more likely there than not.
#![allow(clippy::unwrap_used, reason = "a test may fail by panic")]

mod answer;

use super::against::{doubt_what_is_left, unless_outweighed};
use super::models::runnable;
use super::start::refitted;
use super::{accepted, believe, beside_unnamed, name_transmitter};
use crate::ablation::Step;
use crate::diagnosis::{DiagnoseError, Finding, Options, ParameterEstimate, Trace};
use crate::record::Record;
use crate::relations::Applied;
use crate::select::Sought;
use crate::selection::Named;
use crate::tangent::{Bend, Tangent};
use crate::test_rig::{Hidden, drilled, found, named, normals, recorded, steady};
use dgd_effects::{Curves, Relation, find, unknown};
use dgd_recording::{ChannelSource, TimeSource};
use dgd_units::Unit;

#[test]
fn a_cause_is_as_likely_there_as_it_and_what_cannot_be_told_from_it() {
    let one = influx(0.3, &[("inflow_gain", 0.2), ("unknown", 0.1)]);
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

/// The friction's intercept is pulled to 5 kPa and to 11: within three times its prior, and beyond.
#[test]
fn stops_count_unless_the_column_at_rest_is_not_that_of_the_model() {
    // Two blocks after the mud has come to rest, to the last but one.
    let stops: Vec<bool> = (0..540).map(|b| (122..419).contains(&b)).collect();
    let none = vec![false; 540];
    let early: Vec<bool> = (0..540).map(|b| b < 60).collect();
    let both: Vec<bool> = stops.iter().zip(&early).map(|(a, b)| *a || *b).collect();
    for (lighter_pa, counts) in [(0.0, true), (2e5, true), (5e5, false)] {
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
        let gains = format!("inflow_gain: gain {given:.3}, here {here:.3}");
        let told = if passed {
            format!("unknown, a correction; {gains}")
        } else {
            format!("{gains}; as strong: unknown, a correction")
        };
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

fn influx(probability: f64, alternatives: &[(&str, f64)]) -> Named {
    Named {
        probability,
        alternatives: (alternatives.iter())
            .map(|(id, p)| ((*id).to_owned(), *p))
            .collect(),
        ..named("influx", &[1e-3, 0.0, 600.0, 0.15])
    }
}

fn correction(probability: f64) -> Named {
    Named {
        applied: Applied::new(unknown(), vec![0.0; unknown().about().parameters.len()]),
        ..influx(probability, &[])
    }
}

#[test]
fn what_outweighs_a_suspect_and_was_not_suspected_is_no_alternative_to_it() {
    let of = |alternatives: &[(&str, f64)], suspects: &[&str]| {
        let mut one = influx(0.3, alternatives);
        let suspects: Vec<String> = suspects.iter().map(|s| (*s).to_owned()).collect();
        unless_outweighed(&mut one, &suspects);
        let left = one.alternatives.into_iter().map(|a| a.0);
        left.collect::<Vec<String>>()
    };
    let suspects = ["influx", "annulus_area"];
    let likelier = ("inflow_gain", 0.4);
    assert_eq!(of(&[("inflow_gain", 0.3)], &suspects), ["inflow_gain"]);
    assert_eq!(of(&[("annulus_area", 0.4)], &suspects), ["annulus_area"]);
    assert!(of(&[likelier], &suspects).is_empty());
    // Nothing else that was not suspected stays either, but what was suspected does.
    assert_eq!(
        of(
            &[("annulus_area", 0.2), likelier, ("unknown", 0.05)],
            &suspects
        ),
        ["annulus_area"]
    );
}

#[test]
fn what_is_more_likely_not_there_is_kept_of_suspects_alone() {
    let record = steady(10);
    let after = |record: &Record, probability: f64, sought: Sought<'_>| {
        let mut named = vec![influx(probability, &[])];
        believe(record, &mut named, sought);
        named
    };
    let suspects = ["influx".to_owned()];
    assert!(after(&record, 0.05, Sought::Any(6)).is_empty());
    assert_eq!(after(&record, 0.05, Sought::Given(&suspects)).len(), 1);
    let believed = after(&record, 0.95, Sought::Any(6));
    assert_ne!(believed[0].probability, 0.95);
    let uncalibrated = Record {
        without: vec![Step::Calibration],
        ..record
    };
    let raw = |probability: f64| after(&uncalibrated, probability, Sought::Any(6));
    assert_eq!(raw(0.95)[0].probability, 0.95);
    assert_eq!((raw(0.5).len(), raw(0.49).len()), (1, 0));
}

#[test]
fn names_are_doubted_beside_what_is_likely_and_has_none() {
    let beside = |probability: f64| {
        let mut named = vec![influx(0.95, &[]), correction(probability)];
        let doubted = beside_unnamed(&mut named);
        (doubted, named[0].probability)
    };
    let (alone, doubted) = (beside(0.5), beside(0.9));
    assert!(!alone.0 && doubted.0);
    assert!(doubted.1 < alone.1, "{doubted:?} {alone:?}");
}

/// A trace of a relation, so many times as large as noise and accuracy explain.
fn trace(relation: Relation, times: f64) -> Trace {
    Trace {
        relation,
        pair: None,
        unit: "Pa",
        t_s: vec![0.0; 2],
        before: vec![0.0; 2],
        after: vec![5e3 * times, -5e3 * times],
        offset: 0.0,
        noise: 3e3,
        wander: 4e3,
    }
}

#[test]
fn a_name_is_doubted_where_its_relation_keeps_more_than_noise_and_less_if_it_was_before() {
    let of = |relation: Relation, times: f64, doubted: bool| {
        let mut named = vec![influx(0.9, &[])];
        let traces = [trace(relation, times)];
        doubt_what_is_left(&traces, &mut named, doubted, Sought::Any(6));
        named[0].probability
    };
    let own = Relation::RiserMassBalance;
    assert_eq!(of(own, 1.0, false), 0.9);
    assert_eq!(of(Relation::PumpHead, 3.0, false), 0.9);
    let (once, again) = (of(own, 3.0, false), of(own, 3.0, true));
    assert!(once < again && again < 0.9, "{once} {again}");
}

#[test]
fn a_suspect_that_is_doubted_for_what_is_left_does_not_stand_for_that() {
    let suspects = ["influx".to_owned()];
    let mut found = vec![influx(0.4, &[])];
    let traces = [trace(Relation::RiserMassBalance, 3.0)];
    doubt_what_is_left(&traces, &mut found, false, Sought::Given(&suspects));
    assert!(found[0].probability < 0.2);
    assert!(found[0].alternatives.is_empty());
    let mut any = vec![influx(0.4, &[])];
    doubt_what_is_left(&traces, &mut any, false, Sought::Any(6));
    assert_eq!(any[0].alternatives[0].0, "unknown");
}

#[test]
fn an_outlet_transmitter_is_told_by_its_tag() {
    let (mut well, _) = recorded(&steady(10), 0.0);
    well.channels.pump_outlet_pressure = vec![
        ChannelSource::column("PT-1", Unit::parse("Pa").unwrap()),
        ChannelSource::column("PT-2", Unit::parse("Pa").unwrap()),
        ChannelSource::Constant { si: 0.0 },
    ];
    let told = |name: &str, sensor: f64| {
        let parameter = |name: &str| ParameterEstimate {
            name: name.to_owned(),
            meaning: "which".to_owned(),
            estimate: sensor,
            ci95: (sensor, sensor),
        };
        let mut finding = Finding {
            parameters: vec![parameter(name)],
            ..found("outlet_pressure_bias_step", 0.9)
        };
        name_transmitter(&mut finding, &well);
        finding.parameters.remove(0).meaning
    };
    assert_eq!(told("sensor", 1.0), "which: `PT-1`");
    assert_eq!(told("sensor", 2.0), "which: `PT-2`");
    // A constant has no tag, and what is no sensor none either.
    assert_eq!(told("sensor", 3.0), "which");
    assert_eq!(told("sensor", 4.0), "which");
    assert_eq!(told("bias_pa", 1.0), "which");
}

#[test]
fn samples_a_minute_apart_are_diagnosed_and_rarer_ones_refused() {
    let of = |step_s: f64| {
        let (mut well, mut prepared) = recorded(&steady(10), 0.0);
        well.channels.time = TimeSource::Interval { step_s };
        prepared.step_s = step_s;
        for (i, t) in prepared.recording.time_s.iter_mut().enumerate() {
            *t = step_s * i as f64;
        }
        accepted(&well, &prepared, &Options::default()).map(|given| given.len())
    };
    assert_eq!(of(60.0), Ok(0));
    assert_eq!(of(61.0), Err(DiagnoseError::Step { step_s: 61.0 }));
}
