//! `benches.html`: self-contained, readable on paper.

use super::score::{Outcome, Row, Sort, concealed, said};
use super::summary::{Score, measures, of};
use super::{BENCHES, Origin, Settings, counterparts};
use crate::prove::page::{Cell, END, begin, figure, put, table};
use crate::prove::svg::{Anchor, BLUE, FAINT, GRID, INK, RED, Svg, escape};

/// The page.
pub(crate) fn write(settings: &Settings, origin: &Origin, rows: &[Row]) -> String {
    let mut html = begin("Two benches, diagnosed blind");
    opening(&mut html, settings, rows);
    scores(&mut html, rows);
    things(&mut html, rows);
    figure(
        &mut html,
        "Does the fit improve where it was not fitted?",
        &gains(rows),
        "Root mean square error on held-out samples over what the instruments&#8217; noise alone adds, all instruments of a case together, from without \
         (open) to with the findings (full); on the red line no model can do better. Blue: right; grey: otherwise. Recomputed from each simulation.csv.",
    );
    cases(&mut html, settings, rows);
    right_answers(&mut html);
    method(&mut html, settings, origin);
    html.push_str(END);
    html
}

fn value(rows: &[&Row], title: &str) -> String {
    let list = measures(rows);
    let found = list.iter().find(|(t, _)| *t == title);
    found.map_or(String::new(), |(_, score)| score.value())
}

fn opening(html: &mut String, settings: &Settings, rows: &[Row]) {
    let all = of(rows, None);
    put!(
        html,
        "<h1>Two benches that the catalogue was not written for</h1>"
    );
    put!(
        html,
        "<p class=\"lead\">Of things that the catalogue holds, {} were named and nothing beside them; {} clean recordings raised a false alarm; of the \
         gain that knowing the truth allows on held-out samples, the median case has {}.</p>",
        value(&all, "in the catalogue: named, and nothing else"),
        value(&all, "clean: false alarms"),
        value(
            &all,
            "share of the gain that knowing the truth allows (median)"
        ),
    );
    let broken = rows.iter().filter(|r| !r.broken.is_empty()).count();
    put!(
        html,
        "<p class=\"quiet\">{} recordings, seed {}. A surge shaft (reservoir, pipeline, shaft, penstock, control valve) and a loop of glycol (sump, gear pump, \
         accumulator, hose, needle valve, header tank) were simulated by code that shares nothing with what is judged; each left out of its textbook form \
         one thing that the literature lists, or one that no catalogue could hold, or nothing. {}</p>",
        rows.len(),
        settings.seed,
        match broken {
            0 => "No rule was broken.".to_owned(),
            n => format!("<strong>{n} broke a rule.</strong>"),
        }
    );
}

fn scores(html: &mut String, rows: &[Row]) {
    put!(html, "<h2>Scores</h2>");
    let columns = [Some(BENCHES[0]), Some(BENCHES[1]), None].map(|b| measures(&of(rows, b)));
    let cells = |i: usize| {
        let mut row = vec![Cell::Name(columns[0][i].0.into())];
        for column in &columns {
            let score: Score = column[i].1;
            row.push(Cell::Number(score.value()));
            row.push(Cell::Basis(score.basis()));
        }
        row
    };
    let list: Vec<Vec<Cell>> = (0..columns[0].len()).map(cells).collect();
    table(
        html,
        &["measure", "surge shaft", "", "glycol loop", "", "both", ""],
        &list,
    );
    put!(
        html,
        "<p class=\"quiet\">Shares with Wilson&#8217;s 95 % interval. Knowing the truth allows a held-out error down to what noise and steps of the readings \
         alone add; the plant states it. Cases with less than 5 % to be gained have no share.</p>"
    );
}

