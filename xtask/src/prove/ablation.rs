//! What each step of the chain contributes: the same sealed recordings diagnosed without it.

use super::Sealed;
use super::batch;
use super::exam::{Exam, Paper, Scope};
use super::stats::{median, sign_test};
use super::summary::{Row, Summary};
use super::targets::COVERAGE;
use super::truth::SEVERITIES;
use anyhow::{Context, Result, bail};
use serde_json::{Value, json};
use std::path::Path;
use std::process::Command;

/// Probabilities are better or worse where their squared errors differ by more than so many standard errors, case by case.
const BRIER_SIGMAS: f64 = 2.0;
/// A Brier score that differs by less is the same.
const BRIER: f64 = 0.001;
/// A coverage that differs by less is the same.
const COVERED: f64 = 0.02;

/// The steps that `dgd diagnose` can leave out, as `dgd catalogue --json` lists them.
pub(crate) fn steps(dgd: &Path) -> Result<Vec<String>> {
    let output = Command::new(dgd)
        .args(["catalogue", "--json"])
        .output()
        .context("cannot run dgd")?;
    if !output.status.success() {
        bail!(
            "dgd catalogue: {}",
            String::from_utf8_lossy(&output.stderr).trim()
        );
    }
    listed(&output.stdout)
}

fn listed(catalogue: &[u8]) -> Result<Vec<String>> {
    let catalogue: Value =
        serde_json::from_slice(catalogue).context("cannot read what `dgd catalogue` said")?;
    let steps = catalogue["steps"].as_array().into_iter().flatten();
    let steps: Vec<String> = steps
        .filter_map(|s| s.as_str().map(str::to_owned))
        .collect();
    if steps.is_empty() {
        bail!("`dgd catalogue` lists no steps");
    }
    Ok(steps)
}

/// Which of the steps are asked for; all if none are.
pub(crate) fn chosen(steps: Vec<String>, asked: &[String]) -> Result<Vec<String>> {
    if let Some(other) = asked.iter().find(|s| !steps.contains(s)) {
        bail!("`{other}` is no step: they are {}", steps.join(", "));
    }
    Ok(if asked.is_empty() {
        steps
    } else {
        asked.to_vec()
    })
}

/// The answers without one step, in the order of the cases.
pub(crate) struct Without {
    pub(crate) step: String,
    pub(crate) exams: Vec<Exam>,
}

/// Diagnoses the cases without each step in turn; the truths stay sealed.
pub(crate) fn ask(
    dgd: &Path,
    jobs: usize,
    out: &Path,
    todo: &[(&Sealed, &String)],
    steps: Vec<String>,
) -> Vec<Without> {
    let without = |step: String| {
        let paper = |(sealed, id): &(&Sealed, &String)| Paper {
            case: sealed.cases.join(id),
            out: out
                .join("ablation")
                .join(&step)
                .join(format!("level-{}", sealed.level))
                .join(id),
            options: vec!["--without".into(), step.clone()],
            scope: Scope::Names,
        };
        let papers: Vec<Paper> = todo.iter().map(paper).collect();
        let exams = batch::all(dgd, jobs, &papers, &format!(" without {step}"));
        Without { step, exams }
    };
    steps.into_iter().map(without).collect()
}

/// What a level comes to with or without a step.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Figures {
    /// Single effects named exactly, by severity: strongest first.
    pub(crate) singles: [Option<f64>; 5],
    pub(crate) pairs: Option<f64>,
    pub(crate) false_alarms: Option<f64>,
    pub(crate) foreign: Option<f64>,
    /// Of all findings of probability 0.9 or more.
    pub(crate) confidently_wrong: Option<f64>,
    pub(crate) brier: Option<f64>,
    pub(crate) covered: Option<f64>,
    pub(crate) seconds: Option<f64>,
}

impl Figures {
    fn of(level: u8, rows: &[Row]) -> Figures {
        let s = Summary::of(level, rows);
        let mut singles = s.by_severity.map(|n| n.exact.share());
        singles.reverse();
        Figures {
            singles,
            pairs: s.pairs.exact.share(),
            false_alarms: s.false_alarms.share(),
            foreign: s.foreign.share(),
            confidently_wrong: s.confidently_wrong.share(),
            brier: s.brier,
            covered: s.parameter.covered.share(),
            seconds: median(&s.walls_s),
        }
    }

