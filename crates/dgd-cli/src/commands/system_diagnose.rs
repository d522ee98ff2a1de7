//! `dgd diagnose --system`: what a system of any components leaves out.

mod report;
mod tell;

use crate::args::Global;
use crate::failure::Failure;
use crate::output::{self, Outputs};
use crate::progress::Progress;
use crate::say::{self, brief};
use crate::system::measure::Measure;
use crate::system::quantity::{self, Quantity};
use crate::system::{self, Gauge, column, columns, failed, gauges, runs};
use dgd_assembly::{Assembly, Record, System};
use dgd_documents::{FittedParameter, FittedSystem, write_fitted_system};
use dgd_recording::Table;
use dgd_revise::{
    Estimate, Excuse, Finding, Model, Options, Outcome, OutputGain, ReviseError, Revision, Shape,
    Stage, Tested, Trace, Verdict, revise,
};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

/// Probability from which a name is told without a reserve.
const LIKELY: f64 = 0.5;

/// A revision and what it is told with.
struct Done {
    title: String,
    recording: String,
    revision: Revision,
    gauges: Vec<Gauge>,
    /// What was wrong in the recording.
    issues: Vec<String>,
}

pub(crate) fn run(
    out: &Path,
    path: &Path,
    recordings: &[PathBuf],
    global: &Global,
) -> Result<String, Failure> {
    let progress = Progress::new(global);
    let (recording, document) = system::open(path, recordings)?;
    let assembly = &document.assembly;
    let held = columns::whole(recording, path, assembly, &progress)?;
    if out.exists() && !out.is_dir() {
        return Err(Failure::unwritten(out, "it is not a folder"));
    }
    let names = [
        "model.toml",
        "simulation.csv",
        "report.html",
        "diagnosis.json",
    ];
    let files = names.map(|name| out.join(name));
    files.iter().try_for_each(|file| output::check(file))?;
    let record = Record {
        columns: (held.columns)
            .iter()
            .map(|(n, v)| (n.as_str(), v.as_slice()))
            .collect(),
    };
    let mut said = |stage: Stage| {
        let (kind, what) = words(stage);
        progress.stage(kind, &what);
    };
    let revision =
        revise(assembly, &record, &Options::default(), &mut said).map_err(|e| match e {
            ReviseError::Assembly(error) => failed(path, recording, &error),
            other => Failure::input(recording, other),
        })?;
    let mut issues = held.issues;
    let fitted_part = || revision.traces.iter().filter(|t| !t.test);
    let readings = |o: usize| {
        let signals = fitted_part().filter_map(move |t| t.outputs.get(o));
        signals.flat_map(|s| s.measured.iter().copied().zip(s.before.iter().copied()))
    };
    // What a named effect explains is no doubt of a unit.
    if revision.verdict == Verdict::Unexplained {
        for doubt in runs::doubted(assembly, readings) {
            tracing::warn!("{}: {doubt}", recording.display());
            issues.push(doubt);
        }
    }
    progress.stage("writing", &out.display().to_string());
    let done = Done {
        title: system::title(assembly, path),
        recording: system::file_name(recording),
        gauges: gauges(assembly),
        issues,
        revision,
    };
    let fitted = fitted(&done);
    let model = write_fitted_system(&done.revision.after.assembly, &fitted)
        .map_err(|e| failed(path, recording, &e))?;
    let head = tell::unwritten(&done).map_or_else(String::new, |line| format!("# {line}.\n"));
    let model = head + &model;
    let html = report::html(&done, &fitted).map_err(|e| Failure::unwritten(&files[2], e))?;
    let value = as_json(&done);
    let table = table(&done, assembly);
    let mut outputs = Outputs::new();
    outputs.add_bytes(&files[0], &model)?;
    outputs.add_csv(&files[1], &table)?;
    outputs.add_bytes(&files[2], &html)?;
    outputs.add_bytes(&files[3], say::json(&value))?;
    outputs.keep()?;
    tracing::info!("seconds by stage: {}", progress.seconds_by_stage());
    drop(progress);
    if global.json {
        return Ok(say::json(&value));
    }
    let mut said = String::new();
    // Writing to a String cannot fail.
    let _ = tell::answer(&mut said, &done, out);
    Ok(said)
}

