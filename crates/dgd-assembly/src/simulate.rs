//! Runs an assembly over a window of samples.

mod linear;
mod running;

pub(crate) use running::Model;

use crate::assembly::Assembly;
use crate::error::AssemblyError;
use crate::model::Work;
use crate::network::{ATMOSPHERE_PA, Attached, Flow, Network, Reading, Start};
use crate::record::Window;
use crate::spec::Between;
use dgd_dynamics::inputs::{Interpolation, Signal, merged_kinks};
use dgd_dynamics::integrate::{self, Method, Plan, Status, Tolerances};

/// Settings of a simulation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SimulationOptions {
    /// Integration method; [`Method::Rodasp`] by default, which stiff systems need.
    pub method: Method,
    /// Relative tolerance of a step; 1e-5 by default. The absolute one is a tenth of it times the state's usual size.
    pub relative: f64,
    /// Steps after which to give up; 10 million by default.
    pub max_steps: usize,
    /// The linear model in the place of the equations: deviations from the steady state at the mean of the window's inputs (from the
    /// window's start where there is none), as `linearise` gives it at each `theta`. No tank is full or empty in it, and what an
    /// instrument does with earlier samples is left out.
    pub linear: bool,
}

impl Default for SimulationOptions {
    fn default() -> Self {
        Self {
            method: Method::default(),
            relative: 1e-5,
            max_steps: 10_000_000,
            linear: false,
        }
    }
}

/// A simulated window.
#[derive(Debug, Clone, PartialEq)]
pub struct Simulation {
    /// Times, as in the window.
    pub time: Vec<f64>,
    /// Readings of each instrument, each of shape `(n,)`; NaN where the run did not get to.
    pub outputs: Vec<Vec<f64>>,
    /// Each state, of shape `(n,)`; NaN where the run did not get to.
    pub states: Vec<Vec<f64>>,
    /// Tanks that were full or empty: state path, time of the first event, `true` if full.
    pub held: Vec<(String, f64, bool)>,
    /// How the integration ended.
    pub status: RunStatus,
}

/// How a run ended.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum RunStatus {
    /// All samples were reached.
    Finished,
    /// The integrator gave up: see there.
    Stopped(Status),
    /// Pressures or flows could not be solved for at some moment; outputs are not to be trusted.
    NotSolved,
}

impl Assembly {
    /// Runs a window with the parameters `theta`, in the order of [`Self::parameters`]; they are not held to their bounds.
    ///
    /// `number` is that of the training window, for its free initial states; held-out windows use 0.
    ///
    /// # Errors
    /// [`AssemblyError::Length`] or [`AssemblyError::Value`] on a wrong `theta`; [`AssemblyError::Input`] on inputs that are
    /// not finite or times that do not ascend; [`AssemblyError::Value`] if an initial state is to be measured and is not.
    pub fn simulate(
        &self,
        theta: &[f64],
        window: &Window,
        number: usize,
        options: &SimulationOptions,
    ) -> Result<Simulation, AssemblyError> {
        self.check_theta(theta)?;
        Simulator::new(self, window, number, options)?.run(theta)
    }
}

/// A window made ready to be run many times.
pub struct Simulator<'a> {
    assembly: &'a Assembly,
    pub(crate) window: &'a Window,
    number: usize,
    /// Length of `theta`.
    expected: usize,
    pub(crate) options: SimulationOptions,
    pub(crate) model: Model<'a>,
    pub(crate) breaks: Vec<f64>,
    pub(crate) absolute: Vec<f64>,
}

