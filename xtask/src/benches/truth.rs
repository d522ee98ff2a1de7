//! What was concealed; read after the last diagnosis.

use anyhow::{Context, Result};
use serde_json::Value;
use std::collections::BTreeMap;

/// A truth.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Truth {
    pub(crate) id: String,
    pub(crate) bench: String,
    /// `None` in a clean case.
    pub(crate) concealed: Option<Concealed>,
    /// What noise and steps alone add on held-out samples, by instrument.
    pub(crate) floor: BTreeMap<String, f64>,
}

/// One concealed thing.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Concealed {
    pub(crate) thing: String,
    pub(crate) severity: String,
    /// Kind of the component that it sits on, or `foreign`.
    pub(crate) kind: String,
    /// Components that it can be said to sit on.
    pub(crate) components: Vec<String>,
    /// Its size, by the plant's names.
    pub(crate) size: BTreeMap<String, f64>,
}

impl Truth {
    pub(crate) fn read(bytes: &[u8]) -> Result<Truth> {
        let json: Value = serde_json::from_slice(bytes).context("is no JSON")?;
        let text = |value: &Value, name: &str| {
            let text = value[name].as_str().map(str::to_owned);
            text.with_context(|| format!("`{name}` is missing"))
        };
        let concealed = match &json["concealed"] {
            Value::Null => None,
            value => {
                let components = value["components"].as_array();
                let components = components.context("`components` is missing")?.iter();
                let size = value["size"].as_object().into_iter().flatten();
                let size = size.filter_map(|(name, v)| Some((name.clone(), v.as_f64()?)));
                Some(Concealed {
                    thing: text(value, "thing")?,
                    severity: text(value, "severity")?,
                    kind: text(value, "kind")?,
                    components: components
                        .filter_map(Value::as_str)
                        .map(str::to_owned)
                        .collect(),
                    size: size.collect(),
                })
            }
        };
        let outputs = json["outputs"]
            .as_object()
            .context("`outputs` is missing")?;
        let floor = |(name, output): (&String, &Value)| {
            let floor = output["floor_held_out"].as_f64();
            let floor = floor.with_context(|| format!("`{name}` has no floor"))?;
            Ok((name.clone(), floor))
        };
        Ok(Truth {
            id: text(&json, "id")?,
            bench: text(&json, "bench")?,
            concealed,
            floor: outputs.iter().map(floor).collect::<Result<_>>()?,
        })
    }
}
