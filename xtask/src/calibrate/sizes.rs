//! How well sizes are told: the shares that widen intervals in the catalogue of `dgd-effects` (`Search::size_error`).

use super::Case;
use crate::prove::answer::{EFFECTS, Estimate};
use crate::prove::stats::{Tally, quantile};
use crate::tools;
use anyhow::{Context, Result};
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::path::Path;
use std::process::Command;

/// Share of the intervals that should hold what was concealed.
const COVERED: f64 = 0.95;
/// Standard deviations to either side of an interval of that share.
const Z: f64 = 1.96;
/// Factor on bare standard errors, as the estimates have it.
pub(crate) const WIDENING: f64 = 2.0;
/// Fewer sizes than this tell nothing of the twentieth that an interval may miss.
const LEAST: usize = 10;

/// A size as it was told, and as it was concealed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Told {
    /// Told less concealed, as a share of what was told; above 1 where it has the other sign.
    pub(crate) error: f64,
    /// The bare standard error, as a share of the same.
    pub(crate) bare: f64,
}

impl Told {
    /// Of an estimate whose truth is known; a gain's size is its distance from 1.
    fn of(name: &str, estimate: &Estimate, truth: f64) -> Option<Told> {
        let (low, high) = estimate.ci95?;
        let neutral = if name == "gain" { 1.0 } else { 0.0 };
        let size = (estimate.value - neutral).abs();
        (size > 0.0).then(|| Told {
            error: 1.0 - (truth - neutral) / (estimate.value - neutral),
            bare: 0.5 * (high - low) / Z / size,
        })
    }

    /// How wide the interval must be, in shares of the size, to hold the truth: smaller sizes are so many times smaller.
    fn off(&self) -> f64 {
        if self.error > 0.0 {
            -(-self.error.min(1.0)).ln_1p()
        } else {
            -self.error
        }
    }

    /// Whether the interval holds the truth.
    fn held(&self, share: f64) -> bool {
        self.off() <= Z * (WIDENING * self.bare).hypot(share)
    }

    /// The least share with which it does.
    fn needs(&self) -> f64 {
        let beyond = (self.off() / Z).powi(2) - (WIDENING * self.bare).powi(2);
        beyond.max(0.0).sqrt()
    }
}

/// What was told of one effect's size.
pub(crate) struct Size {
    pub(crate) effect: &'static str,
    /// The share in the catalogue now.
    pub(crate) now: f64,
    pub(crate) told: Vec<Told>,
}

impl Size {
    /// The least share with which as many intervals as should hold the truth; `None` where too few sizes tell.
    pub(crate) fn derived(&self) -> Option<f64> {
        let needs: Vec<f64> = self.told.iter().map(Told::needs).collect();
        (needs.len() >= LEAST).then_some(())?;
        quantile(&needs, COVERED)
    }

    /// Intervals that hold the truth by the share now.
    pub(crate) fn held(&self) -> Tally {
        let mut held = Tally::default();
        (self.told.iter()).for_each(|t| held.add(t.held(self.now)));
        held
    }

    /// The median error, as a share of what was told.
    pub(crate) fn typical(&self) -> Option<f64> {
        let errors: Vec<f64> = self.told.iter().map(|t| t.error.abs()).collect();
        quantile(&errors, 0.5)
    }
}

/// Sizes of the effects that were concealed and found.
pub(crate) struct Sizes {
    pub(crate) effects: Vec<Size>,
}

impl Sizes {
    /// Of answers without calibration; `now` has the shares of the catalogue.
    pub(crate) fn of(cases: &[Case], now: &BTreeMap<String, f64>) -> Sizes {
        let of = |effect: &'static str| Size {
            effect,
            now: now.get(effect).copied().unwrap_or_default(),
            told: cases.iter().flat_map(|c| told(c, effect)).collect(),
        };
        // What is found in the spectrum has no share: its interval is another's.
        let widened = EFFECTS.iter().filter(|effect| now.contains_key(**effect));
        let effects = widened.map(|effect| of(effect));
        Sizes {
            effects: effects.filter(|s| !s.told.is_empty()).collect(),
        }
    }

    /// All intervals by the shares now.
    pub(crate) fn held(&self) -> Tally {
        let held: Vec<Tally> = self.effects.iter().map(Size::held).collect();
        Tally {
            right: held.iter().map(|t| t.right).sum(),
            of: held.iter().map(|t| t.of).sum(),
        }
    }

    pub(crate) fn json(&self) -> Value {
        let of = |s: &Size| {
            json!({
                "effect": s.effect, "sizes": s.told.len(), "now": s.now, "derived": s.derived(),
                "median_error": s.typical(), "held_now": s.held().right,
            })
        };
        json!({ "widening": WIDENING, "effects": self.effects.iter().map(of).collect::<Vec<_>>() })
    }
}

