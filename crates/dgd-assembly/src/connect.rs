//! From connections to nodes and chains.

use crate::build::{Slots, listed};
use crate::error::Problem;
use crate::network::{Chain, Flow, Location, Member, Node, NodeKind, Part};
use crate::spec::{Kind, System};
use std::collections::BTreeMap;

/// Port of a part: number of the part (`usize::MAX` for the atmosphere) and of its port.
pub(crate) type Port = (usize, usize);
const ATMOSPHERE: usize = usize::MAX;
pub(crate) const INLET: usize = 0;
pub(crate) const OUTLET: usize = 1;

/// Ports that are joined share a class.
#[derive(Default)]
pub(crate) struct Classes {
    index: BTreeMap<Port, usize>,
    parent: Vec<usize>,
}

impl Classes {
    fn of(&mut self, port: Port) -> usize {
        let next = self.parent.len();
        let index = *self.index.entry(port).or_insert(next);
        if index == next {
            self.parent.push(next);
        }
        self.root(index)
    }

    fn root(&self, mut index: usize) -> usize {
        while self.parent[index] != index {
            index = self.parent[index];
        }
        index
    }

    fn join(&mut self, a: Port, b: Port) {
        let (a, b) = (self.of(a), self.of(b));
        self.parent[b.max(a)] = a.min(b);
    }
}

/// What meets in one point.
#[derive(Debug, Default, Clone)]
pub(crate) struct Junction {
    pub name: String,
    /// What sets the pressure; more than one is a contradiction.
    pub bearers: Vec<NodeKind>,
    pub bearer_names: Vec<String>,
    pub sources: Vec<usize>,
    /// Components of the kind `junction`.
    pub named: Vec<usize>,
    /// Branch and which of its ends.
    pub ends: Vec<Port>,
}

/// The connections as a graph of junctions.
#[derive(Debug, Default)]
pub(crate) struct Graph {
    pub junctions: Vec<Junction>,
    /// Junction of each port.
    pub of_port: BTreeMap<Port, usize>,
}

/// Joins the ports as the connections say and collects what meets where.
pub(crate) fn meet(
    system: &System,
    slots: &Slots,
    tanks: &[usize],
    volumes: &[usize],
    problems: &mut Vec<Problem>,
) -> Graph {
    let mut classes = Classes::default();
    for (i, part) in slots.parts.iter().enumerate() {
        if part.kind.is_branch() {
            classes.of((i, INLET));
            classes.of((i, OUTLET));
        } else if matches!(part.kind, Kind::Volume | Kind::Boundary | Kind::Junction) {
            classes.of((i, 0));
        }
    }
    for (index, connection) in system.connections.iter().enumerate() {
        let path = format!("connections[{index}]");
        let names: Vec<&str> = connection.split("->").map(str::trim).collect();
        if names.len() < 2 {
            problems.push(Problem::new(
                &path,
                format!("`{connection}` connects nothing"),
                "write `\"a -> b\"` in the direction of flow",
            ));
        }
        for pair in names.windows(2) {
            let from = find_port(slots, &path, pair[0], OUTLET, problems);
            let to = find_port(slots, &path, pair[1], INLET, problems);
            if let (Some(from), Some(to)) = (from, to) {
                classes.join(from, to);
            }
        }
    }
    let mut graph = Graph::default();
    let mut of_root: BTreeMap<usize, usize> = BTreeMap::new();
    for (&port, &index) in &classes.index {
        let root = classes.root(index);
        let junction = *of_root.entry(root).or_insert_with(|| {
            graph.junctions.push(Junction::default());
            graph.junctions.len() - 1
        });
        graph.of_port.insert(port, junction);
        let m = &mut graph.junctions[junction];
        let (i, end) = port;
        if i == ATMOSPHERE {
            m.bearers.push(NodeKind::Atmosphere);
            m.bearer_names.push("atmosphere".into());
            continue;
        }
        let part = &slots.parts[i];
        match part.kind {
            Kind::Tank => {
                let tank = tanks.iter().position(|&t| t == i).unwrap_or_default();
                let (name, height) = &part.ports[end];
                m.bearers.push(NodeKind::Port {
                    tank,
                    height: *height,
                });
                m.bearer_names.push(format!("{}.{name}", part.name));
            }
            Kind::Volume => {
                let volume = volumes.iter().position(|&v| v == i).unwrap_or_default();
                m.bearers.push(NodeKind::Volume(volume));
                m.bearer_names.push(part.name.clone());
            }
            Kind::Boundary if part.gives_flow => m.sources.push(i),
            Kind::Boundary => {
                m.bearers.push(NodeKind::Boundary(i));
                m.bearer_names.push(part.name.clone());
            }
            Kind::Junction => m.named.push(i),
            _ => m.ends.push(port),
        }
    }
    for m in &mut graph.junctions {
        m.name = name(&slots.parts, m);
    }
    graph
}

fn name(parts: &[Part], m: &Junction) -> String {
    if let Some(name) = m.bearer_names.first() {
        return name.clone();
    }
    if let Some(&junction) = m.named.first() {
        return parts[junction].name.clone();
    }
    let ends: Vec<String> = m
        .ends
        .iter()
        .map(|&p| port_name(parts, p))
        .chain(m.sources.iter().map(|&s| parts[s].name.clone()))
        .collect();
    ends.join("/")
}

pub(crate) fn port_name(parts: &[Part], (part, end): Port) -> String {
    let side = if end == INLET { "inlet" } else { "outlet" };
    format!("{}.{side}", parts[part].name)
}

