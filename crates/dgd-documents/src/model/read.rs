//! A model from its text.

use super::{Base, MODEL_SCHEMA, ModelDocument};
use crate::augmented::read_augmented;
use crate::mistaken::{Kind, mistaken};
use crate::reader::{Notes, Section, parse};
use crate::well::read_geometry;
use crate::{DocumentError, Problem};
use dgd_identify::{DataUsed, Estimate, FrictionModel, FrictionTerm, Model, PumpModel};
use dgd_recording::Geometry;
use dgd_units::Dimension;

/// Reads the two-state model of `model.toml` (its schema is in this crate's README).
///
/// Returns the model and warnings about keys that are not read. For whoever knows nothing of effects:
/// a document whose `[augmented]` model has effects is refused, as the two-state model alone would not be
/// what its owner means.
///
/// # Errors
/// [`DocumentError`] with every problem found, each at its place in `source`.
pub fn read_model(source: &str) -> Result<(Model, Vec<Problem>), DocumentError> {
    let (document, warnings) = read_model_document(source)?;
    let place = || {
        let at = source.find("[augmented").unwrap_or(0);
        at..source[at..].find('\n').map_or(source.len(), |end| at + end)
    };
    let refused = |message: String, help: &str| {
        let help = Some(help.to_owned());
        let problem = Problem {
            span: place(),
            message,
            help,
        };
        Err(DocumentError::new(source, vec![problem]))
    };
    let effects = document.augmented.map_or(Vec::new(), |a| a.effects);
    if !effects.is_empty() {
        let ids: Vec<&str> = effects.iter().map(|e| e.id.as_str()).collect();
        return refused(
            format!(
                "the model contains effects ({}), expected a two-state model without effects",
                ids.join(", ")
            ),
            "take the model that `dgd fit` writes",
        );
    }
    match document.base {
        Base::Identified(model) => Ok((*model, warnings)),
        Base::WellOnly { .. } => refused(
            "the model has no [friction], [return_flow_meter] and [pump], expected a two-state model".into(),
            "take the model that `dgd fit` writes",
        ),
    }
}

/// Reads `model.toml` with what a diagnosis added to it (its schema is in this crate's README).
///
/// Returns the document and warnings about keys that are not read.
///
/// # Errors
/// [`DocumentError`] with every problem found, each at its place in `source`.
pub fn read_model_document(source: &str) -> Result<(ModelDocument, Vec<Problem>), DocumentError> {
    let document = parse(source)?;
    mistaken(source, document.get_ref(), Kind::Model)?;
    let notes = Notes::default();
    let root = Section::new("", 0..source.len(), document.get_ref(), &notes);
    check_schema(&root);
    let well = root.need_section("well").and_then(|section| {
        let density = section.need_positive("density", Dimension::Density, "1.08 sg");
        let geometry = read_geometry(&section);
        Some((density?, geometry?))
    });
    let augmented = root.section("augmented");
    let keys = ["friction", "return_flow_meter", "pump"];
    // An augmented model stands without a two-state one, but not with half of one.
    let alone = augmented.is_some() && keys.iter().all(|key| root.get(key).is_none());
    let base = if alone {
        well.map(|(density_kg_m3, geometry)| Base::WellOnly {
            density_kg_m3,
            geometry,
        })
    } else {
        read_base(&root, well).map(|model| Base::Identified(Box::new(model)))
    };
    root.warn_of_unread();
    let augmented = match augmented {
        Some(section) => read_augmented(&section).map(Some),
        None => Some(None),
    };
    let document = match (base, augmented) {
        (Some(base), Some(augmented)) => Some(ModelDocument { base, augmented }),
        _ => None,
    };
    notes.conclude(source, document)
}

/// The sections of the two-state model.
fn read_base(root: &Section<'_, '_>, well: Option<(f64, Geometry)>) -> Option<Model> {
    let friction = root.need_section("friction");
    let meter = root.need_section("return_flow_meter");
    let pump = root.need_section("pump");
    let data = root.section("data");
    let friction = friction.and_then(|section| read_friction(&section));
    let delay_s = meter.and_then(|section| {
        let delay = section.need_number("delay_s");
        section.warn_of_unread();
        delay
    });
    let pump = pump.and_then(|section| read_pump(&section));
    let data = data.map_or_else(DataUsed::default, |section| read_data(&section));
    let (density_kg_m3, geometry) = well?;
    Some(Model {
        density_kg_m3,
        geometry,
        friction: friction?,
        pump: pump?,
        delay_s: delay_s?,
        data,
    })
}

fn check_schema(root: &Section<'_, '_>) {
    let Some(value) = root.need("schema", &format!("\"{MODEL_SCHEMA}\"")) else {
        return;
    };
    if root
        .text("schema", value)
        .is_some_and(|schema| schema != MODEL_SCHEMA)
    {
        let found = value.get_ref().as_str().unwrap_or_default();
        let help = Some("fit the recording again with this version".to_owned());
        root.problem(
            value,
            format!("the schema is `{found}`, expected `{MODEL_SCHEMA}`"),
            help,
        );
    }
}

