//! `proof.html`.

use super::failures::{FAULTS, concealed, remarks, repeat, said, with};
use super::measures::{Score, measures};
use super::page::{self, Cell, figure, put, table};
use super::stats::{Tally, median};
use super::summary::{Row, Summary};
use super::svg::escape;
use super::targets::TRUTH_SHARE;
use super::{Origin, Proof, Settings, ablation_page, charts, detection_page, informed};
use std::fmt::Write;

/// The page.
pub(crate) fn write(proof: &Proof) -> String {
    let Proof {
        settings,
        origin,
        summaries: levels,
        rows,
        steps,
    } = *proof;
    let mut html = page::begin("Proof of the diagnosis");
    opening(&mut html, settings, levels, rows);
    scores(&mut html, levels);
    detection(&mut html, levels);
    detection_page::section(&mut html, rows);
    figure(
        &mut html,
        "What was taken for what",
        &charts::matrix(rows),
        "Blue: the right name. Red: a wrong one. Grey: there, but nothing found. Both levels and all severities; pairs are left out. \
         A case with two findings counts in two columns.",
    );
    outside(&mut html, levels);
    figure(
        &mut html,
        "Are the probabilities honest?",
        &charts::reliability(levels),
        "Findings by tenth of the probability stated, with the share that was right, its 95 % interval and the number of findings. \
         On the diagonal nine in ten findings of probability 0.9 are right. An effect passed over is no finding and not shown here; in the Brier score it \
         counts as probability zero.",
    );
    parameters(&mut html, levels);
    figure(
        &mut html,
        "Does the fit improve?",
        &charts::gains(levels),
        "Root mean square error on held-out windows with the findings over that without, recomputed from each simulation.csv; a dot a case with something \
         concealed, red where it grew by more than 2 %, a bar at the median. Values beyond the axis stand at its end.",
    );
    knowing(&mut html, levels, rows);
    cost(&mut html, levels, settings);
    ablation_page::section(&mut html, steps);
    faults(&mut html, settings, rows);
    method(&mut html, settings, origin);
    html.push_str(page::END);
    html
}

fn opening(html: &mut String, settings: &Settings, levels: &[Summary], rows: &[Row]) {
    put!(html, "<h1>Concealed effects, diagnosed blind</h1>");
    let mut parts = Vec::new();
    for s in levels {
        let mut said = format!(
            "At level {}, {} single effects were named exactly, and {} clean recordings raised a false alarm",
            s.level,
            of(s.singles.exact),
            of(s.false_alarms)
        );
        if s.confidently_wrong.of > 0 {
            let _ = write!(
                said,
                "; {} findings of probability 0.9 or more were wrong",
                of(s.confidently_wrong)
            );
        }
        parts.push(said + ".");
    }
    put!(html, "<p class=\"lead\">{}</p>", escape(&parts.join(" ")));
    let broken = rows.iter().filter(|r| !r.broken.is_empty()).count();
    let rules = if broken == 0 {
        "No rule was broken.".to_owned()
    } else {
        format!("<strong>{broken} broke a rule.</strong>")
    };
    put!(
        html,
        "<p class=\"quiet\">{} recordings, seed {}. {rules} Severities go from strong down to trace, where mostly nothing can be seen: what matters is the curve \
         below, and that clean recordings stay clean.</p>",
        rows.len(),
        settings.seed
    );
}

fn of(tally: Tally) -> String {
    format!("{} of {}", tally.right, tally.of)
}

fn scores(html: &mut String, levels: &[Summary]) {
    put!(
        html,
        "<h2>Scores beside their targets</h2><table><thead><tr><th scope=\"col\">measure</th>"
    );
    for s in levels {
        put!(
            html,
            "<th scope=\"col\" colspan=\"3\">level {}</th>",
            s.level
        );
    }
    put!(html, "</tr></thead><tbody>");
    let columns: Vec<_> = levels.iter().map(measures).collect();
    for (i, measure) in columns.first().into_iter().flatten().enumerate() {
        put!(
            html,
            "<tr><th scope=\"row\">{}</th>",
            escape(&measure.title)
        );
        for column in &columns {
            let m = &column[i];
            let target = m.target.map_or_else(String::new, |t| {
                let text = t.text(m.score);
                match t.met(m.score) {
                    Some(true) => format!("<span class=\"met\">✓ {text}</span>"),
                    Some(false) => format!("<span class=\"missed\">✗ {text}</span>"),
                    None => text,
                }
            });
            put!(
                html,
                "<td class=\"n\">{}</td><td class=\"b\">{}</td><td>{target}</td>",
                m.score.value(),
                m.score.basis()
            );
        }
        put!(html, "</tr>");
    }
    put!(
        html,
        "</tbody></table><p class=\"quiet\">Shares with Wilson's 95 % interval. A finding counts as claimed from probability 0.5 on, an alternative \
         as stated from 0.1 on. Exactly: the set claimed is the set concealed. A run without an answer counts as one that names nothing. \
         A dash: not measured here.</p>"
    );
}

