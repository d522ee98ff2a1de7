//! The held-out gain against a fit that knows what was concealed.

use super::answer::Answer;
use super::batch;
use super::exam::{Paper, Scope};
use super::simulation::Simulation;
use super::stats::{Tally, median};
use super::summary::{Row, SIGNAL_TITLES};
use super::targets::TRUTH_SHARE;
use super::{Sealed, exam::Exam};
use anyhow::{Context, Result};
use serde_json::{Value, json};
use std::path::Path;

/// A signal counts where knowing the truth takes off at least this share of its held-out error.
const MATERIAL: f64 = 0.05;

/// What a fit makes of a recording that is told what was concealed.
#[derive(Default)]
pub(crate) struct Informed {
    pub(crate) answer: Option<Answer>,
    pub(crate) simulation: Option<Simulation>,
    pub(crate) broken: Vec<String>,
    /// Share of its gain that the blind run reaches.
    pub(crate) share: Option<Share>,
}

/// Gain of the blind run over the gain of the fit that knows the truth.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Share {
    /// `None` where knowing the truth gains nothing material.
    pub(crate) by_signal: [Option<f64>; 4],
    /// Over all signals that count, each relative to its error before.
    pub(crate) whole: f64,
}

/// Runs `dgd diagnose --suspect` on every recording in which effects of the catalogue alone are concealed. Only after the
/// seal is opened.
pub(crate) fn ask(
    dgd: &Path,
    jobs: usize,
    out: &Path,
    sealed: &[Sealed],
    rows: &mut [Row],
) -> Result<()> {
    let mut papers = Vec::new();
    let mut whose = Vec::new();
    for (at, row) in rows.iter().enumerate() {
        let effects: Vec<&str> = row.truth.names().collect();
        if effects.is_empty() || effects.contains(&"unknown") {
            continue;
        }
        let own = sealed.iter().find(|s| s.level == row.level);
        let level = format!("level-{}", row.level);
        papers.push(Paper {
            case: own.context("a case of no level")?.cases.join(&row.id),
            out: out.join("informed").join(level).join(&row.id),
            options: vec!["--suspect".into(), effects.join(",")],
            scope: Scope::Fit,
        });
        whose.push(at);
    }
    let exams = batch::all(dgd, jobs, &papers, " with the truth known");
    for (at, exam) in whose.into_iter().zip(exams) {
        rows[at].informed = Some(of(exam, rows[at].simulation.as_ref()));
    }
    Ok(())
}

fn of(exam: Exam, blind: Option<&Simulation>) -> Informed {
    let share = blind.zip(exam.simulation.as_ref());
    Informed {
        share: share.and_then(|(blind, knowing)| share_of(blind, knowing)),
        answer: exam.answer,
        simulation: exam.simulation,
        broken: exam.broken,
    }
}

/// `None` where knowing the truth gains nothing material in any signal.
pub(crate) fn share_of(blind: &Simulation, knowing: &Simulation) -> Option<Share> {
    let (mut reached, mut possible) = (0.0, 0.0);
    let mut by_signal = [None; 4];
    let pairs = blind.gains.iter().zip(&knowing.gains);
    for (share, (blind, knowing)) in by_signal.iter_mut().zip(pairs) {
        let (Some(blind), Some(knowing)) = (blind, knowing) else {
            continue;
        };
        // Each on its own base: held-out windows give way to onsets, so the two runs may hold out other ones.
        let (blind, knowing) = (1.0 - blind.ratio(), 1.0 - knowing.ratio());
        if knowing < MATERIAL {
            continue;
        }
        *share = Some(blind / knowing);
        reached += blind;
        possible += knowing;
    }
    (possible > 0.0).then(|| Share {
        by_signal,
        whole: reached / possible,
    })
}

/// Rows with a share.
fn shared(rows: &[Row]) -> impl Iterator<Item = (&Row, Share)> {
    rows.iter()
        .filter_map(|r| Some((r, r.informed.as_ref()?.share?)))
}

