//! Claims about what is late, and about what is allowed to be, on an hour and a half of drilling.
#![allow(clippy::unwrap_used, reason = "a test may fail by panic")]

mod allowances;

use super::{allowances_with, allowed_beside, gauss_newton_step, is_late_meter, retimed};
use crate::refine::refine;
use crate::relations::Applied;
use crate::selection::{Named, Selection};
use crate::tangent::{Bend, Tangent};
use crate::test_rig::{Hidden, drilled, one};
use dgd_effects::find;
use dgd_lsq::dot;

#[test]
fn sound_drilling_leaves_no_more_than_white_noise_and_needs_no_allowance() {
    let record = drilled(Hidden::default());
    let tangent = Tangent::at(&record, &[], &[], Bend::Stiff).unwrap();
    let misfit = dot(&tangent.off, &tangent.off);
    let rows = tangent.whitening.valid.iter().filter(|v| **v).count();
    assert!(rows > 1000 && misfit < rows as f64);
    let allowed = allowances_with(&record, &[], &[], Bend::Stiff, None).unwrap();
    assert!(allowed.is_empty());
}

#[test]
fn a_late_meter_is_timed_from_either_side_without_a_lag_of_the_pump() {
    let record = drilled(Hidden {
        late_s: 6.0,
        ..Hidden::default()
    });
    for from in [4.0, 9.0] {
        let late = one("return_flow_delay", &[from]);
        let mut state = vec![late.clone()];
        refine(&record, &mut state, 0, &[], 1);
        let refined = state[0].parameters[0];
        assert!((refined - 6.0).abs() < 0.5, "{refined}");

        let mut named = vec![late];
        let beside = allowed_beside(&record, &[], &mut named, &[]).unwrap();
        let timed = named[0].parameters[0];
        assert!((timed - 6.0).abs() < 0.5, "{timed}");
        assert!(beside.is_empty());
    }
}

#[test]
fn a_named_store_keeps_the_delay_of_a_sound_meter_beside_it() {
    let record = drilled(Hidden {
        late_s: 6.0,
        ..Hidden::default()
    });
    let mut named = vec![one("line_gas_storage", &[6.0, 0.0])];
    let beside = allowed_beside(&record, &[], &mut named, &[]).unwrap();
    let [delay] = beside.as_slice() else {
        panic!("{} beside it", beside.len());
    };
    // All of this lateness is a delay: as much of it is allowed for as may be.
    assert_eq!(delay.id(), "return_flow_delay");
    assert!(delay.allowance);
    assert_eq!(delay.parameters, [2.5]);
    let time_s = named[0].parameters[0];
    assert!(time_s < 6.0 - 0.5 * 2.5, "{time_s}");
}

#[test]
fn a_late_meter_is_timed_beside_the_lag_of_the_pump_that_earns_its_place() {
    let record = drilled(Hidden {
        late_s: 6.0,
        lag_s: 3.0,
        ..Hidden::default()
    });
    // Effects that do next to nothing, before it among those to start from and among those named.
    let start = [one("outlet_pressure_bias", &[1.0])];
    let mut named = vec![
        one("line_leak", &[1e-9, 2000.0]),
        one("return_flow_delay", &[4.0]),
    ];
    let beside = allowed_beside(&record, &start, &mut named, &[]).unwrap();
    let timed = named[1].parameters[0];
    assert!((timed - 6.0).abs() < 0.7, "{timed}");
    let found: Vec<(&str, f64, bool)> = (beside.iter())
        .map(|a| (a.id(), a.parameters[0], a.allowance))
        .collect();
    let bias = ("outlet_pressure_bias", 1.0, false);
    assert_eq!(found, [bias, ("pump_speed_lag", 3.0, true)]);
    assert_eq!(named[0].parameters, [1e-9, 2000.0]);

    // One that is named is not allowed for too.
    named.push(one("pump_speed_lag", &[3.0]));
    let beside = allowed_beside(&record, &start, &mut named, &[]).unwrap();
    assert_eq!(beside.len(), 1);
}

