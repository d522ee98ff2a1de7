//! `real.html`: self-contained, in the style of the proof's page.

use super::cases::{Aim, CASES, Case};
use super::{Done, Outcome, word};
use crate::prove::page::{self, Cell, put};
use crate::prove::svg::{Anchor, BLUE, FAINT, GRID, INK, RED, Svg, escape};
use serde_json::Value;

/// Three figures.
pub(crate) fn short(value: f64) -> String {
    if value == 0.0 || !value.is_finite() {
        return value.to_string();
    }
    let (mut digits, mut size) = (2_usize, value.abs());
    while size < 1.0 && digits < 9 {
        (digits, size) = (digits + 1, 10.0 * size);
    }
    while size >= 10.0 && digits > 0 {
        (digits, size) = (digits - 1, size / 10.0);
    }
    format!("{value:.digits$}")
}

pub(crate) fn write(outcomes: &[Outcome]) -> String {
    let mut html = page::begin("Real recordings");
    let run = CASES.iter().zip(outcomes).filter_map(|(c, o)| match o {
        Outcome::Done(d) => Some((c, d.as_ref())),
        Outcome::Absent(_) => None,
    });
    let run: Vec<(&Case, &Done)> = run.collect();
    let met = run.iter().filter(|(c, d)| d.meets(c.aim)).count();
    put!(html, "<h1>Recordings of real physics</h1>");
    let slow = run
        .iter()
        .filter(|(c, d)| c.seconds.is_some_and(|most| d.seconds >= most));
    let slow = match slow.count() {
        0 => String::new(),
        n => format!(", {n} of them not in the time asked"),
    };
    put!(
        html,
        "<p class=\"lead\">{met} of {} recordings came out as asked{slow}.</p>",
        run.len()
    );
    put!(
        html,
        "<p class=\"quiet\">The engine and its catalogue know none of them: each is a <code>system.toml</code> and a table, and goes through <code>dgd diagnose \
         --system</code>. The held-out errors below are computed again from its tables against the recordings. What was blind and what was not stands with \
         each.</p>"
    );
    let rows: Vec<Vec<Cell>> = CASES.iter().zip(outcomes).map(|(c, o)| row(c, o)).collect();
    put!(html, "<h2>At a glance</h2>");
    page::table(
        &mut html,
        &[
            "recording",
            "answer",
            "held out: before",
            "after",
            "unit",
            "samples",
            "asked",
            "seconds",
        ],
        &rows,
    );
    put!(
        html,
        "<p class=\"quiet\">Root mean square of simulated less measured on the held-out part. Seconds: the whole diagnosis, on whatever else the machine was \
         doing.</p>"
    );
    for (case, done) in &run {
        section(&mut html, case, done);
    }
    put!(
        html,
        "<h2>How this was made</h2><p><code>cargo xtask prove --real DIR</code></p><p>The recordings belong to others and are not part of this project; \
         <code>fixtures/real/README.md</code> says where they come from, and their SHA-256 are checked before anything is run.</p>"
    );
    html.push_str(page::END);
    html
}

fn asked(aim: Aim, unit: &str) -> String {
    match aim {
        Aim::AtMost { after, from } => format!("at most {after} {unit}, from {from}, cause named"),
        Aim::Consistent => "consistent".into(),
        Aim::Located => "changes located, nothing claimed that hurts".into(),
    }
}

fn row(case: &Case, outcome: &Outcome) -> Vec<Cell> {
    let name = Cell::Name(case.title.into());
    match outcome {
        Outcome::Absent(files) => vec![
            name,
            Cell::Text(format!("skipped: no {}", files.join(", "))),
        ],
        Outcome::Done(d) => vec![
            name,
            Cell::Text(d.verdict().replace('_', " ")),
            Cell::Number(short(d.score.before)),
            Cell::Number(short(d.score.after)),
            Cell::Text(case.unit.into()),
            Cell::Basis(d.score.samples.to_string()),
            Cell::Target(Some(d.meets(case.aim)), asked(case.aim, case.unit)),
            match case.seconds {
                Some(most) => Cell::Target(
                    Some(d.seconds < most),
                    format!("{:.1}, below {most}", d.seconds),
                ),
                None => Cell::Basis(format!("{:.1}", d.seconds)),
            },
        ],
    }
}