fn words(stage: Stage) -> (&'static str, String) {
    match stage {
        Stage::Baseline => ("re-fitting", "the system as described".into()),
        Stage::Screening => ("screening", "the catalogue".into()),
        Stage::Fitting(size) => ("fitting", format!("sets of {size}")),
        Stage::Exchanging => ("exchanging", "what was found, for its rivals".into()),
        Stage::Confirming => ("confirming", "on the test part".into()),
    }
}

fn fitted(done: &Done) -> FittedSystem {
    let parameter = |e: &Estimate| FittedParameter {
        path: e.path.clone(),
        value: e.value,
        standard_error: e.standard_error,
        at_bound: e.at_bound,
    };
    let Model { parameters, .. } = &done.revision.after;
    let traces = done.revision.traces.iter().filter(|t| !t.test);
    FittedSystem {
        recording: done.recording.clone(),
        status: done.revision.verdict.name().into(),
        samples: traces
            .flat_map(|t| &t.outputs)
            .map(|s| s.measured.iter().filter(|v| v.is_finite()).count())
            .sum(),
        parameters: parameters.iter().map(parameter).collect(),
    }
}

/// `upper.unseen_brim`
fn name(finding: &Finding) -> String {
    if finding.component.is_empty() {
        return finding.effect.clone();
    }
    format!("{}.{}", finding.component, finding.effect)
}

/// A finding with as much reserve as it deserves.
fn told(finding: &Finding) -> String {
    /// Alternatives that are named; the others are counted.
    const NAMED: usize = 2;
    // Nothing is named.
    if finding.component.is_empty() {
        return finding.title.clone();
    }
    // What is as likely as not, or may as well be none, is told as no more than that.
    let doubtful = finding.slight
        || finding
            .probability_with_alternatives
            .is_some_and(|p| p < LIKELY);
    let perhaps = if doubtful { "perhaps " } else { "" };
    let (name, title) = (name(finding), &finding.title);
    let others = &finding.alternatives;
    if others.is_empty() || finding.probability.is_none_or(|p| p >= LIKELY) {
        return format!("{perhaps}{name} ({title})");
    }
    let mut all = vec![name];
    all.extend(others.iter().take(NAMED).map(|(other, _)| other.clone()));
    let more = others.len().saturating_sub(NAMED);
    let last = match more {
        0 => all.pop().unwrap_or_default(),
        n => format!("{n} more"),
    };
    format!(
        "{perhaps}one of {} or {last} (the first: {title})",
        all.join(", ")
    )
}

/// The answer in one sentence.
fn sentence(done: &Done) -> String {
    let revision = &done.revision;
    let found: Vec<String> = revision.findings.iter().map(told).collect();
    let answer = match revision.verdict {
        Verdict::Consistent => match revision.excused {
            None => "the model leaves out nothing that this recording could show".to_owned(),
            Some(Excuse::Accuracy) => {
                "what the model leaves is more than chance, but within the accuracy of the instruments".to_owned()
            }
            Some(Excuse::Noise | Excuse::Small) => {
                "what the model leaves is more than chance, but of each instrument within its accuracy, or no more than a tenth above its noise".to_owned()
            }
        },
        Verdict::Unexplained if found.is_empty() => {
            "the model leaves out something that no effect of the catalogue explains".to_owned()
        }
        Verdict::Unexplained if revision.findings.iter().all(|f| f.component.is_empty()) => {
            found.join("; ")
        }
        _ => format!("left out: {}", found.join("; ")),
    };
    let doubtful: Vec<String> = revision.also_possible.iter().map(name).collect();
    let answer = if doubtful.is_empty() {
        answer
    } else {
        format!(
            "{answer}. Also possible, and in the model: {}",
            doubtful.join("; ")
        )
    };
    let gains: Vec<String> = revision
        .outputs
        .iter()
        .zip(&done.gauges)
        .filter_map(|(gain, gauge)| gained(gain, gauge))
        .collect();
    if gains.is_empty() || revision.verdict == Verdict::Consistent {
        return format!("{answer}.");
    }
    format!("{answer}. Root mean square {}.", gains.join("; "))
}

