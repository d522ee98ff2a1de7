//! What an effect must show before it is believed: what clean recordings hardly ever show.

use super::Case;
use super::tail::Tail;
use crate::prove::answer::{EFFECTS, Tested};
use crate::prove::stats::{Tally, quantile};
use crate::prove::truth::Sort;
use serde_json::{Value, json};
use std::collections::BTreeSet;

/// A Bayes factor of less than e is no evidence, whatever clean recordings show.
const LEAST: f64 = 1.0;

/// Evidence of one effect.
pub(crate) struct Hurdle {
    pub(crate) effect: &'static str,
    /// The hurdle in the catalogue now.
    pub(crate) now: Option<f64>,
    /// Evidence in the clean recordings that can show it, where it might be named.
    pub(crate) clean: Vec<f64>,
    /// Clean recordings in which its size, bounds or place forbid to name it.
    pub(crate) forbidden: usize,
    /// Evidence where it alone is concealed.
    pub(crate) own: Vec<f64>,
    pub(crate) tail: Option<Tail>,
    /// At which clean recordings may exceed its hurdle.
    rate: f64,
}

/// By which rule hurdles follow from clean recordings.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Rule {
    /// Of clean recordings that may raise an alarm, over the whole catalogue; each effect gets its even part.
    pub(crate) rate: f64,
    /// Share of the values below the tail.
    pub(crate) below: f64,
}

impl Hurdle {
    fn of(effect: &'static str, cases: &[&Case], rule: Rule) -> Hurdle {
        let told = |c: &Case| {
            let tested = c.answer.tested.iter().find(|t| t.effect == effect);
            tested.filter(|t| t.testable).cloned()
        };
        // The least that was asked: where the suction may lose unseen it was more.
        let asked = cases.iter().filter_map(|c| told(c)?.hurdle);
        let now = asked.min_by(f64::total_cmp);
        // What may not be named stands above no hurdle.
        let evidence = |c: &&Case| {
            let told = told(c)?;
            let evidence = shown(&told, now)?;
            Some(if told.admissible {
                evidence
            } else {
                f64::NEG_INFINITY
            })
        };
        let clean = cases.iter().filter(|c| c.truth.sort() == Sort::Clean);
        let own = cases
            .iter()
            .filter(|c| c.truth.sort() == Sort::Single && c.truth.names().eq([effect]));
        let (clean, forbidden): (Vec<f64>, Vec<f64>) = clean
            .filter_map(evidence)
            .partition(|e| *e > f64::NEG_INFINITY);
        Hurdle {
            effect,
            now,
            tail: Tail::of(&clean, forbidden.len(), rule.below),
            clean,
            forbidden: forbidden.len(),
            own: own.filter_map(evidence).collect(),
            rate: rule.rate,
        }
    }

    /// The evidence that clean recordings exceed at the rate; `None` where they tell too little.
    pub(crate) fn derived(&self) -> Option<f64> {
        Some(self.tail?.exceeded_at(self.rate).max(LEAST))
    }

    /// Its standard error.
    pub(crate) fn error(&self) -> Option<f64> {
        Some(self.tail?.error_at(self.rate))
    }

    /// Clean recordings above a hurdle.
    pub(crate) fn above(&self, hurdle: f64) -> usize {
        self.clean.iter().filter(|e| **e > hurdle).count()
    }

    /// Recordings with this effect alone that stand above a hurdle.
    pub(crate) fn power(&self, hurdle: f64) -> Tally {
        let mut power = Tally::default();
        self.own.iter().for_each(|e| power.add(*e > hurdle));
        power
    }
}

/// Every effect of the catalogue.
pub(crate) struct Hurdles {
    pub(crate) effects: Vec<Hurdle>,
    /// Clean recordings.
    pub(crate) clean: usize,
    /// At which they may exceed the hurdle of one effect.
    pub(crate) rate: f64,
    /// Clean recordings in which some effect exceeds its hurdle of now.
    pub(crate) alarms_now: Tally,
    /// The same with hurdles derived from the other seeds.
    pub(crate) alarms_left_out: Tally,
}