    /// Titles of [`Figures::list`].
    pub(crate) fn titles() -> Vec<String> {
        let singles = SEVERITIES.iter().rev().map(|s| (*s).to_owned());
        let others = [
            "pairs",
            "false alarms",
            "unknown",
            "conf. wrong",
            "Brier",
            "ci95",
            "s",
        ];
        singles.chain(others.map(str::to_owned)).collect()
    }

    /// All figures; shares but the Brier score and the seconds.
    pub(crate) fn list(&self) -> Vec<(Unit, Option<f64>)> {
        let mut list: Vec<_> = self.singles.map(|s| (Unit::Share, s)).into();
        list.extend([
            (Unit::Share, self.pairs),
            (Unit::Share, self.false_alarms),
            (Unit::Share, self.foreign),
            (Unit::Share, self.confidently_wrong),
            (Unit::Brier, self.brier),
            (Unit::Share, self.covered),
            (Unit::Seconds, self.seconds),
        ]);
        list
    }
}

/// How a figure is written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Unit {
    Share,
    Brier,
    Seconds,
}

impl Unit {
    pub(crate) fn value(self, value: f64) -> String {
        match self {
            Unit::Share => format!("{:.0} %", 100.0 * value),
            Unit::Brier => format!("{value:.3}"),
            Unit::Seconds => format!("{value:.2}"),
        }
    }

    /// A difference with its sign; nothing where it would be written as zero.
    pub(crate) fn difference(self, value: f64) -> String {
        let text = match self {
            Unit::Share => format!("{:+.1}", 100.0 * value),
            Unit::Brier => format!("{value:+.3}"),
            Unit::Seconds => format!("{value:+.2}"),
        };
        if text[1..].chars().all(|c| c == '0' || c == '.') {
            "0".into()
        } else {
            text
        }
    }
}

/// A step at one level.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct OfStep {
    pub(crate) step: String,
    pub(crate) level: u8,
    /// With every step.
    pub(crate) whole: Figures,
    /// Without this one.
    pub(crate) without: Figures,
    /// Cases that are answered exactly with the step and not without it.
    pub(crate) better: Vec<String>,
    /// Cases that are answered exactly without the step and not with it.
    pub(crate) worse: Vec<String>,
    /// Cases that are wrong either way, but name something else.
    pub(crate) other: usize,
    /// Cases that gave no answer without it.
    pub(crate) broken: usize,
    /// By how many standard errors the squared errors of the probabilities are larger without it, paired case by case.
    pub(crate) brier_sigmas: f64,
}

impl OfStep {
    fn of(step: &str, level: u8, whole: &[Row], without: &[Row]) -> OfStep {
        let own = |(a, _): &(&Row, &Row)| a.level == level;
        let pairs = || whole.iter().zip(without).filter(own);
        let exact = |with: bool, off: bool| {
            pairs()
                .filter(move |(a, b)| a.marks.exact == with && b.marks.exact == off)
                .map(|(a, _)| a.id.clone())
                .collect()
        };
        let wrong = |a: &Row, b: &Row| !a.marks.exact && !b.marks.exact;
        OfStep {
            step: step.to_owned(),
            level,
            whole: Figures::of(level, whole),
            without: Figures::of(level, without),
            better: exact(true, false),
            worse: exact(false, true),
            other: pairs()
                .filter(|(a, b)| wrong(a, b) && a.marks.found != b.marks.found)
                .count(),
            broken: pairs().filter(|(_, b)| b.answer.is_none()).count(),
            brier_sigmas: {
                let squares = |r: &Row| r.marks.squares().sum::<f64>();
                paired(pairs().map(|(a, b)| squares(b) - squares(a)))
            },
        }
    }

