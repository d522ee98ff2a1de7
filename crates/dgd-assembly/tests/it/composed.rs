//! What components and effects are together: no answer hangs on the order in which they are written, or on what was run before.

use crate::common::{Noise, PUMP_LOOP, TWO_TANKS, apart, clock, steps, window};
use dgd_assembly::{
    Assembly, FitOptions, Portion, Record, RunStatus, SimulationOptions, Simulator, effects_for,
    fit, identifiability, sensitivities, steady_state,
};

fn tight() -> SimulationOptions {
    SimulationOptions {
        relative: 1e-8,
        ..SimulationOptions::default()
    }
}

fn parse(text: &str) -> Assembly {
    Assembly::parse(text).unwrap()
}

fn problem(text: &str) -> String {
    Assembly::parse(text).unwrap_err().to_string()
}

/// Parameters with these values, the others at their start.
fn theta(assembly: &Assembly, values: &[(&str, f64)]) -> Vec<f64> {
    let set = |path: &str| values.iter().find(|v| v.0 == path).map(|v| v.1);
    let all = assembly.parameters();
    all.iter()
        .map(|p| set(&p.path).unwrap_or(p.start))
        .collect()
}

const FED_TANK: &str = r#"
    connections = ["feed -> tank -> drain -> atmosphere"]
    [components]
    feed = { kind = "boundary" }
    tank = { kind = "tank", area = 0.02 }
    drain = { kind = "orifice", discharge_coefficient = 0.6, area = 1e-4 }
    level = { kind = "instrument", measures = "level", of = "tank", channel = "h" }
    [inputs]
    "feed.flow" = { channel = "q", between = "held" }
    [initial]
    "tank.level" = 0.1
    [record]
    step = 4.0
"#;

#[test]
fn a_late_input_is_late_as_the_effects_before_it_leave_it() {
    let flow = steps(200, 20, 5e-5, 1.2e-4);
    let orders = [
        ["inflow_gain", "boundary_lag"],
        ["boundary_lag", "inflow_gain"],
    ];
    let levels = orders.map(|order| {
        let both = order.iter().fold(parse(FED_TANK), |a, effect| {
            let strength = if *effect == "inflow_gain" {
                "excess"
            } else {
                "tau"
            };
            a.with_effect("feed", effect, &[strength]).unwrap()
        });
        let window = window(&both, &[("q", &flow)]);
        [0.0, 0.5].map(|excess| {
            let values = [
                ("feed.inflow_gain.excess", excess),
                ("feed.boundary_lag.tau", 20.0),
            ];
            let run = both.simulate(&theta(&both, &values), &window, 0, &tight());
            run.unwrap().outputs[0].clone()
        })
    });
    assert_eq!(levels[0], levels[1]);
    assert!(apart(&levels[0][0], &levels[0][1]) > 0.1);
}

#[test]
fn what_adds_to_the_pressure_is_not_multiplied_with_the_friction_in_any_order() {
    let text = r#"
        connections = ["feed -> pot -> line -> atmosphere"]
        [components]
        feed = { kind = "boundary", flow = 1e-3 }
        pot = { kind = "volume", volume = 1.0 }
        line = { kind = "line", quadratic = 1e10 }
        drop = { kind = "instrument", measures = "drop", of = "line" }
        [initial]
        "pot.pressure" = 111325.0
        [scale]
        pressure = 1e5
        time = 1.0
        flow = 1e-3
    "#;
    let time = clock(1001, 1.0);
    let orders = [
        ["static_head_error", "friction_drift"],
        ["friction_drift", "static_head_error"],
    ];
    for order in orders {
        let both = order.iter().fold(parse(text), |a, effect| {
            let strength = if *effect == "friction_drift" {
                "change"
            } else {
                "head"
            };
            a.with_effect("line", effect, &[strength]).unwrap()
        });
        let values = [
            ("line.friction_drift.change", 1.0),
            ("line.static_head_error.head", 2e4),
        ];
        let window = window(&both, &[("t", &time)]);
        let run = both
            .simulate(&theta(&both, &values), &window, 0, &tight())
            .unwrap();
        // After a thousand times, at 1 L/s: what its equations say.
        let expected = 2e4 + 1e4 * 1f64.exp();
        assert!(
            (run.outputs[0][1000] - expected).abs() < 10.0,
            "{order:?}: {}",
            run.outputs[0][1000]
        );
    }
}

