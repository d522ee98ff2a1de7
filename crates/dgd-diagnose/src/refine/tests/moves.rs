//! Claims about effects that are moved to where they explain most, on an hour and a half of drilling.

use crate::record::Record;
use crate::refine::refine;
use crate::relations::Applied;
use crate::tangent::{Bend, Tangent};
use crate::test_rig::{Hidden, INFLUX_S, drilled, one};
use dgd_lsq::dot;

fn misfit(record: &Record, state: &[Applied]) -> f64 {
    let tangent = Tangent::at(record, state, &[], Bend::Stiff).unwrap();
    dot(&tangent.off, &tangent.off)
}

fn influx() -> Record {
    drilled(Hidden {
        influx_m3_s: 3e-3,
        ..Hidden::default()
    })
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
    let (tau, mut held, mut before) = (12.0_f64, 0.01, 0.01);
    let share = 1.0 - (-record.dt_s / tau).exp();
    for i in 0..record.t_s.len() {
        let booster = if i / 150 % 2 == 0 { 0.01 } else { 0.02 };
        // Straight from sample to sample.
        held += share * (before - held) + (1.0 - share * tau / record.dt_s) * (booster - before);
        before = booster;
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