    /// What the step is worth here.
    pub(crate) fn worth(&self) -> Worth {
        use std::cmp::Ordering::{Equal, Greater, Less};
        match self.better.len().cmp(&self.worse.len()) {
            Greater => return Worth::Buys,
            Less => return Worth::Costs,
            Equal => {}
        }
        // As many right answers either way: the probabilities and the intervals decide.
        let sign = |by: f64, least: f64| i32::from(by > least) - i32::from(by < -least);
        let off = |f: &Figures| f.covered.map(uncovered);
        let covered = off(&self.without).zip(off(&self.whole));
        let covered = covered.map_or(0.0, |(without, with)| without - with);
        let score = sign(self.brier_sigmas, BRIER_SIGMAS) + sign(covered, COVERED);
        match score.cmp(&0) {
            Greater => Worth::Buys,
            Less => Worth::Costs,
            Equal => {
                let apart = |a: Option<f64>, b: Option<f64>, least: f64| {
                    a.zip(b).is_some_and(|(a, b)| (a - b).abs() > least)
                };
                let (a, b) = (&self.without, &self.whole);
                let same = self.better.is_empty()
                    && self.other == 0
                    && !apart(a.brier, b.brier, BRIER)
                    && !apart(a.covered, b.covered, COVERED)
                    && !apart(a.confidently_wrong, b.confidently_wrong, 0.0);
                if same {
                    Worth::Nothing
                } else {
                    Worth::Undecided
                }
            }
        }
    }

    /// Chance of so uneven a change if the step did nothing.
    pub(crate) fn chance(&self) -> f64 {
        sign_test(self.better.len(), self.worse.len())
    }
}

/// Mean of differences over its standard error; zero where they are all the same.
fn paired(differences: impl Iterator<Item = f64>) -> f64 {
    let all: Vec<f64> = differences.collect();
    let n = all.len() as f64;
    let mean = all.iter().sum::<f64>() / n;
    let spread = all.iter().map(|d| (d - mean).powi(2)).sum::<f64>();
    let error = (spread / (n * (n - 1.0))).sqrt();
    if error > 0.0 { mean / error } else { 0.0 }
}

/// How far a coverage lies outside its target.
fn uncovered(share: f64) -> f64 {
    (COVERAGE.0 - share).max(share - COVERAGE.1).max(0.0)
}

/// What a step is worth on an ensemble.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Worth {
    /// More right answers with it than without; or as many, with better probabilities or intervals.
    Buys,
    /// The answers differ, but neither way by more than chance.
    Undecided,
    /// The answers are the same but for trifles.
    Nothing,
    /// The other way round.
    Costs,
}

/// Every step at every level, level by level.
pub(crate) fn compare(whole: &[Row], without: &[(String, Vec<Row>)], levels: &[u8]) -> Vec<OfStep> {
    let of = |level: &u8| {
        let level = *level;
        without
            .iter()
            .map(move |(step, rows)| OfStep::of(step, level, whole, rows))
    };
    levels.iter().flat_map(of).collect()
}

/// In words, level by level: what contributes, with the answers right only with the step and only without it, and what costs.
pub(crate) fn words(list: &[OfStep], level: u8) -> String {
    let said = |s: &OfStep| match s.better.len() == s.worse.len() {
        true => s.step.clone(),
        false => format!(
            "{} ({} to {}, p {})",
            s.step,
            s.better.len(),
            s.worse.len(),
            chance_in_words(s.chance())
        ),
    };
    let named = |wanted: Worth| -> Vec<String> {
        list.iter()
            .filter(|s| s.level == level && s.worth() == wanted)
            .map(said)
            .collect()
    };
    let mut said = Vec::new();
    for (worth, verb) in [
        (Worth::Buys, "contributes"),
        (
            Worth::Undecided,
            "changes answers, for better as much as for worse",
        ),
        (Worth::Nothing, "contributes nothing"),
        (Worth::Costs, "costs right answers, or honest probabilities"),
    ] {
        let steps = named(worth);
        if !steps.is_empty() {
            said.push(format!("{verb}: {}", steps.join(", ")));
        }
    }
    format!("On this ensemble at level {level}, {}.", said.join("; "))
}

/// A chance as it is printed: none is nought.
fn chance_in_words(p: f64) -> String {
    if p < 0.001 {
        "< 0.001".to_owned()
    } else {
        format!("= {p:.3}")
    }
}

/// For `proof.json`.
pub(crate) fn json_of(list: &[OfStep]) -> Value {
    let figures = |f: &Figures| {
        let named = Figures::titles()
            .into_iter()
            .zip(f.list())
            .map(|(title, (_, v))| (title, json!(v)));
        Value::Object(named.collect())
    };
    let of = |s: &OfStep| {
        json!({"step": s.step, "level": s.level, "with": figures(&s.whole), "without": figures(&s.without),
               "better_by_step": s.better, "worse_by_step": s.worse, "wrong_in_another_way": s.other, "no_answer": s.broken,
               "sign_test_p": s.chance(), "brier_sigmas": s.brier_sigmas,
               "worth": match s.worth() { Worth::Buys => "buys", Worth::Undecided => "undecided", Worth::Nothing => "nothing", Worth::Costs => "costs" }})
    };
    json!(list.iter().map(of).collect::<Vec<_>>())
}

