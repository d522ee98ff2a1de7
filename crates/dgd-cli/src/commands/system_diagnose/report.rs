//! The page of a diagnosis of a system: what was left out, before and after, what was tested.

use super::{Done, curve, name, outcome, probability, sentence};
use crate::say::{self, brief, number};
use crate::system::{diagram, page, unit_of};
use dgd_documents::FittedSystem;
use dgd_report::{Axis, Page, ReportError, Role, Series, TimePanel, series_over, time_series};
use dgd_revise::Trace;

pub(super) fn html(done: &Done, fitted: &FittedSystem) -> Result<String, ReportError> {
    let revision = &done.revision;
    let mut lead = sentence(done);
    if let Some(first) = lead.get(..1) {
        lead.replace_range(..1, &first.to_uppercase());
    }
    let mut page = Page::new(
        format!("Diagnosis of {} on {}", done.title, done.recording),
        lead,
    );
    if !revision.findings.is_empty() {
        page.section("What was left out");
    }
    for finding in &revision.findings {
        page.paragraph(&format!("{}: {}.", name(finding), finding.title));
        let mut points = Vec::new();
        if !finding.equation.is_empty() {
            points.push(format!(
                "Equation: {} ({})",
                finding.equation, finding.source
            ));
        }
        if let Some(p) = finding.probability {
            points.push(format!(
                "Probability {}: so often was such a weight right where the truth was known. It weighs the sets of effects that were fitted by their scores on left-out blocks, less chance and what stays unexplained.",
                probability(p)
            ));
        }
        points.extend(finding.parameters.iter().map(|p| {
            let [value, low, high] = say::with_interval(p.value, p.ci95);
            let unit = unit_of(revision.after.assembly.system(), &p.path);
            let gap = if unit.is_empty() { "" } else { " " };
            format!(
                "{} = {value}{gap}{unit}, 95 % interval {low} to {high}: {}",
                p.path, p.meaning
            )
        }));
        if !finding.region.is_empty() {
            points.push(format!("Where: {}", finding.region));
        }
        if finding.left_out_loss.is_finite() {
            points.push(format!(
                "Without it the mean square on left-out blocks is {} times the present one, {} standard errors more.",
                brief(1.0 + finding.left_out_loss),
                brief(finding.standard_errors)
            ));
        }
        if !points.is_empty() {
            page.list(&points);
        }
    }
    let classes: Vec<String> = revision
        .classes
        .iter()
        .map(|class| {
            let sets: Vec<String> = class.members.iter().map(|m| m.join(" with ")).collect();
            let test = class.separating_test.as_ref();
            let test = test.map_or(String::new(), |t| {
                format!(" What would separate them: {t}.")
            });
            format!("{}.{test}", sets.join(", or "))
        })
        .collect();
    if !classes.is_empty() {
        page.note("This recording cannot tell these apart:")
            .list(&classes);
    }
    page.section("Before and after")
        .table(&before_and_after(done));
    figures(&mut page, done)?;
    page.section("The system")
        .figure(&diagram::draw(revision.after.assembly.system())?);
    page.section("Parameters");
    page::parameters(&mut page, &revision.after.assembly, &fitted.parameters)?;
    if revision.sections.len() > 1 {
        page.section("Sections").table(&sections(done));
    }
    page.section("What was tested").table(&tested(done));
    let checks = revision.checks.iter().map(|c| {
        let passed = if c.passed { "passed" } else { "failed" };
        vec![c.name.clone(), passed.into(), c.detail.clone()]
    });
    page.section("Checks and settings")
        .table(&dgd_report::Table {
            caption: "Checks".into(),
            head: ["Check", "", "Numbers"].map(Into::into).to_vec(),
            rows: checks.collect(),
        });
    page.table(&dgd_report::Table {
        caption: "Settings".into(),
        head: Vec::new(),
        rows: revision
            .settings
            .iter()
            .map(|(n, v)| vec![n.clone(), v.clone()])
            .collect(),
    });
    Ok(page.html())
}

