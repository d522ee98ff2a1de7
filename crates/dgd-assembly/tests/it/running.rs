//! Simulations against closed forms, balances and the two-state model of `dgd-dynamics`.

use crate::common::{PUMP_LOOP, RETURN_LINE, TWO_TANKS, apart, clock, steps, window};
use dgd_assembly::{ATMOSPHERE, Assembly, Portion, Record, RunStatus, SimulationOptions};
use dgd_dynamics::inputs::{Interpolation, Signal};
use dgd_dynamics::return_line;

fn tight() -> SimulationOptions {
    SimulationOptions {
        relative: 1e-9,
        ..SimulationOptions::default()
    }
}

#[test]
fn the_return_line_agrees_with_the_two_state_model() {
    let assembly = Assembly::parse(RETURN_LINE).unwrap();
    let t = clock(600, 1.0);
    let inflow: Vec<f64> = t.iter().map(|t| 0.05 + 0.004 * (t * 0.03).sin()).collect();
    let speed: Vec<f64> = t.iter().map(|t| 62.0 + 3.0 * (t * 0.02).cos()).collect();
    let window = window(&assembly, &[("t", &t), ("q_in", &inflow), ("w", &speed)]);
    let run = assembly.simulate(&[], &window, 0, &tight()).unwrap();
    assert_eq!(run.status, RunStatus::Finished);
    let line = return_line::ReturnLine {
        density_kg_m3: 1080.0,
        riser_area_m2: 0.17044,
        line_area_m2: 0.018_241,
        inlet_depth_m: 350.3,
        outlet_depth_m: 350.3,
        friction: return_line::Friction {
            b_pa: 12_650.0,
            c_pa_s_m3: 2e5,
            d_pa_s2_m6: 1.28e8,
            e_pa_s3_m9: -2.3e8,
        },
        pump: return_line::PumpHead {
            c0: 0.068_78,
            c1: 0.05,
            c2: 8926.0,
            n0: 1.9546,
            n2: 1.6243,
        },
        non_return_valve: true,
        b_is_offset: false,
    };
    let start = return_line::LineState {
        level_m: 140.0,
        flow_m3_s: 0.05,
    };
    let options = return_line::SimulationOptions {
        relative: 1e-9,
        level_tolerance_m: 1e-8,
        flow_tolerance_m3_s: 1e-10,
        ..Default::default()
    };
    let u = Signal::new("q", &t, &inflow, Interpolation::Linear).unwrap();
    let w = Signal::new("w", &t, &speed, Interpolation::Linear).unwrap();
    let known = return_line::simulate_coupled(&line, start, &u, &w, &t, &options).unwrap();
    let level: Vec<f64> = known.level_m.iter().map(|h| 350.3 - h).collect();
    assert!(
        apart(&run.outputs[2], &level) < 1e-6 * 210.0,
        "{}",
        apart(&run.outputs[2], &level)
    );
    assert!(
        apart(&run.outputs[0], &known.flow_m3_s) < 1e-6 * 0.05,
        "{}",
        apart(&run.outputs[0], &known.flow_m3_s)
    );
    let inlet: Vec<f64> = known
        .level_m
        .iter()
        .map(|&h| line.inlet_pressure_pa(h))
        .collect();
    assert!(apart(&run.outputs[1], &inlet) < 1e-6 * 2e6);
}

#[test]
fn a_tank_drains_as_torricelli_says() {
    let text = r#"
        connections = ["tank -> hole -> atmosphere"]
        [components]
        tank = { kind = "tank", area = 0.5 }
        hole = { kind = "orifice", discharge_coefficient = 0.6, area = 1e-3 }
        gauge = { kind = "instrument", measures = "level", of = "tank" }
        [initial]
        "tank.level" = 2.0
    "#;
    let assembly = Assembly::parse(text).unwrap();
    let t = clock(400, 1.0);
    let run = assembly
        .simulate(&[], &window(&assembly, &[("t", &t)]), 0, &tight())
        .unwrap();
    // √h falls evenly: d√h/dt = −(C a / A) √(g/2).
    let fall = 0.6e-3 / 0.5 * (9.80665_f64 / 2.0).sqrt();
    let expected: Vec<f64> = t
        .iter()
        .map(|t| (2.0_f64.sqrt() - fall * t).max(0.0).powi(2))
        .collect();
    assert!(
        apart(&run.outputs[0], &expected) < 1e-6,
        "{}",
        apart(&run.outputs[0], &expected)
    );
}

