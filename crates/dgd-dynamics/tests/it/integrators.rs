use dgd_dynamics::inputs::{Cursor, Interpolation, Piece, Signal, merged_kinks};
use dgd_dynamics::integrate::{
    Linearised, Method, Options, Plan, Status, System, Trajectory, integrate,
};

use crate::common::{METHODS, Noise, slope};

/// `dx/dt = f(t, x)` from a closure, derivatives by finite differences.
struct Closure<F>(usize, F);

impl<F: Fn(f64, &[f64], &mut [f64])> System for Closure<F> {
    fn dimension(&self) -> usize {
        self.0
    }
    fn rhs(&self, t: f64, x: &[f64], rate: &mut [f64]) {
        (self.1)(t, x, rate);
    }
}

fn run<S: System>(method: Method, s: &mut S, x: &[f64], outputs: &[f64], tol: f64) -> Trajectory {
    let plan = Plan {
        start: 0.0,
        end: *outputs.last().unwrap(),
        outputs,
        breaks: &[],
    };
    integrate(method, s, x, &plan, &Options::new(tol, vec![tol; x.len()])).unwrap()
}

/// Runs with `n` equal steps: the tolerance accepts everything and breaks force the grid.
fn fixed<S: System>(
    method: Method,
    s: &mut S,
    x: &[f64],
    end: f64,
    n: u32,
    outputs: &[f64],
) -> Trajectory {
    let breaks: Vec<f64> = (1..n).map(|k| end * f64::from(k) / f64::from(n)).collect();
    let plan = Plan {
        start: 0.0,
        end,
        outputs,
        breaks: &breaks,
    };
    let options = Options {
        first_step: Some(end),
        ..Options::new(0.0, vec![1e9; x.len()])
    };
    let run = integrate(method, s, x, &plan, &options).unwrap();
    assert_eq!(run.statistics.steps, usize::try_from(n).unwrap());
    run
}

/// A non-linear, non-autonomous pair with a closed form: x = cos(t²)+2, y = exp(sin t).
struct Pair;

impl System for Pair {
    fn dimension(&self) -> usize {
        2
    }
    fn rhs(&self, t: f64, x: &[f64], rate: &mut [f64]) {
        let (a, b) = ((t * t).cos() + 2.0, t.sin().exp());
        // The coupling vanishes on the solution, so it only tests the Jacobian terms.
        rate[0] = -2.0 * t * (t * t).sin() + (x[1] * x[1] - b * b) - (x[0] - a);
        rate[1] = t.cos() * x[1] + 0.5 * (x[0] - a) * x[1];
    }
}

fn pair(t: f64) -> [f64; 2] {
    [(t * t).cos() + 2.0, t.sin().exp()]
}

#[test]
fn observed_order_is_that_of_the_method() {
    for (method, order) in [
        (Method::DormandPrince, 5.0),
        (Method::Rodasp, 4.0),
        (Method::Rodas3, 3.0),
    ] {
        let (mut x, mut y) = (Vec::new(), Vec::new());
        for n in [40, 57, 80, 113, 160] {
            let run = fixed(method, &mut Pair, &pair(0.0), 1.5, n, &[]);
            let error = (run.end_state[0] - pair(1.5)[0]).hypot(run.end_state[1] - pair(1.5)[1]);
            x.push(f64::from(n).ln());
            y.push(-error.ln());
        }
        let found = slope(&x, &y);
        assert!((found - order).abs() < 0.25, "{method:?}: {found}");
    }
}

#[test]
fn dense_output_is_as_good_as_the_steps() {
    // The largest error between the grid points falls with one power more than the global order
    // of the continuous extension, limited by the order of the steps.
    for (method, order) in [
        (Method::DormandPrince, 5.0),
        (Method::Rodasp, 4.0),
        (Method::Rodas3, 3.0),
    ] {
        let outputs: Vec<f64> = (1..=997).map(|k| 1.5 * f64::from(k) / 998.0).collect();
        let (mut x, mut y) = (Vec::new(), Vec::new());
        for n in [20, 28, 40, 57, 80] {
            let run = fixed(method, &mut Pair, &pair(0.0), 1.5, n, &outputs);
            assert_eq!(run.times, outputs);
            let error = run.iter().fold(0.0_f64, |e, (t, x)| {
                e.max((x[0] - pair(t)[0]).abs())
                    .max((x[1] - pair(t)[1]).abs())
            });
            x.push(f64::from(n).ln());
            y.push(-error.ln());
        }
        let found = slope(&x, &y);
        assert!(
            found > order - 0.3 && found < order + 0.7,
            "{method:?}: {found}"
        );
    }
}

