//! Components against independent arithmetic.

use crate::common::{TWO_TANKS, apart, clock, steps, window};
use dgd_assembly::{Assembly, RunStatus, SimulationOptions, Simulator, steady_state};

fn tight() -> SimulationOptions {
    SimulationOptions {
        relative: 1e-8,
        ..Default::default()
    }
}

#[test]
fn the_spilling_cascade_is_that_of_a_small_step_euler_code() {
    let assembly = Assembly::parse(TWO_TANKS)
        .unwrap()
        .with_effect("upper", "overflow_caught", &["share"])
        .unwrap();
    let u = steps(200, 20, 2.0, 14.0);
    let window = window(&assembly, &[("u", &u)]);
    let mut theta = assembly.start();
    let at = |path: &str| {
        assembly
            .parameters()
            .iter()
            .position(|p| p.path == path)
            .unwrap()
    };
    theta[at("upper.overflow_caught.share")] = 0.4;
    let run = assembly.simulate(&theta, &window, 0, &tight()).unwrap();
    assert!(run.held.len() == 1 || run.held.len() == 2, "{:?}", run.held);
    let (mut upper, mut lower) = (0.1_f64, 0.1_f64);
    let (mut all_upper, mut all_lower) = (Vec::new(), Vec::new());
    let fine = 20_000;
    let dt = 4.0 / f64::from(fine);
    for u in &u {
        all_upper.push(upper);
        all_lower.push(lower);
        for _ in 0..fine {
            let q_in = 2e-5 * u;
            let q1 = 0.6 * 1e-4 * (2.0 * 9.80665 * upper).sqrt();
            let q2 = 0.6 * 1.2e-4 * (2.0 * 9.80665 * lower).sqrt();
            upper += dt * (q_in - q1) / 0.02;
            let spilled = (upper - 0.4).max(0.0) * 0.02;
            upper = upper.min(0.4);
            lower = (lower + dt * (q1 - q2) / 0.02 + 0.4 * spilled / 0.02).min(0.4);
        }
    }
    assert!(
        apart(&run.states[1], &all_upper) < 2e-5,
        "{}",
        apart(&run.states[1], &all_upper)
    );
    assert!(
        apart(&run.states[0], &all_lower) < 2e-5,
        "{}",
        apart(&run.states[0], &all_lower)
    );
}

#[test]
fn a_closed_tank_stops_filling_where_its_gas_balances_the_feed() {
    let text = r#"
        connections = ["main -> valve -> tank.outlet"]
        [components]
        main = { kind = "boundary", pressure = "4 bar" }
        valve = { kind = "valve", flow_coefficient = 1e-5 }
        tank = { kind = "tank", area = 0.5, gas_volume = 1.0 }
        p = { kind = "instrument", measures = "pressure", of = "tank" }
        [initial]
        "tank.level" = 0.0
    "#;
    let assembly = Assembly::parse(text).unwrap();
    let steady = steady_state(&assembly, &[], &[], &[0.1]).unwrap();
    let h = steady.state[0];
    assert!(
        steady.found && (steady.outputs[0] - 4e5).abs() < 1.0,
        "{steady:?}"
    );
    assert!((101_325.0 / (1.0 - 0.5 * h) + 9806.65 * h - 4e5).abs() < 1.0);
}

#[test]
fn the_gas_of_a_closed_tank_is_what_its_profile_leaves() {
    let text = r#"
        connections = ["main -> valve -> tank.outlet"]
        [components]
        main = { kind = "boundary", pressure = "4 bar" }
        valve = { kind = "valve", flow_coefficient = 1e-5 }
        tank = { kind = "tank", area_profile = [[-1.0, 0.2], [0.5, 0.5], [1.0, 0.4]], gas_volume = 1.0 }
        p = { kind = "instrument", measures = "pressure", of = "tank" }
        [initial]
        "tank.level" = 0.0
    "#;
    let assembly = Assembly::parse(text).unwrap();
    let steady = steady_state(&assembly, &[], &[], &[0.1]).unwrap();
    let h = steady.state[0];
    assert!(steady.found && h > 1.0, "{steady:?}");
    // Area 0.4 m2 at level 0: two trapezia, and a prism above.
    let filled = 0.5 * 0.5 * (0.4 + 0.5) + 0.5 * 0.5 * (0.5 + 0.4) + 0.4 * (h - 1.0);
    let balance = 101_325.0 / (1.0 - filled) + 9806.65 * h - 4e5;
    assert!(balance.abs() < 1.0, "{balance}");
}

