//! Holds an answer against the truth.

use super::answer::{Answer, Finding, Off};
use super::counterparts;
use super::run::Exam;
use super::truth::{Concealed, Truth};
use std::collections::BTreeMap;

/// What came of a case.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Outcome {
    /// Something the catalogue has: named, and nothing beside it. What no catalogue has: called unknown, and nothing named. Clean: silent.
    Right,
    /// Named, with others beside it that are not there.
    Beside,
    /// Among the stated alternatives of a finding, or told as also possible.
    Within,
    /// In the catalogue, but called unknown.
    Unknown,
    /// Something there, nothing found.
    Silent,
    /// Another name; on a clean recording, any finding.
    Wrong,
    /// No answer.
    None,
}

impl Outcome {
    pub(crate) fn word(self) -> &'static str {
        match self {
            Outcome::Right => "right",
            Outcome::Beside => "named, with others",
            Outcome::Within => "an alternative",
            Outcome::Unknown => "unknown",
            Outcome::Silent => "nothing found",
            Outcome::Wrong => "wrong",
            Outcome::None => "no answer",
        }
    }
}

/// A case, its answer and its marks.
pub(crate) struct Row {
    pub(crate) truth: Truth,
    pub(crate) answer: Option<Answer>,
    pub(crate) held_out: BTreeMap<String, Off>,
    pub(crate) broken: Vec<String>,
    pub(crate) wall_s: f64,
    pub(crate) outcome: Outcome,
    /// A finding sits on a component that the concealed thing can be said to sit on.
    pub(crate) located: bool,
    /// A finding sits on a component of its kind.
    pub(crate) kind: bool,
}

/// What a case is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Sort {
    /// The catalogue has it.
    Held,
    /// A textbook has it, the catalogue does not.
    Lacking,
    Foreign,
    Clean,
}

impl Row {
    pub(crate) fn new(truth: Truth, exam: Exam) -> Row {
        let on = |fits: &dyn Fn(&Concealed, &str) -> bool| {
            let (Some(c), Some(a)) = (&truth.concealed, &exam.answer) else {
                return false;
            };
            a.findings.iter().any(|f| fits(c, &f.component))
        };
        Row {
            outcome: outcome(&truth, exam.answer.as_ref()),
            located: on(&|c, name| c.components.iter().any(|k| k == name)),
            kind: on(&|c, name| counterparts::kind(&truth.bench, name) == Some(c.kind.as_str())),
            truth,
            answer: exam.answer,
            held_out: exam.held_out,
            broken: exam.broken,
            wall_s: exam.wall_s,
        }
    }

    pub(crate) fn sort(&self) -> Sort {
        sort(&self.truth)
    }

    /// Something was found.
    pub(crate) fn detected(&self) -> bool {
        self.answer
            .as_ref()
            .is_some_and(|a| a.verdict != "consistent")
    }

    /// The outcome, were only findings of some probability given; where none is stated, all count.
    pub(crate) fn outcome_from(&self, least: f64) -> Outcome {
        let likely = self.answer.clone().map(|mut a| {
            a.findings
                .retain(|f| f.probability.is_none_or(|p| p >= least));
            a
        });
        outcome(&self.truth, likely.as_ref())
    }

    /// Findings of probability 0.9 or more: whether each is right.
    pub(crate) fn confident(&self) -> Vec<bool> {
        let said = self.weighed().into_iter();
        said.filter(|(p, _)| *p >= 0.9).map(|(_, r)| r).collect()
    }

    /// Each stated probability, and whether its finding is right.
    pub(crate) fn weighed(&self) -> Vec<(f64, bool)> {
        let names = |thing: &str, f: &Finding| {
            counterparts::names(thing).contains(&(f.component.as_str(), f.effect.as_str()))
        };
        let right = |f: &Finding| match (self.sort(), &self.truth.concealed) {
            (Sort::Held, Some(c)) => names(&c.thing, f),
            (Sort::Lacking | Sort::Foreign, _) => f.effect == "unknown",
            _ => false,
        };
        let said = self.answer.iter();
        said.flat_map(|a| a.findings.iter().chain(&a.possible))
            .filter_map(|f| Some((f.probability?, right(f))))
            .collect()
    }

