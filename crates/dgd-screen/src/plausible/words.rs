//! Faults and mistakes in words.

use super::WellLine;
use super::causes::{Cause, Depth};
use super::checks::{Check, Fault};
use super::facts::{median, quantile};
use super::state::State;
use crate::channel::is_pressure;
use dgd_recording::Channel;
use dgd_units::{Dimension, STANDARD_GRAVITY_M_S2, Unit};

/// `pump_inlet_pressure `PT1``.
pub(super) fn named(state: &State<'_>, told: usize) -> String {
    let told = &state.facts.told[told];
    match &told.tag {
        Some(tag) => format!("{} `{tag}`", told.channel.name()),
        None => format!("{} (a fixed value)", told.channel.name()),
    }
}

fn of(state: &State<'_>, channel: Channel) -> String {
    let told = state.facts.find(channel);
    told.map_or_else(|| channel.name().into(), |i| named(state, i))
}

/// `all pressures` in the place of a list of them.
fn all_of(state: &State<'_>, told: &[usize]) -> String {
    for (all, words) in [
        (state.pressures(), "all pressures"),
        (state.flows(), "all flows"),
    ] {
        if all == told {
            return words.to_owned();
        }
    }
    all_named(state, told)
}

fn all_named(state: &State<'_>, told: &[usize]) -> String {
    let names: Vec<String> = told.iter().map(|i| named(state, *i)).collect();
    match names.as_slice() {
        [] => String::new(),
        [only] => only.clone(),
        [first @ .., last] => format!("{} and {last}", first.join(", ")),
    }
}

/// Three digits, or all before the point, with thousands parted; beyond a thousand millions and below a ten thousandth by powers of ten.
pub(super) fn number(value: f64) -> String {
    if !value.is_finite() || value == 0.0 {
        return format!("{value}");
    }
    let size = value.abs().log10().floor();
    if !(-4.0..9.0).contains(&size) {
        return format!("{value:.2e}");
    }
    let decimals = (2.0 - size).clamp(0.0, 6.0);
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "between 0 and 6"
    )]
    let text = format!("{value:.*}", decimals as usize);
    let text = match text.split_once('.') {
        Some(_) => text.trim_end_matches('0').trim_end_matches('.').to_owned(),
        None => text,
    };
    let (whole, rest) = match text.split_once('.') {
        Some((whole, rest)) => (whole, format!(".{rest}")),
        None => (text.as_str(), String::new()),
    };
    let mut parted = String::new();
    for (n, digit) in whole.chars().enumerate() {
        let left = whole.len() - n;
        if n > 0 && left.is_multiple_of(3) && !parted.ends_with('-') {
            parted.push(',');
        }
        parted.push(digit);
    }
    parted + &rest
}

fn bar(pa: f64) -> String {
    format!("{} bar", number(pa * 1e-5))
}

fn l_min(m3_s: f64) -> String {
    format!("{} L/min", number(m3_s * 6e4))
}

/// In the unit that it is read in, and in bar or L/min where that is another.
fn in_unit(si: f64, unit: Unit) -> String {
    let own = format!("{} {unit}", number(unit.from_si(si)));
    let plain = match unit.dimension {
        Dimension::Pressure if unit.factor != 1e5 => bar(si),
        Dimension::FlowRate if !unit.symbol.starts_with("l/min") => l_min(si),
        _ => return own,
    };
    format!("{own}, that is {plain},")
}

