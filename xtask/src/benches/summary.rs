//! The scores: for the page, for standard output, and as JSON.

use super::score::{Outcome, Row, Sort, said};
use super::{BENCHES, Origin, Settings, counterparts};
use crate::calibrate::logistic;
use crate::prove::stats::{Tally, median};
use serde_json::{Value, json};
use std::fmt::Write;

/// A score.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Score {
    /// So many of so many.
    Share(Tally),
    /// The median of so many values, as a factor.
    Factor(Option<f64>, usize),
    /// As a share of one.
    Percent(Option<f64>, usize),
    /// In s.
    Seconds(Option<f64>, usize),
}

impl Score {
    pub(crate) fn value(self) -> String {
        let or = |v: Option<f64>, text: fn(f64) -> String| v.map_or("–".into(), text);
        match self {
            Score::Share(t) => format!("{} of {}", t.right, t.of),
            Score::Factor(v, _) => or(v, |v| format!("{v:.2}")),
            Score::Percent(v, _) => or(v, |v| format!("{:.0} %", 100.0 * v)),
            Score::Seconds(v, _) => or(v, |v| format!("{v:.0} s")),
        }
    }

    pub(crate) fn basis(self) -> String {
        match self {
            Score::Share(t) => t.interval().map_or(String::new(), |(low, high)| {
                format!("{:.0} to {:.0} %", 100.0 * low, 100.0 * high)
            }),
            Score::Factor(_, n) | Score::Percent(_, n) | Score::Seconds(_, n) => {
                format!("{n} cases")
            }
        }
    }

    fn json(self) -> Value {
        match self {
            Score::Share(t) => json!({"right": t.right, "of": t.of, "interval95": t.interval()}),
            Score::Factor(v, n) | Score::Percent(v, n) | Score::Seconds(v, n) => {
                json!({"value": v, "of": n})
            }
        }
    }
}

/// Scores by title.
type Measures = Vec<(&'static str, Score)>;

/// The scores of some cases, by title.
pub(crate) fn measures(rows: &[&Row]) -> Measures {
    [
        naming(rows),
        location(rows),
        reliability(rows),
        held_out(rows),
        wall_time(rows),
    ]
    .concat()
}

/// What was found and named.
fn naming(rows: &[&Row]) -> Measures {
    let held = of_sort(rows, &[Sort::Held]);
    let lacking = of_sort(rows, &[Sort::Lacking]);
    let foreign = of_sort(rows, &[Sort::Foreign]);
    let there = of_sort(rows, &CONCEALED);
    let named = |r: &Row| matches!(r.outcome, Outcome::Right | Outcome::Beside);
    vec![
        (
            "something concealed, something found",
            share(&there, Row::detected),
        ),
        (
            "in the catalogue: named, and nothing else",
            share(&held, |r| r.outcome == Outcome::Right),
        ),
        (
            "the same, findings of probability 0.5 or more alone",
            share(&held, |r| r.outcome_from(0.5) == Outcome::Right),
        ),
        ("in the catalogue: named", share(&held, named)),
        (
            "in the catalogue: named or among the alternatives",
            share(&held, |r| named(r) || r.outcome == Outcome::Within),
        ),
        (
            "in no catalogue, but in textbooks: called unknown",
            share(&lacking, |r| r.outcome == Outcome::Right),
        ),
        (
            "foreign: called unknown",
            share(&foreign, |r| r.outcome == Outcome::Right),
        ),
    ]
}

/// Where findings lie.
fn location(rows: &[&Row]) -> Measures {
    let there = of_sort(rows, &CONCEALED);
    let known = of_sort(rows, &[Sort::Held, Sort::Lacking]);
    vec![
        (
            "a finding on the right component",
            share(&there, |r| r.located),
        ),
        (
            "a finding on the right kind of component",
            share(&known, |r| r.kind),
        ),
    ]
}

/// How far what is stated holds: that there is something, its probability, its interval.
fn reliability(rows: &[&Row]) -> Measures {
    let clean = of_sort(rows, &[Sort::Clean]);
    let sure = rows.iter().flat_map(|r| r.confident());
    let covered = rows.iter().flat_map(|r| r.covered());
    let weighed: Vec<(f64, bool)> = rows.iter().flat_map(|r| r.weighed()).collect();
    vec![
        ("clean: false alarms", share(&clean, Row::detected)),
        (
            "findings of probability 0.9 or more: wrong",
            Score::Share(tally(sure.map(|right| !right))),
        ),
        (
            "stated probabilities: Brier score (0.25 is knowing nothing)",
            Score::Factor(brier(&weighed), weighed.len()),
        ),
        (
            "95 % intervals of sizes that hold the truth",
            Score::Share(tally(covered)),
        ),
    ]
}

/// What is gained on held-out samples.
fn held_out(rows: &[&Row]) -> Measures {
    let there = of_sort(rows, &CONCEALED);
    let held = of_sort(rows, &[Sort::Held]);
    let collect = |of: &[&Row], f: fn(&Row) -> Option<f64>| -> Vec<f64> {
        of.iter().filter_map(|r| f(r)).collect()
    };
    let factor = |v: Vec<f64>| Score::Factor(median(&v), v.len());
    let percent = |v: Vec<f64>| Score::Percent(median(&v), v.len());
    vec![
        (
            "held-out error over the noise, before (median)",
            factor(collect(&there, |r| r.off().map(|o| o.0))),
        ),
        (
            "held-out error over the noise, after (median)",
            factor(collect(&there, |r| r.off().map(|o| o.1))),
        ),
        (
            "share of the gain that knowing the truth allows (median)",
            percent(collect(&there, Row::share)),
        ),
        (
            "the same, in the catalogue (median)",
            percent(collect(&held, Row::share)),
        ),
        (
            "an instrument made worse on held-out samples",
            share(rows, |r| !r.worse().is_empty()),
        ),
    ]
}

fn wall_time(rows: &[&Row]) -> Measures {
    let walls: Vec<f64> = rows.iter().map(|r| r.wall_s).collect();
    let longest = walls.iter().copied().reduce(f64::max);
    vec![
        (
            "wall time, median",
            Score::Seconds(median(&walls), walls.len()),
        ),
        ("wall time, longest", Score::Seconds(longest, walls.len())),
    ]
}

/// Sorts of cases in which something is concealed.
const CONCEALED: [Sort; 3] = [Sort::Held, Sort::Lacking, Sort::Foreign];

fn of_sort<'a>(rows: &[&'a Row], sorts: &[Sort]) -> Vec<&'a Row> {
    let is = |r: &&Row| sorts.contains(&r.sort());
    rows.iter().copied().filter(is).collect()
}