/// What a case tells of an effect's size, where it was concealed and claimed.
fn told(case: &Case, effect: &str) -> Vec<Told> {
    let concealed = case.truth.effects.iter().find(|e| e.effect == effect);
    let claimed = case.answer.claimed().find(|f| f.effect == effect);
    let (Some(truth), Some(claimed)) = (concealed, claimed) else {
        return Vec::new();
    };
    let of = |(name, value): &(String, f64)| {
        // Which transmitter it is has no size.
        let sized = claimed
            .parameters
            .iter()
            .find(|p| p.name == *name && name != "sensor");
        Told::of(name, sized?, *value)
    };
    // The plant knows some sizes that are not scored.
    truth
        .parameters
        .iter()
        .chain(&truth.extra)
        .filter_map(of)
        .collect()
}

/// The shares of the catalogue, as `dgd catalogue --json` lists them.
pub(crate) fn now(dgd: &Path) -> Result<BTreeMap<String, f64>> {
    let mut command = Command::new(dgd);
    let listed = tools::run_json(command.args(["catalogue", "--json"]))?;
    let effects = listed["effects"]
        .as_array()
        .context("no effects are listed")?;
    let of = |e: &Value| Some((e["effect"].as_str()?.to_owned(), e["size_error"].as_f64()?));
    Ok(effects.iter().filter_map(of).collect())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may")]
    use super::*;
    use crate::prove::answer::{Answer, Finding};
    use crate::prove::truth::{Concealed, Truth};

    fn estimate(name: &str, value: f64, sd: f64) -> Estimate {
        Estimate {
            name: name.into(),
            value,
            ci95: Some((value - Z * sd, value + Z * sd)),
        }
    }

    /// A case whose effect was concealed with one size and told with another.
    fn case(effect: &str, concealed: (&str, f64), told: Estimate) -> Case {
        Case {
            seed: 11,
            level: 1,
            truth: Truth {
                hours: 6.0,
                well: String::new(),
                effects: vec![Concealed {
                    effect: effect.into(),
                    extra: vec![(concealed.0.into(), concealed.1)],
                    parameters: vec![("sensor".into(), 2.0)],
                    ..Concealed::default()
                }],
            },
            answer: Answer {
                verdict: "explained".into(),
                findings: vec![Finding {
                    effect: effect.into(),
                    probability: 0.9,
                    parameters: vec![told, estimate("sensor", 1.0, 0.0)],
                    ..Finding::default()
                }],
                tested: Vec::new(),
            },
        }
    }

    #[test]
    fn the_factor_is_that_of_the_estimates() {
        let path = tools::root().join("crates/dgd-diagnose/src/estimates.rs");
        let source = std::fs::read_to_string(path).unwrap();
        assert!(source.contains(&format!("const WIDENING: f64 = {WIDENING:?};")));
    }

    #[test]
    fn a_share_covers_what_noise_does_not_and_a_gain_is_measured_from_one() {
        // Told a tenth too large, with nothing but noise to show for it: a tenth over 1.96 is needed.
        let off = case(
            "influx",
            ("rate_m3_s", 0.9),
            estimate("rate_m3_s", 1.0, 0.0),
        );
        let gain = case(
            "inflow_gain",
            ("gain", 1.03),
            estimate("gain", 1.04, 0.012 / 1.96 / WIDENING),
        );
        let now = BTreeMap::from([("influx".to_owned(), 0.05), ("inflow_gain".to_owned(), 0.0)]);
        let sizes = Sizes::of(&[off, gain], &now);
        let [gain, influx] = &sizes.effects[..] else {
            panic!("{}", sizes.effects.len());
        };
        assert_eq!((gain.effect, influx.effect), ("inflow_gain", "influx"));
        assert!((influx.told[0].needs() + 0.9_f64.ln() / Z).abs() < 1e-12);
        assert_eq!((influx.now, influx.held().right), (0.05, 0));
        assert!((gain.typical().unwrap() - 0.25).abs() < 1e-9);
        assert!(gain.told[0].needs() < 1e-3);
        assert_eq!(sizes.held(), Tally { right: 1, of: 2 });
        // One size tells nothing of a twentieth.
        assert_eq!(influx.derived(), None);
    }

    #[test]
    fn nineteen_of_twenty_are_covered_by_the_share_that_is_derived() {
        let cases: Vec<Case> = (1..=21)
            .map(|k| {
                let told = estimate("tau_s", 1.0, 0.0);
                case("u_tube", ("tau_s", 1.0 - 0.01 * k as f64), told)
            })
            .collect();
        let sizes = Sizes::of(&cases, &BTreeMap::from([("u_tube".to_owned(), 0.0)]));
        let derived = sizes.effects[0].derived().unwrap();
        assert!((derived + 0.8_f64.ln() / Z).abs() < 1e-9, "{derived}");
        let held = |share: f64| {
            sizes.effects[0]
                .told
                .iter()
                .filter(|t| t.held(share))
                .count()
        };
        assert_eq!((held(1.001 * derived), held(0.0)), (20, 0));
    }
}
