//! How each chain's flow is found, and in which order the algebraic unknowns are solved.

use crate::build::listed;
use crate::error::Problem;
use crate::network::{Flow, Island, Network, NodeKind, Step};
use crate::spec::Kind;

/// Which tank lies below which.
pub(super) fn cascade(net: &mut Network) {
    for chain in &net.chains {
        if let (NodeKind::Port { tank: upper, .. }, NodeKind::Port { tank: lower, .. }) =
            (net.nodes[chain.from].kind, net.nodes[chain.to].kind)
            && upper != lower
            && net.below[upper].is_none()
        {
            net.below[upper] = Some(lower);
        }
    }
    let n = net.tanks.len();
    // Distance to the end of the cascade; a ring is cut where it is longer than there are tanks.
    let depth = |mut tank: usize| {
        let mut steps = 0;
        while let Some(lower) = net.below[tank]
            && steps < n
        {
            (tank, steps) = (lower, steps + 1);
        }
        steps
    };
    let mut order: Vec<usize> = (0..n).collect();
    order.sort_by_key(|&t| std::cmp::Reverse(depth(t)));
    net.tank_order = order;
}

/// How each chain's flow is found.
pub(super) fn flows(net: &mut Network, problems: &mut Vec<Problem>) {
    let mut inertial = 0;
    for c in 0..net.chains.len() {
        let chain = &net.chains[c];
        let part = |k: usize| &net.parts[chain.members[k].part];
        let effects = |k: usize| net.effects_of(chain.members[k].part);
        let all = 0..chain.members.len();
        let pump = all
            .clone()
            .find(|&k| part(k).kind == Kind::DisplacementPump);
        let slipping = pump.filter(|&k| effects(k).iter().any(|a| a.effect.has_delivery()));
        let heavy = all
            .clone()
            .find(|&k| part(k).inertia || effects(k).iter().any(|a| a.effect.gives_inertia()));
        if let (Some(pump), Some(line)) = (pump, heavy) {
            let (pump, line) = (&part(pump).name, &part(line).name);
            problems.push(Problem::new(
                line,
                format!("has inertia, but `{pump}` sets its flow"),
                "set `inertia = false`, or put a volume between them",
            ));
            continue;
        }
        if heavy.is_some() && !net.in_time {
            problems.push(Problem::new(
                &part(heavy.unwrap_or_default()).name,
                "has inertia in a relation without time",
                "set `inertia = false`",
            ));
        }
        let plain = chain.members.len() == 1
            && matches!(part(0).kind, Kind::Valve | Kind::Orifice)
            && effects(0).is_empty();
        let check = all.clone().any(|k| part(k).check_valve);
        let last = chain.members.len() - 1;
        let leaves = !effects(last).is_empty() && chain.members[last].sign > 0.0;
        let chain = &mut net.chains[c];
        chain.flow = match (pump, heavy) {
            (Some(k), _) if slipping.is_none() => Flow::Prescribed(k),
            (None, Some(_)) => {
                inertial += 1;
                net.inertial.push(c);
                Flow::State(net.tanks.len() + net.volumes.len() + inertial - 1)
            }
            _ => Flow::Algebraic,
        };
        chain.slipping = slipping;
        chain.plain_valve = plain;
        chain.check_valve = check;
        chain.leaves_other = leaves;
        if check && heavy.is_some() {
            net.valves.push(c);
        }
    }
    if !net.in_time && net.tanks.len() + net.volumes.len() > 0 {
        let name = net
            .tanks
            .iter()
            .chain(&net.volumes)
            .map(|&p| net.parts[p].name.as_str());
        problems.push(Problem::new(
            "independent",
            format!("is no time, but {} would fill in time", listed(name)),
            "use boundaries instead",
        ));
    }
}

/// In which order the algebraic unknowns are solved.
pub(super) fn plan(net: &mut Network, problems: &mut Vec<Problem>) {
    let free = |net: &Network, n: usize| net.nodes[n].kind == NodeKind::Free;
    let mut known: Vec<bool> = net
        .chains
        .iter()
        .map(|c| matches!(c.flow, Flow::State(_) | Flow::Prescribed(_)))
        .collect();
    for c in 0..net.chains.len() {
        if !known[c] && !free(net, net.chains[c].from) && !free(net, net.chains[c].to) {
            net.plan.push(Step::Direct(c));
            known[c] = true;
        }
    }
    let mut settled: Vec<bool> = (0..net.nodes.len()).map(|n| !free(net, n)).collect();
    let mut backwards = Vec::new();
    loop {
        let next = (0..net.nodes.len()).filter(|&n| !settled[n]).find_map(|n| {
            let mut unknown = net.nodes[n].chains.iter().filter(|(c, _)| !known[*c]);
            match (unknown.next(), unknown.next()) {
                (Some(&(chain, sign)), None) => Some((n, chain, sign)),
                _ => None,
            }
        });
        let Some((node, chain, sign)) = next else {
            break;
        };
        if net.chains[chain].slipping.is_some() || net.chains[chain].from == net.chains[chain].to {
            let name = &net.parts[net.chains[chain].members[0].part].name;
            problems.push(Problem::new(
                name,
                format!(
                    "is forced to a flow by the mass balance at {}",
                    net.nodes[node].name
                ),
                "put a volume there",
            ));
            return;
        }
        net.plan.push(Step::Forced { node, chain, sign });
        net.chains[chain].flow = Flow::Forced;
        backwards.push(Step::Pressure { node, chain });
        (known[chain], settled[node]) = (true, true);
    }
    // What is left hangs together in islands.
    let mut island_of: Vec<Option<usize>> = vec![None; net.nodes.len()];
    for n in 0..net.nodes.len() {
        if settled[n] || island_of[n].is_some() {
            continue;
        }
        let mut island = Island::default();
        let mut stack = vec![n];
        while let Some(n) = stack.pop() {
            if island_of[n].replace(net.islands.len()).is_some() {
                continue;
            }
            island.nodes.push(n);
            for &(c, _) in net.nodes[n].chains.iter().filter(|(c, _)| !known[*c]) {
                if !island.chains.contains(&c) {
                    island.chains.push(c);
                }
                for m in [net.chains[c].from, net.chains[c].to] {
                    if !settled[m] && island_of[m].is_none() {
                        stack.push(m);
                    }
                }
            }
        }
        if island.chains.is_empty() {
            let lines: Vec<&str> = net.nodes[n]
                .chains
                .iter()
                .map(|&(c, _)| net.parts[net.chains[c].members[0].part].name.as_str())
                .collect();
            let message = format!(
                "mass balance in excess: the flows of {} are all given, and nothing determines the pressure",
                lines.join(", ")
            );
            problems.push(Problem::new(
                &net.nodes[n].name,
                message,
                "put a volume there, or set `inertia = false` in one of the lines",
            ));
        }
        net.plan.push(Step::Island(net.islands.len()));
        net.islands.push(island);
    }
    net.plan.extend(backwards.into_iter().rev());
}