#[test]
fn a_reading_is_bent_before_its_zero_is_off_and_cut_off_after_both() {
    let written = ["reading_clipping", "reading_offset", "reading_curvature"];
    let dull = written.iter().fold(parse(FED_TANK), |a, effect| {
        let free = match *effect {
            "reading_clipping" => &["limit"][..],
            "reading_offset" => &["offset"],
            _ => &["bow"],
        };
        a.with_effect("level", effect, free).unwrap()
    });
    let time = clock(50, 1.0);
    let flow = [0.0; 50];
    let window = window(&dull, &[("t", &time), ("q", &flow)]);
    let read = |offset: f64, bow: f64, limit: f64| {
        let values = [
            ("level.reading_offset.offset", offset),
            ("level.reading_curvature.bow", bow),
            ("level.reading_clipping.limit", limit),
        ];
        let run = dull.simulate(&theta(&dull, &values), &window, 0, &tight());
        run.unwrap().outputs[0].clone()
    };
    let plain = read(0.0, 0.0, 1.0);
    let bent = read(0.0, 0.2, 1.0);
    let all = read(0.03, 0.2, 0.1);
    for i in 0..50 {
        assert!((all[i] - (bent[i] + 0.03).min(0.1)).abs() < 1e-12);
    }
    // All three did something.
    assert!(apart(&plain, &bent) > 1e-3);
    assert!(all[0] == 0.1 && all[49] < 0.1);
}

#[test]
fn a_valve_is_late_before_its_opening_tells() {
    let text = r#"
        connections = ["high -> valve -> low"]
        [components]
        high = { kind = "boundary", pressure = 3e5 }
        low = { kind = "boundary", pressure = 1e5 }
        valve = { kind = "valve", loss_coefficient = 5.0, area = 2e-4 }
        flow = { kind = "instrument", measures = "flow", of = "valve" }
        [inputs]
        "valve.opening" = { channel = "z", between = "held" }
    "#;
    let late = parse(text)
        .with_effect("valve", "opening_characteristic", &["exponent"])
        .and_then(|a| a.with_effect("valve", "opening_lag", &["tau"]))
        .unwrap();
    let time = clock(100, 1.0);
    let opening: Vec<f64> = time
        .iter()
        .map(|t| if *t < 1.0 { 0.25 } else { 1.0 })
        .collect();
    let window = window(&late, &[("t", &time), ("z", &opening)]);
    let values = [
        ("valve.opening_characteristic.exponent", 1.0),
        ("valve.opening_lag.tau", 20.0),
    ];
    let run = late.simulate(&theta(&late, &values), &window, 0, &tight());
    let flow = &run.unwrap().outputs[0];
    // The stem is on its way from a quarter to all; the flow goes with its square.
    for i in [1, 21, 61] {
        let stem = 1.0 - 0.75 * (-(time[i] - 1.0) / 20.0).exp();
        let expected = (stem / 0.25).powi(2);
        assert!(
            (flow[i] / flow[0] - expected).abs() < 1e-3 * expected,
            "{i}: {}",
            flow[i] / flow[0]
        );
    }
}