fn share(of: &[&Row], is: impl Fn(&Row) -> bool) -> Score {
    Score::Share(tally(of.iter().map(|r| is(r))))
}

fn tally(each: impl Iterator<Item = bool>) -> Tally {
    let mut tally = Tally::default();
    each.for_each(|right| tally.add(right));
    tally
}

/// Mean square by which stated probabilities miss what came.
fn brier(weighed: &[(f64, bool)]) -> Option<f64> {
    let miss = |(p, right): &(f64, bool)| (p - f64::from(u8::from(*right))).powi(2);
    let n = weighed.len() as f64;
    (n > 0.0).then(|| weighed.iter().map(miss).sum::<f64>() / n)
}

/// Edges of the groups in which stated probabilities are held against what came.
const GROUPS: [f64; 5] = [0.0, 0.25, 0.5, 0.75, 0.9];
/// Standard deviation of the prior on the line's two coefficients.
const PRIOR: f64 = 3.0;

/// Stated probabilities of one size, beside what came.
struct Group {
    from: f64,
    to: f64,
    /// Their mean.
    stated: f64,
    came: Tally,
}

fn groups(weighed: &[(f64, bool)]) -> Vec<Group> {
    let group = |k: usize| {
        let (from, next) = (GROUPS[k], GROUPS.get(k + 1));
        let inside = |p: f64| p >= from && next.is_none_or(|to| p < *to);
        let (mut came, mut stated) = (Tally::default(), 0.0);
        for (p, right) in weighed.iter().filter(|w| inside(w.0)) {
            came.add(*right);
            stated += p;
        }
        Group {
            from,
            to: next.copied().unwrap_or(1.0),
            stated: stated / came.of.max(1) as f64,
            came,
        }
    };
    (0..GROUPS.len())
        .map(group)
        .filter(|g| g.came.of > 0)
        .collect()
}

/// The line by which the logits of what was stated would have come out right: 0 and 1 where they do.
fn line(weighed: &[(f64, bool)]) -> Option<logistic::Fit> {
    let row = |(p, right): &(f64, bool)| (vec![1.0, logistic::logit(*p)], *right);
    logistic::fit(&weighed.iter().map(row).collect::<Vec<_>>(), PRIOR)
}

/// The rows of a bench; of both for `None`.
pub(crate) fn of<'a>(rows: &'a [Row], bench: Option<&str>) -> Vec<&'a Row> {
    let is = |r: &&Row| bench.is_none_or(|b| r.truth.bench == b);
    rows.iter().filter(is).collect()
}