impl<'a> Simulator<'a> {
    /// Checks the window's inputs.
    ///
    /// # Errors
    /// As [`Assembly::simulate`].
    pub fn new(
        assembly: &'a Assembly,
        window: &'a Window,
        number: usize,
        options: &SimulationOptions,
    ) -> Result<Self, AssemblyError> {
        let net = &assembly.net;
        let (expected, found) = (net.driven.len(), window.inputs.len());
        if found != expected {
            return Err(AssemblyError::Length {
                name: "inputs".into(),
                expected,
                found,
            });
        }
        if window.time.is_empty() {
            return Err(AssemblyError::Length {
                name: "time".into(),
                expected: 1,
                found: 0,
            });
        }
        let mut signals = Vec::new();
        if net.in_time {
            for (driven, values) in net.driven.iter().zip(&window.inputs) {
                let between = match driven.between {
                    Between::Interpolated => Interpolation::Linear,
                    Between::Held => Interpolation::Hold,
                };
                signals.push(Signal::new(&driven.path, &window.time, values, between)?);
            }
        } else {
            for (driven, values) in net.driven.iter().zip(&window.inputs) {
                if values.len() != window.time.len() {
                    return Err(AssemblyError::Length {
                        name: driven.path.clone(),
                        expected: window.time.len(),
                        found: values.len(),
                    });
                }
            }
        }
        let start = window.time[0];
        let end = window.time[window.time.len() - 1];
        let model = Model::moving(net, signals, window);
        let breaks = if model.commands() {
            // What a command is changed to may bend or jump at any sample.
            window.time[1..]
                .iter()
                .copied()
                .filter(|t| *t < end)
                .collect()
        } else {
            merged_kinks(&model.signals.iter().collect::<Vec<_>>(), start, end)
        };
        let absolute = net
            .states
            .iter()
            .map(|s| 0.1 * options.relative * s.size)
            .collect();
        Ok(Self {
            assembly,
            window,
            number,
            expected: assembly.parameters().len(),
            options: *options,
            model,
            breaks,
            absolute,
        })
    }

    /// Runs it.
    ///
    /// # Errors
    /// [`AssemblyError::Length`] or [`AssemblyError::Value`] on a wrong `theta`; [`AssemblyError::Value`] if an initial state
    /// is to be measured and is not.
    pub fn run(&mut self, theta: &[f64]) -> Result<Simulation, AssemblyError> {
        let net = self.model.net;
        if theta.len() != self.expected || theta.iter().any(|v| !v.is_finite()) {
            self.assembly.check_theta(theta)?;
        }
        let n = net.states.len();
        let samples = self.window.time.len();
        {
            let mut work = self.model.work.borrow_mut();
            set_theta(net, &mut work, theta);
            work.reset();
        }
        if self.options.linear {
            return self.run_linear(theta);
        }
        self.model.command();
        self.model.held.clear();
        let mut simulation = Simulation {
            time: self.window.time.clone(),
            outputs: vec![vec![f64::NAN; samples]; net.meters.len()],
            states: vec![vec![f64::NAN; samples]; n],
            held: Vec::new(),
            status: RunStatus::Finished,
        };
        if n == 0 {
            for i in 0..samples {
                self.model.feed_sample(i);
                self.model.read(&[], i, &mut simulation.outputs);
            }
        } else {
            let x = self.initial(theta)?;
            let plan = Plan {
                start: self.window.time[0],
                end: self.window.time[samples - 1],
                outputs: &self.window.time,
                breaks: &self.breaks,
            };
            let settings = integrate::Options {
                tolerances: Tolerances {
                    relative: self.options.relative,
                    absolute: self.absolute.clone(),
                },
                max_steps: self.options.max_steps,
                ..integrate::Options::new(0.0, Vec::new())
            };
            let run =
                integrate::integrate(self.options.method, &mut self.model, &x, &plan, &settings)?;
            if run.status != Status::Finished {
                simulation.status = RunStatus::Stopped(run.status);
            }
            for (i, state) in run.states.chunks_exact(n).enumerate() {
                for (column, value) in simulation.states.iter_mut().zip(state) {
                    column[i] = *value;
                }
                self.model.feed_sample(i);
                self.model.read(state, i, &mut simulation.outputs);
            }
        }
        self.model
            .instruments(&self.window.time, &mut simulation.outputs);
        simulation.held = self
            .model
            .held
            .iter()
            .map(|&(k, t, full)| (net.states[k].path.clone(), t, full))
            .collect();
        if self.model.work.borrow().failed && simulation.status == RunStatus::Finished {
            simulation.status = RunStatus::NotSolved;
        }
        Ok(simulation)
    }

