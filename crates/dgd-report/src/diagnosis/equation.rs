//! The relation as the base model has it and with the effect, and what was estimated.

use dgd_diagnose::{Diagnosis, Finding};

use super::html::{Cell, Html};
use super::quantity::split;
use super::words::{capital, is_unknown, title};
use super::{glossary, letter, plain};

/// The relations of the base model, for a page without findings.
const BASE: [(&str, &str); 4] = [
    ("Return line", "p_out = p_0 + rho g L + F(q)"),
    ("Pump", "p_out - p_in = H(w, q)"),
    ("Riser", "A dh/dt = q_in - q"),
    (
        "Momentum",
        "rho L/A_line dq/dt = p_in + H(w, q) - p_0 - rho g L - F(q)",
    ),
];

pub(super) fn write(diagnosis: &Diagnosis, html: &mut Html) {
    if diagnosis.findings.is_empty() {
        html.paragraph("Nothing was added; the relations stand as the base model has them.");
        for (name, equation) in BASE {
            html.open("div", "equation base")
                .element("span", "side", name)
                .mathml(&plain::formula(equation))
                .close("div");
        }
        glossary::write(BASE.map(|(_, equation)| equation), html);
        html.small(
            "Source: Slettebø 2015, Eqs. 3.13, 2.27, 3.45 and 3.46, with the friction F(q) and the head H(w, q) as \
             smooth curves fitted to the recording.",
        );
        return;
    }
    for (index, finding) in diagnosis.findings.iter().enumerate() {
        one(index, finding, html);
    }
    let equations = diagnosis.findings.iter();
    glossary::write(
        equations.flat_map(|f| [f.equation_before.as_str(), f.equation_after.as_str()]),
        html,
    );
}

fn one(index: usize, finding: &Finding, html: &mut Html) {
    html.heading(&format!("{}. {}", letter(index), capital(&title(finding))));
    for (side, class, equation) in [
        ("Before", "equation", &finding.equation_before),
        ("After", "equation after", &finding.equation_after),
    ] {
        html.open("div", class).element("span", "side", side);
        if equation.trim().is_empty() {
            html.element("span", "none", "not stated");
        } else {
            html.mathml(&plain::formula(equation));
        }
        html.close("div");
    }
    if !finding.source.trim().is_empty() {
        html.small(&format!(
            "Source: {}.",
            finding.source.trim_end_matches('.')
        ));
    }
    if is_unknown(finding) {
        html.paragraph(
            "The correction is empirical: it has the shape that the residual shows, no physical cause is claimed.",
        );
    }
    if finding.parameters.is_empty() {
        return;
    }
    let rows: Vec<Vec<Cell>> = finding
        .parameters
        .iter()
        .map(|p| {
            let (name, unit) = split(&p.name);
            let meaning = if p.meaning.is_empty() {
                &name
            } else {
                &p.meaning
            };
            vec![
                Cell::Named(capital(meaning), p.name.clone()),
                Cell::Number(unit.estimate(p.estimate, p.ci95)),
                Cell::Number(
                    unit.interval(p.estimate, p.ci95)
                        .unwrap_or_else(|| "–".to_owned()),
                ),
            ]
        })
        .collect();
    html.table(
        "What was estimated, on the whole recording; the runs below use estimates without the held-out windows.",
        &["Parameter", "Estimate", "95 % interval"],
        &rows,
        "wide-first",
    );
}
