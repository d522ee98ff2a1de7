//! Claims about the search on an hour and a half of drilling: what is concealed is found again.

use super::fixture::{BLOCK_S, Hidden, INFLUX_S, drilled};
use crate::belief::calibrate;
use crate::record::{MASS_BLOCKS, Record};
use crate::refine::refine;
use crate::relations::Applied;
use crate::scan::allowances_with;
use crate::select::{Named, Selection, Sought, select};
use crate::slack::slack;
use crate::tangent::{Bend, Tangent, dot};
use crate::timing::{allowed_beside, is_late_meter, retimed, stepped};
use dgd_effects::find;

fn one(id: &str, parameters: &[f64]) -> Applied {
    Applied::new(find(id).unwrap(), parameters.to_vec())
}

fn about(record: &Record, state: &[Applied]) -> Tangent {
    Tangent::at(record, state, &[], Bend::Free).unwrap()
}

fn misfit(record: &Record, state: &[Applied]) -> f64 {
    let tangent = about(record, state);
    dot(&tangent.off, &tangent.off)
}

fn influx() -> Record {
    drilled(Hidden {
        influx_m3_s: 3e-3,
        ..Hidden::default()
    })
}

#[test]
fn sound_drilling_leaves_no_more_than_white_noise_and_needs_no_allowance() {
    let record = drilled(Hidden::default());
    let tangent = about(&record, &[]);
    let rows = tangent.whitening.valid.iter().filter(|v| **v).count();
    assert!(rows > 1000 && misfit(&record, &[]) < rows as f64);
    let allowed = allowances_with(&record, &[], &[], Bend::Free, None).unwrap();
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
        .map(|a| (a.effect.about().id, a.parameters[0], a.allowance))
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
    let wide = stepped(&slopes, &off, &from, &[(0.0, 90.0); 3]);
    for (got, want) in wide.iter().zip([4.0, 6.0, 1.5]) {
        assert!((got - want).abs() < 1e-6, "{wide:?}");
    }
    // Held at 3, the second leaves 2 + 4 of the second row to the first: (3 + 6) / 2.
    let held = stepped(
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
    let told = stepped(&still, &off, &from, &[(0.0, 90.0); 3]);
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
fn an_influx_is_moved_to_its_rate_and_times() {
    let record = influx();
    let (from, lasts, rise) = INFLUX_S;
    let start = one("influx", &[2e-3, from + 60.0, lasts - 90.0, rise]);
    let mut state = vec![start.clone()];
    refine(&record, &mut state, 0, &[], 2);
    let p = &state[0].parameters;
    assert!((p[0] / 3e-3 - 1.0).abs() < 0.03, "{p:?}");
    assert!((p[1] - from).abs() < 30.0, "{p:?}");
    assert!((p[1] + p[2] - from - lasts).abs() < 30.0, "{p:?}");
    let (before, after) = (
        misfit(&record, std::slice::from_ref(&start)),
        misfit(&record, &state),
    );
    assert!(after < before - 30.0, "{after} of {before}");

    // Effects before the first to be moved, and allowances, stay where they are.
    let mut kept = vec![start.clone()];
    refine(&record, &mut kept, 1, &[], 2);
    assert_eq!(kept[0].parameters, start.parameters);
    kept[0].allowance = true;
    refine(&record, &mut kept, 0, &[], 2);
    assert_eq!(kept[0].parameters, start.parameters);
}

#[test]
fn an_influx_of_another_size_or_minutes_off_is_found_in_one_round() {
    let record = influx();
    let (from, lasts, rise) = INFLUX_S;
    let found = |rate: f64, late: f64, rise: f64| {
        let mut state = vec![one("influx", &[rate, from + late, lasts, rise])];
        refine(&record, &mut state, 0, &[], 1);
        state.swap_remove(0).parameters
    };
    // Three steps of one size are made at the most.
    for (rate, late) in [(3e-3, 200.0), (3e-3, -200.0), (1.5e-3, 60.0), (5e-3, 0.0)] {
        let p = found(rate, late, rise);
        assert!((p[1] - from).abs() < 45.0, "{rate} {late}: {p:?}");
        assert!(
            (p[1] + p[2] - from - lasts).abs() < 45.0,
            "{rate} {late}: {p:?}"
        );
        assert!((p[0] / 3e-3 - 1.0).abs() < 0.05, "{rate} {late}: {p:?}");
    }
    let p = found(3e-3, 0.0, 0.5);
    assert!((p[3] - rise).abs() < 0.06, "{p:?}");
}

#[test]
fn a_transmitter_is_not_moved_and_nor_is_what_the_record_does_not_show() {
    let mut record = drilled(Hidden::default());
    let (onset, bias) = (2000.0, 4e4);
    let mut first = record.outlet.clone();
    for (p, t) in first.iter_mut().zip(&record.t_s) {
        *p += if *t >= onset { bias } else { 0.0 };
    }
    record.outlets.insert(0, first);
    for (mean, outlets) in record.outlet.iter_mut().zip(&record.outlets[0]) {
        *mean = 0.5 * (*mean + outlets);
    }
    record.filled.outlet.clone_from(&record.outlet);
    let mut state = vec![
        one("outlet_pressure_bias_step", &[2e4, onset + 30.0, 1.0]),
        // Nothing stands still.
        one("line_drainage", &[0.1, 0.5, 100.0]),
    ];
    refine(&record, &mut state, 0, &[], 2);
    let p = &state[0].parameters;
    assert!(
        (p[0] / bias - 1.0).abs() < 0.01 && (p[1] - onset).abs() < 5.0 && p[2] == 1.0,
        "{p:?}"
    );
    assert_eq!(state[1].parameters, [0.1, 0.5, 100.0]);
}

#[test]
fn a_strength_on_a_grid_is_moved_to_where_it_explains_most() {
    let mut record = drilled(Hidden::default());
    // The booster runs now more, now less; what it pumps comes by way of its line.
    let (tau, mut held) = (12.0_f64, 0.01);
    for i in 0..record.t_s.len() {
        let booster = if i / 150 % 2 == 0 { 0.01 } else { 0.02 };
        held += (1.0 - (-record.dt_s / tau).exp()) * (booster - held);
        record.mud_pump[i] += 0.01 - held;
        record.booster[i] = booster;
    }
    record.filled.mud_pump.clone_from(&record.mud_pump);
    record.filled.booster.clone_from(&record.booster);
    for from in [7.0, 10.0, 17.0] {
        let mut state = vec![one("booster_line_storage", &[from])];
        refine(&record, &mut state, 0, &[], 1);
        let found = state[0].parameters[0];
        assert!((found / tau - 1.0).abs() < 0.05, "{found} from {from}");
    }
}

#[test]
fn an_influx_may_be_wrong_by_its_parameters_and_by_a_seventh_of_its_form() {
    let record = influx();
    let (from, lasts, rise) = INFLUX_S;
    let state = vec![one("influx", &[3e-3, from, lasts, rise])];
    let tangent = about(&record, &state);
    let free = slack(&record, &tangent, &state, 0);
    // Strength, onset, duration, shape; then time twice and load, each with half of its form's error.
    let widths: Vec<f64> = free.iter().map(|s| s.width).collect();
    assert_eq!(widths, [3e-3, 120.0, 120.0, 1.0, 0.075, 0.075, 0.075]);

    // Along its strength lies all that it does.
    let columns: Vec<Vec<f64>> = free.iter().map(|s| s.column.whole()).collect();
    let trace: Vec<f64> = columns[0].iter().map(|v| 3e-3 * v).collect();
    let without = tangent.change(&record, &[]);
    let size = dot(&trace, &trace).sqrt();
    assert!(size > 1e-3);
    for (trace, without) in trace.iter().zip(&without) {
        assert!((trace + without).abs() < 1e-9 * size);
    }
    // Later by a second, it is what the trace loses in one: onset and duration together move it whole.
    let later = one("influx", &[3e-3, from + 30.0, lasts, rise]);
    let moved = tangent.change(&record, &[later]);
    for (column, moved) in columns[1].iter().zip(&moved) {
        assert!((30.0 * column - moved).abs() < 1e-9 * size);
    }
    // It may swell and fade from first to last, and be weak amidst; at the ends both are whole.
    let mass = tangent.layout.mass_at();
    for row in 0..tangent.layout.mass {
        let t = (row * MASS_BLOCKS) as f64 * BLOCK_S;
        let through = 2.0 * ((t - from) / lasts).clamp(0.0, 1.0) - 1.0;
        let here = trace[mass + row];
        let close = |k: usize, by: f64| {
            let found = columns[k][mass + row];
            assert!((found - here * by).abs() < 1e-9 * size, "{k} {row}");
        };
        close(4, through);
        close(5, 2.0 * through * through - 1.0);
    }
    // An allowance is no finding, and not wrong by anything.
    let mut allowed = state.clone();
    allowed[0].allowance = true;
    assert!(slack(&record, &tangent, &allowed, 0).is_empty());
}

#[test]
fn a_named_effect_takes_the_place_of_its_allowance() {
    let allowance = |id: &str, tau: f64| Applied {
        allowance: true,
        ..one(id, &[tau])
    };
    let named = |applied: Applied| crate::select::Named {
        applied,
        evidence: 20.0,
        bent: 0.0,
        hurdle: 10.0,
        probability: 0.9,
        alternatives: Vec::new(),
        correction: None,
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
    };
    let state: Vec<(&str, f64)> = (selection.state().iter())
        .map(|a| (a.effect.about().id, a.parameters[0]))
        .collect();
    assert_eq!(state, [("pump_speed_lag", 2.0), ("return_flow_delay", 6.0)]);
}

/// The same drilling with a pump that lifts less by a share in a stretch, s, for which it turns faster.
fn lifting_less(loss: f64, stretch_s: std::ops::Range<f64>) -> Record {
    let mut record = drilled(Hidden::default());
    for i in 0..record.t_s.len() {
        if stretch_s.contains(&record.t_s[i]) {
            let lift = record.outlet[i] - record.inlet[i];
            // Its head is 45 bar times the square of the speed over 70 %, less what the flow takes.
            let more = lift * loss / (1.0 - loss) / 45e5 * 70.0_f64.powi(2);
            record.speed[i] = (record.speed[i].powi(2) + more).sqrt();
        }
    }
    record.filled.speed.clone_from(&record.speed);
    record
}

#[test]
fn a_head_that_is_lost_for_a_while_is_gas_and_one_that_stays_lost_is_nothing_of_the_catalogue() {
    let ends = 5400.0;
    for (stretch_s, is_gas) in [
        (1800.0..3600.0, true),
        (1800.0..ends, false),
        // It may have come before the recording began.
        (-1.0..3600.0, true),
    ] {
        let record = lifting_less(0.05, stretch_s.clone());
        let mut found = select(&record, &[], Sought::Any(3), |_| {}).unwrap().named;
        calibrate(&mut found);
        let gas = |n: &&Named| n.applied.effect.about().id == "gas_in_pump" && n.probability > 0.5;
        assert_eq!(found.iter().any(|n| gas(&n)), is_gas, "{stretch_s:?}");
        let unknown = |n: &Named| {
            let told = n
                .alternatives
                .iter()
                .any(|(id, p)| id == "unknown" && *p > 0.5);
            n.correction.is_some() || told
        };
        assert_eq!(found.iter().any(unknown), !is_gas, "{stretch_s:?}");
    }
}