#[test]
fn volume_is_conserved_in_the_cascade_below_the_brim() {
    let assembly = Assembly::parse(TWO_TANKS).unwrap();
    let u = steps(500, 20, 2.0, 5.0);
    let window = window(&assembly, &[("u", &u)]);
    let theta = assembly.start();
    let run = assembly.simulate(&theta, &window, 0, &tight()).unwrap();
    assert!(run.held.is_empty());
    // What the pump gave less what left through the lower outlet, by Simpson's rule within each sample.
    let (upper, lower) = (&run.states[1], &run.states[0]);
    let stored = 0.02 * (upper[499] + lower[499] - upper[0] - lower[0]);
    let given: f64 = u[..499].iter().sum::<f64>()
        * 4.0
        * theta[assembly
            .parameters()
            .iter()
            .position(|p| p.path == "pump.coefficient")
            .unwrap()];
    let coefficient = theta[assembly
        .parameters()
        .iter()
        .position(|p| p.path == "lower_outlet.discharge_coefficient")
        .unwrap()];
    let out = |h: f64| coefficient * 1.2e-4 * (2.0 * 9.80665 * h).sqrt();
    let left: f64 = lower
        .windows(2)
        .map(|h| 2.0 * (out(h[0]) + out(h[1])))
        .sum();
    assert!(
        (stored - (given - left)).abs() < 1e-3 * given,
        "{stored} {given} {left}"
    );
}

#[test]
fn a_full_tank_stays_at_the_brim_until_it_drains() {
    let assembly = Assembly::parse(TWO_TANKS).unwrap();
    let u: Vec<f64> = (0..300).map(|i| if i < 150 { 12.0 } else { 1.0 }).collect();
    let window = window(&assembly, &[("u", &u)]);
    let run = assembly
        .simulate(&assembly.start(), &window, 0, &SimulationOptions::default())
        .unwrap();
    assert_eq!(run.status, RunStatus::Finished);
    assert!(
        run.held
            .iter()
            .any(|(path, _, full)| path == "upper.level" && *full),
        "{:?}",
        run.held
    );
    assert!(run.states[1].iter().all(|h| *h <= 0.4 + 1e-9));
    assert!((run.states[1][140] - 0.4).abs() < 1e-12);
    assert!(run.states[1][299] < 0.1);
}

#[test]
fn the_pump_loop_settles_where_head_meets_losses_and_shuts_when_the_pump_stops() {
    let assembly = Assembly::parse(PUMP_LOOP).unwrap();
    let t = clock(120, 1.0);
    let w: Vec<f64> = t
        .iter()
        .map(|t| if *t < 60.0 { 80.0 } else { 0.0 })
        .collect();
    let z = vec![1.0; 120];
    let window = window(&assembly, &[("t", &t), ("w", &w), ("z", &z)]);
    let run = assembly
        .simulate(&assembly.start(), &window, 0, &tight())
        .unwrap();
    assert_eq!(run.status, RunStatus::Finished);
    let at = |name: &str, i: usize| {
        run.outputs[assembly.outputs().iter().position(|o| o == name).unwrap()][i]
    };
    let q = at("flow", 55);
    assert!(q > 1e-3);
    assert!((at("rise", 55) - (0.004 * 6400.0 - 2e4 * q * q)).abs() < 1e-6);
    assert!((at("discharge", 55) - (101_325.0 + 9806.65 * (1.5 + at("rise", 55)))).abs() < 1.0);
    assert!(at("flow", 119).abs() < 1e-12);
}

#[test]
fn explicit_and_implicit_methods_agree() {
    let assembly = Assembly::parse(TWO_TANKS).unwrap();
    let u = steps(200, 5, 1.0, 10.0);
    let window = window(&assembly, &[("u", &u)]);
    let runs: Vec<_> = [
        dgd_dynamics::integrate::Method::Rodasp,
        dgd_dynamics::integrate::Method::DormandPrince,
    ]
    .into_iter()
    .map(|method| {
        assembly
            .simulate(
                &assembly.start(),
                &window,
                0,
                &SimulationOptions { method, ..tight() },
            )
            .unwrap()
    })
    .collect();
    assert!(apart(&runs[0].states[0], &runs[1].states[0]) < 1e-7);
}

