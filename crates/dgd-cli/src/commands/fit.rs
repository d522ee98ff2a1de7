//! `dgd fit`: from recordings to an identified model.

use crate::args::{Fit, Global, Source, Subject, Window};
use crate::commands::system_fit;
use crate::failure::Failure;
use crate::figures;
use crate::load::{self, Loaded};
use crate::output::{self, Outputs};
use crate::progress::Progress;
use crate::say::{self, TextTable, count, number};
use dgd_friction::{Loss, PolynomialFit};
use dgd_identify::{
    Estimate, Identification, IdentifyOptions, Prepared, Series, identify, prepare,
};
use dgd_pump::CurveFit;
use dgd_recording::Well;
use dgd_screen::ScreenOptions;
use serde_json::{Value, json};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

/// A recording read, screened and identified.
pub(crate) struct Fitted {
    pub(crate) prepared: Prepared,
    /// Before the screening, for the figures that show what it rejects.
    pub(crate) unscreened: Option<(Series, Vec<f64>)>,
    pub(crate) identification: Identification,
    pub(crate) issues: Vec<String>,
    pub(crate) formats: Vec<String>,
}

pub(crate) fn run(arguments: &Fit, global: &Global) -> Result<String, Failure> {
    let source = match arguments.source.subject() {
        Subject::Well(source) => source,
        Subject::System(system, recordings) => {
            return system_fit::run(arguments, system, recordings, global);
        }
    };
    let progress = Progress::new(global);
    let well = load::read_well(&source.well)?;
    let loaded = load::read_recordings(&source.recordings, &well, &progress)?.within(&source)?;
    let options = IdentifyOptions {
        delays: delays_in_samples(arguments.delays, loaded.step_s)?,
        loss: if arguments.robust {
            Loss::Huber(Default::default())
        } else {
            Loss::Squared
        },
        free_exponents: !arguments.fixed_exponents,
        ..IdentifyOptions::default()
    };
    output::check(&arguments.out)?;
    if let Some(folder) = &arguments.figures {
        figures::check(folder)?;
    }
    let keep_unscreened = arguments.figures.is_some();
    let fitted = fit(loaded, &well, &source, &options, keep_unscreened, &progress)?;
    progress.stage("writing", &arguments.out.display().to_string());
    let model = dgd_documents::write_model(&fitted.identification.model);
    let mut outputs = Outputs::new();
    outputs.add_bytes(&arguments.out, model)?;
    let mut drawn = Vec::new();
    if let Some(folder) = &arguments.figures {
        progress.stage("drawing", "figures");
        drawn = figures::draw_identification(&mut outputs, folder, &fitted)?;
    }
    outputs.keep()?;
    let (seconds, stages) = (progress.seconds(), progress.seconds_by_stage());
    drop(progress);
    if global.json {
        let mut value = as_json(&fitted, &arguments.out, &drawn, seconds);
        value["seconds_by_stage"] = stages;
        return Ok(say::json(&value));
    }
    let mut text = tell(&fitted);
    let _ = writeln!(text, "\nwrote {}", arguments.out.display());
    if let Some(folder) = &arguments.figures {
        let drawn = say::counted(drawn.len() / 2, "figure");
        let _ = writeln!(text, "drew {drawn} into {}", folder.display());
    }
    Ok(text)
}

/// Screens and identifies what was read.
pub(crate) fn fit(
    loaded: Loaded,
    well: &Well,
    source: &Source,
    options: &IdentifyOptions,
    keep_unscreened: bool,
    progress: &Progress,
) -> Result<Fitted, Failure> {
    let first = &source.recordings[0];
    loaded.warn_of_suspicions();
    progress.stage("screening", "");
    let unscreened = keep_unscreened.then(|| {
        let recording = &loaded.recording;
        let series = Series::of(
            well,
            &recording.mean_inlet_pressure_pa(),
            &recording.mean_outlet_pressure_pa(),
        );
        (series, recording.return_flow_m3_s.clone())
    });
    let prepared = prepare(loaded.recording, loaded.step_s, &screening(source))
        .map_err(|e| Failure::input(first, e))?;
    progress.stage("identifying", "friction, delay and pump");
    let mut identification =
        identify(&prepared, well, options).map_err(|e| Failure::input(first, e))?;
    identification.model.data.samples = loaded.samples;
    identification.model.data.recordings = names(source);
    // They come first in the answer: what follows may rest on a wrong unit.
    let told = loaded.told.into_iter().chain(loaded.suspicions);
    identification.warnings.splice(0..0, told);
    identification.warnings.extend(prepared.not_used());
    let issues = loaded
        .issues
        .iter()
        .map(|(path, issue)| format!("{}: {issue}", path.display()))
        .collect();
    let formats = loaded.formats.iter().map(ToString::to_string).collect();
    Ok(Fitted {
        prepared,
        unscreened,
        identification,
        issues,
        formats,
    })
}