fn detection(html: &mut String, levels: &[Summary]) {
    figure(
        html,
        "How small an effect is still named",
        &charts::detection(levels),
        "Single effects of the catalogue. Blue: named exactly, with the 95 % interval; grey, dashed: named at all; green, dotted: within the alternatives; \
         red strokes: targets.",
    );
    figure(
        html,
        "Effect by effect",
        &charts::heat(levels),
        "Named exactly, of so many. Pale red: none of them. Grey: no such case.",
    );
}

/// What is outside the catalogue, by kind.
fn outside(html: &mut String, levels: &[Summary]) {
    put!(
        html,
        "<h2>Effects outside the catalogue</h2><table><thead><tr><th scope=\"col\">what it is</th><th scope=\"col\">level</th>\
         <th scope=\"col\">called unknown</th><th scope=\"col\">nothing found</th><th scope=\"col\">given a name</th></tr></thead><tbody>"
    );
    for s in levels {
        for (kind, [right, silent, named]) in &s.by_foreign {
            put!(
                html,
                "<tr><th scope=\"row\">{}</th><td>{}</td><td>{right}</td><td>{silent}</td><td>{named}</td></tr>",
                escape(&charts::words(kind)),
                s.level
            );
        }
    }
    put!(html, "</tbody></table>");
}

fn parameters(html: &mut String, levels: &[Summary]) {
    put!(
        html,
        "<h2>Parameters and their intervals</h2><table><thead><tr><th scope=\"col\">effect</th><th scope=\"col\">parameter</th>\
         <th scope=\"col\">level</th><th scope=\"col\">named</th><th scope=\"col\">relative error, median</th>\
         <th scope=\"col\">ci95 holds the truth</th><th scope=\"col\">not given</th></tr></thead><tbody>"
    );
    for s in levels {
        for ((effect, name), p) in &s.by_parameter {
            let error = median(&p.errors).map_or("–".into(), |e| format!("{:.1} %", 100.0 * e));
            put!(
                html,
                "<tr><th scope=\"row\">{}</th><td><code>{}</code></td><td>{}</td><td>{}</td><td>{error}</td><td>{}</td><td>{}</td></tr>",
                escape(&charts::words(effect)),
                escape(name),
                s.level,
                p.errors.len() + p.missing,
                of(p.covered),
                p.missing
            );
        }
    }
    put!(
        html,
        "</tbody></table><p class=\"quiet\">Where the effect was named; pairs included. The error of a gain is relative to its distance from one.</p>"
    );
}

/// The held-out gain against that of a fit that knows the truth.
fn knowing(html: &mut String, levels: &[Summary], rows: &[Row]) {
    if rows.iter().all(|r| r.informed.is_none()) {
        return;
    }
    put!(
        html,
        "<h2>Held-out gain against a fit that knows the truth</h2><p>After the seal was opened, <code>dgd diagnose --suspect</code> fitted the \
         concealed effects to each recording that hides effects of the catalogue alone. The gain is 1 less the error after over the error before; a signal counts \
         where knowing the truth gains at least 5 %. A fit that is not told may gain more: its allowances are its own.</p>"
    );
    let mut cells = Vec::new();
    for s in levels {
        for (title, middle, reached) in informed::by_signal(rows, s.level) {
            cells.push(share_of_truth(title, s.level, middle, reached));
        }
        let mut reached = Tally::default();
        let shares = &s.truth_shares;
        shares.iter().for_each(|v| reached.add(*v >= TRUTH_SHARE));
        cells.push(share_of_truth(
            "all signals of a case",
            s.level,
            median(shares),
            reached,
        ));
    }
    let head = [
        "signal",
        "level",
        "median share of the gain",
        "cases that reach 95 %",
        "",
    ];
    table(html, &head, &cells);
    let silent = rows.iter().filter_map(|r| r.informed.as_ref());
    let silent = silent.filter(|i| i.answer.is_none()).count();
    let short = informed::short(rows);
    put!(
        html,
        "<h3>Below 95 %: {}</h3><p class=\"quiet\">Worst first. {silent} fits that know the truth gave no answer.</p>",
        short.len()
    );
    let case = |(row, share): &(&Row, informed::Share)| {
        vec![
            Cell::Name(format!("level {} {}", row.level, row.id)),
            Cell::Number(format!("{:.0} %", 100.0 * share.whole)),
            Cell::Text(concealed(&row.truth)),
            Cell::Text(said(row.answer.as_ref())),
        ]
    };
    let cells: Vec<Vec<Cell>> = short.iter().map(case).collect();
    table(html, &["case", "share", "concealed", "said"], &cells);
}

