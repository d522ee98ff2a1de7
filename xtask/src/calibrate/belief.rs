//! From evidence to a probability that keeps its word: the regression behind `dgd-diagnose`'s `belief.rs`.

use super::Case;
use super::logistic::{Fit, chance, fit, logit};
use crate::prove::stats::mean;
use crate::tools;
use serde_json::{Value, json};
use std::collections::BTreeSet;

/// What the logit of the probability grows with.
pub(crate) const NAMES: [&str; 3] = ["constant", "e-fold over hurdle", "logit of the share"];

/// Standard deviation of the prior on each coefficient.
pub(crate) const PRIOR: f64 = 10.0;

/// A finding with what its probability may rest on.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Claim {
    pub(crate) seed: u64,
    /// In the order of [`NAMES`].
    pub(crate) row: Vec<f64>,
    /// Bare probability.
    pub(crate) share: f64,
    pub(crate) right: bool,
}

/// Findings of effects of the catalogue; those called unknown are not calibrated.
pub(crate) fn claims(cases: &[Case]) -> Vec<Claim> {
    let of = |c: &Case| {
        let claim = |f: &crate::prove::answer::Finding| {
            let (evidence, hurdle) = f.evidence.zip(f.hurdle)?;
            let over = (evidence / hurdle.max(1.0)).max(1.0).ln();
            (f.effect != "unknown").then(|| Claim {
                seed: c.seed,
                row: vec![1.0, over, logit(f.probability)],
                share: f.probability,
                right: c.truth.names().any(|t| t == f.effect),
            })
        };
        c.answer
            .findings
            .iter()
            .filter_map(claim)
            .collect::<Vec<_>>()
    };
    cases.iter().flat_map(of).collect()
}

/// What the regression comes to beside the constants now.
pub(crate) struct Belief {
    pub(crate) claims: Vec<Claim>,
    /// The constants of `belief.rs`, if they could be read.
    pub(crate) now: Option<[f64; 3]>,
    pub(crate) fit: Option<Fit>,
    /// By claim, from the other seeds; empty with one seed.
    pub(crate) left_out: Vec<f64>,
}

impl Belief {
    pub(crate) fn of(cases: &[Case], now: Option<[f64; 3]>) -> Belief {
        let claims = claims(cases);
        let rows = |keep: &dyn Fn(&Claim) -> bool| -> Vec<(Vec<f64>, bool)> {
            let kept = claims.iter().filter(|c| keep(c));
            kept.map(|c| (c.row.clone(), c.right)).collect()
        };
        let whole = fit(&rows(&|_| true), PRIOR);
        let seeds: BTreeSet<u64> = claims.iter().map(|c| c.seed).collect();
        let mut left_out = vec![f64::NAN; claims.len()];
        for seed in &seeds {
            let others = fit(&rows(&|c| c.seed != *seed), PRIOR);
            for (p, claim) in left_out.iter_mut().zip(&claims) {
                if let (Some(fit), true) = (&others, claim.seed == *seed) {
                    *p = chance(&fit.coefficients, &claim.row);
                }
            }
        }
        if left_out.iter().any(|p| p.is_nan()) {
            left_out.clear();
        }
        Belief {
            claims,
            now,
            fit: whole,
            left_out,
        }
    }

    /// Forecasts with their truth: bare, by the constants now, and from the other seeds; none of what is not known.
    pub(crate) fn forecasts(&self) -> [Vec<(f64, bool)>; 3] {
        let with = |p: &dyn Fn(&Claim) -> f64| -> Vec<(f64, bool)> {
            self.claims.iter().map(|c| (p(c), c.right)).collect()
        };
        [
            with(&|c| c.share),
            self.now
                .map_or_else(Vec::new, |now| with(&|c| chance(&now, &c.row))),
            self.left_out
                .iter()
                .zip(&self.claims)
                .map(|(p, c)| (*p, c.right))
                .collect(),
        ]
    }

    /// Brier scores of [`Belief::forecasts`].
    pub(crate) fn brier(&self) -> [Option<f64>; 3] {
        self.forecasts().map(|f| {
            let of = |(p, right): &(f64, bool)| (p - f64::from(u8::from(*right))).powi(2);
            mean(&f.iter().map(of).collect::<Vec<f64>>())
        })
    }