#[test]
fn a_clock_in_minutes_runs_as_one_in_seconds() {
    let tank = r#"
connections = ["feed -> tank -> drain -> atmosphere"]
[components]
feed = { kind = "boundary" }
tank = { kind = "tank", area = 0.02 }
drain = { kind = "orifice", discharge_coefficient = 0.6, area = 1e-4 }
[inputs]
"feed.flow" = { channel = "q" }
[initial]
"tank.level" = 0.1
[record]
"#;
    let seconds = clock(200, 12.0);
    let minutes: Vec<f64> = seconds.iter().map(|t| t / 60.0).collect();
    let q: Vec<f64> = seconds
        .iter()
        .map(|t| 8e-5 + 4e-5 * (t / 300.0).sin())
        .collect();
    let level = |record: &str, time: &[f64]| {
        let assembly = Assembly::parse(&format!("{tank}{record}")).unwrap();
        let record = Record {
            columns: vec![("t", time), ("q", &q)],
        };
        let window = assembly.windows(&record, Portion::Train).unwrap().remove(0);
        let run = assembly.simulate(&[], &window, 0, &tight()).unwrap();
        assert!((window.time[0] - 120.0).abs() < 1e-9 && window.time.len() == 141);
        run.states[0].clone()
    };
    let by_seconds = level("time = \"t\"\ntrain.windows = [[114, 1806]]", &seconds);
    let by_minutes = level(
        "time = \"t\"\nunit = \"min\"\ntrain.windows = [[1.9, 30.1]]",
        &minutes,
    );
    // A moment rounded otherwise moves the steps of the integrator a little.
    let off = apart(&by_seconds, &by_minutes);
    assert!(off < 1e-8, "{off:e}");
    // Without a column the step counts in the same unit.
    let by_steps = level(
        "step = 0.2\nunit = \"min\"\ntrain.windows = [[1.9, 30.1]]",
        &[0.0; 200],
    );
    assert!(apart(&by_minutes, &by_steps) < 1e-8);
    let wrong = Assembly::parse(&format!("{tank}unit = \"ft\""))
        .unwrap_err()
        .to_string();
    assert!(
        wrong.contains("record.unit") && wrong.contains("not a unit of time"),
        "{wrong}"
    );
}

/// A relation over depth whose friction grows along the record.
const GROWING: &str = r#"
independent = "depth"
connections = ["mud -> string -> atmosphere"]
[components]
mud = { kind = "boundary" }
string = { kind = "line", length = 1.0, bore = 0.1, friction = "polynomial", quadratic = 1e8 }
standpipe = { kind = "instrument", measures = "pressure", of = "string.inlet", channel = "p" }
[scale]
time = 0.1
[[effects]]
component = "string"
effect = "friction_drift"
parameters = { change = 1.0 }
[inputs]
"mud.flow" = { channel = "q" }
[record]
time = "depth"
train = { windows = [[20.0, 59.0]] }
test = { windows = [[60.0, 99.0]] }
"#;

#[test]
fn a_drift_goes_on_in_a_held_out_window_of_the_same_record_and_starts_anew_in_another() {
    let depth = clock(100, 1.0);
    let q = vec![0.03; 100];
    let record = Record {
        columns: vec![("depth", &depth), ("q", &q), ("q2", &q)],
    };
    let first = |text: &str, portion: Portion| {
        let assembly = Assembly::parse(text).unwrap();
        let window = assembly.windows(&record, portion).unwrap().remove(0);
        let run = assembly
            .simulate(&[], &window, 0, &SimulationOptions::default())
            .unwrap();
        (window.origin, run.outputs[0][0] - ATMOSPHERE)
    };
    let still = 1e8 * 0.03 * 0.03;
    let close = |a: f64, b: f64| (a - b).abs() < 1e-6 * b;
    let (origin, train) = first(GROWING, Portion::Train);
    assert!(origin == Some(20.0) && close(train, still));
    let (origin, test) = first(GROWING, Portion::Test);
    assert!(
        origin == Some(20.0) && close(test, still * f64::exp(0.4)),
        "{test}"
    );
    let other = GROWING.replace(
        "test = { windows = [[60.0, 99.0]] }",
        "test = { windows = [[60.0, 99.0]], channels = { q = \"q2\" } }",
    );
    let (origin, test) = first(&other, Portion::Test);
    assert!(origin.is_none() && close(test, still), "{test}");
}

/// A valve between a kept pressure and the open, its opening and the pressure before it recorded.
const THROTTLE: &str = r#"
connections = ["main -> valve -> atmosphere"]
[components]
main = { kind = "boundary", pressure = 201325.0 }
valve = { kind = "valve", flow_coefficient = 1e-5 }
before = { kind = "instrument", measures = "pressure", of = "valve.inlet", channel = "p", unit = "kPag", accuracy = 0.165 }
flow = { kind = "instrument", measures = "flow", of = "valve", channel = "q" }
[inputs]
"valve.opening" = { channel = "z", unit = "%" }
"#;

