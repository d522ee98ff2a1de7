//! Runs that end where they should: over stops of the pump, an emptied riser and a valve that shuts and opens.

use crate::common::{METHODS, Noise, line, linear};
use dgd_dynamics::integrate::Status;
use dgd_dynamics::return_line::{
    Friction, LineState, PumpHead, ReturnLine, SimulationOptions, simulate_coupled,
};

#[test]
fn a_pump_that_stops_within_a_sample_is_run_through_at_any_rate_and_clock() {
    for method in METHODS {
        let options = SimulationOptions {
            method,
            ..SimulationOptions::default()
        };
        for (origin_s, step_s) in [(10.0, 0.1), (20.0, 0.2), (0.37, 1.0), (1000.7, 0.5)] {
            let time: Vec<f64> = (0..6).map(|i| origin_s + f64::from(i) * step_s).collect();
            for k in 0..120 {
                let w = 50.0 + 0.3 * f64::from(k);
                let speed = [w, w, w, 0.0, 0.0, 0.0];
                let run = simulate_coupled(
                    &line(),
                    LineState {
                        level_m: 140.0,
                        flow_m3_s: 0.05,
                    },
                    &linear(&time, &[0.05; 6]),
                    &linear(&time, &speed),
                    &time,
                    &options,
                )
                .unwrap();
                assert_eq!(run.status, Status::Finished, "{method:?} {w} {step_s}");
                assert!(run.flow_m3_s.iter().all(|q| q.is_finite()));
            }
        }
    }
}

#[test]
fn a_riser_that_empties_and_a_valve_that_shuts_hold_up_no_run() {
    let mut noise = Noise(5);
    let mut unit = || noise.next() + 0.5;
    let time: Vec<f64> = (0..40).map(|i| 30.0 * f64::from(i)).collect();
    for case in 0..400 {
        let depth = if case % 3 == 0 { 60.0 } else { 350.0 };
        let line = ReturnLine {
            inlet_depth_m: depth,
            outlet_depth_m: if case % 4 == 0 { 330.0 } else { depth },
            friction: Friction {
                b_pa: if case % 2 == 0 { 2e4 } else { -1e4 },
                d_pa_s2_m6: 1.2e8,
                ..Friction::default()
            },
            pump: PumpHead {
                c0: 0.0688,
                c1: 1.0,
                c2: 2.4e3,
                n0: 1.95,
                n2: 1.62,
            },
            ..line()
        };
        let inflow: Vec<f64> = (0..40).map(|_| (0.1 * (unit() - 0.2)).max(0.0)).collect();
        let speed: Vec<f64> = (0..40)
            .map(|_| (110.0 * (unit() - 0.3)).max(0.0) + 1.0)
            .collect();
        let start = LineState {
            level_m: depth * unit(),
            flow_m3_s: 0.02 * unit(),
        };
        for method in METHODS {
            let options = SimulationOptions {
                method,
                // What takes more than a few steps a sample chatters.
                max_steps: 20_000,
                ..SimulationOptions::default()
            };
            let (inflow, speed) = (linear(&time, &inflow), linear(&time, &speed));
            let run = simulate_coupled(&line, start, &inflow, &speed, &time, &options).unwrap();
            assert_eq!(run.status, Status::Finished, "{case} {method:?}");
            let within = |h: &f64| *h > -1e-6 && *h < depth + 1e-6;
            assert!(run.level_m.iter().all(within), "{case} {method:?}");
        }
    }
}