/// `of level from 0.7 to 0.2 cm on held-out data`
fn gained(gain: &OutputGain, gauge: &Gauge) -> Option<String> {
    let tested = gain.test.0.is_finite();
    let (before, after) = if tested { gain.test } else { gain.left_out };
    let part = if tested {
        "held-out data"
    } else {
        "left-out blocks"
    };
    let shown = |v: f64| brief(gauge.difference(v));
    before.is_finite().then(|| {
        let after = gauge.with_unit(&shown(after));
        format!(
            "of {} from {} to {after} on {part}",
            gain.output,
            shown(before)
        )
    })
}

/// The parameter of an effect, its distance from neutral that would have shown, and the unit of that.
fn smallest(system: &System, tested: &Tested) -> Option<(&'static str, f64, String)> {
    let about = dgd_assembly::effects::find(tested.effect)?.about();
    let first = about.parameters.first()?.name;
    let path = format!("{}.{}.{first}", tested.component, tested.effect);
    let measure = Measure::of(system, &path);
    let limit = tested.limit.filter(|l| l.is_finite())?;
    Some((first, measure.shown(limit), measure.symbol))
}

fn outcome(outcome: Outcome) -> &'static str {
    match outcome {
        Outcome::Found => "found",
        Outcome::Possible => "possible",
        Outcome::Alternative => "alternative",
        Outcome::NotNeeded => "not_needed",
        Outcome::NotSeen => "not_seen",
        Outcome::Absorbed => "absorbed",
        Outcome::NotTestable => "not_testable",
    }
}

/// Two digits; never a certainty.
fn probability(p: f64) -> String {
    format!("{:.2}", p.clamp(0.01, 0.99))
}

fn estimate_as_json(assembly: &Assembly, e: &Estimate) -> Value {
    let measure = Measure::of(assembly.system(), &e.path);
    let (low, high) = measure.ends(e.ci95);
    json!({ "path": e.path, "meaning": tell::meaning(assembly, e), "value": measure.shown(e.value), "ci95": [low, high],
            "standard_error": measure.shown(e.standard_error), "at_bound": e.at_bound, "unit": measure.symbol })
}

fn finding_as_json(assembly: &Assembly, f: &Finding) -> Value {
    let estimates = f.parameters.iter();
    json!({
        "effect": f.effect,
        "component": f.component,
        "title": f.title,
        "equation": f.equation,
        "source": f.source,
        "parameters": estimates.map(|e| estimate_as_json(assembly, e)).collect::<Vec<_>>(),
        "intervals": f.intervals.iter().map(|(a, b)| json!([a, b])).collect::<Vec<_>>(),
        "region": f.region.as_ref().map_or_else(String::new, |r| quantity::place(assembly, r)),
        "range": f.region.as_ref().map(|r| {
            let along = Quantity::of(assembly, &r.along);
            json!({ "along": r.along, "from": along.shown(r.range.0), "to": along.shown(r.range.1), "unit": along.symbol,
                    "share": r.share, "of_samples": r.of_samples })
        }),
        "left_out_loss": f.left_out_loss,
        "standard_errors": f.standard_errors,
        "probability": f.probability,
        "probability_with_alternatives": f.probability_with_alternatives,
        "alternatives": f.alternatives.iter().map(|(n, worse)| json!({ "effect": n, "worse_by": worse })).collect::<Vec<_>>(),
        "separating_test": f.separating_test,
        "slight": f.slight,
        "shape": f.shape.as_ref().map(|s| shape_as_json(assembly, s)),
    })
}

