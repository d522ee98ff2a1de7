use dgd_dynamics::inputs::{Interpolation, Signal};
use dgd_dynamics::integrate::{Method, Status};
use dgd_dynamics::return_line::{
    ATMOSPHERE_PA, GRAVITY_M_S2, LineState, ReturnLine, SimulationOptions, derive_outputs,
    linearise, measured_flow, simulate_coupled, simulate_flow_alone, simulate_riser_alone,
};

use crate::common::{METHODS, kinked_inputs, line, linear, options};

const START: LineState = LineState {
    level_m: 140.0,
    flow_m3_s: 0.05,
};

fn farthest(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).fold(0.0, |e, (a, b)| e.max((a - b).abs()))
}

#[test]
fn a_simulation_ends_with_the_steps_that_it_may_take() {
    let time = [0.0, 3000.0];
    let (u, w) = (linear(&time, &[0.04; 2]), linear(&time, &[50.0; 2]));
    for method in METHODS {
        let few = SimulationOptions {
            max_steps: 7,
            ..options(method, 1e-6)
        };
        let run = simulate_coupled(&line(), START, &u, &w, &time, &few).unwrap();
        assert!(
            matches!(run.status, Status::TooManySteps { .. }),
            "{:?}",
            run.status
        );
        assert_eq!(run.statistics.steps + run.statistics.rejected, 7);
    }
}

#[test]
fn the_methods_agree_and_converge_with_the_tolerance() {
    let (time, inflow, speed) = kinked_inputs(300);
    let (u, w) = (linear(&time, &inflow), linear(&time, &speed));
    let go = |method, tol| {
        simulate_coupled(&line(), START, &u, &w, &time, &options(method, tol)).unwrap()
    };
    let best = go(Method::Rodasp, 1e-11);
    assert!(farthest(&best.flow_m3_s, &go(Method::DormandPrince, 1e-11).flow_m3_s) < 1e-11);
    for method in METHODS {
        for (tol, allowed) in [(1e-4, 1e-5), (1e-6, 1e-7), (1e-8, 1e-9)] {
            let run = go(method, tol);
            assert_eq!(run.status, Status::Finished);
            let off = farthest(&run.flow_m3_s, &best.flow_m3_s);
            assert!(off < allowed, "{method:?} {tol}: {off:e}");
            assert!(farthest(&run.level_m, &best.level_m) < 10.0 * allowed);
        }
    }
    // Unless asked for otherwise: below what any transmitter shows.
    let run = simulate_coupled(&line(), START, &u, &w, &time, &SimulationOptions::default());
    let run = run.unwrap();
    assert!(farthest(&run.level_m, &best.level_m) < 1e-4);
    assert!(farthest(&run.flow_m3_s, &best.flow_m3_s) < 2.5e-5);
}

#[test]
fn the_riser_keeps_its_mud() {
    let (time, inflow, speed) = kinked_inputs(600);
    let (u, w) = (linear(&time, &inflow), linear(&time, &speed));
    // Fine outputs, so that the trapezoidal rule below is exact enough.
    let fine: Vec<f64> = (0..=600 * 64).map(|k| f64::from(k) / 64.0).collect();
    for method in METHODS {
        let run = simulate_coupled(&line(), START, &u, &w, &fine, &options(method, 1e-8)).unwrap();
        let mut volume = 0.0;
        for k in 1..fine.len() {
            let net = |k: usize| run.flow_m3_s[k] - u.at(fine[k]);
            volume += 0.5 * (net(k) + net(k - 1)) * (fine[k] - fine[k - 1]);
            let stored = (run.level_m[k] - run.level_m[0]) * line().riser_area_m2;
            assert!(
                (stored - volume).abs() < 2e-6,
                "{method:?} at {} s",
                fine[k]
            );
        }
    }
}