/// A stiff header behind a pump, whose valve moves after rests of half a minute: the steps are as long, and what lies within them is right too.
#[test]
fn samples_within_long_steps_behind_a_move_of_a_valve_are_right() {
    let text = r#"
        connections = ["supply -> pump -> header -> valve -> atmosphere"]
        [components]
        supply = { kind = "boundary", pressure = "0.3 barg" }
        pump = { kind = "centrifugal_pump", c0 = 0.004, c2 = 3e5, check_valve = true }
        header = { kind = "volume", volume = 0.05, bulk_modulus = 2e7 }
        valve = { kind = "valve", flow_coefficient = 4e-6 }
        p = { kind = "instrument", measures = "pressure", of = "header" }
        [inputs]
        "pump.speed" = { channel = "n", between = "held", unit = "%" }
        "valve.opening" = { channel = "z", between = "held", unit = "%" }
        [initial]
        "header.pressure" = 3e5
        [record]
        time = "t"
    "#;
    let assembly = Assembly::parse(text).unwrap();
    let t = clock(121, 1.0);
    let opening: Vec<f64> = t
        .iter()
        .map(|t| match *t {
            t if t < 30.0 => 80.0,
            t if t < 60.0 => 78.0,
            _ => 79.0,
        })
        .collect();
    let window = window(
        &assembly,
        &[("t", &t), ("n", &[72.0; 121]), ("z", &opening)],
    );
    let pressures = |options: &SimulationOptions| {
        let run = assembly.simulate(&[], &window, 0, options).unwrap();
        run.outputs[0].clone()
    };
    let (usual, tight) = (
        pressures(&SimulationOptions::default()),
        pressures(&tight()),
    );
    // Four times a tolerance of 1e-5 of the pressure and of a tenth of the usual one.
    let off = apart(&usual, &tight);
    assert!(off < 4.0 * 1e-5 * 1.1 * 3.3e5, "{off} Pa");
}

#[test]
fn an_area_that_is_off_is_that_of_a_tank_of_the_true_one() {
    let of = |area: f64| {
        let text = format!(
            r#"
            connections = ["feed -> tank -> outlet -> atmosphere"]
            [components]
            feed = {{ kind = "boundary", flow = "1 l/s" }}
            tank = {{ kind = "tank", area = {area} }}
            outlet = {{ kind = "orifice", discharge_coefficient = 0.6, area = 5e-4 }}
            h = {{ kind = "instrument", measures = "level", of = "tank" }}
            [initial]
            "tank.level" = 0.2
            [record]
            time = "t"
            "#
        );
        Assembly::parse(&text).unwrap()
    };
    let t = clock(200, 2.0);
    let levels = |assembly: &Assembly, theta: &[f64]| {
        let window = window(assembly, &[("t", &t)]);
        let run = assembly.simulate(theta, &window, 0, &tight()).unwrap();
        run.outputs[0].clone()
    };
    let off = of(0.5)
        .with_effect("tank", "tank_area", &["excess"])
        .unwrap();
    for excess in [0.0, -0.4, 0.6] {
        let (as_stated, true_one) = (
            levels(&off, &[excess]),
            levels(&of(0.5 * (1.0 + excess)), &[]),
        );
        assert!(apart(&as_stated, &true_one) < 1e-9, "{excess}");
    }
}

