//! The `[augmented]` table of `model.toml`: general curves and the effects that act.

use crate::model::float;
use crate::reader::{Section, Value};
use dgd_effects::{
    About, AppliedEffect, AugmentedModel, Curves, Effect, KNOTS, Laminar, Method, Parameter, Place,
    Quantity, Role, Scale, catalogue, find, find_taking,
};
use std::fmt::Write as _;

/// The knots of a correction that has more of them than it has parameters.
const KNOTS_KEY: &str = "knots";

/// More effects than a diagnosis fits by far; bounds the work on a hostile document.
const MOST_EFFECTS: usize = 64;

const LAMINAR_KEY: &str = "laminar_below_m3_s";
const INDEX_KEY: &str = "laminar_flow_index";

/// Writes the table; parameters go by their names in the catalogue.
pub(crate) fn write_augmented(text: &mut String, model: &AugmentedModel) -> std::fmt::Result {
    let curves = &model.curves;
    writeln!(
        text,
        "\n# Added by a diagnosis: free-form base curves and the effects that act, in SI units. `dgd simulate` runs this.\n\
         # Fitted without the held-out windows, so that they test it; the sizes in the report are of the whole recording."
    )?;
    writeln!(
        text,
        "[augmented]\nflow_scale_m3_s = {}\nspeed_scale_pct = {}",
        float(curves.scale.flow_m3_s),
        float(curves.scale.speed_pct)
    )?;
    if let Some(laminar) = curves.scale.laminar {
        writeln!(
            text,
            "{LAMINAR_KEY} = {} # the line's flow\n{INDEX_KEY} = {} # power of the flow that its friction then goes with",
            float(laminar.below_m3_s),
            float(laminar.index)
        )?;
    }
    writeln!(text, "friction = {} # Pa", list(&curves.friction))?;
    writeln!(text, "head = {} # Pa", list(&curves.head))?;
    let range = |(low, high): (f64, f64)| list(&[low, high]);
    writeln!(text, "speed_range_pct = {}", range(model.speed_range_pct))?;
    writeln!(text, "ratio_range = {} # m3/s/%", range(model.ratio_range))?;
    if let Some(span) = model.span_s {
        writeln!(text, "span_s = {}", range(span))?;
    }
    if let Some(inlet) = model.inlet_range_pa {
        writeln!(text, "inlet_range_pa = {}", range(inlet))?;
    }
    if model.effects.is_empty() {
        return writeln!(text, "effects = []");
    }
    for effect in &model.effects {
        write_effect(text, effect)?;
    }
    Ok(())
}

fn list(values: &[f64]) -> String {
    let values: Vec<String> = values.iter().map(|v| float(*v)).collect();
    format!("[{}]", values.join(", "))
}

fn write_effect(text: &mut String, applied: &AppliedEffect) -> std::fmt::Result {
    let effect = find_taking(&applied.id, applied.parameters.len()).or_else(|| find(&applied.id));
    let names = effect.map_or(&[][..], |effect| effect.about().parameters);
    let goes_on = effect.is_some_and(|effect| effect.takes(names.len() + 1));
    if let Some(effect) = effect {
        writeln!(text, "\n[[augmented.effects]] # {}", effect.about().title)?;
    } else {
        writeln!(text, "\n[[augmented.effects]]")?;
    }
    writeln!(text, "id = {}", crate::well::quoted(&applied.id))?;
    let mut named = applied.parameters.as_slice();
    let mut knots: &[f64] = &[];
    if goes_on && named.len() > names.len() {
        (named, knots) = named.split_at(names.len() - KNOTS);
    }
    let values = named.iter().enumerate().map(|(i, value)| {
        let name = names
            .get(i)
            .map_or_else(|| format!("p{i}"), |p| p.name.to_owned());
        format!("{name} = {}", float(*value))
    });
    let mut values: Vec<String> = values.collect();
    if !knots.is_empty() {
        values.push(format!("{KNOTS_KEY} = {}", list(knots)));
    }
    if values.is_empty() {
        writeln!(text, "parameters = {{}}")
    } else {
        writeln!(text, "parameters = {{ {} }}", values.join(", "))
    }
}

