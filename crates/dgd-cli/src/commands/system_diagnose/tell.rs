//! A diagnosis of a system for the terminal, and the words that its page shares.

use super::{Done, name, probability, sentence};
use crate::say::{TextTable, brief, number};
use crate::system::quantity::Quantity;
use crate::system::{bounds, measure::Measure, page, quantity};
use dgd_assembly::Assembly;
use dgd_revise::{Estimate, Finding, Verdict};
use std::fmt::Write as _;
use std::path::Path;

pub(super) fn answer(text: &mut String, done: &Done, out: &Path) -> std::fmt::Result {
    let revision = &done.revision;
    writeln!(
        text,
        "{} on {}: {}",
        done.title,
        done.recording,
        revision.verdict.name()
    )?;
    writeln!(text, "{}\n", sentence(done))?;
    let assembly = &revision.after.assembly;
    for finding in &revision.findings {
        told(text, assembly, finding)?;
    }
    for finding in &revision.also_possible {
        write!(text, "also possible: ")?;
        told(text, assembly, finding)?;
    }
    write!(text, "{}", gains(done).render())?;
    if let Some(line) = unwritten(done) {
        writeln!(text, "{line}")?;
    }
    checks(text, done)?;
    if let Some(line) = no_accuracy(done) {
        writeln!(text, "{line}")?;
    }
    let shown = out.display();
    writeln!(
        text,
        "\nwrote {shown}/diagnosis.json, simulation.csv and model.toml; open {shown}/report.html"
    )
}

/// What of the answer `model.toml` does not hold, and what it leaves.
pub(super) fn unwritten(done: &Done) -> Option<String> {
    let revision = &done.revision;
    let Some(finding) = revision.unwritten() else {
        let mut beside = revision.findings.iter().filter_map(|f| f.shape.as_ref());
        let shape = beside.next()?;
        return Some(format!(
            "the correction of {} along {} is part neither of \"after\" nor of model.toml, which simulates as \"after\"",
            shape.of, shape.along
        ));
    };
    let shape = finding.shape.as_ref()?;
    let outputs = || revision.outputs.iter().zip(&done.gauges);
    let tested = outputs().any(|(gain, _)| gain.test.0.is_finite());
    let part = if tested { "held out" } else { "training" };
    let left: Vec<String> = outputs()
        .filter_map(|(gain, gauge)| {
            let before = if tested { gain.test.0 } else { gain.training.0 };
            let shown = gauge.with_unit(&brief(gauge.difference(before)));
            (before.is_finite()).then(|| format!("{} {shown}", gain.output))
        })
        .collect();
    Some(format!(
        "\"after\" contains the correction of {} along {}, which no component can hold: it is not in model.toml, which simulates as before it \
         (off by, rms, {part}: {})",
        shape.of,
        shape.along,
        left.join(", ")
    ))
}

/// What is left without a name may be no more than the instruments leave.
fn no_accuracy(done: &Done) -> Option<String> {
    let revision = &done.revision;
    if !matches!(
        revision.verdict,
        Verdict::Unexplained | Verdict::PartlyExplained
    ) {
        return None;
    }
    let accuracies = revision.after.assembly.accuracies();
    let without: Vec<&str> = (done.gauges.iter().zip(accuracies))
        .filter(|(_, accuracy)| accuracy.is_none())
        .map(|(gauge, _)| gauge.name.as_str())
        .collect();
    (!without.is_empty()).then(|| {
        format!(
            "no `accuracy` is given for {}: a mismatch within accuracy is not counted",
            without.join(", ")
        )
    })
}

fn told(text: &mut String, assembly: &Assembly, finding: &Finding) -> std::fmt::Result {
    writeln!(text, "{}: {}", name(finding), finding.title)?;
    if !finding.equation.is_empty() {
        writeln!(text, "  {}", finding.equation)?;
    }
    if let Some(line) = likely(finding) {
        writeln!(text, "  {line}")?;
    }
    for p in &finding.parameters {
        writeln!(
            text,
            "  {}: {}",
            parameter(assembly, p),
            meaning(assembly, p)
        )?;
    }
    for line in places(assembly, finding) {
        writeln!(text, "  {line}")?;
    }
    let alternatives: Vec<&str> = finding.alternatives.iter().map(|a| a.0.as_str()).collect();
    if !alternatives.is_empty() {
        writeln!(text, "  not separated from: {}", alternatives.join(", "))?;
    }
    if let Some(test) = &finding.separating_test {
        writeln!(text, "  what would separate them: {test}")?;
    }
    writeln!(text)
}

