//! Mistakes in a well description that people make, and how a recording reads without them.

use super::checks::{Check, Fault, faults, moves};
use super::state::{Map, State};
use dgd_recording::Channel;
use dgd_units::{Dimension, Unit};

/// Pressure units that recordings come in, besides those that the description has.
const PRESSURES: [&str; 5] = ["psia", "bara", "kPaa", "MPa", "Pa"];
/// The same for flows.
const FLOWS: [&str; 7] = ["gpm", "l/min", "m3/h", "l/s", "bbl/min", "m3/min", "m3/s"];
/// The same for clocks.
const CLOCKS: [&str; 5] = ["s", "ms", "min", "h", "d"];
/// Lengths written in another unit than they were read in: true over read.
const DEPTHS: [(f64, &str); 2] = [
    (1.0 / 0.3048, "metres written as ft"),
    (0.3048, "feet written as m"),
];
const DIAMETERS: [(f64, &str); 6] = [
    (2.54, "inches written as cm"),
    (1.0 / 2.54, "centimetres written as in"),
    (25.4, "inches written as mm"),
    (1.0 / 25.4, "millimetres written as in"),
    (10.0, "centimetres written as mm"),
    (0.1, "millimetres written as cm"),
];
const DENSITIES: [(f64, &str); 6] = [
    (8.345_404, "specific gravity written as ppg"),
    (1.0 / 8.345_404, "ppg written as specific gravity"),
    (1e3, "specific gravity written as kg/m3"),
    (1e-3, "kg/m3 written as specific gravity"),
    (119.826_43, "ppg written as kg/m3"),
    (1.0 / 119.826_43, "kg/m3 written as ppg"),
];

/// Strain beyond the least from which an explanation is no longer worth telling.
const FURTHER: f64 = 0.25;

/// Which depths.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Depth {
    All,
    Inlet,
    Outlet,
}