#[test]
fn the_gas_of_a_closed_tank_is_what_a_taper_leaves() {
    let shapes = [
        "area = 0.5",
        "area_profile = [[-1.0, 0.2], [0.3, 0.5], [1.0, 0.4]]",
    ];
    for shape in shapes {
        let text = format!(
            r#"
            connections = ["feed -> tank.outlet"]
            [components]
            feed = {{ kind = "boundary", flow = "1 l/s" }}
            tank = {{ kind = "tank", {shape}, gas_volume = 1.0 }}
            p = {{ kind = "instrument", measures = "pressure", of = "tank" }}
            level = {{ kind = "instrument", measures = "level", of = "tank" }}
            [initial]
            "tank.level" = 0.0
        "#
        );
        let assembly = Assembly::parse(&text).unwrap();
        let tapered = assembly.with_effect("tank", "taper", &["slope"]).unwrap();
        let t = clock(300, 1.0);
        let pressures = |slope: f64| -> Vec<f64> {
            let window = window(&tapered, &[("t", &t)]);
            let run = tapered.simulate(&[slope], &window, 0, &tight()).unwrap();
            let gas = run.outputs[0].iter().zip(&run.outputs[1]);
            gas.map(|(level, p)| p - 9806.65 * level).collect()
        };
        // Whatever the shape, what came in is what the gas has lost.
        let expected: Vec<f64> = t.iter().map(|t| 101_325.0 / (1.0 - 1e-3 * t)).collect();
        for slope in [0.0, 0.8, -0.6] {
            let off = apart(&pressures(slope), &expected);
            assert!(off < 20.0, "{shape}, {slope}: {off} Pa");
        }
    }
}

#[test]
fn a_cone_fills_with_the_root_of_its_volume() {
    // A wedge: area h, so that volume is h²/2 and a constant feed gives h = sqrt(2 q t) from h0.
    let text = r#"
        connections = ["feed -> tank"]
        [components]
        feed = { kind = "boundary", flow = "10 l/s" }
        tank = { kind = "tank", area_profile = [[0.0, 1e-6], [10.0, 10.000001]] }
        level = { kind = "instrument", measures = "level", of = "tank" }
        [initial]
        "tank.level" = 0.5
    "#;
    let assembly = Assembly::parse(text).unwrap();
    let t = clock(300, 1.0);
    let run = assembly
        .simulate(&[], &window(&assembly, &[("t", &t)]), 0, &tight())
        .unwrap();
    let expected: Vec<f64> = t.iter().map(|t| (0.25 + 2.0 * 0.01 * t).sqrt()).collect();
    assert!(
        apart(&run.outputs[0], &expected) < 1e-5,
        "{}",
        apart(&run.outputs[0], &expected)
    );
}

#[test]
fn two_tanks_joined_at_their_floors_swing_as_a_u_tube() {
    let text = r#"
        connections = ["left.outlet -> pipe -> right.outlet"]
        [components]
        left = { kind = "tank", area = 0.1 }
        right = { kind = "tank", area = 0.1 }
        pipe = { kind = "line", length = 50.0, flow_area = 0.01, friction = "none", inertia = true }
        level = { kind = "instrument", measures = "level", of = "left" }
        [initial]
        "left.level" = 1.2
        "right.level" = 0.8
        "pipe.flow" = 0.0
    "#;
    let assembly = Assembly::parse(text).unwrap();
    let t = clock(200, 1.0);
    let run = assembly
        .simulate(&[], &window(&assembly, &[("t", &t)]), 0, &tight())
        .unwrap();
    // M dq/dt = rho g (hl − hr): w² = 2 g a / (A l).
    let w = (2.0 * 9.80665 * 0.01 / (0.1 * 50.0_f64)).sqrt();
    let expected: Vec<f64> = t.iter().map(|t| 1.0 + 0.2 * (w * t).cos()).collect();
    assert!(
        apart(&run.outputs[0], &expected) < 1e-4,
        "{}",
        apart(&run.outputs[0], &expected)
    );
}