#[test]
fn the_riser_alone_is_the_integral_of_the_measured_flows() {
    let (time, inflow, speed) = kinked_inputs(300);
    let flow: Vec<f64> = speed.iter().map(|w| w * 8e-4).collect();
    let (u, q) = (linear(&time, &inflow), linear(&time, &flow));
    for method in METHODS {
        let run =
            simulate_riser_alone(&line(), 140.0, &u, &q, &time, &options(method, 1e-4)).unwrap();
        let mut level = 140.0;
        for k in 1..time.len() {
            level +=
                0.5 * (flow[k] + flow[k - 1] - inflow[k] - inflow[k - 1]) / line().riser_area_m2;
            assert!((run.level_m[k] - level).abs() < 1e-10, "{method:?} at {k}");
        }
        assert_eq!(run.flow_m3_s, flow);
    }
}

#[test]
fn the_flow_alone_follows_the_coupled_flow_if_given_its_level() {
    let (time, inflow, speed) = kinked_inputs(300);
    let fine: Vec<f64> = (0..=3000).map(|k| f64::from(k) / 10.0).collect();
    let (u, w) = (linear(&time, &inflow), linear(&time, &speed));
    for method in METHODS {
        let o = options(method, 1e-9);
        let both = simulate_coupled(&line(), START, &u, &w, &fine, &o).unwrap();
        let level = linear(&fine, &both.level_m);
        let alone = simulate_flow_alone(&line(), START.flow_m3_s, &level, &w, &fine, &o).unwrap();
        // The level is sampled at 0.1 s: its straight pieces are off by 1e-4 m at most.
        assert!(farthest(&alone.flow_m3_s, &both.flow_m3_s) < 1e-6);
        assert_eq!(alone.level_m, both.level_m);
    }
}

/// Pump on, ramp down to standstill, off for minutes, and on again.
fn stop_and_restart() -> (Vec<f64>, Vec<f64>, Vec<f64>) {
    let time: Vec<f64> = (0..=900).map(f64::from).collect();
    let speed = time
        .iter()
        .map(|&t| match t {
            t if t < 200.0 => 62.0,
            t if t < 210.0 => 62.0 * (210.0 - t) / 10.0,
            t if t < 500.0 => 0.0,
            t if t < 540.0 => 62.0 * (t - 500.0) / 40.0,
            _ => 62.0,
        })
        .collect();
    let inflow = time
        .iter()
        .map(|&t| {
            if (205.0..=520.0).contains(&t) {
                0.01
            } else {
                0.05
            }
        })
        .collect();
    (time, inflow, speed)
}

#[test]
fn the_valve_shuts_once_at_the_stop_and_opens_once_at_the_restart() {
    let (time, inflow, speed) = stop_and_restart();
    for kind in [Interpolation::Linear, Interpolation::Hold] {
        let u = Signal::new("u", &time, &inflow, kind).unwrap();
        let w = Signal::new("w", &time, &speed, kind).unwrap();
        let mut ends = Vec::new();
        for method in METHODS {
            let run =
                simulate_coupled(&line(), START, &u, &w, &time, &options(method, 1e-6)).unwrap();
            assert_eq!(run.status, Status::Finished);
            assert_eq!(run.statistics.events, 2, "{method:?} {kind:?}");
            let shut = run.bounds.valve_shut_s.unwrap();
            assert!((200.0..215.0).contains(&shut), "{shut}");
            assert!(run.flow_m3_s.iter().all(|&q| q >= 0.0));
            assert!(run.flow_m3_s[220..500].iter().all(|&q| q == 0.0));
            assert!(run.flow_m3_s[600] > 0.03);
            // The standing riser fills with what flows in.
            let fill = (run.level_m[480] - run.level_m[220]) * line().riser_area_m2 / 260.0;
            assert!((fill + 0.01).abs() < 1e-9, "{fill}");
            assert!(run.statistics.steps < 4000, "{:?}", run.statistics);
            ends.push((run.level_m[900], run.flow_m3_s[900]));
        }
        assert!(
            (ends[0].0 - ends[1].0).abs() < 1e-4 && (ends[0].1 - ends[1].1).abs() < 1e-6,
            "{ends:?}"
        );
    }
}

