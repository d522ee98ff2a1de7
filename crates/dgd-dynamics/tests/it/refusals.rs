use dgd_dynamics::DynamicsError;
use dgd_dynamics::inputs::{InputError, Interpolation, Signal};
use dgd_dynamics::integrate::{IntegrateError, Method, Options, Plan, System, integrate};
use dgd_dynamics::return_line::{
    LineParts, LineState, ReturnLine, SimulationOptions, derive_outputs, linearise, measured_flow,
    simulate_coupled, simulate_flow_alone, simulate_riser_alone, steady_state,
};

use crate::common::{line, linear};

#[test]
fn a_signal_has_no_value_at_no_time() {
    for kind in [Interpolation::Linear, Interpolation::Hold] {
        let signal = Signal::new("speed", &[0.0, 1.0], &[3.0, 4.0], kind).unwrap();
        assert!(signal.at(f64::NAN).is_nan());
        assert_eq!(signal.at(-1.0), 3.0);
    }
}

#[test]
fn a_nan_sample_is_refused_with_signal_and_index() {
    let refuse =
        |t: &[f64], v: &[f64]| Signal::new("speed", t, v, Interpolation::Linear).unwrap_err();
    let error = refuse(&[0.0, 1.0, 2.0], &[1.0, f64::NAN, 2.0]);
    assert_eq!(
        error,
        InputError::NonFinite {
            name: "speed".into(),
            index: 1
        }
    );
    assert!(error.to_string().contains("`speed`") && error.to_string().contains("sample 1"));
    assert!(matches!(
        refuse(&[0.0], &[1.0, 2.0]),
        InputError::Length {
            expected: 1,
            found: 2,
            ..
        }
    ));
    assert!(matches!(refuse(&[], &[]), InputError::Empty { .. }));
    assert!(matches!(
        refuse(&[0.0, 0.0], &[1.0, 2.0]),
        InputError::Time { index: 1, .. }
    ));
    assert!(matches!(
        refuse(&[0.0, f64::INFINITY], &[1.0, 2.0]),
        InputError::NonFinite { index: 1, .. }
    ));
}

struct Nothing;

impl System for Nothing {
    fn dimension(&self) -> usize {
        2
    }
    fn rhs(&self, _: f64, _: &[f64], rate: &mut [f64]) {
        rate.fill(0.0);
    }
}

#[test]
fn unusable_plans_and_tolerances_are_refused() {
    let good = Options::new(1e-6, vec![1e-6; 2]);
    let plan = Plan {
        start: 0.0,
        end: 1.0,
        outputs: &[0.5],
        breaks: &[],
    };
    let go = |x: &[f64], plan: Plan<'_>, options: &Options| {
        integrate(Method::Rodasp, &mut Nothing, x, &plan, options)
    };
    assert!(go(&[0.0; 2], plan, &good).is_ok());
    let name = |error: IntegrateError| match error {
        IntegrateError::Dimension { name, .. } | IntegrateError::Value { name, .. } => name,
        other => panic!("{other}"),
    };
    assert_eq!(name(go(&[0.0], plan, &good).unwrap_err()), "initial");
    assert_eq!(
        name(go(&[0.0, f64::NAN], plan, &good).unwrap_err()),
        "initial"
    );
    let with = |options: Options| name(go(&[0.0; 2], plan, &options).unwrap_err());
    assert_eq!(with(Options::new(1e-6, vec![1e-6])), "absolute");
    assert_eq!(with(Options::new(1e-6, vec![1e-6, 0.0])), "absolute");
    assert_eq!(with(Options::new(f64::NAN, vec![1e-6; 2])), "relative");
    assert_eq!(
        with(Options {
            max_step: 0.0,
            ..good.clone()
        }),
        "max_step"
    );
    assert_eq!(
        with(Options {
            first_step: Some(-1.0),
            ..good.clone()
        }),
        "first_step"
    );
    for first_step in [0.0, f64::INFINITY] {
        let first_step = Some(first_step);
        let options = good.clone();
        assert_eq!(
            with(Options {
                first_step,
                ..options
            }),
            "first_step"
        );
    }
    for max_step in [-1.0, f64::NAN] {
        let options = good.clone();
        assert_eq!(
            with(Options {
                max_step,
                ..options
            }),
            "max_step"
        );
    }
    for wrong in [-1e-9, f64::INFINITY] {
        assert_eq!(with(Options::new(wrong, vec![1e-6; 2])), "relative");
        assert_eq!(with(Options::new(1e-6, vec![1e-6, wrong])), "absolute");
    }
    assert!(go(&[0.0; 2], plan, &Options::new(0.0, vec![1e-6; 2])).is_ok());
    let at = |plan: Plan<'_>| name(go(&[0.0; 2], plan, &good).unwrap_err());
    assert_eq!(
        at(Plan {
            start: f64::NAN,
            ..plan
        }),
        "start"
    );
    assert_eq!(at(Plan { end: -1.0, ..plan }), "end");
    assert_eq!(
        at(Plan {
            end: f64::INFINITY,
            ..plan
        }),
        "end"
    );
    assert_eq!(
        at(Plan {
            breaks: &[0.5, f64::NAN],
            ..plan
        }),
        "breaks"
    );
    // Twice the same time, and the ends of the span, are no trouble.
    let ends = Plan {
        outputs: &[0.0, 0.5, 0.5, 1.0, 1.0],
        breaks: &[0.5, 0.5],
        ..plan
    };
    let run = go(&[0.0; 2], ends, &good).unwrap();
    assert_eq!(run.times, ends.outputs);
    let point = Plan {
        end: 0.0,
        outputs: &[0.0],
        ..plan
    };
    assert_eq!(go(&[0.0; 2], point, &good).unwrap().times, [0.0]);
    assert_eq!(
        at(Plan {
            outputs: &[0.5, 0.4],
            ..plan
        }),
        "outputs"
    );
    assert_eq!(
        at(Plan {
            outputs: &[1.5],
            ..plan
        }),
        "outputs"
    );
    assert_eq!(
        at(Plan {
            breaks: &[0.5, 0.4],
            ..plan
        }),
        "breaks"
    );
}

