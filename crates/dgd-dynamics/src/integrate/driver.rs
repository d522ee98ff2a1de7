//! The loop both methods share: segments between breaks, step control, guards, dense output.

use super::vector::Vector;
use super::{Options, Plan, Statistics, Status, System, Trajectory};

/// One-step method with an error estimate and a continuous extension.
pub(crate) trait Stepper<V: Vector> {
    /// Forgets what was known about the right-hand side at the current point.
    fn restart(&mut self);
    /// Tries a step of `h` from `(t, x)`, writes the result to `next` and the error estimate to
    /// `error`. False if its equations have no solution worth the name, however small the error.
    #[expect(
        clippy::too_many_arguments,
        reason = "the step's data, passed flat for speed"
    )]
    fn attempt<S: System + ?Sized>(
        &mut self,
        system: &S,
        t: f64,
        x: &V,
        h: f64,
        next: &mut V,
        error: &mut V,
        count: &mut Statistics,
    ) -> bool;
    /// Takes over the last attempted step.
    fn accept(&mut self);
    /// State at the fraction `theta` of the last attempted step, from `x` to `next`.
    fn dense(&self, theta: f64, h: f64, x: &V, next: &V, out: &mut [f64]);
    /// How far that state is off, written to `error`; false if steps that end right are right in between, as those of an explicit method are:
    /// they are too short for any mode to be stiff.
    fn strays<S: System + ?Sized>(
        &mut self,
        _system: &S,
        _theta: f64,
        _step: &Step<'_, V>,
        _error: &mut V,
        _count: &mut Statistics,
    ) -> bool {
        false
    }
    /// By what to multiply the step after a scaled error of `error`; `previous` is that of the
    /// last accepted step.
    fn factor(error: f64, previous: f64) -> f64;
}

/// A step cut short by a break says nothing against the longer proposal if its error is below
/// this.
const CUT_IS_FINE: f64 = 0.5;
/// Fractions of a step with samples or an event within it at which its continuous extension is held to the tolerance, and how many times that it may be off:
/// it is of a lower order than the step.
const BETWEEN: [f64; 2] = [0.3, 0.7];
const MOST_BETWEEN: f64 = 4.0;
/// Guard crossings at one and the same instant before we call it a deadlock.
const MAX_STALLED: usize = 16;

/// What an integration carries from one part of its span to the next.
pub(crate) struct Carried<V, M> {
    method: M,
    x: V,
    /// The next step to try; 0 before the first.
    h: f64,
    previous_error: f64,
    stalled: usize,
    /// Segments between breaks.
    begun: usize,
    count: Statistics,
}

impl<V: Vector, M: Stepper<V>> Carried<V, M> {
    pub(super) fn new(method: M, initial: &[f64]) -> Self {
        let mut x = V::zeros(initial.len());
        x.get_mut().copy_from_slice(initial);
        Self {
            method,
            x,
            h: 0.0,
            previous_error: 1e-4,
            stalled: 0,
            begun: 0,
            count: Statistics::default(),
        }
    }
}

/// The samples that were asked for, as the steps pass them.
struct Samples<'a> {
    /// Times still ahead.
    pending: &'a [f64],
    times: Vec<f64>,
    states: Vec<f64>,
}

impl<'a> Samples<'a> {
    fn new(pending: &'a [f64], dimension: usize) -> Self {
        Self {
            pending,
            times: Vec::with_capacity(pending.len()),
            states: Vec::with_capacity(pending.len() * dimension),
        }
    }

    /// Whether some are due before `until`.
    #[inline(always)]
    fn are_due_before(&self, until: f64) -> bool {
        self.pending.first().is_some_and(|due| *due < until)
    }

    /// Those due at `t`, where the state is `x`.
    #[inline(always)]
    fn take(&mut self, t: f64, x: &[f64]) {
        while let [due, rest @ ..] = self.pending
            && *due <= t
        {
            self.times.push(*due);
            self.states.extend_from_slice(x);
            self.pending = rest;
        }
    }