fn section(html: &mut String, case: &Case, done: &Done) {
    put!(
        html,
        "<h2>{}</h2><p>{}</p>",
        escape(case.title),
        escape(case.about)
    );
    if done.left_out > 0 {
        put!(
            html,
            "<p class=\"quiet\">{} rows were left out.</p>",
            done.left_out
        );
    }
    located(html, done);
    page::picture(
        html,
        &curves(case, done),
        &format!(
            "The held-out part along {}. Grey: measured; red: the textbook model, fitted again; blue: with what was found.",
            case.axis
        ),
    );
    figures(html, case, done);
    apart(html, done);
    checks(html, done);
    put!(html, "<h3>Blind or not</h3>");
    for line in case.history {
        put!(html, "<p>{}</p>", escape(line));
    }
}

fn list(value: &Value) -> impl Iterator<Item = &Value> {
    value.as_array().into_iter().flatten()
}

fn located(html: &mut String, done: &Done) {
    put!(html, "<h3>Named, located, modelled</h3>");
    let findings: Vec<&Value> = list(&done.diagnosis["findings"]).collect();
    if findings.is_empty() {
        put!(
            html,
            "<p>Nothing: the recording is consistent with its description.</p>"
        );
    }
    let doubtful = list(&done.diagnosis["also_possible"]).map(|f| (f, "also possible: "));
    for (f, how) in findings.into_iter().map(|f| (f, "")).chain(doubtful) {
        let unknown = f["effect"] == "unknown";
        let what = if unknown {
            "unknown".to_owned()
        } else {
            format!("{}.{}", word(&f["component"]), word(&f["effect"]))
        };
        put!(
            html,
            "<p>{how}<strong>{}</strong>: {}. <code>{}</code></p>",
            escape(&what),
            escape(word(&f["title"])),
            escape(word(&f["equation"]))
        );
        let parameters: Vec<String> = list(&f["parameters"])
            .map(|p| {
                let doubt = if p["at_bound"] == true {
                    "on its bound".to_owned()
                } else {
                    format!("{} to {}", number(&p["ci95"][0]), number(&p["ci95"][1]))
                };
                format!("{} = {} ({doubt})", word(&p["path"]), with_unit(p))
            })
            .collect();
        let mut more = parameters.join("; ");
        if let Some(weight) = f["probability"].as_f64() {
            more += &format!(
                ". Probability {:.2}, as often as such a weight was right where the truth was known",
                weight.clamp(0.01, 0.99)
            );
        }
        if !word(&f["region"]).is_empty() {
            more += &format!(". {}", word(&f["region"]));
        }
        put!(
            html,
            "<p class=\"quiet\">{}</p>",
            escape(more.trim_start_matches(". "))
        );
    }
    let sections: Vec<Vec<Cell>> = list(&done.diagnosis["sections"])
        .map(|s| {
            let cause: Vec<&str> = list(&s["cause"]).map(word).collect();
            let parameters =
                list(&s["parameters"]).map(|p| format!("{} {}", word(&p["path"]), with_unit(p)));
            vec![
                Cell::Name(format!("{} to {}", number(&s["from"]), number(&s["to"]))),
                Cell::Text(if cause.is_empty() {
                    "as described".into()
                } else {
                    cause.join(", ")
                }),
                Cell::Text(parameters.collect::<Vec<_>>().join("; ")),
            ]
        })
        .collect();
    if sections.len() > 1 {
        put!(
            html,
            "<p>Along the training part the same parameters do not hold throughout. Sections, each with parameters of its own:</p>"
        );
        page::table(html, &["section", "relation", "parameters"], &sections);
    }
}