/// Those that reach less than 95 % of what the truth-knowing fit gains, worst first.
pub(crate) fn short(rows: &[Row]) -> Vec<(&Row, Share)> {
    let mut list: Vec<_> = shared(rows)
        .filter(|(_, s)| s.whole < TRUTH_SHARE)
        .collect();
    list.sort_by(|a, b| a.1.whole.total_cmp(&b.1.whole));
    list
}

/// The median share by signal, with the number of cases behind it, and the share of them that reach 95 %.
pub(crate) fn by_signal(rows: &[Row], level: u8) -> Vec<(&'static str, Option<f64>, Tally)> {
    let titles = SIGNAL_TITLES.iter().enumerate();
    titles
        .map(|(i, title)| {
            let own = shared(rows).filter(|(r, _)| r.level == level);
            let shares: Vec<f64> = own.filter_map(|(_, s)| s.by_signal[i]).collect();
            let mut reached = Tally::default();
            shares.iter().for_each(|s| reached.add(*s >= TRUTH_SHARE));
            (*title, median(&shares), reached)
        })
        .collect()
}

/// For a case of `proof.json`.
pub(crate) fn json_of(informed: &Informed) -> Value {
    let after: Vec<Option<f64>> = informed
        .simulation
        .iter()
        .flat_map(|s| s.gains)
        .map(|g| g.map(|g| g.rmse_after))
        .collect();
    json!({"share_of_gain": informed.share.map(|s| s.whole), "by_signal": informed.share.map(|s| s.by_signal),
           "rmse_after": after, "broken": informed.broken})
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may")]
    use super::super::simulation::Gain;
    use super::super::summary::tests::row;
    use super::*;

    fn simulation(after: [f64; 4]) -> Simulation {
        Simulation {
            gains: after.map(|rmse_after| {
                rmse_after.is_finite().then_some(Gain {
                    rmse_before: 2.0,
                    rmse_after,
                    samples: 100,
                })
            }),
            ..Simulation::default()
        }
    }

    #[test]
    fn a_blind_fit_as_good_as_the_knowing_one_reaches_all_of_its_gain() {
        let knowing = simulation([0.5, 1.99, 1.0, f64::NAN]);
        let all = share_of(&knowing, &knowing).unwrap();
        assert_eq!(all.by_signal, [Some(1.0), None, Some(1.0), None]);
        assert_eq!(all.whole, 1.0);
        let silent = simulation([2.0, 2.0, 2.0, f64::NAN]);
        assert_eq!(share_of(&silent, &knowing).unwrap().whole, 0.0);
    }

    #[test]
    fn the_whole_weighs_signals_by_what_there_is_to_gain() {
        let knowing = simulation([0.5, 2.0, 1.0, f64::NAN]);
        let blind = simulation([0.5, 2.0, 1.5, f64::NAN]);
        let share = share_of(&blind, &knowing).unwrap();
        assert_eq!(share.by_signal[2], Some(0.5));
        // 0.75 and 0.25 of 0.75 and 0.5.
        assert!((share.whole - 0.8).abs() < 1e-12);
    }

    #[test]
    fn where_knowing_the_truth_gains_nothing_there_is_no_share() {
        let faint = simulation([1.95, 2.1, f64::NAN, f64::NAN]);
        assert_eq!(share_of(&simulation([1.0; 4]), &faint), None);
    }

    #[test]
    fn cases_below_the_target_are_listed_worst_first() {
        let with = |whole: f64| {
            let mut case = row(&["influx"], Some(&[]));
            case.informed = Some(Informed {
                share: Some(Share {
                    by_signal: [Some(whole), None, None, None],
                    whole,
                }),
                ..Informed::default()
            });
            case
        };
        let rows = [with(0.9), with(0.96), with(0.2), row(&[], Some(&[]))];
        let found: Vec<f64> = short(&rows).iter().map(|s| s.1.whole).collect();
        assert_eq!(found, [0.2, 0.9]);
        let (title, middle, reached) = by_signal(&rows, 2)[0];
        assert_eq!((title, middle), ("return flow", Some(0.9)));
        assert_eq!(reached, Tally { right: 1, of: 3 });
        assert_eq!(by_signal(&rows, 1)[0].1, None);
    }
}
