//! The states and how they start.

use crate::build::listed;
use crate::error::Problem;
use crate::kinds;
use crate::network::{Chain, Location, Network, NodeKind, Reading, Start, StateInfo};
use crate::spec::{Bounds, Initial, Kind, System};
use dgd_units::{Dimension, Unit, UnitError};

pub(super) fn states(system: &System, net: &mut Network, problems: &mut Vec<Problem>) {
    let mut used: Vec<String> = Vec::new();
    let mut list: Vec<StateInfo> = Vec::new();
    for (number, &part) in net.tanks.iter().enumerate() {
        let path = format!("{}.level", net.parts[part].name);
        let meter = net
            .meters
            .iter()
            .position(|m| m.reading == Reading::Level(number));
        let start = start(system, net, &path, Dimension::Length, &mut used, problems)
            .or(meter.map(Start::Measured));
        problems.extend(start.and_then(|start| above_brim(net, part, start, &path)));
        let size = net.parts[part].scale.level_m;
        list.push(StateInfo {
            start: needed(start, &path, problems),
            path,
            size,
        });
    }
    for (number, &part) in net.volumes.iter().enumerate() {
        let path = format!("{}.pressure", net.parts[part].name);
        let meter = net.meters.iter().position(|m| matches!(m.reading, Reading::Pressure(Location::Node(n)) if net.nodes[n].kind == NodeKind::Volume(number)));
        let start = start(system, net, &path, Dimension::Pressure, &mut used, problems)
            .or(meter.map(Start::Measured));
        let size = net.parts[part].scale.pressure_pa;
        list.push(StateInfo {
            start: needed(start, &path, problems),
            path,
            size,
        });
    }
    for &chain in &net.inertial {
        let Chain { members, .. } = &net.chains[chain];
        let mut found = None;
        let mut name = String::new();
        for member in members {
            let part = &net.parts[member.part];
            let path = format!("{}.flow", part.name);
            // The state is the chain's flow: of a member that lies the other way it is the opposite.
            let along = member.sign > 0.0;
            if name.is_empty() && part.kind == Kind::Line && along {
                name.clone_from(&path);
            }
            if let Some(start) = start(system, net, &path, Dimension::FlowRate, &mut used, problems)
            {
                found = Some(if along { start } else { opposite(start) });
                if along {
                    name = path;
                }
            }
        }
        if name.is_empty() {
            let at = members.iter().position(|m| m.sign > 0.0).unwrap_or(0);
            name = format!("{}.flow", net.parts[members[at].part].name);
        }
        let size = net.parts[members[0].part].scale.flow_m3_s;
        list.push(StateInfo {
            path: name,
            start: found.unwrap_or(Start::Steady),
            size,
        });
    }
    for attached in &mut net.effects {
        let count = attached.effect.states();
        attached.states = list.len()..list.len() + count;
        let part = &net.parts[attached.part];
        for k in 0..count {
            list.push(StateInfo {
                path: format!("{}.{}.x{k}", part.name, attached.effect.about().id),
                start: Start::Effect,
                size: 1.0,
            });
        }
    }
    for path in system.initial.keys().filter(|p| !used.contains(p)) {
        let known = listed(list.iter().map(|s| s.path.as_str()));
        problems.push(Problem::new(
            path,
            "in [initial] is not a state",
            format!("states: {known}; a path is quoted, \"tank.level\""),
        ));
    }
    net.states = list;
}

/// Why a level cannot start there: above a brim that is known.
fn above_brim(net: &Network, tank: usize, start: Start, path: &str) -> Option<Problem> {
    let slot = net.parts[tank].base + kinds::tank::BRIM;
    let open = net.free.iter().any(|f| f.slot == slot) || net.driven.iter().any(|d| d.slot == slot);
    let brim_m = net.values[slot];
    let level_m = match start {
        Start::Given(level_m) => level_m,
        Start::Free(bounds) => bounds.start,
        _ => return None,
    };
    (!open && level_m > brim_m).then(|| {
        Problem::new(
            path,
            format!("starts at {level_m} m, above the brim at {brim_m} m"),
            "levels and brims are heights above the tank's floor",
        )
    })
}

/// The start of a flow that is counted the other way; of a meter that is settled where it is read.
fn opposite(start: Start) -> Start {
    match start {
        Start::Given(flow) => Start::Given(-flow),
        Start::Free(bounds) => Start::Free(Bounds {
            start: -bounds.start,
            low: -bounds.high,
            high: -bounds.low,
        }),
        other => other,
    }
}

fn needed(start: Option<Start>, path: &str, problems: &mut Vec<Problem>) -> Start {
    start.unwrap_or_else(|| {
        problems.push(Problem::new(path, "has no start", "add it to [initial] as a number, `{ measured = \"instrument\" }` or `{ start = .., low = .., high = .. }`"));
        Start::Steady
    })
}

/// A value written with its unit, in SI.
pub(super) fn written(text: &str, dimension: Dimension) -> Result<f64, UnitError> {
    let (value, unit) = dgd_units::split_number(text)?;
    Ok(Unit::parse_as(unit, dimension)?.to_si(value))
}

fn start(
    system: &System,
    net: &Network,
    path: &str,
    dimension: Dimension,
    used: &mut Vec<String>,
    problems: &mut Vec<Problem>,
) -> Option<Start> {
    let initial = system.initial.get(path)?;
    used.push(path.to_owned());
    match initial {
        Initial::Given(value) => Some(Start::Given(*value)),
        Initial::Written(text) => match written(text, dimension) {
            Ok(value) => Some(Start::Given(value)),
            Err(error) => {
                problems.push(Problem::new(path, error.to_string(), ""));
                None
            }
        },
        Initial::Measured(m) => {
            let meter = net.meters.iter().position(|k| k.name == m.measured);
            if meter.is_none() {
                let known = listed(net.meters.iter().map(|m| m.name.as_str()));
                problems.push(Problem::new(
                    path,
                    format!("there is no instrument `{}`", m.measured),
                    format!("instruments: {known}"),
                ));
            }
            let reading = meter.map(|meter| &net.meters[meter].reading);
            if let Some(measured) = reading.map(|reading| reading.dimension())
                && measured != Some(dimension)
            {
                let what = measured.map_or("no quantity of a state".to_owned(), |measured| {
                    format!("what is in {}", measured.si_symbol())
                });
                problems.push(Problem::new(
                    path,
                    format!(
                        "is in {}, but `{}` measures {what}",
                        dimension.si_symbol(),
                        m.measured
                    ),
                    "an instrument that measures the state itself, or a value",
                ));
            }
            let meter = meter.unwrap_or_default();
            Some(match m.within {
                None => Start::Measured(meter),
                Some(within) => Start::Near(
                    meter,
                    Bounds {
                        start: 0.0,
                        low: -within,
                        high: within,
                    },
                ),
            })
        }
        Initial::Free(bounds) => {
            if !(bounds.low < bounds.high
                && bounds.start >= bounds.low
                && bounds.start <= bounds.high
                && bounds.low.is_finite()
                && bounds.high.is_finite())
            {
                problems.push(Problem::new(path, format!("has start {}, low {}, high {}, expected finite low <= start <= high, low < high", bounds.start, bounds.low, bounds.high), ""));
            }
            Some(Start::Free(*bounds))
        }
    }
}