#[test]
fn decay_and_oscillator_meet_their_tolerance() {
    for method in METHODS {
        for tol in [1e-4, 1e-6, 1e-8] {
            let mut decay = Closure(1, |_, x: &[f64], d: &mut [f64]| d[0] = -x[0]);
            let outputs: Vec<f64> = (0..=20).map(|k| 0.25 * f64::from(k)).collect();
            let run = self::run(method, &mut decay, &[1.0], &outputs, tol);
            assert_eq!(run.status, Status::Finished);
            for (t, x) in run.times.iter().zip(&run.states) {
                assert!(
                    (x - (-t).exp()).abs() < 20.0 * tol,
                    "{method:?} {tol} at {t}"
                );
            }
            let mut spring = Closure(2, |_, x: &[f64], d: &mut [f64]| {
                d[0] = x[1];
                d[1] = -x[0];
            });
            let run = self::run(
                method,
                &mut spring,
                &[1.0, 0.0],
                &[std::f64::consts::TAU],
                tol,
            );
            assert!(
                (run.states[0] - 1.0).hypot(run.states[1]) < 100.0 * tol,
                "{method:?} {tol}"
            );
        }
    }
}

/// `x' = −λ(x − sin t) + cos t` with analytic derivatives; the solution is `sin t`.
struct ProtheroRobinson(f64);

impl System for ProtheroRobinson {
    fn dimension(&self) -> usize {
        1
    }
    fn rhs(&self, t: f64, x: &[f64], rate: &mut [f64]) {
        rate[0] = -self.0 * (x[0] - t.sin()) + t.cos();
    }
    fn jacobian(&self, _: f64, _: &[f64], _: &[f64], jacobian: &mut [f64]) -> usize {
        jacobian[0] = -self.0;
        0
    }
    fn time_derivative(&self, t: f64, _: &[f64], _: &[f64], _: f64, drift: &mut [f64]) -> usize {
        drift[0] = self.0 * t.cos() - t.sin();
        0
    }
}

#[test]
fn stiffness_never_makes_rodas_less_accurate() {
    let error = |lambda: f64, n: u32| {
        let run = fixed(
            Method::Rodasp,
            &mut ProtheroRobinson(lambda),
            &[0.0],
            3.0,
            n,
            &[],
        );
        (run.end_state[0] - 3.0_f64.sin()).abs()
    };
    let steps = [10, 14, 20, 28, 40];
    for n in steps {
        for lambda in [1e1, 1e2, 1e3, 1e4, 1e6] {
            assert!(
                error(lambda, n) < 0.5 * error(1.0, n),
                "{lambda}, {n} steps"
            );
        }
    }
    // λh from 7 to 30: where methods of the older kind fall back to second order.
    let x: Vec<f64> = steps.iter().map(|&n| f64::from(n).ln()).collect();
    let y: Vec<f64> = steps.iter().map(|&n| -error(1e2, n).ln()).collect();
    let found = slope(&x, &y);
    assert!(found > 3.0, "observed order {found}");
}

#[test]
fn rodas_takes_few_steps_where_the_explicit_method_is_limited_by_stability() {
    let steps = |method| {
        let run = run(method, &mut ProtheroRobinson(1e5), &[0.0], &[3.0], 1e-5);
        assert_eq!(run.status, Status::Finished);
        assert!((run.end_state[0] - 3.0_f64.sin()).abs() < 1e-4);
        run.statistics.steps
    };
    assert!(steps(Method::Rodasp) < 60);
    assert!(steps(Method::Rodas3) < 120);
    assert!(steps(Method::DormandPrince) > 50_000);
}

#[test]
fn an_infinitely_fast_mode_is_damped_in_one_step() {
    // R(∞) = 0: one step of 1 with λ = 1e12 leaves nothing of the initial deviation.
    let mut fast = Closure(1, |_, x: &[f64], d: &mut [f64]| d[0] = -1e12 * x[0]);
    for method in [Method::Rodasp, Method::Rodas3] {
        let run = fixed(method, &mut fast, &[1.0], 1.0, 1, &[]);
        assert!(run.end_state[0].abs() < 1e-6, "{}", run.end_state[0]);
    }
}

