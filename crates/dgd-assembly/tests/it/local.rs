//! Sensitivities, steady states, linear models and identifiability.

use crate::common::{PUMP_LOOP, RETURN_LINE, TWO_TANKS, clock, steps, window};
use dgd_assembly::{
    Assembly, FitOptions, RunStatus, Sensitivities, SimulationOptions, Window, identifiability,
    linearise, profile, sensitivities, sensitivities_variational, steady_state,
};
use dgd_dynamics::integrate::Method;

fn tight() -> SimulationOptions {
    SimulationOptions {
        relative: 1e-9,
        ..Default::default()
    }
}

fn agree(a: &Sensitivities, b: &Sensitivities, share: f64) {
    assert_eq!(
        (a.status, b.status),
        (RunStatus::Finished, RunStatus::Finished)
    );
    for (p, (one, two)) in a.values.iter().zip(&b.values).enumerate() {
        for (m, (one, two)) in one.iter().zip(two).enumerate() {
            // What is truly zero shows the integrator's noise in the differences of runs.
            let size = two
                .iter()
                .fold(1e-3 * a.size[m] / a.range[p], |s: f64, v| s.max(v.abs()));
            let off = crate::common::apart(one, two);
            assert!(
                off < share * size,
                "{} of {}: {off} of {size}",
                a.outputs[m],
                a.parameters[p]
            );
        }
    }
}

fn cascade(high: f64) -> (Assembly, Window) {
    let assembly = Assembly::parse(TWO_TANKS).unwrap();
    let u = steps(300, 20, 2.0, high);
    let window = window(&assembly, &[("u", &u)]);
    (assembly, window)
}

#[test]
fn differences_of_runs_and_variational_equations_agree() {
    let (assembly, window) = cascade(5.0);
    let theta = assembly.start();
    let by_runs = sensitivities(&assembly, &theta, &window, 0, &tight()).unwrap();
    for method in [Method::DormandPrince, Method::Rodasp] {
        let by_equations = sensitivities_variational(
            &assembly,
            &theta,
            &window,
            0,
            &SimulationOptions { method, ..tight() },
        )
        .unwrap();
        agree(&by_runs, &by_equations, 1e-4);
    }
    assert_eq!(by_runs.parameters.len(), 4);
    assert!(by_runs.importance().iter().all(|i| *i > 1e-3));
}

#[test]
fn they_agree_across_overflow_too() {
    let (base, window) = cascade(14.0);
    let assembly = base
        .with_effect("upper", "overflow_caught", &["share"])
        .unwrap();
    let theta = assembly.start();
    let by_runs = sensitivities(&assembly, &theta, &window, 0, &tight()).unwrap();
    let by_equations = sensitivities_variational(
        &assembly,
        &theta,
        &window,
        0,
        &SimulationOptions {
            method: Method::DormandPrince,
            ..tight()
        },
    )
    .unwrap();
    agree(&by_runs, &by_equations, 2e-3);
}

#[test]
fn the_cascade_rests_where_pump_and_outlets_balance() {
    let (assembly, _) = cascade(5.0);
    let theta = assembly.start();
    let steady = steady_state(&assembly, &theta, &[4.0], &[0.1, 0.1]).unwrap();
    assert!(steady.found, "{steady:?}");
    let flow = 4.0 * 2e-5;
    let level =
        |coefficient: f64, area: f64| (flow / (coefficient * area)).powi(2) / (2.0 * 9.80665);
    // States go by name: lower, upper. The square law is rounded off below 0.01 Pa, felt at 600 Pa by 0.005/600.
    assert!(
        (steady.state[0] / level(0.6, 1.2e-4) - 1.0).abs() < 2e-5,
        "{steady:?}"
    );
    assert!((steady.state[1] / level(0.6, 1e-4) - 1.0).abs() < 2e-5);
}