    pub(crate) fn json(&self) -> Value {
        let [bare, now, left_out] = self.brier();
        json!({
            "names": NAMES, "now": self.now, "derived": self.fit.as_ref().map(|f| &f.coefficients),
            "standard_errors": self.fit.as_ref().map(|f| &f.errors), "findings": self.claims.len(),
            "right": self.claims.iter().filter(|c| c.right).count(),
            "brier": {"bare": bare, "now": now, "derived_from_other_seeds": left_out},
        })
    }
}

/// The constants as `belief.rs` has them, read from its text: no command tells them.
pub(crate) fn now() -> Option<[f64; 3]> {
    let path = tools::root().join("crates/dgd-diagnose/src/belief.rs");
    constants(&std::fs::read_to_string(path).ok()?)
}

fn constants(source: &str) -> Option<[f64; 3]> {
    let (_, rest) = source.split_once("const CALIBRATION: [f64; 3] = [")?;
    let (list, _) = rest.split_once(']')?;
    let numbers: Option<Vec<f64>> = list
        .split(',')
        .map(str::trim)
        .filter(|n| !n.is_empty())
        .map(|n| n.parse().ok())
        .collect();
    numbers?.try_into().ok()
}

#[cfg(test)]
pub(crate) mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may")]
    use super::super::hurdles::tests::case;
    use super::super::logistic::tests::Draw;
    use super::*;
    use crate::prove::answer::Finding;

    fn finding(effect: &str, evidence: f64, probability: f64) -> Finding {
        Finding {
            effect: effect.into(),
            probability,
            evidence: Some(evidence),
            hurdle: Some(10.0),
            ..Finding::default()
        }
    }

    /// Claims of an influx that are right by a known rule.
    pub(crate) fn claimed(truth: [f64; 3]) -> Vec<Case> {
        let mut draw = Draw(3);
        let mut all = Vec::new();
        for seed in [21, 22, 23] {
            for _ in 0..400 {
                let (over, share) = (3.0 * draw.unit(), 0.5 + 0.49 * draw.unit());
                let right = draw.unit() < chance(&truth, &[1.0, over, logit(share)]);
                let concealed: &[&str] = if right { &["influx"] } else { &[] };
                let mut case = case(seed, concealed, 0.0);
                case.answer.findings = vec![finding("influx", 10.0 * over.exp(), share)];
                all.push(case);
            }
        }
        all
    }

    #[test]
    fn the_rule_by_which_claims_are_right_is_recovered_and_beats_the_bare_share() {
        let truth = [-2.5, 0.8, 0.6];
        let belief = Belief::of(&claimed(truth), Some([4.0, 0.0, 0.0]));
        let fit = belief.fit.as_ref().unwrap();
        for ((found, error), truth) in fit.coefficients.iter().zip(&fit.errors).zip(truth) {
            assert!((found - truth).abs() < 3.0 * error, "{fit:?}");
        }
        let [bare, now, left_out] = belief.brier().map(Option::unwrap);
        assert!(left_out < bare && left_out < now, "{bare} {now} {left_out}");
    }

    #[test]
    fn what_a_claim_rests_on_is_what_belief_counts() {
        let mut one = case(1, &["influx"], 0.0);
        one.answer.findings = vec![
            finding("influx", 10.0 * 1.5_f64.exp(), 0.9),
            finding("heave", 5.0, 0.999),
            finding("unknown", 50.0, 0.9),
        ];
        let claims = claims(&[one]);
        assert_eq!(claims.len(), 2, "what is unknown is not calibrated");
        let close = |a: f64, b: f64| assert!((a - b).abs() < 1e-12, "{a} {b}");
        close(claims[0].row[1], 1.5);
        close(claims[0].row[2], 9.0_f64.ln());
        close(claims[1].row[1], 0.0);
        close(claims[1].row[2], 99.0_f64.ln());
        assert!(claims[0].right && !claims[1].right);
    }

    #[test]
    fn one_seed_leaves_nothing_out() {
        let one: Vec<Case> = claimed([0.0, 1.0, 1.0])
            .into_iter()
            .filter(|c| c.seed == 21)
            .collect();
        let belief = Belief::of(&one, None);
        assert_eq!(belief.brier()[1..], [None, None]);
        assert!(Belief::of(&[], None).fit.is_none());
    }

    #[test]
    fn the_constants_of_the_source_are_found() {
        let text = "const CALIBRATION: [f64; 3] = [-0.9, 0.55,\n 0.5];";
        assert_eq!(constants(text), Some([-0.9, 0.55, 0.5]));
        assert_eq!(constants("const CALIBRATION: [f64; 3] = [1.0];"), None);
        assert_eq!(constants(""), None);
        assert!(now().is_some(), "belief.rs has another form now");
    }
}
