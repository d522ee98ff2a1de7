//! One evaluation of the compiled network: pressures, flows, rates. No allocation.

mod branch;
mod nodal;
mod tanks;

use crate::Dual;
use crate::effect::{Drive, Now};
use crate::kinds::{boundary, fluid, tank, valve, volume};
use crate::laws;
use crate::network::{ATMOSPHERE_PA, Attached, Flow, Location, Member, Network, NodeKind, Step};
use crate::spec::Kind;

/// Where a tank's level is held.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Mode {
    Between,
    Full,
    Empty,
}

/// `dp = k q|q|` of a valve or orifice.
#[derive(Debug, Clone, Copy)]
struct Square {
    part: usize,
    of: [f64; valve::COUNT + 1],
    k: f64,
}

/// Everything an evaluation writes.
#[derive(Debug, Clone)]
pub(crate) struct Work {
    /// Slots as the components feel them.
    pub values: Vec<f64>,
    /// Slots before effects on inputs, for the hooked ones.
    pub raw: Vec<f64>,
    /// Time since the window's start.
    pub t: f64,
    heads: Vec<f64>,
    gas: Vec<f64>,
    pub pressure: Vec<f64>,
    pub flow: Vec<f64>,
    /// Rate of an inertial chain's flow.
    pub acceleration: Vec<f64>,
    /// What leaves each chain.
    pub leaving: Vec<f64>,
    /// What fills a tank, overflow not taken off.
    pub net_flow: Vec<f64>,
    inflow: Vec<f64>,
    outflow: Vec<f64>,
    caught: Vec<f64>,
    pub mode: Vec<Mode>,
    /// Check valves of inertial chains that are shut, by chain.
    pub shut: Vec<bool>,
    residual: Vec<f64>,
    matrix: Vec<f64>,
    step: Vec<f64>,
    trial: Vec<f64>,
    /// Valves and orifices with the properties at which their square was last found, and that square.
    squares: Vec<Square>,
    /// Place of each part in `squares`.
    square_of: Vec<usize>,
    /// Surface of each tank with effects, by [`balance`](Self::balance).
    surface: Vec<f64>,
    /// A scalar or nodal solution did not converge.
    pub failed: bool,
}

impl Work {
    pub(crate) fn new(net: &Network) -> Self {
        let tanks = net.tanks.len();
        let mut squares = Vec::new();
        let mut square_of = vec![0; net.parts.len()];
        for (part, p) in net.parts.iter().enumerate() {
            if matches!(p.kind, Kind::Valve | Kind::Orifice) {
                square_of[part] = squares.len();
                squares.push(Square {
                    part,
                    of: [f64::NAN; valve::COUNT + 1],
                    k: f64::NAN,
                });
            }
        }
        let widest = net.islands.iter().map(|i| i.nodes.len()).max().unwrap_or(0);
        Self {
            values: net.values.clone(),
            raw: net.values.clone(),
            t: 0.0,
            heads: vec![0.0; tanks],
            gas: vec![0.0; tanks],
            pressure: vec![ATMOSPHERE_PA; net.nodes.len()],
            flow: vec![0.0; net.chains.len()],
            acceleration: vec![0.0; net.chains.len()],
            leaving: vec![0.0; net.chains.len()],
            net_flow: vec![0.0; tanks],
            inflow: vec![0.0; tanks],
            outflow: vec![0.0; tanks],
            caught: vec![0.0; tanks],
            mode: vec![Mode::Between; tanks],
            shut: vec![false; net.chains.len()],
            residual: vec![0.0; widest],
            matrix: vec![0.0; widest * widest],
            step: vec![0.0; widest],
            trial: vec![0.0; widest],
            squares,
            square_of,
            surface: vec![0.0; tanks],
            failed: false,
        }
    }

    /// Forgets the last solution, so that a run depends on its own inputs alone.
    pub(crate) fn reset(&mut self) {
        self.flow.fill(0.0);
        self.pressure.fill(ATMOSPHERE_PA);
        self.mode.fill(Mode::Between);
        self.shut.fill(false);
        self.failed = false;
    }

    /// Finds the squares of valves anew whose properties have changed: mostly none has.
    #[inline]
    fn refresh(&mut self, net: &Network) {
        let density = self.values[fluid::DENSITY];
        for square in &mut self.squares {
            let base = net.parts[square.part].base;
            let own = &self.values[base..base + valve::COUNT];
            if square.of[..valve::COUNT] != *own || square.of[valve::COUNT] != density {
                square.of[..valve::COUNT].copy_from_slice(own);
                square.of[valve::COUNT] = density;
                square.k = laws::valve_square(own, density);
            }
        }
    }