    /// Whether each 95 % interval of a parameter that has a counterpart in the plant holds it.
    pub(crate) fn covered(&self) -> Vec<bool> {
        let Some(c) = &self.truth.concealed else {
            return Vec::new();
        };
        let findings = self.answer.iter().flat_map(|a| &a.findings);
        let stated = findings.flat_map(|f| &f.intervals);
        let holds = |(path, (low, high)): &(String, (f64, f64))| {
            let same = |s: &&(&str, &str, &str, f64)| s.0 == c.thing && s.2 == path;
            let (_, name, _, units) = counterparts::SIZES.iter().find(same)?;
            let truth = units * c.size.get(*name)?;
            Some((*low..=*high).contains(&truth))
        };
        stated.filter_map(holds).collect()
    }

    /// Held-out error over what noise alone adds, over all instruments, before and after; 1 is as good as can be.
    pub(crate) fn off(&self) -> Option<(f64, f64)> {
        let mut sums = (0.0, 0.0);
        for (name, floor) in &self.truth.floor {
            let off = self.held_out.get(name)?;
            sums.0 += (off.before / floor).powi(2);
            sums.1 += (off.after / floor).powi(2);
        }
        let n = self.truth.floor.len() as f64;
        (n > 0.0).then(|| ((sums.0 / n).sqrt(), (sums.1 / n).sqrt()))
    }

    /// Share of the held-out gain that there is down to the noise; `None` where less than 5 % is to be gained.
    pub(crate) fn share(&self) -> Option<f64> {
        let (before, after) = self.off()?;
        (before > 1.05).then(|| (before - after) / (before - 1.0))
    }

    /// Instruments that got worse by more than 2 %.
    pub(crate) fn worse(&self) -> Vec<&str> {
        let worse = self
            .held_out
            .iter()
            .filter(|(_, o)| o.after > 1.02 * o.before);
        worse.map(|(name, _)| name.as_str()).collect()
    }
}

fn sort(truth: &Truth) -> Sort {
    match &truth.concealed {
        None => Sort::Clean,
        Some(c) if c.kind == "foreign" => Sort::Foreign,
        Some(c) if counterparts::names(&c.thing).is_empty() => Sort::Lacking,
        Some(_) => Sort::Held,
    }
}

fn outcome(truth: &Truth, answer: Option<&Answer>) -> Outcome {
    let Some(answer) = answer else {
        return Outcome::None;
    };
    let unknown = answer.findings.iter().all(|f| f.effect == "unknown");
    match (sort(truth), answer.findings.is_empty()) {
        (Sort::Clean, true) => Outcome::Right,
        (Sort::Clean, false) => Outcome::Wrong,
        (_, true) => Outcome::Silent,
        (Sort::Foreign | Sort::Lacking, false) if unknown => Outcome::Right,
        (Sort::Foreign | Sort::Lacking, false) => Outcome::Wrong,
        (Sort::Held, false) if unknown => Outcome::Unknown,
        (Sort::Held, false) => {
            let thing = truth.concealed.as_ref().map_or("", |c| c.thing.as_str());
            let names = counterparts::names(thing);
            let is = |component: &str, effect: &str| names.contains(&(component, effect));
            let named = answer.findings.iter().any(|f| is(&f.component, &f.effect));
            let all = || answer.findings.iter().chain(&answer.possible);
            let possible = answer.possible.iter().any(|f| is(&f.component, &f.effect));
            let within = all().flat_map(|f| &f.alternatives);
            let mut within = within.filter_map(|a| a.rsplit_once('.'));
            match (named, answer.findings.len()) {
                (true, 1) => Outcome::Right,
                (true, _) => Outcome::Beside,
                (false, _) if possible || within.any(|(c, e)| is(c, e)) => Outcome::Within,
                (false, _) => Outcome::Wrong,
            }
        }
    }
}