/// A mistake.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Cause {
    /// Channels in another unit than described.
    Unit(Vec<usize>, Unit),
    /// Columns of channels exchanged.
    Swap(Vec<(usize, usize)>),
    /// Speed of 0 to 1 in the place of percent.
    Share(usize),
    /// The clock in another unit.
    Clock(Unit, f64),
    /// Depths, or one of them, times a factor.
    Depths(Depth, f64, &'static str),
    /// The mud's density times a factor.
    Density(f64, &'static str),
    /// The return line's diameter times a factor.
    Line(f64, &'static str),
    /// Riser and pipe in it, or one of them, times a factor.
    Riser(bool, bool, f64, &'static str),
}

impl Cause {
    /// The recording as it reads without this mistake; `None` where it would not fit together.
    pub(super) fn undone<'a>(&self, state: &State<'a>) -> Option<State<'a>> {
        let mut other = state.clone();
        match self {
            Self::Unit(told, unit) => {
                for i in told {
                    other.maps[*i] = read_as(state.maps[*i], state.units[*i], *unit);
                    other.units[*i] = *unit;
                }
            }
            Self::Swap(pairs) => {
                for (a, b) in pairs {
                    other.maps[*a] = read_as(state.maps[*b], state.units[*b], state.units[*a]);
                    other.maps[*b] = read_as(state.maps[*a], state.units[*a], state.units[*b]);
                }
            }
            Self::Share(i) => {
                other.maps[*i].factor *= 100.0;
                other.maps[*i].offset *= 100.0;
            }
            Self::Clock(_, factor) => other.time *= factor,
            Self::Depths(which, factor, _) => {
                let geometry = &mut other.geometry;
                if *which != Depth::Outlet {
                    geometry.pump_inlet_depth_m *= factor;
                }
                if *which != Depth::Inlet {
                    geometry.pump_outlet_depth_m *= factor;
                }
                if let Some(depth_m) = &mut geometry.riser_pressure_sensor_depth_m
                    && *which == Depth::All
                {
                    *depth_m *= factor;
                }
            }
            Self::Density(factor, _) => other.density_kg_m3 *= factor,
            Self::Line(factor, _) => other.geometry.return_line_id_m *= factor,
            Self::Riser(riser, pipe, factor, _) => {
                if *riser {
                    other.geometry.riser_id_m *= factor;
                }
                if *pipe {
                    other.geometry.drillpipe_od_m *= factor;
                }
                let riser_m = other.geometry.riser_id_m;
                let fits = other.geometry.drillpipe_od_m < 0.9 * riser_m;
                if !fits || !(0.2..1.0).contains(&riser_m) {
                    return None;
                }
            }
        }
        Some(other)
    }

    /// Whether a fault is about what this mistake touches.
    fn touches(&self, state: &State<'_>, fault: &Fault) -> bool {
        let told: Vec<usize> = match self {
            Self::Unit(told, _) => told.clone(),
            Self::Swap(pairs) => pairs.iter().flat_map(|(a, b)| [*a, *b]).collect(),
            Self::Share(i) => vec![*i],
            _ => Vec::new(),
        };
        let of_the_rest = match fault.check {
            Check::Column(_) | Check::Riser(_) => {
                matches!(self, Self::Depths(..) | Self::Density(..))
            }
            Check::Apart => matches!(self, Self::Depths(..)),
            Check::Returned => matches!(self, Self::Clock(..)),
            Check::Moves => matches!(self, Self::Clock(..) | Self::Riser(..)),
            Check::Friction => matches!(self, Self::Line(..)),
            Check::Step => matches!(self, Self::Clock(..)),
            Check::Density => matches!(self, Self::Density(..)),
            Check::Twins(..) | Check::Flow(_) | Check::Rise | Check::Speed | Check::Lifts => false,
        };
        of_the_rest || told.iter().any(|i| concerns(state, fault, *i))
    }
}

/// Whether a channel may be what a fault is about.
fn concerns(state: &State<'_>, fault: &Fault, told: usize) -> bool {
    let flow = || state.flows().contains(&told);
    let pressure = || state.pressures().contains(&told);
    let speed = || state.facts.told[told].channel == Channel::PumpSpeed;
    match fault.check {
        Check::Column(i) | Check::Riser(i) | Check::Flow(i) => told == i,
        Check::Twins(a, b) => told == a || told == b,
        Check::Rise => pressure(),
        Check::Returned | Check::Moves => flow(),
        Check::Friction => flow() || pressure(),
        Check::Speed => speed(),
        Check::Lifts => speed() || pressure(),
        Check::Apart | Check::Step | Check::Density => false,
    }
}

/// Columns of one channel under the unit of another.
fn read_as(map: Map, from: Unit, to: Unit) -> Map {
    let factor = to.factor / from.factor;
    Map {
        from: map.from,
        factor: map.factor * factor,
        offset: (map.offset - from.offset) * factor + to.offset,
    }
}

/// A mistake that explains faults, and how the recording reads without it.
pub(super) struct Explained<'a> {
    pub(super) cause: Cause,
    pub(super) state: State<'a>,
    pub(super) left: Vec<Fault>,
    /// How far from plain the reading still is; less is better.
    strain: f64,
}

/// The single mistakes that explain most of the faults, the plainest first.
///
/// One is only taken if nothing that it touches stays at fault and nothing new comes to be.
pub(super) fn explain<'a>(state: &State<'a>, found: &[Fault]) -> Vec<Explained<'a>> {
    let mut explained: Vec<Explained<'a>> = Vec::new();
    for cause in causes(state, found) {
        let Some(other) = cause.undone(state) else {
            continue;
        };
        let left = faults(&other);
        let known = |f: &Fault| found.iter().any(|g| g.check == f.check);
        if left.len() >= found.len()
            || !left.iter().all(known)
            || left.iter().any(|f| cause.touches(&other, f))
        {
            continue;
        }
        let strain = unease(&other) + price(state, &cause);
        explained.push(Explained {
            cause,
            state: other,
            left,
            strain,
        });
    }
    let fewest = explained.iter().map(|e| e.left.len()).min();
    explained.retain(|e| Some(e.left.len()) == fewest);
    explained.sort_by(|a, b| a.strain.total_cmp(&b.strain));
    let least = explained.first().map_or(0.0, |e| e.strain);
    explained.retain(|e| e.strain <= least + FURTHER);
    explained
}

