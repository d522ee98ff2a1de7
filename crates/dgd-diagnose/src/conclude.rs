//! From a selection to an answer.

mod again;
mod residue;
mod worse;

use crate::belief::{beside_unnamed, calibrate, doubt, left_over, unmodelled};
use crate::contest::material;
use crate::diagnosis::{
    Check, DiagnoseError, Diagnosis, Finding, MOST_STEP_S, Options, Stage, Verdict, beside,
};
use crate::empirical::is_correction;
use crate::finding::{amiss, finding, heaving};
use crate::free_run::{gains, simulate};
use crate::heave::swell;
use crate::held_out::{held_out, model, trained};
use crate::placebo::placebo;
use crate::record::{MASS_BLOCKS, Record, whole};
use crate::refine::{settled, unshown};
use crate::relations::{Applied, Blocks, Rows};
use crate::scan::allowances_with;
use crate::select::{Named, Sought, select};
use crate::step::Step;
use crate::suction::ALLOWED_HEADS;
use crate::tangent::{Bend, FRICTION_PRIOR_PA, Tangent};
use crate::tested::tested;
use crate::traces::traces;
use crate::work::Work;
use again::again;
use dgd_effects::{About, AppliedEffect, Method, catalogue, find};
use dgd_identify::Prepared;
use dgd_recording::{ChannelSource, Well};
use tracing::debug;
use worse::worse;

/// Blocks that a diagnosis needs: a held-out window and ten minutes to fit on.
const LEAST_BLOCKS: usize = 190;

