//! `dgd diagnose`: where model and recording differ, what was left out, and the fit with it.

mod base;
mod tell;
#[cfg(test)]
mod tests;

use crate::args::{Diagnose, Global, Source, Subject};
use crate::commands::carried::{carry_over, effects_here};
use crate::commands::fit::{names, screening};
use crate::commands::system_diagnose;
use crate::failure::Failure;
use crate::load;
use crate::output::{self, Outputs};
use crate::progress::Progress;
use crate::say;
use dgd_diagnose::{
    Archived, DiagnoseError, Diagnosis, Finding, Options, Simulation, Stage, Step, diagnose,
};
use dgd_documents::{Base, ModelDocument, write_diagnosis, write_model_document};
use dgd_export::{ComparedSignal, Comparison, ExportError, write_comparison_csv};
use dgd_identify::prepare;
use dgd_recording::{Channel, Recording, Well};
use dgd_screen::Coarse;
use std::io::Write;
use std::path::{Path, PathBuf};

const DIAGNOSIS: &str = "diagnosis.json";
const SIMULATION: &str = "simulation.csv";
const REPORT: &str = "report.html";
const MODEL: &str = "model.toml";

/// A diagnosis and its document.
pub(crate) struct Diagnosed {
    pub(crate) diagnosis: Diagnosis,
    pub(crate) json: String,
    departures: Vec<(String, String)>,
    recording: String,
}

/// What a diagnosis starts from and looks for.
#[derive(Clone, Copy, Default)]
pub(crate) struct Search<'a> {
    pub(crate) model: Option<&'a Path>,
    pub(crate) suspects: &'a [String],
    pub(crate) without: &'a [Step],
}

pub(crate) fn run(arguments: &Diagnose, global: &Global) -> Result<String, Failure> {
    let source = match arguments.source.subject() {
        Subject::Well(source) => source,
        Subject::System(system, recordings) => {
            return system_diagnose::run(&arguments.out, system, recordings, global);
        }
    };
    let progress = Progress::new(global);
    let search = Search {
        model: arguments.model.as_deref(),
        suspects: &arguments.suspect,
        without: &arguments.without,
    };
    let done = carry_out(&source, search, &arguments.out, &progress)?;
    tracing::info!("seconds by stage: {}", progress.seconds_by_stage());
    drop(progress);
    Ok(if global.json {
        done.json
    } else {
        tell(&done, &arguments.out)
    })
}

/// The answer for people.
pub(crate) fn tell(done: &Diagnosed, out: &Path) -> String {
    say::again(&done.diagnosis.warnings)
        + &tell::tell(&done.diagnosis, &done.departures, &done.recording, out)
}