#[test]
fn a_pressed_volume_relaxes_with_its_bulk_modulus() {
    let text = r#"
        connections = ["vessel -> line -> atmosphere"]
        [components]
        vessel = { kind = "volume", volume = 2.0, bulk_modulus = 1e9 }
        line = { kind = "line", linear = 1e10 }
        p = { kind = "instrument", measures = "pressure", of = "vessel", unit = "bar" }
        [initial]
        "vessel.pressure" = "101 bar"
    "#;
    let assembly = Assembly::parse(text).unwrap();
    let t = clock(60, 1.0);
    let run = assembly
        .simulate(&[], &window(&assembly, &[("t", &t)]), 0, &tight())
        .unwrap();
    let rate = 1e9 / 2.0 / 1e10;
    let expected: Vec<f64> = t
        .iter()
        .map(|t| 101_325.0 + (101e5 - 101_325.0) * (-rate * t).exp())
        .collect();
    assert!(apart(&run.outputs[0], &expected) < 1e-5 * 1e7);
}

#[test]
fn a_pump_that_slips_delivers_less_against_pressure() {
    let text = r#"
        connections = ["atmosphere -> pump -> valve -> sea"]
        [components]
        pump = { kind = "displacement_pump", input = 10.0, coefficient = 1e-4 }
        valve = { kind = "valve", flow_coefficient = 1e-6 }
        sea = { kind = "boundary", pressure = 201325.0 }
        q = { kind = "instrument", measures = "flow", of = "valve" }
        p = { kind = "instrument", measures = "pressure", of = "pump.outlet" }
        [scale]
        flow = 1e-3
        pressure = 1e6
    "#;
    let assembly = Assembly::parse(text).unwrap();
    let with = assembly
        .with_effect("pump", "pump_slip", &["slip"])
        .unwrap();
    let still = |assembly: &Assembly, theta: &[f64]| {
        steady_state(assembly, theta, &[], &[]).unwrap().outputs
    };
    let rigid = still(&assembly, &[]);
    assert!(
        (rigid[1] - 1e-3).abs() < 1e-15 && (rigid[0] - 201_325.0 - 1e6).abs() < 1.0,
        "{rigid:?}"
    );
    let [p, q] = still(&with, &[2e-4])[..] else {
        panic!()
    };
    assert!(
        (q - (1e-3 - 2e-4 * (p - 101_325.0) / 1e6)).abs() < 1e-12,
        "{q} {p}"
    );
    assert!((q - 1e-6 * (p - 201_325.0).sqrt()).abs() < 1e-9);
}

#[test]
fn a_check_valve_shuts_and_opens_with_the_pressure() {
    let text = r#"
        connections = ["low -> pump -> line -> high"]
        [components]
        low = { kind = "boundary" }
        high = { kind = "boundary", pressure = "3 bar" }
        pump = { kind = "centrifugal_pump", speed = 0.0, c0 = 0.0, c2 = 0.0, check_valve = true }
        line = { kind = "line", length = 20.0, bore = 0.05, inertia = true }
        q = { kind = "instrument", measures = "flow", of = "line" }
        [inputs]
        "low.pressure" = { channel = "p", unit = "bar", between = "held" }
    "#;
    let assembly = Assembly::parse(text).unwrap();
    let t = clock(90, 1.0);
    let p: Vec<f64> = t
        .iter()
        .map(|t| if (30.0..60.0).contains(t) { 2.0 } else { 3.5 })
        .collect();
    let run = assembly
        .simulate(
            &[],
            &window(&assembly, &[("t", &t), ("p", &p)]),
            0,
            &tight(),
        )
        .unwrap();
    assert_eq!(run.status, RunStatus::Finished);
    let q = &run.outputs[0];
    assert!(
        q[29] > 1e-3 && q[59] == 0.0 && (q[89] / q[29] - 1.0).abs() < 1e-3,
        "{} {} {}",
        q[29],
        q[59],
        q[89]
    );
    assert!(q.iter().all(|q| *q >= 0.0));
}

#[test]
fn a_simulator_refuses_a_theta_that_is_too_short() {
    let assembly = Assembly::parse(TWO_TANKS).unwrap();
    let u = [1.0; 5];
    let window = window(&assembly, &[("u", &u)]);
    let mut simulator =
        Simulator::new(&assembly, &window, 0, &SimulationOptions::default()).unwrap();
    assert!(simulator.run(&[1.0]).is_err());
    assert!(simulator.run(&[f64::NAN; 4]).is_err());
    assert!(simulator.run(&assembly.start()).is_ok());
}