/// Diagnoses a screened recording.
///
/// - `well`: mud, geometry and channels. One outlet transmitter is enough; the riser's own, where there is one, is held
///   against the inlet's, which tells what the suction loses between the two, and enters no relation itself.
/// - `prepared`: the recording after `dgd_identify::prepare`, on its even clock.
/// - `options`: effects that the model already holds, and how many are fitted together at most.
/// - `progress`: called as each [`Stage`] begins.
///
/// The same arguments give the same [`Diagnosis`], bit by bit, on however many threads of rayon's
/// pool the catalogue is weighed; memory grows in proportion to the samples.
///
/// # Errors
/// [`DiagnoseError::TooShort`] below 190 blocks of 10 s (of a step, where steps are longer), or where fewer than sixty outside
/// the held-out windows show the line or the pump; [`DiagnoseError::Step`] on steps above a minute;
/// [`DiagnoseError::UnknownEffect`] and [`DiagnoseError::NotInCatalogue`] if `options.start` or `options.suspects` hold an
/// effect that the catalogue does not, [`DiagnoseError::NoEffects`] if `options.most_effects` is 0;
/// [`DiagnoseError::Prepared`] and [`DiagnoseError::Well`] on input that cannot be.
///
/// # Source
/// The relations are Eqs. 2.27, 3.13, 3.45 and 3.46 of Slettebø (2015). Recovery of what an independent plant conceals:
/// `tests/it/naming.rs`.
pub fn diagnose(
    well: &Well,
    prepared: &Prepared,
    options: &Options,
    progress: &mut dyn FnMut(Stage),
) -> Result<Diagnosis, DiagnoseError> {
    well.check()?;
    prepared.check()?;
    if prepared.step_s > MOST_STEP_S {
        return Err(DiagnoseError::Step {
            step_s: prepared.step_s,
        });
    }
    if options.most_effects == 0 {
        return Err(DiagnoseError::NoEffects);
    }
    progress(Stage::Baseline);
    let record = Record::new(well, prepared, &options.without);
    let short = || DiagnoseError::TooShort {
        block_s: record.block_s(),
        usable: usable(&record),
        needed: LEAST_BLOCKS,
    };
    let given = from_model(&options.start)?;
    for id in &options.suspects {
        let known = catalogue().iter().any(|e| e.about().id == id);
        if !known {
            return Err(DiagnoseError::NotInCatalogue { id: id.clone() });
        }
    }
    if record.blocks < LEAST_BLOCKS {
        return Err(short());
    }
    let sought = if options.suspects.is_empty() {
        Sought::Any(options.most_effects)
    } else {
        Sought::Given(&options.suspects)
    };
    let here = settled(&record, &given, &[]);
    let known: Vec<Applied> = here.iter().flatten().cloned().collect();
    let kept = given.iter().zip(&here).filter(|(_, here)| here.is_some());
    let kept: Vec<Applied> = kept.map(|(given, _)| given.clone()).collect();
    let mut selection = select(&record, &known, sought, |round| {
        progress(Stage::Screening(round))
    })
    .ok_or_else(short)?;
    if record.takes(Step::Calibration) {
        calibrate(&mut selection.named);
        beside_unnamed(&mut selection.named);
    }
    selection.named.iter_mut().for_each(doubt);
    if let Sought::Given(suspects) = sought {
        selection
            .named
            .iter_mut()
            .for_each(|one| unless_outweighed(one, suspects));
    } else {
        // What is more likely not there is weighed under what was tested, and neither claimed nor modelled.
        selection.named.retain(|n| likely(n) >= 0.5);
    }
    progress(Stage::Fitting);
    let span = record.setting.span_s;
    let acting = selection.named.iter().map(|n| &n.applied).chain(&known);
    let intervals: Vec<(f64, f64)> = acting
        .map(|a| a.effect.about().interval_s(&a.parameters, span))
        .collect();
    let windows = held_out(span, &intervals);
    let seconds = record.block_s();
    let excluded: Vec<bool> = (0..record.blocks)
        .map(|b| {
            let from = record.setting.span_s.0 + b as f64 * seconds;
            let to = from + seconds;
            // Windows ascend: of those that end later, the first begins first.
            let next = windows.partition_point(|w| w.1 <= from);
            windows.get(next).is_some_and(|w| to > w.0)
        })
        .collect();
    // From what was given, not from what the whole recording made of it: the held-out windows would have had their say.
    let start = settled(&record, &kept, &excluded).into_iter().zip(kept);
    let start: Vec<Applied> = start
        .map(|(trained, given)| trained.unwrap_or_else(|| unshown(given)))
        .collect();
    let before_state =
        allowances_with(&record, &start, &excluded, Bend::Free, None).ok_or_else(short)?;
    let after_state = trained(&record, &start, &selection, &excluded).ok_or_else(short)?;
    let before_fit = runnable(&record, &before_state, &excluded).ok_or_else(short)?;
    let after_fit = runnable(&record, &after_state, &excluded).ok_or_else(short)?;
    let before = model(&record, &before_state, &before_fit, &excluded);
    let mut after = model(&record, &after_state, &after_fit, &excluded);
    progress(Stage::Confirming);
    let mut simulation = simulate(well, &record, prepared, &windows, &before, &after)?;
    let inlet_raw = &prepared.inlet_pressure_pa;
    let swell = swell(inlet_raw, prepared.step_s, well.mud_density_kg_m3);
    if let Ok(s) = &swell {
        debug!(
            "swell of {:.1} s, {:.3} m stands {:.1} times above its surroundings",
            s.period_s, s.amplitude_m, s.ratio
        );
    }
    let mut checks: Vec<Check> = refitted(&given, &here, record.setting.span_s)
        .into_iter()
        .collect();
    // An empirical correction can make the free run unstable: on the training stretches that shows, and it is left out.
    let gained = |s: &crate::diagnosis::Simulation| -> f64 {
        gains(s, false)
            .iter()
            .map(|g| (g.1 / g.0.max(1e-12)).ln())
            .filter(|v| v.is_finite())
            .sum()
    };
    if selection.named.iter().any(|n| n.correction.is_some()) && gained(&simulation) > 0.0 {
        // Those of the model that the search starts from stay.
        let named = after_state.len() - selection.named.len();
        let plain: Vec<Applied> = (after_state.iter().enumerate())
            .filter(|(k, a)| *k < named || !is_correction(a.effect))
            .map(|(_, a)| a.clone())
            .collect();
        if let Some(fit) = runnable(&record, &plain, &excluded) {
            let without = model(&record, &plain, &fit, &excluded);
            let other = simulate(well, &record, prepared, &windows, &before, &without)?;
            debug!(
                "free runs on the training stretches come to {:.2} with the correction, {:.2} without it",
                gained(&simulation),
                gained(&other)
            );
            if gained(&other) < gained(&simulation) {
                checks.push(unstable(&mut selection.named, sought));
                after = without;
                simulation = other;
            }
        }
    }
    if selection.named.is_empty() {
        // Nothing found: the two models are one.
        after = before.clone();
        for signal in &mut simulation.signals {
            signal.after = signal.before.clone();
        }
    }
    let not_worse = worse(&simulation);
    let sound = not_worse.passed;
    checks.push(not_worse);
    if let Sought::Any(most) = sought {
        checks.extend(again(&record, &after.effects, &selection.named, most)?);
    }
    let state = selection.state();
    let full = Tangent::at(&record, &state, &[], Bend::Free).ok_or_else(short)?;
    let traces = traces(&record, (&before_fit, &start), (&full, &state));
    let nothing_left = residue::left(&traces);
    for one in &mut selection.named {
        let relation = one.applied.effect.about().relation;
        if residue::is_left_in(&traces, relation) {
            left_over(one);
            if let Sought::Given(suspects) = sought {
                unless_outweighed(one, suspects);
            }
        }
    }
    let mut findings: Vec<Finding> = selection
        .named
        .iter()
        .enumerate()
        .map(|(k, n)| finding(&record, &selection, k, n, &full, &simulation))
        .collect();
    if let Some(s) = swell.ok().filter(|s| s.ratio > s.believed) {
        let held = |about: &About| start.iter().any(|a| a.effect.about().id == about.id);
        for about in (catalogue().iter().map(|effect| effect.about()))
            .filter(|about| about.search.method == Method::Spectrum && !held(about))
        {
            findings.push(heaving(&record, about, s, &simulation));
            // It moves no run; a search that starts from the model need not find it again.
            after.effects.push(AppliedEffect {
                id: about.id.to_owned(),
                parameters: vec![s.period_s, s.amplitude_m],
            });
        }
    }
    for finding in &mut findings {
        name_transmitter(finding, well);
    }
    checks.extend(placebo(&record, &selection));
    findings.sort_by(|a, b| b.probability.total_cmp(&a.probability));
    let tested = tested(&record, &selection, &findings, &start, swell);
    let unknown = |f: &Finding| f.effect == "unknown";
    // What was only suspected may be less likely than not, and then is nothing that was left out; nor is a swell that nobody asked about.
    let asked = |f: &Finding| options.suspects.is_empty() || options.suspects.contains(&f.effect);
    let left_out: Vec<&Finding> = (findings.iter())
        .filter(|f| f.is_likely() && asked(f))
        .collect();
    let verdict = if left_out.is_empty() {
        // Suspects that explain nothing leave open what stands out beside them.
        if options.suspects.is_empty() || beside(&tested, &options.suspects).next().is_none() {
            Verdict::Consistent
        } else {
            Verdict::Unexplained
        }
    } else if left_out.iter().all(|f| unknown(f)) {
        Verdict::Unexplained
    } else if left_out.iter().any(|f| unknown(f)) || !sound || !nothing_left.passed {
        // What leaves more than noise, or makes a run worse where no fit has looked, is not all there is.
        Verdict::PartlyExplained
    } else {
        Verdict::Explained
    };
    checks.push(nothing_left);
    checks.extend(residue::apart(well, &traces));
    checks.extend(residue::early(&selection.allowances));
    let work = record.tally.work();
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
        (
            "logged now and then, with straight lines between".into(),
            match record.seldom.as_slice() {
                [] => "no channel".into(),
                seldom => (seldom.iter())
                    .map(|(channel, every_s)| format!("{channel} every {every_s} s"))
                    .collect::<Vec<_>>()
                    .join(", "),
            },
        ),
        (
            "suction loss".into(),
            match record.suction_heads {
                Some(heads) => format!("{heads:.2} velocity heads of the return line"),
                None => format!(
                    "not known, for no riser transmitter tells it of a flow that changes: none is put back, and each effect must show more by \
                     what {ALLOWED_HEADS} velocity heads would make of it"
                ),
            },
        ),
        ("work".into(), told(work, record.t_s.len())),
    ];
    Ok(Diagnosis {
        verdict,
        findings,
        started_from: known.iter().map(|a| a.effect.about().id).collect(),
        suspected: options.suspects.clone(),
        tested,
        checks,
        before,
        after,
        setting: record.setting.clone(),
        simulation,
        traces,
        held_out_s: windows,
        began: options.began,
        settings,
        work,
    })
}

