//! `cargo xtask prove`: concealed effects, diagnosed blind, scored.
//!
//! The plant makes recordings and seals what it concealed in them; `dgd diagnose` sees a folder with one
//! recording and its well description; only after the last run are the truths opened. Both are run
//! as programs: nothing here shares code with what is judged.

pub(crate) mod ablation;
mod ablation_page;
pub(crate) mod answer;
pub(crate) mod batch;
mod charts;
mod detection;
mod detection_page;
pub(crate) mod exam;
mod failures;
mod floors;
mod informed;
mod measures;
pub(crate) mod page;
mod proof_page;
mod record;
pub(crate) mod score;
mod scores;
pub(crate) mod seal;
mod simulation;
pub(crate) mod stats;
mod strength;
mod summary;
pub(crate) mod svg;
pub(crate) mod targets;
pub(crate) mod truth;

use crate::tools;
use anyhow::{Context, Result, bail};
use clap::{Args, ValueEnum};
use exam::{Exam, Paper, Scope};
use floors::Floor;
use seal::Sealed;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use summary::{Row, Summary};
use truth::{Sort, Truth};

/// Seeds up to this one are for calibrating, and prove nothing.
pub(crate) const CALIBRATION_SEEDS: u64 = 999;
/// So many hold each single effect in each severity once.
const WHOLE: usize = 200;
/// A level of the short form diagnoses this many: eight singles, two clean, a pair and a foreign effect.
const SHORT: usize = 12;
/// Of so many: level one takes the first, level two the last, so that they meet other effects.
const SHORT_OF: usize = 32;
/// Seed unless another is given; the short form's floors are those of its recordings.
const SEED: u64 = 2015;
/// What recordings conceal unless another kind is asked for.
const MIX: &str = "mix";
/// Folders of an earlier proof carry this file.
const MARKER: &str = ".dgd-proof";

/// What they hold besides the page.
const FOLDERS: [&str; 5] = ["cases", "sealed", "answers", "ablation", "informed"];

/// What to prove, and how.
#[derive(Args)]
pub(crate) struct Settings {
    /// Base physics: 1 clean, 2 what a model meets only approximately
    #[arg(long, value_enum, default_value = "both")]
    level: Levels,
    /// Recordings a level; 200 hold each single effect in each severity once
    #[arg(long, default_value_t = WHOLE, default_value_if("benches", "true", "40"), value_parser = clap::builder::RangedU64ValueParser::<usize>::new().range(1..=10_000))]
    count: usize,
    /// Seed of the recordings; 1 to 999 are for calibrating and refused
    #[arg(long, default_value_t = SEED)]
    seed: u64,
    /// What each recording conceals, as `dgd-plant conceal` knows it
    #[arg(long, conflicts_with_all = ["short", "benches", "real"], default_value = MIX,
        value_parser = ["mix", "single", "pair", "several", "passing", "recurring", "clean", "foreign", "beside"])]
    kind: String,
    /// How long each recording lasts, h; by default 4 to 8, as drawn
    #[arg(long, conflicts_with_all = ["short", "benches", "real"], value_parser = hours)]
    hours: Option<f64>,
    /// Twelve of 32 recordings a level, others at each, for continuous integration
    #[arg(long, conflicts_with = "count")]
    short: bool,
    /// Folder for recordings, answers, proof.html, proof.json, scores.md and failures.md
    #[arg(
        long,
        default_value = "target/proof",
        default_value_if("benches", "true", "target/benches")
    )]
    out: PathBuf,
    /// Diagnoses at a time; with more than one the wall times tell less
    #[arg(long, default_value_t = 1, value_parser = clap::builder::RangedU64ValueParser::<usize>::new().range(1..=256))]
    jobs: usize,
    /// Only these cases, such as c012,c044
    #[arg(long, value_delimiter = ',')]
    only: Vec<String>,
    /// Keep the simulation.csv of every case, some megabytes each
    #[arg(long)]
    keep: bool,
    /// Diagnose all again without each step of the chain in turn, to see what it contributes
    #[arg(long)]
    ablate: bool,
    /// Only these steps, such as edges,form; `dgd catalogue` lists them
    #[arg(long, value_name = "STEPS", value_delimiter = ',', requires = "ablate")]
    steps: Vec<String>,
    /// Leave out the fits that know the truth, which are as many runs again; the short form does
    #[arg(long)]
    blind: bool,
    /// Fail on scores: silent=N, alarms=N, sure=N at most, named=N at least; the short form, whole and of the default seed, has its own
    #[arg(long = "floor", value_name = "NAME=COUNT", value_delimiter = ',')]
    floors: Vec<Floor>,
}

