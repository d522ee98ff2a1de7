//! One component's slots: its properties, ports, curves and laws.

use super::{Slots, number, properties};
use crate::effect::Scale;
use crate::kinds::{self, Property};
use crate::laws::Friction;
use crate::network::Part;
use crate::spec::{Component, Kind, Setting, System};
use std::collections::BTreeMap;

/// Slots of one component, with its laws as words choose them.
pub(super) fn component_slots(
    slots: &mut Slots,
    system: &System,
    name: &str,
    component: &Component,
    missing: &mut Vec<(usize, String, &'static Property)>,
) {
    check_name(slots, name);
    let kind = component.kind;
    let table = kind.properties();
    let base = slots.values.len();
    for (index, p) in table.iter().enumerate() {
        slots.values.push(p.default.unwrap_or(f64::NAN));
        slots
            .paths
            .insert(format!("{name}.{}", p.name), base + index);
    }
    let settings = &component.settings;
    // A property is given if it is known, free or an input.
    let given = |key: &str| {
        let path = format!("{name}.{key}");
        settings.contains_key(key)
            || system.free.contains_key(&path)
            || system.inputs.contains_key(&path)
    };
    let mut absent = Vec::new();
    properties(
        slots,
        name,
        settings,
        table,
        base,
        kind.choices(),
        &mut absent,
    );
    // A curve of areas stands in for the area.
    let profile = points(slots, name, settings.get("area_profile"));
    absent.retain(|(_, path, _)| profile.is_empty() || !path.ends_with(".area"));
    if !profile.is_empty() {
        if given("area") {
            slots.problem(
                format!("{name}.area"),
                "is given beside `area_profile`, which stands in for it",
                "give one of them",
            );
        }
        slots.values[base + kinds::tank::AREA] = profile[0][1];
    }
    missing.extend(absent);
    let mut ports = Vec::new();
    if kind == Kind::Tank {
        ports.push(("outlet".to_owned(), Some(base + kinds::tank::OUTLET_HEIGHT)));
        ports.push(("inlet".to_owned(), None));
        tank_ports(slots, name, settings.get("ports"), &mut ports);
    }
    let friction = friction(slots, name, settings, &given);
    let inertia = flag(slots, name, settings, "inertia");
    if kind == Kind::Line {
        let said = matches!(settings.get("friction"), Some(Setting::Text(word)) if word == "darcy");
        let darcy = friction == Friction::Darcy;
        if darcy || inertia || given("minor_loss") {
            let known = |key: &str| settings.contains_key(key);
            line_bore(slots, name, base, &given, &known);
        }
        foreign_terms(slots, name, friction, &given);
        // Without a word on friction a bore may stand for the loss of fittings alone.
        if inertia || said || (darcy && !given("minor_loss")) {
            line_length(slots, system, name, base);
        }
    }
    if matches!(kind, Kind::Valve | Kind::Orifice) {
        valve_law(slots, name, &given);
    }
    let gives_flow = kind == Kind::Boundary && given("flow");
    let check_valve = flag(slots, name, settings, "check_valve");
    slots.parts.push(Part {
        name: name.to_owned(),
        kind,
        base,
        count: table.len(),
        friction,
        inertia,
        check_valve,
        column: None,
        profile,
        ports,
        gives_flow,
        effects: 0..0,
        scale: Scale {
            level_m: 1.0,
            flow_m3_s: 1.0,
            pressure_pa: 1.0,
            time_s: 1.0,
            reading: 1.0,
        },
    });
}

fn check_name(slots: &mut Slots, name: &str) {
    if name.is_empty()
        || name == "atmosphere"
        || name == "fluid"
        || name.contains(|c: char| c == '.' || c == '>' || c.is_whitespace())
    {
        slots.problem(
            name,
            "cannot be the name of a component",
            "a name must not contain a dot, space or `>`, nor be `atmosphere` or `fluid`",
        );
    }
}

/// The law of friction, by its word or by what is given.
fn friction(
    slots: &mut Slots,
    name: &str,
    settings: &BTreeMap<String, Setting>,
    given: &dyn Fn(&str) -> bool,
) -> Friction {
    let polynomial = ["linear", "quadratic", "cubic", "constant"];
    match word(slots, name, settings, "friction").as_deref() {
        None if given("power_coefficient") => Friction::Power,
        None if given("bore") && !polynomial.into_iter().any(given) => Friction::Darcy,
        None | Some("polynomial") => Friction::Polynomial,
        Some("darcy") => Friction::Darcy,
        Some("power") => Friction::Power,
        Some("none") => Friction::None,
        Some(other) => {
            let message =
                format!("is `{other}`, expected \"darcy\", \"polynomial\", \"power\" or \"none\"");
            slots.problem(format!("{name}.friction"), message, "");
            Friction::None
        }
    }
}

/// A line that needs a cross-section has one.
fn line_bore(
    slots: &mut Slots,
    name: &str,
    base: usize,
    given: &dyn Fn(&str) -> bool,
    known: &dyn Fn(&str) -> bool,
) {
    if given("flow_area") {
        return;
    }
    let own = &slots.values[base..];
    let (bore, inner) = (own[kinds::line::BORE], own[kinds::line::INNER]);
    let mend = "the Darcy law and inertia need `length` and `bore`, a minor loss needs `bore`; or give `flow_area`";
    if !given("bore") {
        slots.problem(format!("{name}.bore"), "is missing", mend);
    } else if known("bore")
        && (known("inner_diameter") || !given("inner_diameter"))
        && bore <= inner
    {
        slots.problem(
            format!("{name}.bore"),
            format!("is {bore} m, not above the inner diameter of {inner} m"),
            mend,
        );
    }
}

/// Terms of one law of friction beside another would change nothing.
fn foreign_terms(slots: &mut Slots, name: &str, law: Friction, given: &dyn Fn(&str) -> bool) {
    let polynomial = ["constant", "linear", "quadratic", "cubic"];
    let power = ["power_coefficient", "exponent"];
    let terms = polynomial
        .map(|key| (key, Friction::Polynomial, "polynomial"))
        .into_iter()
        .chain(power.map(|key| (key, Friction::Power, "power")));
    for (key, of, word) in terms {
        if law != of && given(key) {
            slots.problem(
                format!("{name}.{key}"),
                "belongs to another law of friction than the line has",
                format!("write `friction = \"{word}\"`, or leave it out"),
            );
        }
    }
}

/// A line that needs a length has one, or gets it from a recording or a fit.
fn line_length(slots: &mut Slots, system: &System, name: &str, base: usize) {
    let path = format!("{name}.length");
    let later = system.free.contains_key(&path) || system.inputs.contains_key(&path);
    if !later && slots.values[base + kinds::line::LENGTH] == 0.0 {
        slots.problem(
            path,
            "is missing or 0",
            "the Darcy law and inertia need `length`",
        );
    }
}

fn valve_law(slots: &mut Slots, name: &str, has: &dyn Fn(&str) -> bool) {
    let ways = [
        has("flow_coefficient"),
        has("discharge_coefficient"),
        has("loss_coefficient"),
    ];
    if ways.iter().filter(|w| **w).count() != 1 || (!ways[0] && !has("area")) {
        slots.problem(name, "has no flow law, or several", "give one of `flow_coefficient`, `discharge_coefficient` with `area`, `loss_coefficient` with `area`");
    }
}

fn tank_ports(
    slots: &mut Slots,
    name: &str,
    setting: Option<&Setting>,
    ports: &mut Vec<(String, Option<usize>)>,
) {
    let Some(setting) = setting else { return };
    let path = format!("{name}.ports");
    let Setting::Named(named) = setting else {
        slots.problem(
            path,
            "is no table",
            "write `ports = { drain = 0.1, filler = \"top\" }`",
        );
        return;
    };
    let height = &kinds::PORT_HEIGHT;
    for (port, setting) in named {
        ports.retain(|(known, _)| known != port);
        if matches!(setting, Setting::Text(word) if word == "top") {
            ports.push((port.clone(), None));
            continue;
        }
        match number(setting, height) {
            Ok(value) => {
                slots
                    .paths
                    .insert(format!("{path}.{port}"), slots.values.len());
                ports.push((port.clone(), Some(slots.values.len())));
                slots.values.push(value);
            }
            Err(message) => slots.problem(
                format!("{path}.{port}"),
                message,
                "a height above the floor, or \"top\"",
            ),
        }
    }
}

fn points(slots: &mut Slots, name: &str, setting: Option<&Setting>) -> Vec<[f64; 2]> {
    let Some(setting) = setting else {
        return Vec::new();
    };
    let path = format!("{name}.area_profile");
    let Setting::Points(points) = setting else {
        slots.problem(
            path,
            "is not a list of points",
            "write `area_profile = [[0.0, 1.0], [2.0, 1.5]]`",
        );
        return Vec::new();
    };
    let ascending = points.windows(2).all(|w| w[0][0] < w[1][0]);
    let positive = points
        .iter()
        .all(|p| p[1] > 0.0 && p[1].is_finite() && p[0].is_finite());
    if points.is_empty() || !ascending || !positive {
        slots.problem(
            path,
            "does not rise in height or has no positive areas",
            "points are [height in m, area in m2]",
        );
        return Vec::new();
    }
    points.clone()
}

fn word(
    slots: &mut Slots,
    name: &str,
    settings: &BTreeMap<String, Setting>,
    key: &str,
) -> Option<String> {
    match settings.get(key)? {
        Setting::Text(text) => Some(text.clone()),
        _ => {
            slots.problem(format!("{name}.{key}"), "is no text", "write it in quotes");
            None
        }
    }
}

fn flag(slots: &mut Slots, name: &str, settings: &BTreeMap<String, Setting>, key: &str) -> bool {
    match settings.get(key) {
        None => false,
        Some(Setting::Flag(flag)) => *flag,
        Some(_) => {
            slots.problem(format!("{name}.{key}"), "is neither true nor false", "");
            false
        }
    }
}

/// The tanks whose columns lines follow.
pub(super) fn resolve_columns(slots: &mut Slots, system: &System) {
    for (name, component) in &system.components {
        if component.kind != Kind::Line {
            continue;
        }
        let Some(tank) = word(slots, name, &component.settings, "column") else {
            continue;
        };
        let found = slots
            .part(&tank)
            .filter(|&t| slots.parts[t].kind == Kind::Tank);
        let Some(part) = slots.part(name) else {
            continue;
        };
        match found {
            Some(tank) => slots.parts[part].column = Some(tank),
            None => slots.problem(
                format!("{name}.column"),
                format!("`{tank}` is not a tank"),
                "name a tank in [components]",
            ),
        }
    }
}
