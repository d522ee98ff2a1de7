//! The effects of the model that a diagnosis starts from.

use super::worse::figures;
use crate::contest::material;
use crate::diagnosis::{Check, DiagnoseError};
use crate::record::Record;
use crate::refine::fitted_here;
use crate::relations::Applied;
use dgd_effects::AppliedEffect;
use dgd_units::Legible;

/// The effects of the model to start from.
pub(super) struct Start {
    /// As the model gives them.
    given: Vec<Applied>,
    /// As they are in this recording; `None` where it holds nothing of them.
    here: Vec<Option<Applied>>,
}

impl Start {
    pub(super) fn here(record: &Record, given: Vec<Applied>) -> Self {
        let here = fitted_here(record, &given, &[]);
        Self { given, here }
    }

    /// Those that this recording holds, as they are in it.
    pub(super) fn known(&self) -> Vec<Applied> {
        self.here.iter().flatten().cloned().collect()
    }

    /// The same as they were given.
    pub(super) fn kept(&self) -> Vec<Applied> {
        let kept = self.given.iter().zip(&self.here);
        let kept = kept.filter(|(_, here)| here.is_some());
        kept.map(|(given, _)| given.clone()).collect()
    }

    /// Whether they are as strong here; `None` if there are none.
    pub(super) fn check(&self, span_s: (f64, f64)) -> Option<Check> {
        refitted(&self.given, &self.here, span_s)
    }
}

/// How the effects of the model to start from came out on this recording, which holds nothing of those that are `None`.
pub(super) fn refitted(
    given: &[Applied],
    here: &[Option<Applied>],
    span_s: (f64, f64),
) -> Option<Check> {
    /// Share by which a strength may change: what is half as strong again, or half as strong, may be something else by now.
    const CHANGE: f64 = 0.5;
    if given.is_empty() {
        return None;
    }
    // What passed before this recording, or sets in after it, does nothing in it.
    let acts = |one: &Applied| {
        let about = one.effect.about();
        let (from, to) = about.interval_s(&one.parameters, span_s);
        about.onset().is_none() || from < to && from < span_s.1 && to > span_s.0
    };
    let outcome = |(before, after): (&Applied, &Option<Applied>)| -> (bool, String) {
        let about = before.effect.about();
        let Some(after) = after else {
            let why = if before.is_correction() {
                "this recording does not show the curve along time"
            } else {
                "this recording contradicts it"
            };
            return (false, format!("{}: {why}; it was left out", about.id));
        };
        if !acts(after) {
            let outside =
                "its onset and duration lie outside this recording, which cannot confirm it";
            return (false, format!("{}: {outside}", about.id));
        }
        if before.is_correction() {
            return (true, format!("{}, a correction", about.id));
        }
        let (old, new) = (before.parameters[0], after.parameters[0]);
        let strength = Legible::of(about.parameters[0].name);
        let Legible { factor, unit, .. } = strength;
        let [shown, here] = figures([factor * old, factor * new]);
        let told = format!("{}: {} {shown} {unit}", about.id, strength.words());
        let told = format!("{}, here {here} {unit}", told.trim_end());
        let alike = (new - old).abs() <= CHANGE * old.abs();
        (alike, told.trim_end().to_owned())
    };
    let outcomes: Vec<(bool, String)> = given.iter().zip(here).map(outcome).collect();
    // What differs comes first: that is what the check failed for.
    let [differing, alike] = [false, true].map(|passed| -> Vec<&str> {
        let those = outcomes.iter().filter(|outcome| outcome.0 == passed);
        those.map(|outcome| outcome.1.as_str()).collect()
    });
    let detail = match (differing.is_empty(), alike.is_empty()) {
        (false, false) => format!("{}; as strong: {}", differing.join("; "), alike.join("; ")),
        (false, true) => differing.join("; "),
        (true, _) => alike.join("; "),
    };
    Some(Check {
        name: "the effects of the model to start from are as strong here".into(),
        passed: alike.len() == outcomes.len(),
        detail,
    })
}

/// What a search starts from where it starts from a model. A model holds what was allowed for in its own recording; here it is
/// allowed for anew.
pub(super) fn from_model(effects: &[AppliedEffect]) -> Result<Vec<Applied>, DiagnoseError> {
    let held = effects.iter().map(applied).collect::<Result<Vec<_>, _>>()?;
    let stays = |a: &Applied| a.effect.about().search.allowance.is_empty() || material(a);
    Ok(held.into_iter().filter(stays).collect())
}

/// An effect of the model to start from, looked up.
fn applied(one: &AppliedEffect) -> Result<Applied, DiagnoseError> {
    Ok(Applied::new(one.look_up()?, one.parameters.clone()))
}
