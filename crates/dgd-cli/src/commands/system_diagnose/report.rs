//! The page of a diagnosis of a system: what was left out, before and after, what was tested.

use super::{Done, curve, name, outcome, sentence, smallest, tell};
use crate::say::{brief, number};
use crate::system::{diagram, measure::Measure, page, quantity::Quantity};
use dgd_assembly::System;
use dgd_documents::FittedSystem;
use dgd_report::{Axis, Page, ReportError, Role, Series, TimePanel, series_over, time_series};
use dgd_revise::{Finding, Outcome, Tested, Trace};

pub(super) fn html(done: &Done, fitted: &FittedSystem) -> Result<String, ReportError> {
    let revision = &done.revision;
    let mut page = Page::new(
        format!("Diagnosis of {} on {}", done.title, done.recording),
        format!(
            "Verdict: {}. {}",
            revision.verdict.name().replace('_', " "),
            capital(sentence(done))
        ),
    );
    if !revision.findings.is_empty() {
        page.section("What was left out");
    }
    if !done.issues.is_empty() {
        page.note("Faults in the recording, which may be all that is found here:")
            .list(&done.issues);
    }
    for finding in &revision.findings {
        found(&mut page, done, finding);
    }
    if !revision.also_possible.is_empty() {
        page.section("Also possible").paragraph(
            "Part of the model, which predicts left-out blocks better with it, but with too little weight to be a finding, alternatives included, \
             after allowing for chance and for what stays unexplained: something else may do the same.",
        );
    }
    for finding in &revision.also_possible {
        found(&mut page, done, finding);
    }
    let classes: Vec<String> = revision
        .classes
        .iter()
        .map(|class| {
            let test = class.separating_test.as_ref();
            let test = test.map_or(String::new(), |t| {
                format!(" What would separate them: {t}.")
            });
            format!("{}.{test}", rivals(&class.members))
        })
        .collect();
    if !classes.is_empty() {
        page.note("This recording cannot separate these:")
            .list(&classes);
    }
    page.section("Before and after")
        .table(&before_and_after(done));
    if let Some(line) = tell::unwritten(done) {
        page.note(&format!("{}.", capital(line)));
    }
    figures(&mut page, done)?;
    page.section("The system")
        .figure(&diagram::draw(revision.after.assembly.system())?);
    page.section("Parameters");
    let rows: Vec<page::Parameter<'_>> = (fitted.parameters.iter())
        .zip(&revision.after.parameters)
        .map(|(fitted, told)| page::Parameter {
            fitted,
            ci95: told.ci95,
        })
        .collect();
    let includes = "the noise and its autocorrelation, or the spread between parts of the record if that is wider";
    page::parameters(&mut page, &revision.after.assembly, &rows, includes)?;
    if revision.sections.len() > 1 {
        page.section("Sections").table(&sections(done));
    }
    page.section("What was tested").paragraph(
        "Found: among the findings. Possible: part of the model, with too little weight for a finding. Alternative: as good as one of them. \
         Absorbed: re-fitted free parameters do the same, so it cannot be seen here and does not matter here. Not testable: the recording does not \
         excite it. Not seen: looked for, but absent or with too little weight to be claimed.",
    );
    page.table(&tested(done));
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

fn found(page: &mut Page, done: &Done, finding: &Finding) {
    let assembly = &done.revision.after.assembly;
    page.subsection(&name(finding))
        .paragraph(&format!("{}.", finding.title));
    let mut points = Vec::new();
    if !finding.equation.is_empty() {
        points.push(format!(
            "Equation: {} ({})",
            finding.equation, finding.source
        ));
    }
    points.extend(tell::likely(finding).map(|line| {
        format!(
            "{}. The weight is that of the fitted sets of effects that contain it, by their scores on left-out blocks, less chance and what stays \
             unexplained.",
            capital(line)
        )
    }));
    points.extend(finding.parameters.iter().map(|p| {
        let line = page::typeset(&tell::parameter(assembly, p));
        format!("{line}: {}", tell::meaning(assembly, p))
    }));
    points.extend(tell::places(assembly, finding).into_iter().map(capital));
    if finding.left_out_loss.is_finite() {
        points.push(format!(
            "Without it the mean square on left-out blocks is {} times as large, {} standard errors more.",
            brief(1.0 + finding.left_out_loss),
            brief(finding.standard_errors)
        ));
    }
    if !points.is_empty() {
        page.list(&points);
    }
}

fn capital(mut line: String) -> String {
    if let Some(first) = line.get(..1).map(str::to_uppercase) {
        line.replace_range(..1, &first);
    }
    line
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
            "Root mean square of simulated minus measured: training, its left-out blocks, held out"
                .into(),
        head: [
            "Instrument",
            "Unit",
            "Training",
            "→ after",
            "Cross-validation",
            "→ after",
            "Held out",
            "→ after",
        ]
        .map(Into::into)
        .to_vec(),
        rows: rows.collect(),
    }
}