fn things(html: &mut String, rows: &[Row]) {
    put!(html, "<h2>Thing by thing</h2>");
    for bench in BENCHES {
        put!(html, "<h3>{bench}</h3>");
        let own = of(rows, Some(bench));
        let mut names: Vec<&str> = Vec::new();
        for row in &own {
            if let Some(c) = &row.truth.concealed
                && !names.contains(&c.thing.as_str())
            {
                names.push(&c.thing);
            }
        }
        names.sort_by_key(|n| {
            let at = counterparts::COUNTERPARTS
                .iter()
                .position(|c| c.thing == *n);
            at.unwrap_or(usize::MAX)
        });
        let mut list = Vec::new();
        for name in names {
            let mut row = vec![Cell::Name(name.replace('_', " "))];
            for severity in ["strong", "moderate", "subtle"] {
                let words = own.iter().filter_map(|r| {
                    let c = r.truth.concealed.as_ref()?;
                    (c.thing == name && c.severity == severity).then_some(r)
                });
                let words: Vec<&&Row> = words.collect();
                let right = words.iter().all(|r| r.outcome == Outcome::Right);
                let text = words.iter().map(|r| r.outcome.word()).collect::<Vec<_>>();
                row.push(match words.is_empty() {
                    true => Cell::Text(String::new()),
                    false => Cell::Target(Some(right), text.join("; ")),
                });
            }
            list.push(row);
        }
        table(html, &["concealed", "strong", "moderate", "subtle"], &list);
    }
}

/// From before to after, a line a case.
fn gains(rows: &[Row]) -> String {
    let there: Vec<&Row> = rows
        .iter()
        .filter(|r| r.sort() != Sort::Clean && r.off().is_some())
        .collect();
    let most = there
        .iter()
        .filter_map(|r| r.off())
        .map(|o| o.0.max(o.1))
        .fold(10.0, f64::max);
    let decades = most.log10().max(1.0);
    let (left, width, step, top) = (250.0, 640.0, 17.0, 26.0);
    let bottom = top + step * there.len() as f64;
    let x = |v: f64| left + width * v.max(0.9).log10().max(-0.04) / decades;
    let mut svg = Svg::new(
        left + width + 40.0,
        bottom + 14.0,
        "Held-out error over noise, before and after",
    );
    for v in [1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0] {
        if v <= most * 1.001 {
            let (colour, wide) = if v > 1.0 { (GRID, 1.0) } else { (RED, 1.5) };
            svg.line((x(v), top - 6.0), (x(v), bottom), colour, wide);
            svg.text((x(v), top - 11.0), Anchor::Middle, FAINT, &format!("{v}"));
        }
    }
    for (i, row) in there.iter().enumerate() {
        let Some((before, after)) = row.off() else {
            continue;
        };
        let y = top + step * (i as f64 + 0.5);
        let colour = if row.outcome == Outcome::Right {
            BLUE
        } else {
            FAINT
        };
        svg.text(
            (left - 12.0, y + 4.0),
            Anchor::End,
            INK,
            &concealed(&row.truth),
        );
        svg.line((x(before), y), (x(after), y), colour, 1.2);
        svg.dot((x(before), y), 3.6, colour, 1.0);
        svg.dot((x(before), y), 2.2, "#ffffff", 1.0);
        svg.dot((x(after), y), 3.6, colour, 1.0);
    }
    svg.finish()
}

fn cases(html: &mut String, settings: &Settings, rows: &[Row]) {
    put!(html, "<h2>Every case</h2>");
    for bench in BENCHES {
        put!(html, "<h3>{bench}</h3>");
        let list: Vec<Vec<Cell>> = of(rows, Some(bench))
            .into_iter()
            .map(|r| {
                let off = r.off();
                let number =
                    |v: Option<f64>| Cell::Number(v.map_or("–".into(), |v| format!("{v:.2}")));
                let mut word = r.outcome.word().to_owned();
                if !r.worse().is_empty() {
                    word.push_str(&format!("; worse: {}", r.worse().join(", ")));
                }
                if let Some(broken) = r.broken.first() {
                    word.push_str(&format!("; broke a rule: {broken}"));
                }
                vec![
                    Cell::Name(r.truth.id.clone()),
                    Cell::Text(concealed(&r.truth)),
                    Cell::Text(said(r)),
                    Cell::Target(Some(r.outcome == Outcome::Right), word),
                    number(off.map(|o| o.0)),
                    number(off.map(|o| o.1)),
                    Cell::Basis(format!("{:.0} s", r.wall_s)),
                ]
            })
            .collect();
        table(
            html,
            &[
                "case",
                "concealed",
                "said",
                "outcome",
                "before",
                "after",
                "time",
            ],
            &list,
        );
    }
    put!(
        html,
        "<p class=\"quiet\">Before and after: held-out error over the noise. A case again: <code>{}</code></p>",
        escape(&format!(
            "cargo xtask prove --benches --count {} --seed {} --only c003 --keep --out target/benches-again",
            settings.count, settings.seed
        ))
    );
}