    /// Those due before `until`, which lies within the step.
    fn take_within<V: Vector, M: Stepper<V>>(
        &mut self,
        method: &M,
        step: &Step<'_, V>,
        until: f64,
    ) {
        while let [due, rest @ ..] = self.pending
            && *due < until
        {
            self.times.push(*due);
            let from = self.states.len();
            self.states.resize(from + step.x.get().len(), 0.0);
            step.at(method, (due - step.t) / step.h, &mut self.states[from..]);
            self.pending = rest;
        }
    }
}

/// A step of `h` from `t`, between its two states.
pub(crate) struct Step<'a, V> {
    pub(super) t: f64,
    pub(super) h: f64,
    pub(super) x: &'a V,
    pub(super) next: &'a V,
}

impl<V: Vector> Step<'_, V> {
    /// The state at the fraction `theta` of it.
    fn at<M: Stepper<V>>(&self, method: &M, theta: f64, out: &mut [f64]) {
        method.dense(theta, self.h, self.x, self.next, out);
    }

    /// The scaled error of the step or, where that is larger, of what lies within it; NaN where what lies within it has none.
    ///
    /// - `size`: scales an error, which is written into `error`.
    #[inline(always)]
    fn worst_between<M: Stepper<V>, S: System + ?Sized>(
        &self,
        method: &mut M,
        system: &S,
        scaled: f64,
        size: impl Fn(&V) -> f64,
        error: &mut V,
        count: &mut Statistics,
    ) -> f64 {
        let mut worst = scaled;
        for theta in BETWEEN {
            if method.strays(system, theta, self, error, count) {
                let between = size(error) / MOST_BETWEEN;
                // `max` would drop it.
                if between.is_nan() {
                    return between;
                }
                worst = worst.max(between);
            }
        }
        worst
    }

    /// Bisects for the earliest crossing; returns the guard and the fraction of the step at which it is just negative.
    fn locate<M: Stepper<V>, S: System + ?Sized>(
        &self,
        method: &M,
        system: &S,
        found: usize,
        scratch: &mut [f64],
    ) -> (usize, f64) {
        let (mut index, mut low, mut high) = (found, 0.0_f64, 1.0_f64);
        // 52 halvings exhaust the fraction's bits.
        for _ in 0..52 {
            let middle = 0.5 * (low + high);
            self.at(method, middle, scratch);
            match crossing(system, self.t + middle * self.h, scratch) {
                Some(now) => (index, high) = (now, middle),
                None => low = middle,
            }
            if (high - low) * self.h <= f64::EPSILON * self.t.abs() {
                break;
            }
        }
        (index, high)
    }
}

/// By what a step is to be shortened whose scaled error is too large, or is none.
#[inline(always)]
fn shrunk<V: Vector, M: Stepper<V>>(scaled: f64, previous_error: f64) -> f64 {
    if scaled.is_finite() {
        M::factor(scaled, previous_error).min(0.9)
    } else {
        0.25
    }
}

