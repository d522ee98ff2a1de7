//! From a selection to an answer.

use crate::diagnosis::{
    Check, DiagnoseError, Diagnosis, Finding, Options, Stage, Verdict,
};
use crate::finding::{finding, heaving};
use crate::free_run::{gains, simulate};
use crate::heave::swell;
use crate::held_out::{held_out, model, trained};
use crate::record::{MASS_BLOCKS, Record};
use crate::relations::Applied;
use crate::scan::allowances_with;
use crate::select::select;
use crate::tangent::{Bend, Tangent};
use crate::tested::{placebo, tested};
use crate::traces::traces;
use dgd_effects::{AppliedEffect, find};
use dgd_identify::Prepared;
use dgd_recording::Well;

/// Peak over floor from which swell is believed.
const SWELL_RATIO: f64 = 6.0;

/// Diagnoses a screened recording.
///
/// # Errors
/// [`DiagnoseError`] if too little can be used, or the model to start from holds an effect that is not known.
pub fn diagnose(
    well: &Well,
    prepared: &Prepared,
    options: &Options,
    progress: &mut dyn FnMut(Stage),
) -> Result<Diagnosis, DiagnoseError> {
    progress(Stage::Baseline);
    let record = Record::new(well, prepared);
    let short = || DiagnoseError::TooShort {
        usable: record.blocks,
        needed: 60,
    };
    let start = options
        .start
        .iter()
        .map(applied)
        .collect::<Result<Vec<_>, _>>()?;
    if record.blocks < 120 {
        return Err(short());
    }
    let selection = select(&record, &start, options.most_effects, |round| {
        progress(Stage::Screening(round))
    })
    .ok_or_else(short)?;
    progress(Stage::Fitting);
    let windows = held_out(record.setting.span_s);
    let seconds = record.dt_s * record.per_block as f64;
    let excluded: Vec<bool> = (0..record.blocks)
        .map(|b| {
            let (from, to) = (b as f64 * seconds, (b + 1) as f64 * seconds);
            windows.iter().any(|w| from < w.1 && to > w.0)
        })
        .collect();
    let before_state = allowances_with(&record, &start, Bend::Free)
        .ok_or_else(short)?
        .0;
    let after_state = trained(&record, &selection, &excluded);
    let before_fit =
        Tangent::at(&record, &before_state, &excluded, Bend::Free).ok_or_else(short)?;
    let after_fit = Tangent::at(&record, &after_state, &excluded, Bend::Free).ok_or_else(short)?;
    let before = model(&record, &before_state, &before_fit);
    let mut after = model(&record, &after_state, &after_fit);
    progress(Stage::Confirming);
    let mut simulation = simulate(well, &record, prepared, &windows, &before, &after)?;
    let inlet_raw = &prepared.inlet_pressure_pa;
    let swell = swell(inlet_raw, prepared.step_s, well.mud_density_kg_m3);
    let mut checks = Vec::new();
    // A model that runs away is worse than none: the finding stays, the run falls back and says so.
    let worse = gains(&simulation)
        .iter()
        .filter(|g| g.1 > 1.5 * g.0)
        .count();
    checks.push(Check {
        name: "no output is made worse on held-out windows".into(),
        passed: worse == 0,
        detail: format!("{worse} of 4 signals have an RMSE above 1.5 times that before"),
    });
    if selection.named.is_empty() {
        // Nothing found: the two models are one.
        after = before.clone();
        for signal in &mut simulation.signals {
            signal.after = signal.before.clone();
        }
    }
    let full = Tangent::at(&record, &selection.state(), &[], Bend::Free).ok_or_else(short)?;
    let mut findings: Vec<Finding> = selection
        .named
        .iter()
        .enumerate()
        .map(|(k, n)| finding(&record, &selection, k, n, &full, &simulation))
        .collect();
    if let Some(s) = swell
        .filter(|s| s.ratio > SWELL_RATIO && !start.iter().any(|a| a.effect.about().id == "heave"))
    {
        findings.extend(heaving(&record, s, &simulation));
    }
    checks.extend(placebo(&record, &selection));
    findings.sort_by(|a, b| b.probability.total_cmp(&a.probability));
    let tested = tested(&record, &selection, &findings, swell);
    let strong: Vec<&Finding> = findings.iter().filter(|f| f.probability >= 0.5).collect();
    let verdict = if strong.is_empty() {
        Verdict::Consistent
    } else if strong.iter().all(|f| f.effect == "unknown") {
        Verdict::Unexplained
    } else if strong.iter().any(|f| f.effect == "unknown") {
        Verdict::PartlyExplained
    } else {
        Verdict::Explained
    };
    // `consistent` goes with no findings; what was weighed and not believed stands under what was tested.
    let findings = if verdict == Verdict::Consistent {
        Vec::new()
    } else {
        findings
    };
    let traces = traces(&record, &before_fit, &full);
    let settings = vec![
        ("working clock".into(), format!("{} s", record.dt_s)),
        ("block of relation residuals".into(), format!("{seconds} s")),
        (
            "row of the mass balance".into(),
            format!("{} s", seconds * MASS_BLOCKS as f64),
        ),
        (
            "held out".into(),
            format!(
                "{} windows of {:.0} s",
                windows.len(),
                windows.first().map_or(0.0, |w| w.1 - w.0)
            ),
        ),
        (
            "timing allowed for".into(),
            selection
                .allowances
                .iter()
                .filter(|a| a.allowance)
                .map(|a| format!("{} {} s", a.effect.about().id, a.parameters[0]))
                .collect::<Vec<_>>()
                .join(", "),
        ),
    ];
    Ok(Diagnosis {
        verdict,
        findings,
        tested,
        checks,
        before,
        after,
        setting: record.setting.clone(),
        simulation,
        traces,
        held_out_s: windows,
        settings,
    })
}

/// An effect of the model to start from, looked up.
fn applied(one: &AppliedEffect) -> Result<Applied, DiagnoseError> {
    let effect = find(&one.id)
        .filter(|e| e.about().parameters.len() == one.parameters.len())
        .ok_or_else(|| dgd_effects::UnknownEffect {
            id: one.id.clone(),
            given: one.parameters.len(),
        })?;
    Ok(Applied {
        effect,
        parameters: one.parameters.clone(),
        allowance: false,
    })
}