/// `probability 0.45, with its alternatives 0.52: ..`
pub(super) fn likely(finding: &Finding) -> Option<String> {
    let p = finding.probability?;
    let together = finding.probability_with_alternatives;
    let together = together.filter(|_| !finding.alternatives.is_empty());
    let together = together.map(probability).filter(|t| *t != probability(p));
    let together = together.map_or_else(String::new, |t| format!(", with its alternatives {t}"));
    Some(format!(
        "probability {}{together}: the share of such weights that were right where the truth was known",
        probability(p)
    ))
}

/// A parameter with its unit and its interval, as it stands among all parameters too.
pub(super) fn parameter(assembly: &Assembly, e: &Estimate) -> String {
    let measure = Measure::of(assembly.system(), &e.path);
    let unit = &measure.symbol;
    let gap = if unit.is_empty() { "" } else { " " };
    let bounds = measure.ends(bounds(assembly, &e.path));
    let (value, ci95) = (measure.shown(e.value), measure.ends(e.ci95));
    let told = page::Told::of(value, e.at_bound, ci95, bounds);
    let said = match told.ends {
        Some([from, to]) => format!("95 %: {from} to {to}"),
        None => told.note.to_owned(),
    };
    format!("{} = {}{gap}{unit} ({said})", e.path, told.value)
}

/// What a parameter means, with the time of this record where the catalogue counts in usual times.
pub(super) fn meaning(assembly: &Assembly, e: &Estimate) -> String {
    let clock = Quantity::of(assembly, &assembly.system().independent);
    let thousand = 1000.0 * assembly.usual_time_s();
    e.meaning
        .replace("a thousand usual times", &clock.range((thousand, thousand)))
}

/// Where it lies: in the operating space, and along the recording.
pub(super) fn places(assembly: &Assembly, finding: &Finding) -> Vec<String> {
    let mut lines = Vec::new();
    lines.extend(
        finding
            .region
            .as_ref()
            .map(|r| quantity::place(assembly, r)),
    );
    let stretches = quantity::stretches(assembly, &finding.intervals);
    if !stretches.is_empty() {
        let along = &assembly.system().independent;
        lines.push(format!("most of it at {along} {stretches}"));
    }
    lines
}

fn gains(done: &Done) -> TextTable {
    let mut table = TextTable::new([
        "off by, rms",
        "training",
        "after",
        "held out",
        "after",
        "unit",
    ]);
    for (gain, gauge) in done.revision.outputs.iter().zip(&done.gauges) {
        let cell = |v: f64| {
            if v.is_finite() {
                number(gauge.difference(v))
            } else {
                String::new()
            }
        };
        table.row([
            gain.output.clone(),
            cell(gain.training.0),
            cell(gain.training.1),
            cell(gain.test.0),
            cell(gain.test.1),
            gauge.symbol.clone(),
        ]);
    }
    table
}

fn checks(text: &mut String, done: &Done) -> std::fmt::Result {
    let revision = &done.revision;
    let passed = revision.checks.iter().filter(|c| c.passed).count();
    writeln!(
        text,
        "\nchecks: {passed} of {} passed",
        revision.checks.len()
    )?;
    // Why nothing was found rests on what was checked.
    let all = revision.verdict == Verdict::Consistent;
    for check in revision.checks.iter().filter(|c| all || !c.passed) {
        let lead = if check.passed { "passed" } else { "failed" };
        writeln!(text, "  {lead}: {}: {}", check.name, check.detail)?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may")]
    use super::*;

    #[test]
    fn a_drift_is_told_in_the_time_of_the_record() {
        let tank = |lines: &str| {
            let text = format!(
                r#"
{lines}
connections = ["tank -> valve -> atmosphere"]
[components]
tank = {{ kind = "tank", area = 1.0 }}
valve = {{ kind = "valve", flow_coefficient = 1e-5 }}
gauge = {{ kind = "instrument", measures = "level", of = "tank" }}
[initial]
"tank.level" = 1.0
"#
            );
            Assembly::parse(&text).unwrap()
        };
        let share = Estimate {
            path: "valve.clogging.share".into(),
            meaning: "share of the opening lost in a thousand usual times".into(),
            value: 0.2,
            standard_error: 0.01,
            ci95: (0.18, 0.22),
            at_bound: false,
        };
        for (lines, told) in [
            ("scale = { time = 4.0 }", "lost in 4000 s"),
            (
                "scale = { time = \"4 min\" }\nrecord = { unit = \"min\" }",
                "lost in 240000 s",
            ),
        ] {
            let found = meaning(&tank(lines), &share);
            assert!(found.ends_with(told), "{found}");
        }
    }
}
