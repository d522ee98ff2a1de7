//! Which parameters and inputs can reach an output at all: reachability in the graph of influences.

use crate::assembly::Assembly;
use crate::error::Problem;
use crate::network::{Location, Network, NodeKind, Reading};
use std::collections::BTreeSet;

/// What can be influenced.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Place {
    Chain(usize),
    Node(usize),
    Tank(usize),
    Volume(usize),
}

/// Places that what happens at `place` acts on at once.
fn acts_on(net: &Network, place: Place) -> Vec<Place> {
    let mut next = Vec::new();
    match place {
        Place::Chain(c) => {
            for n in [net.chains[c].from, net.chains[c].to] {
                match net.nodes[n].kind {
                    NodeKind::Port { tank, .. } => next.push(Place::Tank(tank)),
                    NodeKind::Volume(v) => next.push(Place::Volume(v)),
                    NodeKind::Free => next.push(Place::Node(n)),
                    NodeKind::Boundary(_) | NodeKind::Atmosphere => {}
                }
            }
        }
        Place::Node(n) => next.extend(net.nodes[n].chains.iter().map(|&(c, _)| Place::Chain(c))),
        Place::Tank(k) => {
            for node in &net.nodes {
                let wet = matches!(node.kind, NodeKind::Port { tank, height } if tank == k && (height.is_some() || closed(net, k)));
                if wet {
                    next.extend(node.chains.iter().map(|&(c, _)| Place::Chain(c)));
                }
            }
            // What spills may be caught below.
            next.extend(net.below[k].map(Place::Tank));
        }
        Place::Volume(v) => {
            for node in net.nodes.iter().filter(|n| n.kind == NodeKind::Volume(v)) {
                next.extend(node.chains.iter().map(|&(c, _)| Place::Chain(c)));
            }
        }
    }
    next
}

fn closed(net: &Network, tank: usize) -> bool {
    net.values[net.parts[net.tanks[tank]].base + crate::kinds::tank::GAS_VOLUME].is_finite()
}

/// Where a part acts first.
fn seats(net: &Network, part: usize) -> Vec<Place> {
    if let Some((chain, _)) = net.seat[part] {
        return vec![Place::Chain(chain)];
    }
    if let Some(k) = net.tanks.iter().position(|&t| t == part) {
        return vec![Place::Tank(k)];
    }
    if let Some(v) = net.volumes.iter().position(|&t| t == part) {
        return vec![Place::Volume(v)];
    }
    let mut places = Vec::new();
    for (n, node) in net.nodes.iter().enumerate() {
        if node.sources.contains(&part) {
            match node.kind {
                NodeKind::Port { tank, .. } => places.push(Place::Tank(tank)),
                NodeKind::Volume(v) => places.push(Place::Volume(v)),
                _ => places.push(Place::Node(n)),
            }
        }
        if node.kind == NodeKind::Boundary(part) {
            places.extend(node.chains.iter().map(|&(c, _)| Place::Chain(c)));
        }
    }
    places
}

/// Where an instrument looks.
fn watched(net: &Network, reading: Reading) -> Vec<Place> {
    let of = |l: Location| match l {
        Location::Inside { chain, .. } => vec![Place::Chain(chain)],
        Location::Node(n) => match net.nodes[n].kind {
            NodeKind::Port { tank, .. } => vec![Place::Tank(tank)],
            NodeKind::Volume(v) => vec![Place::Volume(v)],
            NodeKind::Free => vec![Place::Node(n)],
            _ => Vec::new(),
        },
    };
    match reading {
        Reading::Level(tank) => vec![Place::Tank(tank)],
        Reading::Pressure(l) => of(l),
        Reading::Drop { inlet, outlet } | Reading::Head { inlet, outlet } => {
            [of(inlet), of(outlet)].concat()
        }
        Reading::Flow { chain, .. } | Reading::Leaving { chain } => vec![Place::Chain(chain)],
        Reading::Source(_) | Reading::Speed(_) => Vec::new(),
    }
}

/// Outputs (by number) that a part can act on.
pub(crate) fn outputs_of(net: &Network, part: usize) -> BTreeSet<usize> {
    let mut reached: BTreeSet<Place> = BTreeSet::new();
    let mut stack = seats(net, part);
    while let Some(place) = stack.pop() {
        if reached.insert(place) {
            stack.extend(acts_on(net, place));
        }
    }
    let own = |reading: Reading| match reading {
        Reading::Source(p) => p == part,
        Reading::Speed(slot) => {
            net.parts[part].base <= slot && slot < net.parts[part].base + net.parts[part].count
        }
        _ => false,
    };
    (0..net.meters.len())
        .filter(|&m| {
            let meter = &net.meters[m];
            meter.part == part
                || own(meter.reading)
                || watched(net, meter.reading)
                    .iter()
                    .any(|p| reached.contains(p))
        })
        .collect()
}

/// Part that a slot belongs to; none for the fluid.
fn part_of(net: &Network, slot: usize) -> Option<usize> {
    net.parts
        .iter()
        .position(|p| {
            p.base <= slot && slot < p.base + p.count
                || p.ports.iter().any(|(_, s)| *s == Some(slot))
        })
        .or_else(|| {
            net.effects
                .iter()
                .find(|a| a.base <= slot && slot < a.base + a.count)
                .map(|a| a.part)
        })
}

pub(crate) fn warnings(assembly: &Assembly) -> Vec<Problem> {
    let net = &assembly.net;
    let mut found = Vec::new();
    if net.meters.is_empty() {
        found.push(Problem::new(
            "components",
            "there is no instrument",
            "add one: nothing can be compared with a recording",
        ));
        return found;
    }
    for (path, slot) in net.free.iter().map(|f| (&f.path, f.slot)) {
        if part_of(net, slot).is_some_and(|part| outputs_of(net, part).is_empty()) {
            found.push(Problem::new(
                path,
                "no output depends on it",
                "measure what it acts on, or fix its value",
            ));
        }
    }
    for driven in &net.driven {
        if part_of(net, driven.slot).is_some_and(|part| outputs_of(net, part).is_empty()) {
            found.push(Problem::new(
                &driven.path,
                "this input reaches no output",
                "measure what it acts on, or remove it",
            ));
        }
    }
    for (k, &tank) in net.tanks.iter().enumerate() {
        let ports: Vec<usize> = (0..net.nodes.len())
            .filter(|&n| assembly.is_port(n, k))
            .collect();
        let fed = ports.iter().any(|&n| {
            !net.nodes[n].sources.is_empty() || net.nodes[n].chains.iter().any(|&(_, s)| s > 0.0)
        });
        let drained = ports
            .iter()
            .any(|&n| net.nodes[n].chains.iter().any(|&(_, s)| s < 0.0));
        let name = &net.parts[tank].name;
        match (fed, drained) {
            (false, false) => found.push(Problem::new(name, "neither filled nor drained", "")),
            (false, true) => found.push(Problem::new(
                name,
                "nothing fills it",
                "it can only run empty",
            )),
            _ => {}
        }
    }
    found
}
