//! Initial-value problems `dx/dt = f(t, x)` whose input has kinks.
//!
//! Implement [`System`], fill a [`Plan`], call [`integrate()`]. Three methods share one driver:
//! [`Method::DormandPrince`] (explicit, order 5) for smooth non-stiff problems, [`Method::Rodasp`]
//! (linearly implicit, L-stable, order 4) for stiff ones and [`Method::Rodas3`] (the same of order 3)
//! for stiff ones whose breaks come close on each other. All stop exactly at the break times,
//! restart there, and write the requested times by dense output.

mod dormand_prince;
mod driver;
mod rosenbrock;
mod system;
mod tableaus;
mod vector;

pub use system::{Linearised, System};

use dormand_prince::DormandPrince;
use rosenbrock::Rosenbrock;
use tableaus::{Rodas3, Rodasp};
pub(crate) use vector::Vector;

/// The integration method.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
pub enum Method {
    /// Dormand and Prince 5(4): explicit, first-same-as-last, 4th-order dense output (Hairer, Nørsett and Wanner
    /// 1993, II.5-6), PI step control (Hairer and Wanner 1996, IV.2).
    DormandPrince,
    /// RODASP 4(3): linearly implicit Rosenbrock, L-stable, stiffly accurate, made to lose little
    /// order where a fast mode follows a moving input, 3rd-order dense output (Steinebach 1995;
    /// Hairer and Wanner 1996, IV.7).
    #[default]
    Rodasp,
    /// RODAS3 3(2): linearly implicit Rosenbrock of half the evaluations a step, L-stable, stiffly accurate, 2nd-order dense
    /// output (Sandu et al. 1997). For inputs that bend at every sample, which no step may be longer than.
    Rodas3,
}

/// What error a step may make: `absolute[i] + relative·|x[i]|` in the root mean square.
///
/// They are held at the ends of steps; times in between are written by the method's continuous extension. Where a mode is much faster than
/// a step, as the linearly implicit methods step over it, every step may end right and the extension be off by many times the
/// tolerance. [`Method::Rodasp`] and [`Method::Rodas3`] therefore also look within each step that times or an event lie in, by the difference of rate
/// and slope (two evaluations), and hold it there to four times the tolerance.
#[derive(Debug, Clone, PartialEq)]
pub struct Tolerances {
    /// Relative tolerance, at least 0.
    pub relative: f64,
    /// Absolute tolerance of each state, in its unit, positive.
    pub absolute: Vec<f64>,
}

/// Settings of one integration.
#[derive(Debug, Clone, PartialEq)]
pub struct Options {
    /// Error allowed a step.
    pub tolerances: Tolerances,
    /// First step to try; `None` (default) estimates it.
    pub first_step: Option<f64>,
    /// Longest step; infinite by default.
    pub max_step: f64,
    /// Steps after which to give up, rejected ones included, beyond the one that each break takes; 10 million by default.
    pub max_steps: usize,
}

impl Options {
    /// Default settings with the given tolerances.
    #[must_use]
    pub fn new(relative: f64, absolute: Vec<f64>) -> Self {
        Self {
            tolerances: Tolerances { relative, absolute },
            first_step: None,
            max_step: f64::INFINITY,
            max_steps: 10_000_000,
        }
    }
}

/// Where to start and end, where to stop on the way, and what to write.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Plan<'a> {
    /// Start time.
    pub start: f64,
    /// End time, not before `start`.
    pub end: f64,
    /// Times to write, ascending, within `start..=end`.
    pub outputs: &'a [f64],
    /// Times at which the right-hand side has a kink or jump, ascending; those outside the span
    /// are ignored. No step crosses one.
    pub breaks: &'a [f64],
}

/// How an integration ended.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Status {
    /// The end was reached.
    Finished,
    /// The tolerance could not be met with a step the clock resolves.
    StepTooSmall {
        /// Time reached.
        t: f64,
    },
    /// [`Options::max_steps`] was used up.
    TooManySteps {
        /// Time reached.
        t: f64,
    },
    /// The right-hand side gave NaN or infinity however short the step.
    NonFinite {
        /// Time reached.
        t: f64,
    },
}

/// What an integration cost.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Statistics {
    /// Accepted steps.
    pub steps: usize,
    /// Rejected steps.
    pub rejected: usize,
    /// Evaluations of the right-hand side, those for finite differences included.
    pub rhs: usize,
    /// Jacobians.
    pub jacobians: usize,
    /// LU factorisations.
    pub factorisations: usize,
    /// Guards crossed ([`System::guard`]).
    pub events: usize,
}

