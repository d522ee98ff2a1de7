//! From a selection to an answer.

mod again;
mod against;
mod archived;
mod clock;
mod coverage;
mod described;
mod models;
mod outdone;
mod residue;
mod settings;
mod start;
mod unlogged;
mod untrained;
mod verdict;
mod worse;

use crate::ablation::Step;
use crate::belief::{beside_unnamed, calibrate, doubt};
use crate::dead::{Dead, without_dead};
use crate::diagnosis::{DiagnoseError, Diagnosis, Finding, MOST_STEP_S, Options, Stage};
use crate::estimates::Estimator;
use crate::finding::{finding, heaving};
use crate::free_run::{Part, errors, headline_gain};
use crate::heave::{Swell, Unseen, swell};
use crate::numbers::whole;
use crate::placebo::placebo;
use crate::record::Record;
use crate::regime::laminar;
use crate::relations::{Applied, Blocks, Rows};
use crate::remains;
use crate::select::{Sought, select};
use crate::selection::{Named, Selection};
use crate::tangent::{Bend, LEAST_ROWS, Tangent};
use crate::tested::tested;
use crate::traces::traces;
use again::again;
use against::{Against, Told, unless_outweighed};
use coverage::Unjudged;
use dgd_effects::{About, AppliedEffect, Method, catalogue};
use dgd_identify::Prepared;
use dgd_recording::{ChannelSource, Well};
use models::Models;
use outdone::doubt_outdone;
use settings::settings;
use start::{Start, from_model};
use tracing::debug;
use verdict::verdict;
use worse::worse;

/// Blocks that a diagnosis needs: a held-out window and ten minutes to fit on.
const LEAST_BLOCKS: usize = 190;

/// Diagnoses a screened recording.
///
/// - `well`: mud, geometry and channels. One outlet transmitter is enough; the riser's own, where there is one, is held
///   against the inlet's, which tells what the suction loses between the two, and enters no relation itself.
/// - `prepared`: the recording after `dgd_identify::prepare`, on its even clock, of at most two transmitters a pump side: effects know of no third.
/// - `options`: effects that the model already holds, and how many are fitted together at most.
/// - `progress`: called as each [`Stage`] begins.
///
/// The same arguments give the same [`Diagnosis`], bit by bit, on however many threads of rayon's
/// pool the catalogue is weighed; memory grows in proportion to the samples.
///
/// # Errors
/// [`DiagnoseError::TooShort`] below 190 blocks of 10 s (of a step, where steps are longer), [`DiagnoseError::TooFew`] where fewer than
/// sixty outside the held-out windows show the line or the pump; [`DiagnoseError::Step`] on steps above a minute;
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
    let given = accepted(well, prepared, options)?;
    progress(Stage::Baseline);
    let (dead, prepared) = without_dead(well, prepared);
    let prepared = prepared.as_ref();
    let mut record = recorded(well, prepared, options)?;
    let sought = if options.suspects.is_empty() {
        Sought::Any(options.most_effects)
    } else {
        Sought::Given(&options.suspects)
    };
    let start = Start::here(&record, given);
    let known = start.known();
    let mut selection = found(&record, &known, sought, |round| {
        progress(Stage::Screening(round))
    })
    .ok_or_else(|| too_few(&record))?;
    if selection.stays {
        // A second search need not find that out once more.
        record.without.push(Step::Ends);
    }
    let anew = |other: &Record| {
        found(other, &known, sought, |round| {
            progress(Stage::Screening(round))
        })
    };
    if let Some(other) = laminar(&record, &selection, anew) {
        (record, selection) = other;
    }
    // One that starts from the model has all steps.
    record.without.clone_from(&options.without);
    if let Sought::Given(suspects) = sought {
        let asked = (suspects, options.most_effects);
        doubt_outdone(&record, &known, &mut selection.named, asked, |round| {
            progress(Stage::Screening(round))
        });
    }

    progress(Stage::Fitting);
    let models = Models::trained(&record, &selection, &known, start.kept())
        .ok_or_else(|| too_few(&record))?;

    progress(Stage::Confirming);
    let (mut models, simulation, stability) =
        models.run(well, &record, prepared, &mut selection.named, sought)?;
    // Not beside a correction that no model runs with and that is therefore not claimed.
    let doubted = record.takes(Step::Calibration) && beside_unnamed(&mut selection.named);
    let errors = errors(&simulation, Part::HeldOut);
    let not_worse = worse(&simulation, &errors);
    let found_again = match sought {
        Sought::Any(most) => again(&record, &models.after.effects, &selection.named, most)?,
        Sought::Given(_) => None,
    };
    let state = selection.state();
    let full = Tangent::at(&record, &state, &[], Bend::Stiff).ok_or_else(|| too_few(&record))?;
    let traces = traces(
        &record,
        (&models.before_fit, &models.start),
        (&full, &state),
    );
    let told = Told {
        full: &full,
        traces: &traces,
        errors: &errors,
        trained: &models.after.effects,
        doubted,
    };
    let (channels, archived) = (&well.channels, options.archived);
    let against = Against::weigh(&record, channels, archived, &told, &mut selection, sought);

    let swell = match archived.pressures {
        true => Err(Unseen::Archived),
        false => swell(
            &prepared.inlet_pressure_pa,
            prepared.step_s,
            well.mud_density_kg_m3,
        ),
    };
    let swelling: Vec<(&About, Swell)> = swelling(swell, &models.start).collect();
    let held_out = headline_gain(&simulation);
    let estimator = Estimator::of(&record, &state, &full);
    let named = selection.named.iter().map(|named| {
        let mut told = finding(&record, named, &estimator, held_out.clone());
        against.tell(named, &mut told);
        told
    });
    let heaving = (swelling.iter()).map(|(about, s)| heaving(&record, about, *s, held_out.clone()));
    let mut findings: Vec<Finding> = named.chain(heaving).collect();
    for finding in &mut findings {
        name_transmitter(finding, well);
    }
    findings.sort_by(|a, b| b.probability.total_cmp(&a.probability));
    // A swell moves no run; it is in the model, so that a search that starts from it need not find it again.
    let swells = (swelling.iter()).map(|(about, s)| AppliedEffect {
        id: about.id.to_owned(),
        parameters: vec![s.period_s, s.amplitude_m],
    });
    models.after.effects.extend(swells);

    let unjudged = Unjudged::of(&record, &full.rows);
    let tested = tested(&record, &selection, &findings, &models.start, swell);
    let sound = not_worse.passed && against.leaves_nothing();
    let checks = (start.check(record.setting.span_s).into_iter())
        .chain(stability)
        .chain([not_worse])
        .chain(found_again)
        .chain(placebo(&record, &selection))
        .chain(against.checks())
        .chain(residue::apart(well, &traces))
        .chain(residue::early(&selection.allowances))
        .chain(unjudged.iter().map(Unjudged::check))
        .chain(Dead::check(&dead))
        .collect();
    let work = record.tally.work();
    Ok(Diagnosis {
        verdict: verdict(&findings, &tested, &options.suspects, sound),
        findings,
        started_from: known.iter().map(|a| a.id()).collect(),
        suspected: options.suspects.clone(),
        tested,
        warnings: (dead.iter().map(Dead::warning))
            .chain(unjudged.iter().map(Unjudged::warning))
            .chain(against.warnings())
            .chain(described::warning(&record.setting, &selection.named))
            .collect(),
        checks,
        before: models.before,
        after: models.after,
        setting: record.setting.clone(),
        simulation,
        traces,
        settings: settings(&record, &models.windows, &selection, work),
        held_out_s: models.windows,
        began: options.began,
        work,
    })
}