/// The screening a command asks for.
pub(crate) fn screening(source: &Source) -> ScreenOptions {
    if source.thesis_screening {
        ScreenOptions::thesis()
    } else {
        ScreenOptions::default()
    }
}

/// File names without their folders, and the window of them: a model travels, its author's folders do not.
pub(crate) fn names(source: &Source) -> Vec<String> {
    let mut names: Vec<String> = source
        .recordings
        .iter()
        .filter_map(|p| p.file_name())
        .map(|n| n.to_string_lossy().into_owned())
        .collect();
    if let (Some(window), Some(last)) = (&source.window, names.last_mut()) {
        let _ = match window {
            Window::Clock(from, to) => write!(last, " ({from} to {to} s)"),
            Window::Dates(..) => write!(last, " ({window})"),
        };
    }
    names
}

/// A range of delays in whole samples.
pub(crate) fn delays_in_samples(
    (from_s, to_s): (f64, f64),
    step_s: f64,
) -> Result<std::ops::RangeInclusive<i64>, Failure> {
    const MOST: f64 = 1e6;
    let (from, to) = ((from_s / step_s).round(), (to_s / step_s).round());
    if from.abs() > MOST || to.abs() > MOST {
        return Err(Failure::Arguments {
            reason: format!(
                "delays from {from_s} to {to_s} s span too many samples of {step_s} s: check the unit of [channels] time in the well description, \
                 or give a smaller range with --delays"
            ),
        });
    }
    #[expect(clippy::cast_possible_truncation, reason = "bounded above")]
    let range = from as i64..=to as i64;
    Ok(range)
}

pub(crate) fn tell(fitted: &Fitted) -> String {
    let mut text = String::new();
    // Writing to a String cannot fail.
    let _ = tell_into(&mut text, fitted);
    text
}

fn tell_into(text: &mut String, fitted: &Fitted) -> std::fmt::Result {
    let Identification { model, .. } = &fitted.identification;
    let data = &model.data;
    let hours = data.samples as f64 * data.step_s / 3600.0;
    writeln!(
        text,
        "{}: {} samples, {} h every {} s",
        data.recordings.join(", "),
        count(data.samples),
        number(hours),
        number(data.step_s)
    )?;
    let share = 100.0 * data.kept as f64 / data.samples as f64;
    writeln!(text, "screening kept {} ({share:.1} %)\n", count(data.kept))?;
    let mut reasons = TextTable::new(["rejected for", "samples", "rejected for this reason first"]);
    for tally in fitted.prepared.tally.iter().filter(|t| t.total > 0) {
        reasons.row([
            tally.name.to_owned(),
            count(tally.total),
            count(tally.first),
        ]);
    }
    writeln!(text, "{}", reasons.render())?;
    text.push_str(&ladder(&fitted.identification).render());
    writeln!(text)?;
    text.push_str(&parameters(&fitted.identification).render());
    if !fitted.identification.warnings.is_empty() {
        writeln!(text)?;
    }
    fitted
        .identification
        .warnings
        .iter()
        .try_for_each(|w| writeln!(text, "warning: {w}"))
}