#[cfg(test)]
pub(crate) mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may")]
    use super::super::summary::tests::row;
    use super::*;

    fn rows(said: &[&str]) -> Vec<Row> {
        let case = |(i, s): (usize, &&str)| {
            let mut case = row(&["influx"], Some(&[(*s, 0.8)]));
            case.id = format!("c{i:03}");
            case
        };
        said.iter().enumerate().map(case).collect()
    }

    pub(crate) fn example() -> Vec<OfStep> {
        let whole = rows(&["influx", "influx", "heave", "heave"]);
        let list = [
            (
                "edges".to_owned(),
                rows(&["influx", "heave", "u_tube", "heave"]),
            ),
            (
                "form".to_owned(),
                rows(&["influx", "influx", "influx", "heave"]),
            ),
            (
                "busiest".to_owned(),
                rows(&["influx", "influx", "heave", "heave"]),
            ),
        ];
        compare(&whole, &list, &[2])
    }

    #[test]
    fn a_step_is_worth_what_goes_wrong_without_it() {
        let of = example();
        assert_eq!(of[0].better, ["c001"]);
        assert_eq!((of[0].worse.len(), of[0].other), (0, 1));
        assert_eq!(of[0].worth(), Worth::Buys);
        assert_eq!(of[1].worse, ["c002"]);
        assert_eq!(of[1].worth(), Worth::Costs);
        assert_eq!(of[2].worth(), Worth::Nothing);
        assert_eq!(of[0].chance(), 1.0, "one case proves nothing");
        assert_eq!(chance_in_words(1e-6), "< 0.001");
        let said = words(&of, 2);
        assert!(
            said.contains("contributes nothing: busiest")
                && said.contains("contributes: edges (1 to 0, p = 1.000)"),
            "{said}"
        );
    }

    #[test]
    fn with_as_many_right_answers_the_probabilities_decide() {
        let said = ["influx", "heave", "heave", "heave", "heave"];
        let whole = rows(&said);
        let mut sure = rows(&said);
        for case in &mut sure {
            case.marks.forecasts.iter_mut().for_each(|f| f.0 = 0.99);
        }
        let of = compare(&whole, &[("calibration".to_owned(), sure)], &[2]);
        assert!(of[0].without.brier > of[0].whole.brier);
        assert!(of[0].brier_sigmas > 2.0, "{}", of[0].brier_sigmas);
        assert_eq!(of[0].worth(), Worth::Buys);
    }

    #[test]
    fn differences_that_would_read_as_zero_are_zero() {
        assert_eq!(Unit::Share.difference(-0.0001), "0");
        assert_eq!(Unit::Share.difference(-0.024), "-2.4");
        assert_eq!(Unit::Brier.difference(0.0101), "+0.010");
        assert_eq!(Unit::Seconds.difference(0.0), "0");
        assert_eq!(uncovered(0.94), 0.0);
        assert!((uncovered(0.85) - 0.05).abs() < 1e-12);
    }

    #[test]
    fn steps_are_read_from_the_catalogue_and_an_empty_one_is_refused() {
        let list = br#"{ "effects": [], "steps": ["edges", "form"] }"#;
        assert_eq!(listed(list).unwrap(), ["edges", "form"]);
        for nothing in [&b"{}"[..], br#"{ "steps": [] }"#, b"edges"] {
            assert!(listed(nothing).is_err());
        }
    }

    #[test]
    fn only_steps_that_there_are_can_be_asked_for() {
        let all = || vec!["edges".to_owned(), "form".to_owned()];
        assert_eq!(chosen(all(), &[]).unwrap(), all());
        assert_eq!(chosen(all(), &["form".to_owned()]).unwrap(), ["form"]);
        let error = chosen(all(), &["from".to_owned()]).unwrap_err();
        assert!(error.to_string().contains("edges, form"), "{error}");
    }

    #[test]
    fn every_title_has_its_figure() {
        let of = example();
        assert_eq!(Figures::titles().len(), of[0].whole.list().len());
    }
}
