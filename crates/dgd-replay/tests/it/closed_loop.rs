//! A recording made by the model is met by the model.

use super::rig::{DELAY_S, START, line, options, recording, run};
use dgd_dynamics::integrate::Status;
use dgd_replay::{Kind, Pair, ReplayOptions, Start};

fn largest(pair: &Pair) -> f64 {
    let deviation = pair.deviation().unwrap();
    assert!(deviation.samples > 1000, "{}", deviation.samples);
    deviation.largest
}

#[test]
fn the_coupled_simulation_meets_every_signal_of_its_own_recording() {
    let run = run(&recording(1500), &options(Kind::Coupled));
    assert_eq!(run.status, Some(Status::Finished));
    assert!(largest(&run.level_m) < 1e-6, "{}", largest(&run.level_m));
    assert!(largest(&run.pump_flow_m3_s) < 1e-8);
    assert!(largest(&run.return_flow_m3_s) < 1e-8);
    assert!(largest(&run.inlet_pressure_pa) < 0.02);
    assert!(largest(&run.outlet_pressure_pa) < 2.0);
    assert_eq!(run.filled, 0);
    assert_eq!(run.time_s.len(), 1500);
}

#[test]
fn the_measured_head_is_the_pumps_but_for_the_inertia_of_the_risers_column() {
    let run = run(&recording(1500), &options(Kind::Coupled));
    let rows = run.time_s.len();
    let (q, head) = (&run.pump_flow_m3_s.simulated, &run.head_m);
    assert!(
        largest(head) > 0.3,
        "the start is no test: {}",
        largest(head)
    );
    for i in 20..rows - 1 {
        // ΔH_pump - ΔH_measured = (h_in - h_r)/(A_a g) · dq/dt, some 114 s²/m² · dq/dt here.
        let column = line().inlet_depth_m - run.level_m.simulated[i];
        let rate = 0.5 * (q[i + 1] - q[i - 1]);
        let expected = column / line().riser_area_m2 / 9.80665 * rate;
        let off = head.simulated[i] - head.measured[i] - expected;
        assert!(off.abs() < 2e-3, "{off} m at {i}");
    }
}

#[test]
fn the_riser_alone_follows_the_measured_flow() {
    // Within a window whose flow is smooth and read ahead from beyond its end.
    let window = ReplayOptions {
        window_s: Some((20.0, 1480.0)),
        ..options(Kind::Riser)
    };
    let inside = run(&recording(1500), &window);
    assert!(
        largest(&inside.level_m) < 1e-3,
        "{}",
        largest(&inside.level_m)
    );
    assert_eq!(inside.filled, 0);
    assert!(inside.return_flow_m3_s.simulated.is_empty() && inside.head_m.simulated.is_empty());
    assert!(inside.outlet_pressure_pa.deviation().is_none());
    // The meter cannot be read ahead at the recording's last 12 s: they are filled.
    assert_eq!(run(&recording(1500), &options(Kind::Riser)).filled, 12);
}

#[test]
fn the_flow_alone_follows_the_measured_level() {
    let run = run(&recording(1500), &options(Kind::Flow));
    assert!(
        largest(&run.pump_flow_m3_s) < 1e-6,
        "{}",
        largest(&run.pump_flow_m3_s)
    );
    assert!(run.level_m.simulated.is_empty() && run.inlet_pressure_pa.simulated.is_empty());
}

#[test]
fn the_steady_flow_solves_the_balance_at_every_sample() {
    let run = run(&recording(1500), &options(Kind::Steady));
    assert_eq!((run.status, run.unsolved), (None, 0));
    for i in 0..run.time_s.len() {
        let q = run.pump_flow_m3_s.simulated[i];
        let left = line().drive_pa(run.level_m.measured[i], run.speed_pct[i], q);
        assert!(left.abs() < 1e-3, "{left} Pa at {i}");
    }
}

#[test]
fn a_bias_of_the_flow_moves_the_riser_alone_by_its_integral_over_the_area() {
    let recording = recording(1500);
    let mut biased = recording.clone();
    let bias = 2e-4;
    biased.return_flow_m3_s.iter_mut().for_each(|q| *q += bias);
    let (sound, moved) = (
        run(&recording, &options(Kind::Riser)),
        run(&biased, &options(Kind::Riser)),
    );
    for i in [0, 1, 500, 1499] {
        let drift = moved.level_m.simulated[i] - sound.level_m.simulated[i];
        let expected = bias * sound.time_s[i] / line().riser_area_m2;
        assert!(
            (drift - expected).abs() < 1e-6,
            "{drift} m at {i}, expected {expected} m"
        );
    }
}

#[test]
fn a_longer_delay_shows_the_same_flow_later() {
    let recording = recording(1500);
    let with = |delay_s| {
        let options = ReplayOptions {
            delay_s,
            start: Start {
                level_m: Some(START.level_m),
                flow_m3_s: Some(START.flow_m3_s),
            },
            ..options(Kind::Coupled)
        };
        run(&recording, &options)
    };
    let (early, late) = (with(DELAY_S), with(DELAY_S + 30.0));
    assert_eq!(
        early.pump_flow_m3_s.simulated,
        late.pump_flow_m3_s.simulated
    );
    let (early, late) = (
        &early.return_flow_m3_s.simulated,
        &late.return_flow_m3_s.simulated,
    );
    let moved = early
        .iter()
        .zip(&late[30..])
        .all(|(e, l)| (e - l).abs() < 1e-15);
    assert!(moved);
    assert_eq!(late[..30], [START.flow_m3_s; 30]);
}

#[test]
fn the_initial_states_may_be_given() {
    let start = Start {
        level_m: Some(150.0),
        flow_m3_s: Some(0.03),
    };
    let options = ReplayOptions {
        start,
        ..options(Kind::Coupled)
    };
    let run = run(&recording(1500), &options);
    assert_eq!(run.level_m.simulated[0], 150.0);
    assert_eq!(run.pump_flow_m3_s.simulated[0], 0.03);
    assert!((run.level_m.measured[0] - START.level_m).abs() < 1e-9);
}

#[test]
fn the_order_of_the_transmitters_changes_no_bit() {
    let recording = recording(300);
    let mut exchanged = recording.clone();
    exchanged.pump_inlet_pressure_pa.reverse();
    exchanged.pump_outlet_pressure_pa.reverse();
    let [there, here] = [exchanged, recording].map(|r| run(&r, &options(Kind::Coupled)));
    // As text: the last values read ahead are NaN.
    assert_eq!(format!("{there:?}"), format!("{here:?}"));
}

#[test]
fn across_a_shut_valve_stands_the_difference_of_the_columns() {
    let mut stopped = recording(200);
    stopped.pump_speed_pct.fill(0.0);
    let mut steady = options(Kind::Steady);
    steady.window_s = None;
    let run = run(&stopped, &steady);
    let line = line();
    assert!(run.pump_flow_m3_s.simulated.iter().all(|q| *q == 0.0));
    let columns =
        |inlet_pa: f64| (line.outlet_pressure_pa(0.0) - inlet_pa) / (line.density_kg_m3 * 9.80665);
    let inlet = stopped.mean_inlet_pressure_pa();
    for (head_m, inlet_pa) in run.head_m.simulated.iter().zip(inlet) {
        assert!((head_m - columns(inlet_pa)).abs() < 1e-6, "{head_m}");
    }
}