#[test]
fn a_tank_that_nothing_regulates_has_no_steady_state() {
    let text = r#"
        connections = ["feed -> tank", "tank -> pump -> atmosphere"]
        [components]
        feed = { kind = "boundary", flow = 2e-3 }
        pump = { kind = "displacement_pump", input = 1.0, coefficient = 1e-3 }
        tank = { kind = "tank", area = 1.0 }
        [initial]
        "tank.level" = 1.0
    "#;
    let assembly = Assembly::parse(text).unwrap();
    assert!(!steady_state(&assembly, &[], &[], &[1.0]).unwrap().found);
    // Nor has one that fills to its brim and spills there.
    let spilling = text.replace("area = 1.0 }", "area = 1.0, brim = 3.0 }");
    let assembly = Assembly::parse(&spilling).unwrap();
    let steady = steady_state(&assembly, &[], &[], &[1.0]).unwrap();
    assert!(!steady.found, "{steady:?}");
    // Nor one whose outlet would let as much go at a level above the brim.
    let regulated = |brim: f64| {
        let text = format!(
            r#"connections = ["feed -> tank -> outlet -> atmosphere"]
            [components]
            feed = {{ kind = "boundary", flow = 2e-3 }}
            outlet = {{ kind = "orifice", area = 3e-4, discharge_coefficient = 0.6 }}
            tank = {{ kind = "tank", area = 1.0, brim = {brim} }}
            [initial]
            "tank.level" = 1.0
        "#
        );
        steady_state(&Assembly::parse(&text).unwrap(), &[], &[], &[1.0]).unwrap()
    };
    let (free, spilling) = (regulated(20.0), regulated(5.0));
    assert!(free.found && free.state[0] > 5.0, "{free:?}");
    assert!(!spilling.found, "{spilling:?}");
}

#[test]
fn the_linear_return_line_is_that_of_dgd_dynamics() {
    use dgd_dynamics::return_line as known;
    let assembly = Assembly::parse(RETURN_LINE).unwrap();
    let line = known::ReturnLine {
        density_kg_m3: 1080.0,
        riser_area_m2: 0.17044,
        line_area_m2: 0.018_241,
        inlet_depth_m: 350.3,
        outlet_depth_m: 350.3,
        friction: known::Friction {
            b_pa: 12_650.0,
            c_pa_s_m3: 2e5,
            d_pa_s2_m6: 1.28e8,
            e_pa_s3_m9: -2.3e8,
        },
        pump: known::PumpHead {
            c0: 0.068_78,
            c1: 0.05,
            c2: 8926.0,
            n0: 1.9546,
            n2: 1.6243,
        },
        non_return_valve: true,
        b_is_offset: false,
    };
    let expected = known::linearise(
        &line,
        known::LineState {
            level_m: 140.0,
            flow_m3_s: 0.05,
        },
        62.0,
    )
    .unwrap();
    let found = linearise(&assembly, &[], &[210.3, 0.05], &[0.05, 62.0]).unwrap();
    // The level is counted upwards here: its row and column change their sign.
    let sign = [-1.0, 1.0];
    for i in 0..2 {
        for j in 0..2 {
            let a = expected.a[i][j] * sign[i] * sign[j];
            assert!(
                (found.a[i * 2 + j] - a).abs() <= 1e-6 * a.abs().max(1e-9),
                "a[{i}][{j}] {} {a}",
                found.a[i * 2 + j]
            );
            let b = expected.b[i][j] * sign[i];
            assert!(
                (found.b[i * 2 + j] - b).abs() <= 1e-6 * b.abs().max(1e-9),
                "b[{i}][{j}]"
            );
        }
    }
    let constants = found.time_constants();
    assert!(
        constants.iter().all(|t| *t > 0.0) && constants[0] > constants[1],
        "{constants:?}"
    );
}

#[test]
fn the_discrete_model_is_the_run_of_a_linear_system_with_held_inputs() {
    // A tank that drains through a laminar line is linear, and known in closed form.
    let text = r#"
        connections = ["feed -> tank -> line -> atmosphere"]
        [components]
        feed = { kind = "boundary", flow = 0.0 }
        tank = { kind = "tank", area = 2.0 }
        line = { kind = "line", linear = 1e6 }
        gauge = { kind = "instrument", measures = "level", of = "tank" }
        flow = { kind = "instrument", measures = "flow", of = "line" }
        [inputs]
        "feed.flow" = { channel = "q", between = "held" }
        [initial]
        "tank.level" = 1.0
    "#;
    let text = text.replace(
        "\"feed -> tank -> line -> atmosphere\"",
        "\"feed -> tank\", \"tank -> line -> atmosphere\"",
    );
    let assembly = Assembly::parse(&text).unwrap();
    let linear = linearise(&assembly, &[], &[1.0], &[1e-3]).unwrap();
    let pole = -1000.0 * 9.80665 / 1e6 / 2.0;
    assert!((linear.poles()[0].0 / pole - 1.0).abs() < 1e-7);
    let h = 30.0;
    let discrete = linear.discrete(h).unwrap();
    assert!((discrete.a[0] - (pole * h).exp()).abs() < 1e-8);
    assert!((discrete.b[0] - ((pole * h).exp() - 1.0) / pole / 2.0).abs() < 1e-6);
    assert!((discrete.time_constants()[0] + 1.0 / pole).abs() < 1e-4);
    assert!((linear.c[1] - 0.0098_0665).abs() < 1e-9 || (linear.c[0] - 0.0098_0665).abs() < 1e-9);
    assert!(discrete.discrete(h).is_err() && linear.discrete(0.0).is_err());
}

