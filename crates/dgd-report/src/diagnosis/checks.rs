//! Checks passed and failed, what was tested down to which size, and the settings.

use dgd_diagnose::{Diagnosis, Outcome, Tested};

use super::html::{Cell, Html};
use super::quantity::{clock, evidence, significant, split};
use super::words::{self, capital};

pub(super) fn write(diagnosis: &Diagnosis, html: &mut Html) {
    html.heading("Checks");
    checks(diagnosis, html);
    html.heading("What was tested, and down to what size");
    tested(diagnosis, html);
    html.heading("Settings");
    settings(diagnosis, html);
}

fn checks(diagnosis: &Diagnosis, html: &mut Html) {
    if diagnosis.checks.is_empty() {
        html.paragraph("There was no finding to check.");
        return;
    }
    let failed = diagnosis.checks.iter().filter(|c| !c.passed).count();
    let mut ordered: Vec<_> = diagnosis.checks.iter().collect();
    ordered.sort_by_key(|c| c.passed);
    let rows: Vec<Vec<Cell>> = ordered
        .iter()
        .map(|check| {
            vec![
                Cell::Text(capital(&named(&check.name))),
                if check.passed {
                    Cell::Mark("good", "passed".to_owned())
                } else {
                    Cell::Mark("open", "failed".to_owned())
                },
                Cell::Text(check.detail.clone()),
            ]
        })
        .collect();
    html.table(
        &format!(
            "{} passed, {failed} failed.",
            diagnosis.checks.len() - failed
        ),
        &["Check", "Outcome", "Numbers"],
        &rows,
        "",
    );
}

/// A check of one effect begins with its id.
fn named(check: &str) -> String {
    let known = check
        .split_once(": ")
        .filter(|(id, _)| dgd_effects::find(id).is_some());
    known.map_or_else(
        || check.to_owned(),
        |(id, what)| format!("{}: {what}", words::title_of(id)),
    )
}

fn tested(diagnosis: &Diagnosis, html: &mut Html) {
    if diagnosis.tested.is_empty() {
        html.paragraph("No effect of the catalogue was tested.");
        return;
    }
    let rank = |t: &Tested| match t.outcome {
        Outcome::Found => 0,
        Outcome::Resembled => 1,
        Outcome::NotSeen => 2,
        Outcome::NotTestable(_) => 3,
    };
    let mut seen: Vec<&Tested> = diagnosis.tested.iter().filter(|t| rank(t) < 3).collect();
    seen.sort_by(|a, b| {
        let by_evidence = b.evidence.total_cmp(&a.evidence);
        rank(a).cmp(&rank(b)).then(by_evidence)
    });
    if !seen.is_empty() {
        let rows: Vec<Vec<Cell>> = seen
            .iter()
            .map(|t| row(t, !diagnosis.findings.is_empty()))
            .collect();
        if !diagnosis.suspected.is_empty() {
            html.paragraph(&format!(
                "Only what was suspected was fitted ({}), and judged beside what a search of the whole catalogue finds; every other effect is listed as it was tested by itself, before anything was named.",
                diagnosis.suspected.join(", ")
            ));
        }
        html.table(
            "The smallest size is the strength that this recording would have shown beside the findings; of a gain or an area (±) the departure from \
             what the model has. The evidence is that of each effect \
             alone, when first tested; sound rigs reach less than the evidence needed. 'Not needed': the effect exceeded this alone but adds \
             nothing to the findings. 'Resembled': it stands in the model for a cause outside the catalogue.",
            &[
                "Effect",
                "Outcome",
                "Smallest size",
                "ln Bayes factor, alone",
                "Needed",
            ],
            &rows,
            "compact",
        );
    }
    let rows: Vec<Vec<Cell>> = diagnosis
        .tested
        .iter()
        .filter_map(|t| match &t.outcome {
            Outcome::NotTestable(why) => Some(vec![
                Cell::Named(capital(t.title), t.effect.to_owned()),
                Cell::Text(capital(why)),
            ]),
            _ => None,
        })
        .collect();
    if rows.is_empty() {
        html.paragraph("Every effect of the catalogue could be tested on this recording.");
    } else {
        html.table(
            "Not testable on this recording.",
            &["Effect", "Why"],
            &rows,
            "compact",
        );
    }
}

fn row(tested: &Tested, beside: bool) -> Vec<Cell> {
    let (name, unit) = split(tested.strength);
    let limit = tested.limit.filter(|l| l.is_finite()).map_or_else(
        || "–".to_owned(),
        |limit| {
            let side = if tested.is_departure() { "±" } else { "" };
            format!("{name} {side}{}", unit.value(limit))
        },
    );
    vec![
        Cell::Named(capital(tested.title), tested.effect.to_owned()),
        if tested.outcome == Outcome::Found {
            Cell::Mark("found", "found".to_owned())
        } else if tested.outcome == Outcome::Resembled {
            Cell::Mark("open", "resembled".to_owned())
        } else if beside && tested.exceeded_its_hurdle() {
            Cell::Mark("quiet", "not needed".to_owned())
        } else {
            Cell::Mark("quiet", "not seen".to_owned())
        },
        Cell::Number(limit),
        Cell::Number(evidence(tested.evidence)),
        Cell::Number(evidence(tested.hurdle)),
    ]
}

fn settings(diagnosis: &Diagnosis, html: &mut Html) {
    let (from, to) = words::span(diagnosis);
    let setting = &diagnosis.setting;
    let mut pairs = vec![
        ("Recording".to_owned(), clock(to - from)),
        (
            "Samples".to_owned(),
            crate::axis::count(diagnosis.simulation.t_s.len()),
        ),
        (
            "Held-out windows".to_owned(),
            diagnosis.held_out_s.len().to_string(),
        ),
        (
            "Mud density of the well file".to_owned(),
            format!("{} kg/m³", significant(setting.density_kg_m3, 4)),
        ),
        (
            "Riser annulus".to_owned(),
            format!("{} m²", significant(setting.riser_area_m2, 4)),
        ),
        (
            "Return line".to_owned(),
            format!(
                "{} m, bore {} m",
                significant(setting.line_length_m, 4),
                significant(setting.line_diameter_m, 3)
            ),
        ),
        (
            "Connections".to_owned(),
            setting.connections.len().to_string(),
        ),
    ];
    if !diagnosis.before.effects.is_empty() {
        let ids: Vec<&str> = diagnosis
            .before
            .effects
            .iter()
            .map(|e| e.id.as_str())
            .collect();
        pairs.push((
            "Effects in the model without the findings".to_owned(),
            ids.join(", "),
        ));
    }
    let told = diagnosis
        .settings
        .iter()
        .filter(|(_, value)| !value.is_empty());
    pairs.extend(told.cloned());
    let rows: Vec<Vec<Cell>> = pairs
        .into_iter()
        .map(|(name, value)| vec![Cell::Text(capital(&name)), Cell::Text(value)])
        .collect();
    html.table(
        "Settings and facts of the run.",
        &["Name", "Value"],
        &rows,
        "settings",
    );
}