impl Hurdles {
    /// Of all recordings, and of those of all seeds but one in turn.
    pub(crate) fn of(cases: &[Case], rule: Rule) -> Hurdles {
        let names = &EFFECTS[..EFFECTS.len() - 1];
        let rule = Rule {
            rate: rule.rate / names.len() as f64,
            ..rule
        };
        let from = |cases: &[&Case]| -> Vec<Hurdle> {
            let of = |effect: &&'static str| Hurdle::of(effect, cases, rule);
            names.iter().map(of).collect()
        };
        let all: Vec<&Case> = cases.iter().collect();
        let effects = from(&all);
        let clean: Vec<&Case> = all
            .iter()
            .copied()
            .filter(|c| c.truth.sort() == Sort::Clean)
            .collect();
        let mut alarms_now = Tally::default();
        for case in &clean {
            alarms_now.add(alarm(case, &effects, |h| h.now));
        }
        let mut alarms_left_out = Tally::default();
        let seeds: BTreeSet<u64> = clean.iter().map(|c| c.seed).collect();
        for seed in seeds.iter().filter(|_| seeds.len() > 1) {
            let others: Vec<&Case> = clean.iter().copied().filter(|c| c.seed != *seed).collect();
            let others = from(&others);
            if others.iter().all(|h| h.derived().is_none()) {
                continue;
            }
            for case in clean.iter().filter(|c| c.seed == *seed) {
                alarms_left_out.add(alarm(case, &others, Hurdle::derived));
            }
        }
        Hurdles {
            effects,
            clean: clean.len(),
            rate: rule.rate,
            alarms_now,
            alarms_left_out,
        }
    }

    pub(crate) fn json(&self) -> Value {
        let tally = |t: Tally| json!({"right": t.right, "of": t.of, "share": t.share(), "wilson95": t.interval()});
        let effect = |h: &Hurdle| {
            json!({
                "effect": h.effect, "clean_forbidden": h.forbidden, "now": h.now, "derived": h.derived(), "standard_error": h.error(), "clean": h.clean.len(),
                "threshold": h.tail.map(|t| t.threshold), "scale": h.tail.map(|t| t.scale), "above_threshold": h.tail.map(|t| t.above),
                "spread": h.tail.map(|t| t.spread), "largest": quantile(&h.clean, 1.0),
                "clean_above_now": h.now.map(|v| h.above(v)), "clean_above_derived": h.derived().map(|v| h.above(v)),
                "own": h.own.len(), "own_above_now": h.now.map(|v| h.power(v).right),
                "own_above_derived": h.derived().map(|v| h.power(v).right),
            })
        };
        json!({
            "rate_by_effect": self.rate, "effects": self.effects.iter().map(effect).collect::<Vec<_>>(),
            "clean_with_evidence_above_now": tally(self.alarms_now),
            "clean_with_evidence_above_derived_from_other_seeds": tally(self.alarms_left_out),
        })
    }
}

/// Evidence of an effect, less what was asked of it beyond a hurdle: what the suction may lose unseen is no evidence.
fn shown(tested: &Tested, hurdle: Option<f64>) -> Option<f64> {
    let more = (tested.hurdle.zip(hurdle)).map_or(0.0, |(asked, hurdle)| asked - hurdle);
    Some(tested.evidence? - more)
}