fn before_and_after(done: &Done) -> dgd_report::Table {
    let rows = done
        .revision
        .outputs
        .iter()
        .zip(&done.gauges)
        .map(|(gain, gauge)| {
            let cell = |v: f64| {
                if v.is_finite() {
                    number(gauge.difference(v))
                } else {
                    "—".to_owned()
                }
            };
            let pairs = [gain.training, gain.left_out, gain.test];
            let mut row = vec![gain.output.clone(), gauge.symbol.clone()];
            row.extend(pairs.into_iter().flat_map(|(a, b)| [cell(a), cell(b)]));
            row
        });
    dgd_report::Table {
        caption:
            "Root mean square of simulated less measured: training, left-out blocks of it, held out"
                .into(),
        head: [
            "Instrument",
            "Unit",
            "Training",
            "after",
            "Left out",
            "after",
            "Held out",
            "after",
        ]
        .map(Into::into)
        .to_vec(),
        rows: rows.collect(),
    }
}

fn figures(page: &mut Page, done: &Done) -> Result<(), ReportError> {
    let independent = &done.revision.after.assembly.system().independent;
    for (test, part) in [(true, "held-out"), (false, "training")] {
        let traces: Vec<&Trace> = done
            .revision
            .traces
            .iter()
            .filter(|t| t.test == test)
            .collect();
        for (output, gauge) in done
            .gauges
            .iter()
            .enumerate()
            .filter(|_| !traces.is_empty())
        {
            let mut time = Vec::new();
            let mut curves = vec![Vec::new(); 3];
            for trace in &traces {
                // A gap between windows, in which nothing is drawn.
                if !time.is_empty() {
                    time.extend(trace.time.first());
                    curves.iter_mut().for_each(|c| c.push(f64::NAN));
                }
                let mut order: Vec<usize> = (0..trace.time.len()).collect();
                order.sort_by(|&a, &b| trace.time[a].total_cmp(&trace.time[b]));
                time.extend(order.iter().map(|&i| trace.time[i]));
                for (k, out) in curves.iter_mut().enumerate() {
                    let values = curve(trace, output, k, gauge);
                    out.extend(order.iter().map(|&i| values[i]));
                }
            }
            let roles = [
                ("Measured", Role::Measured),
                ("Before", Role::Before),
                ("After", Role::Model),
            ];
            let series: Vec<Series<'_>> = roles
                .into_iter()
                .zip(&curves)
                .map(|((label, role), value)| Series {
                    label,
                    role,
                    time_s: &time,
                    value,
                })
                .collect();
            let panel = [TimePanel {
                axis: Axis::new(gauge.label()),
                title: "",
                series: &series,
            }];
            let caption = format!("{} in the {part} part, before and after.", gauge.name);
            let figure = if independent == "time" {
                time_series(&panel, &[])?.with_caption(caption)
            } else {
                series_over(&Axis::new(independent.clone()), &panel, &[], &caption)?
            };
            page.figure(&figure);
        }
    }
    Ok(())
}

fn sections(done: &Done) -> dgd_report::Table {
    let rows = done.revision.sections.iter().map(|s| {
        let values = s
            .parameters
            .iter()
            .map(|(p, v)| format!("{p} = {}", number(*v)));
        let cause = if s.cause.is_empty() {
            "the same".into()
        } else {
            s.cause.join(" with ")
        };
        vec![
            format!("{} to {}", number(s.from), number(s.to)),
            cause,
            values.collect::<Vec<_>>().join(", "),
        ]
    });
    dgd_report::Table {
        caption: "Stretches in which one cause holds with one set of parameters".into(),
        head: ["From, to", "Cause", "Parameters"].map(Into::into).to_vec(),
        rows: rows.collect(),
    }
}

fn tested(done: &Done) -> dgd_report::Table {
    let rows = done.revision.tested.iter().map(|t| {
        vec![
            t.component.clone(),
            t.effect.to_owned(),
            outcome(t.outcome).replace('_', " "),
            brief(100.0 * t.gain),
            brief(t.score),
            t.limit.map_or("—".into(), brief),
        ]
    });
    dgd_report::Table {
        caption: "Gain: share of the residual's square, linear; score in standard deviations; limit: the size that five of them would have shown".into(),
        head: ["Component", "Effect", "Outcome", "Gain [%]", "Score", "Limit"].map(Into::into).to_vec(),
        rows: rows.collect(),
    }
}