/// The states at the requested times.
#[derive(Debug, Clone, PartialEq)]
pub struct Trajectory {
    /// Number of states.
    pub dimension: usize,
    /// Times written; a prefix of [`Plan::outputs`], all of it if [`Status::Finished`].
    pub times: Vec<f64>,
    /// States, row-major, `times.len() × dimension`.
    pub states: Vec<f64>,
    /// Time reached.
    pub end: f64,
    /// State at `end`.
    pub end_state: Vec<f64>,
    /// How it ended.
    pub status: Status,
    /// What it cost.
    pub statistics: Statistics,
}

impl Trajectory {
    /// State at `times[i]`, shape `(dimension,)`.
    ///
    /// # Panics
    /// If so many times were not written.
    ///
    /// ```
    /// # use dgd_dynamics::integrate::{integrate, Method, Options, Plan, System};
    /// /// A weight on a spring: place and speed.
    /// struct Spring;
    /// impl System for Spring {
    ///     fn dimension(&self) -> usize { 2 }
    ///     fn rhs(&self, _t: f64, x: &[f64], dx: &mut [f64]) { (dx[0], dx[1]) = (x[1], -x[0]) }
    /// }
    /// let plan = Plan { start: 0.0, end: 3.0, outputs: &[0.0, 1.5, 3.0], breaks: &[] };
    /// let options = Options::new(1e-8, vec![1e-8; 2]);
    /// let run = integrate(Method::DormandPrince, &mut Spring, &[1.0, 0.0], &plan, &options)?;
    /// assert!((run.state(1)[0] - 1.5f64.cos()).abs() < 1e-6);
    /// for (t, x) in run.iter() {
    ///     assert!((x[1] + t.sin()).abs() < 1e-6);
    /// }
    /// # Ok::<(), dgd_dynamics::integrate::IntegrateError>(())
    /// ```
    #[must_use]
    pub fn state(&self, i: usize) -> &[f64] {
        assert!(i < self.times.len(), "{i} of {} times", self.times.len());
        &self.states[i * self.dimension..][..self.dimension]
    }

    /// The times written, each with its state, shape `(dimension,)`.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = (f64, &[f64])> + '_ {
        let times = self.times.iter().enumerate();
        times.map(|(i, t)| (*t, self.state(i)))
    }

    /// One of the states at all times.
    pub(crate) fn column(&self, k: usize) -> Vec<f64> {
        self.iter().map(|(_, x)| x[k]).collect()
    }
}

/// Why an integration was refused.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum IntegrateError {
    /// A per-state argument has the wrong length.
    #[error("`{name}` has {found} entries, expected {expected} (one per state)")]
    Dimension {
        /// Argument.
        name: &'static str,
        /// Entries expected.
        expected: usize,
        /// Entries found.
        found: usize,
    },
    /// An entry is not usable.
    #[error("`{name}`[{index}] is {found}, expected {expected}")]
    Value {
        /// Argument.
        name: &'static str,
        /// Position.
        index: usize,
        /// Value found.
        found: f64,
        /// What would have been accepted.
        expected: &'static str,
    },
}

/// Integrates `system` from `initial` as `plan` says.
///
/// The small dimensions (1, 2, 3, 4 and 6) run on stack arrays, the others on vectors; the
/// arithmetic is the same. A system without states is finished at once.
///
/// # Errors
/// [`IntegrateError::Dimension`] if `initial` or the absolute tolerances do not have one entry a
/// state; [`IntegrateError::Value`] on a non-finite start, an empty tolerance, times that are not
/// ascending or lie outside the span. What happens once it runs is the [`Status`].
///
/// ```
/// use dgd_dynamics::integrate::{integrate, Method, Options, Plan, System};
///
/// struct Decay;
/// impl System for Decay {
///     fn dimension(&self) -> usize { 1 }
///     fn rhs(&self, _t: f64, x: &[f64], dx: &mut [f64]) { dx[0] = -x[0] }
/// }
/// let plan = Plan { start: 0.0, end: 1.0, outputs: &[0.5, 1.0], breaks: &[] };
/// let run = integrate(Method::Rodasp, &mut Decay, &[1.0], &plan, &Options::new(1e-8, vec![1e-8]))?;
/// assert!((run.state(1)[0] - (-1.0f64).exp()).abs() < 1e-7);
/// # Ok::<(), dgd_dynamics::integrate::IntegrateError>(())
/// ```
pub fn integrate<S: System + ?Sized>(
    method: Method,
    system: &mut S,
    initial: &[f64],
    plan: &Plan<'_>,
    options: &Options,
) -> Result<Trajectory, IntegrateError> {
    check(system.dimension(), initial, plan, options)?;
    Ok(match initial.len() {
        0 => nothing(plan),
        1 => run::<S, [f64; 1]>(method, system, initial, plan, options),
        2 => run::<S, [f64; 2]>(method, system, initial, plan, options),
        3 => run::<S, [f64; 3]>(method, system, initial, plan, options),
        4 => run::<S, [f64; 4]>(method, system, initial, plan, options),
        6 => run::<S, [f64; 6]>(method, system, initial, plan, options),
        _ => run::<S, Vec<f64>>(method, system, initial, plan, options),
    })
}