/// Integrates a piecewise-linear input: `dx/dt = u(t)`.
struct Integral<'a>(Signal<'a>, Cursor, Piece);

impl System for Integral<'_> {
    fn dimension(&self) -> usize {
        1
    }
    fn rhs(&self, t: f64, _: &[f64], rate: &mut [f64]) {
        rate[0] = self.2.at(t);
    }
    fn linearise(&self, t: f64, x: &[f64], _: f64, out: Linearised<'_>) -> usize {
        self.rhs(t, x, out.rate);
        out.jacobian[0] = 0.0;
        out.drift[0] = self.2.slope;
        1
    }
    fn begin_segment(&mut self, start: f64, end: f64, _: &[f64]) {
        self.2 = self.0.piece(&mut self.1, start, end);
    }
}

#[test]
fn stopping_at_kinks_integrates_sampled_inputs_to_round_off() {
    let mut noise = Noise(3);
    let mut at = 0.0;
    let time: Vec<f64> = (0..500)
        .map(|_| {
            at += 1.0 + noise.next();
            at
        })
        .collect();
    let values: Vec<f64> = time.iter().map(|_| noise.next()).collect();
    for kind in [Interpolation::Linear, Interpolation::Hold] {
        let mut exact = vec![0.0];
        for k in 1..time.len() {
            let mean = match kind {
                Interpolation::Linear => 0.5 * (values[k] + values[k - 1]),
                Interpolation::Hold => values[k - 1],
            };
            exact.push(exact[k - 1] + mean * (time[k] - time[k - 1]));
        }
        let signal = Signal::new("u", &time, &values, kind).unwrap();
        let end = time[time.len() - 1];
        let breaks = merged_kinks(&[&signal], time[0], end);
        let plan = Plan {
            start: time[0],
            end,
            outputs: &time,
            breaks: &breaks,
        };
        for method in METHODS {
            let mut system = Integral(signal, Cursor::default(), Piece::default());
            let run = integrate(
                method,
                &mut system,
                &[0.0],
                &plan,
                &Options::new(1e-6, vec![1e-6]),
            )
            .unwrap();
            assert_eq!(run.times, time);
            for (k, (found, expected)) in run.states.iter().zip(&exact).enumerate() {
                assert!(
                    (found - expected).abs() < 1e-12,
                    "{method:?} {kind:?} sample {k}"
                );
            }
        }
    }
}

#[test]
fn constant_inputs_do_not_stop_the_integrator() {
    let time: Vec<f64> = (0..10_000).map(f64::from).collect();
    let values = vec![0.3; time.len()];
    let signal = Signal::new("u", &time, &values, Interpolation::Linear).unwrap();
    let breaks = merged_kinks(&[&signal], 0.0, 9999.0);
    let plan = Plan {
        start: 0.0,
        end: 9999.0,
        outputs: &time,
        breaks: &breaks,
    };
    for method in METHODS {
        let mut system = Integral(signal, Cursor::default(), Piece::default());
        let run = integrate(
            method,
            &mut system,
            &[0.0],
            &plan,
            &Options::new(1e-6, vec![1e-6]),
        )
        .unwrap();
        assert!(run.statistics.steps < 40, "{:?}", run.statistics);
        for (t, x) in time.iter().zip(&run.states) {
            assert!((x - 0.3 * t).abs() < 1e-9);
        }
    }
}

/// Coupled states with time constants from 1e-4 to 10 s; the modes are mixed by a Householder
/// reflection, so the closed form is known.
fn stiff_modes(n: usize) -> (Vec<f64>, Vec<f64>) {
    let rates: Vec<f64> = (0..n)
        .map(|k| -0.1 * 10_f64.powf(5.0 * k as f64 / (n - 1) as f64))
        .collect();
    let v: Vec<f64> = (0..n).map(|k| 1.0 + 0.3 * k as f64).collect();
    let norm: f64 = v.iter().map(|v| v * v).sum();
    let mut a = vec![0.0; n * n];
    let q = |i: usize, j: usize| f64::from(u8::from(i == j)) - 2.0 * v[i] * v[j] / norm;
    for i in 0..n {
        for j in 0..n {
            a[i * n + j] = (0..n).map(|k| q(i, k) * rates[k] * q(j, k)).sum();
        }
    }
    (rates, a)
}