/// `name` or `name.port`; `default` is the end that a branch offers on this side of an arrow.
pub(crate) fn find_port(
    slots: &Slots,
    path: &str,
    text: &str,
    default: usize,
    problems: &mut Vec<Problem>,
) -> Option<Port> {
    let (name, port) = text
        .split_once('.')
        .map_or((text, None), |(n, p)| (n, Some(p)));
    if name == "atmosphere" && port.is_none() {
        return Some((ATMOSPHERE, 0));
    }
    let Some(i) = slots.part(name) else {
        problems.push(Problem::new(
            path,
            format!("there is no component `{name}`"),
            slots.carriers(name, &["atmosphere"]),
        ));
        return None;
    };
    let part = &slots.parts[i];
    let refuse = |ports: &str, problems: &mut Vec<Problem>| {
        problems.push(Problem::new(
            path,
            format!("`{name}` has no port `{}`", port.unwrap_or_default()),
            format!("ports: {ports}"),
        ));
        None
    };
    match part.kind {
        Kind::Instrument => {
            problems.push(Problem::new(
                path,
                format!("`{name}` is an instrument and carries no flow"),
                "say what it measures by `of = ..`",
            ));
            None
        }
        Kind::Tank => {
            let wanted = port.unwrap_or(if default == OUTLET { "outlet" } else { "inlet" });
            match part.ports.iter().position(|(n, _)| n == wanted) {
                Some(p) => Some((i, p)),
                None => refuse(
                    &listed(part.ports.iter().map(|(n, _)| n.as_str())),
                    problems,
                ),
            }
        }
        kind if kind.is_branch() => match port {
            None => Some((i, default)),
            Some("inlet") => Some((i, INLET)),
            Some("outlet") => Some((i, OUTLET)),
            Some(_) => refuse("inlet, outlet", problems),
        },
        _ if port.is_some() => refuse("none; write the name alone", problems),
        _ => Some((i, 0)),
    }
}

/// Nodes, chains, and where each junction went.
pub(crate) struct Chained {
    pub nodes: Vec<Node>,
    pub chains: Vec<Chain>,
    pub location: Vec<Option<Location>>,
}

/// Joins branches in series to chains between nodes.
pub(crate) fn chain(graph: &Graph, slots: &Slots, problems: &mut Vec<Problem>) -> Chained {
    let inner: Vec<bool> = graph
        .junctions
        .iter()
        .map(|m| m.bearers.is_empty() && m.sources.is_empty() && m.ends.len() == 2)
        .collect();
    let mut location = vec![None; graph.junctions.len()];
    let mut nodes = Vec::new();
    for (i, m) in graph.junctions.iter().enumerate() {
        if inner[i] {
            continue;
        }
        location[i] = Some(Location::Node(nodes.len()));
        nodes.push(Node {
            kind: m.bearers.first().copied().unwrap_or(NodeKind::Free),
            name: m.name.clone(),
            sources: m.sources.clone(),
            chains: Vec::new(),
        });
    }
    let mut chains: Vec<Chain> = Vec::new();
    let mut done = vec![false; slots.parts.len()];
    for (i, m) in graph.junctions.iter().enumerate() {
        let Some(Location::Node(from)) = location[i].filter(|_| !inner[i]) else {
            continue;
        };
        for &(first, end) in &m.ends {
            if done[first] {
                continue;
            }
            // A chain runs from the inlet of its first member where it can, so start at inlets.
            let (mut part, mut at) = (first, end);
            let mut members = Vec::new();
            let mut passed = Vec::new();
            let to = loop {
                done[part] = true;
                members.push(Member {
                    part,
                    sign: if at == INLET { 1.0 } else { -1.0 },
                });
                let far = (part, 1 - at);
                let junction = graph.of_port[&far];
                if !inner[junction] {
                    break junction;
                }
                passed.push(junction);
                let next = graph.junctions[junction].ends.iter().find(|&&e| e != far);
                match next {
                    Some(&(p, e)) if !done[p] => (part, at) = (p, e),
                    _ => break junction,
                }
            };
            let Some(Location::Node(to)) = location[to].filter(|_| !inner[to]) else {
                continue;
            };
            // As a check valve lets flow pass; without one, as most members point.
            let one_way = members.iter().find(|m| slots.parts[m.part].check_valve);
            let backwards = one_way.map_or_else(
                || members.iter().filter(|m| m.sign < 0.0).count() * 2 > members.len(),
                |m| m.sign < 0.0,
            );
            let (mut from, mut to) = (from, to);
            if backwards {
                members.reverse();
                passed.reverse();
                members.iter_mut().for_each(|m| m.sign = -m.sign);
                std::mem::swap(&mut from, &mut to);
            }
            let chain = chains.len();
            for (k, junction) in passed.into_iter().enumerate() {
                location[junction] = Some(Location::Inside {
                    chain,
                    members: k + 1,
                });
            }
            nodes[from].chains.push((chain, -1.0));
            nodes[to].chains.push((chain, 1.0));
            chains.push(Chain {
                from,
                to,
                members,
                flow: Flow::Algebraic,
                slipping: None,
                check_valve: false,
                plain_valve: false,
                leaves_other: false,
            });
        }
    }
    for (i, part) in slots.parts.iter().enumerate() {
        if part.kind.is_branch() && !done[i] {
            problems.push(Problem::new(
                &part.name,
                "lies in a closed loop without any pressure",
                "connect a tank, volume, boundary or `atmosphere` to the loop",
            ));
        }
    }
    Chained {
        nodes,
        chains,
        location,
    }
}