/// What does not hold.
pub(super) fn fault(state: &State<'_>, fault: &Fault) -> String {
    let flowing = state.flowing();
    let at = |told: usize| state.median(told, &flowing);
    let geometry = &state.geometry;
    match fault.check {
        Check::Column(i) => {
            let unit = state.units[i];
            let depth_m = match state.facts.told[i].channel {
                Channel::PumpOutletPressure(_) => geometry.pump_outlet_depth_m,
                Channel::RiserPressure => geometry
                    .riser_pressure_sensor_depth_m
                    .unwrap_or(geometry.pump_inlet_depth_m),
                _ => geometry.pump_inlet_depth_m,
            };
            format!(
                "{} is read as {unit}: {} at {} m, where mud of {} kg/m3 gives {} to {}",
                named(state, i),
                in_unit(at(i), unit).trim_end_matches(','),
                number(depth_m),
                number(state.density_kg_m3),
                number(fault.low.max(0.0) * 1e-5),
                bar(fault.high),
            )
        }
        Check::Twins(a, b) => format!(
            "{}, read as {}, shows {} where its twin {}, read as {}, shows {}",
            named(state, a),
            state.units[a],
            bar(at(a)),
            named(state, b),
            state.units[b],
            bar(at(b)),
        ),
        Check::Riser(i) => format!(
            "{}, read as {}, shows {}, which differs by {}, as much as {} m of the mud, from the pump inlet brought to its depth",
            named(state, i),
            state.units[i],
            bar(at(i)),
            bar(fault.found.abs()),
            number(fault.found.abs() / (STANDARD_GRAVITY_M_S2 * state.density_kg_m3)),
        ),
        Check::Flow(i) => format!(
            "{} is read as {}: {} are more than rigs pump (up to {})",
            named(state, i),
            state.units[i],
            l_min(fault.found),
            l_min(fault.high),
        ),
        Check::Apart => format!(
            "the pump's inlet lies at {} m and its outlet at {} m",
            number(geometry.pump_inlet_depth_m),
            number(geometry.pump_outlet_depth_m),
        ),
        Check::Rise => format!(
            "while mud flows, the pressure falls by {} from pump inlet to outlet",
            bar(-fault.found)
        ),
        Check::Returned => {
            let back = median(flowing.iter().map(|k| state.return_flow(*k)));
            let pumped = median(flowing.iter().map(|k| state.inflow(*k)));
            format!(
                "{} returns {} of the flow pumped in ({} against {}), read as {}",
                of(state, Channel::ReturnFlow),
                number(fault.found),
                l_min(back),
                l_min(pumped),
                units_of_flows(state),
            )
        }
        Check::Moves => format!(
            "the riser level moves {} times as far as inflow and return flow, read as {}, imply",
            number(fault.found),
            units_of_flows(state),
        ),
        Check::Friction => format!(
            "outlet pressure and return flow give the return line a friction factor of {} (lines have 0.01 to 0.1)",
            number(fault.found)
        ),
        Check::Lifts => format!(
            "the pump head does not follow {} (correlation {} with its square)",
            of(state, Channel::PumpSpeed),
            number(fault.found)
        ),
        Check::Speed => format!(
            "{} is read as %: it reaches {} %, but a pump runs at up to 100 % of its full speed",
            of(state, Channel::PumpSpeed),
            number(fault.found)
        ),
        Check::Step => format!(
            "time is read as {}: the samples are {} s apart",
            state.facts.clock,
            number(fault.found)
        ),
        Check::Density => format!(
            "mud of {} kg/m3 is not a drilling mud ({} to {} kg/m3)",
            number(fault.found),
            number(fault.low),
            number(fault.high)
        ),
    }
}

