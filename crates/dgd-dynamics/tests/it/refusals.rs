use dgd_dynamics::DynamicsError;
use dgd_dynamics::inputs::{InputError, Interpolation, Signal};
use dgd_dynamics::integrate::{IntegrateError, Method, Options, Plan, System, integrate};
use dgd_dynamics::return_line::{
    LineState, SimulationOptions, derive_outputs, measured_flow, simulate_coupled, steady_state,
};

use crate::common::{line, linear};

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
        integrate(Method::Rodas, &mut Nothing, x, &plan, options)
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
    assert!(matches!(
        go(line(), &speed, &[5.0, 1.0]),
        Err(DynamicsError::Integrate(_))
    ));
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