#[test]
fn without_a_valve_the_line_runs_back() {
    let (time, inflow, speed) = stop_and_restart();
    let (u, w) = (linear(&time, &inflow), linear(&time, &speed));
    let mut line = line();
    line.non_return_valve = false;
    for method in METHODS {
        let run =
            simulate_coupled(&line, START, &u, &w, &time[..=400], &options(method, 1e-6)).unwrap();
        assert_eq!(run.status, Status::Finished);
        assert!(run.flow_m3_s[240] < -0.03, "{}", run.flow_m3_s[240]);
    }
}

#[test]
fn an_overfed_riser_overflows_and_an_overdrawn_one_runs_empty() {
    let t: Vec<f64> = (0..=4000).map(f64::from).collect();
    let full = |t: &f64| if *t < 2000.0 { 0.2 } else { 0.0 };
    for method in METHODS {
        let inflow: Vec<f64> = t.iter().map(full).collect();
        let still = vec![0.0; t.len()];
        let o = options(method, 1e-6);
        let start = LineState {
            level_m: 140.0,
            flow_m3_s: 0.0,
        };
        let (u, w) = (linear(&t, &inflow), linear(&t, &still));
        let run = simulate_coupled(&line(), start, &u, &w, &t, &o).unwrap();
        assert_eq!(run.status, Status::Finished);
        let expected = 140.0 * line().riser_area_m2 / 0.2;
        assert!((run.bounds.full_s.unwrap() - expected).abs() < 1e-6);
        assert_eq!(run.level_m[1500], 0.0);
        assert_eq!(run.bounds.empty_s, None);

        // A pump far too strong empties it; then inflow alone refills it once the pump stops.
        let inflow: Vec<f64> = t
            .iter()
            .map(|t| if *t < 3000.0 { 0.0 } else { 0.05 })
            .collect();
        let speed: Vec<f64> = t
            .iter()
            .map(|t| if *t < 2990.0 { 100.0 } else { 0.0 })
            .collect();
        let (u, w) = (linear(&t, &inflow), linear(&t, &speed));
        let run = simulate_coupled(&line(), START, &u, &w, &t, &o).unwrap();
        assert_eq!(run.status, Status::Finished);
        let empty = run.bounds.empty_s.unwrap();
        assert!(empty > 100.0 && empty < 2000.0, "{empty}");
        assert_eq!(run.level_m[2900], line().inlet_depth_m);
        assert!(run.level_m[4000] < line().inlet_depth_m - 100.0);
        assert!(
            run.level_m
                .iter()
                .chain(&run.flow_m3_s)
                .all(|x| x.is_finite())
        );
        assert!(
            run.level_m
                .iter()
                .all(|h| (0.0..=line().inlet_depth_m).contains(h))
        );
    }
}

#[test]
fn momentum_balances_when_inlet_and_outlet_lie_at_different_depths() {
    let mut line = line();
    line.outlet_depth_m = 330.0;
    let (h, w, q) = (120.0, 58.0, 0.04);
    let rho_g = line.density_kg_m3 * GRAVITY_M_S2;
    // (P_in + ρ·g·H − p0 − F − ρ·g·h_out), written out.
    let head = line.pump.c0 * w_power(w, line.pump.n0)
        - line.pump.c1 * w * q
        - line.pump.c2 * w_power(q, line.pump.n2);
    let f = line.friction.b_pa
        + line.friction.c_pa_s_m3 * q
        + line.friction.d_pa_s2_m6 * q * q
        + line.friction.e_pa_s3_m9 * q * q * q;
    let by_hand = line.inlet_pressure_pa(h) + rho_g * head - ATMOSPHERE_PA - f - rho_g * 330.0;
    assert!((line.drive_pa(h, w, q) - by_hand).abs() < 1e-6 * by_hand.abs());
    let m = 1080.0 * (350.3 - h) / line.riser_area_m2 + 1080.0 * 330.0 / line.line_area_m2;
    assert!((line.inertia_kg_m4(h) / m - 1.0).abs() < 1e-14);

    // The simulated acceleration over a short while is drive over inertia.
    let t = [0.0, 1e-4];
    let (u, ws) = ([q; 2], [w; 2]);
    let start = LineState {
        level_m: h,
        flow_m3_s: q,
    };
    let run = simulate_coupled(
        &line,
        start,
        &linear(&t, &u),
        &linear(&t, &ws),
        &t,
        &options(Method::Rodasp, 1e-9),
    )
    .unwrap();
    let found = (run.flow_m3_s[1] - q) / 1e-4;
    assert!(
        (found / (by_hand / m) - 1.0).abs() < 1e-3,
        "{found} against {}",
        by_hand / m
    );
}

