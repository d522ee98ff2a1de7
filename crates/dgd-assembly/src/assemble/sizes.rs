//! Usual sizes, and the parameters of effects that were left open.

use super::states::written;
use crate::Dual;
use crate::build::number;
use crate::effect::Scale;
use crate::error::Problem;
use crate::kinds::{self, Property};
use crate::laws;
use crate::network::{Network, Reading};
use crate::record::Window;
use crate::spec::{Initial, Kind, System};
use dgd_units::{Dimension, Unit};

/// The usual flow, pressure and time that a record shows, under their names in `[scale]`, where it shows them: medians of what flows
/// and pressures are recorded, and twice the interval between samples.
pub(crate) fn shown_sizes(
    net: &Network,
    windows: &[Window],
    in_time: bool,
) -> Vec<(&'static str, f64)> {
    let inputs = (net.driven.iter().enumerate()).flat_map(|(i, driven)| {
        let of_windows = windows.iter().filter_map(move |w| w.inputs.get(i));
        of_windows.map(move |values| (driven.unit, values))
    });
    let readings = (net.meters.iter().enumerate()).flat_map(|(o, meter)| {
        let of_windows = windows.iter().filter_map(move |w| w.readings.get(o));
        of_windows.map(move |values| (meter.unit, values))
    });
    let recorded: Vec<(Option<Unit>, &Vec<f64>)> = inputs.chain(readings).collect();
    let usual = |dimension: Dimension| {
        let of_it = recorded
            .iter()
            .filter(|(unit, _)| unit.is_some_and(|u| u.dimension == dimension));
        median(of_it.flat_map(|(_, values)| values.iter().map(|v| v.abs())))
    };
    let interval = || {
        let steps = windows.iter().flat_map(|w| w.time.windows(2));
        median(steps.map(|pair| pair[1] - pair[0])).map(|step| 2.0 * step)
    };
    [
        ("flow", usual(Dimension::FlowRate)),
        ("pressure", usual(Dimension::Pressure)),
        ("time", in_time.then(interval).flatten()),
    ]
    .into_iter()
    .filter_map(|(name, size)| Some((name, size?)))
    .collect()
}

/// The middle of the values above 0, if there are any.
fn median(values: impl Iterator<Item = f64>) -> Option<f64> {
    let mut values: Vec<f64> = values.filter(|v| v.is_finite() && *v > 0.0).collect();
    let middle = values.len() / 2;
    if values.is_empty() {
        return None;
    }
    Some(*values.select_nth_unstable_by(middle, f64::total_cmp).1)
}

/// Usual sizes, and the parameters of effects that were left open.
pub(super) fn sizes(system: &System, net: &mut Network, problems: &mut Vec<Problem>) {
    let given = Given::read(system, problems);
    let usual = usual(system, net, &given);
    for i in 0..net.parts.len() {
        let level_m = if net.parts[i].kind == Kind::Tank {
            tank_level(system, net, &given, i)
        } else {
            usual.level_m
        };
        let meter = net.meters.iter().find(|m| m.part == i);
        let reading = meter.map_or(1.0, |m| {
            let size = match m.reading {
                Reading::Level(tank) => tank_level(system, net, &given, net.tanks[tank]),
                Reading::Pressure(_) | Reading::Drop { .. } => usual.pressure_pa,
                Reading::Head { .. } => usual.level_m,
                Reading::Flow { .. } | Reading::Leaving { .. } | Reading::Source(_) => {
                    usual.flow_m3_s
                }
                Reading::Speed(_) => 100.0,
            };
            let gain = net.values[net.parts[i].base + kinds::instrument::GAIN].abs();
            positive(Some(size * gain)).unwrap_or(1.0)
        });
        net.parts[i].scale = Scale {
            level_m,
            reading,
            ..usual
        };
    }
    neutral(net);
    hook(net);
}

/// Names in `[scale]`.
const SIZES: [(&str, Dimension); 4] = [
    ("level", Dimension::Length),
    ("flow", Dimension::FlowRate),
    ("pressure", Dimension::Pressure),
    ("time", Dimension::Time),
];

/// What `[scale]` says, where it does.
struct Given {
    level: Option<f64>,
    flow: Option<f64>,
    pressure: Option<f64>,
    time: Option<f64>,
}