/// A unit of pressures and one of flows that are wrong at once.
pub(super) struct TwoUnits<'a> {
    /// The first mistake, and how the recording reads without it.
    pub(super) pressures: (Cause, State<'a>),
    /// The second, and how it reads without both.
    pub(super) flows: (Cause, State<'a>),
    /// As that of a single mistake.
    pub(super) strain: f64,
}

/// The plainest pair of a unit of pressures and one of flows without which nothing is at fault.
///
/// The two hide each other: friction and the level's movement rest on both, so that a unit that is right alone makes them worse.
pub(super) fn two_units<'a>(state: &State<'a>) -> Option<TwoUnits<'a>> {
    let recorded = |i: &usize| state.facts.told[*i].tag.is_some();
    let of = |dimension| {
        let causes = units(state, dimension, &recorded).into_iter();
        causes.filter_map(|cause| Some((cause.undone(state)?, cause)))
    };
    // What rests on pressures alone, or on flows alone, must be mended by the one.
    let upright =
        |wrong: &dyn Fn(&Fault) -> bool, other: &State<'_>| !faults(other).iter().any(wrong);
    let pressures =
        of(Dimension::Pressure).filter(|(other, _)| upright(&|f| f.check.is_of_pressures(), other));
    let flows: Vec<Cause> = of(Dimension::FlowRate)
        .filter(|(other, _)| upright(&|f| f.check == Check::Returned, other))
        .map(|(_, cause)| cause)
        .collect();
    let mut best: Option<TwoUnits<'a>> = None;
    for (between, pressure) in pressures {
        for flow in &flows {
            let Some(other) = flow.undone(&between) else {
                continue;
            };
            let strain = unease(&other) + price(state, &pressure) + price(state, flow);
            let plainer = best.as_ref().is_none_or(|b| strain < b.strain);
            if plainer && faults(&other).is_empty() {
                best = Some(TwoUnits {
                    pressures: (pressure.clone(), between.clone()),
                    flows: (flow.clone(), other),
                    strain,
                });
            }
        }
    }
    best
}

/// How far from plain a recording reads: twins that agree and flows that balance are likelier than what barely passes.
pub(super) fn unease(state: &State<'_>) -> f64 {
    let flowing = state.flowing();
    let mut strain: f64 = 0.0;
    for side in [state.inlets(), state.outlets()] {
        for pair in side.windows(2) {
            let (a, b) = (
                state.median(pair[0], &flowing),
                state.median(pair[1], &flowing),
            );
            if a > 0.0 && b > 0.0 {
                strain += (a / b).ln().abs();
            }
        }
    }
    let (mut back, mut pumped) = (0.0, 0.0);
    for k in &flowing {
        let (one, other) = (state.return_flow(*k), state.inflow(*k));
        if one.is_finite() && other.is_finite() {
            back += one;
            pumped += other;
        }
    }
    if back > 0.0 && pumped > 0.0 {
        strain += f64::ln(back / pumped).abs();
    }
    let moves = moves(state, &state.inlets());
    if moves.is_finite() {
        strain += 0.3 * moves.ln().abs();
    }
    strain
}

/// What a mistake costs: units that siblings have are likelier than others, one channel's mistake than several channels'.
pub(super) fn price(before: &State<'_>, cause: &Cause) -> f64 {
    match cause {
        Cause::Share(_) => 0.05,
        Cause::Unit(told, unit) => {
            // A channel without a transmitter has a unit that nobody chose.
            let siblings = before.units.iter().zip(&before.facts.told).enumerate();
            let in_use = siblings
                .filter(|(i, (_, sibling))| !told.contains(i) && sibling.tag.is_some())
                .any(|(_, (u, _))| u.dimension == unit.dimension && u.factor == unit.factor);
            if in_use { 0.0 } else { 0.1 }
        }
        Cause::Clock(_, factor) => 0.05 * (factor * before.step_s()).ln().abs(),
        Cause::Swap(pairs) => {
            let alike =
                |(a, b): &(usize, usize)| before.units[*a].dimension == before.units[*b].dimension;
            let each = pairs.iter().map(|p| if alike(p) { 0.1 } else { 0.2 });
            each.sum::<f64>()
        }
        _ => 0.2,
    }
}

