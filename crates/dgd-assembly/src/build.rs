//! From the description to slots: components, properties, inputs, free values.

use crate::effect::Scale;
use crate::effects;
use crate::error::Problem;
use crate::kinds::{self, Property};
use crate::laws::Friction;
use crate::network::{Attached, Driven, FLUID_SLOTS, FreeSlot, Part};
use crate::spec::{Component, Kind, Setting, System};
use dgd_units::{Dimension, Unit, split_number};
use std::collections::BTreeMap;

/// What the first pass over a description gives.
pub(crate) struct Slots {
    pub parts: Vec<Part>,
    pub effects: Vec<Attached>,
    pub values: Vec<f64>,
    /// Path to slot and property.
    pub paths: BTreeMap<String, usize>,
    pub free: Vec<FreeSlot>,
    pub driven: Vec<Driven>,
    pub problems: Vec<Problem>,
}

impl Slots {
    pub(crate) fn part(&self, name: &str) -> Option<usize> {
        self.parts.iter().position(|p| p.name == name)
    }

    fn problem(
        &mut self,
        path: impl Into<String>,
        message: impl Into<String>,
        mend: impl Into<String>,
    ) {
        self.problems.push(Problem::new(path, message, mend));
    }
}

/// The words nearest to what was written, for a message.
pub(crate) fn listed<'a>(names: impl IntoIterator<Item = &'a str>) -> String {
    let all: Vec<&str> = names.into_iter().collect();
    if all.is_empty() {
        "none".into()
    } else {
        all.join(", ")
    }
}

/// A number, or a number with a unit of the property's dimension.
pub(crate) fn number(setting: &Setting, property: &Property) -> Result<f64, String> {
    match setting {
        Setting::Number(value) => Ok(*value),
        Setting::Text(text) => {
            let (value, unit) = split_number(text).map_err(|e| e.to_string())?;
            if unit.is_empty() || unit == property.unit {
                return Ok(value);
            }
            match property.dimension {
                Some(dimension) => Unit::parse_as(unit, dimension)
                    .map(|u| u.to_si(value))
                    .map_err(|e| e.to_string()),
                None => Err(format!(
                    "`{text}` has a unit, expected a bare number in {}",
                    property.unit
                )),
            }
        }
        _ => Err(format!(
            "is no number, expected a number in {}",
            property.unit
        )),
    }
}

fn within(value: f64, property: &Property) -> bool {
    value.is_nan() && property.default.is_some_and(f64::is_nan)
        || value >= property.low && value <= property.high
}