impl Given {
    fn read(system: &System, problems: &mut Vec<Problem>) -> Self {
        let [level, flow, pressure, time] = SIZES.map(|(name, dimension)| {
            let property = Property {
                name,
                dimension: Some(dimension),
                unit: "SI",
                default: None,
                low: 0.0,
                high: f64::INFINITY,
                meaning: "",
            };
            let size = number(system.scale.get(name)?, &property).and_then(|size| {
                let positive = positive(Some(size));
                positive.ok_or_else(|| format!("is {size}, expected a positive number"))
            });
            size.map_err(|message| {
                problems.push(Problem::new(format!("scale.{name}"), message, ""));
            })
            .ok()
        });
        for key in system.scale.keys() {
            if SIZES.iter().all(|(name, _)| name != key) {
                problems.push(Problem::new(
                    format!("scale.{key}"),
                    "is no size",
                    "expected level, flow, pressure or time",
                ));
            }
        }
        Self {
            level,
            flow,
            pressure,
            time,
        }
    }
}

fn tank_level(system: &System, net: &Network, given: &Given, tank: usize) -> f64 {
    let part = &net.parts[tank];
    let initial = match system.initial.get(&format!("{}.level", part.name)) {
        Some(Initial::Given(level)) => Some(*level),
        Some(Initial::Written(text)) => written(text, Dimension::Length).ok(),
        Some(Initial::Free(bounds)) => Some(bounds.high),
        _ => None,
    };
    (given.level)
        .or(positive(Some(net.values[part.base + kinds::tank::BRIM])))
        .or(positive(initial))
        .unwrap_or(1.0)
}

/// Sizes of the whole system, each from those before it where nothing is given.
fn usual(system: &System, net: &Network, given: &Given) -> Scale {
    let weight = net.values[kinds::fluid::DENSITY] * net.values[kinds::fluid::GRAVITY];
    let level = net
        .tanks
        .iter()
        .map(|&t| tank_level(system, net, given, t))
        .fold(0.0, f64::max);
    let pressure = (given.pressure)
        .or(positive(Some(weight * level)))
        .unwrap_or(1e5);
    let mut at_pressure: Vec<f64> = (0..net.parts.len())
        .filter_map(|i| positive(flow_at(net, i, pressure)))
        .collect();
    at_pressure.sort_by(f64::total_cmp);
    let flow = (given.flow)
        .or(at_pressure.get(at_pressure.len() / 2).copied())
        .unwrap_or(1.0);
    let level = if level > 0.0 {
        level
    } else {
        pressure / weight.max(1e-9)
    };
    let area = net
        .tanks
        .first()
        .map(|&t| net.values[net.parts[t].base + kinds::tank::AREA]);
    let time = (given.time)
        .or(positive(system.record.step.map(|s| 2.0 * s * net.tick)))
        .or(positive(area.map(|a| 0.05 * a * level / flow)))
        .unwrap_or(1.0);
    Scale {
        level_m: level,
        flow_m3_s: flow,
        pressure_pa: pressure,
        time_s: time,
        reading: 1.0,
    }
}

/// Parameters of effects that nothing says start where they change nothing.
fn neutral(net: &mut Network) {
    for attached in &net.effects {
        let scale = &net.parts[attached.part].scale;
        for (slot, parameter) in (attached.base..).zip(attached.effect.about().parameters) {
            if net.values[slot].is_nan() {
                net.values[slot] = parameter.neutral * scale.of(parameter.size);
            }
        }
    }
}

/// Which value each component's effects may change.
fn hook(net: &mut Network) {
    for (i, part) in net.parts.iter().enumerate() {
        if part.effects.is_empty() {
            continue;
        }
        let slot = match part.kind {
            Kind::Boundary if part.gives_flow => Some(kinds::boundary::FLOW),
            Kind::Boundary => Some(kinds::boundary::PRESSURE),
            kind => kind.drive(),
        };
        net.hooked.extend(slot.map(|slot| (part.base + slot, i)));
    }
}

/// Flow of a line or valve at a pressure drop beside its rise.
fn flow_at(net: &Network, part: usize, pressure: f64) -> Option<f64> {
    let p = &net.parts[part];
    let own = &net.values[p.base..p.base + p.count];
    let [density, viscosity, gravity] = [net.values[0], net.values[1], net.values[2]];
    match p.kind {
        Kind::Valve | Kind::Orifice => Some((pressure / laws::valve_square(own, density)).sqrt()),
        Kind::Line => {
            let drop = |q: f64| {
                laws::line_drop(
                    p.friction,
                    own,
                    density,
                    viscosity,
                    gravity,
                    Dual::variable(q),
                )
                .v
            };
            let still = drop(0.0);
            let (mut low, mut high) = (1e-12, 1e6);
            if !(drop(high) - still > pressure) {
                return None;
            }
            for _ in 0..100 {
                let middle = f64::sqrt(low * high);
                if drop(middle) - still > pressure {
                    high = middle
                } else {
                    low = middle
                }
            }
            Some(low)
        }
        _ => None,
    }
}

fn positive(value: Option<f64>) -> Option<f64> {
    value.filter(|v| v.is_finite() && *v > 0.0)
}