/// Reads the length of recordings, h.
fn hours(text: &str) -> Result<f64, String> {
    let hours: f64 = text.parse().unwrap_or(f64::NAN);
    if hours > 0.0 && hours <= 2400.0 {
        return Ok(hours);
    }
    Err("expected a number up to 2400".into())
}

/// Which levels of base physics.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum Levels {
    #[value(name = "1")]
    One,
    #[value(name = "2")]
    Two,
    Both,
}

impl Levels {
    pub(crate) fn list(self) -> &'static [u8] {
        match self {
            Levels::One => &[1],
            Levels::Two => &[2],
            Levels::Both => &[1, 2],
        }
    }
}

impl Settings {
    /// What of it goes for `--benches`.
    pub(crate) fn for_benches(self) -> crate::benches::Settings {
        crate::benches::Settings {
            count: self.count,
            seed: self.seed,
            out: self.out,
            jobs: self.jobs,
            only: self.only,
            keep: self.keep,
        }
    }

    /// Folder for what is written.
    pub(crate) fn out(&self) -> &Path {
        &self.out
    }

    /// The options for the kind and the length of the recordings, each with a blank before it; nothing where they are as usual.
    fn of_kind(&self) -> String {
        let kind = (self.kind != MIX).then(|| format!(" --kind {}", self.kind));
        let hours = self.hours.map(|h| format!(" --hours {h}"));
        kind.into_iter().chain(hours).collect()
    }

    /// Whether the case with that number is diagnosed.
    fn wants(&self, level: u8, index: usize, id: &String) -> bool {
        let turn = match (self.short, level) {
            (false, _) => true,
            (true, 1) => index < SHORT,
            (true, _) => (SHORT_OF - SHORT..SHORT_OF).contains(&index),
        };
        turn && (self.only.is_empty() || self.only.contains(id))
    }

    #[cfg(test)]
    /// The short form, as continuous integration runs it.
    pub(crate) fn short(out: PathBuf) -> Settings {
        Settings {
            level: Levels::Both,
            count: SHORT_OF,
            seed: SEED,
            kind: MIX.into(),
            hours: None,
            short: true,
            out,
            jobs: 1,
            only: Vec::new(),
            keep: false,
            ablate: false,
            steps: Vec::new(),
            blind: false,
            floors: Vec::new(),
        }
    }

    /// The floors of its scores. Those of the short form were chosen on its own recordings, and hold for all of them alone.
    fn floors(&self) -> Vec<Floor> {
        let whole =
            self.short && self.seed == SEED && self.level == Levels::Both && self.only.is_empty();
        let built_in: &[Floor] = if whole { &floors::SHORT } else { &[] };
        floors::in_force(&self.floors, built_in)
    }
}

/// The program that was examined, and where.
pub(crate) struct Program {
    pub(crate) version: String,
    pub(crate) sha256: String,
    pub(crate) commit: Option<String>,
    pub(crate) cores: usize,
}

impl Program {
    pub(crate) fn of(dgd: &Path) -> Result<Self> {
        let mut described = Command::new("git");
        described
            .args(["describe", "--always", "--dirty"])
            .current_dir(tools::root());
        Ok(Self {
            version: first_line(Command::new(dgd).arg("--version")).unwrap_or_default(),
            sha256: seal::sha256(&fs::read(dgd).context("cannot read the program")?),
            commit: first_line(&mut described),
            cores: std::thread::available_parallelism().map_or(1, usize::from),
        })
    }
}

/// What the page says about how it came to be.
struct Origin {
    program: Program,
    /// Level and SHA-256 of its truths.
    seals: Vec<(u8, String)>,
}

/// All that is told of a proof.
struct Proof<'a> {
    settings: &'a Settings,
    origin: &'a Origin,
    summaries: &'a [Summary],
    rows: &'a [Row],
    /// What each step contributes; empty without `--ablate`.
    steps: &'a [ablation::OfStep],
}

/// The programs, put where a build meanwhile does not change them.
pub(crate) struct Shelf {
    pub(crate) plant: PathBuf,
    pub(crate) dgd: PathBuf,
    _folder: tempfile::TempDir,
}

impl Shelf {
    /// Builds and copies them.
    pub(crate) fn stock() -> Result<Shelf> {
        let folder = tempfile::tempdir().context("cannot make a temporary folder")?;
        let put = |package, name| -> Result<PathBuf> {
            let (from, to) = (tools::build(package, name)?, folder.path().join(name));
            fs::copy(&from, &to).with_context(|| format!("cannot copy {}", from.display()))?;
            Ok(to)
        };
        Ok(Shelf {
            plant: put("dgd-plant", "dgd-plant")?,
            dgd: put("dgd-cli", "dgd")?,
            _folder: folder,
        })
    }
}