/// Knots and values in the units in which their quantities are read.
fn shape_as_json(assembly: &Assembly, shape: &Shape) -> Value {
    let along = Quantity::of(assembly, &shape.along);
    let knots: Vec<f64> = shape.knots.iter().map(|k| along.shown(*k)).collect();
    let gauge = gauges(assembly).into_iter().find(|g| g.name == shape.of);
    // What is no reading is an inflow.
    let (values, unit) = match gauge {
        Some(gauge) => {
            let values = shape.values.iter().map(|v| gauge.difference(*v));
            (values.collect(), gauge.symbol)
        }
        None => (shape.values.clone(), "m3/s".to_owned()),
    };
    json!({ "of": shape.of, "along": shape.along, "along_unit": along.symbol, "knots": knots, "values": values, "unit": unit })
}

fn as_json(done: &Done) -> Value {
    let revision = &done.revision;
    let assembly = &revision.after.assembly;
    let model = |m: &Model| {
        let estimates = m.parameters.iter();
        estimates
            .map(|e| estimate_as_json(assembly, e))
            .collect::<Vec<_>>()
    };
    let list = |findings: &[Finding]| {
        let each = findings.iter().map(|f| finding_as_json(assembly, f));
        each.collect::<Vec<_>>()
    };
    json!({
        "schema": "dgd.system-diagnosis/1",
        "issues": done.issues,
        "system": done.title,
        "recording": done.recording,
        "verdict": revision.verdict.name(),
        "answer": sentence(done),
        "excused": revision.excused.map(|e| match e {
            Excuse::Accuracy => "accuracy",
            Excuse::Noise | Excuse::Small => "noise",
        }),
        "findings": list(&revision.findings),
        "also_possible": list(&revision.also_possible),
        "classes": revision.classes.iter().map(|c| json!({
            "members": c.members, "apart": c.apart, "separating_test": c.separating_test,
        })).collect::<Vec<_>>(),
        "outputs": revision.outputs.iter().zip(&done.gauges).map(|(o, gauge)| {
            let pair = |(a, b): (f64, f64)| json!([gauge.difference(a), gauge.difference(b)]);
            json!({ "name": o.output, "unit": gauge.symbol, "training": pair(o.training), "left_out": pair(o.left_out),
                    "test": pair(o.test), "test_gain_ci95": [o.test_gain_ci95.0, o.test_gain_ci95.1] })
        }).collect::<Vec<_>>(),
        "tested": revision.tested.iter().map(|t| {
            let smallest = smallest(assembly.system(), t);
            json!({
                "component": t.component, "effect": t.effect, "title": t.title, "outcome": outcome(t.outcome),
                "gain": t.gain, "score": t.score, "limit": smallest.as_ref().map(|s| s.1),
                "parameter": smallest.as_ref().map(|s| s.0), "unit": smallest.map(|s| s.2),
            })
        }).collect::<Vec<_>>(),
        "after_is_model": revision.unwritten().is_none(),
        "contenders": revision.contenders.iter().map(|c| json!({
            "members": c.members, "training": c.training, "left_out": c.left_out, "standard_error": c.standard_error,
        })).collect::<Vec<_>>(),
        "sections": revision.sections.iter().map(|s| json!({
            "from": s.from, "to": s.to, "cause": s.cause,
            "common": in_units(&s.common, &done.gauges), "own": in_units(&s.own, &done.gauges),
            "parameters": s.parameters.iter().map(|(p, v)| {
                let measure = Measure::of(assembly.system(), p);
                json!({ "path": p, "value": measure.shown(*v), "unit": measure.symbol })
            }).collect::<Vec<_>>(),
        })).collect::<Vec<_>>(),
        "checks": revision.checks.iter().map(|c| json!({ "name": c.name, "passed": c.passed, "detail": c.detail })).collect::<Vec<_>>(),
        "parameters": { "before": model(&revision.before), "after": model(&revision.after) },
        "settings": revision.settings.iter().map(|(n, v)| json!({ "name": n, "value": v })).collect::<Vec<_>>(),
    })
}

