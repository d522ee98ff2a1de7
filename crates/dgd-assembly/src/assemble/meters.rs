//! What the instruments read.

use crate::build::Slots;
use crate::connect::{OUTLET, find_port};
use crate::error::Problem;
use crate::network::{Location, Meter, Network, NodeKind, Reading};
use crate::spec::{Component, Kind, Setting, System};
use dgd_units::{Dimension, Unit};

pub(super) fn meters(
    system: &System,
    slots: &Slots,
    net: &mut Network,
    problems: &mut Vec<Problem>,
) {
    for (i, part) in slots
        .parts
        .iter()
        .enumerate()
        .filter(|(_, p)| p.kind == Kind::Instrument)
    {
        let Some(component) = system.components.get(&part.name) else {
            continue;
        };
        let name = &part.name;
        let (Some(measures), Some(of)) = (text(component, "measures"), text(component, "of"))
        else {
            problems.push(Problem::new(
                name,
                "measures nothing",
                "add `measures = \"level\"` and `of = \"tank\"`",
            ));
            continue;
        };
        let before = problems.len();
        let reading = reading(slots, net, measures, of, &format!("{name}.of"), problems);
        let Some(reading) = reading else {
            if problems.len() == before {
                problems.push(Problem::new(format!("{name}.measures"), format!("`{measures}` of `{of}` is not measurable"), "level of a tank; pressure at a component or `line.outlet`; drop, flow of a branch; head, speed of a pump"));
            }
            continue;
        };
        let parse = |written: &str| match dimension(measures) {
            // Of the same dimension is what an error suggests.
            Some(expected) => Unit::parse(written).or_else(|_| Unit::parse_as(written, expected)),
            None => Unit::parse(written),
        };
        let unit = match text(component, "unit").map(parse).transpose() {
            Ok(unit) => {
                let gain = format!("{name}.gain");
                let own = component.settings.contains_key("gain")
                    || system.free.contains_key(&gain)
                    || system.inputs.contains_key(&gain);
                if let (Some(unit), Some(expected)) = (unit, dimension(measures))
                    && !own
                    && unit.dimension != Dimension::Number
                    && unit.dimension != expected
                {
                    problems.push(Problem::new(
                        format!("{name}.unit"),
                        format!(
                            "`{}` is not a unit of {measures}",
                            text(component, "unit").unwrap_or_default()
                        ),
                        format!(
                            "a unit such as {}; or a `gain`, for a reading with its own scale",
                            expected.si_symbol()
                        ),
                    ));
                }
                unit
            }
            Err(error) => {
                problems.push(Problem::new(format!("{name}.unit"), error.to_string(), ""));
                None
            }
        };
        net.meters.push(Meter {
            part: i,
            name: name.clone(),
            channel: text(component, "channel").unwrap_or(name).to_owned(),
            unit,
            reading,
        });
    }
}

/// Dimension of what is measured; none of a speed, which pumps take in units of their own.
fn dimension(measures: &str) -> Option<Dimension> {
    match measures {
        "level" | "head" => Some(Dimension::Length),
        "pressure" | "drop" => Some(Dimension::Pressure),
        "flow" => Some(Dimension::FlowRate),
        _ => None,
    }
}

fn reading(
    slots: &Slots,
    net: &Network,
    measures: &str,
    of: &str,
    path: &str,
    problems: &mut Vec<Problem>,
) -> Option<Reading> {
    let (name, port) = of.split_once('.').map_or((of, None), |(n, p)| (n, Some(p)));
    let Some(part) = slots.part(name) else {
        problems.push(Problem::new(
            path,
            format!("there is no component `{name}`"),
            slots.carriers(name, &[]),
        ));
        return None;
    };
    let kind = slots.parts[part].kind;
    let [inlet, outlet] = net.ends[part];
    match measures {
        "level" => net
            .tanks
            .iter()
            .position(|&t| t == part)
            .map(Reading::Level),
        "pressure" if kind == Kind::Tank => {
            let tank = net.tanks.iter().position(|&t| t == part)?;
            let (_, port) = find_port(slots, path, of, OUTLET, problems)?;
            let height = slots.parts[part].ports[port].1;
            let node = net
                .nodes
                .iter()
                .position(|n| n.kind == NodeKind::Port { tank, height })?;
            Some(Reading::Pressure(Location::Node(node)))
        }
        "pressure" if kind.is_branch() => match port {
            Some("inlet") => inlet.map(Reading::Pressure),
            Some("outlet") => outlet.map(Reading::Pressure),
            _ => None,
        },
        "pressure" => inlet.map(Reading::Pressure),
        "drop" if kind.is_branch() => Some(Reading::Drop {
            inlet: inlet?,
            outlet: outlet?,
        }),
        "head" if kind == Kind::CentrifugalPump || kind == Kind::DisplacementPump => {
            Some(Reading::Head {
                inlet: inlet?,
                outlet: outlet?,
            })
        }
        "flow" if kind == Kind::Boundary && slots.parts[part].gives_flow => {
            Some(Reading::Source(part))
        }
        "flow" => {
            let (chain, member) = net.seat[part]?;
            let sign = net.chains[chain].members[member].sign;
            let last = member + 1 == net.chains[chain].members.len() && sign > 0.0;
            if port == Some("outlet") && last {
                return Some(Reading::Leaving { chain });
            }
            Some(Reading::Flow { chain, sign })
        }
        "speed" => kind
            .drive()
            .map(|slot| Reading::Speed(slots.parts[part].base + slot)),
        _ => None,
    }
}

fn text<'a>(component: &'a Component, key: &str) -> Option<&'a str> {
    match component.settings.get(key) {
        Some(Setting::Text(text)) => Some(text),
        _ => None,
    }
}
