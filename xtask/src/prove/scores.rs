//! `scores.md`: the scores as a table that can be kept beside the code.

use super::ablation::{self, Figures, OfStep, Unit};
use super::measures::{Measure, measures};
use super::{Proof, summary::Summary};
use std::fmt::Write as _;

pub(crate) fn write(proof: &Proof) -> String {
    let commit = proof.origin.program.commit.as_deref().unwrap_or("unknown");
    let mut text = format!(
        "Seed {}, {} recordings a level{}, commit {commit}.\n",
        proof.settings.seed,
        proof.settings.count,
        (proof.settings.hours).map_or_else(String::new, |h| format!(" of {h} h"))
    );
    text += &table(proof.summaries);
    for summary in proof.summaries {
        text += &steps(proof.steps, summary.level);
    }
    text
}

/// One row a measure, value and basis of each level, the target last.
fn table(summaries: &[Summary]) -> String {
    let columns: Vec<Vec<Measure>> = summaries.iter().map(measures).collect();
    let mut text = "\n| measure |".to_owned();
    // Writing into a string cannot fail, here and below.
    for s in summaries {
        let _ = write!(text, " level {} |", s.level);
    }
    text += " target |\n|---|";
    text += &"---|".repeat(summaries.len() + 1);
    text.push('\n');
    let Some(first) = columns.first() else {
        return text;
    };
    for (k, measure) in first.iter().enumerate() {
        let _ = write!(text, "| {} |", measure.title);
        for column in &columns {
            let score = column[k].score;
            let cell = format!("{} {}", score.value().trim(), score.basis());
            let _ = write!(text, " {} |", cell.trim());
        }
        let targets: Vec<String> = (columns.iter())
            .filter_map(|c| Some(c[k].target?.text(c[k].score)))
            .collect();
        let same = targets.windows(2).all(|w| w[0] == w[1]);
        let told = if same {
            targets.first().cloned()
        } else {
            Some(targets.join("; "))
        };
        let _ = writeln!(text, " {} |", told.unwrap_or_default());
    }
    text
}

/// What each step contributes at a level; empty where none was left out.
fn steps(list: &[OfStep], level: u8) -> String {
    let here: Vec<&OfStep> = list.iter().filter(|s| s.level == level).collect();
    if here.is_empty() {
        return String::new();
    }
    let mut text = format!(
        "\n{}\n\n| without | {} | answers it mends | spoils |\n|---|{}---|---|\n",
        ablation::words(list, level),
        Figures::titles().join(" | "),
        "---|".repeat(Figures::titles().len())
    );
    let cells = |f: &Figures| -> String {
        let told = |(unit, value): (Unit, Option<f64>)| {
            value.map_or_else(|| "–".to_owned(), |v| unit.value(v))
        };
        let told: Vec<String> = f.list().into_iter().map(told).collect();
        told.join(" | ")
    };
    if let Some(one) = here.first() {
        let _ = writeln!(text, "| nothing | {} | | |", cells(&one.whole));
    }
    for s in here {
        let _ = writeln!(
            text,
            "| {} | {} | {} | {} |",
            s.step,
            cells(&s.without),
            s.better.len(),
            s.worse.len()
        );
    }
    text
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may fail by panic")]

    use super::super::summary::tests::row;
    use super::*;

    #[test]
    fn every_row_has_a_cell_for_each_level_and_the_target() {
        let rows = [
            row(&["heave"], Some(&[("heave", 0.9)])),
            row(&[], Some(&[])),
        ];
        let text = table(&[Summary::of(1, &rows), Summary::of(2, &rows)]);
        let lines: Vec<&str> = text.lines().skip(1).collect();
        assert!(lines.len() > 10);
        for line in &lines {
            assert_eq!(line.matches('|').count(), 5, "{line}");
        }
        assert!(lines[0].contains("level 1 | level 2 | target"));
        let alarms = lines.iter().find(|l| l.contains("clean")).unwrap();
        assert!(alarms.contains("0/1"), "{alarms}");
    }
}