/// The rungs with their errors.
fn ladder(id: &Identification) -> TextTable {
    let mut table = TextTable::new(["equation", "law", "root mean square", "R2", "note"]);
    let mut friction = |equation: &str, law: &str, fit: Option<&PolynomialFit>, note: String| {
        let (rmse, r2) = fit.map_or((String::new(), String::new()), |f| {
            (
                format!("{} Pa", number(f.mse_pa2.sqrt())),
                format!("{:.4}", f.r2),
            )
        });
        table.row([equation.into(), law.into(), rmse, r2, note]);
    };
    let refused =
        |reason: Option<String>| reason.map_or(String::new(), |r| format!("refused: {r}"));
    let undelayed = id.undelayed.as_ref();
    friction(
        "3.14",
        "F = C q + D q^2",
        undelayed.ok(),
        refused(undelayed.err().map(ToString::to_string)),
    );
    let delay = format!(
        "delay {} s (refined {} s)",
        number(id.sweep.delays_s[id.sweep.best]),
        number(id.sweep.refined_delay_s)
    );
    friction(
        "3.23",
        "F = C q(t+d) + D q(t+d)^2",
        Some(&id.sweep.fit),
        delay,
    );
    let cubic = id.cubic.as_ref();
    friction(
        "3.26",
        "F = B + D q^2 + E q^3",
        cubic.ok(),
        refused(cubic.err().map(ToString::to_string)),
    );
    let mut pump = |equation: &str, law: &str, fit: Option<&CurveFit>, note: String| {
        let (rmse, r2) = fit.map_or((String::new(), String::new()), |f| {
            (
                format!("{} m", number(f.mse_m2.sqrt())),
                format!("{:.4}", f.r2),
            )
        });
        table.row([equation.into(), law.into(), rmse, r2, note]);
    };
    let plain = id.pump.plain.as_ref();
    let sign = plain.ok().map_or(String::new(), |f| {
        format!(
            "c2 {}",
            if f.curve.c2 < 0.0 {
                "< 0: convex"
            } else {
                "> 0"
            }
        )
    });
    pump("3.31", "H = c0 w^2 - c1 w q - c2 q^2", plain.ok(), sign);
    let constrained = id.pump.constrained.as_ref();
    let active = constrained.ok().map_or(String::new(), |c| {
        let names = ["c0", "c1", "c2"]
            .into_iter()
            .zip(c.active)
            .filter(|(_, a)| *a)
            .map(|(n, _)| n);
        let names: Vec<&str> = names.collect();
        if names.is_empty() {
            "no bound reached".into()
        } else {
            format!("at bound: {} = 0", names.join(", "))
        }
    });
    pump(
        "3.31",
        "the same with c1, c2 > 0",
        constrained.ok().map(|c| &c.fit),
        active,
    );
    if let Some(search) = &id.pump.search {
        let note = match search {
            Ok(s) => format!(
                "n0 {} n2 {}, {} trials",
                number(s.fit.curve.n0),
                number(s.fit.curve.n2),
                s.trials.len()
            ),
            Err(reason) => format!("refused: {reason}"),
        };
        pump(
            "3.39",
            "H = c0 w^n0 - c1 w q - c2 q^n2",
            search.as_ref().ok().map(|s| &s.fit),
            note,
        );
    }
    table
}

/// The parameters of the model with their doubt.
fn parameters(id: &Identification) -> TextTable {
    let mut table = TextTable::new(["parameter", "value", "standard error", "unit"]);
    let mut row = |name: &str, estimate: &Estimate, unit: &str| {
        let [value, error] = estimate.standard_error.map_or_else(
            || [number(estimate.value), "held".to_owned()],
            |error| say::with_error(estimate.value, error),
        );
        table.row([name.into(), value, error, unit.into()]);
    };
    let letters = [
        ("B", "Pa"),
        ("C", "Pa/(m3/s)"),
        ("D", "Pa/(m3/s)^2"),
        ("E", "Pa/(m3/s)^3"),
    ];
    for term in &id.model.friction.terms {
        let (letter, unit) = letters[usize::from(term.power.min(3))];
        row(letter, &term.coefficient, unit);
    }
    let pump = &id.model.pump;
    row("c0", &pump.c0, "m/%^n0");
    row("c1", &pump.c1, "m/(% m3/s)");
    row("c2", &pump.c2, "m/(m3/s)^n2");
    table.row(["n0".into(), number(pump.n0), String::new(), String::new()]);
    table.row(["n2".into(), number(pump.n2), String::new(), String::new()]);
    table.row([
        "delay".into(),
        number(id.model.delay_s),
        String::new(),
        "s".into(),
    ]);
    table
}

