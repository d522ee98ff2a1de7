//! `dgd system kinds`: what a description may hold.

use crate::args::{Global, Kinds};
use crate::failure::Failure;
use crate::say::{self, TextTable, number};
use dgd_assembly::{Kind, Property};
use serde_json::{Value, json};
use std::fmt::Write as _;

pub(crate) fn run(arguments: &Kinds, global: &Global) -> Result<String, Failure> {
    let kinds: Vec<Kind> = match &arguments.kind {
        None => Kind::ALL.to_vec(),
        Some(name) => {
            let known = || Kind::ALL.map(Kind::name).join(", ");
            let kind = Kind::ALL.into_iter().find(|kind| kind.name() == name);
            vec![kind.ok_or_else(|| Failure::Arguments {
                reason: format!("`{name}` is not a kind of component; there are {}", known()),
            })?]
        }
    };
    Ok(if global.json {
        say::json(&json!({
            "schema": "dgd.kinds/1",
            "kinds": kinds.iter().map(|kind| as_json(*kind)).collect::<Vec<_>>(),
        }))
    } else {
        tell(&kinds)
    })
}

fn tell(kinds: &[Kind]) -> String {
    let mut text = String::new();
    for kind in kinds {
        let _ = writeln!(text, "kind = \"{}\": {}\n", kind.name(), kind.meaning());
        let mut table = TextTable::new(["property", "unit", "default", "range", "meaning"]);
        for p in kind.properties() {
            table.row([
                p.name.into(),
                p.unit.into(),
                default(p),
                p.range(),
                p.meaning.into(),
            ]);
        }
        for (name, accepts) in kind.choices() {
            table.row([
                (*name).into(),
                String::new(),
                String::new(),
                String::new(),
                (*accepts).into(),
            ]);
        }
        let _ = writeln!(text, "{}", table.render());
    }
    text.push_str(
        "`needed`: given as a number, free under [free], or driven under [inputs]. Numbers are in that unit, or strings with another, such as \
         \"19.5 in\".\n",
    );
    text
}

/// The value if absent.
fn default(property: &Property) -> String {
    match property.default {
        None => "needed".into(),
        Some(value) if value.is_nan() => "none".into(),
        Some(value) if value.is_infinite() => "infinite".into(),
        Some(value) => number(value),
    }
}

fn as_json(kind: Kind) -> Value {
    let properties = kind.properties().iter().map(|p| {
        let above_0 = p.low == f64::MIN_POSITIVE;
        json!({
            "name": p.name,
            "unit": p.unit,
            "needed": p.default.is_none(),
            "default": p.default.filter(|v| v.is_finite()),
            "low": Some(if above_0 { 0.0 } else { p.low }).filter(|v| v.is_finite()),
            "low_excluded": above_0,
            "high": Some(p.high).filter(|v| v.is_finite()),
            "meaning": p.meaning,
        })
    });
    json!({
        "name": kind.name(),
        "meaning": kind.meaning(),
        "properties": properties.collect::<Vec<_>>(),
        "choices": kind.choices().iter().map(|(name, accepts)| json!({"name": name, "accepts": accepts})).collect::<Vec<_>>(),
    })
}