/// Reads the table, noting every problem.
pub(crate) fn read_augmented(section: &Section<'_, '_>) -> Option<AugmentedModel> {
    let scale = |key| {
        let value = section.need(key, "<number>")?;
        let number = section.number(key, value)?;
        if number > 0.0 {
            return Some(number);
        }
        let message = format!("`{key}` is {number}, expected more than 0");
        section.problem(value, message, None);
        None
    };
    let (flow_m3_s, speed_pct) = (scale("flow_scale_m3_s"), scale("speed_scale_pct"));
    let laminar = match section.get(LAMINAR_KEY) {
        Some(_) => match (scale(LAMINAR_KEY), scale(INDEX_KEY)) {
            (Some(below_m3_s), Some(index)) => Some(Some(Laminar { below_m3_s, index })),
            _ => None,
        },
        None => Some(None),
    };
    let friction = numbers(section, "friction");
    let head = numbers(section, "head");
    let range = |key| {
        let [low, high] = numbers(section, key)?;
        if low <= high {
            return Some((low, high));
        }
        let message = format!("`{key}` runs from {low} to {high}, expected the lower one first");
        section.problem(section.get(key)?, message, None);
        None
    };
    let (speed_range_pct, ratio_range) = (range("speed_range_pct"), range("ratio_range"));
    let optional = |key| match section.get(key) {
        Some(_) => range(key).map(Some),
        None => Some(None),
    };
    let (span_s, inlet_range_pa) = (optional("span_s"), optional("inlet_range_pa"));
    let effects = read_effects(section);
    section.warn_of_unread();
    Some(AugmentedModel {
        curves: Curves {
            scale: Scale {
                flow_m3_s: flow_m3_s?,
                speed_pct: speed_pct?,
                laminar: laminar?,
            },
            friction: friction?,
            head: head?,
        },
        speed_range_pct: speed_range_pct?,
        ratio_range: ratio_range?,
        span_s: span_s?,
        inlet_range_pa: inlet_range_pa?,
        effects: effects?,
    })
}

/// A needed list of so many finite numbers.
fn numbers<const N: usize>(section: &Section<'_, '_>, key: &'static str) -> Option<[f64; N]> {
    let value = section.need(key, "[<number>, ...]")?;
    let Some(items) = value.get_ref().as_array() else {
        section.wrong_type(key, value, &format!("a list of {N} numbers"));
        return None;
    };
    if items.len() != N {
        let found = items.len();
        section.problem(
            value,
            format!("`{key}` has {found} numbers, expected {N}"),
            Some("it was written by another version: diagnose the recording again".into()),
        );
        return None;
    }
    // Every number that is none is told, not only the first.
    let read: Vec<Option<f64>> = items.iter().map(|v| section.number(key, v)).collect();
    let read: Option<Vec<f64>> = read.into_iter().collect();
    read?.try_into().ok()
}

/// `[[augmented.effects]]`; none if it is absent.
fn read_effects(section: &Section<'_, '_>) -> Option<Vec<AppliedEffect>> {
    let Some(list) = section.get("effects") else {
        return Some(Vec::new());
    };
    let Some(items) = list.get_ref().as_array() else {
        section.wrong_type("effects", list, "a list of effects, [[augmented.effects]]");
        return None;
    };
    if items.len() > MOST_EFFECTS {
        let found = items.len();
        let message = format!("`effects` has {found} effects, expected at most {MOST_EFFECTS}");
        section.problem(list, message, None);
        return None;
    }
    let read: Vec<Option<AppliedEffect>> = items
        .iter()
        .map(|item| read_effect(section, item))
        .collect();
    read.into_iter().collect()
}

