//! From the description to slots: components, properties, inputs, free values.

mod attached;
mod components;

use crate::error::Problem;
use crate::kinds::{self, Property};
use crate::near::meant;
use crate::network::{Attached, Driven, FLUID_SLOTS, FreeSlot, Part};
use crate::spec::{Kind, Setting, System};
use attached::effect_slots;
use components::{component_slots, resolve_columns};
use dgd_units::{Unit, UnitError, split_number};
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

    /// The components that carry flow, and `more`, for a name that is none of them.
    pub(crate) fn carriers(&self, written: &str, more: &[&str]) -> String {
        let carries = |part: &&Part| part.kind != Kind::Instrument;
        let parts = self.parts.iter().filter(carries);
        let names = parts.map(|p| p.name.as_str()).chain(more.iter().copied());
        let meant = meant(written, names.clone());
        format!("{meant}components: {}", listed(names))
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

/// What there is, for a message.
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
            if property.dimension.is_none() {
                return Err(format!(
                    "`{text}` has a unit, expected a bare number in {}",
                    property.unit
                ));
            }
            let unit = property.unit_of(unit).map_err(|e| match e {
                UnitError::UnknownUnit {
                    suggestion: None, ..
                } => format!("{e}, expected one such as `{}`", property.unit),
                other => other.to_string(),
            })?;
            Ok(unit.to_si(value))
        }
        _ => Err(format!(
            "is not a number, expected a number in {}",
            property.unit
        )),
    }
}

/// Why a property cannot be that; one that may be absent may be NaN.
fn refused(value: f64, property: &Property) -> Option<String> {
    let absent = value.is_nan() && property.default.is_some_and(f64::is_nan);
    property.refusal(value).filter(|_| !absent)
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
            let property = &table[index];
            match number(setting, property).map(|value| (value, refused(value, property))) {
                Ok((value, None)) => slots.values[base + index] = value,
                Ok((_, Some(message))) | Err(message) => {
                    slots.problem(path, message, property.meaning);
                }
            }
        } else if !choices.iter().any(|(c, _)| c == key) {
            let known = listed(
                table
                    .iter()
                    .map(|p| p.name)
                    .chain(choices.iter().map(|c| c.0)),
            );
            let all = table.iter().map(|p| p.name);
            let meant = meant(key, all.chain(choices.iter().map(|c| c.0)));
            slots.problem(
                path,
                "is not a property here",
                format!("{meant}expected one of: {known}"),
            );
        }
    }
    for (index, property) in table.iter().enumerate() {
        if property.default.is_none() && !settings.contains_key(property.name) {
            missing.push((base + index, format!("{name}.{}", property.name), property));
        }
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
        let read = |written: &str| {
            property_of(system, path).map_or_else(
                || Unit::parse(written),
                |property| property.unit_of(written),
            )
        };
        let unit = match input.unit.as_deref().map(read).transpose() {
            Ok(unit) => unit,
            Err(error) => {
                slots.problem(path, error.to_string(), "");
                None
            }
        };
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
                "remove it from [free] or from [inputs]",
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
        let all = || slots.parts.iter().map(|p| p.name.as_str());
        format!(
            "{}there is no component `{part}`; components: {}; a path is quoted, \"tank.area\"",
            meant(part, all()),
            listed(all())
        )
    } else {
        let meant = meant(path, near.iter().map(String::as_str));
        format!("{meant}expected one of: {}", near.join(", "))
    };
    slots.problem(path, format!("in {table} is not a property"), mend);
}