#[test]
fn what_leaves_a_heavy_chain_goes_by_the_pressures_of_its_own_moment() {
    let text = r#"
        connections = ["high -> suction -> main -> low"]
        [components]
        high = { kind = "boundary" }
        low = { kind = "tank", area = 1.0 }
        suction = { kind = "line", quadratic = 1e8, length = 1000.0, flow_area = 0.01, inertia = true }
        main = { kind = "line", quadratic = 1e8, length = 1000.0, flow_area = 0.01, inertia = true }
        q = { kind = "instrument", measures = "flow", of = "main.outlet" }
        h = { kind = "instrument", measures = "level", of = "low" }
        [inputs]
        "high.pressure" = { channel = "p", between = "held" }
        [initial]
        "low.level" = 1.0
        [scale]
        flow = 0.05
        pressure = 3e5
        time = 5.0
    "#;
    let leaky = parse(text)
        .with_effect("main", "line_leak", &["leak"])
        .unwrap();
    let pressure: Vec<f64> = (0..60).map(|i| if i < 20 { 5e5 } else { 8e5 }).collect();
    let window = window(&leaky, &[("p", &pressure)]);
    let of = |leak: f64| theta(&leaky, &[("main.line_leak.leak", leak)]);
    let fresh = leaky.simulate(&of(0.02), &window, 0, &tight()).unwrap();
    let out = leaky.outputs().iter().position(|o| o == "q").unwrap();
    let flow = leaky
        .states()
        .iter()
        .position(|s| s.ends_with(".flow"))
        .unwrap();
    for i in [19, 20, 21, 59] {
        let q = fresh.states[flow][i];
        // Half of what accelerates both lines is spent in the first.
        let accelerates = pressure[i] - 101_325.0 - 2e8 * q * q;
        let between = pressure[i] - 1e8 * q * q - 0.5 * accelerates;
        let expected = q - 0.02 * ((between - 101_325.0) / 3e5).sqrt();
        let found = fresh.outputs[out][i];
        assert!(
            (found - expected).abs() < 1e-9,
            "{i}: {found} for {expected}"
        );
    }
    let mut simulator = Simulator::new(&leaky, &window, 0, &tight()).unwrap();
    simulator.run(&of(0.0)).unwrap();
    assert_eq!(simulator.run(&of(0.02)).unwrap(), fresh);
}

#[test]
fn a_check_valve_passes_what_its_own_pump_lifts_however_the_chain_is_drawn() {
    let text = r#"
        connections = ["sea -> pump", "tank -> line -> pump.outlet"]
        [components]
        sea = { kind = "boundary", pressure = 101325.0 }
        tank = { kind = "tank", area = 1.0 }
        line = { kind = "line", quadratic = 1e8 }
        pump = { kind = "centrifugal_pump", c0 = 0.004, c2 = 20000.0, speed = 80.0, check_valve = true }
        q = { kind = "instrument", measures = "flow", of = "pump" }
        h = { kind = "instrument", measures = "level", of = "tank" }
        [initial]
        "tank.level" = 2.0
        [record]
        step = 1.0
    "#;
    let time = clock(50, 1.0);
    let run = |text: &str| {
        let system = parse(text);
        let window = window(&system, &[("t", &time)]);
        let run = system.simulate(&[], &window, 0, &tight()).unwrap();
        let q = system.outputs().iter().position(|o| o == "q").unwrap();
        (run.outputs[q].clone(), run.states[0].clone())
    };
    let (flow, level) = run(text);
    let (free, _) = run(&text.replace("check_valve = true", "check_valve = false"));
    assert!(flow[0] > 0.02 && apart(&flow, &free) < 1e-9, "{flow:?}");
    assert!(level[49] > level[0] + 0.5);
}

#[test]
fn the_start_of_a_flow_is_that_of_the_member_it_is_given_for() {
    let text = |connections: &str| {
        format!(
            r#"
            connections = {connections}
            [components]
            high = {{ kind = "boundary", pressure = 3e5 }}
            first = {{ kind = "line", quadratic = 1e8, length = 1000.0, flow_area = 0.01, inertia = true }}
            second = {{ kind = "line", quadratic = 1e8 }}
            third = {{ kind = "line", quadratic = 1e8 }}
            q = {{ kind = "instrument", measures = "flow", of = "first" }}
            [initial]
            "first.flow" = 0.01
        "#
        )
    };
    let starts = [
        r#"["high -> first -> second -> third -> atmosphere"]"#,
        // Drawn against the other two.
        r#"["atmosphere -> first -> high", "high -> second -> third -> atmosphere"]"#,
        r#"["third.outlet -> atmosphere", "second.outlet -> third.inlet", "second.inlet -> first.inlet", "high -> first.outlet"]"#,
    ]
    .map(|connections| {
        let system = parse(&text(connections));
        let window = window(&system, &[("t", &[0.0, 1.0])]);
        system.simulate(&[], &window, 0, &tight()).unwrap().outputs[0][0]
    });
    assert_eq!(starts, [0.01; 3]);
}