fn as_json(fitted: &Fitted, out: &Path, drawn: &[PathBuf], seconds: f64) -> Value {
    let id = &fitted.identification;
    let data = &id.model.data;
    let friction = |fit: &PolynomialFit| {
        json!({
            "powers": fit.law.powers,
            "coefficients": fit.law.coefficients,
            "standard_errors": fit.standard_errors,
            "mse_pa2": fit.mse_pa2,
            "r2": fit.r2,
            "samples": fit.n,
            "condition": fit.condition,
        })
    };
    let curve = |fit: &CurveFit| {
        json!({
            "c": [fit.curve.c0, fit.curve.c1, fit.curve.c2],
            "n0": fit.curve.n0,
            "n2": fit.curve.n2,
            "standard_errors": fit.standard_errors,
            "mse_m2": fit.mse_m2,
            "r2": fit.r2,
            "samples": fit.n,
            "condition": fit.condition,
        })
    };
    fn or_error<T, E: ToString>(result: &Result<T, E>, ok: impl Fn(&T) -> Value) -> Value {
        match result {
            Ok(value) => ok(value),
            Err(error) => json!({ "refused": error.to_string() }),
        }
    }
    let model = &id.model;
    let estimate = |e: &Estimate| json!({ "value": e.value, "standard_error": e.standard_error });
    json!({
        "schema": "dgd.fit/1",
        "recordings": data.recordings,
        "formats": fitted.formats,
        "samples": data.samples,
        "kept": data.kept,
        "step_s": data.step_s,
        "rejected": fitted.prepared.tally.iter().filter(|t| t.total > 0)
            .map(|t| json!({ "reason": t.name, "samples": t.total, "first": t.first, "alone": t.alone })).collect::<Vec<_>>(),
        "issues": fitted.issues,
        "friction": {
            "eq_3_14": or_error(&id.undelayed, friction),
            "eq_3_23": friction(&id.sweep.fit),
            "eq_3_26": or_error(&id.cubic, friction),
        },
        "delay": {
            "best_s": id.sweep.delays_s[id.sweep.best],
            "refined_s": id.sweep.refined_delay_s,
            "minimum": format!("{:?}", id.sweep.minimum),
            "delays_s": id.sweep.delays_s,
            "mse_pa2": id.sweep.mse_pa2,
        },
        "pump": {
            "eq_3_31": or_error(&id.pump.plain, curve),
            "eq_3_31_constrained": or_error(&id.pump.constrained, |c| {
                let mut value = curve(&c.fit);
                value["active"] = json!({ "c0": c.active[0], "c1": c.active[1], "c2": c.active[2] });
                value["status"] = json!(format!("{:?}", c.status));
                value["kkt_residual"] = json!(c.kkt_residual);
                value
            }),
            "eq_3_39": id.pump.search.as_ref().map(|search| or_error(search, |s| {
                let mut value = curve(&s.fit);
                value["status"] = json!(format!("{:?}", s.status));
                value["limits"] = json!(s.limits.iter().map(|l| format!("{l:?}")).collect::<Vec<_>>());
                value["trials"] = json!(s.trials.len());
                value["path"] = s.path.iter().map(|p| json!([p.n0, p.n2, p.mse_m2])).collect();
                value
            })),
            "shape": id.pump.shape.as_ref().ok().map(|s| json!({
                "falls_with_flow": s.falls_with_flow,
                "concave": s.concave,
                "rises_with_speed": s.rises_with_speed,
            })),
        },
        "model": {
            "friction": model.friction.terms.iter()
                .map(|t| json!({ "power": t.power, "estimate": estimate(&t.coefficient) })).collect::<Vec<_>>(),
            "delay_s": model.delay_s,
            "c0": estimate(&model.pump.c0),
            "c1": estimate(&model.pump.c1),
            "c2": estimate(&model.pump.c2),
            "n0": model.pump.n0,
            "n2": model.pump.n2,
            "active_constraints": model.pump.active_constraints,
        },
        "warnings": id.warnings,
        "model_file": out.display().to_string(),
        "figures": say::paths(drawn),
        "seconds": seconds,
    })
}
