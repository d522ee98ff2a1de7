//! Whether the model that runs holds what was called unknown.

use super::found;
use super::start::from_model;
use crate::diagnosis::{Check, DiagnoseError};
use crate::record::Record;
use crate::refine::fitted_here;
use crate::relations::Applied;
use crate::select::Sought;
use crate::selection::Named;
use dgd_effects::{AppliedEffect, Curve};

/// Searches again from the model that runs, as a diagnosis does that starts from it, where corrections are among what is `named`:
/// the model may have to go without one, or one fitted without the held-out windows may explain too little.
///
/// - `effects`: those of the model.
/// - `most`: how many are fitted together at most.
///
/// A model that holds none of the corrections has nothing to search from. `None` where nothing is called unknown.
pub(super) fn again(
    record: &Record,
    effects: &[AppliedEffect],
    named: &[Named],
    most: usize,
) -> Result<Option<Check>, DiagnoseError> {
    let before = evidence(named.iter());
    if before <= 0.0 {
        return Ok(None);
    }
    if !named.iter().any(|n| holds(effects, n)) {
        return Ok(Some(check(Some(
            "the model does not contain it, and keeps none of the evidence for `unknown`"
                .to_owned(),
        ))));
    }
    let start = fitted_here(record, &from_model(effects)?, &[]);
    let start: Vec<Applied> = start.into_iter().flatten().collect();
    let found = found(record, &start, Sought::Any(most), |_| {});
    Ok(found.map(|found| kept(before, evidence(found.named.iter()))))
}

/// Evidence of the corrections among what is named.
fn evidence<'a>(named: impl Iterator<Item = &'a Named>) -> f64 {
    let corrections = named.filter(|n| n.applied.is_correction());
    corrections.map(|n| n.evidence).sum()
}

/// Whether among the effects is a correction of the same place along the same quantity, with a curve that is not nothing.
fn holds(effects: &[AppliedEffect], named: &Named) -> bool {
    let id = named.applied.id();
    named.applied.curve().is_some_and(|own| {
        let theirs = effects.iter().filter(|e| e.id == id);
        let mut curves = theirs.filter_map(|e| Curve::read(&e.parameters));
        curves.any(|curve| curve.is_alike(&own) && !curve.is_flat())
    })
}

/// What to say of a model that leaves so much of the evidence of its corrections to be found again.
fn kept(before: f64, left: f64) -> Check {
    // Rounded down: what is found again is not kept whole.
    let percent = (100.0 * (1.0 - left / before)).floor().min(99.0);
    let share = if left >= before {
        "none".to_owned()
    } else {
        format!("{percent:.0} %")
    };
    check((left > 0.0).then(|| {
        format!(
            "it explains {share} of the evidence for `unknown`: a diagnosis that starts from it finds `unknown` again"
        )
    }))
}

/// The check, with what is amiss.
fn check(amiss: Option<String>) -> Check {
    let passed = amiss.is_none();
    let sound = || "a diagnosis that starts from it does not find `unknown` again".to_owned();
    Check {
        name: "the model file contains what is called unknown".into(),
        passed,
        detail: amiss.unwrap_or_else(sound),
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may fail by panic")]

    use super::{again, kept};
    use crate::record::Record;
    use crate::select::{Sought, select};
    use crate::test_rig::{Hidden, drilled, named, normals};
    use dgd_effects::{AppliedEffect, Curve, Quantity};

    /// Drilling with two outlet transmitters, of which the second climbs and falls back again and again.
    fn sawing() -> Record {
        let mut record = drilled(Hidden::default());
        let first = record.outlet.clone();
        let noise = normals(11, first.len());
        let second: Vec<f64> = (first.iter().zip(&noise).enumerate())
            .map(|(i, (p, noise))| p + 6e4 * (i % 550) as f64 / 550.0 + 1500.0 * noise)
            .collect();
        let mean = |(a, b): (&f64, &f64)| 0.5 * (a + b);
        record.outlet = first.iter().zip(&second).map(mean).collect();
        record.filled.outlet.clone_from(&record.outlet);
        record.outlets = vec![first, second];
        record
    }

    #[test]
    fn a_model_without_its_correction_is_told_and_one_that_holds_it_is_not() {
        let record = sawing();
        let found = select(&record, &[], Sought::Any(1), |_| {}).unwrap().named;
        let [one] = &found[..] else {
            panic!("{}", found.len());
        };
        assert!(one.applied.is_correction() && one.probability > 0.5);
        let holds = AppliedEffect {
            id: one.applied.id().to_owned(),
            parameters: one.applied.parameters.clone(),
        };
        let check =
            |effects: &[AppliedEffect]| again(&record, effects, &found, 1).unwrap().unwrap();
        let with = check(std::slice::from_ref(&holds));
        assert!(with.passed, "{}", with.detail);
        let curve = one.applied.curve().unwrap();
        let with = |curve: Curve| AppliedEffect {
            id: holds.id.clone(),
            parameters: curve.parameters(),
        };
        let nothing = with(curve.clone().flattened());
        let elsewhere = with(Curve {
            quantity: Quantity::InletPressure,
            ..curve
        });
        let influx = AppliedEffect {
            id: "influx".to_owned(),
            parameters: vec![1e-3, 0.0, 600.0, 0.15],
        };
        for model in [&[][..], &[nothing], &[elsewhere], &[influx]] {
            let without = check(model);
            assert!(!without.passed);
            let none =
                "the model does not contain it, and keeps none of the evidence for `unknown`";
            assert_eq!(without.detail, none);
        }
    }

    #[test]
    fn what_the_catalogue_names_is_not_searched_for_again() {
        let influx = [named("influx", &[1e-3, 0.0, 600.0, 0.15])];
        let record = drilled(Hidden::default());
        assert_eq!(again(&record, &[], &influx, 1).unwrap(), None);
    }

    #[test]
    fn the_share_that_is_kept_is_told() {
        let some = kept(400.0, 100.0);
        assert!(
            !some.passed && some.detail.contains("it explains 75 %"),
            "{}",
            some.detail
        );
        // More may be left than was there, where the model leads the search elsewhere.
        for (left, told) in [
            (120.0, "none"),
            (100.0, "none"),
            (99.9, "0 %"),
            (0.9, "99 %"),
            (1e-20, "99 %"),
        ] {
            let check = kept(100.0, left);
            assert!(!check.passed);
            let told = format!("it explains {told} of the evidence");
            assert!(check.detail.contains(&told), "{}", check.detail);
        }
        assert!(kept(100.0, 0.0).passed);
    }
}