fn figures(page: &mut Page, done: &Done) -> Result<(), ReportError> {
    let along = page::independent(&done.revision.after.assembly);
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
            let figure = match &along {
                None => time_series(&panel, &[])?.with_caption(caption),
                Some(axis) => series_over(axis, &panel, &[], &caption)?,
            };
            page.figure(&figure);
        }
    }
    Ok(())
}

fn sections(done: &Done) -> dgd_report::Table {
    let assembly = &done.revision.after.assembly;
    let along = Quantity::of(assembly, &assembly.system().independent);
    let rows = done.revision.sections.iter().map(|s| {
        let values = s.parameters.iter().map(|(p, v)| {
            let measure = Measure::of(assembly.system(), p);
            let unit = page::typeset(&measure.symbol);
            let told = format!("{p} = {} {unit}", number(measure.shown(*v)));
            told.trim_end().to_owned()
        });
        let cause = if s.cause.is_empty() {
            "the same".into()
        } else {
            s.cause.join(" with ")
        };
        vec![
            along.range((s.from, s.to)),
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
    let system = done.revision.after.assembly.system();
    let rank = |outcome: Outcome| match outcome {
        Outcome::Found => 0,
        Outcome::Possible => 1,
        Outcome::Alternative => 2,
        Outcome::NotNeeded => 3,
        Outcome::NotSeen => 4,
        Outcome::Absorbed => 5,
        Outcome::NotTestable => 6,
    };
    let mut ordered: Vec<&Tested> = done.revision.tested.iter().collect();
    ordered.sort_by(|a, b| {
        let by_gain = b.gain.total_cmp(&a.gain);
        rank(a.outcome).cmp(&rank(b.outcome)).then(by_gain)
    });
    let rows = ordered.into_iter().map(|t| {
        vec![
            t.component.clone(),
            t.effect.to_owned(),
            outcome(t.outcome).replace('_', " "),
            tenths(100.0 * t.gain),
            tenths(t.score),
            size(system, t).unwrap_or_else(|| "—".into()),
        ]
    });
    dgd_report::Table {
        caption: "Share of the squared residual that each would remove alone, its score in standard deviations, and the size that would have \
                  scored five of them. 'Not needed': it shows alone, and adds nothing to the findings or does not stand beside them".into(),
        head: ["Component", "Effect", "Outcome", "Share [%]", "Score", "Smallest size"].map(Into::into).to_vec(),
        rows: rows.collect(),
    }
}

fn tenths(value: f64) -> String {
    format!("{value:.1}")
}

/// `height 0.28 m`: the distance from neutral that would have shown.
fn size(system: &System, tested: &Tested) -> Option<String> {
    let (name, size, unit) = smallest(system, tested)?;
    let told = format!("{name} {} {}", brief(size), page::typeset(&unit));
    Some(told.trim_end().to_owned())
}

/// Sets that do the same: what all hold is said once.
fn rivals(sets: &[Vec<String>]) -> String {
    let common: Vec<&str> = (sets.first().into_iter().flatten())
        .filter(|one| sets.iter().all(|set| set.contains(one)))
        .map(String::as_str)
        .collect();
    let own: Vec<String> = (sets.iter())
        .map(|set| {
            let rest = set.iter().filter(|one| !common.contains(&one.as_str()));
            rest.cloned().collect::<Vec<_>>().join(" with ")
        })
        .map(|rest| {
            if rest.is_empty() {
                "nothing more".into()
            } else {
                rest
            }
        })
        .collect();
    if common.is_empty() {
        return own.join(", or ");
    }
    format!("beside {}: {}", common.join(", "), own.join(", or "))
}

#[cfg(test)]
mod tests {
    use super::rivals;

    #[test]
    fn what_rivals_have_in_common_is_said_once() {
        let set = |names: &[&str]| names.iter().map(|n| (*n).to_owned()).collect();
        let sets: Vec<Vec<String>> = vec![
            set(&["a.brim", "b.vortex"]),
            set(&["a.brim", "b.taper", "c.lag"]),
            set(&["a.brim"]),
        ];
        assert_eq!(
            rivals(&sets),
            "beside a.brim: b.vortex, or b.taper with c.lag, or nothing more"
        );
        assert_eq!(rivals(&[set(&["a"]), set(&["b"])]), "a, or b");
        assert_eq!(rivals(&[]), "");
    }
}