/// Runs the proof; fails on broken rules, and on scores below their floors.
pub(crate) fn run(mut settings: Settings) -> Result<()> {
    if settings.seed <= CALIBRATION_SEEDS {
        bail!(
            "seed {} is one of those for calibrating (0 to {CALIBRATION_SEEDS}): prove with another",
            settings.seed
        );
    }
    if settings.short {
        settings.count = SHORT_OF;
    }
    let shelf = Shelf::stock()?;
    fs::create_dir_all(&settings.out)
        .with_context(|| format!("cannot make {}", settings.out.display()))?;
    settings.out = fs::canonicalize(&settings.out).context("cannot resolve the folder")?;
    clear(&settings.out, MARKER, &FOLDERS)?;

    let steps = match settings.ablate {
        true => ablation::chosen(ablation::steps(&shelf.dgd)?, &settings.steps)?,
        false => Vec::new(),
    };
    let levels = settings.level.list();
    let make = |level: &u8| {
        let order = seal::Order {
            level: *level,
            seed: settings.seed,
            count: settings.count,
            kind: &settings.kind,
            hours: settings.hours,
        };
        seal::conceal(&shelf.plant, &settings.out, &order)
    };
    let sealed = levels.iter().map(make).collect::<Result<Vec<_>>>()?;
    for s in &sealed {
        println!(
            "sealed: {} recordings of level {}, SHA-256 of their truths {}",
            s.ids.len(),
            s.level,
            s.sha256
        );
    }
    let origin = Origin {
        program: Program::of(&shelf.dgd)?,
        seals: sealed.iter().map(|s| (s.level, s.sha256.clone())).collect(),
    };

    let todo = asked(&settings, &sealed)?;
    let exams = examine(&settings, &shelf.dgd, &todo);
    let without = ablation::ask(&shelf.dgd, settings.jobs, &settings.out, &todo, steps);

    for s in &sealed {
        s.check().context("the seal is broken")?;
        println!("seal of level {} holds", s.level);
    }
    let mut rows = open(&todo, exams)?;
    if !settings.blind && !settings.short {
        informed::ask(&shelf.dgd, settings.jobs, &settings.out, &sealed, &mut rows)?;
    }
    let without = without
        .into_iter()
        .map(|w| Ok((w.step, open(&todo, w.exams)?)))
        .collect::<Result<Vec<_>>>()?;
    let steps = ablation::compare(&rows, &without, levels);
    let summaries: Vec<Summary> = levels.iter().map(|l| Summary::of(*l, &rows)).collect();
    let save = |name: &str, text: String| tools::replace(&settings.out.join(name), text);
    save("failures.md", failures::write(&settings, &rows))?;
    let proof = Proof {
        settings: &settings,
        origin: &origin,
        summaries: &summaries,
        rows: &rows,
        steps: &steps,
    };
    save("scores.md", scores::write(&proof))?;
    save("proof.json", format!("{:#}\n", record::json_of(&proof)))?;
    save("proof.html", proof_page::write(&proof))?;
    record::tell(&proof);
    println!("\n{}", settings.out.join("proof.html").display());
    floors::verdict(&settings.floors(), &rows)
}

/// Removes the folders that an earlier run left; one that holds anything else but its marker is left alone.
pub(crate) fn clear(out: &Path, marker: &str, folders: &[&str]) -> Result<()> {
    let mut entries =
        fs::read_dir(out).with_context(|| format!("cannot read {}", out.display()))?;
    let marker = out.join(marker);
    if entries.next().is_some() && !marker.exists() {
        bail!(
            "{} holds files that are of no earlier run: give an empty folder",
            out.display()
        );
    }
    for folder in folders {
        let path = out.join(folder);
        if path.exists() {
            fs::remove_dir_all(&path)
                .with_context(|| format!("cannot clear {}", path.display()))?;
        }
    }
    fs::write(&marker, "").with_context(|| format!("cannot write {}", marker.display()))
}

/// The first line a command prints, if it can be run.
fn first_line(command: &mut Command) -> Option<String> {
    let output = command.output().ok().filter(|o| o.status.success())?;
    let text = String::from_utf8_lossy(&output.stdout);
    text.lines().next().map(|l| l.trim().to_owned())
}

