use dgd_dynamics::integrate::Method;
use dgd_dynamics::return_line::{
    FLOW_LIMIT_M3_S, LineState, SteadyStatus, simulate_flow_alone, steady_flow, steady_state,
};

use crate::common::{line, linear, options};

#[test]
fn the_steady_flow_meets_the_balance_at_every_sample() {
    let mut line = line();
    for valve in [true, false] {
        line.non_return_valve = valve;
        let (mut level, mut speed) = (Vec::new(), Vec::new());
        for h in 0..=35 {
            for w in 0..=50 {
                level.push(10.0 * f64::from(h));
                speed.push(2.0 * f64::from(w));
            }
        }
        let all = steady_state(&line, &level, &speed).unwrap();
        let mut shut = 0;
        for (k, (&q, &status)) in all.flow_m3_s.iter().zip(&all.status).enumerate() {
            let drive = line.drive_pa(level[k], speed[k], q);
            match status {
                SteadyStatus::Solved => assert!(drive.abs() < 1e-6, "{drive} at {k}"),
                SteadyStatus::Shut => {
                    shut += 1;
                    assert!(q == 0.0 && drive < 0.0 && valve);
                }
                other => panic!("{other:?} at {k}"),
            }
        }
        assert_eq!(shut > 0, valve);
    }
}

#[test]
fn the_steady_flow_is_the_limit_of_the_dynamic_one() {
    let t = [0.0, 300.0];
    for (h, w) in [(120.0, 60.0), (200.0, 70.0), (10.0, 30.0)] {
        let (level, speed) = ([h; 2], [w; 2]);
        let run = simulate_flow_alone(
            &line(),
            0.03,
            &linear(&t, &level),
            &linear(&t, &speed),
            &t,
            &options(Method::Rodasp, 1e-10),
        )
        .unwrap();
        let (q, status) = steady_flow(&line(), h, w).unwrap();
        assert_eq!(status, SteadyStatus::Solved);
        assert!(
            (run.flow_m3_s[1] - q).abs() < 1e-9,
            "{} against {q}",
            run.flow_m3_s[1]
        );
    }
}

#[test]
fn the_order_of_samples_does_not_matter() {
    let (h, w) = ([100.0, 140.0, 20.0, 140.0], [60.0, 0.0, 99.0, 62.0]);
    let together = steady_state(&line(), &h, &w).unwrap();
    for k in 0..4 {
        let (alone, status) = steady_flow(&line(), h[k], w[k]).unwrap();
        assert_eq!(status, together.status[k]);
        assert!((alone - together.flow_m3_s[k]).abs() < 1e-14);
    }
}

#[test]
fn without_resistance_the_flow_is_reported_as_unbounded() {
    let mut line = line();
    line.friction = Default::default();
    (line.pump.c1, line.pump.c2) = (0.0, 0.0);
    assert_eq!(
        steady_flow(&line, 50.0, 80.0).unwrap(),
        (FLOW_LIMIT_M3_S, SteadyStatus::Unbounded)
    );
}

#[test]
fn a_start_at_the_steady_state_stays_there() {
    let t = [0.0, 3600.0];
    let (q, _) = steady_flow(&line(), 140.0, 65.0).unwrap();
    let (u, w) = ([q; 2], [65.0; 2]);
    let start = LineState {
        level_m: 140.0,
        flow_m3_s: q,
    };
    let run = dgd_dynamics::return_line::simulate_coupled(
        &line(),
        start,
        &linear(&t, &u),
        &linear(&t, &w),
        &t,
        &options(Method::Rodasp, 1e-6),
    )
    .unwrap();
    assert!((run.level_m[1] - 140.0).abs() < 1e-9);
    assert!((run.flow_m3_s[1] - q).abs() < 1e-12);
}

#[test]
fn a_balance_that_overflows_ends_with_a_status() {
    let mut line = line();
    line.friction.e_pa_s3_m9 = f64::MAX;
    line.pump.c2 = f64::MAX;
    let (q, status) = steady_flow(&line, 140.0, 65.0).unwrap();
    assert!(
        matches!(status, SteadyStatus::IterationLimit | SteadyStatus::Solved),
        "{status:?} at {q}"
    );
    line.pump.c0 = f64::MAX;
    let (_, status) = steady_flow(&line, 140.0, 65.0).unwrap();
    assert_eq!(status, SteadyStatus::IterationLimit);
}

#[test]
fn columns_in_balance_do_not_flow() {
    // Level and outlet lie alike, and nothing drives.
    let mut line = line();
    line.friction.b_pa = 0.0;
    for valve in [true, false] {
        line.non_return_valve = valve;
        assert_eq!(
            steady_flow(&line, 0.0, 0.0).unwrap(),
            (0.0, SteadyStatus::Solved)
        );
    }
}

#[test]
fn of_several_flows_that_balance_the_stable_one_is_returned() {
    // Beyond 0.07 m3/s this friction falls again: a second flow balances there, and more flow meets less resistance.
    let mut line = line();
    line.friction.e_pa_s3_m9 = -1.2e9;
    line.pump.c2 = 0.0;
    let up: Vec<f64> = (0..=80).map(|k| 50.0 + 0.25 * f64::from(k)).collect();
    let down: Vec<f64> = up.iter().rev().copied().collect();
    let mut solved = 0;
    for speeds in [&up, &down] {
        let all = steady_state(&line, &vec![140.0; speeds.len()], speeds).unwrap();
        for ((&w, &q), &status) in speeds.iter().zip(&all.flow_m3_s).zip(&all.status) {
            let drive = |q: f64| line.drive_pa(140.0, w, q);
            // Over a fiftieth of some flow.
            let balances = (1..2000)
                .map(|k| 1e-4 * f64::from(k))
                .any(|q| [q, 1.01 * q, 1.02 * q].iter().all(|q| drive(*q) < 0.0));
            match status {
                SteadyStatus::Solved => {
                    solved += 1;
                    assert!(
                        drive(q).abs() < 1e-6 && drive(q + 1e-5) < drive(q - 1e-5),
                        "{w}: {q}"
                    );
                }
                SteadyStatus::Shut => assert!(drive(0.0) < 0.0),
                SteadyStatus::Unbounded => assert!(!balances, "{w}: {q}"),
                other => panic!("{other:?} at {w}"),
            }
        }
    }
    assert!(solved > 20, "{solved}");
}