/// Refuses what cannot be diagnosed; gives the effects of the model to start from.
fn accepted(
    well: &Well,
    prepared: &Prepared,
    options: &Options,
) -> Result<Vec<Applied>, DiagnoseError> {
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
    let given = from_model(&options.start)?;
    for id in &options.suspects {
        let known = catalogue().iter().any(|e| e.about().id == id);
        if !known {
            return Err(DiagnoseError::NotInCatalogue { id: id.clone() });
        }
    }
    Ok(given)
}

/// The recording on its working clock, if it is long enough.
fn recorded(well: &Well, prepared: &Prepared, options: &Options) -> Result<Record, DiagnoseError> {
    let record = Record::new(well, prepared, &options.without);
    if record.blocks < LEAST_BLOCKS {
        return Err(DiagnoseError::TooShort {
            block_s: record.block_s(),
            blocks: record.blocks,
            needed: LEAST_BLOCKS,
        });
    }
    Ok(record)
}

fn too_few(record: &Record) -> DiagnoseError {
    DiagnoseError::TooFew {
        block_s: record.block_s(),
        usable: usable(record),
        blocks: record.blocks,
        needed: LEAST_ROWS,
    }
}

/// What a search finds, as it is believed, and what remains where it was for anything; `None` where too few rows can be judged.
fn found(
    record: &Record,
    start: &[Applied],
    sought: Sought<'_>,
    round_begins: impl FnMut(usize),
) -> Option<Selection> {
    let mut selection = select(record, start, sought, round_begins)?;
    believe(record, &mut selection.named, sought);
    if let Sought::Any(_) = sought {
        remains::tell(record, &mut selection);
    }
    Some(selection)
}

/// Calibrates what a search found, and lets go of what is more likely not there.
fn believe(record: &Record, named: &mut Vec<Named>, sought: Sought<'_>) {
    if record.takes(Step::Calibration) {
        calibrate(named);
    }
    named.iter_mut().for_each(doubt);
    if let Sought::Given(suspects) = sought {
        named
            .iter_mut()
            .for_each(|one| unless_outweighed(one, suspects));
    } else {
        // It is still listed among what was tested, but neither claimed nor modelled.
        named.retain(|n| n.likely() >= 0.5);
    }
}

/// The effects that a swell is, if it stands out, but for those that the model to start from holds.
fn swelling(
    swell: Result<Swell, Unseen>,
    start: &[Applied],
) -> impl Iterator<Item = (&'static About, Swell)> {
    if let Ok(s) = &swell {
        debug!(
            "swell of {:.1} s, {:.3} m is {:.1} times its surroundings",
            s.period_s, s.amplitude_m, s.ratio
        );
    }
    let swell = swell.ok().filter(|s| s.ratio > s.believed);
    let held = |about: &About| start.iter().any(|a| a.id() == about.id);
    let effects = catalogue().iter().map(|effect| effect.about());
    let spectral =
        effects.filter(move |about| about.search.method == Method::Spectrum && !held(about));
    spectral.filter_map(move |about| Some((about, swell?)))
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

/// Blocks in which both the line and the pump can be judged.
fn usable(record: &Record) -> usize {
    let rows = Rows::of(record, &Blocks::under(record, &[]));
    rows.friction
        .iter()
        .zip(&rows.head)
        .filter(|(f, h)| **f && **h)
        .count()
}

#[cfg(test)]
mod tests;
