//! The relation as the base model has it and with the effect, and what was estimated.

use dgd_diagnose::{Diagnosis, Finding};
use dgd_effects::{About, find};

use super::html::{Cell, Html};
use super::quantity::split;
use super::words::{capital, held_title, title};
use super::{correction, glossary, letter, plain};

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
    let held: Vec<&About> = (diagnosis.started_from.iter())
        .filter_map(|id| find(id).map(|effect| effect.about()))
        .collect();
    if diagnosis.findings.is_empty() {
        html.paragraph(if held.is_empty() {
            "Nothing was added; the relations are those of the base model."
        } else {
            "Nothing was added; the relations are those of the starting model."
        });
        for (name, equation) in BASE {
            base(name, equation, html);
        }
        given(&held, html);
        let equations = BASE.iter().map(|(_, equation)| *equation);
        glossary::write(equations.chain(held.iter().map(|a| a.equation)), html);
        html.small(
            "Source: Slettebø 2015, Eqs. 3.13, 2.27, 3.45 and 3.46, with the friction F(q) and the head H(w, q) as \
             smooth curves fitted to the recording.",
        );
        return;
    }
    for (index, finding) in diagnosis.findings.iter().enumerate() {
        one(index, finding, html);
    }
    given(&held, html);
    let equations = diagnosis.findings.iter();
    glossary::write(
        equations
            .flat_map(|f| [f.equation_before.as_str(), f.equation_after.as_str()])
            .chain(held.iter().map(|a| a.equation)),
        html,
    );
}

fn base(name: &str, equation: &str, html: &mut Html) {
    html.open("div", "equation base")
        .element("span", "side", name)
        .mathml(&plain::formula(equation))
        .close("div");
}

/// What the model to start from holds, with its equations.
fn given(held: &[&About], html: &mut Html) {
    for about in held {
        html.paragraph(&format!("In the starting model, {}.", held_title(about.id)));
        base("Held", about.equation, html);
    }
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
    if let Some(curve) = &finding.curve {
        html.paragraph(
            "The correction is empirical: it has the shape of the residual; no physical cause is claimed.",
        );
        correction::picture(curve, html);
    } else if finding.is_unknown() {
        html.paragraph(
            "The equation is only an approximation: an effect of the catalogue explains much of the difference, but in a form that does not hold. \
             No physical cause is claimed.",
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
        "Estimates from the whole recording; the runs below, and model.toml, use estimates without the held-out windows.",
        &["Parameter", "Estimate", "95 % interval"],
        &rows,
        "wide-first",
    );
}