fn number(value: &Value) -> String {
    match value.as_f64() {
        Some(v) if v == 0.0 || (1e-3..1e5).contains(&v.abs()) => short(v),
        Some(v) => format!("{v:.3e}"),
        None => "–".into(),
    }
}

/// `0.12 m`
fn with_unit(parameter: &Value) -> String {
    let told = format!(
        "{} {}",
        number(&parameter["value"]),
        word(&parameter["unit"])
    );
    told.trim_end().to_owned()
}

fn figures(html: &mut String, case: &Case, done: &Done) {
    put!(html, "<h3>Before, after, and others</h3>");
    let mut rows: Vec<(f64, &str, bool)> = case
        .published
        .iter()
        .map(|(w, v)| (*v, *w, false))
        .collect();
    rows.push((
        done.score.before,
        "textbook model, fitted by the diagnosis (before)",
        true,
    ));
    rows.push((done.fitted, "textbook model, by dgd fit", true));
    rows.push((done.score.after, "with what was found (after)", true));
    rows.push((
        done.rerun,
        "the model written down, run again by dgd simulate",
        true,
    ));
    rows.sort_by(|a, b| b.0.total_cmp(&a.0));
    let rows: Vec<Vec<Cell>> = rows
        .into_iter()
        .map(|(v, who, own)| {
            let value = short(v);
            let value = if own {
                Cell::Number(value)
            } else {
                Cell::Basis(value)
            };
            vec![Cell::Name(who.into()), value]
        })
        .collect();
    page::table(
        html,
        &["model", &format!("held-out rms, {}", case.unit)],
        &rows,
    );
    if !case.published.is_empty() {
        put!(
            html,
            "<p class=\"quiet\">Grey: figures of others, for orientation.</p>"
        );
    }
}

fn apart(html: &mut String, done: &Done) {
    put!(html, "<h3>What cannot be told apart</h3>");
    let mut any = false;
    let named = ["findings", "also_possible"].map(|key| list(&done.diagnosis[key]));
    for f in named.into_iter().flatten() {
        let others: Vec<&str> = list(&f["alternatives"])
            .map(|a| word(&a["effect"]))
            .collect();
        if others.is_empty() {
            continue;
        }
        any = true;
        put!(
            html,
            "<p><strong>{}.{}</strong> or {}. A test that would tell: {}.</p>",
            escape(word(&f["component"])),
            escape(word(&f["effect"])),
            escape(&others.join(", ")),
            escape(word(&f["separating_test"]))
        );
    }
    if !any {
        put!(
            html,
            "<p>Nothing that does as well was found in the place of what is named.</p>"
        );
    }
}

fn checks(html: &mut String, done: &Done) {
    let rows: Vec<Vec<Cell>> = list(&done.diagnosis["checks"])
        .map(|c| {
            let passed = c["passed"].as_bool();
            let said = if passed == Some(true) { "yes" } else { "no" };
            vec![
                Cell::Name(word(&c["name"]).into()),
                Cell::Target(passed, said.into()),
                Cell::Text(word(&c["detail"]).into()),
            ]
        })
        .collect();
    put!(html, "<h3>Checks</h3>");
    page::table(html, &["check", "", "numbers"], &rows);
}

/// Points of a curve, so that the picture stays small.
const POINTS: usize = 700;