    #[inline(always)]
    pub(crate) fn now<'a>(
        &'a self,
        net: &'a Network,
        attached: &Attached,
        x: &'a [f64],
    ) -> Now<'a> {
        let part = &net.parts[attached.part];
        Now {
            t_s: self.t,
            density_kg_m3: self.values[fluid::DENSITY],
            viscosity_pa_s: self.values[fluid::VISCOSITY],
            gravity_m_s2: self.values[fluid::GRAVITY],
            scale: &part.scale,
            own: &self.values[part.base..part.base + part.count],
            p: &self.values[attached.base..attached.base + attached.count],
            x: x.get(attached.states.clone()).unwrap_or(&[]),
        }
    }

    pub(crate) fn weight(&self) -> f64 {
        self.values[fluid::DENSITY] * self.values[fluid::GRAVITY]
    }

    /// Solves pressures and flows at the state `x`; the inputs stand in `values`.
    pub(crate) fn solve(&mut self, net: &Network, x: &[f64]) {
        for &(slot, part) in &net.hooked {
            let mut value = self.raw[slot];
            for attached in net.effects_of(part) {
                value = attached.effect.input(&self.now(net, attached, x), value);
            }
            self.values[slot] = value;
        }
        self.refresh(net);
        for k in 0..net.tanks.len() {
            let part = &net.parts[net.tanks[k]];
            let own = &self.values[part.base..];
            let mut gas = own[tank::GAS_PRESSURE];
            if own[tank::GAS_VOLUME].is_finite() {
                // Isothermal cushion; a thousandth of it stays however full the tank.
                let left = own[tank::GAS_VOLUME] - self.filled(net, k, x);
                gas *= own[tank::GAS_VOLUME] / left.max(1e-3 * own[tank::GAS_VOLUME]);
            }
            let mut head = x[k];
            for attached in net.effects_of(net.tanks[k]) {
                head = attached.effect.head(&self.now(net, attached, x), head);
            }
            (self.gas[k], self.heads[k]) = (gas, head);
        }
        let weight = self.weight();
        for (n, node) in net.nodes.iter().enumerate() {
            self.pressure[n] = match node.kind {
                NodeKind::Port {
                    tank,
                    height: Some(slot),
                } => self.gas[tank] + weight * (self.heads[tank] - self.values[slot]).max(0.0),
                NodeKind::Port { tank, height: None } => self.gas[tank],
                NodeKind::Volume(v) => x[net.tanks.len() + v],
                NodeKind::Boundary(part) => self.values[net.parts[part].base + boundary::PRESSURE],
                NodeKind::Atmosphere => ATMOSPHERE_PA,
                NodeKind::Free => continue,
            };
        }
        for (c, chain) in net.chains.iter().enumerate() {
            match chain.flow {
                Flow::State(state) => self.flow[c] = if self.shut[c] { 0.0 } else { x[state] },
                Flow::Prescribed(member) => {
                    let Member { part, sign } = chain.members[member];
                    self.flow[c] = sign * self.delivered(net, part);
                }
                Flow::Algebraic | Flow::Forced => {}
            }
        }
        for step in &net.plan {
            match *step {
                Step::Direct(c) => {
                    let chain = &net.chains[c];
                    let dp = self.pressure[chain.from] - self.pressure[chain.to];
                    self.flow[c] = if chain.plain_valve {
                        laws::square_inverse(self.square(chain.members[0].part), dp).v
                    } else {
                        self.flow_at(net, c, dp, x).v
                    };
                }
                Step::Forced { node, chain, sign } => {
                    self.flow[chain] = 0.0;
                    self.flow[chain] = -sign * self.arriving(net, node);
                }
                Step::Island(island) => self.nodal(net, island, x),
                Step::Pressure { node, chain } => {
                    let q = Dual::variable(self.flow[chain]);
                    let drop = self.chain_drop(net, chain, q, x).v;
                    let (from, to) = (net.chains[chain].from, net.chains[chain].to);
                    self.pressure[node] = if node == from {
                        self.pressure[to] + drop
                    } else {
                        self.pressure[from] - drop
                    };
                }
            }
        }
        // What leaves a heavy chain hangs on the pressures inside it, and these on its acceleration.
        self.accelerate(net, x);
        self.leave(net, x);
    }

    /// Rates of all states; [`solve`](Self::solve) first.
    pub(crate) fn rates(&mut self, net: &Network, x: &[f64], rate: &mut [f64]) {
        self.balance(net, x);
        for k in 0..net.tanks.len() {
            rate[k] = if self.mode[k] == Mode::Between {
                self.net_flow[k] / self.surface[k]
            } else {
                0.0
            };
        }
        for v in 0..net.volumes.len() {
            let part = &net.parts[net.volumes[v]];
            let arriving: f64 = net
                .nodes
                .iter()
                .enumerate()
                .filter(|(_, n)| n.kind == NodeKind::Volume(v))
                .map(|(n, _)| self.arriving(net, n))
                .sum();
            let own = &self.values[part.base..];
            rate[net.tanks.len() + v] = own[volume::BULK_MODULUS] / own[volume::VOLUME] * arriving;
        }
        for &c in &net.inertial {
            if let Flow::State(state) = net.chains[c].flow {
                rate[state] = self.acceleration[c];
            }
        }
        for attached in net.effects.iter().filter(|a| !a.states.is_empty()) {
            let drive = self.drive(net, attached, x);
            attached.effect.rates(
                &self.now(net, attached, x),
                &drive,
                &mut rate[attached.states.clone()],
            );
        }
    }

    /// What an effect's part goes through; its input as the effects before this one leave it.
    pub(crate) fn drive(&self, net: &Network, attached: &Attached, x: &[f64]) -> Drive {
        let part = attached.part;
        let p = &net.parts[part];
        let mut drive = Drive::default();
        if let Some(&(slot, _)) = net.hooked.iter().find(|(_, i)| *i == part) {
            let before = (net.effects_of(part).iter()).take_while(|a| a.base != attached.base);
            drive.input = before.fold(self.raw[slot], |value, a| {
                a.effect.input(&self.now(net, a, x), value)
            });
        }
        if let Some(k) = net.tanks.iter().position(|&t| t == part) {
            drive.flow_m3_s = self.inflow[k];
        }
        if let Some((chain, member)) = net.seat[part] {
            drive.flow_m3_s = net.chains[chain].members[member].sign * self.flow[chain];
        }
        if p.kind == Kind::Boundary
            && let Some(Location::Node(node)) = net.ends[part][0]
        {
            drive.flow_m3_s = -self.arriving(net, node);
        }
        drive
    }

    /// Pressure at a place.
    pub(crate) fn pressure_at(&self, net: &Network, location: Location, x: &[f64]) -> f64 {
        match location {
            Location::Node(node) => self.pressure[node],
            Location::Inside { chain: c, members } => {
                let chain = &net.chains[c];
                // From the side on which no displacement pump stands: its rise is what the rest asks for.
                let pump = chain
                    .members
                    .iter()
                    .position(|m| net.parts[m.part].kind == Kind::DisplacementPump);
                let fall = |range: std::ops::Range<usize>| -> f64 {
                    chain.members[range]
                        .iter()
                        .map(|m| self.member_fall(net, c, m, x))
                        .sum()
                };
                if pump.is_some_and(|p| p < members) {
                    self.pressure[chain.to] + fall(members..chain.members.len())
                } else {
                    self.pressure[chain.from] - fall(0..members)
                }
            }
        }
    }

    /// Drop of one member in the chain's direction, with what accelerates it.
    fn member_fall(&self, net: &Network, c: usize, member: &Member, x: &[f64]) -> f64 {
        let q = Dual::variable(member.sign * self.flow[c]);
        let drop = member.sign * self.part_drop(net, member.part, q, x).v;
        match net.chains[c].flow {
            Flow::State(_) => drop + self.inertia(net, c, member.part, x) * self.acceleration[c],
            _ => drop,
        }
    }

    /// Net flow into a node from chains and boundaries.
    fn arriving(&self, net: &Network, node: usize) -> f64 {
        let node = &net.nodes[node];
        let mut sum = 0.0;
        for &source in &node.sources {
            sum += self.values[net.parts[source].base + boundary::FLOW];
        }
        for &(c, sign) in &node.chains {
            let free = node.kind == NodeKind::Free;
            sum += if sign > 0.0 && !free {
                self.leaving[c]
            } else {
                sign * self.flow[c]
            };
        }
        sum
    }
}