#[test]
fn line_settings_that_would_change_nothing_are_refused() {
    let line = |settings: &str| {
        format!(
            r#"
            connections = ["high -> line -> atmosphere"]
            [components]
            high = {{ kind = "boundary", pressure = 5e5 }}
            line = {{ kind = "line", {settings} }}
            q = {{ kind = "instrument", measures = "flow", of = "line" }}
        "#
        )
    };
    for (settings, said) in [
        ("quadratic = 1e8, minor_loss = 50.0", "line.bore"),
        (
            "bore = 0.1, inner_diameter = 0.2, length = 100.0",
            "not above the inner diameter",
        ),
        (
            "friction = \"darcy\", constant = 1e5, bore = 0.1, length = 100.0",
            "belongs to another law",
        ),
        ("quadratic = 1e8, exponent = 1.8", "belongs to another law"),
    ] {
        let found = problem(&line(settings));
        assert!(found.contains(said), "{settings}: {found}");
    }
    for settings in [
        "quadratic = 1e8, minor_loss = 50.0, bore = 0.1",
        "quadratic = 1e8, minor_loss = 50.0, flow_area = 0.01",
        "bore = 0.2, inner_diameter = 0.1, length = 100.0",
        "power_coefficient = 1e8, exponent = 1.8",
    ] {
        parse(&line(settings));
    }
}

#[test]
fn a_tank_whose_outflow_is_no_number_never_rests() {
    let text = r#"
        connections = ["a -> bad -> atmosphere", "feed -> b -> good -> atmosphere"]
        [components]
        a = { kind = "tank", area = 1.0 }
        b = { kind = "tank", area = 1.0 }
        feed = { kind = "boundary", flow = 2e-3 }
        bad = { kind = "valve", loss_coefficient = 0.0, area = 1e-3 }
        good = { kind = "orifice", area = 3e-4, discharge_coefficient = 0.6 }
        [initial]
        "a.level" = 1.0
        "b.level" = 1.0
    "#;
    let rests = (2e-3_f64 / (0.6 * 3e-4)).powi(2) / (2.0 * 9.80665);
    let found = steady_state(&parse(text), &[], &[], &[1.0, rests]).unwrap();
    assert!(!found.found && found.residual.is_nan(), "{found:?}");
}

#[test]
fn a_line_behind_a_shut_check_valve_rests() {
    let text = r#"
        connections = ["atmosphere -> pump -> line -> atmosphere"]
        [components]
        pump = { kind = "centrifugal_pump", c0 = 0.004, c2 = 20000.0, check_valve = true }
        line = { kind = "line", quadratic = 1e8, length = 100.0, flow_area = 0.01, elevation = 2.0, inertia = true }
        q = { kind = "instrument", measures = "flow", of = "line" }
        [inputs]
        "pump.speed" = { channel = "w" }
    "#;
    let system = parse(text);
    let shut = steady_state(&system, &[], &[0.0], &[0.0]).unwrap();
    assert!(shut.found, "{shut:?}");
    assert_eq!((shut.state[0], shut.outputs[0]), (0.0, 0.0));
    let linear = dgd_assembly::linearise(&system, &[], &shut.state, &[0.0]).unwrap();
    assert_eq!((linear.a[0], linear.c[0]), (0.0, 0.0));
    let runs = steady_state(&system, &[], &[80.0], &[0.0]).unwrap();
    assert!(runs.found && runs.outputs[0] > 0.01, "{runs:?}");
}

#[test]
fn sensitivities_of_a_value_on_its_bound_do_not_look_beyond_it() {
    let system = parse(PUMP_LOOP);
    let (time, open) = (clock(60, 1.0), vec![1.0; 60]);
    let speed = steps(60, 10, 60.0, 85.0);
    let window = window(&system, &[("t", &time), ("w", &speed), ("z", &open)]);
    // A negative roughness to a broken power is no number.
    let values = theta(&system, &[("line.roughness", 0.0)]);
    let found = sensitivities(&system, &values, &window, 0, &SimulationOptions::default()).unwrap();
    assert_eq!(found.status, RunStatus::Finished);
    assert!(
        found
            .values
            .iter()
            .flatten()
            .flatten()
            .all(|v| v.is_finite())
    );
    assert_eq!(identifiability(&[found]).unwrap().rank, 2);
}