#[test]
fn stiff_systems_of_any_dimension_follow_their_closed_form() {
    for n in [2, 3, 4, 5, 6, 7, 9] {
        let (rates, a) = stiff_modes(n);
        let v: Vec<f64> = (0..n).map(|k| 1.0 + 0.3 * k as f64).collect();
        let norm: f64 = v.iter().map(|v| v * v).sum();
        let reflect = |x: &[f64]| -> Vec<f64> {
            let dot: f64 = x.iter().zip(&v).map(|(x, v)| x * v).sum();
            x.iter()
                .zip(&v)
                .map(|(x, v)| x - 2.0 * v * dot / norm)
                .collect()
        };
        let start = vec![1.0; n];
        let modes = reflect(&start);
        let mut system = Closure(n, |_, x: &[f64], d: &mut [f64]| {
            for i in 0..n {
                d[i] = (0..n).map(|j| a[i * n + j] * x[j]).sum();
            }
        });
        let outputs = [0.01, 0.5, 5.0];
        let run = run(Method::Rodasp, &mut system, &start, &outputs, 1e-7);
        assert_eq!(run.status, Status::Finished);
        assert!(run.statistics.steps < 300, "n {n}: {:?}", run.statistics);
        assert_eq!(run.iter().len(), 3);
        for (t, found) in run.iter() {
            let now: Vec<f64> = modes
                .iter()
                .zip(&rates)
                .map(|(m, r)| m * (r * t).exp())
                .collect();
            for (f, e) in found.iter().zip(reflect(&now)) {
                assert!((f - e).abs() < 1e-5, "n {n}, t {t}: {f} against {e}");
            }
        }
    }
}

#[test]
fn blow_up_nan_and_exhaustion_end_with_a_status() {
    for method in METHODS {
        // x' = x² reaches infinity at t = 1.
        let mut blow = Closure(1, |_, x: &[f64], d: &mut [f64]| d[0] = x[0] * x[0]);
        let run = run(method, &mut blow, &[1.0], &[0.5, 2.0], 1e-6);
        assert_eq!(run.times, [0.5]);
        let t = match run.status {
            Status::StepTooSmall { t } | Status::NonFinite { t } => t,
            other => panic!("{method:?}: {other:?}"),
        };
        assert!((t - 1.0).abs() < 1e-3, "{method:?}: {t}");

        // As many of them as like: one after the other, and at once.
        for other in [1.0, 0.9] {
            for states in [2, 4] {
                let mut blow = Closure(states, |_, x: &[f64], d: &mut [f64]| {
                    d.iter_mut().zip(x).for_each(|(d, x)| *d = x * x);
                });
                let mut start = vec![other; states];
                start[0] = 1.0;
                for tolerance in [1e-1, 1e-3, 1e-6] {
                    let run = self::run(method, &mut blow, &start, &[2.0], tolerance);
                    let told = run.status != Status::Finished;
                    assert!(
                        told,
                        "{method:?} of {states} from {other} at {tolerance}: {run:?}"
                    );
                }
            }
        }

        let mut bad = Closure(1, |t: f64, _: &[f64], d: &mut [f64]| {
            d[0] = if t > 0.3 { f64::NAN } else { 1.0 }
        });
        let run = self::run(method, &mut bad, &[0.0], &[1.0], 1e-6);
        assert!(
            matches!(run.status, Status::NonFinite { t } if (t - 0.3).abs() < 1e-3),
            "{:?}",
            run.status
        );

        let mut spring = Closure(2, |_, x: &[f64], d: &mut [f64]| {
            d[0] = x[1];
            d[1] = -x[0];
        });
        let plan = Plan {
            start: 0.0,
            end: 1e9,
            outputs: &[],
            breaks: &[],
        };
        let options = Options {
            max_steps: 100,
            ..Options::new(1e-6, vec![1e-6; 2])
        };
        let run = integrate(method, &mut spring, &[1.0, 0.0], &plan, &options).unwrap();
        assert!(matches!(run.status, Status::TooManySteps { .. }));
        assert_eq!(run.statistics.steps + run.statistics.rejected, 100);
    }
}

/// A ball that bounces without loss: height and speed, guard on the height.
struct Ball;

impl System for Ball {
    fn dimension(&self) -> usize {
        2
    }
    fn rhs(&self, _: f64, x: &[f64], rate: &mut [f64]) {
        rate[0] = x[1];
        rate[1] = -2.0;
    }
    fn guards(&self) -> usize {
        1
    }
    fn guard(&self, _: usize, _: f64, x: &[f64]) -> f64 {
        x[0]
    }
    fn cross(&mut self, _: usize, _: f64, x: &mut [f64]) {
        x[0] = 0.0;
        x[1] = -x[1];
    }
}