#[test]
fn each_parameter_of_the_line_is_refused_by_name_where_it_cannot_be() {
    type Field = fn(&mut ReturnLine) -> &mut f64;
    let positive: [(&str, Field); 5] = [
        ("density_kg_m3", |l| &mut l.density_kg_m3),
        ("riser_area_m2", |l| &mut l.riser_area_m2),
        ("line_area_m2", |l| &mut l.line_area_m2),
        ("inlet_depth_m", |l| &mut l.inlet_depth_m),
        ("outlet_depth_m", |l| &mut l.outlet_depth_m),
    ];
    let finite: [(&str, Field); 7] = [
        ("b_pa", |l| &mut l.friction.b_pa),
        ("c_pa_s_m3", |l| &mut l.friction.c_pa_s_m3),
        ("d_pa_s2_m6", |l| &mut l.friction.d_pa_s2_m6),
        ("e_pa_s3_m9", |l| &mut l.friction.e_pa_s3_m9),
        ("c0", |l| &mut l.pump.c0),
        ("c1", |l| &mut l.pump.c1),
        ("c2", |l| &mut l.pump.c2),
    ];
    let exponents: [(&str, Field); 2] = [("n0", |l| &mut l.pump.n0), ("n2", |l| &mut l.pump.n2)];
    let refused = |field: Field, value: f64| {
        let mut line = line();
        *field(&mut line) = value;
        match line.check() {
            Err(DynamicsError::Parameter { name, found, .. }) => {
                assert!(found == value || value.is_nan());
                Some(name)
            }
            Err(other) => panic!("{other}"),
            Ok(()) => None,
        }
    };
    for (name, field) in positive.into_iter().chain(finite).chain(exponents) {
        assert_eq!(refused(field, f64::NAN), Some(name));
        assert_eq!(refused(field, f64::INFINITY), Some(name));
    }
    for (name, field) in positive {
        assert_eq!(refused(field, 0.0), Some(name));
        assert_eq!(refused(field, -1.0), Some(name));
    }
    for (_, field) in finite {
        assert_eq!(refused(field, -1.0), None);
    }
    for (name, field) in exponents {
        assert_eq!(refused(field, 0.999), Some(name));
        assert_eq!(refused(field, 1.0), None);
    }
}