fn w_power(x: f64, n: f64) -> f64 {
    (n * x.ln()).exp()
}

#[test]
fn an_offset_b_leaves_the_flow_alone() {
    let (time, inflow, speed) = kinked_inputs(60);
    let (u, w) = (linear(&time, &inflow), linear(&time, &speed));
    let go = |b_pa, b_is_offset| {
        let mut line = line();
        line.friction.b_pa = b_pa;
        line.b_is_offset = b_is_offset;
        simulate_coupled(&line, START, &u, &w, &time, &options(Method::Rodasp, 1e-6))
            .unwrap()
            .flow_m3_s
    };
    assert_eq!(go(0.0, false), go(5e4, true));
    assert!(farthest(&go(0.0, false), &go(5e4, false)) > 1e-4);
}

#[test]
fn an_offset_b_drives_nothing() {
    let (mut none, mut offset) = (line(), line());
    none.friction.b_pa = 0.0;
    offset.b_is_offset = true;
    let drive = |line: &ReturnLine| line.drive_pa(140.0, 62.0, 0.05);
    // Of columns of 4 MPa, to round-off.
    assert!((drive(&offset) - drive(&none)).abs() < 1e-8);
    let b_pa = line().friction.b_pa;
    assert!((drive(&line()) + b_pa - drive(&none)).abs() < 1e-8);
}

#[test]
fn reversing_the_flow_reverses_the_friction() {
    let f = line().friction;
    for q in [0.001, 0.03, 0.07] {
        let (plus, minus) = (f.loss_pa(q) - f.b_pa, f.loss_pa(-q) - f.b_pa);
        assert!((plus + minus).abs() < 1e-9 * plus.abs().max(1.0));
        assert_eq!(f.slope_pa_s_m3(q), f.slope_pa_s_m3(-q));
        let d = 1e-6;
        let numeric = (f.loss_pa(q + d) - f.loss_pa(q - d)) / (2.0 * d);
        assert!((f.slope_pa_s_m3(q) / numeric - 1.0).abs() < 1e-6);
    }
}

#[test]
fn level_and_inlet_pressure_are_inverse() {
    for h in [0.0, 75.5, 350.3] {
        let back = line().level_from_inlet_pressure(line().inlet_pressure_pa(h));
        assert!((back - h).abs() < 1e-12 * 350.0);
    }
    assert!((line().inlet_pressure_pa(line().inlet_depth_m) - ATMOSPHERE_PA).abs() < 1e-9);
}

#[test]
fn outputs_belong_to_the_states() {
    let line = line();
    let steady = dgd_dynamics::return_line::steady_flow(&line, 130.0, 61.0)
        .unwrap()
        .0;
    let (h, q, w) = ([130.0; 2], [steady, 0.9 * steady], [61.0; 2]);
    let plain = derive_outputs(&line, &h, &q, &w, false).unwrap();
    let with = derive_outputs(&line, &h, &q, &w, true).unwrap();
    // In steady flow the pump makes the whole difference; the inertia adds nothing.
    let rise = line.density_kg_m3 * GRAVITY_M_S2 * plain.head_m[0];
    assert!((plain.outlet_pa[0] - plain.inlet_pa[0] - rise).abs() < 1e-3);
    assert!((with.outlet_pa[0] - plain.outlet_pa[0]).abs() < 1e-3);
    // Off balance, inlet column and discharge line share the drive by their inertias.
    let drive = line.drive_pa(h[1], w[1], q[1]);
    let share =
        line.density_kg_m3 * line.outlet_depth_m / line.line_area_m2 / line.inertia_kg_m4(h[1]);
    assert!((with.outlet_pa[1] - plain.outlet_pa[1] - share * drive).abs() < 1e-6 * drive);
}