#[test]
fn guards_are_located_to_round_off() {
    // From height 1 with g = 2 it lands at t = 1, 3, 5, ... with speed 2.
    for method in METHODS {
        let run = run(method, &mut Ball, &[1.0, 0.0], &[2.0, 4.0, 6.5], 1e-9);
        assert_eq!(run.statistics.events, 3);
        for (found, expected) in run.states.iter().zip([1.0, 0.0, 1.0, 0.0, 0.75, -1.0]) {
            assert!(
                (found - expected).abs() < 1e-7,
                "{method:?}: {:?}",
                run.states
            );
        }
    }
}

#[test]
fn crossings_apart_are_no_deadlock_however_many() {
    for method in METHODS {
        let run = run(method, &mut Ball, &[1.0, 0.0], &[60.0], 1e-6);
        assert_eq!((run.status, run.statistics.events), (Status::Finished, 30));
    }
}

#[test]
fn a_guard_that_never_settles_ends_with_a_status() {
    struct Stuck;
    impl System for Stuck {
        fn dimension(&self) -> usize {
            1
        }
        fn rhs(&self, _: f64, _: &[f64], rate: &mut [f64]) {
            rate[0] = -1.0;
        }
        fn guards(&self) -> usize {
            1
        }
        fn guard(&self, _: usize, _: f64, x: &[f64]) -> f64 {
            x[0] - 0.5
        }
    }
    for method in METHODS {
        let run = run(method, &mut Stuck, &[1.0], &[1.0], 1e-6);
        assert!(
            matches!(run.status, Status::StepTooSmall { t } if (t - 0.5).abs() < 1e-6),
            "{:?}",
            run.status
        );
        // The first crossing and seventeen more at that instant; each is tried twice again before the next step.
        assert_eq!(run.statistics.events, 18 * 3, "{method:?}");
    }
}

#[test]
fn no_step_is_tried_that_the_clock_does_not_resolve() {
    let start = 1e9;
    let plan = Plan {
        start,
        end: start + 1e3,
        outputs: &[],
        breaks: &[],
    };
    let options = Options {
        first_step: Some(1.0),
        ..Options::new(1e-6, vec![1e-6])
    };
    for method in METHODS {
        let mut nowhere = Closure(1, |_, _: &[f64], d: &mut [f64]| d[0] = f64::NAN);
        let run = integrate(method, &mut nowhere, &[0.0], &plan, &options).unwrap();
        assert_eq!(run.status, Status::NonFinite { t: start });
        // Quartered from 1 s to below 16 units of round-off of 1e9 s, 3.6e-6 s.
        assert_eq!(run.statistics.rejected, 10, "{method:?}");
    }
}

#[test]
fn derivatives_by_differences_hold_for_states_and_clocks_of_any_size() {
    let slopes = Closure(1, |t: f64, x: &[f64], d: &mut [f64]| {
        d[0] = 3.0 * x[0] + 2.0 * t;
    });
    let mut rate = [0.0];
    for x in [0.0, 1e-8, 1.0, -40.0, 1e8] {
        let mut by_state = [0.0];
        slopes.rhs(0.0, &[x], &mut rate);
        assert_eq!(slopes.jacobian(0.0, &[x], &rate, &mut by_state), 1);
        assert!((by_state[0] - 3.0).abs() < 1e-3, "{x}: {by_state:?}");
    }
    for t in [0.0, 5.0, 3e5] {
        let mut by_time = [0.0];
        slopes.rhs(t, &[0.0], &mut rate);
        assert_eq!(
            slopes.time_derivative(t, &[0.0], &rate, 1.0, &mut by_time),
            1
        );
        assert!((by_time[0] - 2.0).abs() < 1e-6, "{t}: {by_time:?}");
        // In no time nothing drifts.
        slopes.time_derivative(t, &[0.0], &rate, 0.0, &mut by_time);
        assert_eq!(by_time, [0.0]);
    }
}

/// A guard that an input's jump makes negative at once, and one on the clock; when each was crossed.
struct Switches {
    on: bool,
    late: bool,
    crossed: Vec<(usize, f64)>,
}

