//! Runs an assembly over a window of samples.

use crate::assembly::Assembly;
use crate::error::AssemblyError;
use crate::kinds;
use crate::model::{Mode, Work};
use crate::network::{ATMOSPHERE_PA, Flow, Network, Reading, Start};
use crate::record::Window;
use crate::spec::Between;
use dgd_dynamics::inputs::{Cursor, Interpolation, Piece, Signal, merged_kinks};
use dgd_dynamics::integrate::{self, Linearised, Method, Plan, Status, System, Tolerances};
use std::cell::RefCell;

/// Settings of a simulation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SimulationOptions {
    /// Integration method; [`Method::Rodas`] by default, which stiff systems need.
    pub method: Method,
    /// Relative tolerance of a step; 1e-5 by default. The absolute one is a tenth of it times the state's usual size.
    pub relative: f64,
    /// Steps after which to give up; 10 million by default.
    pub max_steps: usize,
}

impl Default for SimulationOptions {
    fn default() -> Self {
        Self {
            method: Method::default(),
            relative: 1e-5,
            max_steps: 10_000_000,
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
    /// Runs a window with the parameters `theta`.
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

/// What the integrator runs.
pub(crate) struct Model<'a> {
    pub(crate) net: &'a Network,
    pub(crate) work: RefCell<Work>,
    scratch: RefCell<[Vec<f64>; 2]>,
    signals: Vec<Signal<'a>>,
    cursors: Vec<Cursor>,
    pieces: Vec<Piece>,
    /// Time zero of what effects see.
    start: f64,
    /// Time stands still: for steady states.
    frozen: bool,
    moves: bool,
    held: Vec<(usize, f64, bool)>,
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
        let breaks = merged_kinks(&signals.iter().collect::<Vec<_>>(), start, end);
        let n = net.states.len();
        let model = Model {
            net,
            work: RefCell::new(Work::new(net)),
            scratch: RefCell::new([vec![0.0; n], vec![0.0; n]]),
            cursors: vec![Cursor::default(); signals.len()],
            pieces: vec![Piece::default(); signals.len()],
            signals,
            start: window.origin(),
            frozen: false,
            moves: !net.effects.is_empty(),
            held: Vec::new(),
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
                self.model.feed_sample(self.window, i);
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
                self.model.feed_sample(self.window, i);
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
            .filter(|s| matches!(s.start, Start::Free(_)))
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
                Start::Measured(meter) => {
                    let reading = self
                        .window
                        .readings
                        .get(meter)
                        .and_then(|r| r.iter().find(|v| v.is_finite()));
                    let m = &net.meters[meter];
                    let own = &work.values[net.parts[m.part].base..];
                    reading
                        .map(|&r| m.quantity(own, r))
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
            let step = push.v / -push.d;
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

fn start_effect(
    net: &Network,
    work: &mut Work,
    attached: &crate::network::Attached,
    x: &mut [f64],
) {
    work.solve(net, x);
    let drive = work.drive(net, attached.part, x);
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

impl<'a> Model<'a> {
    /// A model whose inputs stand still.
    pub(crate) fn still(net: &'a Network, theta: &[f64], inputs: &[f64]) -> Self {
        let n = net.states.len();
        let mut work = Work::new(net);
        set_theta(net, &mut work, theta);
        let pieces = inputs
            .iter()
            .map(|&value| Piece {
                from_s: 0.0,
                value,
                slope: 0.0,
            })
            .collect();
        let model = Self {
            net,
            work: RefCell::new(work),
            scratch: RefCell::new([vec![0.0; n], vec![0.0; n]]),
            signals: Vec::new(),
            cursors: Vec::new(),
            pieces,
            start: 0.0,
            frozen: true,
            moves: false,
            held: Vec::new(),
        };
        model.feed(&mut model.work.borrow_mut(), 0.0);
        model
    }

    pub(crate) fn feed(&self, work: &mut Work, t: f64) {
        work.t = if self.frozen { 0.0 } else { t - self.start };
        for (driven, piece) in self.net.driven.iter().zip(&self.pieces) {
            let value = piece.at(t);
            (work.raw[driven.slot], work.values[driven.slot]) = (value, value);
        }
    }

    pub(crate) fn feed_sample(&self, window: &Window, i: usize) {
        let work = &mut *self.work.borrow_mut();
        work.t = window.time[i] - self.start;
        for (driven, values) in self.net.driven.iter().zip(&window.inputs) {
            (work.raw[driven.slot], work.values[driven.slot]) = (values[i], values[i]);
        }
    }

    /// Writes what the instruments would read at a sample.
    pub(crate) fn read(&self, x: &[f64], i: usize, outputs: &mut [Vec<f64>]) {
        let net = self.net;
        let work = &mut *self.work.borrow_mut();
        if net
            .meters
            .iter()
            .any(|m| !matches!(m.reading, Reading::Level(_)))
        {
            for &c in &net.valves {
                if let Flow::State(state) = net.chains[c].flow {
                    work.shut[c] = x[state] <= 0.0;
                }
            }
            work.solve(net, x);
            work.accelerate(net, x);
        }
        for (meter, column) in net.meters.iter().zip(outputs) {
            column[i] = work.reading(net, meter, x);
        }
    }

    /// Effects of the instruments on their readings.
    pub(crate) fn instruments(&self, time: &[f64], outputs: &mut [Vec<f64>]) {
        let work = self.work.borrow();
        let since: Vec<f64> = time.iter().map(|t| t - self.start).collect();
        for (meter, column) in self.net.meters.iter().zip(outputs) {
            for attached in self.net.effects_of(meter.part) {
                attached
                    .effect
                    .reading(&work.now(self.net, attached, &[]), &since, column);
            }
        }
    }
}

impl Work {
    /// What a meter reads, after gain and offset; [`solve`](Self::solve) first unless it reads a level.
    pub(crate) fn reading(&self, net: &Network, meter: &crate::network::Meter, x: &[f64]) -> f64 {
        let at = |l| self.pressure_at(net, l, x);
        let quantity = match meter.reading {
            Reading::Level(tank) => x[tank],
            Reading::Pressure(l) => at(l),
            Reading::Drop { inlet, outlet } => at(inlet) - at(outlet),
            Reading::Head { inlet, outlet } => (at(outlet) - at(inlet)) / self.weight(),
            Reading::Flow { chain, sign } => sign * self.flow[chain],
            Reading::Leaving { chain } => self.leaving[chain],
            Reading::Source(part) => self.values[net.parts[part].base + kinds::boundary::FLOW],
            Reading::Speed(slot) => self.values[slot],
        };
        let own = &self.values[net.parts[meter.part].base..];
        meter.said(own, quantity)
    }
}

impl System for Model<'_> {
    fn dimension(&self) -> usize {
        self.net.states.len()
    }

    fn rhs(&self, t: f64, x: &[f64], rate: &mut [f64]) {
        let work = &mut *self.work.borrow_mut();
        self.feed(work, t);
        work.solve(self.net, x);
        work.rates(self.net, x, rate);
    }

    fn linearise(&self, t: f64, x: &[f64], step: f64, out: Linearised<'_>) -> usize {
        let n = x.len();
        self.rhs(t, x, out.rate);
        let [moved, changed] = &mut *self.scratch.borrow_mut();
        moved.copy_from_slice(x);
        for j in 0..n {
            moved[j] = x[j] + 1e-7 * x[j].abs().max(self.net.states[j].size);
            let h = moved[j] - x[j];
            self.rhs(t, moved, changed);
            for i in 0..n {
                out.jacobian[i * n + j] = (changed[i] - out.rate[i]) / h;
            }
            moved[j] = x[j];
        }
        if !self.moves && self.pieces.iter().all(|p| p.slope == 0.0) {
            out.drift.fill(0.0);
            return n + 1;
        }
        let h = (1e-4 * step).max(1e-8 * t.abs()).min(step);
        self.rhs(t + h, x, out.drift);
        for i in 0..n {
            out.drift[i] = if h > 0.0 {
                (out.drift[i] - out.rate[i]) / h
            } else {
                0.0
            };
        }
        n + 2
    }

    fn begin_segment(&mut self, start: f64, end: f64, _x: &[f64]) {
        for ((signal, cursor), piece) in self
            .signals
            .iter()
            .zip(&mut self.cursors)
            .zip(&mut self.pieces)
        {
            *piece = signal.piece(cursor, start, end);
        }
    }

    fn guards(&self) -> usize {
        self.net.tanks.len() + self.net.valves.len()
    }

    fn guard(&self, index: usize, t: f64, x: &[f64]) -> f64 {
        let net = self.net;
        let work = &mut *self.work.borrow_mut();
        if let Some(valve) = index.checked_sub(net.tanks.len()) {
            let c = net.valves[valve];
            let Flow::State(state) = net.chains[c].flow else {
                return 0.0;
            };
            if !work.shut[c] {
                return x[state];
            }
            self.feed(work, t);
            work.solve(net, x);
            return -work.push(net, c, x).v;
        }
        match work.mode[index] {
            Mode::Between => x[index].min(work.brim(net, index, x) - x[index]),
            held => {
                self.feed(work, t);
                work.solve(net, x);
                work.balance(net, x);
                if held == Mode::Full {
                    work.net_flow[index]
                } else {
                    -work.net_flow[index]
                }
            }
        }
    }

    fn cross(&mut self, index: usize, t: f64, x: &mut [f64]) {
        let net = self.net;
        let work = &mut *self.work.borrow_mut();
        if let Some(valve) = index.checked_sub(net.tanks.len()) {
            let c = net.valves[valve];
            if let Flow::State(state) = net.chains[c].flow {
                work.shut[c] = !work.shut[c];
                x[state] = 0.0;
            }
            return;
        }
        work.mode[index] = match work.mode[index] {
            Mode::Between => {
                let brim = work.brim(net, index, x);
                let full = brim - x[index] < x[index];
                x[index] = if full { brim } else { 0.0 };
                if !self.held.iter().any(|&(k, _, f)| k == index && f == full) {
                    self.held.push((index, t, full));
                }
                if full { Mode::Full } else { Mode::Empty }
            }
            _ => Mode::Between,
        };
    }
}

/// Pressure of the node `atmosphere`, Pa.
pub const ATMOSPHERE: f64 = ATMOSPHERE_PA;