#[test]
fn a_late_meter_shows_the_flow_of_before() {
    let time: Vec<f64> = (0..20).map(f64::from).collect();
    let flow: Vec<f64> = time.iter().map(|t| 0.01 * t).collect();
    let shown = measured_flow(&time, &flow, 2.5).unwrap();
    for (t, q) in time.iter().zip(&shown) {
        assert!((q - 0.01 * (t - 2.5).max(0.0)).abs() < 1e-15);
    }
    assert_eq!(measured_flow(&time, &flow, 0.0).unwrap(), flow);
}

#[test]
fn later_clocks_give_the_same_run() {
    // The model does not know the time of day: 300,000 s later nothing changes but round-off.
    let (time, inflow, speed) = kinked_inputs(200);
    let later: Vec<f64> = time.iter().map(|t| t + 300_000.0).collect();
    let go = |time: &[f64]| {
        simulate_coupled(
            &line(),
            START,
            &linear(time, &inflow),
            &linear(time, &speed),
            time,
            &options(Method::Rodasp, 1e-6),
        )
        .unwrap()
    };
    assert!(farthest(&go(&time).flow_m3_s, &go(&later).flow_m3_s) < 1e-12);
}

#[test]
fn the_linear_model_is_the_slope_of_the_non_linear_one() {
    for (h, q, w) in [
        (140.0, 0.05, 62.0),
        (20.0, 0.001, 0.0),
        (200.0, -0.02, 40.0),
    ] {
        let line = line();
        let linear = linearise(
            &line,
            LineState {
                level_m: h,
                flow_m3_s: q,
            },
            w,
        )
        .unwrap();
        let rate = |h: f64, q: f64, w: f64| line.drive_pa(h, w, q) / line.inertia_kg_m4(h);
        let close = |found: f64, low: f64, high: f64, by: f64| {
            let expected = (high - low) / by;
            assert!(
                (found - expected).abs() < 2e-4 * expected.abs() + 1e-7,
                "{found} against {expected}"
            );
        };
        close(
            linear.a[1][0],
            rate(h - 1e-3, q, w),
            rate(h + 1e-3, q, w),
            2e-3,
        );
        close(
            linear.a[1][1],
            rate(h, q - 1e-6, w),
            rate(h, q + 1e-6, w),
            2e-6,
        );
        // One-sided: the speed has no value below zero.
        close(linear.b[1][1], rate(h, q, w), rate(h, q, w + 1e-5), 1e-5);
        assert_eq!(linear.a[0], [0.0, 1.0 / line.riser_area_m2]);
        assert_eq!(linear.b[0], [-1.0 / line.riser_area_m2, 0.0]);
        close(
            linear.c[0][0],
            line.inlet_pressure_pa(h - 1.0),
            line.inlet_pressure_pa(h + 1.0),
            2.0,
        );
        close(
            linear.c[1][1],
            line.outlet_pressure_pa(q - 1e-6),
            line.outlet_pressure_pa(q + 1e-6),
            2e-6,
        );
    }
    // At standstill only the linear terms resist.
    let still = linearise(
        &line(),
        LineState {
            level_m: 140.0,
            flow_m3_s: 0.0,
        },
        50.0,
    )
    .unwrap();
    let resistance = line().friction.c_pa_s_m3 + 1080.0 * GRAVITY_M_S2 * line().pump.c1 * 50.0;
    assert!((still.a[1][1] * line().inertia_kg_m4(140.0) / -resistance - 1.0).abs() < 1e-12);
    // The flow follows in the time of its inertia over its resistance.
    let constant = line().inertia_kg_m4(140.0) / resistance;
    assert!((still.flow_time_constant_s() / constant - 1.0).abs() < 1e-12);
    let at = linearise(&line(), START, 62.0)
        .unwrap()
        .flow_time_constant_s();
    assert!(at > 0.2 && at < 2.0, "{at} s");
}

