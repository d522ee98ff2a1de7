//! The effects of the model that a diagnosis starts from.

use crate::contest::material;
use crate::diagnosis::{Check, DiagnoseError};
use crate::record::Record;
use crate::refine::fitted_here;
use crate::relations::Applied;
use dgd_effects::AppliedEffect;

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
    let told = given.iter().zip(here).map(|(before, after)| {
        let about = before.effect.about();
        let Some(after) = after else {
            let why = if before.is_correction() {
                "this recording does not show the curve along time"
            } else {
                "this recording contradicts it"
            };
            return format!("{}: {why}; it was left out", about.id);
        };
        if before.is_correction() {
            return format!("{}, a correction", about.id);
        }
        if !acts(after) {
            return format!(
                "{}: its onset and duration lie outside this recording, which cannot confirm it",
                about.id
            );
        }
        let (name, old, new) = (
            about.parameters[0].name,
            before.parameters[0],
            after.parameters[0],
        );
        format!("{}: {name} {old:.3e}, here {new:.3e}", about.id)
    });
    let alike = |(before, after): (&Applied, &Option<Applied>)| {
        let Some(after) = after else {
            return false;
        };
        let (old, new) = (before.parameters[0], after.parameters[0]);
        if !acts(after) {
            return false;
        }
        before.is_correction() || (new - old).abs() <= CHANGE * old.abs()
    };
    Some(Check {
        name: "the effects of the model to start from are as strong here".into(),
        passed: given.iter().zip(here).all(alike),
        detail: told.collect::<Vec<_>>().join("; "),
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