fn share_of_truth(title: &str, level: u8, middle: Option<f64>, reached: Tally) -> Vec<Cell> {
    let share = Score::Share(reached);
    vec![
        Cell::Name(title.to_owned()),
        Cell::Text(level.to_string()),
        Cell::Number(middle.map_or("–".into(), |m| format!("{:.0} %", 100.0 * m))),
        Cell::Number(share.value()),
        Cell::Basis(share.basis()),
    ]
}

fn cost(html: &mut String, levels: &[Summary], settings: &Settings) {
    put!(
        html,
        "<h2>Time and memory</h2><table><thead><tr><th scope=\"col\">length of the recording</th><th scope=\"col\">level</th>\
         <th scope=\"col\">cases</th><th scope=\"col\">median, s</th><th scope=\"col\">longest, s</th></tr></thead><tbody>"
    );
    for s in levels {
        for (hours, walls) in &s.by_hours {
            let most = walls.iter().copied().fold(0.0, f64::max);
            put!(
                html,
                "<tr><th scope=\"row\">{hours} h</th><td>{}</td><td>{}</td><td>{:.2}</td><td>{most:.2}</td></tr>",
                s.level,
                walls.len(),
                median(walls).unwrap_or(f64::NAN)
            );
        }
    }
    put!(
        html,
        "</tbody></table><p class=\"quiet\">Wall time of the whole command, reading and report included, with {} at a time. Level two holds recordings of 1, \
         2 and 5 s from sample to sample.</p>",
        settings.jobs
    );
}

fn faults(html: &mut String, settings: &Settings, rows: &[Row]) {
    put!(html, "<h2>Every failure</h2>");
    for (kind, title) in FAULTS {
        let cases: Vec<&Row> = with(rows, kind).collect();
        put!(html, "<h3>{title}: {}</h3>", cases.len());
        for row in cases {
            put!(
                html,
                "<div class=\"case\"><p><strong>level {} {}</strong> · {}, {:.0} h · concealed {}</p><p>said {}</p>",
                row.level,
                escape(&row.id),
                escape(&row.truth.well),
                row.truth.hours,
                escape(&concealed(&row.truth)),
                escape(&said(row.answer.as_ref()))
            );
            let more: Vec<String> = row.broken.iter().cloned().chain(remarks(row)).collect();
            if !more.is_empty() {
                put!(html, "<p>{}</p>", escape(&more.join("; ")));
            }
            put!(
                html,
                "<p><code>{}</code></p></div>",
                escape(&repeat(settings, row))
            );
        }
    }
}

fn method(html: &mut String, settings: &Settings, origin: &Origin) {
    put!(html, "<h2>How this was made</h2>");
    let levels: Vec<String> = origin.seals.iter().map(|(l, _)| l.to_string()).collect();
    let level = if levels.len() == 2 {
        "both".into()
    } else {
        levels.join("")
    };
    let mut command = format!("cargo xtask prove --seed {} --level {level}", settings.seed);
    // Writing into a string cannot fail.
    let _ = match settings.short {
        true => write!(command, " --short"),
        false => write!(command, " --count {}", settings.count),
    };
    command += &settings.of_kind();
    if !settings.only.is_empty() {
        let _ = write!(command, " --only {}", settings.only.join(","));
    }
    if settings.ablate {
        command.push_str(" --ablate");
        if !settings.steps.is_empty() {
            let _ = write!(command, " --steps {}", settings.steps.join(","));
        }
    }
    if settings.blind {
        command.push_str(" --blind");
    }
    put!(html, "<p><code>{}</code></p>", escape(&command));
    put!(
        html,
        "<p><code>dgd-plant</code>, which shares no code with what is judged, made the recordings and printed the SHA-256 of what it had concealed before the \
         first diagnosis. <code>dgd diagnose</code> ran on each in a temporary folder with the recording, its well.toml and nothing else. After the last the \
         truths had the same SHA-256 and were opened. Seeds up to {} are for calibrating and refused here.</p><table><tbody>",
        super::CALIBRATION_SEEDS
    );
    for (level, sha256) in &origin.seals {
        put!(
            html,
            "<tr><th scope=\"row\">truths of level {level}</th><td><code>{}</code></td></tr>",
            escape(sha256)
        );
    }
    put!(
        html,
        "<tr><th scope=\"row\">program</th><td>{}{}; SHA-256 <code>{}</code></td></tr><tr><th scope=\"row\">cores</th><td>{}</td></tr></tbody></table>",
        escape(&origin.program.version),
        origin
            .program
            .commit
            .as_ref()
            .map_or_else(String::new, |c| format!(", {}", escape(c))),
        escape(&origin.program.sha256),
        origin.program.cores
    );
}