fn curves(case: &Case, done: &Done) -> String {
    const SIZE: (f64, f64) = (860.0, 240.0);
    const LEFT: f64 = 56.0;
    const BELOW: f64 = 26.0;
    let [axis, lines @ ..] = &done.curves;
    let all = || lines.iter().flatten().copied().filter(|v| v.is_finite());
    let (low, high) = all().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| {
        (l.min(v), h.max(v))
    });
    #[expect(clippy::cast_precision_loss, reason = "sample counts")]
    let n = (axis.len().max(2) - 1) as f64;
    #[expect(clippy::cast_precision_loss, reason = "sample counts")]
    let x = |i: usize| LEFT + (SIZE.0 - LEFT - 8.0) * i as f64 / n;
    let y = |v: f64| 8.0 + (SIZE.1 - BELOW - 8.0) * (high - v) / (high - low).max(1e-300);
    let mut svg = Svg::new(SIZE.0, SIZE.1, &format!("{}: held-out part", case.title));
    for k in 0..5 {
        let v = low + (high - low) * f64::from(k) / 4.0;
        svg.line((LEFT, y(v)), (SIZE.0 - 8.0, y(v)), GRID, 1.0);
        svg.text((LEFT - 6.0, y(v) + 4.0), Anchor::End, FAINT, &short(v));
    }
    let stride = axis.len().div_ceil(POINTS).max(1);
    for (line, colour) in lines.iter().zip([FAINT, RED, BLUE]) {
        let points = line.iter().enumerate().step_by(stride);
        let points: Vec<(f64, f64)> = points
            .filter(|(_, v)| v.is_finite())
            .map(|(i, v)| (x(i), y(*v)))
            .collect();
        svg.polyline(&points, colour, "none");
    }
    let ends = [
        (0, Anchor::Start),
        (axis.len() / 2, Anchor::Middle),
        (axis.len().max(1) - 1, Anchor::End),
    ];
    for (i, anchor) in ends {
        let at = axis.get(i).copied().unwrap_or_default();
        svg.text((x(i), SIZE.1 - 8.0), anchor, INK, &short(at));
    }
    svg.text((4.0, 14.0), Anchor::Start, INK, case.unit);
    svg.finish()
}

#[cfg(test)]
mod tests {
    use super::super::score::Score;
    use super::*;
    use serde_json::json;

    fn done(findings: Value) -> Done {
        Done {
            score: Score {
                samples: 3,
                before: 0.67,
                after: 0.2,
            },
            fitted: 0.67,
            rerun: 0.2,
            seconds: 12.0,
            diagnosis: json!({ "verdict": "explained", "findings": findings, "checks": [{ "name": "<b>", "passed": false, "detail": "x" }] }),
            left_out: 0,
            curves: [
                vec![0.0, 1.0, 2.0],
                vec![1.0, 2.0, 3.0],
                vec![0.0; 3],
                vec![1.0; 3],
            ],
        }
    }

    #[test]
    fn the_page_tells_what_was_found_what_was_skipped_and_what_was_blind() {
        let finding = json!([{ "effect": "brim_head", "component": "upper", "title": "<i>", "equation": "q = 1",
            "parameters": [{ "path": "upper.brim_head.rise", "value": 0.5, "ci95": [0.4, 0.6] }],
            "alternatives": [{ "effect": "upper.taper" }], "separating_test": "fill it" }]);
        let outcomes = [
            Outcome::Done(Box::new(done(finding))),
            Outcome::Absent(vec!["log.csv"]),
            Outcome::Absent(vec!["log.csv"]),
            Outcome::Absent(vec!["1bengzc.csv"]),
        ];
        let html = write(&outcomes);
        for part in [
            "upper.brim_head",
            "skipped: no log.csv",
            "upper.taper",
            "fill it",
            "Not blind",
            "SUBNET",
            "1 of 1 recordings",
        ] {
            assert!(html.contains(part), "{part}");
        }
        assert!(!html.contains("<b>") && !html.contains("<i>") && !html.contains("NaN"));
    }

    #[test]
    fn a_low_error_without_a_name_does_not_meet_the_aim() {
        let unnamed = done(json!([{ "effect": "unknown" }]));
        assert!(!unnamed.meets(CASES[0].aim));
    }

    #[test]
    fn numbers_keep_three_figures() {
        assert_eq!(short(0.24907), "0.249");
        assert_eq!(short(158.51), "159");
        assert_eq!(short(0.010989), "0.0110");
    }
}
