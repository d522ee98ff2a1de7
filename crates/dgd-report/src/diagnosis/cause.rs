//! Candidates with their probabilities and evidence, and the test that would separate them.

use dgd_diagnose::{Diagnosis, Finding, Outcome};

use super::html::{Cell, Html};
use super::letter;
use super::quantity::{evidence, percent};
use super::words::{Rung, capital, listed, other_or_nothing, title, title_of};

const MOST_ALTERNATIVES: usize = 8;

pub(super) fn write(diagnosis: &Diagnosis, html: &mut Html) {
    if diagnosis.findings.is_empty() {
        nothing(diagnosis, html);
        return;
    }
    for (index, finding) in diagnosis.findings.iter().enumerate() {
        html.heading(&format!("{}. {}", letter(index), capital(&title(finding))));
        candidates(diagnosis, finding, html);
        apart(finding, html);
    }
    html.small(
        "Evidence is the natural logarithm of the Bayes factor: 1 to 3 is positive, 3 to 5 strong, above 5 very strong (Kass and Raftery 1995). \
         The final fit contains all findings; 'alone' tests each effect by itself against none. Probabilities grow with the evidence in \
         excess of what fault-free simulated recordings reach.",
    );
}

/// Without a finding: what came nearest.
fn nothing(diagnosis: &Diagnosis, html: &mut Html) {
    html.paragraph("No cause is claimed. The nearest effects, each alone against none:");
    let mut nearest: Vec<_> = diagnosis
        .tested
        .iter()
        .filter(|t| !matches!(t.outcome, Outcome::NotTestable(_)) && t.evidence.is_finite())
        .collect();
    nearest.sort_by(|a, b| b.evidence.total_cmp(&a.evidence));
    nearest.truncate(5);
    if nearest.is_empty() {
        html.small("No effect could be tested.");
        return;
    }
    let rows: Vec<Vec<Cell>> = nearest
        .iter()
        .map(|t| {
            vec![
                Cell::Named(capital(t.title), t.effect.to_owned()),
                Cell::Number(evidence(t.evidence)),
                Cell::Text(in_words(t.evidence).to_owned()),
            ]
        })
        .collect();
    html.table(
        "Evidence for the nearest effects.",
        &["Effect", "ln Bayes factor", "In words"],
        &rows,
        "wide-first",
    );
    html.small(
        "Natural logarithm of the Bayes factor against no effect; a negative value favours no effect (Kass and Raftery 1995). Many effects were \
         tried, so the hurdle for a finding is higher than one effect alone would need.",
    );
}

fn in_words(evidence: f64) -> &'static str {
    if !evidence.is_finite() {
        "–"
    } else if evidence < 0.0 {
        "evidence against it"
    } else if evidence < 1.0 {
        "not worth a mention"
    } else if evidence < 3.0 {
        "positive"
    } else if evidence < 5.0 {
        "strong"
    } else {
        "very strong"
    }
}

fn candidates(diagnosis: &Diagnosis, finding: &Finding, html: &mut Html) {
    let first_weighed = |id: &str| {
        diagnosis
            .tested
            .iter()
            .find(|t| t.effect == id && !matches!(t.outcome, Outcome::NotTestable(_)))
            .map_or_else(|| "–".to_owned(), |t| evidence(t.evidence))
    };
    let row = |words: String, id: &str, probability: f64, fitted: String, first: bool| {
        vec![
            Cell::Named(capital(&words), id.to_owned()),
            Cell::Bar(probability, percent(probability), first),
            Cell::Number(fitted),
            Cell::Number(first_weighed(id)),
        ]
    };
    let mut rows = vec![row(
        title(finding),
        &finding.effect,
        finding.probability,
        evidence(finding.evidence),
        true,
    )];
    let shown = finding.alternatives.iter().take(MOST_ALTERNATIVES);
    rows.extend(
        shown
            .clone()
            .map(|(id, p)| row(title_of(id), id, *p, "–".to_owned(), false)),
    );
    let told: f64 = finding.probability + shown.map(|a| a.1).sum::<f64>();
    if told.is_finite() && told < 0.995 {
        rows.push(vec![
            Cell::Text("Chance, or another effect of the catalogue".to_owned()),
            Cell::Bar(1.0 - told, percent(1.0 - told), false),
            Cell::Number("–".to_owned()),
            Cell::Number("–".to_owned()),
        ]);
    }
    html.table(
        "Candidates, likeliest first.",
        &[
            "Candidate",
            "Probability",
            "ln Bayes factor, final fit",
            "ln Bayes factor, alone",
        ],
        &rows,
        "candidates",
    );
}

/// What cannot be told apart, and how it could be.
fn apart(finding: &Finding, html: &mut Html) {
    let rivals: Vec<String> = finding
        .serious()
        .map(|(id, _)| format!("“{}”", title_of(id)))
        .collect();
    let count = rivals.len();
    if count == 0 {
        if !finding.is_unknown() {
            let others = "no other effect has a probability of 5 % or more on this recording";
            match Rung::of(finding) {
                Rung::Class => html.labelled(
                    "Not sure:",
                    &format!("{others}, but {}.", other_or_nothing(finding)),
                ),
                _ => html.labelled("Separated:", &format!("{others}.")),
            };
        }
    } else {
        let rivals = listed(&rivals, "or");
        if Rung::of(finding) == Rung::Class {
            html.labelled(
                "Cannot be separated on this recording:",
                &format!("“{}” from {rivals}.", title(finding)),
            );
        } else {
            html.labelled("Less likely, but not ruled out:", &format!("{rivals}."));
        }
    }
    if let Some(described) = &finding.same_as {
        let described = described.trim().trim_end_matches('.');
        html.labelled(
            "The recording would look the same with the following instead; rule it out first:",
            &format!("{described}."),
        );
    }
    // None is known but for a serious rival.
    if let Some(test) = &finding.separating_test {
        let test = test.trim().trim_end_matches('.');
        html.open("div", "todo")
            .labelled(
                if count > 1 {
                    "A test that would separate it from one of them:"
                } else {
                    "A test that would separate them:"
                },
                &format!("{test}."),
            )
            .close("div");
    }
}
