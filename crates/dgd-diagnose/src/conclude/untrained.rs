//! Causes of which the samples outside the held-out windows show nothing: the model that runs is without them.

use crate::diagnosis::Check;
use crate::selection::Named;
use dgd_effects::AppliedEffect;

/// Whether the model that was trained without the held-out windows gives a cause no size.
pub(super) fn is_untrained(named: &Named, trained: &[AppliedEffect]) -> bool {
    let id = named.applied.id();
    let without_size =
        |e: &AppliedEffect| e.id == id && e.parameters.first().is_some_and(|size| *size == 0.0);
    !named.applied.is_correction() && !named.has_no_size() && trained.iter().any(without_size)
}

/// That they are in the answer and not in the model; `None` where there are none.
pub(super) fn check(named: &[Named], trained: &[AppliedEffect]) -> Option<Check> {
    let ids: Vec<&str> = (named.iter())
        .filter(|n| is_untrained(n, trained))
        .map(|n| n.applied.id())
        .collect();
    (!ids.is_empty()).then(|| Check {
        name: "each cause shows outside the held-out windows too".into(),
        passed: false,
        detail: format!(
            "{}: without the held-out windows the size is 0, so that the model that runs is without it and its gain there is not tested",
            ids.join(", ")
        ),
    })
}

#[cfg(test)]
mod tests {
    use super::{check, is_untrained};
    use crate::test_rig::named;
    use dgd_effects::AppliedEffect;

    #[test]
    fn a_cause_that_the_trained_model_is_without_is_told() {
        let trained = |id: &str, size: f64| AppliedEffect {
            id: id.to_owned(),
            parameters: vec![size, 4.0],
        };
        let model = [trained("pump_wear", 0.0), trained("influx", 2e-3)];
        let found = [
            named("pump_wear", &[3e-3, 0.0]),
            named("influx", &[2e-3, 4e3, 1e3, 0.15]),
            named("annulus_area", &[0.05]),
        ];
        let untrained = found.each_ref().map(|n| is_untrained(n, &model));
        assert_eq!(untrained, [true, false, false]);
        let told = check(&found, &model);
        assert!(told.is_some_and(|c| !c.passed && c.detail.starts_with("pump_wear: ")));
        assert_eq!(check(&found[1..], &model), None);
        // What was refined to nothing on the whole recording says so itself.
        assert!(!is_untrained(&named("pump_wear", &[0.0, 0.0]), &model));
    }
}