#[test]
fn a_shut_valve_keeps_the_inertia_out_of_the_outlet_pressure_and_an_open_one_does_not() {
    let valve = line();
    let mut open = line();
    open.non_return_valve = false;
    let outlet = |line: &_, h: f64, q: f64, w: f64, with: bool| {
        derive_outputs(line, &[h], &[q], &[w], with)
            .unwrap()
            .outlet_pa[0]
    };
    let inertia = |line: &_, h, q, w| outlet(line, h, q, w, true) - outlet(line, h, q, w, false);
    // At a standstill without the pump the columns push back.
    assert!(valve.drive_pa(140.0, 0.0, 0.0) < 0.0);
    assert_eq!(inertia(&valve, 140.0, 0.0, 0.0), 0.0);
    let share = valve.density_kg_m3 * valve.outlet_depth_m / valve.line_area_m2;
    let expected =
        |h: f64, q: f64, w: f64| share * valve.drive_pa(h, w, q) / valve.inertia_kg_m4(h);
    for (line, h, q, w) in [
        (&open, 140.0, 0.0, 0.0),
        (&open, 140.0, -0.01, 0.0),
        // It opens: the pump overcomes the columns.
        (&valve, 140.0, 0.0, 80.0),
        // It still runs forward while it is slowed down.
        (&valve, 140.0, 0.03, 0.0),
    ] {
        let (found, expected) = (inertia(line, h, q, w), expected(h, q, w));
        assert!(expected.abs() > 1e4, "no test at {expected} Pa");
        // Of pressures of 4 MPa, to round-off.
        assert!((found - expected).abs() < 1e-6, "{found} {expected}");
    }
}

#[test]
fn below_the_inlet_no_column_of_the_riser_moves() {
    let line = line();
    let discharge = line.density_kg_m3 * line.outlet_depth_m / line.line_area_m2;
    for below in [0.0, 5.0] {
        let found = line.inertia_kg_m4(line.inlet_depth_m + below);
        assert!((found / discharge - 1.0).abs() < 1e-15);
    }
    let at = |level_m: f64| {
        let state = LineState {
            level_m,
            flow_m3_s: 0.05,
        };
        linearise(&line, state, 62.0).unwrap().a[1][0] * discharge
    };
    // There only the weight of the level drives, and above it the column takes a share.
    let rho_g = line.density_kg_m3 * GRAVITY_M_S2;
    assert!((at(line.inlet_depth_m + 1.0) / -rho_g - 1.0).abs() < 1e-12);
    assert!((at(line.inlet_depth_m - 250.0) / -rho_g - 1.0).abs() > 5e-2);
}

#[test]
fn at_rest_the_outlet_carries_its_column_and_in_flow_the_friction_too() {
    let mut line = line();
    line.outlet_depth_m = 330.0;
    let column = ATMOSPHERE_PA + line.density_kg_m3 * GRAVITY_M_S2 * 330.0;
    for q in [0.0, 0.05, -0.02] {
        let expected = column + line.friction.loss_pa(q);
        assert!((line.outlet_pressure_pa(q) / expected - 1.0).abs() < 1e-15);
        let derived = derive_outputs(&line, &[140.0], &[q], &[60.0], false).unwrap();
        assert!((derived.outlet_pa[0] / expected - 1.0).abs() < 1e-15);
    }
    assert_eq!(line.outlet_pressure_pa(0.0), column + line.friction.b_pa);
}
