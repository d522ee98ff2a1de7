//! Every case that was not answered rightly: what was concealed, what was said, how to repeat it.

use super::Settings;
use super::answer::Answer;
use super::summary::{Row, SIGNAL_TITLES};
use super::truth::{Sort, Truth};
use std::fmt::Write;

/// Worst first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Fault {
    Broken,
    FalseAlarm,
    WrongName,
    PassedOver,
    /// Named rightly, but something else is wrong.
    Beside,
}

pub(crate) const FAULTS: [(Fault, &str); 5] = [
    (Fault::Broken, "Rules broken"),
    (Fault::FalseAlarm, "False alarms on clean recordings"),
    (Fault::WrongName, "Wrong names"),
    (Fault::PassedOver, "Passed over in silence"),
    (Fault::Beside, "Named rightly, but"),
];

/// The worst that is wrong with a case; `None` if nothing is.
pub(crate) fn fault(row: &Row) -> Option<Fault> {
    if !row.broken.is_empty() {
        return Some(Fault::Broken);
    }
    if row.marks.exact {
        return (!remarks(row).is_empty()).then_some(Fault::Beside);
    }
    Some(match row.sort() {
        Sort::Clean => Fault::FalseAlarm,
        _ if row.marks.extra.is_empty() => Fault::PassedOver,
        _ => Fault::WrongName,
    })
}

/// Cases with that fault.
pub(crate) fn with(rows: &[Row], wanted: Fault) -> impl Iterator<Item = &Row> {
    rows.iter().filter(move |r| fault(r) == Some(wanted))
}

/// What else is wrong: relation, interval, parameters, transmitter, held-out windows.
pub(crate) fn remarks(row: &Row) -> Vec<String> {
    let marks = &row.marks;
    let mut list = Vec::new();
    if marks.confidently_wrong() > 0 {
        list.push("confidently wrong".into());
    }
    if !marks.relation.iter().all(|r| *r) {
        list.push("another relation".into());
    }
    for overlap in marks.overlap.iter().filter(|o| **o < 0.5) {
        list.push(format!("interval overlaps by {overlap:.2}"));
    }
    for p in &marks.parameters {
        match p.error {
            None => list.push(format!("`{}` not given", p.name)),
            Some(error) if !p.covered => {
                list.push(format!(
                    "ci95 of `{}` misses, {:.0} % off",
                    p.name,
                    100.0 * error
                ));
            }
            _ => {}
        }
    }
    if marks.sensor == Some(false) {
        list.push("another transmitter".into());
    }
    if let Some(simulation) = &row.simulation {
        if !simulation.keeps_rules() {
            list.push(format!(
                "held-out windows: {:.0} % of the recording, shortest {:.0} s",
                100.0 * simulation.held_share,
                simulation.shortest_window_s
            ));
        }
        for (title, gain) in SIGNAL_TITLES.iter().zip(&simulation.gains) {
            if let Some(gain) = gain.filter(|g| g.worse()) {
                list.push(format!("{title} made worse, {:.2} times", gain.ratio()));
            }
        }
        if simulation.unmodelled() && !marks.found.is_empty() {
            list.push("claimed but not modelled".into());
        }
    }
    list
}

pub(crate) fn concealed(truth: &Truth) -> String {
    let effects = truth.effects.iter().map(|e| {
        let parameters = e.parameters.iter().map(|(n, v)| format!(" {n} {v:.4e}"));
        let what = e.kind.as_deref().map_or_else(
            || e.effect.clone(),
            |kind| format!("{kind} (in no catalogue)"),
        );
        let when = e
            .interval_s
            .map_or_else(String::new, |(a, b)| format!(" {a:.0}–{b:.0} s"));
        format!(
            "{what}, {}{}{when}",
            e.severity,
            parameters.collect::<String>()
        )
    });
    let text = effects.collect::<Vec<_>>().join(" + ");
    if text.is_empty() {
        "nothing".into()
    } else {
        text
    }
}