    /// States at the window's start.
    pub(crate) fn initial(&self, theta: &[f64]) -> Result<Vec<f64>, AssemblyError> {
        let net = self.model.net;
        let free = net
            .states
            .iter()
            .filter(|s| s.start.found().is_some())
            .count();
        let number = self.number.min(self.assembly.training_windows() - 1);
        let mut given = theta[net.free.len() + number * free..].iter();
        let mut x = vec![0.0; net.states.len()];
        let work = &mut self.model.work.borrow_mut();
        for (i, state) in net.states.iter().enumerate() {
            x[i] = match state.start {
                Start::Given(value) => value,
                Start::Free(_) => given.next().copied().unwrap_or_default(),
                Start::Steady | Start::Effect => 0.0,
                Start::Measured(meter) | Start::Near(meter, _) => {
                    let reading = self
                        .window
                        .readings
                        .get(meter)
                        .and_then(|r| r.iter().find(|v| v.is_finite()));
                    let m = &net.meters[meter];
                    let own = &work.values[net.parts[m.part].base..];
                    let along = match m.reading {
                        Reading::Flow { sign, .. } => sign,
                        _ => 1.0,
                    };
                    let off = match state.start {
                        Start::Near(..) => given.next().copied().unwrap_or_default(),
                        _ => 0.0,
                    };
                    reading
                        .map(|&r| along * m.quantity(own, r) + off)
                        .filter(|v| v.is_finite())
                        .ok_or_else(|| AssemblyError::Value {
                            name: state.path.clone(),
                            found: f64::NAN,
                            expected: "a reading of its instrument in the window",
                        })?
                }
            };
        }
        for (i, driven) in net.driven.iter().enumerate() {
            let value = self.window.inputs[i][0];
            (work.raw[driven.slot], work.values[driven.slot]) = (value, value);
        }
        work.t = 0.0;
        settle(net, work, &mut x);
        work.failed = false;
        Ok(x)
    }
}

/// Fills in flows that start at rest with their surroundings, and the effects' states.
pub(crate) fn settle(net: &Network, work: &mut Work, x: &mut [f64]) {
    for attached in net.effects.iter().filter(|a| !a.states.is_empty()) {
        start_effect(net, work, attached, x);
    }
    for _ in 0..80 {
        let mut moved = 0.0_f64;
        for &c in &net.inertial {
            let Flow::State(state) = net.chains[c].flow else {
                continue;
            };
            if net.states[state].start != Start::Steady {
                continue;
            }
            work.solve(net, x);
            let push = work.push(net, c, x);
            // From rest the slope of a square law is small: by steps of the usual flow the nearest balance is found, not
            // one beyond the range that the friction's polynomial was made for.
            let most = net.states[state].size;
            let step = if push.d < 0.0 {
                (push.v / -push.d).clamp(-most, most)
            } else {
                most * push.v.signum()
            };
            if !step.is_finite() {
                continue;
            }
            let mut next = x[state] + step;
            if net.chains[c].check_valve {
                next = next.max(0.0);
            }
            moved = moved.max((next - x[state]).abs() / net.states[state].size);
            x[state] = next;
        }
        if moved < 1e-13 {
            break;
        }
    }
    for attached in net.effects.iter().filter(|a| !a.states.is_empty()) {
        start_effect(net, work, attached, x);
    }
}

fn start_effect(net: &Network, work: &mut Work, attached: &Attached, x: &mut [f64]) {
    work.solve(net, x);
    let drive = work.drive(net, attached, x);
    let mut own = x[attached.states.clone()].to_vec();
    attached
        .effect
        .start(&work.now(net, attached, x), &drive, &mut own);
    x[attached.states.clone()].copy_from_slice(&own);
}

pub(crate) fn set_theta(net: &Network, work: &mut Work, theta: &[f64]) {
    for (free, &value) in net.free.iter().zip(theta) {
        work.raw[free.slot] = value;
        work.values[free.slot] = value;
    }
}

/// Pressure of the node `atmosphere`, Pa.
pub const ATMOSPHERE: f64 = ATMOSPHERE_PA;