#[test]
fn a_gain_and_an_area_that_stand_in_for_each_other_are_named() {
    let text = TWO_TANKS.replace(
        "[free]",
        "[free]\n\"upper_outlet.area\" = { start = 1e-4, low = 5e-5, high = 2e-4 }",
    );
    let assembly = Assembly::parse(&text).unwrap();
    let u = steps(200, 20, 2.0, 5.0);
    let window = window(&assembly, &[("u", &u)]);
    let found =
        identifiability(&[
            sensitivities(&assembly, &assembly.start(), &window, 0, &tight()).unwrap(),
        ])
        .unwrap();
    assert_eq!(found.rank, 4, "{found:?}");
    let names: Vec<&str> = found.near_null[0]
        .shares
        .iter()
        .map(|s| s.0.as_str())
        .collect();
    assert!(
        names.contains(&"upper_outlet.area")
            && names.contains(&"upper_outlet.discharge_coefficient"),
        "{names:?}"
    );
    assert!(found.pairs[0].2 > 1e3 && found.collinearity > 1e3);
    let (apart, window) = cascade(5.0);
    let apart =
        identifiability(&[sensitivities(&apart, &apart.start(), &window, 0, &tight()).unwrap()])
            .unwrap();
    assert!(
        apart.collinearity < 0.01 * found.collinearity && apart.near_null.is_empty(),
        "{apart:?}"
    );
}

#[test]
fn the_profile_of_a_told_parameter_has_its_minimum_at_the_truth() {
    let (assembly, mut window) = cascade(5.0);
    let theta = assembly.start();
    window.readings = assembly
        .simulate(&theta, &window, 0, &tight())
        .unwrap()
        .outputs;
    let path = "pump.coefficient";
    let points = profile(
        &assembly,
        &[window],
        &FitOptions::default(),
        path,
        &[1.8e-5, 2e-5, 2.2e-5],
    )
    .unwrap();
    assert!(
        points[1].cost < 1e-6 * points[0].cost.min(points[2].cost),
        "{points:?}"
    );
}

#[test]
fn sensitivities_of_the_heavy_loop_agree_with_the_implicit_method() {
    let assembly = Assembly::parse(PUMP_LOOP).unwrap();
    let t = clock(60, 1.0);
    let w = steps(60, 10, 50.0, 90.0);
    let z = vec![1.0; 60];
    let window = window(&assembly, &[("t", &t), ("w", &w), ("z", &z)]);
    let theta = assembly.start();
    let by_runs = sensitivities(&assembly, &theta, &window, 0, &tight()).unwrap();
    let by_equations = sensitivities_variational(
        &assembly,
        &theta,
        &window,
        0,
        &SimulationOptions {
            relative: 1e-8,
            ..tight()
        },
    )
    .unwrap();
    agree(&by_runs, &by_equations, 2e-3);
}

#[test]
fn what_returns_all_it_receives_is_an_integrator_though_its_pole_is_rounded() {
    // A pump loop between two tanks, as it was linearised.
    let a = vec![
        -0.005_171_749_856_075_392,
        0.0,
        3.595_707_210_264_402_8,
        0.000_387_881_239_253_778_05,
        0.0,
        -0.269_678_040_820_017_8,
        0.0,
        0.001_026_949_987_079_203_4,
        -10.666_853_015_950_377,
    ];
    let linear = dgd_assembly::Linear {
        states: ["header.level", "sump.level", "riser.flow"]
            .map(String::from)
            .to_vec(),
        inputs: Vec::new(),
        outputs: Vec::new(),
        a,
        b: Vec::new(),
        c: Vec::new(),
        d: Vec::new(),
        step_s: None,
        rates: vec![0.0; 3],
    };
    assert_eq!(linear.poles()[0], (0.0, 0.0));
    let discrete = linear.discrete(1.0).unwrap();
    for model in [&linear, &discrete] {
        let constants = model.time_constants();
        assert_eq!(constants[0], f64::INFINITY, "{constants:?}");
        assert!((constants[1] - 192.39).abs() < 0.01, "{constants:?}");
    }
}