pub(crate) fn said(answer: Option<&Answer>) -> String {
    let Some(answer) = answer else {
        return "no answer".into();
    };
    let findings = answer.findings.iter().map(|f| {
        let others = f.alternatives.iter();
        let others: Vec<String> = others.map(|(a, p)| format!("{a} {p:.2}")).collect();
        let or = if others.is_empty() {
            String::new()
        } else {
            format!(" (or {})", others.join(", "))
        };
        format!("{} {:.2}{or}", f.effect, f.probability)
    });
    let text = findings.collect::<Vec<_>>().join(" + ");
    let colon = if text.is_empty() { "" } else { ": " };
    format!("{}{colon}{text}", answer.verdict)
}

/// The command that runs this case again.
pub(crate) fn repeat(settings: &Settings, row: &Row) -> String {
    format!(
        "cargo xtask prove --seed {} --level {} --count {}{} --only {} --keep --out target/proof-again",
        settings.seed,
        row.level,
        settings.count,
        settings.of_kind(),
        row.id
    )
}

/// `failures.md`
pub(crate) fn write(settings: &Settings, rows: &[Row]) -> String {
    let mut text = format!(
        "# Failures\n\nSeed {}, {} recordings. Sizes in SI. A case is repeated by the command below it; the recording and the \
         answer are then in `target/proof-again`.\n",
        settings.seed,
        rows.len()
    );
    for (kind, title) in FAULTS {
        let cases: Vec<&Row> = with(rows, kind).collect();
        // Writing into a string cannot fail, here and below.
        let _ = write!(text, "\n## {title}: {}\n", cases.len());
        for row in cases {
            let _ = write!(
                text,
                "\n### level {} {} ({}, {:.0} h)\n\n- concealed: {}\n- said: {}\n",
                row.level,
                row.id,
                row.truth.well,
                row.truth.hours,
                concealed(&row.truth),
                said(row.answer.as_ref())
            );
            for remark in row.broken.iter().chain(&remarks(row)) {
                let _ = writeln!(text, "- {remark}");
            }
            let _ = writeln!(text, "- `{}`", repeat(settings, row));
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::super::simulation::Simulation;
    use super::super::summary::tests::row;
    use super::*;

    #[test]
    fn the_worst_fault_of_a_case_is_the_one_it_is_listed_under() {
        assert_eq!(fault(&row(&["heave"], Some(&[("heave", 0.9)]))), None);
        assert_eq!(fault(&row(&[], Some(&[]))), None);
        let of = |concealed: &[&str], said: &[(&str, f64)]| fault(&row(concealed, Some(said)));
        assert_eq!(of(&[], &[("heave", 0.6)]), Some(Fault::FalseAlarm));
        assert_eq!(of(&["heave"], &[("influx", 0.6)]), Some(Fault::WrongName));
        assert_eq!(of(&["heave"], &[("heave", 0.3)]), Some(Fault::PassedOver));
        let mut broken = row(&[], Some(&[("heave", 0.9)]));
        broken.broken.push("simulation.csv: empty".into());
        assert_eq!(fault(&broken), Some(Fault::Broken));
    }

    #[test]
    fn a_right_name_with_short_windows_is_listed_beside() {
        let mut case = row(&["heave"], Some(&[("heave", 0.9)]));
        case.simulation = Some(Simulation {
            held_share: 0.25,
            shortest_window_s: 600.0,
            ..Simulation::default()
        });
        assert_eq!(fault(&case), Some(Fault::Beside));
        let text = write(&Settings::short("proof".into()), &[case]);
        assert!(
            text.contains("shortest 600 s") && text.contains("--only c000"),
            "{text}"
        );
    }

    #[test]
    fn what_was_concealed_and_said_reads_as_a_sentence() {
        let case = row(&["unknown"], Some(&[("influx", 0.7), ("heave", 0.25)]));
        assert_eq!(
            said(case.answer.as_ref()),
            "explained: influx 0.70 + heave 0.25"
        );
        assert_eq!(said(None), "no answer");
        assert_eq!(concealed(&case.truth), "unknown, moderate");
        assert_eq!(concealed(&row(&[], None).truth), "nothing");
    }
}