pub(crate) fn read(system: &System) -> Slots {
    let mut slots = Slots {
        parts: Vec::new(),
        effects: Vec::new(),
        values: kinds::FLUID
            .iter()
            .map(|p| p.default.unwrap_or(0.0))
            .collect(),
        paths: BTreeMap::new(),
        free: Vec::new(),
        driven: Vec::new(),
        problems: Vec::new(),
    };
    debug_assert_eq!(slots.values.len(), FLUID_SLOTS);
    let mut missing: Vec<(usize, String, &'static Property)> = Vec::new();
    for (i, p) in kinds::FLUID.iter().enumerate() {
        slots.paths.insert(format!("fluid.{}", p.name), i);
    }
    properties(
        &mut slots,
        "fluid",
        &system.fluid,
        kinds::FLUID,
        0,
        &[],
        &mut missing,
    );
    for (name, component) in &system.components {
        component_slots(&mut slots, system, name, component, &mut missing);
    }
    resolve_columns(&mut slots, system);
    effect_slots(&mut slots, system);
    inputs(&mut slots, system);
    free(&mut slots, system);
    for (slot, path, property) in missing {
        let found = slots.free.iter().any(|f| f.slot == slot)
            || slots.driven.iter().any(|d| d.slot == slot);
        if !found {
            let mend = format!(
                "add `{} = ..` ({}, {}), or `\"{path}\"` to [free] or [inputs]",
                property.name, property.meaning, property.unit
            );
            slots.problem(path, "has no value", mend);
        }
    }
    slots
}

fn properties(
    slots: &mut Slots,
    name: &str,
    settings: &BTreeMap<String, Setting>,
    table: &'static [Property],
    base: usize,
    choices: &[(&str, &str)],
    missing: &mut Vec<(usize, String, &'static Property)>,
) {
    for (key, setting) in settings {
        let path = format!("{name}.{key}");
        if let Some(index) = table.iter().position(|p| p.name == key) {
            match number(setting, &table[index]) {
                Ok(value) if within(value, &table[index]) => slots.values[base + index] = value,
                Ok(value) => {
                    let p = &table[index];
                    slots.problem(
                        path,
                        format!("is {value} {}, expected {} to {}", p.unit, p.low, p.high),
                        p.meaning,
                    );
                }
                Err(message) => slots.problem(path, message, table[index].meaning),
            }
        } else if !choices.iter().any(|(c, _)| c == key) {
            let known = listed(
                table
                    .iter()
                    .map(|p| p.name)
                    .chain(choices.iter().map(|c| c.0)),
            );
            slots.problem(
                path,
                "is not a property here",
                format!("expected one of: {known}"),
            );
        }
    }
    for (index, property) in table.iter().enumerate() {
        if property.default.is_none() && !settings.contains_key(property.name) {
            missing.push((base + index, format!("{name}.{}", property.name), property));
        }
    }
}

fn component_slots(
    slots: &mut Slots,
    system: &System,
    name: &str,
    component: &Component,
    missing: &mut Vec<(usize, String, &'static Property)>,
) {
    if name.is_empty()
        || name == "atmosphere"
        || name == "fluid"
        || name.contains(|c: char| c == '.' || c == '>' || c.is_whitespace())
    {
        slots.problem(
            name,
            "cannot be the name of a component",
            "a name holds no dot, space or `>` and is not `atmosphere` or `fluid`",
        );
    }
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
        slots.values[base + kinds::tank::AREA] = profile[0][1];
    }
    missing.extend(absent);
    let mut ports = Vec::new();
    if kind == Kind::Tank {
        ports.push(("outlet".to_owned(), Some(base + kinds::tank::OUTLET_HEIGHT)));
        ports.push(("inlet".to_owned(), None));
        tank_ports(slots, name, settings.get("ports"), &mut ports);
    }
    let friction = match word(slots, name, settings, "friction").as_deref() {
        None if given("power_coefficient") => Friction::Power,
        None if given("bore")
            && !["linear", "quadratic", "cubic", "constant"]
                .iter()
                .any(|k| given(k)) =>
        {
            Friction::Darcy
        }
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
    };
    let inertia = flag(slots, name, settings, "inertia");
    let own = &slots.values[base..];
    if kind == Kind::Line
        && (friction == Friction::Darcy || inertia)
        && !given("flow_area")
        && !given("bore")
        && !(own[kinds::line::BORE].is_finite() && own[kinds::line::BORE] > own[kinds::line::INNER])
    {
        slots.problem(
            format!("{name}.bore"),
            "is missing or not above the inner diameter",
            "the Darcy law and inertia need `length` and `bore`",
        );
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

fn valve_law(slots: &mut Slots, name: &str, has: &dyn Fn(&str) -> bool) {
    let ways = [
        has("flow_coefficient"),
        has("discharge_coefficient"),
        has("loss_coefficient"),
    ];
    if ways.iter().filter(|w| **w).count() != 1 || (!ways[0] && !has("area")) {
        slots.problem(name, "has no or several flow laws", "give one of `flow_coefficient`, `discharge_coefficient` with `area`, `loss_coefficient` with `area`");
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
            "is no list of points",
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

fn resolve_columns(slots: &mut Slots, system: &System) {
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
                format!("`{tank}` is no tank"),
                "name a tank of [components]",
            ),
        }
    }
}

fn effect_slots(slots: &mut Slots, system: &System) {
    // Effects of a part stand together.
    let mut asked: Vec<(usize, &crate::spec::EffectSetting)> = Vec::new();
    for setting in &system.effects {
        let path = format!("{}.{}", setting.component, setting.effect);
        match slots.part(&setting.component) {
            None => slots.problem(
                path,
                format!("there is no component `{}`", setting.component),
                "",
            ),
            Some(part) => asked.push((part, setting)),
        }
    }
    asked.sort_by_key(|(part, _)| *part);
    for (part, setting) in asked {
        let kind = slots.parts[part].kind;
        let path = format!("{}.{}", setting.component, setting.effect);
        let Some(effect) =
            effects::find(&setting.effect).filter(|e| e.about().kinds.contains(&kind))
        else {
            let known = listed(
                effects::all()
                    .iter()
                    .map(|e| e.about())
                    .filter(|a| a.kinds.contains(&kind))
                    .map(|a| a.id),
            );
            slots.problem(
                path,
                format!("is no effect of a {}", kind.name()),
                format!("expected one of: {known}"),
            );
            continue;
        };
        if slots
            .paths
            .contains_key(&format!("{path}.{}", effect.about().parameters[0].name))
        {
            slots.problem(path, "is given twice", "an effect acts once on a component");
            continue;
        }
        let about = effect.about();
        for key in setting.parameters.keys() {
            if !about.parameters.iter().any(|p| p.name == key) {
                let known = listed(about.parameters.iter().map(|p| p.name));
                slots.problem(
                    format!("{path}.{key}"),
                    "is no parameter of the effect",
                    format!("expected one of: {known}"),
                );
            }
        }
        let base = slots.values.len();
        for parameter in about.parameters {
            let value = setting.parameters.get(parameter.name).copied();
            slots
                .paths
                .insert(format!("{path}.{}", parameter.name), slots.values.len());
            // NaN: filled in once the sizes are known.
            slots.values.push(value.unwrap_or(f64::NAN));
        }
        let index = slots.effects.len();
        slots.effects.push(Attached {
            effect,
            part,
            base,
            count: about.parameters.len(),
            states: 0..0,
        });
        let range = &mut slots.parts[part].effects;
        let first = if range.start == range.end {
            index
        } else {
            range.start
        };
        *range = first..index + 1;
    }
}

/// The property of a component that a path stands for.
fn property_of(system: &System, path: &str) -> Option<&'static Property> {
    let (name, key) = path.split_once('.')?;
    let table = system.components.get(name)?.kind.properties();
    table.iter().find(|p| p.name == key)
}

fn inputs(slots: &mut Slots, system: &System) {
    for (path, input) in &system.inputs {
        let Some(&slot) = slots.paths.get(path) else {
            unknown_path(slots, path, "[inputs]");
            continue;
        };
        if input.channel.is_empty() {
            slots.problem(
                path,
                "is an input without a channel",
                "add `channel = \"column\"`",
            );
        }
        let unit = match input.unit.as_deref().map(Unit::parse).transpose() {
            Ok(unit) => unit,
            Err(error) => {
                slots.problem(path, error.to_string(), "");
                None
            }
        };
        // A bare number is a share: per cent are hundredths of it.
        let share =
            property_of(system, path).is_some_and(|p| p.dimension == Some(Dimension::Number));
        let unit = unit.map(|u| match u.dimension {
            Dimension::Percent if share => Unit {
                factor: 0.01 * u.factor,
                ..u
            },
            _ => u,
        });
        slots.driven.push(Driven {
            path: path.clone(),
            slot,
            channel: input.channel.clone(),
            between: input.between,
            unit,
        });
    }
}

fn free(slots: &mut Slots, system: &System) {
    for (path, bounds) in &system.free {
        let Some(&slot) = slots.paths.get(path) else {
            unknown_path(slots, path, "[free]");
            continue;
        };
        let ordered =
            bounds.low < bounds.high && bounds.start >= bounds.low && bounds.start <= bounds.high;
        if !(ordered && bounds.low.is_finite() && bounds.high.is_finite()) {
            let message = format!(
                "has start {}, low {}, high {}, expected finite low <= start <= high, low < high",
                bounds.start, bounds.low, bounds.high
            );
            slots.problem(path, message, "");
            continue;
        }
        if slots.driven.iter().any(|d| d.slot == slot) {
            slots.problem(
                path,
                "is free and an input",
                "take it out of [free] or of [inputs]",
            );
        }
        slots.values[slot] = bounds.start;
        slots.free.push(FreeSlot {
            path: path.clone(),
            slot,
            bounds: *bounds,
        });
    }
}

fn unknown_path(slots: &mut Slots, path: &str, table: &str) {
    let part = path.split('.').next().unwrap_or_default();
    let near: Vec<String> = slots
        .paths
        .keys()
        .filter(|k| k.split('.').next() == Some(part))
        .cloned()
        .collect();
    let mend = if near.is_empty() {
        let names = listed(slots.parts.iter().map(|p| p.name.as_str()));
        format!(
            "there is no component `{part}`; components: {names}; a path is quoted, \"tank.area\""
        )
    } else {
        format!("expected one of: {}", near.join(", "))
    };
    slots.problem(path, format!("in {table} is no property"), mend);
}