/// Reads, diagnoses and writes the four files.
pub(crate) fn carry_out(
    source: &Source,
    search: Search<'_>,
    out: &Path,
    progress: &Progress,
) -> Result<Diagnosed, Failure> {
    let well = load::read_well(&source.well)?;
    let model = search.model.map(|path| start(path, &well)).transpose()?;
    let mut loaded = load::read_recordings(&source.recordings, &well, progress)?.within(source)?;
    if out.exists() && !out.is_dir() {
        return Err(Failure::unwritten(out, "it is not a folder"));
    }
    for name in [DIAGNOSIS, SIMULATION, REPORT, MODEL] {
        output::check(&out.join(name))?;
    }
    let first = &source.recordings[0];
    let coarse = dgd_screen::coarse(&loaded.recording, loaded.step_s, &well)
        .map_err(|e| Failure::input(first, e))?;
    let told = Coarse::suspicions(&coarse);
    (loaded.suspicions).extend(told.iter().map(|suspicion| well.pointing(suspicion)));
    loaded.warn_of_suspicions();
    progress.stage("screening", "");
    let (samples, dated_from) = (loaded.samples, loaded.dated_from());
    let begins = std::mem::take(&mut loaded.begins);
    let unused = beyond_two(&mut loaded.recording);
    let prepared = prepare(loaded.recording, loaded.step_s, &screening(source))
        .map_err(|e| Failure::input(first, e))?;
    let mut warnings = loaded.told;
    warnings.extend(loaded.suspicions);
    say::warn(&mut warnings, unused);
    say::warn(&mut warnings, prepared.not_used());
    let mut start = Vec::new();
    if let (Some(path), Some(mut document)) = (search.model, model) {
        say::warn(
            &mut warnings,
            carry_over(&mut document, path, &source.recordings, (&well, &prepared)),
        );
        start = effects_here(document, &prepared.recording.time_s);
    }
    let recordings = names(source);
    progress.stage("identifying", "friction, delay and pump");
    let identified = base::two_state(&prepared, &well, samples, &recordings)?;
    say::warn(&mut warnings, identified.clocks.iter().cloned());
    say::warn(&mut warnings, doubt_of_step(prepared.step_s));
    let options = Options {
        start,
        suspects: search.suspects.to_vec(),
        without: search.without.to_vec(),
        began: dated_from,
        archived: Archived::of(&coarse),
        ..Options::default()
    };
    let mut said = |stage: Stage| {
        let (kind, what) = words(stage);
        progress.stage(kind, &what);
    };
    let mut diagnosis =
        diagnose(&well, &prepared, &options, &mut said).map_err(|e| undiagnosed(first, &e))?;
    say::warn(&mut warnings, std::mem::take(&mut diagnosis.warnings));
    say::warn(&mut warnings, at_seams(&diagnosis.findings, &begins));
    diagnosis.warnings = warnings;
    // The report is written beside what was found, not beside the recording as well.
    drop(prepared);
    diagnosis.settings.extend(identified.departures.clone());
    let began = dated_from.map(|began| ("time zero".to_owned(), began.to_string()));
    diagnosis.settings.extend(began.clone());
    let mut departures = identified.departures;
    departures.extend(began);
    progress.stage("writing", &out.display().to_string());
    let recording = recordings.join(", ");
    let page = dgd_report::diagnosis_page(&diagnosis, &recording, &command(source, search));
    let json = write(&diagnosis, identified.base, &page, out)?;
    Ok(Diagnosed {
        diagnosis,
        departures,
        json,
        recording,
    })
}

/// Leaves out transmitters of a pump side beyond the first two, and says so: what an effect does to the mean is that of two.
fn beyond_two(recording: &mut Recording) -> Vec<String> {
    const MOST: usize = 2;
    let channels = recording.series().into_iter().map(|(channel, _)| channel);
    let beyond = channels.filter(|channel| match channel {
        Channel::PumpInletPressure(n) | Channel::PumpOutletPressure(n) => *n >= MOST,
        _ => false,
    });
    let told = beyond.map(|channel| {
        format!(
            "`{channel}` is not used: a diagnosis takes the first two transmitters of a pump side"
        )
    });
    let told = told.collect();
    recording.pump_inlet_pressure_pa.truncate(MOST);
    recording.pump_outlet_pressure_pa.truncate(MOST);
    told
}

/// What is to be said of findings that set in where another recording begins: it may be another well's.
fn at_seams(findings: &[Finding], begins: &[(PathBuf, f64)]) -> Vec<String> {
    /// Time before a recording, which is not one as a rule, and after it begins in which what sets in does so there, s. Set by hand.
    const BEFORE_S: f64 = 150.0;
    const AFTER_S: f64 = 60.0;
    let told = findings.iter().filter(|f| f.is_likely()).filter_map(|finding| {
        let near = |begin: f64| {
            let mut acts = finding.intervals_s.iter();
            acts.any(|(from, _)| (begin - BEFORE_S..begin + AFTER_S).contains(from))
        };
        let (path, _) = begins.iter().find(|(_, begin)| near(*begin))?;
        Some(format!(
            "`{}` sets in where {} begins: is it a recording of the same well, with the same mud and instruments?",
            finding.effect,
            path.display()
        ))
    });
    told.collect()
}

/// What is to be said of samples so far apart that causes of seconds to minutes cannot be seen in them.
fn doubt_of_step(step_s: f64) -> Option<String> {
    (step_s >= dgd_screen::TOO_SELDOM_S).then(|| {
        format!(
            "a sample every {step_s:.0} s: averages that long blur pump stops, and this can produce false causes; confirm any finding on an export \
             of 5 s or finer"
        )
    })
}