fn read_effect(section: &Section<'_, '_>, item: &Value<'_>) -> Option<AppliedEffect> {
    let Some(table) = item.get_ref().as_table() else {
        section.wrong_type("effects", item, "a table with `id` and `parameters`");
        return None;
    };
    let inner = Section::new("augmented.effects", item.span(), table, section.notes());
    let id = inner.need("id", "\"influx\"");
    let parameters = inner.need_section("parameters");
    inner.warn_of_unread();
    let id = id?;
    let name = inner.text("id", id)?;
    let Some(effect) = find(name) else {
        let ids = catalogue().iter().map(|e| e.about().id);
        let help = nearest(name, ids).map_or_else(
            || "the effects are listed in the README of the catalogue".to_owned(),
            |near| format!("did you mean `{near}`?"),
        );
        inner.problem(
            id,
            format!("effect `{}` is not in the catalogue", short(name)),
            Some(help),
        );
        return None;
    };
    let parameters = parameters?;
    // One that ends is told by its duration.
    let ends = |form: &&'static dyn Effect| {
        let about = form.about();
        (about.duration()).is_some_and(|k| parameters.get(about.parameters[k].name).is_some())
    };
    let effect = effect.passing().filter(ends).unwrap_or(effect);
    Some(AppliedEffect {
        id: name.to_owned(),
        parameters: read_parameters(effect, &parameters)?,
    })
}

/// The parameters of an effect, in the order of its description; what it does not take is refused, as a
/// misspelt name would otherwise go unseen. A correction's knots are named one by one, or stand in one list.
fn read_parameters(effect: &dyn Effect, section: &Section<'_, '_>) -> Option<Vec<f64>> {
    let about = effect.about();
    let mut names: Vec<&'static str> = about.parameters.iter().map(|p| p.name).collect();
    let mut right = true;
    let mut knots = Vec::new();
    let goes_on = effect.takes(names.len() + 1);
    let listed = goes_on.then(|| section.get(KNOTS_KEY)).flatten();
    if let Some(listed) = listed {
        names.truncate(names.len() - KNOTS);
        match read_knots(section, listed) {
            Some(read) => knots = read,
            None => right = false,
        }
    }
    let known = || names.iter().copied();
    let keys = section.keys().into_iter();
    let foreign = (keys.filter(|(key, _)| !known().any(|name| name == *key)))
        .filter(|(key, _)| listed.is_none() || *key != KNOTS_KEY);
    for (key, span) in foreign.take(MOST_EFFECTS) {
        let names: Vec<&str> = known().collect();
        let help = nearest(key, known()).map_or_else(
            || format!("it takes `{}`", names.join("`, `")),
            |near| format!("did you mean `{near}`?"),
        );
        let message = format!("effect `{}` has no parameter `{}`", about.id, short(key));
        section.notes().problem(span, message, Some(help));
        right = false;
    }
    // A shape that is not told is the usual one: earlier models have fewer.
    let usual = |name: &str| {
        let own = about.parameters.iter().find(|p| p.name == name);
        own.filter(|p| !goes_on && matches!(p.role, Role::Shape(_)))
            .map(|p| p.usual)
    };
    let values = known().map(|name| match (section.get(name), usual(name)) {
        (None, Some(usual)) => Some(usual),
        _ => section.need_number(name),
    });
    let values: Vec<Option<f64>> = values.collect();
    let values: Option<Vec<f64>> = values.into_iter().collect();
    let values = values.filter(|_| right)?;
    let checked = known().zip(&values).map(|(name, value)| {
        let codes = codes(about.id, name);
        codes.is_empty() || is_code(section, about.id, name, *value, &codes)
    });
    // All of them, so that every wrong code is told.
    let right = checked.fold(true, |all, right| all & right);
    let bounded = about.parameters.iter().zip(&values);
    let right = bounded.fold(right, |all, (parameter, value)| {
        all & is_within(section, about, parameter, *value)
    });
    right.then_some([values, knots].concat())
}

/// The knots of a correction in one list.
fn read_knots(section: &Section<'_, '_>, listed: &Value<'_>) -> Option<Vec<f64>> {
    let Some(items) = listed.get_ref().as_array() else {
        section.wrong_type(KNOTS_KEY, listed, "a list of numbers");
        return None;
    };
    if items.len() < KNOTS {
        let found = items.len();
        let message = format!("`{KNOTS_KEY}` has {found} numbers, expected {KNOTS} or more");
        section.problem(listed, message, None);
        return None;
    }
    // The first one that is none is told, not a thousand.
    (items.iter())
        .map(|value| section.number(KNOTS_KEY, value))
        .collect()
}