#[test]
fn an_instrument_that_is_not_fitted_leaves_the_standard_errors_alone() {
    let system = parse(TWO_TANKS);
    let input = steps(300, 20, 2.0, 5.0);
    let mut first = window(&system, &[("u", &input)]);
    let run = system
        .simulate(&system.start(), &first, 0, &tight())
        .unwrap();
    let mut noise = Noise(3);
    let noisy = run
        .outputs
        .iter()
        .map(|c| c.iter().map(|v| v + 1e-3 * noise.next()).collect());
    first.readings = noisy.collect();
    let mut second = first.clone();
    for (i, v) in second.readings[1].iter_mut().enumerate() {
        *v += 0.05 * (f64::from(u32::try_from(i).unwrap()) / 40.0).sin();
    }
    let options = FitOptions {
        outputs: vec![system.outputs()[0].clone()],
        ..FitOptions::default()
    };
    let [a, b] = [first, second].map(|w| fit(&system, &[w], &options).unwrap());
    assert_eq!((a.theta, a.standard_error), (b.theta, b.standard_error));
}

#[test]
fn effects_of_an_instrument_count_from_the_zero_of_its_unit() {
    let text = r#"
        connections = ["sea -> valve -> atmosphere"]
        [components]
        sea = { kind = "boundary" }
        valve = { kind = "valve", flow_coefficient = 1e-5 }
        gauge = { kind = "instrument", measures = "pressure", of = "sea", unit = "barg", channel = "p" }
        [inputs]
        "sea.pressure" = { channel = "x" }
    "#;
    let pressures = [101_325.0, 201_325.0];
    let read = |system: &Assembly, theta: &[f64]| -> Vec<f64> {
        let window = window(system, &[("x", &pressures)]);
        let run = system.simulate(theta, &window, 0, &tight()).unwrap();
        run.outputs[0]
            .iter()
            .map(|p| (p - 101_325.0) / 1e5)
            .collect()
    };
    let high = parse(text)
        .with_effect("gauge", "reading_gain", &["excess"])
        .unwrap();
    assert!(apart(&read(&high, &[0.1]), &[0.0, 1.1]) < 1e-12);
    let cut = parse(text)
        .with_effect("gauge", "low_flow_cutoff", &["cutoff"])
        .unwrap();
    assert_eq!(read(&cut, &[1.5e5]), [0.0, 0.0]);
    assert!(apart(&read(&cut, &[0.5e5]), &[0.0, 1.0]) < 1e-12);
    let topped = parse(text)
        .with_effect("gauge", "reading_clipping", &["limit"])
        .unwrap();
    assert!(apart(&read(&topped, &[0.5e5]), &[0.0, 0.5]) < 1e-12);
}

#[test]
fn a_start_is_as_large_with_its_unit_as_without() {
    let most = |start: &str| {
        let system =
            parse(&FED_TANK.replace("\"tank.level\" = 0.1", &format!("\"tank.level\" = {start}")));
        let all = effects_for(&system);
        let found = all.iter().find(|h| h.effect == "outlet_offset").unwrap();
        found.parameters[0].high
    };
    assert_eq!(most("2.0"), most("\"2 m\""));
    assert!(most("2.0") > most("1.0"));
}

#[test]
fn a_held_out_part_reads_the_columns_of_the_training_part_unless_it_names_its_own() {
    let parts = |test: &str| {
        let train = "train = { channels = { q = \"qA\" }, windows = [[0.0, 100.0]] }";
        FED_TANK.replace("step = 4.0", &format!("step = 4.0\n{train}\n{test}"))
    };
    let columns = [5e-5, 9.9, 0.1].map(|v| vec![v; 200]);
    let record = Record {
        columns: vec![("qA", &columns[0]), ("q", &columns[1]), ("h", &columns[2])],
    };
    let read = |test: &str| {
        let system = parse(&parts(test));
        let windows = system.windows(&record, Portion::Test).unwrap();
        (windows[0].inputs[0][0], system.holds_out_of_one_run())
    };
    assert_eq!(read("test = { windows = [[400.0, 500.0]] }"), (5e-5, true));
    let own = "test = { channels = { q = \"q\" }, windows = [[400.0, 500.0]] }";
    assert_eq!(read(own), (9.9, false));
}