/// `component.effect, ...`, or the verdict where there is no finding.
pub(crate) fn said(row: &Row) -> String {
    let Some(answer) = &row.answer else {
        return "nothing".into();
    };
    if answer.findings.is_empty() {
        return answer.verdict.clone();
    }
    let name = |f: &Finding| {
        let name = match f.component.as_str() {
            "" => f.effect.clone(),
            component => format!("{component}.{}", f.effect),
        };
        match f.probability {
            Some(p) => format!("{name} ({p:.2})"),
            None => name,
        }
    };
    let names = |list: &[Finding]| list.iter().map(name).collect::<Vec<_>>().join(", ");
    let findings = names(&answer.findings);
    if answer.possible.is_empty() {
        return findings;
    }
    format!("{findings}; also possible: {}", names(&answer.possible))
}

/// What was concealed, in words.
pub(crate) fn concealed(truth: &Truth) -> String {
    truth.concealed.as_ref().map_or("nothing".into(), |c| {
        format!("{}, {}", c.thing.replace('_', " "), c.severity)
    })
}

#[cfg(test)]
pub(crate) mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may")]
    use super::*;

    pub(crate) fn truth(thing: Option<(&str, &str, &str)>) -> Truth {
        Truth {
            id: "c000".into(),
            bench: "surge-shaft".into(),
            concealed: thing.map(|(thing, kind, component)| Concealed {
                thing: thing.into(),
                severity: "moderate".into(),
                kind: kind.into(),
                components: vec![component.into()],
                size: [("crest_m".to_owned(), 3.0)].into(),
            }),
            floor: [("level".to_owned(), 1.0), ("tunnel_flow".to_owned(), 2.0)].into(),
        }
    }

    pub(crate) fn row(
        thing: Option<(&str, &str, &str)>,
        findings: &[(&str, &str, &[&str])],
    ) -> Row {
        let findings: Vec<Finding> = findings
            .iter()
            .map(|(component, effect, others)| Finding {
                component: (*component).into(),
                effect: (*effect).into(),
                alternatives: others.iter().map(|o| (*o).to_owned()).collect(),
                probability: None,
                intervals: Vec::new(),
            })
            .collect();
        let verdict = if findings.is_empty() {
            "consistent"
        } else {
            "explained"
        };
        let off = |before, after| Off { before, after };
        let exam = Exam {
            answer: Some(Answer {
                verdict: verdict.into(),
                findings,
                possible: Vec::new(),
            }),
            held_out: [
                ("level".to_owned(), off(3.0, 1.0)),
                ("tunnel_flow".to_owned(), off(6.0, 2.0)),
            ]
            .into(),
            ..Exam::default()
        };
        Row::new(truth(thing), exam)
    }

    const LEAK: Option<(&str, &str, &str)> = Some(("shaft_leak", "tank", "shaft"));

    #[test]
    fn what_is_also_possible_is_no_name_but_among_what_is_stated_with_its_probability() {
        let mut row = row(LEAK, &[("shaft", "taper", &[])]);
        assert_eq!(row.outcome, Outcome::Wrong);
        let answer = row.answer.as_mut().unwrap();
        answer.possible = answer.findings.clone();
        answer.possible[0].effect = "tank_leak".into();
        answer.possible[0].probability = Some(0.1);
        assert_eq!(row.outcome_from(0.0), Outcome::Within);
        assert_eq!(row.weighed(), [(0.1, true)]);
        assert_eq!(
            said(&row),
            "shaft.taper; also possible: shaft.tank_leak (0.10)"
        );
    }

    #[test]
    fn what_the_catalogue_has_is_right_only_by_its_name_alone() {
        let of = |findings: &[(&str, &str, &[&str])]| row(LEAK, findings).outcome;
        assert_eq!(of(&[("shaft", "tank_leak", &[])]), Outcome::Right);
        assert_eq!(
            of(&[("shaft", "tank_leak", &[]), ("valve", "clogging", &[])]),
            Outcome::Beside
        );
        assert_eq!(
            of(&[("shaft", "splash", &["shaft.tank_leak"])]),
            Outcome::Within
        );
        assert_eq!(
            of(&[("shaft", "splash", &["other.tank_leak"])]),
            Outcome::Wrong
        );
        assert_eq!(of(&[("", "unknown", &[])]), Outcome::Unknown);
        assert_eq!(of(&[]), Outcome::Silent);
    }

    #[test]
    fn what_it_lacks_is_right_as_unknown_and_wrong_by_any_name() {
        for thing in [
            ("foot_throttle", "tank", "shaft"),
            ("humming_shaft", "foreign", "valve"),
        ] {
            let of = |findings: &[(&str, &str, &[&str])]| row(Some(thing), findings).outcome;
            assert_eq!(of(&[("", "unknown", &[])]), Outcome::Right);
            assert_eq!(of(&[("valve", "opening_lag", &[])]), Outcome::Wrong);
            assert_eq!(
                of(&[("", "unknown", &[]), ("valve", "opening_lag", &[])]),
                Outcome::Wrong
            );
            assert_eq!(of(&[]), Outcome::Silent);
        }
    }

    #[test]
    fn anything_found_on_a_clean_recording_is_wrong() {
        assert_eq!(row(None, &[]).outcome, Outcome::Right);
        assert_eq!(row(None, &[("", "unknown", &[])]).outcome, Outcome::Wrong);
    }

    #[test]
    fn place_and_kind_are_scored_apart_from_the_name() {
        let other = row(LEAK, &[("shaft", "splash", &[])]);
        assert!(other.located && other.kind);
        let elsewhere = row(LEAK, &[("valve", "clogging", &[])]);
        assert!(!elsewhere.located && !elsewhere.kind);
    }

    #[test]
    fn probabilities_weigh_what_was_said() {
        let mut said = row(
            LEAK,
            &[("shaft", "tank_leak", &[]), ("valve", "clogging", &[])],
        );
        let findings = &mut said.answer.as_mut().unwrap().findings;
        (findings[0].probability, findings[1].probability) = (Some(0.95), Some(0.3));
        assert_eq!(said.outcome, Outcome::Beside);
        assert_eq!(said.outcome_from(0.5), Outcome::Right);
        assert_eq!(said.confident(), [true]);
        said.answer.as_mut().unwrap().findings[1].probability = Some(0.9);
        assert_eq!(said.confident(), [true, false]);
    }

    #[test]
    fn an_interval_is_held_against_the_size_that_means_the_same() {
        let crest = Some(("crest_overflow", "tank", "shaft"));
        let mut said = row(crest, &[("shaft", "unseen_brim", &[])]);
        let path = |name: &str| format!("shaft.unseen_brim.{name}");
        said.answer.as_mut().unwrap().findings[0].intervals =
            vec![(path("height"), (2.9, 3.1)), (path("share"), (0.0, 1.0))];
        assert_eq!(said.covered(), [true]);
        said.answer.as_mut().unwrap().findings[0].intervals[0].1 = (3.1, 3.2);
        assert_eq!(said.covered(), [false]);
    }

    #[test]
    fn the_gain_is_that_down_to_the_noise() {
        let all = row(LEAK, &[]);
        let (before, after) = all.off().unwrap();
        assert!((before - 3.0).abs() < 1e-12 && (after - 1.0).abs() < 1e-12);
        assert!((all.share().unwrap() - 1.0).abs() < 1e-12);
        assert!(all.worse().is_empty());
    }
}