#[test]
fn an_operating_point_that_cannot_be_is_not_linearised() {
    let at = |level_m, flow_m3_s, speed| {
        let state = LineState { level_m, flow_m3_s };
        match linearise(&line(), state, speed) {
            Err(DynamicsError::Parameter { name, .. }) => Some(name),
            Err(other) => panic!("{other}"),
            Ok(_) => None,
        }
    };
    assert_eq!(at(f64::NAN, 0.05, 60.0), Some("level_m"));
    assert_eq!(at(140.0, f64::INFINITY, 60.0), Some("flow_m3_s"));
    for speed in [-0.1, f64::NAN, f64::INFINITY] {
        assert_eq!(at(140.0, 0.05, speed), Some("speed_pct"));
    }
    assert_eq!(at(140.0, 0.05, 0.0), None);
}

#[test]
fn an_input_must_cover_both_ends_of_the_span() {
    let start = LineState {
        level_m: 140.0,
        flow_m3_s: 0.05,
    };
    let go = |inflow: [f64; 2], speed: [f64; 2], span: [f64; 2]| {
        let (u, w) = ([0.05; 2], [60.0; 2]);
        let run = simulate_coupled(
            &line(),
            start,
            &linear(&inflow, &u),
            &Signal::new("speed", &speed, &w, Interpolation::Linear).unwrap(),
            &span,
            &SimulationOptions::default(),
        );
        match run {
            Err(DynamicsError::Span { name, .. }) => Some(name),
            Err(other) => panic!("{other}"),
            Ok(_) => None,
        }
    };
    assert_eq!(go([0.0, 10.0], [0.0, 10.0], [0.0, 10.0]), None);
    assert_eq!(
        go([1.0, 10.0], [0.0, 10.0], [0.0, 10.0]),
        Some("signal".to_owned())
    );
    assert_eq!(
        go([0.0, 10.0], [0.0, 9.0], [0.0, 10.0]),
        Some("speed".to_owned())
    );
}

#[test]
fn unusable_parameters_inputs_and_spans_are_refused() {
    let t = [0.0, 10.0];
    let start = LineState {
        level_m: 140.0,
        flow_m3_s: 0.05,
    };
    let (inflow, speed) = ([0.05; 2], [60.0; 2]);
    let options = SimulationOptions::default();
    let go = |line, speed: &[f64], outputs: &[f64]| {
        simulate_coupled(
            &line,
            start,
            &linear(&t, &inflow),
            &linear(&t, speed),
            outputs,
            &options,
        )
    };
    assert!(go(line(), &speed, &t).is_ok());
    let mut bad = line();
    bad.riser_area_m2 = 0.0;
    assert!(matches!(
        go(bad, &speed, &t),
        Err(DynamicsError::Parameter {
            name: "riser_area_m2",
            ..
        })
    ));
    let mut bad = line();
    bad.pump.n2 = 0.9;
    assert!(matches!(
        go(bad, &speed, &t),
        Err(DynamicsError::Parameter { name: "n2", .. })
    ));
    let mut bad = line();
    bad.friction.d_pa_s2_m6 = f64::NAN;
    assert!(matches!(
        go(bad, &speed, &t),
        Err(DynamicsError::Parameter {
            name: "d_pa_s2_m6",
            ..
        })
    ));
    assert!(matches!(
        go(line(), &[60.0, -1.0], &t),
        Err(DynamicsError::Sample { index: 1, .. })
    ));
    assert!(matches!(
        go(line(), &speed, &[0.0, 11.0]),
        Err(DynamicsError::Span { .. })
    ));
    assert!(matches!(
        go(line(), &speed, &[]),
        Err(DynamicsError::Length {
            name: "output_s",
            ..
        })
    ));
    for (outputs, place) in [
        (&[5.0, 4.0][..], 1),
        (&[f64::NAN], 0),
        (&[0.0, f64::NAN, 2.0], 1),
        (&[0.0, 1.0, f64::INFINITY], 2),
    ] {
        match go(line(), &speed, outputs) {
            Err(DynamicsError::Sample { name, index, .. }) => {
                assert_eq!((name.as_str(), index), ("output_s", place));
            }
            other => panic!("{other:?}"),
        }
    }
    assert!(matches!(
        steady_state(&line(), &[1.0], &[]),
        Err(DynamicsError::Length { .. })
    ));
    assert!(matches!(
        steady_state(&line(), &[f64::NAN], &[1.0]),
        Err(DynamicsError::Sample { index: 0, .. })
    ));
    assert!(matches!(
        derive_outputs(&line(), &[1.0], &[], &[1.0], false),
        Err(DynamicsError::Length { .. })
    ));
    assert!(matches!(
        measured_flow(&[0.0], &[f64::NAN], 1.0),
        Err(DynamicsError::Input(_))
    ));
    assert!(matches!(
        measured_flow(&[0.0], &[1.0], f64::NAN),
        Err(DynamicsError::Parameter { .. })
    ));
}

