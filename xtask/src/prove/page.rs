//! `proof.html`: self-contained, readable on paper.

use super::failures::{FAULTS, concealed, remarks, repeat, said, with};
use super::measures::measures;
use super::stats::{Tally, median};
use super::summary::{Row, Summary};
use super::svg::escape;
use super::{Origin, Settings, charts};
use std::fmt::Write;

const STYLE: &str = "
:root{color-scheme:light}
body{font:15px/1.5 system-ui,-apple-system,'Segoe UI',Roboto,'Helvetica Neue',Arial,sans-serif;color:#1c2733;max-width:980px;margin:2.5rem auto;padding:0 1.2rem}
h1{font-size:1.9rem;line-height:1.2;margin:0 0 .4rem}
h2{font-size:1.25rem;margin:2.6rem 0 .5rem;padding-top:.7rem;border-top:1px solid #dfe5ea}
h3{font-size:1rem;margin:1.5rem 0 .3rem}
p{max-width:46rem}
.lead{font-size:1.1rem}
.quiet{color:#5b6875;font-size:.88rem}
table{border-collapse:collapse;font-size:.86rem;margin:.6rem 0;font-variant-numeric:tabular-nums}
th,td{text-align:left;padding:.2rem .7rem .2rem 0;border-bottom:1px solid #e8edf1;vertical-align:top}
thead th{border-bottom:1.5px solid #8794a1;font-weight:600}
tbody th{font-weight:400}
td.n{text-align:right;font-weight:600;white-space:nowrap}
td.b{color:#5b6875;white-space:nowrap}
.met{color:#2f7d5b;white-space:nowrap}.missed{color:#b8442a;white-space:nowrap}
figure{margin:1rem 0;overflow-x:auto}
figcaption{color:#5b6875;font-size:.88rem;max-width:46rem;margin-top:.3rem}
svg{max-width:100%;height:auto;font-family:inherit}
code{font:.84em ui-monospace,SFMono-Regular,Menlo,Consolas,monospace;overflow-wrap:anywhere}
.case{margin:.9rem 0;break-inside:avoid;font-size:.88rem}
.case p{margin:.1rem 0;max-width:none}
@media(max-width:860px){table{font-size:.74rem}th,td{padding-right:.4rem}}
@media print{body{margin:0;padding:0;max-width:none;font-size:10pt}table{font-size:7.5pt}th,td{padding-right:.4rem}h2,h3{break-after:avoid}figure,tr{break-inside:avoid}@page{margin:16mm 14mm}}
";

/// The page.
pub(crate) fn write(
    settings: &Settings,
    origin: &Origin,
    levels: &[Summary],
    rows: &[Row],
) -> String {
    let mut html = String::from(
        "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" content=\"width=device-width\">\
         <title>Proof of the diagnosis</title><style>",
    );
    html.push_str(STYLE);
    html.push_str("</style></head><body>\n");
    opening(&mut html, settings, levels, rows);
    scores(&mut html, levels);
    detection(&mut html, levels);
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
    cost(&mut html, levels, settings);
    faults(&mut html, settings, rows);
    method(&mut html, settings, origin);
    html.push_str("</body></html>\n");
    html
}

/// Adds to the page; writing into a string cannot fail.
macro_rules! put {
    ($html:expr, $($arg:tt)*) => {{ let _ = writeln!($html, $($arg)*); }};
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
         Targets that are not measured here: the smallest effect against the Cramér–Rao limit, and the held-out gain against a fit that \
         knows the truth.</p>"
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

fn figure(html: &mut String, title: &str, svg: &str, caption: &str) {
    put!(
        html,
        "<h2>{title}</h2><figure>{svg}<figcaption>{caption}</figcaption></figure>"
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
    if !settings.only.is_empty() {
        let _ = write!(command, " --only {}", settings.only.join(","));
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
        escape(&origin.version),
        origin
            .commit
            .as_ref()
            .map_or_else(String::new, |c| format!(", {}", escape(c))),
        escape(&origin.program),
        origin.cores
    );
}

#[cfg(test)]
mod tests {
    use super::super::summary::tests::row;
    use super::*;

    fn page(rows: &[Row]) -> String {
        let settings = Settings::short("proof".into());
        let origin = Origin {
            version: "dgd <0>".into(),
            program: "ef56".into(),
            commit: None,
            cores: 2,
            seals: vec![(1, "ab12".into()), (2, "cd34".into())],
        };
        let levels: Vec<Summary> = [1, 2].map(|l| Summary::of(l, rows)).into();
        write(&settings, &origin, &levels, rows)
    }

    #[test]
    fn every_section_stands_with_and_without_cases() {
        let rows = [
            row(&["influx"], Some(&[("heave", 0.95)])),
            row(&["unknown"], Some(&[("unknown", 0.9)])),
            row(&[], Some(&[])),
        ];
        for html in [page(&rows), page(&[])] {
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
    fn a_failure_is_listed_with_its_command_and_a_right_answer_is_not() {
        let mut wrong = row(&["influx"], Some(&[("heave", 0.95)]));
        wrong.id = "c007".into();
        let mut right = row(&["heave"], Some(&[("heave", 0.95)]));
        right.id = "c008".into();
        let html = page(&[wrong, right]);
        assert!(html.contains("--seed 2015 --level 2 --count 32 --only c007"));
        assert!(!html.contains("c008"));
    }

    #[test]
    fn what_a_broken_run_said_cannot_become_markup() {
        let mut broken = row(&["influx"], None);
        broken.broken = vec!["dgd diagnose: <script>alert(1)</script>".into()];
        let html = page(&[broken]);
        assert!(!html.contains("<script"));
        assert!(html.contains("&lt;script&gt;") && html.contains("dgd &lt;0&gt;"));
    }
}
