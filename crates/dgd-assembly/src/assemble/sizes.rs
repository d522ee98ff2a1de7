//! Usual sizes, and the parameters of effects that were left open.

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
    let property = |name, dimension| Property {
        name,
        dimension: Some(dimension),
        unit: "SI",
        default: None,
        low: 0.0,
        high: f64::INFINITY,
        meaning: "",
    };
    let mut given = |name: &'static str, dimension| {
        let setting = system.scale.get(name)?;
        match number(setting, &property(name, dimension)) {
            Ok(value) => Some(value),
            Err(message) => {
                problems.push(Problem::new(format!("scale.{name}"), message, ""));
                None
            }
        }
    };
    let given = [
        given("level", Dimension::Length),
        given("flow", Dimension::FlowRate),
        given("pressure", Dimension::Pressure),
        given("time", Dimension::Time),
    ];
    for key in system
        .scale
        .keys()
        .filter(|k| !["level", "flow", "pressure", "time"].contains(&k.as_str()))
    {
        problems.push(Problem::new(
            format!("scale.{key}"),
            "is no size",
            "expected level, flow, pressure or time",
        ));
    }
    let weight = net.values[kinds::fluid::DENSITY] * net.values[kinds::fluid::GRAVITY];
    let level_of = |net: &Network, tank: usize| {
        let part = &net.parts[tank];
        let initial = match system.initial.get(&format!("{}.level", part.name)) {
            Some(Initial::Given(level)) => Some(*level),
            Some(Initial::Free(bounds)) => Some(bounds.high),
            _ => None,
        };
        positive(given[0])
            .or(positive(Some(net.values[part.base + kinds::tank::BRIM])))
            .or(positive(initial))
            .unwrap_or(1.0)
    };
    let level = net
        .tanks
        .iter()
        .map(|&t| level_of(net, t))
        .fold(0.0, f64::max);
    let pressure = positive(given[2])
        .or(positive(Some(weight * level)))
        .unwrap_or(1e5);
    let mut at_pressure: Vec<f64> = (0..net.parts.len())
        .filter_map(|i| positive(flow_at(net, i, pressure)))
        .collect();
    at_pressure.sort_by(f64::total_cmp);
    let flow = positive(given[1])
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
    let time = positive(given[3])
        .or(positive(system.record.step.map(|s| 2.0 * s * net.tick)))
        .or(positive(area.map(|a| 0.05 * a * level / flow)))
        .unwrap_or(1.0);
    for i in 0..net.parts.len() {
        let own = if net.parts[i].kind == Kind::Tank {
            level_of(net, i)
        } else {
            level
        };
        let reading = net.meters.iter().find(|m| m.part == i).map_or(1.0, |m| {
            let size = match m.reading {
                Reading::Level(tank) => level_of(net, net.tanks[tank]),
                Reading::Pressure(_) | Reading::Drop { .. } => pressure,
                Reading::Head { .. } => level,
                Reading::Flow { .. } | Reading::Leaving { .. } | Reading::Source(_) => flow,
                Reading::Speed(_) => 100.0,
            };
            let gain = net.values[net.parts[i].base + kinds::instrument::GAIN].abs();
            positive(Some(size * gain)).unwrap_or(1.0)
        });
        net.parts[i].scale = Scale {
            level_m: own,
            flow_m3_s: flow,
            pressure_pa: pressure,
            time_s: time,
            reading,
        };
    }
    for attached in &net.effects {
        let scale = &net.parts[attached.part].scale;
        for (slot, parameter) in (attached.base..).zip(attached.effect.about().parameters) {
            if net.values[slot].is_nan() {
                net.values[slot] = parameter.neutral * scale.of(parameter.size);
            }
        }
    }
    for i in 0..net.parts.len() {
        let part = &net.parts[i];
        if part.effects.is_empty() {
            continue;
        }
        let slot = match part.kind {
            Kind::Boundary if part.gives_flow => Some(kinds::boundary::FLOW),
            Kind::Boundary => Some(kinds::boundary::PRESSURE),
            kind => kind.drive(),
        };
        if let Some(slot) = slot {
            net.hooked.push((part.base + slot, i));
        }
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
