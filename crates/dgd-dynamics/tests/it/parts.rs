//! Inputs that come in parts give what they give at once, to the last bit.

use crate::common::line;
use dgd_dynamics::inputs::Signal;
use dgd_dynamics::integrate::Method;
use dgd_dynamics::return_line::{
    LateParts, LineParts, LineState, OutputParts, Simulation, SimulationOptions, SteadyParts,
    derive_outputs, measured_flow, simulate_coupled, simulate_flow_alone, simulate_riser_alone,
    steady_state,
};
use proptest::prelude::*;

#[derive(Debug, Clone, Copy, PartialEq)]
enum Kind {
    Coupled,
    Riser,
    Flow,
}

const START: LineState = LineState {
    level_m: 140.0,
    flow_m3_s: 0.05,
};

fn at_once(kind: Kind, t: &[f64], a: &[f64], b: &[f64], options: &SimulationOptions) -> Simulation {
    let signal = |name, values| Signal::new(name, t, values, Default::default()).unwrap();
    let (a, b, line) = (signal("a", a), signal("b", b), line());
    match kind {
        Kind::Coupled => simulate_coupled(&line, START, &a, &b, t, options),
        Kind::Riser => simulate_riser_alone(&line, START.level_m, &a, &b, t, options),
        Kind::Flow => simulate_flow_alone(&line, START.flow_m3_s, &a, &b, t, options),
    }
    .unwrap()
}

fn in_parts(
    kind: Kind,
    t: &[f64],
    a: &[f64],
    b: &[f64],
    options: &SimulationOptions,
    part: usize,
) -> Simulation {
    let line = line();
    let mut run = match kind {
        Kind::Coupled => LineParts::coupled(&line, START, options),
        Kind::Riser => LineParts::riser_alone(&line, START.level_m, options),
        Kind::Flow => LineParts::flow_alone(&line, START.flow_m3_s, options),
    }
    .unwrap();
    let mut all: Option<Simulation> = None;
    let mut to = 0;
    while to < t.len() {
        to = (to + part).min(t.len());
        let from = all
            .as_ref()
            .map_or(0, |all| all.time_s.len().saturating_sub(1));
        let range = from..to;
        let (t_s, a, b) = (&t[range.clone()], &a[range.clone()], &b[range]);
        let found = run.add(t_s, a, b, to == t.len()).unwrap();
        let all = all.get_or_insert(Simulation {
            time_s: Vec::new(),
            level_m: Vec::new(),
            flow_m3_s: Vec::new(),
            ..found.clone()
        });
        all.time_s.extend(&found.time_s);
        all.level_m.extend(&found.level_m);
        all.flow_m3_s.extend(&found.flow_m3_s);
        (all.bounds, all.status, all.statistics) = (found.bounds, found.status, found.statistics);
    }
    all.unwrap()
}

/// Stretches that rest, ramp and wander.
fn series(n: usize, low: f64, high: f64) -> impl Strategy<Value = Vec<f64>> {
    let stretch = (0..4_u8, low..high, low..high, 1..60_usize);
    prop::collection::vec(stretch, 1..12).prop_map(move |stretches| {
        let values = stretches.iter().cycle().flat_map(|(how, a, b, length)| {
            let share = move |k: usize| k as f64 / *length as f64;
            (0..*length).map(move |k| match how {
                0 => *a,
                1 => a + (b - a) * share(k),
                2 => 0.5 * (a + b) + 0.5 * (b - a) * (7.0 * share(k)).sin(),
                _ => low,
            })
        });
        values.take(n).collect()
    })
}

fn bits(values: &[f64]) -> Vec<u64> {
    values.iter().map(|v| v.to_bits()).collect()
}

