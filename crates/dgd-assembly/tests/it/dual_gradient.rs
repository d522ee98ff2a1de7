//! The six-state system, and networks that need the nodal solution.

use crate::common::{apart, clock, steps, window};
use dgd_assembly::{
    Assembly, RunStatus, SimulationOptions, identifiability, linearise, sensitivities, steady_state,
};

const SIX: &str = include_str!("../../examples/dual_gradient.toml");

#[test]
fn the_six_states_are_those_of_eq_2_47() {
    let assembly = Assembly::parse(SIX).unwrap();
    assert_eq!(
        assembly.states(),
        [
            "riser.level",
            "booster_head.pressure",
            "standpipe.pressure",
            "string.flow",
            "booster_line.flow",
            "return_line.flow"
        ]
        .map(String::from)
    );
    assert!(assembly.warnings().is_empty(), "{:?}", assembly.warnings());
}

#[test]
fn mass_is_conserved_at_rig_inputs() {
    let assembly = Assembly::parse(SIX).unwrap();
    let t = clock(900, 1.0);
    let q_p = steps(900, 90, 0.02, 0.04);
    let q_bp = steps(900, 130, 0.005, 0.02);
    let q_tf = vec![1e-3; 900];
    let w: Vec<f64> = t.iter().map(|t| 62.0 + 3.0 * (t * 0.02).cos()).collect();
    let window = window(
        &assembly,
        &[
            ("t", &t),
            ("q_p", &q_p),
            ("q_bp", &q_bp),
            ("q_tf", &q_tf),
            ("w", &w),
        ],
    );
    let theta = assembly.start();
    let options = SimulationOptions {
        relative: 1e-8,
        ..Default::default()
    };
    let run = assembly.simulate(&theta, &window, 0, &options).unwrap();
    assert_eq!(run.status, RunStatus::Finished);
    let [level, p_b, p_p, .., q_out] = &run.states[..] else {
        panic!("{:?}", run.states.len())
    };
    let trapezium = |q: &[f64]| -> f64 { q.windows(2).map(|q| 0.5 * (q[0] + q[1])).sum() };
    let given = trapezium(&q_p) + trapezium(&q_bp) + trapezium(&q_tf);
    let stored = 0.17044 * (level[899] - level[0])
        + 28.0 / 1.5e9 * (p_p[899] - p_p[0])
        + 10.0 / 1.5e9 * (p_b[899] - p_b[0]);
    // The outflow is written once a second and follows the speed smoothly: the trapezium is good to a thousandth.
    assert!(
        (given - trapezium(q_out) - stored).abs() < 1e-3 * given,
        "{given} {stored}"
    );
    // A looser run is the same: the stiff volumes leave no trace.
    let loose = assembly
        .simulate(&theta, &window, 0, &SimulationOptions::default())
        .unwrap();
    assert!(apart(&loose.states[0], level) < 1e-2);
}

#[test]
fn a_line_starts_at_the_balance_nearest_to_rest_not_beyond_the_range_of_its_polynomial() {
    let assembly = Assembly::parse(SIX).unwrap();
    let t = clock(20, 1.0);
    let held = |v: f64| vec![v; 20];
    let (q_p, q_bp, q_tf, w) = (held(0.03), held(0.012), held(1e-3), held(62.0));
    let columns: Vec<(&str, &[f64])> = vec![
        ("t", &t),
        ("q_p", &q_p),
        ("q_bp", &q_bp),
        ("q_tf", &q_tf),
        ("w", &w),
    ];
    let window = window(&assembly, &columns);
    let run = assembly
        .simulate(&assembly.start(), &window, 0, &SimulationOptions::default())
        .unwrap();
    // The cubic term is negative: from 0.56 m3/s on the polynomial pushes, and balances once more near 1 m3/s.
    let q = run.states[5][0];
    assert!((0.03..0.08).contains(&q), "{q}");
    let outlet = &run.outputs[assembly
        .outputs()
        .iter()
        .position(|o| o == "outlet_pressure")
        .unwrap()];
    assert!(outlet.iter().all(|p| (2e6..8e6).contains(p)), "{outlet:?}");
}

