//! What the integrator runs: rates, guards and readings of a network whose inputs move.

use super::set_theta;
use crate::kinds;
use crate::model::{Mode, Work};
use crate::network::{Flow, Meter, Network, Reading};
use crate::record::Window;
use crate::spec::Between;
use dgd_dynamics::inputs::{Cursor, Piece, Signal};
use dgd_dynamics::integrate::{Linearised, System};
use std::cell::RefCell;

/// What the integrator runs.
pub(crate) struct Model<'a> {
    pub(crate) net: &'a Network,
    pub(crate) work: RefCell<Work>,
    scratch: RefCell<[Vec<f64>; 2]>,
    pub(super) signals: Vec<Signal<'a>>,
    window: Option<&'a Window>,
    /// Samples of the inputs that effects change before a run; empty for the others.
    commanded: Vec<Vec<f64>>,
    cursors: Vec<Cursor>,
    pieces: Vec<Piece>,
    /// Time zero of what effects see.
    start: f64,
    /// Time stands still: for steady states.
    frozen: bool,
    moves: bool,
    /// Tanks that were full or empty: state, time of the first event, `true` if full.
    pub(super) held: Vec<(usize, f64, bool)>,
}

impl<'a> Model<'a> {
    /// A model whose inputs follow these signals of a window.
    pub(super) fn moving(net: &'a Network, signals: Vec<Signal<'a>>, window: &'a Window) -> Self {
        let n = net.states.len();
        Self {
            net,
            work: RefCell::new(Work::new(net)),
            scratch: RefCell::new([vec![0.0; n], vec![0.0; n]]),
            cursors: vec![Cursor::default(); signals.len()],
            pieces: vec![Piece::default(); signals.len()],
            signals,
            window: Some(window),
            commanded: vec![Vec::new(); net.driven.len()],
            start: window.origin(),
            frozen: false,
            moves: !net.effects.is_empty(),
            held: Vec::new(),
        }
    }

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
            window: None,
            commanded: Vec::new(),
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

    /// Shuts the check valves of heavy chains that stand still at the state `x` and are not pushed forwards.
    pub(crate) fn shut_valves(&self, x: &[f64]) {
        let work = &mut *self.work.borrow_mut();
        work.solve(self.net, x);
        for &c in &self.net.valves {
            if let Flow::State(state) = self.net.chains[c].flow {
                work.shut[c] = x[state] <= 0.0 && work.push(self.net, c, x).v <= 0.0;
            }
        }
    }

    pub(crate) fn feed(&self, work: &mut Work, t: f64) {
        work.t = if self.frozen { 0.0 } else { t - self.start };
        for (driven, piece) in self.net.driven.iter().zip(&self.pieces) {
            let value = piece.at(t);
            (work.raw[driven.slot], work.values[driven.slot]) = (value, value);
        }
    }

    pub(crate) fn feed_sample(&self, i: usize) {
        let Some(window) = self.window else {
            return;
        };
        let work = &mut *self.work.borrow_mut();
        work.t = window.time[i] - self.start;
        let given = window.inputs.iter().zip(&self.commanded);
        for (driven, (values, commanded)) in self.net.driven.iter().zip(given) {
            let value = *commanded.get(i).unwrap_or(&values[i]);
            (work.raw[driven.slot], work.values[driven.slot]) = (value, value);
        }
    }

    /// Whether an effect changes the samples of an input before a run.
    pub(super) fn commands(&self) -> bool {
        let hooked = |&(slot, part): &(usize, usize)| {
            let effects = self.net.effects_of(part);
            self.net.driven.iter().any(|d| d.slot == slot)
                && effects.iter().any(|a| a.effect.has_command())
        };
        self.net.hooked.iter().any(hooked)
    }

    /// Lets effects change the samples of the inputs, by the parameters as they stand.
    pub(crate) fn command(&mut self) {
        let Some(window) = self.window else {
            return;
        };
        let work = self.work.borrow();
        for (k, driven) in self.net.driven.iter().enumerate() {
            let hooked = self
                .net
                .hooked
                .iter()
                .find(|(slot, _)| *slot == driven.slot);
            let Some(&(_, part)) = hooked else {
                continue;
            };
            let effects = self.net.effects_of(part).iter();
            for attached in effects.filter(|a| a.effect.has_command()) {
                let held = driven.between == Between::Held;
                let now = work.now(self.net, attached, &[]);
                let mut values = window.inputs[k].clone();
                attached.effect.command(&now, held, &mut values);
                self.commanded[k] = values;
            }
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
            // While time stands still, valves stay as they are.
            for &c in net.valves.iter().filter(|_| !self.frozen) {
                if let Flow::State(state) = net.chains[c].flow {
                    work.shut[c] = x[state] <= 0.0;
                }
            }
            work.solve(net, x);
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
            let effects = self.net.effects_of(meter.part);
            if effects.is_empty() {
                continue;
            }
            // An effect alters what a gauge shows, from the zero of its own unit.
            let zero = meter.zero();
            column.iter_mut().for_each(|value| *value -= zero);
            for attached in effects {
                attached
                    .effect
                    .reading(&work.now(self.net, attached, &[]), &since, column);
            }
            column.iter_mut().for_each(|value| *value += zero);
        }
    }
}

/// The piece of samples that an effect has changed over `start..=end`, which no sample parts.
fn changed(time: &[f64], values: &[f64], between: Between, start: f64, end: f64) -> Piece {
    let next = time.partition_point(|t| *t <= start).max(1);
    let (from_s, value) = (time[next - 1], values[next - 1]);
    let slope = match (between, time.get(next)) {
        (Between::Interpolated, Some(t)) if end > start => (values[next] - value) / (t - from_s),
        _ => 0.0,
    };
    Piece {
        from_s,
        value,
        slope,
    }
}

impl Work {
    /// What a meter reads, after gain and offset; [`solve`](Self::solve) first unless it reads a level.
    pub(crate) fn reading(&self, net: &Network, meter: &Meter, x: &[f64]) -> f64 {
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
        let Some(window) = self.window else {
            return;
        };
        for ((driven, values), piece) in self
            .net
            .driven
            .iter()
            .zip(&self.commanded)
            .zip(&mut self.pieces)
        {
            if !values.is_empty() {
                *piece = changed(&window.time, values, driven.between, start, end);
            }
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