/// The integration of no states.
fn nothing(plan: &Plan<'_>) -> Trajectory {
    Trajectory {
        dimension: 0,
        times: plan.outputs.to_vec(),
        states: Vec::new(),
        end: plan.end,
        end_state: Vec::new(),
        status: Status::Finished,
        statistics: Statistics::default(),
    }
}

fn run<S: System + ?Sized, V: Vector>(
    method: Method,
    system: &mut S,
    initial: &[f64],
    plan: &Plan<'_>,
    options: &Options,
) -> Trajectory {
    Parts::<V>::new(method, initial).go(system, plan, options).0
}

/// An integration that is done part by part, each up to a break.
pub(crate) enum Parts<V: Vector> {
    DormandPrince(driver::Carried<V, DormandPrince<V>>),
    Rodasp(driver::Carried<V, Rosenbrock<V, Rodasp>>),
    Rodas3(driver::Carried<V, Rosenbrock<V, Rodas3>>),
}

impl<V: Vector> Parts<V> {
    pub(crate) fn new(method: Method, initial: &[f64]) -> Self {
        let n = initial.len();
        match method {
            Method::DormandPrince => {
                Self::DormandPrince(driver::Carried::new(DormandPrince::new(n), initial))
            }
            Method::Rodasp => Self::Rodasp(driver::Carried::new(Rosenbrock::new(n), initial)),
            Method::Rodas3 => Self::Rodas3(driver::Carried::new(Rosenbrock::new(n), initial)),
        }
    }

    /// Integrates over the plan's span, the next one of the whole; the statistics are those of all parts.
    pub(crate) fn go<S: System + ?Sized>(
        self,
        system: &mut S,
        plan: &Plan<'_>,
        options: &Options,
    ) -> (Trajectory, Self) {
        match self {
            Self::DormandPrince(carried) => {
                let (part, carried) = driver::drive(carried, system, plan, options);
                (part, Self::DormandPrince(carried))
            }
            Self::Rodasp(carried) => {
                let (part, carried) = driver::drive(carried, system, plan, options);
                (part, Self::Rodasp(carried))
            }
            Self::Rodas3(carried) => {
                let (part, carried) = driver::drive(carried, system, plan, options);
                (part, Self::Rodas3(carried))
            }
        }
    }
}

pub(crate) fn check(
    n: usize,
    initial: &[f64],
    plan: &Plan<'_>,
    options: &Options,
) -> Result<(), IntegrateError> {
    let absolute = &options.tolerances.absolute;
    for (name, found) in [("initial", initial.len()), ("absolute", absolute.len())] {
        if found != n {
            return Err(IntegrateError::Dimension {
                name,
                expected: n,
                found,
            });
        }
    }
    let refuse = |name, index, found, expected| {
        Err(IntegrateError::Value {
            name,
            index,
            found,
            expected,
        })
    };
    for (index, &x) in initial.iter().enumerate() {
        if !x.is_finite() {
            return refuse("initial", index, x, "a finite number");
        }
    }
    for (index, &a) in absolute.iter().enumerate() {
        if !(a > 0.0 && a.is_finite()) {
            return refuse("absolute", index, a, "a positive finite number");
        }
    }
    let relative = options.tolerances.relative;
    if !(relative >= 0.0 && relative.is_finite()) {
        return refuse("relative", 0, relative, "a finite number of at least 0");
    }
    if options.max_step.is_nan() || options.max_step <= 0.0 {
        return refuse("max_step", 0, options.max_step, "a positive number");
    }
    if let Some(h) = options.first_step
        && !(h > 0.0 && h.is_finite())
    {
        return refuse("first_step", 0, h, "a positive finite number");
    }
    if !plan.start.is_finite() {
        return refuse("start", 0, plan.start, "a finite time");
    }
    if !(plan.end >= plan.start && plan.end.is_finite()) {
        return refuse("end", 0, plan.end, "a finite time not before the start");
    }
    let mut before = plan.start;
    for (index, &t) in plan.outputs.iter().enumerate() {
        if !(t >= before && t <= plan.end) {
            return refuse("outputs", index, t, "ascending times within the span");
        }
        before = t;
    }
    let mut before = f64::NEG_INFINITY;
    for (index, &t) in plan.breaks.iter().enumerate() {
        if t.is_nan() || t < before {
            return refuse("breaks", index, t, "ascending times");
        }
        before = t;
    }
    Ok(())
}

#[cfg(test)]
mod one_step;