#[test]
fn the_rows_of_a_relation_are_taken_along_its_independent_variable() {
    let text = r#"
        independent = "depth"
        connections = ["pump -> string -> atmosphere"]
        [components]
        pump = { kind = "boundary" }
        string = { kind = "line", quadratic = 1e8 }
        standpipe = { kind = "instrument", measures = "pressure", of = "string.inlet", channel = "p" }
        [inputs]
        "pump.flow" = { channel = "q" }
        [record]
        time = "depth"
    "#;
    let system = parse(text);
    let depth = [10.0, 20.0, 30.0, 40.0];
    let (flow, pressure) = ([0.01, 0.02, f64::NAN, 0.04], [1e5, 2e5, 3e5, f64::NAN]);
    let sorted = window(
        &system,
        &[("depth", &depth), ("q", &flow), ("p", &pressure)],
    );
    let order = [2, 0, 3, 1];
    let mixed = |values: &[f64; 4]| order.map(|i| values[i]);
    let columns = [depth, flow, pressure].map(|c| mixed(&c));
    let shuffled = window(
        &system,
        &[
            ("depth", &columns[0]),
            ("q", &columns[1]),
            ("p", &columns[2]),
        ],
    );
    assert_eq!(sorted.time, depth);
    // A flow that is missing is the one before along the depth.
    assert_eq!(sorted.inputs[0], [0.01, 0.02, 0.02, 0.04]);
    assert_eq!(
        (sorted.time, &sorted.inputs),
        (shuffled.time, &shuffled.inputs)
    );
    assert_eq!(
        format!("{:?}", sorted.readings),
        format!("{:?}", shuffled.readings)
    );
}

#[test]
fn a_loose_start_is_the_reading_and_what_it_is_off_by() {
    let system = parse(&FED_TANK.replace("\"tank.level\" = 0.1\n", "").replace(
        "step = 4.0",
        "step = 4.0\ntrain.windows = [[0.0, 300.0], [400.0, 700.0]]",
    ));
    let mut noise = Noise(5);
    let flow = vec![5e-5; 200];
    let level: Vec<f64> = (0..200).map(|_| 0.1 + 2e-3 * noise.next()).collect();
    let record = Record {
        columns: vec![("q", &flow), ("h", &level)],
    };
    let windows = system.windows(&record, Portion::Train).unwrap();
    let loose = system.with_loose_starts(&windows).unwrap();
    let parameters = loose.parameters();
    let paths: Vec<&str> = parameters.iter().map(|p| p.path.as_str()).collect();
    assert_eq!(paths, ["tank.level", "tank.level@2"]);
    for p in &parameters {
        // The noise is uniform within a millimetre: 0.58 mm of standard deviation.
        assert!(p.start == 0.0 && p.low == -p.high, "{p:?}");
        assert!(p.high > 2e-3 && p.high < 1e-2, "{p:?}");
    }
    for (k, window) in windows.iter().enumerate() {
        let run = loose.simulate(&[1e-3, -2e-3], window, k, &tight()).unwrap();
        let off = [1e-3, -2e-3][k];
        assert!((run.states[0][0] - window.readings[0][0] - off).abs() < 1e-12);
    }
    // What does not scatter is taken at its word.
    let still = vec![0.1; 200];
    let record = Record {
        columns: vec![("q", &flow), ("h", &still)],
    };
    let windows = system.windows(&record, Portion::Train).unwrap();
    assert!(
        system
            .with_loose_starts(&windows)
            .unwrap()
            .parameters()
            .is_empty()
    );
    assert!(system.starts_measured() && !loose.starts_measured());
}