#[test]
fn an_accuracy_is_a_difference_in_the_unit_of_its_instrument() {
    let stated = |unit: &str| {
        let text = THROTTLE.replace("unit = \"kPag\"", unit);
        Assembly::parse(&text).unwrap().accuracies()
    };
    assert_eq!(stated("unit = \"kPag\""), [Some(165.0), None]);
    assert_eq!(stated("unit = \"bar\""), [Some(16_500.0), None]);
    // No unit, no conversion.
    assert_eq!(stated("gain = 2.0"), [Some(0.165), None]);
    // What is written down again is what was read.
    let again = Assembly::parse(THROTTLE).unwrap().to_toml();
    assert_eq!(
        Assembly::parse(&again).unwrap().accuracies(),
        [Some(165.0), None]
    );
}

#[test]
fn gain_and_offset_of_an_instrument_are_in_its_unit() {
    let reading = |written: &str| {
        let text = THROTTLE.replace("accuracy = 0.165", written);
        let assembly = Assembly::parse(&text).unwrap();
        let record = Record {
            columns: vec![("z", &[50.0, 50.0][..])],
        };
        let window = assembly.windows(&record, Portion::Train).unwrap().remove(0);
        let run = assembly
            .simulate(&[], &window, 0, &SimulationOptions::default())
            .unwrap();
        run.outputs[0][0]
    };
    // 201325 Pa are 100 kPa above the atmosphere.
    let plain = reading("gain = 1.0");
    assert!((plain - 201_325.0).abs() < 1e-6);
    assert!((reading("offset = 2.0") - plain - 2000.0).abs() < 1e-6);
    assert!((reading("gain = 1.5") - plain - 50_000.0).abs() < 1e-6);
    assert!((reading("gain = 1.5, offset = -50.0") - plain).abs() < 1e-6);
}

#[test]
fn an_opening_in_per_cent_is_a_share() {
    let per_cent = [0.0, 50.0, 100.0];
    let share = [0.0, 0.5, 1.0];
    let flow = |text: &str, z: &[f64]| {
        let record = Record {
            columns: vec![("z", z)],
        };
        let assembly = Assembly::parse(text).unwrap();
        let window = assembly.windows(&record, Portion::Train).unwrap().remove(0);
        let run = assembly
            .simulate(&[], &window, 0, &SimulationOptions::default())
            .unwrap();
        run.outputs[1].clone()
    };
    let found = flow(THROTTLE, &per_cent);
    assert_eq!(
        found,
        flow(&THROTTLE.replace("unit = \"%\"", "unit = \"1\""), &share)
    );
    assert!((found[2] - 1e-5 * 1e5_f64.sqrt()).abs() < 1e-9, "{found:?}");
    // A pump's speed is in per cent by itself.
    let text = PUMP_LOOP.replace("channel = \"w\"", "channel = \"w\", unit = \"%\"");
    let assembly = Assembly::parse(&text).unwrap();
    let (t, w, z) = (clock(3, 1.0), [80.0; 3], [0.7; 3]);
    let loop_window = window(&assembly, &[("t", &t), ("w", &w), ("z", &z)]);
    assert_eq!(loop_window.inputs, [w, z]);
}

#[test]
fn a_fitted_system_that_is_written_down_keeps_what_its_effects_count_in() {
    // The orifice's area says what flow is usual; the wear of the pump is told by that.
    let text = r#"
connections = ["feed -> tank -> valve -> atmosphere"]
[components]
feed = { kind = "boundary" }
tank = { kind = "tank", area = 1.0 }
valve = { kind = "valve" }
gauge = { kind = "instrument", measures = "level", of = "tank", channel = "h" }
[inputs]
"feed.flow" = { channel = "q" }
[initial]
"tank.level" = 1.0
[free]
"valve.flow_coefficient" = { start = 3e-5, low = 1e-6, high = 1e-3 }
"#;
    let drifting = Assembly::parse(text)
        .unwrap()
        .with_effect("valve", "clogging", &["share"])
        .unwrap();
    let q = vec![2e-3; 200];
    let window = window(&drifting, &[("q", &q)]);
    // Far from where the search starts, where the usual time would be another.
    let paths: Vec<String> = drifting
        .parameters()
        .iter()
        .map(|p| p.path.clone())
        .collect();
    let at = |path: &str| if path.contains("share") { 0.4 } else { 9e-5 };
    let theta: Vec<f64> = paths.iter().map(|path| at(path)).collect();
    let fitted = drifting.with_values(&theta).unwrap();
    let read = Assembly::parse(&fitted.to_toml()).unwrap();
    let run = |assembly: &Assembly| {
        let run = assembly.simulate(&theta, &window, 0, &tight()).unwrap();
        run.outputs[0].clone()
    };
    assert_eq!(read.usual_time_s(), drifting.usual_time_s());
    assert!(apart(&run(&read), &run(&drifting)) < 1e-12);
}