#[test]
fn a_start_or_tolerance_that_cannot_be_is_refused_by_its_own_name() {
    let t = [0.0, 10.0];
    let (first, second) = ([0.05; 2], [60.0; 2]);
    let (first, second) = (linear(&t, &first), linear(&t, &second));
    let name = |error| match error {
        DynamicsError::Parameter { name, .. } => name,
        other => panic!("{other}"),
    };
    let good = SimulationOptions::default();
    let no_level = SimulationOptions {
        level_tolerance_m: 0.0,
        ..good
    };
    let no_flow = SimulationOptions {
        flow_tolerance_m3_s: f64::NAN,
        ..good
    };
    for (level_m, flow_m3_s, options, expected) in [
        (f64::NAN, 0.05, good, "start.level_m"),
        (140.0, f64::INFINITY, good, "start.flow_m3_s"),
        (140.0, 0.05, no_level, "level_tolerance_m"),
        (140.0, 0.05, no_flow, "flow_tolerance_m3_s"),
    ] {
        let start = LineState { level_m, flow_m3_s };
        let at_once = simulate_coupled(&line(), start, &first, &second, &t, &options);
        assert_eq!(name(at_once.unwrap_err()), expected);
        let in_parts = LineParts::coupled(&line(), start, &options);
        assert_eq!(name(in_parts.unwrap_err()), expected);
    }
    let riser = |level_m, options| {
        let run = simulate_riser_alone(&line(), level_m, &first, &first, &t, &options);
        name(run.unwrap_err())
    };
    assert_eq!(riser(f64::NAN, good), "start_level_m");
    assert_eq!(riser(140.0, no_level), "level_tolerance_m");
    let level = linear(&t, &[140.0; 2]);
    let flow = |flow_m3_s, options| {
        let run = simulate_flow_alone(&line(), flow_m3_s, &level, &second, &t, &options);
        name(run.unwrap_err())
    };
    assert_eq!(flow(f64::NAN, good), "start_flow_m3_s");
    assert_eq!(flow(0.05, no_flow), "flow_tolerance_m3_s");
}

#[test]
fn a_start_outside_the_riser_or_against_the_valve_is_refused() {
    let t = [0.0, 10.0];
    let (inflow, speed, level) = ([0.05; 2], [60.0; 2], [140.0; 2]);
    let (inflow, speed, level) = (linear(&t, &inflow), linear(&t, &speed), linear(&t, &level));
    let options = SimulationOptions::default();
    let name = |error| match error {
        Some(DynamicsError::Parameter { name, .. }) => Some(name),
        None => None,
        Some(other) => panic!("{other}"),
    };
    let with = |non_return_valve| ReturnLine {
        non_return_valve,
        ..line()
    };
    let coupled = |line: &ReturnLine, level_m, flow_m3_s| {
        let start = LineState { level_m, flow_m3_s };
        let at_once = simulate_coupled(line, start, &inflow, &speed, &t, &options);
        let in_parts = LineParts::coupled(line, start, &options);
        let found = name(at_once.err());
        assert_eq!(name(in_parts.err()), found);
        found
    };
    let (valve, open) = (with(true), with(false));
    assert_eq!(coupled(&valve, 150.0, -0.05), Some("start.flow_m3_s"));
    assert_eq!(coupled(&open, 150.0, -0.05), None);
    for level_m in [-20.0, 350.4, 1e300] {
        assert_eq!(coupled(&valve, level_m, 0.05), Some("start.level_m"));
        let riser = simulate_riser_alone(&open, level_m, &inflow, &inflow, &t, &options);
        assert_eq!(name(riser.err()), Some("start_level_m"));
    }
    for level_m in [0.0, 350.3] {
        assert_eq!(coupled(&valve, level_m, 0.0), None);
    }
    let flow = |line| simulate_flow_alone(line, -0.05, &level, &speed, &t, &options);
    assert_eq!(name(flow(&valve).err()), Some("start_flow_m3_s"));
    assert_eq!(name(flow(&open).err()), None);
}