/// The table on standard output.
pub(crate) fn table(rows: &[Row]) -> String {
    let benches = [Some(BENCHES[0]), Some(BENCHES[1]), None];
    let columns = benches.map(|b| measures(&of(rows, b)));
    let mut text = format!("{:<60}{:<14}{:<14}both\n", "", BENCHES[0], BENCHES[1]);
    for (i, (title, _)) in columns[0].iter().enumerate() {
        let cells = columns.iter().map(|c| format!("{:<14}", c[i].1.value()));
        // Writing into a string cannot fail.
        let _ = writeln!(text, "{title:<60}{}", cells.collect::<String>().trim_end());
    }
    let weighed: Vec<(f64, bool)> = rows.iter().flat_map(Row::weighed).collect();
    let _ = writeln!(text, "\nstated probability: mean, and right");
    for g in groups(&weighed) {
        let (from, to, stated) = (g.from, g.to, g.stated);
        let came = format!("{} of {}", g.came.right, g.came.of);
        let _ = writeln!(text, "  {from:.2} to {to:.2}: {stated:.2}, {came}");
    }
    if let Some(line) = line(&weighed) {
        let of = |k: usize| format!("{:.2} ± {:.2}", line.coefficients[k], line.errors[k]);
        let _ = writeln!(
            text,
            "  logit of right = ({}) + ({}) logit of stated",
            of(0),
            of(1)
        );
    }
    text
}

/// `benches.json`
pub(crate) fn json_of(settings: &Settings, origin: &Origin, rows: &[Row]) -> Value {
    let scores = |bench| -> Value {
        let list = measures(&of(rows, bench));
        let list = list
            .iter()
            .map(|(title, score)| json!({"measure": title, "score": score.json()}));
        list.collect()
    };
    let case = |r: &Row| {
        let off = r.off();
        let instruments: serde_json::Map<String, Value> = r
            .held_out
            .iter()
            .map(|(name, o)| {
                let floor = r.truth.floor.get(name);
                (
                    name.clone(),
                    json!({"rmse_before": o.before, "rmse_after": o.after, "noise": floor}),
                )
            })
            .collect();
        json!({
            "bench": r.truth.bench, "id": r.truth.id,
            "concealed": r.truth.concealed.as_ref().map(|c| json!({"thing": c.thing, "severity": c.severity, "kind": c.kind})),
            "verdict": r.answer.as_ref().map(|a| &a.verdict),
            "said": said(r), "outcome": r.outcome.word(), "located": r.located, "kind_right": r.kind,
            "over_noise_before": off.map(|o| o.0), "over_noise_after": off.map(|o| o.1), "share_of_gain": r.share(),
            "held_out": instruments, "wall_s": r.wall_s, "broken": r.broken,
        })
    };
    let weighed: Vec<(f64, bool)> = rows.iter().flat_map(Row::weighed).collect();
    let groups = groups(&weighed).into_iter().map(|g| {
        json!({"from": g.from, "to": g.to, "right": g.came.right, "of": g.came.of, "stated": g.stated})
    });
    let names = counterparts::COUNTERPARTS.iter().map(|c| {
        let names: Vec<String> = c.names.iter().map(|(k, e)| format!("{k}.{e}")).collect();
        json!({"thing": c.thing, "names": names})
    });
    json!({
        "seed": settings.seed, "count": settings.count, "only": settings.only, "jobs": settings.jobs,
        "truths_sha256": origin.seal, "program": origin.program.version, "program_sha256": origin.program.sha256,
        "commit": origin.program.commit,
        "reliability": {"groups": groups.collect::<Vec<_>>(), "line": line(&weighed).map(|l| json!({"coefficients": l.coefficients, "errors": l.errors}))},
        "surge-shaft": scores(Some(BENCHES[0])), "glycol-loop": scores(Some(BENCHES[1])), "both": scores(None),
        "counterparts": names.collect::<Vec<_>>(),
        "cases": rows.iter().map(case).collect::<Vec<_>>(),
    })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may")]
    use super::*;

    #[test]
    fn what_is_stated_too_high_is_told_by_its_group_and_by_the_line() {
        // Of ten stated at 0.9 six are right, of ten at 0.3 one.
        let of = |p: f64, right: usize| (0..10).map(move |k| (p, k < right));
        let weighed: Vec<(f64, bool)> = of(0.9, 6).chain(of(0.3, 1)).collect();
        let found = groups(&weighed);
        let told: Vec<(f64, usize)> = found.iter().map(|g| (g.from, g.came.right)).collect();
        assert_eq!(told, [(0.25, 1), (0.9, 6)]);
        assert!(line(&weighed).unwrap().coefficients[0] < -0.5);
        let brier = brier(&weighed).unwrap();
        assert!((brier - (6.0 * 0.01 + 4.0 * 0.81 + 0.49 + 9.0 * 0.09) / 20.0).abs() < 1e-12);
    }
}