#[cfg(test)]
mod tests {
    use super::super::Program;
    use super::super::ablation::{OfStep, tests::example};
    use super::super::detection::tests::influx;
    use super::super::informed::Informed;
    use super::super::summary::tests::row;
    use super::*;

    fn page_of(rows: &[Row]) -> String {
        page_with(rows, &[])
    }

    fn page_with(rows: &[Row], steps: &[OfStep]) -> String {
        let settings = Settings::short("proof".into());
        let origin = Origin {
            program: Program {
                version: "dgd <0>".into(),
                sha256: "ef56".into(),
                commit: None,
                cores: 2,
            },
            seals: vec![(1, "ab12".into()), (2, "cd34".into())],
        };
        let levels: Vec<Summary> = [1, 2].map(|l| Summary::of(l, rows)).into();
        write(&Proof {
            settings: &settings,
            origin: &origin,
            summaries: &levels,
            rows,
            steps,
        })
    }

    #[test]
    fn every_section_stands_with_and_without_cases() {
        let rows = [
            row(&["influx"], Some(&[("heave", 0.95)])),
            row(&["unknown"], Some(&[("unknown", 0.9)])),
            row(&[], Some(&[])),
        ];
        for html in [page_of(&rows), page_of(&[])] {
            for section in [
                "Scores beside their targets",
                "How small an effect is still named",
                "Effect by effect",
                "What was taken for what",
                "Effects outside the catalogue",
                "Are the probabilities honest?",
                "Parameters and their intervals",
                "Does the fit improve?",
                "Time and memory",
                "Every failure",
                "ab12",
                "cd34",
            ] {
                assert!(html.contains(section), "{section}");
            }
            assert!(!html.contains("NaN"));
        }
    }

    #[test]
    fn limit_truth_knowing_fit_and_steps_stand_where_they_were_measured() {
        let mut case = influx(6.0, 0.3);
        case.informed = Some(Informed {
            share: Some(informed::Share {
                by_signal: [None, Some(0.4), None, None],
                whole: 0.4,
            }),
            ..Informed::default()
        });
        let html = page_with(&[case], &example());
        let bare = page_of(&[row(&["influx"], Some(&[]))]);
        for section in [
            "Against the limit of the recording",
            "Held-out gain against a fit that knows the truth",
            "Below 95 %: 1",
            "What each step contributes",
        ] {
            assert!(html.contains(section), "{section}");
            assert!(!bare.contains(section), "{section}");
        }
    }

    #[test]
    fn a_failure_is_listed_with_its_command_and_a_right_answer_is_not() {
        let mut wrong = row(&["influx"], Some(&[("heave", 0.95)]));
        wrong.id = "c007".into();
        let mut right = row(&["heave"], Some(&[("heave", 0.95)]));
        right.id = "c008".into();
        let html = page_of(&[wrong, right]);
        assert!(html.contains("--seed 2015 --level 2 --count 32 --only c007"));
        assert!(!html.contains("c008"));
    }

    #[test]
    fn what_a_broken_run_said_cannot_become_markup() {
        let mut broken = row(&["influx"], None);
        broken.broken = vec!["dgd diagnose: <script>alert(1)</script>".into()];
        let html = page_of(&[broken]);
        assert!(!html.contains("<script"));
        assert!(html.contains("&lt;script&gt;") && html.contains("dgd &lt;0&gt;"));
    }
}