impl System for Switches {
    fn dimension(&self) -> usize {
        1
    }
    fn rhs(&self, _: f64, _: &[f64], rate: &mut [f64]) {
        rate[0] = f64::from(u8::from(self.on)) + f64::from(u8::from(self.late));
    }
    fn guards(&self) -> usize {
        2
    }
    fn guard(&self, index: usize, t: f64, _: &[f64]) -> f64 {
        match index {
            0 if !self.on => -1.0,
            1 if !self.late => 0.7 - t,
            _ => 1.0,
        }
    }
    fn cross(&mut self, index: usize, t: f64, _: &mut [f64]) {
        self.crossed.push((index, t));
        if index == 0 {
            self.on = true;
        } else {
            self.late = true;
        }
    }
}

#[test]
fn a_guard_that_is_negative_at_the_start_is_crossed_there_and_one_on_the_clock_in_its_time() {
    for method in METHODS {
        let mut system = Switches {
            on: false,
            late: false,
            crossed: Vec::new(),
        };
        let run = run(method, &mut system, &[0.0], &[1.0], 1e-6);
        assert_eq!(system.crossed[0], (0, 0.0), "{method:?}");
        let (index, at) = system.crossed[1];
        assert!(index == 1 && (at - 0.7).abs() < 1e-12, "{method:?}: {at}");
        assert_eq!((system.crossed.len(), run.statistics.events), (2, 2));
        // One a second from the start on, and two from 0.7 s on.
        assert!((run.states[0] - 1.3).abs() < 1e-12, "{:?}", run.states);
    }
}

#[test]
fn an_output_at_the_end_is_the_state_there_to_the_last_bit() {
    for method in METHODS {
        for k in 1..=20 {
            let mut spring = Closure(2, |_, x: &[f64], d: &mut [f64]| {
                d[0] = x[1];
                d[1] = -x[0];
            });
            let end = 0.7 * f64::from(k);
            let run = run(method, &mut spring, &[1.0, 0.3], &[end - 1e-3, end], 1e-6);
            assert_eq!(run.state(1), run.end_state, "{method:?} {end}");
        }
    }
}

/// Nothing to solve is solved.
#[test]
fn a_system_without_states_is_finished() {
    struct Nothing;
    impl System for Nothing {
        fn dimension(&self) -> usize {
            0
        }
        fn rhs(&self, _: f64, _: &[f64], _: &mut [f64]) {}
    }
    let plan = Plan {
        start: 0.0,
        end: 1.0,
        outputs: &[0.0, 0.5, 1.0],
        breaks: &[0.3],
    };
    for method in METHODS {
        let run = integrate(
            method,
            &mut Nothing,
            &[],
            &plan,
            &Options::new(1e-6, vec![]),
        )
        .unwrap();
        assert_eq!((run.status, run.end), (Status::Finished, 1.0));
        assert_eq!(run.times, plan.outputs);
        assert!(run.iter().all(|(_, x)| x.is_empty()));
    }
}

/// `x' = λ (x - sin t) + cos t` goes along `sin t`; between the ends of long steps an extension that is not held to the tolerance does not.
#[test]
fn outputs_of_a_very_stiff_problem_are_right_within_long_steps_at_breaks_and_with_short_steps() {
    struct Follower;
    impl System for Follower {
        fn dimension(&self) -> usize {
            1
        }
        fn rhs(&self, t: f64, x: &[f64], rate: &mut [f64]) {
            rate[0] = -1e4 * (x[0] - t.sin()) + t.cos();
        }
    }
    let outputs: Vec<f64> = (0..=100).map(|i| 0.1 * f64::from(i)).collect();
    for method in [Method::Rodasp, Method::Rodas3] {
        let worst = |breaks: &[f64], max_step| {
            let plan = Plan {
                start: 0.0,
                end: 10.0,
                outputs: &outputs,
                breaks,
            };
            let options = Options {
                max_step,
                ..Options::new(1e-4, vec![1e-4])
            };
            let run = integrate(method, &mut Follower, &[0.0], &plan, &options).unwrap();
            assert_eq!(run.status, Status::Finished);
            run.iter()
                .map(|(t, x)| (x[0] - t.sin()).abs())
                .fold(0.0, f64::max)
        };
        // Four times a tolerance of 1e-4 (1 + |sin t|).
        assert!(worst(&[], f64::INFINITY) < 8e-4);
        assert!(worst(&outputs, f64::INFINITY) < 8e-4);
        assert!(worst(&[], 1e-2) < 8e-4);
    }
}
