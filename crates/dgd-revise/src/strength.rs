//! Strengths that the record does not tell from none.

use crate::baseline::{self, fresh_jacobian};
use crate::choice;
use crate::context::{Context, path};
use crate::estimates::estimates;
use crate::revision::Estimate;
use crate::sets::Scored;
use crate::validate::Folds;
use dgd_assembly::Hypothesis;

/// Standard errors within which a strength is not told from none: a 95 % interval, rounded outwards.
const TOLD: f64 = 2.0;
/// Square that comes back without a member, as a share of what is left, from which on it stays: where a reading jumps with a
/// strength, as with a valve that sticks, its interval says little. Set by hand.
const LARGE: f64 = 1.0;

/// Whether an effect's first parameter, its strength, may as well be what changes nothing.
pub(crate) fn slight(effect: &Hypothesis, estimates: &[Estimate]) -> bool {
    let Some(strength) = effect.parameters.first() else {
        return false;
    };
    let path = path(effect, strength);
    let found = estimates.iter().find(|e| e.path == path);
    found.is_some_and(|e| (e.value - strength.neutral).abs() <= TOLD * e.standard_error)
}

/// The chosen set without the members that may as well be none, the least first, fitted and scored; and those. A single one is left, to be
/// told with a reserve, and so is the whole set if the rest does not stand its placebo.
pub(crate) fn firm(
    context: &Context<'_>,
    memory: usize,
    folds: &Folds,
    scored: &mut Vec<Scored>,
    chosen: usize,
) -> (usize, Vec<usize>) {
    let (mut now, mut gone) = (chosen, Vec::new());
    while let Some((member, rest)) = slightest(context, folds, scored, now) {
        gone.push(member);
        now = rest;
    }
    if gone.is_empty() || !choice::stand(context, memory, folds, scored, now) {
        return (chosen, Vec::new());
    }
    (now, gone)
}

/// The member that may as well be none and is worth least, with the number of the set without it.
fn slightest(
    context: &Context<'_>,
    folds: &Folds,
    scored: &mut Vec<Scored>,
    set: usize,
) -> Option<(usize, usize)> {
    let whole = scored[set].clone();
    if whole.trial.members.len() < 2 {
        return None;
    }
    let jacobian = fresh_jacobian(context, &whole.trial)?;
    let told = estimates(context, &whole.trial, &jacobian, &whole.left);
    let mut least: Option<(f64, usize, usize)> = None;
    for &member in &whole.trial.members {
        if !slight(&context.hypotheses[member], &told) {
            continue;
        }
        let Some(rest) = refit_reduced(context, folds, scored, &whole, member) else {
            continue;
        };
        let loss = scored[rest].left.less(&whole.left).0 / whole.left.mean().max(1e-300);
        if loss < LARGE && least.is_none_or(|l| loss < l.0) {
            least = Some((loss, member, rest));
        }
    }
    least.map(|(_, member, rest)| (member, rest))
}

/// The number of the set without a member, fitted from the values that the others have beside it: what was fitted before may lie in
/// another minimum, and a member that is none would be worth what parts the two.
fn refit_reduced(
    context: &Context<'_>,
    folds: &Folds,
    scored: &mut Vec<Scored>,
    whole: &Scored,
    member: usize,
) -> Option<usize> {
    let rest = whole.trial.others(member);
    let known = scored.iter().position(|s| s.trial.members == rest);
    let trial = context.fit(&rest, &whole.trial.values(), baseline::FULL)?;
    let better = known.is_none_or(|k| trial.cost() < scored[k].trial.cost());
    if !better {
        return known;
    }
    let left = folds.of_trial(context, &trial)?;
    let fresh = Scored { trial, left };
    match known {
        Some(k) => scored[k] = fresh,
        None => scored.push(fresh),
    }
    known.or(Some(scored.len() - 1))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may fail by panic")]

    use super::slight;
    use crate::revision::Estimate;
    use dgd_assembly::{EffectParameter, Hypothesis, effects};

    #[test]
    fn a_strength_whose_interval_holds_no_change_is_slight_and_a_shape_may_be_anything() {
        let parameter = |name, neutral| EffectParameter {
            name,
            low: -1.0,
            high: 1.0,
            neutral,
            usual: 0.1,
        };
        let effect = Hypothesis {
            component: "feed".into(),
            effect: "inflow_step",
            law: effects::find("inflow_step").unwrap(),
            parameters: vec![parameter("step", 0.0), parameter("onset", f64::NAN)],
        };
        let told = |name: &str, value, standard_error| Estimate {
            path: format!("feed.inflow_step.{name}"),
            meaning: String::new(),
            value,
            standard_error,
            ci95: (value - 1.96 * standard_error, value + 1.96 * standard_error),
            at_bound: false,
        };
        let of = |value, error| {
            slight(
                &effect,
                &[told("onset", 0.0, 1.0), told("step", value, error)],
            )
        };
        assert!(of(-0.001, 0.01) && of(0.007_635, 0.003_888));
        assert!(!of(0.0134, 0.0001) && !of(-0.02, 0.009));
        // Not free, so nothing is known against it.
        assert!(!slight(&effect, &[]));
    }
}
