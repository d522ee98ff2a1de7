//! One answer held against its truth.

use super::answer::{Answer, Finding};
use super::targets::{CONFIDENT, STATED};
use super::truth::{Concealed, Truth};

/// What one answer is worth. Of a run that gave none, nothing is found.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Marks {
    /// Effects claimed.
    pub(crate) found: Vec<String>,
    /// Effects claimed that are not there.
    pub(crate) extra: Vec<String>,
    /// The set claimed is the set concealed.
    pub(crate) exact: bool,
    /// By effect concealed: claimed.
    pub(crate) hit: Vec<bool>,
    /// By effect concealed: claimed or among the alternatives stated.
    pub(crate) within: Vec<bool>,
    pub(crate) verdict_right: bool,
    /// Probability and truth of each finding.
    pub(crate) forecasts: Vec<(f64, bool)>,
    /// Effects concealed of which no finding speaks.
    pub(crate) passed_over: usize,
    /// Of the effects claimed rightly.
    pub(crate) relation: Vec<bool>,
    /// Overlap by effect that has an interval and was claimed rightly.
    pub(crate) overlap: Vec<f64>,
    pub(crate) parameters: Vec<ParameterMark>,
    /// Whether the right transmitter was named.
    pub(crate) sensor: Option<bool>,
}

#[derive(Debug, Clone, PartialEq)]
pub(crate) struct ParameterMark {
    pub(crate) effect: String,
    pub(crate) name: String,
    /// Relative error; of a gain, relative to its distance from one. `None`: not given.
    pub(crate) error: Option<f64>,
    /// Whether the 95 % interval holds the truth.
    pub(crate) covered: bool,
}

/// Scores an answer; `None` stands for a run that gave none.
pub(crate) fn mark(truth: &Truth, answer: Option<&Answer>) -> Marks {
    let Some(answer) = answer else {
        let nothing = || vec![false; truth.effects.len()];
        return Marks {
            hit: nothing(),
            within: nothing(),
            passed_over: truth.effects.len(),
            ..Marks::default()
        };
    };
    let found: Vec<String> = answer.claimed().map(|f| f.effect.clone()).collect();
    let concealed = |effect: &str| truth.names().any(|t| t == effect);
    let extra: Vec<String> = found.iter().filter(|f| !concealed(f)).cloned().collect();
    // What comes again is named as often.
    let hit: Vec<bool> = (truth.effects.iter())
        .map(|t| found.iter().filter(|f| **f == t.effect).count() >= t.times())
        .collect();
    let named = |f: &Finding, t: &str| f.effect == t;
    let stated = |f: &Finding, t: &str| f.alternatives.iter().any(|(a, p)| a == t && *p >= STATED);
    let within = |t: &str| {
        let mut findings = answer.findings.iter();
        findings.any(|f| named(f, t) || stated(f, t))
    };
    let mut marks = Marks {
        exact: extra.is_empty() && hit.iter().all(|h| *h),
        within: truth.names().map(within).collect(),
        verdict_right: verdict_right(truth, answer, &found),
        forecasts: answer
            .findings
            .iter()
            .map(|f| (f.probability, concealed(&f.effect)))
            .collect(),
        passed_over: truth
            .names()
            .filter(|t| !answer.findings.iter().any(|f| named(f, t)))
            .count(),
        found,
        extra,
        hit,
        ..Marks::default()
    };
    for effect in &truth.effects {
        let claimed = answer.claimed().filter(|f| f.effect == effect.effect);
        // Of what comes again each time is told by the finding that lies there.
        let claimed: Vec<&Finding> = claimed.take(effect.times()).collect();
        let Some(finding) = claimed.first() else {
            continue;
        };
        details(effect, finding, &mut marks);
        for when in effect.interval_s.into_iter().chain(effect.again_s) {
            let overlaps =
                (claimed.iter()).map(|f| overlap(when, &f.intervals_s, truth.hours * 3600.0));
            marks.overlap.push(overlaps.fold(0.0, f64::max));
        }
    }
    marks
}

impl Marks {
    /// Findings of high probability that are wrong.
    pub(crate) fn confidently_wrong(&self) -> usize {
        let wrong = |(p, right): &&(f64, bool)| *p >= CONFIDENT && !right;
        self.forecasts.iter().filter(wrong).count()
    }

    /// Squared errors of the probabilities; an effect passed over counts as probability zero.
    pub(crate) fn squares(&self) -> impl Iterator<Item = f64> {
        let of = |(p, right): &(f64, bool)| (p - f64::from(u8::from(*right))).powi(2);
        let silent = std::iter::repeat_n(1.0, self.passed_over);
        self.forecasts.iter().map(of).chain(silent)
    }
}

/// `consistent` for clean recordings alone, and `explained` not for what is in no catalogue.
fn verdict_right(truth: &Truth, answer: &Answer, found: &[String]) -> bool {
    let foreign = truth.names().eq(["unknown"]);
    let abstained = found.iter().any(|f| f == "unknown");
    (answer.verdict == "consistent") == truth.effects.is_empty()
        && !(foreign && answer.verdict == "explained" && !abstained)
}