#[test]
fn its_steady_state_balances_every_term() {
    let assembly = Assembly::parse(SIX).unwrap();
    let theta = assembly.start();
    let inputs = [0.01, 0.035, 62.0, 0.001]; // booster, mud pump, speed, topfill
    assert_eq!(
        assembly.inputs(),
        [
            "booster_pump.flow",
            "mud_pump.flow",
            "subsea_pump.speed",
            "topfill.flow"
        ]
        .map(String::from)
    );
    let guess = [2860.0, 20e5, 150e5, 0.035, 0.01, 0.046];
    let steady = steady_state(&assembly, &theta, &inputs, &guess).unwrap();
    assert!(steady.found, "{steady:?}");
    let x = &steady.state;
    assert!(
        (x[3] - 0.035).abs() < 1e-9 && (x[4] - 0.01).abs() < 1e-9 && (x[5] - 0.046).abs() < 1e-9,
        "{x:?}"
    );
    // Eq. 2.42 at rest: inlet pressure and head carry column and friction.
    let q = 0.046_f64;
    let weight = 1080.0 * 9.80665;
    let head = 0.068_78 * 62.0_f64.powf(1.9546) - 0.05 * 62.0 * q - 8926.0 * q.powf(1.6243);
    let friction = 12_650.0 + 2e5 * q + 1.28e8 * q * q - 2.3e8 * q.powi(3);
    let inlet = weight * (x[0] - 2649.7);
    assert!(
        (inlet + weight * head - weight * 350.3 - friction).abs() < 5.0,
        "{}",
        inlet + weight * head - weight * 350.3 - friction
    );
    // Eq. 2.34 at rest, with Eq. 2.25 at the bit and Haaland in the string.
    let (density, d) = (1080.0, 4.5 * 0.0254);
    let area = std::f64::consts::PI * d * d / 4.0;
    let v = 0.035 / area;
    let re = density * v * d / 0.02;
    let f = (-1.8 * (6.9 / re + (5e-5_f64 / 3.7 / d).powf(1.11)).log10()).powi(-2);
    let string = f * 3000.0 / d * 0.5 * density * v * v;
    let bit = density * 0.035_f64.powi(2) / (2.0 * (0.95_f64 * 7e-4).powi(2));
    let annulus = 2e6 * 0.045 + 2e7 * 0.045_f64.powi(2);
    let standpipe = 101_325.0 + weight * x[0] - weight * 3000.0 + string + bit + annulus;
    assert!(
        (x[2] / standpipe - 1.0).abs() < 1e-7,
        "{} {standpipe}",
        x[2]
    );
}

#[test]
fn it_is_stable_and_stiff_at_its_steady_state() {
    let assembly = Assembly::parse(SIX).unwrap();
    let theta = assembly.start();
    let inputs = [0.01, 0.035, 62.0, 0.001];
    let steady = steady_state(
        &assembly,
        &theta,
        &inputs,
        &[2860.0, 20e5, 150e5, 0.035, 0.01, 0.046],
    )
    .unwrap();
    let linear = linearise(&assembly, &theta, &steady.state, &inputs).unwrap();
    let poles = linear.poles();
    assert!(poles.iter().all(|p| p.0 < 0.0), "{poles:?}");
    assert!(poles[5].0 / poles[0].0 > 50.0, "{poles:?}");
}

#[test]
fn its_transmitters_tell_some_parameters_and_not_others() {
    let assembly = Assembly::parse(SIX).unwrap();
    let t = clock(300, 1.0);
    let q_p = steps(300, 45, 0.02, 0.04);
    let q_bp = steps(300, 65, 0.005, 0.02);
    let q_tf = vec![1e-3; 300];
    let w = vec![62.0; 300];
    let columns: Vec<(&str, &[f64])> = vec![
        ("t", &t),
        ("q_p", &q_p),
        ("q_bp", &q_bp),
        ("q_tf", &q_tf),
        ("w", &w),
    ];
    let window = window(&assembly, &columns);
    let found = identifiability(&[sensitivities(
        &assembly,
        &assembly.start(),
        &window,
        0,
        &SimulationOptions::default(),
    )
    .unwrap()])
    .unwrap();
    assert_eq!(found.rank, 7, "{found:?}");
    // String and bit act through the same sum of squares: the pair stands out.
    let (a, b, index) = &found.pairs[0];
    assert!(
        [a.as_str(), b.as_str()].contains(&"string.roughness")
            && [a.as_str(), b.as_str()].contains(&"bit.area"),
        "{a} {b} {index}"
    );
}

