//! The compiled form of a system: slots, nodes, chains, and the order in which they are solved.

use crate::effect::{Effect, Scale};
use crate::kinds::instrument;
use crate::laws::Friction;
use crate::spec::{Between, Bounds, Kind};
use dgd_units::Dimension;
use std::ops::Range;

/// Slots of the fluid come first.
pub(crate) const FLUID_SLOTS: usize = 3;
/// Pressure of the node `atmosphere`, Pa.
pub(crate) const ATMOSPHERE_PA: f64 = 101_325.0;

/// A component with its place in the slots.
#[derive(Clone)]
pub(crate) struct Part {
    pub name: String,
    pub kind: Kind,
    /// First slot of its properties.
    pub base: usize,
    pub count: usize,
    pub friction: Friction,
    pub inertia: bool,
    pub check_valve: bool,
    /// Tank whose column moves with this line.
    pub column: Option<usize>,
    /// Area over height of a tank, ascending.
    pub profile: Vec<[f64; 2]>,
    /// Ports of a tank: name, slot of the height (none: top).
    pub ports: Vec<(String, Option<usize>)>,
    /// Boundary: it gives a flow.
    pub gives_flow: bool,
    /// Its effects in [`Network::effects`].
    pub effects: Range<usize>,
    pub scale: Scale,
}

/// An effect on a part.
#[derive(Clone)]
pub(crate) struct Attached {
    pub effect: &'static dyn Effect,
    pub part: usize,
    /// Its parameters in the slots.
    pub base: usize,
    pub count: usize,
    /// Its states.
    pub states: Range<usize>,
}

/// What sets a node's pressure.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum NodeKind {
    /// A tank's port (its number among the tanks), at the height in a slot or at the top.
    Port {
        tank: usize,
        height: Option<usize>,
    },
    /// A volume (its number).
    Volume(usize),
    /// A pressure boundary (its part).
    Boundary(usize),
    Atmosphere,
    Free,
}

#[derive(Debug, Clone)]
pub(crate) struct Node {
    pub kind: NodeKind,
    pub name: String,
    /// Flow boundaries that feed it (parts).
    pub sources: Vec<usize>,
    /// Chains that start (−1) or end (+1) here.
    pub chains: Vec<(usize, f64)>,
}

/// A branch in a chain; `sign` is −1 if the chain passes it from outlet to inlet.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Member {
    pub part: usize,
    pub sign: f64,
}

/// How a chain's flow is found.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Flow {
    /// A state.
    State(usize),
    /// A displacement pump (its member) sets it.
    Prescribed(usize),
    /// From the pressures at its ends.
    Algebraic,
    /// From the mass balance of a node.
    Forced,
}

/// Branches in series between two nodes: one flow.
#[derive(Debug, Clone)]
pub(crate) struct Chain {
    pub from: usize,
    pub to: usize,
    pub members: Vec<Member>,
    pub flow: Flow,
    /// A displacement pump whose flow depends on pressure (its member).
    pub slipping: Option<usize>,
    pub check_valve: bool,
    /// One valve without effects: solved in closed form.
    pub plain_valve: bool,
    /// Effects change what leaves at the end.
    pub leaves_other: bool,
}

/// One step of the algebraic solution.
#[derive(Debug, Clone)]
pub(crate) enum Step {
    /// Flow of a chain whose end pressures are known.
    Direct(usize),
    /// Flow of `chain` from the balance of `node`; `sign` as in [`Node::chains`].
    Forced {
        node: usize,
        chain: usize,
        sign: f64,
    },
    /// Pressures of several nodes at once.
    Island(usize),
    /// Pressure of `node` from the other end of `chain`.
    Pressure { node: usize, chain: usize },
}

/// Nodes solved together, with the chains between them and the known.
#[derive(Debug, Clone, Default)]
pub(crate) struct Island {
    pub nodes: Vec<usize>,
    pub chains: Vec<usize>,
}

/// Where a port's pressure is found.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Location {
    Node(usize),
    /// After `members` members of a chain.
    Inside {
        chain: usize,
        members: usize,
    },
}

/// What an instrument reads.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Reading {
    Level(usize),
    Pressure(Location),
    Drop {
        inlet: Location,
        outlet: Location,
    },
    Head {
        inlet: Location,
        outlet: Location,
    },
    Flow {
        chain: usize,
        sign: f64,
    },
    /// What leaves a chain's end, which effects may make another flow.
    Leaving {
        chain: usize,
    },
    /// Flow of a flow boundary (its part).
    Source(usize),
    Speed(usize),
}