/// What the codes of a parameter stand for, from 0 on; none where it is a quantity.
fn codes(effect: &str, parameter: &str) -> Vec<&'static str> {
    match (effect, parameter) {
        ("unknown", "relation") => Place::ALL.map(Place::name).to_vec(),
        ("unknown", "quantity") => Quantity::ALL.map(Quantity::name).to_vec(),
        _ => Vec::new(),
    }
}

/// Whether a value is one of the codes; a correction whose code is none would act nowhere.
fn is_code(
    section: &Section<'_, '_>,
    effect: &str,
    parameter: &'static str,
    value: f64,
    codes: &[&str],
) -> bool {
    let mut known = (0..codes.len()).map(|code| code as f64);
    let right = known.any(|code| code == value);
    if let Some(written) = section.get(parameter).filter(|_| !right) {
        let last = codes.len() - 1;
        let message = format!(
            "`{parameter}` of effect `{effect}` is {}, expected a code from 0 to {last}",
            float(value)
        );
        let named = codes.iter().enumerate();
        let named: Vec<String> = named.map(|(code, name)| format!("{code} {name}")).collect();
        section.problem(written, message, Some(named.join(", ")));
    }
    right
}

/// Whether a strength or shape is one that the effect's equation has a meaning for: a model with another would run, to any numbers. Times
/// may lie anywhere, and of swell, which moves no run, the measured ones stand.
fn is_within(section: &Section<'_, '_>, about: &About, parameter: &Parameter, value: f64) -> bool {
    let Parameter {
        name, low, high, ..
    } = *parameter;
    let timed = matches!(parameter.role, Role::Onset | Role::Duration(_));
    let right = timed || about.search.method != Method::Relations || (low..=high).contains(&value);
    if let Some(written) = section.get(name).filter(|_| !right) {
        let message = format!(
            "`{name}` of effect `{}` is {}, expected {} to {}",
            about.id,
            float(value),
            float(low),
            float(high)
        );
        let help = format!("it is {}, as the model carries it", parameter.meaning);
        section.problem(written, message, Some(help));
    }
    right
}

/// A name of a length that a message can hold.
fn short(name: &str) -> String {
    const MOST: usize = 60;
    if name.chars().count() <= MOST {
        return name.to_owned();
    }
    name.chars().take(MOST).chain(['…']).collect()
}

/// The candidate that a misspelling of it most likely meant, if one is near.
fn nearest<'a>(name: &str, candidates: impl Iterator<Item = &'a str>) -> Option<&'a str> {
    // Compared at a bounded length: a document may hold anything.
    let name: Vec<char> = name.chars().take(64).collect();
    let (distance, near) = candidates
        .map(|candidate| (distance(&name, candidate), candidate))
        .min_by_key(|(distance, _)| *distance)?;
    (distance <= 2.max(near.len() / 3)).then_some(near)
}

/// Insertions, deletions and replacements from one text to the other (Levenshtein).
fn distance(a: &[char], b: &str) -> usize {
    let mut row: Vec<usize> = (0..=a.len()).collect();
    for (i, cb) in b.chars().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, ca) in a.iter().enumerate() {
            let replaced = diagonal + usize::from(*ca != cb);
            diagonal = row[j + 1];
            row[j + 1] = replaced.min(diagonal + 1).min(row[j] + 1);
        }
    }
    row[a.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearest_name_is_a_few_letters_away_or_none() {
        let names = ["influx", "gas_in_pump", "return_flow_delay"];
        assert_eq!(nearest("inflx", names.into_iter()), Some("influx"));
        assert_eq!(nearest("gas_in_the_pump", names.into_iter()), None);
        assert_eq!(
            nearest("return_flow_dealy", names.into_iter()),
            Some("return_flow_delay")
        );
        assert_eq!(nearest("volcano", names.into_iter()), None);
        assert_eq!(distance(&['a', 'b'], "ba"), 2);
    }
}