fn read_estimate(section: &Section<'_, '_>) -> Option<Estimate> {
    let value = section.need_number("value");
    let standard_error = section.optional_statistic("standard_error");
    Some(Estimate {
        value: value?,
        standard_error,
    })
}

fn read_friction(section: &Section<'_, '_>) -> Option<FrictionModel> {
    let statistics = Statistics::read(section, "mse_pa2");
    let list = section.need("term", "[[friction.term]]")?;
    let Some(items) = list.get_ref().as_array() else {
        section.wrong_type("term", list, "a list of terms, [[friction.term]]");
        return None;
    };
    section.warn_of_unread();
    let mut terms = Vec::new();
    for item in items.iter() {
        let Some(table) = item.get_ref().as_table() else {
            section.wrong_type("term", item, "a table with `power` and `value`");
            continue;
        };
        let inner = Section::new("friction.term", item.span(), table, section.notes());
        let place = inner.need("power", "2");
        let power = place.and_then(|value| inner.number("power", value));
        let coefficient = read_estimate(&inner);
        inner.warn_of_unread();
        let (Some(place), Some(power), Some(coefficient)) = (place, power, coefficient) else {
            continue;
        };
        match [0_u8, 1, 2, 3].into_iter().find(|p| f64::from(*p) == power) {
            Some(power) if terms.iter().any(|t: &FrictionTerm| t.power == power) => {
                inner.problem(
                    place,
                    format!("`power` {power} has two terms, expected one"),
                    None,
                );
            }
            Some(power) => terms.push(FrictionTerm { power, coefficient }),
            None => inner.problem(
                place,
                format!("`power` is {power}, expected 0, 1, 2 or 3"),
                None,
            ),
        }
    }
    let complete = terms.len() == items.len();
    terms.sort_by_key(|t| t.power);
    complete.then_some(FrictionModel {
        terms,
        mse_pa2: statistics.mse,
        r2: statistics.r2,
        samples: statistics.samples,
        condition: statistics.condition,
    })
}

fn read_pump(section: &Section<'_, '_>) -> Option<PumpModel> {
    let statistics = Statistics::read(section, "mse_m2");
    let exponent = |key| {
        let value = section.need(key, "2.0")?;
        let n = section.number(key, value)?;
        if n >= 1.0 {
            return Some(n);
        }
        section.problem(value, format!("`{key}` is {n}, expected at least 1"), None);
        None
    };
    let (n0, n2) = (exponent("n0"), exponent("n2"));
    let active_constraints = section
        .get("active_constraints")
        .map(|value| texts(section, "active_constraints", value));
    let coefficient = |key| {
        let inner = section.need_section(key)?;
        let estimate = read_estimate(&inner);
        inner.warn_of_unread();
        estimate
    };
    let (c0, c1, c2) = (coefficient("c0"), coefficient("c1"), coefficient("c2"));
    section.warn_of_unread();
    Some(PumpModel {
        c0: c0?,
        c1: c1?,
        c2: c2?,
        n0: n0?,
        n2: n2?,
        mse_m2: statistics.mse,
        r2: statistics.r2,
        samples: statistics.samples,
        condition: statistics.condition,
        active_constraints: active_constraints.unwrap_or_default(),
    })
}

fn read_data(section: &Section<'_, '_>) -> DataUsed {
    let recordings = section
        .get("recordings")
        .map(|value| texts(section, "recordings", value));
    let samples = section.optional_count("samples");
    let kept = section.optional_count("kept");
    let step_s = section.optional_statistic("step_s");
    let rejected = section.section("rejected").map(|inner| inner.counts());
    section.warn_of_unread();
    let count = |n: Option<u64>| n.and_then(|n| usize::try_from(n).ok()).unwrap_or(0);
    DataUsed {
        recordings: recordings.unwrap_or_default(),
        samples: count(samples),
        kept: count(kept),
        step_s: step_s.unwrap_or(f64::NAN),
        rejected: rejected
            .unwrap_or_default()
            .into_iter()
            .map(|(k, n)| (k, count(Some(n))))
            .collect(),
    }
}

fn texts(section: &Section<'_, '_>, key: &str, value: &crate::reader::Value<'_>) -> Vec<String> {
    let Some(list) = value.get_ref().as_array() else {
        section.wrong_type(key, value, "a list of strings");
        return Vec::new();
    };
    list.iter()
        .filter_map(|item| section.text(key, item).map(str::to_owned))
        .collect()
}

struct Statistics {
    mse: f64,
    r2: f64,
    samples: u64,
    condition: f64,
}

impl Statistics {
    /// How good the fit was: told on, but not needed to simulate, so all may be absent.
    fn read(section: &Section<'_, '_>, mse: &'static str) -> Self {
        let number = |key| section.optional_statistic(key).unwrap_or(f64::NAN);
        Self {
            mse: number(mse),
            r2: number("r2"),
            condition: number("condition"),
            samples: section.optional_count("samples").unwrap_or(0),
        }
    }
}
