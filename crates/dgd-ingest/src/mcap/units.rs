//! Units from a topic's JSON Schema and from its metadata.

use super::json;
use super::records::Channel;
use crate::count;
use dgd_units::Unit;
use serde_json::Value;
use std::collections::HashMap;

/// Unit of each member, by path.
pub(super) type Units = HashMap<String, String>;

/// Bytes of a schema that are parsed; as a tree they take thirty times as much.
pub(super) const MAX_SCHEMA: usize = 1 << 20;
/// Units that a file may state, those of its schemas counted again for each topic.
const MAX_UNITS: usize = 16_384;
/// Longest unit in bytes.
const MAX_UNIT: usize = 64;

/// How many units were kept, and what was not.
#[derive(Debug, Default)]
pub(super) struct Shelf {
    kept: usize,
    /// Units beyond [`MAX_UNITS`].
    pub(super) dropped: u64,
}

impl Shelf {
    fn keep(&mut self, units: &mut Units, path: &str, unit: &str) {
        // No member has a longer path.
        if path.len() > json::MAX_PATH || unit.len() > MAX_UNIT {
            return;
        }
        if self.kept == MAX_UNITS {
            self.dropped += 1;
            return;
        }
        self.kept += 1;
        units.insert(path.to_owned(), unit.to_owned());
    }

    /// Adds units of a schema to those of a topic.
    pub(super) fn copy(&mut self, from: &Units, to: &mut Units) {
        // All or none: which of them were kept must not depend on the order of a hash.
        if from.len() > MAX_UNITS - self.kept {
            self.dropped += from.len() as u64;
            return;
        }
        self.kept += from.len();
        to.extend(from.iter().map(|(path, unit)| (path.clone(), unit.clone())));
    }

    /// What to tell, if something was left out.
    pub(super) fn message(&self) -> Option<String> {
        (self.dropped > 0).then(|| {
            format!(
                "{} beyond the limit of {MAX_UNITS} units of a log were left out",
                count(self.dropped, "unit")
            )
        })
    }
}

/// Looks at the properties of a JSON Schema: a `unit` (or `units`) of their own, else a
/// `description` that is a unit, ends in one in brackets, or begins with `unit:`.
pub(super) fn from_schema(data: &[u8], shelf: &mut Shelf) -> Units {
    let mut units = Units::new();
    if let Ok(schema) = serde_json::from_slice(data) {
        properties(&schema, "", &mut units, shelf);
    }
    units
}

/// Channel metadata such as `FT1.unit = gpm`, `unit.FT1 = gpm` or `FT1 = gpm`.
pub(super) fn add_metadata(channel: &Channel<'_>, units: &mut Units, shelf: &mut Shelf) {
    for (key, value) in &channel.metadata {
        let named = key
            .strip_suffix(".unit")
            .or_else(|| key.strip_prefix("unit."));
        let name = match named {
            Some(name) => name,
            None if Unit::parse(value).is_ok() => key,
            None => continue,
        };
        if !units.contains_key(name) {
            shelf.keep(units, name, value.trim());
        }
    }
}

/// The parser bounds the depth of nesting.
fn properties(schema: &Value, above: &str, units: &mut Units, shelf: &mut Shelf) {
    let Some(members) = schema.get("properties").and_then(Value::as_object) else {
        return;
    };
    for (name, member) in members {
        let path = if above.is_empty() {
            name.clone()
        } else {
            format!("{above}.{name}")
        };
        if let Some(unit) = unit(member) {
            shelf.keep(units, &path, &unit);
        }
        if path.len() <= json::MAX_PATH {
            properties(member, &path, units, shelf);
        }
    }
}

fn unit(member: &Value) -> Option<String> {
    let text = |key| {
        member
            .get(key)
            .and_then(Value::as_str)
            .map(str::trim)
            .filter(|t| !t.is_empty())
    };
    if let Some(unit) = text("unit").or_else(|| text("units")) {
        return Some(unit.to_owned());
    }
    let description = text("description")?;
    let labelled = description.strip_prefix("unit:").map(str::trim);
    let bracketed = || {
        let (_, unit) = description.strip_suffix(']')?.rsplit_once('[')?;
        Some(unit.trim())
    };
    let last = || {
        let (_, unit) = description.strip_suffix(')')?.rsplit_once('(')?;
        Some(unit.trim())
    };
    let known = |unit: &&str| Unit::parse(unit).is_ok();
    let found = labelled
        .or_else(bracketed)
        .or_else(|| last().filter(known))
        .or_else(|| Some(description).filter(known))?;
    (!found.is_empty()).then(|| found.to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_are_found_in_each_place() {
        let schema = br#"{"properties": {
            "a": {"unit": "gpm"}, "b": {"description": "inlet pressure [psia]"},
            "c": {"description": "psi"}, "d": {"description": "unit: l/min"},
            "e": {"description": "pump speed"},
            "f": {"properties": {"g": {"description": "level (m)"}}}}}"#;
        let units = from_schema(schema, &mut Shelf::default());
        let of = |path: &str| units.get(path).map(String::as_str);
        assert_eq!(of("a"), Some("gpm"));
        assert_eq!(of("b"), Some("psia"));
        assert_eq!(of("c"), Some("psi"));
        assert_eq!(of("d"), Some("l/min"));
        assert_eq!(of("e"), None);
        assert_eq!(of("f.g"), Some("m"));
    }
}