/// A delay and a store, each timed anew about what was allowed for before the meter was accused: times and evidence.
fn retimed_about(hidden: Hidden, wrongly: &[Applied]) -> [(f64, f64); 2] {
    let record = drilled(hidden);
    let gate = Tangent::at(&record, wrongly, &[], Bend::Lean).unwrap();
    ["return_flow_delay", "line_gas_storage"].map(|id| {
        let mut meter = one(id, &[]);
        meter.parameters = meter.effect.about().of_strength(4.0);
        retimed(&record, &gate, wrongly, &meter).unwrap()
    })
}

#[test]
fn a_late_meter_gets_back_what_was_allowed_for_before_it_was_accused() {
    let allowed = |id: &str, time: f64| Applied {
        allowance: true,
        ..one(id, &[time])
    };
    let wrongly = [
        allowed("return_flow_delay", 2.5),
        allowed("pump_speed_lag", 5.0),
    ];
    let (late, store) = (
        Hidden {
            late_s: 8.0,
            ..Hidden::default()
        },
        Hidden {
            store_s: 12.0,
            ..Hidden::default()
        },
    );
    for wrongly in [&wrongly[..], &[]] {
        let [delay, other] = retimed_about(late, wrongly);
        assert!((delay.0 - 8.0).abs() < 0.5, "{delay:?}");
        assert!(delay.1 > 1.05 * other.1, "{delay:?} {other:?}");
        let [other, store] = retimed_about(store, wrongly);
        assert!((store.0 - 12.0).abs() < 3.0, "{store:?}");
        assert!(store.1 > 1.05 * other.1, "{store:?} {other:?}");
    }
}

#[test]
fn times_that_would_leave_their_range_are_held_and_the_others_solved_for_again() {
    // Two times that move the same rows, and a third by itself.
    let slopes = [
        vec![1.0, 1.0, 0.0],
        vec![0.0, 1.0, 0.0],
        vec![0.0, 0.0, 2.0],
    ];
    let off = [-3.0, -8.0, -1.0];
    let from = [1.0, 1.0, 1.0];
    let wide = gauss_newton_step(&slopes, &off, &from, &[(0.0, 90.0); 3]);
    for (got, want) in wide.iter().zip([4.0, 6.0, 1.5]) {
        assert!((got - want).abs() < 1e-6, "{wide:?}");
    }
    // Held at 3, the second leaves 2 + 4 of the second row to the first: (3 + 6) / 2.
    let held = gauss_newton_step(
        &slopes,
        &off,
        &from,
        &[(0.0, 90.0), (0.0, 3.0), (0.0, 90.0)],
    );
    for (got, want) in held.iter().zip([1.0 + 4.5, 3.0, 1.5]) {
        assert!((got - want).abs() < 1e-6, "{held:?}");
    }
    // A pump whose speed stands tells nothing of its lag.
    let still = [slopes[0].clone(), vec![0.0; 3], slopes[2].clone()];
    let told = gauss_newton_step(&still, &off, &from, &[(0.0, 90.0); 3]);
    for (got, want) in told.iter().zip([1.0 + 5.5, 1.0, 1.5]) {
        assert!((got - want).abs() < 1e-6, "{told:?}");
    }
}

#[test]
fn only_a_delay_or_lag_of_the_meter_makes_it_late() {
    for (id, late) in [
        ("return_flow_delay", true),
        ("pump_speed_lag", false),
        ("influx", false),
    ] {
        assert_eq!(is_late_meter(find(id).unwrap().about()), late, "{id}");
    }
}

#[test]
fn a_named_effect_takes_the_place_of_its_allowance() {
    let allowance = |id: &str, tau: f64| Applied {
        allowance: true,
        ..one(id, &[tau])
    };
    let named = |applied: Applied| Named {
        applied,
        evidence: 20.0,
        bent: 0.0,
        hurdle: 10.0,
        probability: 0.9,
        alternatives: Vec::new(),
        held: None,
        most: None,
    };
    let selection = Selection {
        held: 0,
        allowances: vec![
            allowance("return_flow_delay", 1.0),
            allowance("pump_speed_lag", 2.0),
        ],
        named: vec![named(one("return_flow_delay", &[6.0]))],
        first: Vec::new(),
        stays: false,
    };
    let state: Vec<(&str, f64)> = (selection.state().iter())
        .map(|a| (a.id(), a.parameters[0]))
        .collect();
    assert_eq!(state, [("pump_speed_lag", 2.0), ("return_flow_delay", 6.0)]);
}
