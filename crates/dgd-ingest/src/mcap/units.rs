//! Units from a topic's JSON Schema and from its metadata.

use super::records::Channel;
use dgd_units::Unit;
use serde_json::Value;
use std::collections::HashMap;

/// Unit of each member, by path.
pub(super) type Units = HashMap<String, String>;

/// Looks at the properties of a JSON Schema: a `unit` (or `units`) of their own, else a
/// `description` that is a unit, ends in one in brackets, or begins with `unit:`.
pub(super) fn from_schema(data: &[u8]) -> Units {
    let mut units = Units::new();
    if let Ok(schema) = serde_json::from_slice(data) {
        properties(&schema, "", &mut units);
    }
    units
}

/// Channel metadata such as `FT1.unit = gpm`, `unit.FT1 = gpm` or `FT1 = gpm`.
pub(super) fn add_metadata(channel: &Channel<'_>, units: &mut Units) {
    for (key, value) in &channel.metadata {
        let named = key
            .strip_suffix(".unit")
            .or_else(|| key.strip_prefix("unit."));
        let name = match named {
            Some(name) => name,
            None if Unit::parse(value).is_ok() => key,
            None => continue,
        };
        units
            .entry(name.to_owned())
            .or_insert_with(|| value.trim().to_owned());
    }
}

/// The parser bounds the depth of nesting.
fn properties(schema: &Value, above: &str, units: &mut Units) {
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
            units.insert(path.clone(), unit);
        }
        properties(member, &path, units);
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
        let units = from_schema(schema);
        let of = |path: &str| units.get(path).map(String::as_str);
        assert_eq!(of("a"), Some("gpm"));
        assert_eq!(of("b"), Some("psia"));
        assert_eq!(of("c"), Some("psi"));
        assert_eq!(of("d"), Some("l/min"));
        assert_eq!(of("e"), None);
        assert_eq!(of("f.g"), Some("m"));
    }
}