#[test]
fn a_pump_that_turns_backwards_is_refused_in_parts_too() {
    let (t, back) = ([0.0, 1.0], [50.0, -1.0]);
    let options = SimulationOptions::default();
    let refused = |mut parts: LineParts| parts.add(&t, &[100.0; 2], &back, true).is_err();
    assert!(refused(
        LineParts::coupled(&line(), START, &options).unwrap()
    ));
    assert!(refused(
        LineParts::flow_alone(&line(), START.flow_m3_s, &options).unwrap()
    ));
    // A riser's second input is a flow, which may run back.
    assert!(!refused(
        LineParts::riser_alone(&line(), START.level_m, &options).unwrap()
    ));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(150))]

    #[test]
    fn any_inputs_in_any_parts(
        (n, flow, speed, level) in (1..400_usize).prop_flat_map(|n| {
            (Just(n), series(n, 0.0, 0.09), series(n, 0.0, 80.0), series(n, 100.0, 200.0))
        }),
        part in 1..120_usize,
        step_s in prop_oneof![Just(1.0), Just(0.3), Just(40.0)],
        kind in prop_oneof![Just(Kind::Coupled), Just(Kind::Riser), Just(Kind::Flow)],
        method in prop_oneof![Just(Method::Rodasp), Just(Method::Rodas3), Just(Method::DormandPrince)],
        max_steps in prop_oneof![3 => Just(10_000_000), 1 => 1..500_usize],
    ) {
        let t: Vec<f64> = (0..n).map(|i| i as f64 * step_s).collect();
        let options = SimulationOptions { method, max_steps, ..SimulationOptions::default() };
        let (a, b) = match kind {
            Kind::Coupled => (&flow, &speed),
            Kind::Riser => (&flow, &flow),
            Kind::Flow => (&level, &speed),
        };
        let whole = at_once(kind, &t, a, b, &options);
        let parts = in_parts(kind, &t, a, b, &options, part);
        prop_assert_eq!(bits(&parts.time_s), bits(&whole.time_s));
        prop_assert_eq!(bits(&parts.level_m), bits(&whole.level_m));
        prop_assert_eq!(bits(&parts.flow_m3_s), bits(&whole.flow_m3_s));
        prop_assert_eq!(parts.bounds, whole.bounds);
        prop_assert_eq!(parts.status, whole.status);
        prop_assert_eq!(parts.statistics, whole.statistics);
    }

    #[test]
    fn what_follows_from_states_in_any_parts(
        (flow, speed, level) in (1..300_usize).prop_flat_map(|n| {
            (series(n, 0.0, 0.09), series(n, 0.0, 80.0), series(n, 100.0, 200.0))
        }),
        part in 1..80_usize,
        delay_s in prop_oneof![Just(0.0), 0.0..30.0_f64],
    ) {
        let (line, n) = (line(), flow.len());
        let t: Vec<f64> = (0..n).map(|i| i as f64 * 0.7).collect();
        let outputs = derive_outputs(&line, &level, &flow, &speed, true).unwrap();
        let steady = steady_state(&line, &level, &speed).unwrap();
        let late = measured_flow(&t, &flow, delay_s).unwrap();
        let mut output_parts = OutputParts::new(&line, true).unwrap();
        let mut steady_parts = SteadyParts::new(&line).unwrap();
        let mut late_parts = LateParts::new(delay_s).unwrap();
        for from in (0..n).step_by(part) {
            let here = from..n.min(from + part);
            let (h, q, w) = (&level[here.clone()], &flow[here.clone()], &speed[here.clone()]);
            let found = output_parts.add(h, q, w).unwrap();
            prop_assert_eq!(bits(&found.outlet_pa), bits(&outputs.outlet_pa[here.clone()]));
            prop_assert_eq!(bits(&found.head_m), bits(&outputs.head_m[here.clone()]));
            prop_assert_eq!(bits(&found.inlet_pa), bits(&outputs.inlet_pa[here.clone()]));
            let found = steady_parts.add(h, w).unwrap();
            prop_assert_eq!(bits(&found.flow_m3_s), bits(&steady.flow_m3_s[here.clone()]));
            let found = late_parts.add(&t[here.clone()], q).unwrap();
            prop_assert_eq!(bits(&found), bits(&late[here]));
        }
    }
}

#[test]
fn a_part_of_which_nothing_was_written_comes_again_from_its_first_sample() {
    let mut parts = LineParts::coupled(&line(), START, &SimulationOptions::default()).unwrap();
    // Inputs that do not bend may go on as they are: nothing is decided yet.
    let still = ([0.05; 3], [60.0; 3]);
    let first = parts
        .add(&[0.0, 1.0, 2.0], &still.0, &still.1, false)
        .unwrap();
    assert_eq!(first.time_s, [] as [f64; 0]);
    assert!(
        parts
            .add(&[500.0, 501.0, 502.0], &still.0, &still.1, true)
            .is_err()
    );
    let again = parts
        .add(&[0.0, 1.0, 2.0], &still.0, &still.1, true)
        .unwrap();
    assert_eq!(again.time_s, [0.0, 1.0, 2.0]);
}

/// A part goes on from the sample that was written last, and nothing comes behind the last one.
#[test]
fn parts_that_do_not_join_are_refused_and_leave_nothing_behind() {
    let time = |from: u32| -> Vec<f64> { (from..from + 10).map(f64::from).collect() };
    let inputs = |time: &[f64]| -> (Vec<f64>, Vec<f64>) {
        (
            time.iter().map(|t| 0.04 + 1e-4 * t).collect(),
            time.iter().map(|t| 60.0 + 0.1 * (t % 3.0)).collect(),
        )
    };
    let mut parts = LineParts::coupled(&line(), START, &SimulationOptions::default()).unwrap();
    let mut add = |time: &[f64], last: bool| {
        let (inflow, speed) = inputs(time);
        parts.add(time, &inflow, &speed, last)
    };
    let first = add(&time(0), false).unwrap();
    let reached = *first.time_s.last().unwrap();
    for wrong in [100, 0] {
        let refused = add(&time(wrong), false).unwrap_err().to_string();
        assert!(
            refused.contains("the time of the last sample that was written"),
            "{refused}"
        );
    }
    let rest: Vec<f64> = (0..8).map(|k| reached + f64::from(k)).collect();
    assert!(!add(&rest, true).unwrap().time_s.is_empty());
    let refused = add(&rest[7..], true).unwrap_err().to_string();
    assert!(refused.contains("no part behind the last one"), "{refused}");
}

#[test]
fn a_late_meter_goes_on_after_a_part_that_it_refused() {
    let mut late = LateParts::new(2.0).unwrap();
    let shown = late.add(&[0.0, 1.0, 2.0], &[1.0, 2.0, 3.0]).unwrap();
    assert_eq!(shown, [1.0, 1.0, 1.0]);
    assert!(late.add(&[3.0, 4.0], &[f64::NAN, 5.0]).is_err());
    assert_eq!(late.add(&[3.0, 4.0], &[4.0, 5.0]).unwrap(), [2.0, 3.0]);
}