fn details(effect: &Concealed, finding: &Finding, marks: &mut Marks) {
    // What a transmitter does to a relation may be laid at the door of the transmitter.
    let of_instrument = ["outlet_", "return_flow", "inflow_gain"];
    let excused = finding.relation == "instrument"
        && of_instrument.iter().any(|p| effect.effect.starts_with(p));
    marks
        .relation
        .push(excused || effect.relations.contains(&finding.relation));
    for (name, truth) in &effect.parameters {
        let estimate = finding.parameters.iter().find(|p| p.name == *name);
        if name == "sensor" {
            // Names a transmitter, measures nothing.
            marks.sensor = Some(estimate.is_some_and(|e| (e.value - truth).abs() < 0.5));
            continue;
        }
        let size = if name == "gain" { truth - 1.0 } else { *truth }.abs();
        marks.parameters.push(ParameterMark {
            effect: effect.effect.clone(),
            name: name.clone(),
            error: estimate.map(|e| (e.value - truth).abs() / size),
            covered: estimate
                .and_then(|e| e.ci95)
                .is_some_and(|(low, high)| low <= *truth && *truth <= high),
        });
    }
}

/// Intersection over union of an interval and the union of others, within the recording.
pub(crate) fn overlap(truth: (f64, f64), found: &[(f64, f64)], length_s: f64) -> f64 {
    let clip = |(a, b): (f64, f64)| (a.clamp(0.0, length_s), b.clamp(0.0, length_s));
    let truth = clip(truth);
    let mut found: Vec<_> = found.iter().copied().map(clip).collect();
    found.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (mut both, mut covered, mut until) = (0.0, 0.0, 0.0_f64);
    for (from, to) in found {
        // What an earlier interval covered does not count twice.
        let from = from.max(until);
        if to <= from {
            continue;
        }
        until = to;
        covered += to - from;
        both += (to.min(truth.1) - from.max(truth.0)).max(0.0);
    }
    let either = covered + (truth.1 - truth.0) - both;
    if either > 0.0 { both / either } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::super::answer::Estimate;
    use super::*;

    fn concealed(effect: &str, relation: &str) -> Concealed {
        Concealed {
            effect: effect.into(),
            severity: "moderate".into(),
            relations: vec![relation.into()],
            ..Concealed::default()
        }
    }

    fn truth(effects: Vec<Concealed>) -> Truth {
        Truth {
            hours: 4.0,
            well: "gom".into(),
            effects,
        }
    }

    fn finding(effect: &str, probability: f64) -> Finding {
        Finding {
            effect: effect.into(),
            probability,
            relation: "pump_head".into(),
            ..Finding::default()
        }
    }

    fn answer(verdict: &str, findings: Vec<Finding>) -> Answer {
        Answer {
            verdict: verdict.into(),
            findings,
            ..Answer::default()
        }
    }

    #[test]
    fn the_right_name_alone_is_exact_and_an_extra_one_spoils_it() {
        let truth = truth(vec![concealed("pump_wear", "pump_head")]);
        let right = mark(
            &truth,
            Some(&answer("explained", vec![finding("pump_wear", 0.9)])),
        );
        assert!(right.exact && right.hit[0] && right.within[0] && right.verdict_right);
        assert_eq!(right.relation, [true]);
        let more = vec![finding("pump_wear", 0.9), finding("influx", 0.95)];
        let both = mark(&truth, Some(&answer("explained", more)));
        assert!(!both.exact && both.hit[0]);
        assert_eq!(both.extra, ["influx"]);
        assert_eq!(both.confidently_wrong(), 1);
    }

    #[test]
    fn a_finding_below_one_half_is_not_claimed_but_within_the_alternatives() {
        let truth = truth(vec![concealed("pump_wear", "pump_head")]);
        let marks = mark(
            &truth,
            Some(&answer("explained", vec![finding("pump_wear", 0.4)])),
        );
        assert!(!marks.exact && !marks.hit[0] && marks.within[0]);
        assert_eq!(marks.passed_over, 0);
        let mut other = finding("gas_in_pump", 0.7);
        other.alternatives = vec![("pump_wear".into(), 0.2)];
        let marks = mark(&truth, Some(&answer("explained", vec![other.clone()])));
        assert!(marks.within[0] && !marks.hit[0] && marks.extra == ["gas_in_pump"]);
        other.alternatives[0].1 = 0.09;
        let marks = mark(&truth, Some(&answer("explained", vec![other])));
        assert!(!marks.within[0]);
    }

    #[test]
    fn clean_and_silent_is_right_and_clean_and_found_is_a_false_alarm() {
        let clean = truth(vec![]);
        let silent = mark(&clean, Some(&answer("consistent", vec![])));
        assert!(silent.exact && silent.verdict_right);
        assert_eq!(silent.squares().count(), 0);
        let loud = mark(
            &clean,
            Some(&answer("explained", vec![finding("heave", 0.6)])),
        );
        assert!(!loud.exact && !loud.verdict_right);
        assert_eq!(loud.forecasts, [(0.6, false)]);
    }

    #[test]
    fn a_foreign_effect_is_unknown_and_not_explained() {
        let foreign = truth(vec![concealed("unknown", "pump_head")]);
        let abstained = mark(
            &foreign,
            Some(&answer("unexplained", vec![finding("unknown", 0.8)])),
        );
        assert!(abstained.exact && abstained.verdict_right);
        let explained = mark(
            &foreign,
            Some(&answer("explained", vec![finding("pump_wear", 0.8)])),
        );
        assert!(!explained.exact && !explained.verdict_right);
    }

    #[test]
    fn silence_costs_a_whole_square_and_a_run_without_answer_names_nothing() {
        let truth = truth(vec![
            concealed("pump_wear", "pump_head"),
            concealed("heave", "pump_head"),
        ]);
        let marks = mark(
            &truth,
            Some(&answer("explained", vec![finding("heave", 0.8)])),
        );
        let squares: Vec<f64> = marks.squares().collect();
        assert_eq!(squares.len(), 2);
        assert!((squares.iter().sum::<f64>() - (0.04 + 1.0)).abs() < 1e-12);
        let none = mark(&truth, None);
        assert!(!none.exact && none.hit == [false, false] && none.passed_over == 2);
    }

    #[test]
    fn a_gain_is_measured_from_one_and_its_interval_must_hold_the_truth() {
        let mut effect = concealed("inflow_gain", "riser_mass_balance");
        effect.parameters = vec![("gain".into(), 0.96)];
        let truth = truth(vec![effect]);
        let mut said = finding("inflow_gain", 0.9);
        said.relation = "instrument".into();
        let with = |value: f64, ci95: Option<(f64, f64)>| {
            let mut said = said.clone();
            said.parameters = vec![Estimate {
                name: "gain".into(),
                value,
                ci95,
            }];
            mark(&truth, Some(&answer("explained", vec![said])))
        };
        let marks = with(0.958, Some((0.95, 0.97)));
        assert!((marks.parameters[0].error.unwrap_or(9.0) - 0.05).abs() < 1e-9);
        assert!(marks.parameters[0].covered);
        assert_eq!(marks.relation, [true], "a meter's error sits in the meter");
        assert!(!with(0.958, Some((0.957, 0.959))).parameters[0].covered);
        assert!(!with(0.96, None).parameters[0].covered);
        let silent = mark(&truth, Some(&answer("explained", vec![said.clone()])));
        assert_eq!(silent.parameters[0].error, None);
    }

    #[test]
    fn the_transmitter_is_named_or_not() {
        let mut effect = concealed("outlet_pressure_bias_step", "return_line_friction");
        effect.parameters = vec![("bias_pa".into(), 5e4), ("sensor".into(), 2.0)];
        let truth = truth(vec![effect]);
        let mut said = finding("outlet_pressure_bias_step", 0.9);
        said.parameters = vec![Estimate {
            name: "sensor".into(),
            value: 1.0,
            ci95: None,
        }];
        let marks = mark(&truth, Some(&answer("explained", vec![said])));
        assert_eq!(marks.sensor, Some(false));
        assert_eq!(marks.parameters.len(), 1);
    }

    #[test]
    fn what_comes_twice_is_to_be_named_twice_each_time_where_it_is() {
        let kick = Concealed {
            interval_s: Some((1000.0, 2000.0)),
            again_s: Some((5000.0, 6000.0)),
            ..concealed("influx", "riser_mass_balance")
        };
        let truth = truth(vec![kick]);
        let at = |from: f64| Finding {
            intervals_s: vec![(from, from + 1000.0)],
            ..finding("influx", 0.9)
        };
        let once = mark(&truth, Some(&answer("explained", vec![at(5000.0)])));
        assert!(!once.exact && !once.hit[0] && once.extra.is_empty());
        let twice = mark(
            &truth,
            Some(&answer("explained", vec![at(5000.0), at(1500.0)])),
        );
        assert!(twice.exact && twice.hit[0]);
        let expected = [1.0 / 3.0, 1.0];
        assert!(
            twice
                .overlap
                .iter()
                .zip(expected)
                .all(|(a, b)| (a - b).abs() < 1e-12)
        );
    }

    #[test]
    fn overlap_is_intersection_over_union_and_counts_nothing_twice() {
        let close = |a: f64, b: f64| assert!((a - b).abs() < 1e-12, "{a} {b}");
        close(overlap((100.0, 200.0), &[(100.0, 200.0)], 1e4), 1.0);
        close(
            overlap((100.0, 200.0), &[(150.0, 250.0)], 1e4),
            50.0 / 150.0,
        );
        close(
            overlap((100.0, 200.0), &[(150.0, 200.0), (100.0, 160.0)], 1e4),
            1.0,
        );
        close(overlap((100.0, 200.0), &[(300.0, 400.0)], 1e4), 0.0);
        close(overlap((100.0, 200.0), &[], 1e4), 0.0);
        // An end beyond the recording means its end.
        close(overlap((9000.0, 1e4), &[(9000.0, 2e4)], 1e4), 1.0);
    }
}