/// Whether some effect shows more than its hurdle.
fn alarm(case: &Case, hurdles: &[Hurdle], pick: impl Fn(&Hurdle) -> Option<f64>) -> bool {
    hurdles.iter().any(|h| {
        let mut tested = case.answer.tested.iter();
        let own = tested.find(|t| t.effect == h.effect && t.testable && t.admissible);
        let evidence = own.and_then(|t| shown(t, h.now));
        evidence.zip(pick(h)).is_some_and(|(e, hurdle)| e > hurdle)
    })
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::calibrate::logistic::tests::Draw;
    use crate::prove::answer::{Answer, Tested};
    use crate::prove::truth::{Concealed, Truth};

    pub(crate) const RULE: Rule = Rule {
        rate: 0.02,
        below: 0.8,
    };

    /// A recording in which an influx shows this evidence.
    pub(crate) fn case(seed: u64, concealed: &[&str], evidence: f64) -> Case {
        let effects = concealed.iter().map(|e| Concealed {
            effect: (*e).into(),
            severity: "moderate".into(),
            ..Concealed::default()
        });
        Case {
            seed,
            level: 2,
            truth: Truth {
                hours: 4.0,
                well: "gom".into(),
                effects: effects.collect(),
            },
            answer: Answer {
                verdict: "consistent".into(),
                tested: vec![Tested {
                    effect: "influx".into(),
                    testable: true,
                    admissible: true,
                    evidence: Some(evidence),
                    hurdle: Some(8.0),
                    ..Tested::default()
                }],
                ..Answer::default()
            },
        }
    }

    /// Three seeds of clean recordings with an exponential tail of scale 1 from -2 on, and some with an influx.
    pub(crate) fn cases() -> Vec<Case> {
        let mut draw = Draw(5);
        let mut all = Vec::new();
        for seed in [11, 12, 13] {
            all.extend((0..100).map(|_| case(seed, &[], -2.0 - (1.0 - draw.unit()).ln())));
            all.extend([6.0, 9.0, 40.0].map(|e| case(seed, &["influx"], e)));
            all.push(case(seed, &["heave"], 100.0));
        }
        all
    }

    fn influx(hurdles: &Hurdles) -> Option<&Hurdle> {
        hurdles.effects.iter().find(|h| h.effect == "influx")
    }

    #[test]
    fn the_hurdle_follows_from_clean_recordings_alone() {
        let hurdles = Hurdles::of(&cases(), RULE);
        let influx = influx(&hurdles);
        let derived = influx.and_then(Hurdle::derived).unwrap_or(f64::NAN);
        // -2 + ln 1200
        let error = influx.and_then(Hurdle::error).unwrap_or(f64::NAN);
        assert!((derived - 5.09).abs() < 3.0 * error, "{derived} {error}");
        assert!(error < 1.0, "{error}");
        assert_eq!(influx.map(|h| h.clean.len()), Some(300));
        assert_eq!(influx.and_then(|h| h.now), Some(8.0));
        // Of 6, 9 and 40 the first stands below 8, in three seeds.
        assert_eq!(
            influx.map(|h| h.power(8.0)),
            Some(Tally { right: 6, of: 9 })
        );
        assert_eq!(hurdles.clean, 300);
        assert_eq!(hurdles.alarms_now, Tally { right: 0, of: 300 });
        assert_eq!(hurdles.alarms_left_out.of, 300);
    }

    #[test]
    fn an_effect_of_which_nothing_is_told_has_no_hurdle() {
        let hurdles = Hurdles::of(&cases(), RULE);
        let heave = hurdles.effects.iter().find(|h| h.effect == "heave");
        assert_eq!(heave.and_then(Hurdle::derived), None);
        assert_eq!(heave.and_then(|h| h.now), None);
    }

    #[test]
    fn a_recording_that_cannot_show_an_effect_is_no_evidence_against_it() {
        let mut all = cases();
        for case in &mut all {
            case.answer.tested[0].testable = false;
        }
        let hurdles = Hurdles::of(&all, RULE);
        assert_eq!(influx(&hurdles).map(|h| h.clean.len()), Some(0));
        assert_eq!(hurdles.alarms_left_out.right, 0);
    }

    #[test]
    fn what_may_not_be_named_raises_no_alarm() {
        let mut all = cases();
        all.extend((0..30).map(|k| case(11, &[], 60.0 + f64::from(k))));
        let loud = Hurdles::of(&all, RULE);
        for case in &mut all {
            let tested = &mut case.answer.tested[0];
            tested.admissible = tested.evidence < Some(50.0);
        }
        let quiet = Hurdles::of(&all, RULE);
        assert_eq!(loud.alarms_now.right, 30);
        assert_eq!(quiet.alarms_now, Tally { right: 0, of: 330 });
        assert_eq!(influx(&quiet).map(|h| h.forbidden), Some(30));
        let of = |h: &Hurdles| influx(h).and_then(Hurdle::derived).unwrap_or(f64::NAN);
        assert!(of(&quiet) < 8.0 && of(&loud) > 60.0);
    }

    #[test]
    fn no_hurdle_lies_where_there_is_no_evidence() {
        let mut all = cases();
        for case in &mut all {
            case.answer.tested[0].evidence = case.answer.tested[0].evidence.map(|e| e - 50.0);
        }
        let hurdles = Hurdles::of(&all, RULE);
        assert_eq!(influx(&hurdles).and_then(Hurdle::derived), Some(LEAST));
    }

    #[test]
    fn one_seed_alone_leaves_nothing_to_check_on() {
        let one: Vec<Case> = cases().into_iter().filter(|c| c.seed == 11).collect();
        assert_eq!(Hurdles::of(&one, RULE).alarms_left_out.of, 0);
        let few = [11, 12].map(|seed| case(seed, &[], 0.0));
        assert_eq!(Hurdles::of(&few, RULE).alarms_left_out.of, 0);
    }
}
