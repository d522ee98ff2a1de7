//! The coupled model written a second time and solved by an independent crate.

use diffsol::{NalgebraLU, NalgebraMat, OdeBuilder, OdeSolverMethod, OdeSolverStopReason};

use dgd_dynamics::return_line::{LineState, simulate_coupled};

use crate::common::{METHODS, kinked_inputs, line, linear, options};

#[test]
fn the_coupled_model_with_kinks_agrees_with_an_independent_solver() {
    let seconds = 120;
    let (time, inflow, speed) = kinked_inputs(seconds);
    let l = line();
    let start = LineState {
        level_m: 140.0,
        flow_m3_s: 0.05,
    };
    let between = |v: &[f64], t: f64| {
        let k = time.partition_point(|&s| s <= t).clamp(1, time.len() - 1) - 1;
        v[k] + (v[k + 1] - v[k]) * (t - time[k])
    };
    let rho_g = 1080.0 * 9.80665;
    let inertia = |h: f64| 1080.0 * ((350.3 - h) / l.riser_area_m2 + 350.3 / l.line_area_m2);
    let drive = |t: f64, h: f64, q: f64| {
        let w = between(&speed, t);
        let head =
            l.pump.c0 * w.powf(l.pump.n0) - l.pump.c1 * w * q - l.pump.c2 * q.powf(l.pump.n2);
        let f = l.friction;
        rho_g * (head - h)
            - (f.b_pa + f.c_pa_s_m3 * q + f.d_pa_s2_m6 * q * q + f.e_pa_s3_m9 * q.powi(3))
    };
    let problem = OdeBuilder::<NalgebraMat<f64>>::new()
        .rtol(1e-9)
        .atol([1e-9, 1e-12])
        .rhs_implicit(
            |x: &[f64], _p: &[f64], t: f64, y: &mut [f64]| {
                y[0] = (x[1] - between(&inflow, t)) / l.riser_area_m2;
                y[1] = drive(t, x[0], x[1]) / inertia(x[0]);
            },
            |x: &[f64], _p: &[f64], t: f64, v: &[f64], y: &mut [f64]| {
                let (q, w, f) = (x[1], between(&speed, t), l.friction);
                let by_flow = -rho_g
                    * (l.pump.c1 * w + l.pump.c2 * l.pump.n2 * q.powf(l.pump.n2 - 1.0))
                    - (f.c_pa_s_m3 + 2.0 * f.d_pa_s2_m6 * q + 3.0 * f.e_pa_s3_m9 * q * q);
                let m = inertia(x[0]);
                let by_level = (drive(t, x[0], q) * 1080.0 / l.riser_area_m2 / m - rho_g) / m;
                y[0] = v[1] / l.riser_area_m2;
                y[1] = by_level * v[0] + by_flow / m * v[1];
            },
        )
        .init(
            |_p: &[f64], _t: f64, y: &mut [f64]| {
                y[0] = start.level_m;
                y[1] = start.flow_m3_s;
            },
            2,
        )
        .build()
        .unwrap();
    let mut solver = problem.esdirk34::<NalgebraLU<f64>>().unwrap();
    let mut expected = vec![[start.level_m, start.flow_m3_s]];
    for &stop in &time[1..] {
        solver.set_stop_time(stop).unwrap();
        while !matches!(solver.step().unwrap(), OdeSolverStopReason::TstopReached) {}
        let y = solver.state().y;
        expected.push([y[0], y[1]]);
    }
    for method in METHODS {
        let run = simulate_coupled(
            &l,
            start,
            &linear(&time, &inflow),
            &linear(&time, &speed),
            &time,
            &options(method, 1e-10),
        )
        .unwrap();
        for (k, e) in expected.iter().enumerate() {
            assert!(
                (run.level_m[k] - e[0]).abs() < 1e-6,
                "{method:?} level at {k}: {} against {}",
                run.level_m[k],
                e[0]
            );
            assert!(
                (run.flow_m3_s[k] - e[1]).abs() < 1e-7,
                "{method:?} flow at {k}: {} against {}",
                run.flow_m3_s[k],
                e[1]
            );
        }
    }
}