/// Units of a dimension that one of its channels, or several that go together, may be in.
fn units(state: &State<'_>, dimension: Dimension, recorded: &dyn Fn(&usize) -> bool) -> Vec<Cause> {
    // Who counts strokes has no unit of flow to be wrong about.
    let recorded = &|i: &usize| {
        recorded(i) && !(dimension == Dimension::FlowRate && state.units[*i].counts_turns())
    };
    let groups = match dimension {
        Dimension::Pressure => vec![state.inlets(), state.outlets(), state.pressures()],
        _ => vec![state.inflows(), state.flows()],
    };
    let all: Vec<usize> = (0..state.facts.told.len()).filter(recorded).collect();
    let singles = all
        .iter()
        .filter(|i| state.units[**i].dimension == dimension);
    let mut groups: Vec<Vec<usize>> = singles
        .map(|i| vec![*i])
        .chain(groups)
        .map(|group| group.into_iter().filter(recorded).collect())
        .collect();
    groups.retain(|group: &Vec<usize>| !group.is_empty());
    groups.dedup();
    let in_use = all.iter().map(|i| state.units[*i]);
    let distinct = readings(dimension, in_use);
    let mut causes = Vec::new();
    for group in groups {
        for unit in &distinct {
            let other = |i: &usize| state.units[*i].factor != unit.factor;
            let told: Vec<usize> = group.iter().copied().filter(other).collect();
            let cause = Cause::Unit(told, *unit);
            if group.iter().any(other) && !causes.contains(&cause) {
                causes.push(cause);
            }
        }
    }
    causes
}

/// Units that a channel of a dimension may be in, those `in_use` first.
pub(super) fn readings(dimension: Dimension, in_use: impl Iterator<Item = Unit>) -> Vec<Unit> {
    let others = match dimension {
        Dimension::Pressure => &PRESSURES[..],
        _ => &FLOWS[..],
    };
    let others = others.iter().filter_map(|u| Unit::parse(u).ok());
    let mut distinct: Vec<Unit> = Vec::new();
    for unit in in_use.filter(|u| u.dimension == dimension).chain(others) {
        // `bar` and `bara` are one reading; gauge and absolute are told apart elsewhere.
        if distinct.iter().all(|d| d.factor != unit.factor) {
            distinct.push(unit);
        }
    }
    distinct
}

/// Every mistake that could be behind the faults.
fn causes(state: &State<'_>, found: &[Fault]) -> Vec<Cause> {
    let told = &state.facts.told;
    let recorded = |i: &usize| told[*i].tag.is_some();
    let any = |f: fn(&Check) -> bool| found.iter().any(|fault| f(&fault.check));
    let mut causes = Vec::new();
    let all: Vec<usize> = (0..told.len()).filter(recorded).collect();
    for dimension in [Dimension::Pressure, Dimension::FlowRate] {
        causes.extend(units(state, dimension, &recorded));
    }
    // A riser transmitter that is off by some metres of mud is no flow.
    let far_off = |fault: &&Fault| !matches!(fault.check, Check::Riser(_));
    let far_off = |i: usize| (found.iter().filter(far_off)).any(|f| concerns(state, f, i));
    let alike = |a: usize, b: usize| state.units[a].dimension == state.units[b].dimension;
    for (n, a) in all.iter().enumerate() {
        let others = all[n + 1..].iter();
        let others = others.filter(|b| alike(*a, **b) || far_off(*a) || far_off(**b));
        causes.extend(others.map(|b| Cause::Swap(vec![(*a, *b)])));
    }
    let (inlets, outlets) = (state.inlets(), state.outlets());
    if inlets.len() > 1 && inlets.len() == outlets.len() {
        causes.push(Cause::Swap(inlets.into_iter().zip(outlets).collect()));
    }
    if any(|c| matches!(c, Check::Column(_) | Check::Apart)) {
        for which in [Depth::All, Depth::Inlet, Depth::Outlet] {
            causes.extend(DEPTHS.map(|(factor, words)| Cause::Depths(which, factor, words)));
        }
    }
    if any(|c| matches!(c, Check::Column(_) | Check::Density)) {
        causes.extend(DENSITIES.map(|(factor, words)| Cause::Density(factor, words)));
    }
    if any(|c| matches!(c, Check::Friction)) {
        causes.extend(DIAMETERS.map(|(factor, words)| Cause::Line(factor, words)));
    }
    if any(|c| matches!(c, Check::Moves)) {
        for (factor, words) in DIAMETERS {
            causes.extend(
                [(true, true), (true, false), (false, true)]
                    .map(|(riser, pipe)| Cause::Riser(riser, pipe, factor, words)),
            );
        }
    }
    if any(|c| matches!(c, Check::Moves | Check::Step)) {
        let clocks = CLOCKS.iter().filter_map(|u| Unit::parse(u).ok());
        let clocks = clocks.filter(|unit| unit.factor != state.facts.clock.factor);
        causes.extend(clocks.map(|u| Cause::Clock(u, u.factor / state.facts.clock.factor)));
    }
    if any(|c| matches!(c, Check::Speed)) {
        causes.extend(state.facts.find(Channel::PumpSpeed).map(Cause::Share));
    }
    causes
}