/// What is to be looked at first in the description.
pub(super) fn check_first(state: &State<'_>, fault: &Fault) -> &'static str {
    if matches!(fault.check, Check::Riser(_)) {
        "`pump_inlet_depth`, `riser_pressure_sensor_depth`, tag and unit"
    } else if state.flows().iter().any(|i| state.units[*i].counts_turns()) {
        "tag, unit and `stroke`"
    } else {
        "tag and unit"
    }
}

fn units_of_flows(state: &State<'_>) -> String {
    let flows = state.flows();
    let recorded = flows.iter().filter(|i| state.facts.told[**i].tag.is_some());
    let mut symbols: Vec<&str> = Vec::new();
    for symbol in recorded.map(|i| state.units[*i].symbol) {
        if !symbols.contains(&symbol) {
            symbols.push(symbol);
        }
    }
    symbols.join(" and ")
}

/// What would be plausible, in words; `after` is the recording read so.
pub(super) fn cause(before: &State<'_>, cause: &Cause, after: &State<'_>) -> String {
    let flowing = after.flowing();
    let shown = |told: &usize| {
        let si = after.median(*told, &flowing);
        if is_pressure(after.facts.told[*told].channel) {
            bar(si)
        } else if after.facts.told[*told].channel == Channel::PumpSpeed {
            format!("{} %", number(si))
        } else if si == 0.0 {
            // One that is mostly off.
            format!("up to {}", l_min(quantile(after.values(*told), 0.99)))
        } else {
            l_min(si)
        }
    };
    match cause {
        Cause::Unit(told, unit) => {
            let values: Vec<String> = told.iter().map(shown).collect();
            match told.as_slice() {
                [only] => format!("as {unit} {} would be {}", named(before, *only), values[0]),
                _ => format!(
                    "as {unit} {} would be {}",
                    all_of(before, told),
                    values.join(", ")
                ),
            }
        }
        Cause::Swap(pairs) => {
            let pairs: Vec<String> = pairs
                .iter()
                .map(|(a, b)| {
                    format!(
                        "{} and {} would be {} and {} if their tags are swapped",
                        named(before, *a),
                        named(before, *b),
                        shown(a),
                        shown(b)
                    )
                })
                .collect();
            pairs.join(", ")
        }
        Cause::Share(i) => format!(
            "as a share of 1 it would reach {} %: multiply the column by 100",
            number(quantile(after.values(*i), 0.95))
        ),
        Cause::Clock(unit, _) => {
            format!("as {unit} they would be {} s apart", number(after.step_s()))
        }
        Cause::Depths(Depth::All, _, words) => format!(
            "it would fit a pump at {} m, as if the depths were {words}",
            number(after.geometry.pump_inlet_depth_m)
        ),
        Cause::Depths(Depth::Inlet, _, words) => format!(
            "it would fit an inlet at {} m, as if its depth were {words}",
            number(after.geometry.pump_inlet_depth_m)
        ),
        Cause::Depths(Depth::Outlet, _, words) => format!(
            "it would fit an outlet at {} m, as if its depth were {words}",
            number(after.geometry.pump_outlet_depth_m)
        ),
        Cause::Density(_, words) => format!(
            "the pressures suggest mud of {} kg/m3, as if its density were {words}",
            number(after.density_kg_m3)
        ),
        Cause::Line(_, words) => format!(
            "it would fit a return line of {} m, as if its diameter were {words}",
            number(after.geometry.return_line_id_m)
        ),
        Cause::Riser(riser, pipe, _, words) => format!(
            "it would fit a riser of {} m around a pipe of {} m, as if {} {words}",
            number(after.geometry.riser_id_m),
            number(after.geometry.drillpipe_od_m),
            match (riser, pipe) {
                (true, true) => "both diameters were",
                (true, false) => "the riser's diameter were",
                _ => "the pipe's diameter were",
            }
        ),
    }
}

/// Where a mistake stands in the well description.
pub(super) fn place_of_cause(state: &State<'_>, cause: &Cause) -> WellLine {
    match cause {
        Cause::Unit(told, _) => place_of(state, told.first().copied()),
        Cause::Swap(pairs) => place_of(state, pairs.first().map(|p| p.0)),
        Cause::Share(i) => place_of(state, Some(*i)),
        Cause::Clock(..) => WellLine::new("channels", "time"),
        Cause::Depths(Depth::Outlet, ..) => WellLine::new("geometry", "pump_outlet_depth"),
        Cause::Depths(..) => WellLine::new("geometry", "pump_inlet_depth"),
        Cause::Density(..) => WellLine::new("mud", "density"),
        Cause::Line(..) => WellLine::new("geometry", "return_line_id"),
        Cause::Riser(true, ..) => WellLine::new("geometry", "riser_id"),
        Cause::Riser(..) => WellLine::new("geometry", "drillpipe_od"),
    }
}

/// Where a fault's channel stands in the well description.
pub(super) fn place_of_fault(state: &State<'_>, fault: &Fault) -> WellLine {
    let channel = |channel| place_of(state, state.facts.find(channel));
    match fault.check {
        Check::Column(i) | Check::Twins(i, _) | Check::Riser(i) | Check::Flow(i) => {
            place_of(state, Some(i))
        }
        Check::Apart => WellLine::new("geometry", "pump_outlet_depth"),
        Check::Rise => channel(Channel::PumpInletPressure(0)),
        Check::Returned | Check::Moves => channel(Channel::ReturnFlow),
        Check::Friction => WellLine::new("geometry", "return_line_id"),
        Check::Speed | Check::Lifts => channel(Channel::PumpSpeed),
        Check::Step => WellLine::new("channels", "time"),
        Check::Density => WellLine::new("mud", "density"),
    }
}

pub(super) fn place_of(state: &State<'_>, told: Option<usize>) -> WellLine {
    told.map_or(WellLine::new("channels", "time"), |i| {
        WellLine::of(state.facts.told[i].channel)
    })
}
