//! What an integration costs, to the step: a change of the step control shows here first.

use dgd_dynamics::integrate::{
    Method, Options, Plan, Statistics, Status, System, Trajectory, integrate,
};
use dgd_dynamics::return_line::{LineState, SimulationOptions, simulate_coupled};

use crate::common::{METHODS, kinked_inputs, line, linear};

/// `dx/dt = f(x)` in arithmetic that every machine does alike.
struct Plain<F>(usize, F);

impl<F: Fn(&[f64], &mut [f64])> System for Plain<F> {
    fn dimension(&self) -> usize {
        self.0
    }
    fn rhs(&self, _: f64, x: &[f64], rate: &mut [f64]) {
        (self.1)(x, rate);
    }
}

fn spring() -> impl System {
    Plain(2, |x: &[f64], d: &mut [f64]| (d[0], d[1]) = (x[1], -x[0]))
}

/// Van der Pol's oscillator: rests for long, then snaps.
fn snapping() -> impl System {
    Plain(2, |x: &[f64], d: &mut [f64]| {
        (d[0], d[1]) = (x[1], 20.0 * (1.0 - x[0] * x[0]) * x[1] - x[0]);
    })
}

fn run(method: Method, system: &mut impl System, plan: &Plan<'_>, options: &Options) -> Trajectory {
    let run = integrate(method, system, &[2.0, 0.0], plan, options).unwrap();
    assert_eq!(run.status, Status::Finished);
    run
}

fn span<'a>(end: f64, breaks: &'a [f64]) -> Plan<'a> {
    Plan {
        start: 0.0,
        end,
        outputs: &[],
        breaks,
    }
}

fn counts(s: Statistics) -> [usize; 5] {
    [s.steps, s.rejected, s.rhs, s.jacobians, s.factorisations]
}

#[test]
fn a_spring_and_a_snapping_oscillator_cost_what_they_did() {
    let options = Options::new(1e-6, vec![1e-6; 2]);
    let of = |method, end| {
        let spring = run(method, &mut spring(), &span(end, &[]), &options);
        let snapping = run(method, &mut snapping(), &span(2.0 * end, &[]), &options);
        [spring, snapping].map(|run| counts(run.statistics))
    };
    assert_eq!(
        of(Method::DormandPrince, 20.0),
        [[88, 0, 530, 0, 0], [605, 27, 3794, 0, 0]]
    );
    assert_eq!(
        of(Method::Rodasp, 20.0),
        [[152, 0, 1369, 152, 152], [363, 31, 3423, 363, 394]]
    );
    assert_eq!(
        of(Method::Rodas3, 20.0),
        [[717, 0, 4303, 717, 717], [1094, 11, 6587, 1094, 1105]]
    );
}

#[test]
fn a_first_step_that_is_too_long_is_cut_and_breaks_do_not_shorten_the_steps_after_them() {
    let options = Options {
        first_step: Some(5.0),
        ..Options::new(1e-6, vec![1e-6; 2])
    };
    let breaks = [0.5, 0.51, 3.0, 7.0, 7.3];
    let of = |method| {
        let plan = span(10.0, &breaks);
        counts(run(method, &mut spring(), &plan, &options).statistics)
    };
    assert_eq!(of(Method::DormandPrince), [46, 1, 288, 0, 0]);
    assert_eq!(of(Method::Rodasp), [78, 1, 707, 78, 79]);
    assert_eq!(of(Method::Rodas3), [362, 2, 2176, 362, 364]);
}

#[test]
fn no_step_is_longer_than_allowed() {
    for method in METHODS {
        let with = |max_step| {
            let options = Options {
                max_step,
                ..Options::new(1e-3, vec![1e-3; 2])
            };
            let run = run(method, &mut spring(), &span(4.0, &[]), &options);
            run.statistics.steps
        };
        assert!(with(f64::INFINITY) < 40, "{method:?}");
        // 128 steps of 1/32 s, and a few shorter ones at the start.
        let steps = with(0.03125);
        assert!((128..140).contains(&steps), "{method:?}: {steps}");
    }
}

#[test]
fn a_recording_at_one_hertz_costs_what_it_did() {
    let (time, inflow, speed) = kinked_inputs(120);
    let start = LineState {
        level_m: 140.0,
        flow_m3_s: 0.05,
    };
    let of = |method| {
        let options = SimulationOptions {
            method,
            ..SimulationOptions::default()
        };
        let (u, w) = (linear(&time, &inflow), linear(&time, &speed));
        let run = simulate_coupled(&line(), start, &u, &w, &time, &options).unwrap();
        counts(run.statistics)
    };
    assert_eq!(of(Method::DormandPrince), [182, 0, 1213, 0, 0]);
    assert_eq!(of(Method::Rodasp), [120, 0, 721, 120, 120]);
    // Of lower order: where an input bends sharply a second takes two steps.
    assert_eq!(of(Method::Rodas3), [171, 5, 524, 171, 176]);
}

#[test]
fn from_rest_the_first_step_is_a_millionth_and_the_next_are_longer_and_longer() {
    for method in METHODS {
        let mut rest = Plain(2, |_: &[f64], d: &mut [f64]| d.fill(0.0));
        let run = run(
            method,
            &mut rest,
            &span(1.0, &[]),
            &Options::new(1e-6, vec![1e-6; 2]),
        );
        // Ten times, or six, as long as the one before.
        assert!(
            (7..=10).contains(&run.statistics.steps),
            "{:?}",
            run.statistics
        );
    }
}