/// Says by its tag which outlet transmitter a finding is about.
fn name_transmitter(finding: &mut Finding, well: &Well) {
    for parameter in finding.parameters.iter_mut().filter(|p| p.name == "sensor") {
        let source = well
            .channels
            .pump_outlet_pressure
            .get(whole(parameter.estimate - 1.0));
        if let Some(ChannelSource::Column { tag, .. }) = source {
            parameter.meaning = format!("{}: `{tag}`", parameter.meaning);
        }
    }
}

/// What a diagnosis cost, in words.
fn told(work: Work, samples: usize) -> String {
    format!(
        "{} hypotheses weighed, relations run over {:.0} lengths of the recording, base curves fitted {} times",
        work.hypotheses,
        work.samples_run as f64 / samples as f64,
        work.fits
    )
}

/// Curves for a free run, as they would be fitted by hand: where standing mud pulls the friction's intercept far beyond what any
/// is, the column at rest is not the model's, and the stops are left out. Curves bent to it would run wild.
fn runnable(record: &Record, state: &[Applied], excluded: &[bool]) -> Option<Tangent> {
    let fit = Tangent::at(record, state, excluded, Bend::Free)?;
    if fit.curves.friction[0].abs() < 3.0 * FRICTION_PRIOR_PA[0] {
        return Some(fit);
    }
    let stops = |(out, still): (&bool, &bool)| *out || *still;
    let flowing: Vec<bool> = excluded.iter().zip(&fit.rows.still).map(stops).collect();
    Tangent::at(record, state, &flowing, Bend::Free).or(Some(fit))
}