/// Goes on from where the last part ended, which must be a break of the whole: then the parts are the whole, to the last bit.
pub(super) fn drive<V: Vector, M: Stepper<V>, S: System + ?Sized>(
    carried: Carried<V, M>,
    system: &mut S,
    plan: &Plan<'_>,
    options: &Options,
) -> (Trajectory, Carried<V, M>) {
    // Out of the struct, so that the loop keeps them where it likes.
    let Carried {
        mut method,
        mut x,
        mut h,
        mut previous_error,
        mut stalled,
        mut begun,
        mut count,
    } = carried;
    let n = x.get().len();
    let mut next = V::zeros(n);
    let mut error = V::zeros(n);
    let mut absolute = V::zeros(n);
    absolute
        .get_mut()
        .copy_from_slice(&options.tolerances.absolute);
    let relative = options.tolerances.relative;

    let mut samples = Samples::new(plan.outputs, n);
    let mut breaks = plan.breaks;
    let mut t = plan.start;
    let mut status = Status::Finished;
    samples.take(t, x.get());

    'segments: while t < plan.end {
        while let [first, rest @ ..] = breaks
            && *first <= t
        {
            breaks = rest;
        }
        let stop = breaks.first().map_or(plan.end, |b| b.min(plan.end));
        system.begin_segment(t, stop, x.get());
        method.restart();
        begun += 1;
        let begin = t;
        let shortest = 16.0 * f64::EPSILON * t.abs().max(stop.abs());
        settle(system, t, x.get_mut(), &mut count);
        if h == 0.0 {
            h = options.first_step.unwrap_or_else(|| {
                first_step(
                    system,
                    t,
                    x.get(),
                    error.get_mut(),
                    &options.tolerances,
                    &mut count,
                )
            });
            h = h.min(options.max_step).max(shortest);
        }
        while t < stop {
            // However long the recording, each of its breaks takes one more step.
            if count.steps + count.rejected >= options.max_steps.saturating_add(begun - 1) {
                status = Status::TooManySteps { t };
                break 'segments;
            }
            let (trial, last) = shortened(h, stop - t);
            let solved = method.attempt(system, t, &x, trial, &mut next, &mut error, &mut count);
            let reached = if last { stop } else { t + trial };
            let step = Step {
                t,
                h: trial,
                x: &x,
                next: &next,
            };
            let size = |error: &V| norm(error.get(), x.get(), next.get(), absolute.get(), relative);
            let mut scaled = if solved { size(&error) } else { f64::NAN };
            let mut found = None;
            if scaled <= 1.0 {
                found = crossing(system, reached, next.get());
                if found.is_some() || samples.are_due_before(reached) {
                    scaled = step.worst_between(
                        &mut method,
                        system,
                        scaled,
                        size,
                        &mut error,
                        &mut count,
                    );
                }
            }
            if scaled.is_nan() || scaled > 1.0 {
                count.rejected += 1;
                h = trial * shrunk::<V, M>(scaled, previous_error);
                if h < shortest {
                    status = if scaled.is_finite() {
                        Status::StepTooSmall { t }
                    } else {
                        Status::NonFinite { t }
                    };
                    break 'segments;
                }
                continue;
            }
            count.steps += 1;
            if let Some(found) = found {
                let (index, theta) = step.locate(&method, system, found, error.get_mut());
                let event = (t + theta * trial).min(reached);
                step.at(&method, theta, error.get_mut());
                samples.take_within(&method, &step, event);
                stalled = if event > t + shortest { 0 } else { stalled + 1 };
                if stalled > 0 {
                    // The same long step would dip below zero at its start again.
                    h = (0.25 * trial).max(shortest);
                }
                x.get_mut().copy_from_slice(error.get());
                t = event;
                count.events += 1;
                system.cross(index, t, x.get_mut());
                settle(system, t, x.get_mut(), &mut count);
                method.restart();
                samples.take(t, x.get());
                if stalled > MAX_STALLED {
                    status = Status::StepTooSmall { t };
                    break 'segments;
                }
                continue;
            }
            samples.take_within(&method, &step, reached);
            let cut = trial < h && scaled <= CUT_IS_FINE;
            // A proposal that spans the segment already need not grow, which saves the power
            // function of the controller.
            if !(cut && h >= stop - begin) {
                let new = (trial * M::factor(scaled, previous_error)).min(options.max_step);
                h = if cut { h.max(new) } else { new };
                previous_error = scaled.max(1e-4);
            }
            t = reached;
            std::mem::swap(&mut x, &mut next);
            method.accept();
            samples.take(t, x.get());
        }
    }
    let trajectory = Trajectory {
        dimension: n,
        times: samples.times,
        states: samples.states,
        end: t,
        end_state: x.get().to_vec(),
        status,
        statistics: count,
    };
    let carried = Carried {
        method,
        x,
        h,
        previous_error,
        stalled,
        begun,
        count,
    };
    (trajectory, carried)
}

/// What is left of the proposal `h` where the segment ends in `remaining`, and whether it reaches that end.
#[inline(always)]
fn shortened(h: f64, remaining: f64) -> (f64, bool) {
    if h >= remaining * (1.0 - 1e-12) {
        (remaining, true)
    } else if 2.0 * h > remaining {
        (0.5 * remaining, false) // no sliver before the break
    } else {
        (h, false)
    }
}

/// Root mean square of the error in units of the tolerance.
#[inline(always)]
fn norm(error: &[f64], x: &[f64], next: &[f64], absolute: &[f64], relative: f64) -> f64 {
    let n = error.len();
    let mut sum = 0.0;
    for i in 0..n {
        let scale = absolute[i] + relative * x[i].abs().max(next[i].abs());
        let part = error[i] / scale;
        sum += part * part;
        // `max` above drops a NaN, and an infinite state would make its own error vanish.
        if !next[i].is_finite() {
            return f64::NAN;
        }
    }
    #[expect(clippy::cast_precision_loss, reason = "a handful of states")]
    let n = n as f64;
    (sum / n).sqrt()
}