/// Errors by instrument, each in the unit of its instrument.
fn in_units(errors: &[f64], gauges: &[Gauge]) -> Vec<f64> {
    let each = errors.iter().zip(gauges);
    each.map(|(error, gauge)| gauge.difference(*error))
        .collect()
}

/// Measured, before and after along all windows.
fn table(done: &Done, assembly: &Assembly) -> Table {
    let traces = &done.revision.traces;
    let (clock, unit) = system::clock(assembly);
    let held = |t: &Trace| std::iter::repeat_n(f64::from(u8::from(t.test)), t.time.len());
    let mut columns = vec![
        column(
            clock,
            unit,
            traces.iter().flat_map(|t| t.time.clone()).collect(),
        ),
        column("held_out", None, traces.iter().flat_map(held).collect()),
    ];
    for (output, gauge) in done.gauges.iter().enumerate() {
        for (k, what) in ["measured", "before", "after"].into_iter().enumerate() {
            let values = traces
                .iter()
                .flat_map(|t| curve(t, output, k, gauge))
                .collect();
            let unit = (!gauge.symbol.is_empty()).then(|| gauge.symbol.clone());
            columns.push(column(&format!("{}_{what}", gauge.name), unit, values));
        }
    }
    Table {
        columns,
        ..Table::default()
    }
}

/// Measured (0), before (1) or after (2) in the instrument's unit.
fn curve(trace: &Trace, output: usize, which: usize, gauge: &Gauge) -> Vec<f64> {
    let Some(signal) = trace.outputs.get(output) else {
        return vec![f64::NAN; trace.time.len()];
    };
    let values = [&signal.measured, &signal.before, &signal.after][which];
    if values.len() != trace.time.len() {
        return vec![f64::NAN; trace.time.len()];
    }
    values.iter().map(|v| gauge.shown(*v)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn finding(probability: f64, alternatives: &[&str]) -> Finding {
        let others = alternatives.iter().map(|name| ((*name).to_owned(), 0.01));
        Finding {
            effect: "opening_play".into(),
            component: "gate".into(),
            title: "the valve has play".into(),
            equation: String::new(),
            source: String::new(),
            parameters: Vec::new(),
            intervals: Vec::new(),
            region: None,
            left_out_loss: 1.0,
            standard_errors: 3.0,
            probability: Some(probability),
            probability_with_alternatives: Some(0.8),
            alternatives: others.collect(),
            separating_test: None,
            slight: false,
            shape: None,
        }
    }

    #[test]
    fn a_name_among_ties_is_told_as_one_of_them_and_what_may_be_none_as_perhaps() {
        let others = [
            "gate.opening_stiction",
            "first.taper",
            "first.vortex",
            "l1.lag",
        ];
        assert_eq!(
            told(&finding(0.8, &[])),
            "gate.opening_play (the valve has play)"
        );
        // Likelier than all others together.
        assert_eq!(
            told(&finding(0.7, &others[..1])),
            "gate.opening_play (the valve has play)"
        );
        assert_eq!(
            told(&finding(0.4, &others[..1])),
            "one of gate.opening_play or gate.opening_stiction (the first: the valve has play)"
        );
        assert_eq!(
            told(&finding(0.2, &others)),
            "one of gate.opening_play, gate.opening_stiction, first.taper or 2 more (the first: the valve has play)"
        );
        let slight = Finding {
            slight: true,
            ..finding(0.8, &[])
        };
        assert_eq!(
            told(&slight),
            "perhaps gate.opening_play (the valve has play)"
        );
        let unlikely = Finding {
            probability_with_alternatives: Some(0.4),
            ..finding(0.2, &others[..1])
        };
        assert!(told(&unlikely).starts_with("perhaps one of "));
    }
}