/// Leaves a suspect by itself where something that was not suspected is likelier: it does not stand for that.
fn unless_outweighed(one: &mut Named, suspects: &[String]) {
    let beside = |a: &(String, f64)| !suspects.contains(&a.0);
    let own = one.probability;
    if (one.alternatives.iter()).any(|a| beside(a) && a.1 > own) {
        one.alternatives.retain(|a| !beside(a));
    }
}

/// Lowers what no model runs with, and lets go of what then is more likely not there, unless it was suspected.
fn unstable(named: &mut Vec<Named>, sought: Sought<'_>) -> Check {
    named.iter_mut().for_each(unmodelled);
    let mut detail =
        "it does not on the training stretches: the model that runs goes without it".to_owned();
    if let Sought::Any(_) = sought {
        let unlikely = named.iter().filter(|n| likely(n) < 0.5);
        for (amiss, p) in unlikely.filter_map(|n| Some((amiss(n)?, n.probability))) {
            detail += &format!("; that {amiss} is therefore not claimed (probability {p:.2})");
        }
        named.retain(|n| likely(n) >= 0.5);
    }
    Check {
        name: "the empirical correction keeps the free run stable".into(),
        passed: false,
        detail,
    }
}

/// How likely it is that there is anything: the cause named, or one that cannot be told from it.
fn likely(one: &Named) -> f64 {
    one.probability + one.alternatives.iter().map(|a| a.1).sum::<f64>()
}

/// Blocks in which both the line and the pump can be judged.
fn usable(record: &Record) -> usize {
    let rows = Rows::of(record, &Blocks::under(record, &[]));
    rows.friction
        .iter()
        .zip(&rows.head)
        .filter(|(f, h)| **f && **h)
        .count()
}

/// How the effects of the model to start from came out on this recording, which holds nothing of those that are `None`.
fn refitted(given: &[Applied], here: &[Option<Applied>], span_s: (f64, f64)) -> Option<Check> {
    if given.is_empty() {
        return None;
    }
    // What passed before this recording, or sets in after it, does nothing in it.
    let acts = |one: &Applied| {
        let about = one.effect.about();
        let (from, to) = about.interval_s(&one.parameters, span_s);
        about.onset().is_none() || from < to && from < span_s.1 && to > span_s.0
    };
    let told = given.iter().zip(here).map(|(before, after)| {
        let about = before.effect.about();
        let Some(after) = after else {
            let why = if is_correction(before.effect) {
                "this recording does not show the curve along time"
            } else {
                "this recording speaks against it"
            };
            return format!("{}: {why}, it was left out", about.id);
        };
        if is_correction(before.effect) {
            return format!("{}, a correction", about.id);
        }
        if !acts(after) {
            return format!(
                "{}: by its own time it acts outside this recording, which says nothing of it",
                about.id
            );
        }
        let (name, old, new) = (
            about.parameters[0].name,
            before.parameters[0],
            after.parameters[0],
        );
        format!("{}: {name} {old:.3e}, here {new:.3e}", about.id)
    });
    // What is half as strong again, or half as strong, may be something else by now.
    let alike = |(before, after): (&Applied, &Option<Applied>)| {
        let Some(after) = after else {
            return false;
        };
        let (old, new) = (before.parameters[0], after.parameters[0]);
        if !acts(after) {
            return false;
        }
        is_correction(before.effect) || (new - old).abs() <= 0.5 * old.abs()
    };
    Some(Check {
        name: "the effects of the model to start from are as strong here".into(),
        passed: given.iter().zip(here).all(alike),
        detail: told.collect::<Vec<_>>().join("; "),
    })
}

/// What a search starts from where it starts from a model. A model holds what was allowed for in its own recording; here it is
/// allowed for anew.
fn from_model(effects: &[AppliedEffect]) -> Result<Vec<Applied>, DiagnoseError> {
    let held = effects.iter().map(applied).collect::<Result<Vec<_>, _>>()?;
    let stays = |a: &Applied| a.effect.about().search.allowance.is_empty() || material(a);
    Ok(held.into_iter().filter(stays).collect())
}

/// An effect of the model to start from, looked up.
fn applied(one: &AppliedEffect) -> Result<Applied, DiagnoseError> {
    let effect = find(&one.id)
        .filter(|e| e.takes(one.parameters.len()))
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

#[cfg(test)]
mod tests;