/// Crosses the guards that are negative already (an input jumped).
#[inline(always)]
fn settle<S: System + ?Sized>(system: &mut S, t: f64, x: &mut [f64], count: &mut Statistics) {
    for _ in 0..2 * system.guards() {
        let Some(index) = crossing(system, t, x) else {
            return;
        };
        system.cross(index, t, x);
        count.events += 1;
    }
}

#[inline(always)]
#[expect(
    clippy::manual_find,
    reason = "`find` stays outside the loop over the steps, with a call for each guard"
)]
fn crossing<S: System + ?Sized>(system: &S, t: f64, x: &[f64]) -> Option<usize> {
    for index in 0..system.guards() {
        if system.guard(index, t, x) < 0.0 {
            return Some(index);
        }
    }
    None
}

/// A hundredth of the time in which the state would change by its own size.
fn first_step<S: System + ?Sized>(
    system: &S,
    t: f64,
    x: &[f64],
    rate: &mut [f64],
    tolerances: &super::Tolerances,
    count: &mut Statistics,
) -> f64 {
    system.rhs(t, x, rate);
    count.rhs += 1;
    let (mut size, mut speed) = (0.0_f64, 0.0_f64);
    for i in 0..x.len() {
        let scale = tolerances.absolute[i] + tolerances.relative * x[i].abs();
        size = size.max((x[i] / scale).abs());
        speed = speed.max((rate[i] / scale).abs());
    }
    let h = 0.01 * size / speed;
    if h.is_finite() && h > 1e-6 { h } else { 1e-6 }
}

#[cfg(test)]
mod tests {
    use super::{BETWEEN, MOST_BETWEEN, Statistics, Step, Stepper, System};

    struct Resting;

    impl System for Resting {
        fn dimension(&self) -> usize {
            1
        }

        fn rhs(&self, _t: f64, _x: &[f64], rate: &mut [f64]) {
            rate.fill(0.0);
        }
    }

    /// A method that is off by so much at each of the fractions in between.
    struct Off([f64; 2]);

    impl Stepper<[f64; 1]> for Off {
        fn restart(&mut self) {}

        fn attempt<S: System + ?Sized>(
            &mut self,
            _system: &S,
            _t: f64,
            _x: &[f64; 1],
            _h: f64,
            _next: &mut [f64; 1],
            _error: &mut [f64; 1],
            _count: &mut Statistics,
        ) -> bool {
            true
        }

        fn accept(&mut self) {}

        fn dense(&self, _theta: f64, _h: f64, x: &[f64; 1], _next: &[f64; 1], out: &mut [f64]) {
            out.copy_from_slice(x);
        }

        fn strays<S: System + ?Sized>(
            &mut self,
            _system: &S,
            theta: f64,
            _step: &Step<'_, [f64; 1]>,
            error: &mut [f64; 1],
            _count: &mut Statistics,
        ) -> bool {
            error[0] = self.0[usize::from(theta > BETWEEN[0])];
            true
        }

        fn factor(_error: f64, _previous: f64) -> f64 {
            1.0
        }
    }

    #[test]
    fn a_step_is_as_far_off_as_what_lies_within_it_and_is_none_if_that_is_none() {
        let step = Step {
            t: 0.0,
            h: 1.0,
            x: &[0.0],
            next: &[0.0],
        };
        let worst = |off: [f64; 2]| {
            let (mut error, mut count) = ([0.0], Statistics::default());
            let size = |error: &[f64; 1]| error[0];
            step.worst_between(&mut Off(off), &Resting, 0.5, size, &mut error, &mut count)
        };
        assert_eq!(worst([0.1, 0.2]), 0.5);
        assert_eq!(worst([0.1, 4.0]), 4.0 / MOST_BETWEEN);
        assert_eq!(worst([3.0, 0.1]), 3.0 / MOST_BETWEEN);
        // A number after it does not hide it.
        assert!(worst([f64::NAN, 0.1]).is_nan());
        assert!(worst([0.1, f64::NAN]).is_nan());
    }
}