/// Why there is no diagnosis, and what tells more.
fn undiagnosed(path: &Path, error: &DiagnoseError) -> Failure {
    let rejected = matches!(error, DiagnoseError::TooFew { .. });
    Failure::Input {
        path: path.to_owned(),
        reason: error.to_string(),
        help: rejected.then(|| {
            "`dgd fit` reports what the screening rejects, and why; also left out: pressures frozen for a minute while the second transmitter moves, as in \
             exports from a historian with a deadband"
                .into()
        }),
    }
}

/// Writes the four files beside their places, then puts them there together; returns diagnosis.json.
fn write(diagnosis: &Diagnosis, base: Base, page: &str, out: &Path) -> Result<String, Failure> {
    let document = ModelDocument {
        base,
        augmented: Some(diagnosis.after.clone()),
    };
    let json = write_diagnosis(diagnosis);
    let mut outputs = Outputs::new();
    outputs.add_bytes(&out.join(MODEL), write_model_document(&document))?;
    outputs.add(&out.join(SIMULATION), |writer| {
        Ok(simulation_csv(&diagnosis.simulation, writer)?)
    })?;
    outputs.add_bytes(&out.join(REPORT), page)?;
    outputs.add_bytes(&out.join(DIAGNOSIS), &json)?;
    outputs.keep()?;
    Ok(json)
}

/// The model whose effects a diagnosis starts from.
fn start(path: &Path, well: &Well) -> Result<ModelDocument, Failure> {
    let document = load::read_model(path)?;
    let (density_kg_m3, geometry) = document.well();
    if density_kg_m3 != well.mud_density_kg_m3 || *geometry != well.geometry {
        tracing::warn!(
            "{} was identified on a well with different mud or geometry; --well is used",
            path.display()
        );
    }
    if document.augmented.is_none() {
        tracing::warn!(
            "{} contains no effects, so the diagnosis starts as without it",
            path.display()
        );
    }
    Ok(document)
}

fn words(stage: Stage) -> (&'static str, String) {
    match stage {
        Stage::Baseline => ("re-fitting", "the base model".into()),
        Stage::Screening(round) => ("screening", format!("the catalogue, round {round}")),
        Stage::Fitting => ("fitting", "the best hypotheses together".into()),
        Stage::Confirming => ("confirming", "on held-out data".into()),
    }
}

/// The command line that repeats the diagnosis, without the folders of whoever ran it: the report does not depend on them.
fn command(source: &Source, search: Search<'_>) -> String {
    let name = |path: &Path| {
        let name = path.file_name().unwrap_or(path.as_os_str());
        name.to_string_lossy().into_owned()
    };
    let mut words: Vec<String> = vec!["dgd diagnose".into()];
    words.extend(source.recordings.iter().map(|path| name(path)));
    words.push(format!("--well {}", name(&source.well)));
    words.extend(search.model.map(|path| format!("--model {}", name(path))));
    if !search.suspects.is_empty() {
        words.push(format!("--suspect {}", search.suspects.join(",")));
    }
    if !search.without.is_empty() {
        let steps: Vec<&str> = search.without.iter().map(|s| s.name()).collect();
        words.push(format!("--without {}", steps.join(",")));
    }
    if source.thesis_screening {
        words.push("--thesis-screening".into());
    }
    if let Some(window) = &source.window {
        words.push(format!("--window {window}"));
    }
    words.push("--out diagnosis".into());
    words.join(" ")
}

fn simulation_csv(simulation: &Simulation, writer: impl Write) -> Result<(), ExportError> {
    let signals: Vec<ComparedSignal<'_>> = simulation
        .signals
        .iter()
        .map(|signal| ComparedSignal {
            name: signal.name,
            measured: &signal.measured,
            before: &signal.before,
            after: &signal.after,
        })
        .collect();
    let comparison = Comparison {
        time_s: &simulation.t_s,
        held_out: &simulation.held_out,
        valid: &simulation.valid,
        signals: &signals,
    };
    write_comparison_csv(&comparison, writer)
}
