//! From slots and chains to the compiled network.

mod meters;
mod plan;
mod sizes;
mod states;

use crate::build::{self, Slots};
use crate::connect::{self, Chained, Graph, INLET, OUTLET};
use crate::error::{AssemblyError, Problem};
use crate::kinds;
use crate::network::{Location, Network};
use crate::spec::{Kind, System};
use crate::structure;
use dgd_units::{Dimension, Unit};
pub(crate) use sizes::shown_sizes;

pub(crate) fn compile(system: &System) -> Result<Network, AssemblyError> {
    let mut slots = build::read(system);
    let mut problems = std::mem::take(&mut slots.problems);
    let of_kind = |kind: Kind| {
        (0..slots.parts.len())
            .filter(|&i| slots.parts[i].kind == kind)
            .collect::<Vec<_>>()
    };
    let (tanks, volumes) = (of_kind(Kind::Tank), of_kind(Kind::Volume));
    boundaries(&slots, &mut problems);
    let graph = connect::meet(system, &slots, &tanks, &volumes, &mut problems);
    // Contradictions among names would be told again as loose ends.
    if !problems.is_empty() {
        return Err(AssemblyError::ill(problems));
    }
    structure::check(&graph, &slots, &mut problems);
    if !problems.is_empty() {
        return Err(AssemblyError::ill(problems));
    }
    let Chained {
        nodes,
        chains,
        location,
    } = connect::chain(&graph, &slots, &mut problems);
    let mut net = Network {
        ends: ends(&slots, &graph, &location),
        seat: vec![None; slots.parts.len()],
        parts: slots.parts.clone(),
        effects: slots.effects.clone(),
        below: vec![None; tanks.len()],
        tank_order: Vec::new(),
        tanks,
        volumes,
        nodes,
        chains,
        inertial: Vec::new(),
        plan: Vec::new(),
        islands: Vec::new(),
        states: Vec::new(),
        meters: Vec::new(),
        driven: slots.driven.clone(),
        free: slots.free.clone(),
        values: slots.values.clone(),
        hooked: Vec::new(),
        valves: Vec::new(),
        in_time: system.independent == "time",
        tick: 1.0,
    };
    for (c, chain) in net.chains.iter().enumerate() {
        for (k, member) in chain.members.iter().enumerate() {
            net.seat[member.part] = Some((c, k));
        }
    }
    tick(system, &mut net, &mut problems);
    plan::cascade(&mut net);
    plan::flows(&mut net, &mut problems);
    plan::plan(&mut net, &mut problems);
    if problems.is_empty() {
        meters::meters(system, &slots, &mut net, &mut problems);
        sizes::sizes(system, &mut net, &mut problems);
        states::states(system, &mut net, &mut problems);
    }
    if problems.is_empty() {
        Ok(net)
    } else {
        Err(AssemblyError::ill(problems))
    }
}

/// In what the record counts its independent variable.
fn tick(system: &System, net: &mut Network, problems: &mut Vec<Problem>) {
    if let Some(step) = system.record.step
        && !(step.is_finite() && step > 0.0)
    {
        problems.push(Problem::new(
            "record.step",
            format!("is {step}, expected a number above 0"),
            "how far apart the samples are, in `unit`",
        ));
    }
    let Some(unit) = system.record.unit.as_deref().filter(|_| net.in_time) else {
        return;
    };
    match Unit::parse(unit) {
        Ok(found) if found.dimension == Dimension::Time => net.tick = found.factor,
        Ok(_) => problems.push(Problem::new(
            "record.unit",
            format!("`{unit}` is not a unit of time"),
            "s, ms, min, h or d; or name the independent variable: `independent = \"depth\"`",
        )),
        Err(error) => problems.push(Problem::new("record.unit", error.to_string(), "")),
    }
}

fn boundaries(slots: &Slots, problems: &mut Vec<Problem>) {
    for part in slots.parts.iter().filter(|p| p.kind == Kind::Boundary) {
        let fed = |slot: usize| {
            slots.values[slot].is_finite() || slots.driven.iter().any(|d| d.slot == slot)
        };
        let pressure = fed(part.base + kinds::boundary::PRESSURE);
        let flow = fed(part.base + kinds::boundary::FLOW);
        if pressure == flow {
            let message = if flow {
                "gives pressure and flow"
            } else {
                "gives neither pressure nor flow"
            };
            problems.push(Problem::new(
                &part.name,
                message,
                "give one of them, as a property, in [free] or in [inputs]",
            ));
        }
    }
}

fn ends(slots: &Slots, graph: &Graph, location: &[Option<Location>]) -> Vec<[Option<Location>; 2]> {
    let at = |port| graph.of_port.get(&port).and_then(|&m| location[m]);
    (0..slots.parts.len())
        .map(|i| {
            let kind = slots.parts[i].kind;
            if kind.is_branch() {
                [at((i, INLET)), at((i, OUTLET))]
            } else {
                [at((i, 0)), at((i, 0))]
            }
        })
        .collect()
}