impl Reading {
    /// Dimension of what is measured; none of a speed, which pumps take in units of their own.
    pub(crate) fn dimension(&self) -> Option<Dimension> {
        match self {
            Self::Level(_) | Self::Head { .. } => Some(Dimension::Length),
            Self::Pressure(_) | Self::Drop { .. } => Some(Dimension::Pressure),
            Self::Flow { .. } | Self::Leaving { .. } | Self::Source(_) => Some(Dimension::FlowRate),
            Self::Speed(_) => None,
        }
    }
}

#[derive(Debug, Clone)]
pub(crate) struct Meter {
    pub part: usize,
    pub name: String,
    pub channel: String,
    pub unit: Option<dgd_units::Unit>,
    pub reading: Reading,
}

impl Meter {
    /// SI units in one of the instrument's, and the SI value of its zero. Voltages and bare numbers stay as they are.
    fn map(&self) -> (f64, f64) {
        let unit = self.unit.filter(|u| u.dimension != Dimension::Number);
        unit.map_or((1.0, 0.0), |u| (u.factor, u.offset))
    }

    /// The SI value of its unit's zero.
    pub(crate) fn zero(&self) -> f64 {
        self.map().1
    }

    /// What the instrument says of a quantity, both in SI units; gain and offset of its properties `own` are in its own.
    #[inline]
    pub(crate) fn said(&self, own: &[f64], quantity: f64) -> f64 {
        let (factor, zero) = self.map();
        own[instrument::GAIN] * (quantity - zero) + factor * own[instrument::OFFSET] + zero
    }

    /// The quantity of which it says `reading`, both in SI units.
    pub(crate) fn quantity(&self, own: &[f64], reading: f64) -> f64 {
        let (factor, zero) = self.map();
        (reading - zero - factor * own[instrument::OFFSET]) / own[instrument::GAIN] + zero
    }
}

/// A channel that drives a slot.
#[derive(Debug, Clone)]
pub(crate) struct Driven {
    pub path: String,
    pub slot: usize,
    pub channel: String,
    pub between: Between,
    pub unit: Option<dgd_units::Unit>,
}

/// A parameter to be found.
#[derive(Debug, Clone)]
pub(crate) struct FreeSlot {
    pub path: String,
    pub slot: usize,
    pub bounds: Bounds,
}

/// How a state starts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Start {
    Given(f64),
    /// First valid sample of a meter.
    Measured(usize),
    /// The same, off by what is found within these bounds around 0.
    Near(usize, Bounds),
    Free(Bounds),
    /// Flow at which nothing accelerates.
    Steady,
    /// An effect's own state.
    Effect,
}

impl Start {
    /// Bounds of what is found of it, a value for each training window.
    pub(crate) fn found(&self) -> Option<&Bounds> {
        match self {
            Self::Free(bounds) | Self::Near(_, bounds) => Some(bounds),
            _ => None,
        }
    }
}

#[derive(Debug, Clone)]
pub(crate) struct StateInfo {
    pub path: String,
    pub start: Start,
    /// Its usual size, for tolerances.
    pub size: f64,
}

/// The compiled system.
#[derive(Clone)]
pub(crate) struct Network {
    pub parts: Vec<Part>,
    pub effects: Vec<Attached>,
    /// Parts that are tanks and volumes, in the order of their states.
    pub tanks: Vec<usize>,
    pub volumes: Vec<usize>,
    pub nodes: Vec<Node>,
    pub chains: Vec<Chain>,
    /// Chains whose flow is a state, in order.
    pub inertial: Vec<usize>,
    pub plan: Vec<Step>,
    pub islands: Vec<Island>,
    pub states: Vec<StateInfo>,
    pub meters: Vec<Meter>,
    pub driven: Vec<Driven>,
    pub free: Vec<FreeSlot>,
    /// Known values, free ones at their start.
    pub values: Vec<f64>,
    /// Tank (number) that catches what a tank spills.
    pub below: Vec<Option<usize>>,
    /// Tanks from the uppermost down.
    pub tank_order: Vec<usize>,
    /// Slots that effects alter, with the part.
    pub hooked: Vec<(usize, usize)>,
    /// Where inlet and outlet of each part are.
    pub ends: Vec<[Option<Location>; 2]>,
    /// Chain and place in it of each branch.
    pub seat: Vec<Option<(usize, usize)>>,
    /// Chains with a check valve and inertia.
    pub valves: Vec<usize>,
    pub in_time: bool,
    /// Seconds a unit of the record's time column; 1 where the samples do not stand along time.
    pub tick: f64,
}

impl Network {
    pub(crate) fn effects_of(&self, part: usize) -> &[Attached] {
        &self.effects[self.parts[part].effects.clone()]
    }
}