/// A bridge of five valves, one of them shut, between two pressures.
fn bridge(shut: f64) -> String {
    format!(
        r#"
        connections = ["high -> a -> left", "high -> b -> right", "left -> c -> right", "left -> d -> atmosphere", "right -> e -> atmosphere"]
        [components]
        high = {{ kind = "boundary", pressure = "3 bar" }}
        left = {{ kind = "junction" }}
        right = {{ kind = "junction" }}
        a = {{ kind = "valve", flow_coefficient = 1e-5 }}
        b = {{ kind = "valve", flow_coefficient = 3e-5 }}
        c = {{ kind = "valve", flow_coefficient = 2e-5, opening = {shut} }}
        d = {{ kind = "valve", flow_coefficient = 4e-5 }}
        e = {{ kind = "valve", flow_coefficient = 1e-5 }}
        qa = {{ kind = "instrument", measures = "flow", of = "a" }}
        qb = {{ kind = "instrument", measures = "flow", of = "b" }}
        qc = {{ kind = "instrument", measures = "flow", of = "c" }}
        qd = {{ kind = "instrument", measures = "flow", of = "d" }}
        qe = {{ kind = "instrument", measures = "flow", of = "e" }}
        pl = {{ kind = "instrument", measures = "pressure", of = "left" }}
        pr = {{ kind = "instrument", measures = "pressure", of = "right" }}
        "#
    )
}

#[test]
fn the_bridge_balances_at_its_nodes_open_and_shut() {
    for opening in [1.0, 1e-3, 0.0] {
        let assembly = Assembly::parse(&bridge(opening)).unwrap();
        let steady = steady_state(&assembly, &[], &[], &[]).unwrap();
        // By name: pl, pr, qa .. qe.
        let [pl, pr, qa, qb, qc, qd, qe] = steady.outputs[..] else {
            panic!()
        };
        assert!(
            (qa - qc - qd).abs() < 1e-9 * qa && (qb + qc - qe).abs() < 1e-9 * qb,
            "{opening} {steady:?}"
        );
        assert!(
            (qa - 1e-5 * (3e5 - pl).sqrt()).abs() < 1e-6 * qa,
            "{opening}"
        );
        assert!(opening > 0.0 || qc.abs() < 1e-8, "{qc}");
        assert!(pl < 3e5 && pr < 3e5 && pl > 101_325.0 && pr > 101_325.0);
    }
}

#[test]
fn a_node_between_shut_valves_is_solved_and_carries_nothing() {
    let text = bridge(0.0)
        .replace(
            "flow_coefficient = 1e-5",
            "flow_coefficient = 1e-5, opening = 0.0",
        )
        .replace(
            "flow_coefficient = 4e-5",
            "flow_coefficient = 4e-5, opening = 0.0",
        );
    let assembly = Assembly::parse(&text).unwrap();
    let steady = steady_state(&assembly, &[], &[], &[]).unwrap();
    assert!(steady.outputs.iter().all(|v| v.is_finite()), "{steady:?}");
    assert!(steady.outputs[2].abs() < 1e-8 && steady.outputs[5].abs() < 1e-8);
}

#[test]
fn resistances_in_series_add_up() {
    let text = r#"
        connections = ["high -> a -> b -> line -> atmosphere"]
        [components]
        high = { kind = "boundary", pressure = 401325.0 }
        a = { kind = "orifice", discharge_coefficient = 0.6, area = 1e-4 }
        b = { kind = "valve", loss_coefficient = 5.0, area = 2e-4 }
        line = { kind = "line", power_coefficient = 3e8, exponent = 1.75 }
        q = { kind = "instrument", measures = "flow", of = "line" }
        p = { kind = "instrument", measures = "pressure", of = "b.outlet" }
        d = { kind = "instrument", measures = "drop", of = "a" }
    "#;
    let steady = steady_state(&Assembly::parse(text).unwrap(), &[], &[], &[]).unwrap();
    let [d, p, q] = steady.outputs[..] else {
        panic!()
    };
    let drops = [
        500.0 * (q / 0.6e-4).powi(2),
        5.0 * 500.0 * (q / 2e-4).powi(2),
        3e8 * q.powf(1.75),
    ];
    assert!(
        (drops.iter().sum::<f64>() / 3e5 - 1.0).abs() < 1e-6,
        "{drops:?}"
    );
    assert!((d / drops[0] - 1.0).abs() < 1e-6 && ((p - 101_325.0) / drops[2] - 1.0).abs() < 1e-6);
}