fn right_answers(html: &mut String) {
    put!(html, "<h2>What counts as right</h2>");
    let list: Vec<Vec<Cell>> = counterparts::COUNTERPARTS
        .iter()
        .map(|c| {
            let names: Vec<String> = c.names.iter().map(|(k, e)| format!("{k}.{e}")).collect();
            let names = match names.is_empty() {
                true => "unknown: the catalogue has no such effect".to_owned(),
                false => names.join(", or "),
            };
            vec![Cell::Name(c.thing.replace('_', " ")), Cell::Text(names)]
        })
        .collect();
    table(html, &["concealed", "right is"], &list);
    put!(
        html,
        "<p class=\"quiet\">Written from ids and one-line titles of the catalogue before the first scored run, and not widened since. The benches were made \
         without regard to how the catalogue is parameterised. Of what no catalogue could hold, only <em>unknown</em> is right.</p>"
    );
}

fn method(html: &mut String, settings: &Settings, origin: &Origin) {
    put!(html, "<h2>How this was made</h2>");
    let mut command = format!(
        "cargo xtask prove --benches --count {} --seed {}",
        settings.count, settings.seed
    );
    if !settings.only.is_empty() {
        command.push_str(&format!(" --only {}", settings.only.join(",")));
    }
    put!(html, "<p><code>{}</code></p>", escape(&command));
    put!(
        html,
        "<p><code>dgd-plant bench</code> made the recordings and printed the SHA-256 of the truths before the first diagnosis. <code>dgd diagnose --system</code> \
         ran on each in a temporary folder with the recording, its system.toml and nothing else, {} at a time. After the last the truths had the same SHA-256 \
         and were opened.</p>",
        settings.jobs
    );
    let program = &origin.program;
    let commit = program
        .commit
        .as_ref()
        .map_or_else(String::new, |c| format!(", {c}"));
    table(
        html,
        &["", ""],
        &[
            vec![Cell::Name("truths".into()), Cell::Text(origin.seal.clone())],
            vec![
                Cell::Name("program".into()),
                Cell::Text(format!(
                    "{}{commit}; SHA-256 {}",
                    program.version, program.sha256
                )),
            ],
            vec![
                Cell::Name("cores".into()),
                Cell::Text(program.cores.to_string()),
            ],
        ],
    );
}

#[cfg(test)]
mod tests {
    use super::super::score::tests::row;
    use super::*;
    use crate::prove::Program;

    #[test]
    fn every_section_stands_with_and_without_cases() {
        let settings = Settings {
            count: 2,
            seed: 5005,
            out: "x".into(),
            jobs: 1,
            only: Vec::new(),
            keep: false,
        };
        let origin = Origin {
            program: Program {
                version: "dgd <0>".into(),
                sha256: "ef56".into(),
                commit: None,
                cores: 2,
            },
            seal: "ab12".into(),
        };
        let rows = [
            row(
                Some(("shaft_leak", "tank", "shaft")),
                &[("shaft", "tank_leak", &[])],
            ),
            row(None, &[("", "unknown", &[])]),
        ];
        for html in [
            write(&settings, &origin, &rows),
            write(&settings, &origin, &[]),
        ] {
            for part in [
                "Scores",
                "Thing by thing",
                "Every case",
                "What counts as right",
                "ab12",
                "dgd &lt;0&gt;",
            ] {
                assert!(html.contains(part), "{part}");
            }
            assert!(html.ends_with(END));
        }
        assert!(write(&settings, &origin, &rows).contains("shaft leak, moderate"));
    }
}