/// The cases to diagnose.
fn asked<'a>(settings: &Settings, sealed: &'a [Sealed]) -> Result<Vec<(&'a Sealed, &'a String)>> {
    let mut todo: Vec<(&Sealed, &String)> = Vec::new();
    for s in sealed {
        let ids = s.ids.iter().enumerate();
        let ids = ids.filter(|(i, id)| settings.wants(s.level, *i, id));
        todo.extend(ids.map(|(_, id)| (s, id)));
    }
    if todo.is_empty() {
        bail!(
            "none of {:?} is a case, expected c000 and so on",
            settings.only
        );
    }
    Ok(todo)
}

/// Diagnoses them blind.
fn examine(settings: &Settings, dgd: &Path, todo: &[(&Sealed, &String)]) -> Vec<Exam> {
    let paper = |(sealed, id): &(&Sealed, &String)| Paper {
        case: sealed.cases.join(id),
        out: settings
            .out
            .join("answers")
            .join(format!("level-{}", sealed.level))
            .join(id),
        options: Vec::new(),
        scope: Scope::Whole {
            keep: settings.keep,
        },
    };
    let papers: Vec<Paper> = todo.iter().map(paper).collect();
    batch::all(dgd, settings.jobs, &papers, "")
}

/// Opens the truths, and holds the answers against them.
fn open(todo: &[(&Sealed, &String)], exams: Vec<Exam>) -> Result<Vec<Row>> {
    let mut rows = Vec::with_capacity(exams.len());
    for ((sealed, id), exam) in todo.iter().zip(exams) {
        let bytes = sealed.truth(id)?;
        let truth = Truth::read(&bytes).with_context(|| format!("{id}.truth.json"))?;
        let well = fs::read_to_string(sealed.cases.join(id).join("well.toml"));
        let well = strength::Well::read(&well.unwrap_or_default());
        let single = truth
            .effects
            .first()
            .filter(|_| truth.sort() == Sort::Single);
        let size = single.zip(well);
        let size = size.and_then(|(effect, well)| strength::strength(effect, well, truth.hours));
        let mut row = Row::new(
            (sealed.level, (*id).clone()),
            truth,
            exam.answer,
            exam.simulation,
        );
        row.strength = size;
        row.broken = exam.broken;
        row.wall_s = exam.wall_s;
        row.peak_mib = exam.peak_mib;
        rows.push(row);
    }
    Ok(rows)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may")]
    use super::*;

    #[test]
    fn a_seed_used_for_calibrating_is_refused() {
        for seed in [0, 5, CALIBRATION_SEEDS] {
            let folder = tempfile::tempdir().unwrap();
            let settings = Settings {
                seed,
                ..Settings::short(folder.path().to_owned())
            };
            let error = run(settings).unwrap_err().to_string();
            assert!(error.contains("for calibrating"), "{error}");
        }
    }

    #[test]
    fn the_short_form_meets_other_cases_at_each_level() {
        let short = Settings::short("proof".into());
        let of = |settings: &Settings, level| -> Vec<usize> {
            let id = String::from("c000");
            (0..SHORT_OF)
                .filter(|i| settings.wants(level, *i, &id))
                .collect()
        };
        let (one, two) = (of(&short, 1), of(&short, 2));
        assert_eq!((one.len(), two.len()), (SHORT, SHORT));
        assert!(one.iter().all(|i| !two.contains(i)));
        let whole = Settings {
            short: false,
            only: vec!["c001".into()],
            ..short
        };
        assert_eq!(of(&whole, 1), [0; 0]);
    }

    #[test]
    fn the_short_forms_floors_hold_for_its_own_recordings_and_all_of_them() {
        let short = || Settings::short("proof".into());
        assert_eq!(short().floors(), floors::SHORT);
        for other in [
            Settings {
                seed: SEED + 1,
                ..short()
            },
            Settings {
                level: Levels::Two,
                ..short()
            },
            Settings {
                only: vec!["c001".into()],
                ..short()
            },
            Settings {
                short: false,
                ..short()
            },
        ] {
            assert_eq!(other.floors(), []);
        }
        let given = Settings {
            floors: vec!["named=1".parse().unwrap()],
            ..short()
        };
        assert_ne!(given.floors(), floors::SHORT);
    }

    #[test]
    fn a_folder_with_other_files_is_not_cleared() {
        let folder = tempfile::tempdir().unwrap();
        let cases = folder.path().join("cases");
        fs::create_dir(&cases).unwrap();
        assert!(clear(folder.path(), MARKER, &FOLDERS).is_err());
        assert!(cases.exists());
        fs::write(folder.path().join(MARKER), "").unwrap();
        clear(folder.path(), MARKER, &FOLDERS).unwrap();
        assert!(!cases.exists());
    }
}
