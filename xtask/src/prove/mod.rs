//! `cargo xtask prove`: concealed effects, diagnosed blind, scored.
//!
//! The plant makes recordings and seals what it concealed in them; `dgd diagnose` sees a folder with one
//! recording and its well description; only after the last run are the truths opened. Both are run
//! as programs: nothing here shares code with what is judged.

mod answer;
mod charts;
mod exam;
mod failures;
mod measures;
mod page;
mod score;
mod seal;
mod simulation;
mod stats;
mod summary;
mod svg;
mod targets;
mod truth;

use crate::tools;
use anyhow::{Context, Result, bail};
use clap::{Args, ValueEnum};
use exam::Exam;
use seal::Sealed;
use serde_json::{Value, json};
use std::fs;
use std::io::{IsTerminal, Write};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::Mutex;
use std::time::Instant;
use summary::{Row, Summary};
use truth::Truth;

/// Seeds up to this one are for calibrating, and prove nothing.
const CALIBRATION_SEEDS: u64 = 999;
/// So many hold each single effect in each severity once.
const WHOLE: usize = 200;
/// A level of the short form diagnoses this many: eight singles, two clean, a pair and a foreign effect.
const SHORT: usize = 12;
/// Of so many: level one takes the first, level two the last, so that they meet other effects.
const SHORT_OF: usize = 32;
/// Folders of an earlier proof carry this file; no others are cleared.
const MARKER: &str = ".dgd-proof";

/// What to prove, and how.
#[derive(Args)]
pub(crate) struct Settings {
    /// Base physics: 1 clean, 2 what a model meets only approximately
    #[arg(long, value_enum, default_value = "both")]
    level: Levels,
    /// Recordings a level; 200 hold each single effect in each severity once
    #[arg(long, default_value_t = WHOLE, value_parser = clap::builder::RangedU64ValueParser::<usize>::new().range(1..=10_000))]
    count: usize,
    /// Seed of the recordings; 1 to 999 are for calibrating and refused
    #[arg(long, default_value_t = 2015)]
    seed: u64,
    /// Twelve of 32 recordings a level, others at each, for continuous integration
    #[arg(long, conflicts_with = "count")]
    short: bool,
    /// Folder for recordings, answers, proof.html, proof.json and failures.md
    #[arg(long, default_value = "target/proof")]
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
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Levels {
    #[value(name = "1")]
    One,
    #[value(name = "2")]
    Two,
    Both,
}

impl Levels {
    fn list(self) -> &'static [u8] {
        match self {
            Levels::One => &[1],
            Levels::Two => &[2],
            Levels::Both => &[1, 2],
        }
    }
}

impl Settings {
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
            seed: 2015,
            short: true,
            out,
            jobs: 1,
            only: Vec::new(),
            keep: false,
        }
    }
}

/// What the page says about how it came to be.
struct Origin {
    version: String,
    /// SHA-256 of the program.
    program: String,
    commit: Option<String>,
    cores: usize,
    /// Level and SHA-256 of its truths.
    seals: Vec<(u8, String)>,
}

/// Runs the proof; fails on broken rules, never on a score.
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
    let (plant, dgd) = (
        tools::build("dgd-plant", "dgd-plant")?,
        tools::build("dgd-cli", "dgd")?,
    );
    // A copy, so that a build meanwhile does not change what is proved.
    let shelf = tempfile::tempdir().context("cannot make a temporary folder")?;
    let (program, dgd) = (dgd, shelf.path().join("dgd"));
    fs::copy(&program, &dgd).with_context(|| format!("cannot copy {}", program.display()))?;
    fs::create_dir_all(&settings.out)
        .with_context(|| format!("cannot make {}", settings.out.display()))?;
    settings.out = fs::canonicalize(&settings.out).context("cannot resolve the folder")?;
    clear(&settings.out)?;

    let levels = settings.level.list();
    let make =
        |level: &u8| seal::conceal(&plant, &settings.out, *level, settings.seed, settings.count);
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
        program: seal::sha256(&fs::read(&dgd).context("cannot read the program")?),
        version: first_line(Command::new(&dgd).arg("--version")).unwrap_or_default(),
        commit: first_line(
            Command::new("git")
                .args(["describe", "--always", "--dirty"])
                .current_dir(tools::root()),
        ),
        cores: std::thread::available_parallelism().map_or(1, usize::from),
        seals: sealed.iter().map(|s| (s.level, s.sha256.clone())).collect(),
    };

    let exams = examine(&settings, &dgd, &sealed)?;

    for s in &sealed {
        s.check().context("the seal is broken")?;
        println!("seal of level {} holds", s.level);
    }
    let rows = open(&sealed, exams)?;
    let summaries: Vec<Summary> = levels.iter().map(|l| Summary::of(*l, &rows)).collect();
    let save = |name: &str, text: String| {
        let path = settings.out.join(name);
        fs::write(&path, text).with_context(|| format!("cannot write {}", path.display()))
    };
    save("failures.md", failures::write(&settings, &rows))?;
    let record = json_of(&settings, &origin, &summaries, &rows);
    save("proof.json", format!("{record:#}\n"))?;
    save(
        "proof.html",
        page::write(&settings, &origin, &summaries, &rows),
    )?;
    tell(&summaries);
    println!("\n{}", settings.out.join("proof.html").display());
    verdict(&rows)
}

/// Broken rules fail the proof.
fn verdict(rows: &[Row]) -> Result<()> {
    let broken: Vec<&Row> = rows.iter().filter(|r| !r.broken.is_empty()).collect();
    if broken.is_empty() {
        return Ok(());
    }
    let mut text = format!("{} of {} cases broke a rule", broken.len(), rows.len());
    for row in broken.iter().take(10) {
        text.push_str(&format!(
            "\n  level {} {}: {}",
            row.level, row.id, row.broken[0]
        ));
    }
    bail!("{text}\nall are in failures.md")
}

/// Removes what an earlier proof left; a folder that holds anything else is left alone.
fn clear(out: &Path) -> Result<()> {
    let mut entries =
        fs::read_dir(out).with_context(|| format!("cannot read {}", out.display()))?;
    let marker = out.join(MARKER);
    if entries.next().is_some() && !marker.exists() {
        bail!(
            "{} holds files that are of no earlier proof: give an empty folder",
            out.display()
        );
    }
    for folder in ["cases", "sealed", "answers"] {
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

/// Diagnoses all cases; results in the order of the cases, however many run at a time.
fn examine(
    settings: &Settings,
    dgd: &Path,
    sealed: &[Sealed],
) -> Result<Vec<((u8, String), Exam)>> {
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
    let time = exam::gnu_time();
    let begun = Instant::now();
    let state = Mutex::new((0_usize, Vec::new()));
    let work = || {
        loop {
            let next = {
                let mut state = state
                    .lock()
                    .unwrap_or_else(std::sync::PoisonError::into_inner);
                state.0 += 1;
                state.0 - 1
            };
            let Some((sealed, id)) = todo.get(next) else {
                return;
            };
            let level = format!("level-{}", sealed.level);
            let out = settings.out.join("answers").join(level).join(id);
            let case = sealed.cases.join(id);
            let exam = exam::sit(dgd, time.as_deref(), &case, &out, settings.keep);
            let mut state = state
                .lock()
                .unwrap_or_else(std::sync::PoisonError::into_inner);
            state.1.push((next, exam));
            progress(state.1.len(), todo.len(), begun);
        }
    };
    std::thread::scope(|scope| {
        for _ in 0..settings.jobs {
            scope.spawn(work);
        }
    });
    let (_, mut exams) = state
        .into_inner()
        .unwrap_or_else(std::sync::PoisonError::into_inner);
    exams.sort_by_key(|(index, _)| *index);
    let name = |(sealed, id): &(&Sealed, &String)| (sealed.level, (*id).clone());
    Ok(todo
        .iter()
        .map(name)
        .zip(exams.into_iter().map(|(_, e)| e))
        .collect())
}

/// How far, and how long still, on standard error; one line that renews itself on a terminal.
fn progress(done: usize, of: usize, begun: Instant) {
    let spent = begun.elapsed().as_secs_f64();
    let left = spent / done as f64 * (of - done) as f64;
    let mut to = std::io::stderr();
    let line = format!("{done} of {of} diagnosed, {spent:.0} s, {left:.0} s to go");
    // Progress is a courtesy: nothing is lost if nobody listens.
    let _ = if to.is_terminal() {
        write!(to, "\r\x1b[2K{line}{}", if done == of { "\n" } else { "" })
    } else if done == of || done.is_multiple_of(10) {
        writeln!(to, "{line}")
    } else {
        Ok(())
    };
}

/// Opens the truths, and holds the answers against them.
fn open(sealed: &[Sealed], exams: Vec<((u8, String), Exam)>) -> Result<Vec<Row>> {
    let mut rows = Vec::with_capacity(exams.len());
    for ((level, id), exam) in exams {
        let own = sealed.iter().find(|s| s.level == level);
        let bytes = own.context("a case of no level")?.truth(&id)?;
        let truth = Truth::read(&bytes).with_context(|| format!("{id}.truth.json"))?;
        let mut row = Row::new((level, id), truth, exam.answer, exam.simulation);
        row.broken = exam.broken;
        row.wall_s = exam.wall_s;
        row.peak_mib = exam.peak_mib;
        rows.push(row);
    }
    Ok(rows)
}

/// The table on standard output.
fn tell(summaries: &[Summary]) {
    let columns: Vec<Vec<measures::Measure>> = summaries.iter().map(measures::measures).collect();
    let Some(first) = columns.first() else { return };
    print!("\n{:<62}", "");
    for s in summaries {
        print!("level {:<38}", s.level);
    }
    println!();
    for (i, measure) in first.iter().enumerate() {
        print!("{:<62}", measure.title);
        for column in &columns {
            let m = &column[i];
            let score = format!("{:>9}  {}", m.score.value(), m.score.basis());
            let target = m.target.map(|t| {
                let sign = match t.met(m.score) {
                    Some(true) => "+",
                    Some(false) => "-",
                    None => " ",
                };
                format!("{sign} {}", t.text(m.score))
            });
            print!("{score:<28}{:<16}", target.unwrap_or_default());
        }
        println!();
    }
}

/// `proof.json`
fn json_of(settings: &Settings, origin: &Origin, summaries: &[Summary], rows: &[Row]) -> Value {
    let target = |m: &measures::Measure| m.target.map(|t| t.text(m.score));
    let level = |s: &Summary| {
        let scores: Vec<Value> = measures::measures(s)
            .iter()
            .map(|m| {
                json!({"measure": m.title, "score": m.score.json(), "target": target(m),
                       "met": m.target.and_then(|t| t.met(m.score))})
            })
            .collect();
        json!({"level": s.level, "scores": scores})
    };
    let case = |r: &Row| {
        let gains: serde_json::Map<String, Value> = answer::SIGNALS
            .iter()
            .zip(r.simulation.iter().flat_map(|s| &s.gains))
            .filter_map(|(name, g)| Some((name, (*g)?)))
            .map(|(name, g)| {
                let value = json!({"rmse_before": g.rmse_before, "rmse_after": g.rmse_after, "samples": g.samples});
                ((*name).to_owned(), value)
            })
            .collect();
        let parameters: Vec<Value> = r
            .marks
            .parameters
            .iter()
            .map(|p| json!({"effect": p.effect, "name": p.name, "relative_error": p.error, "covered": p.covered}))
            .collect();
        json!({
            "level": r.level, "id": r.id, "hours": r.truth.hours, "well": r.truth.well,
            "concealed": r.truth.effects.iter().map(|e| json!({"effect": e.effect, "kind": e.kind, "severity": e.severity})).collect::<Vec<_>>(),
            "verdict": r.answer.as_ref().map(|a| &a.verdict),
            "findings": r.marks.forecasts.iter().zip(r.answer.iter().flat_map(|a| &a.findings))
                .map(|((p, right), f)| json!({"effect": f.effect, "probability": p, "right": right})).collect::<Vec<_>>(),
            "exact": r.marks.exact, "within": r.marks.within, "relation_right": r.marks.relation,
            "overlap": r.marks.overlap, "parameters": parameters, "held_out": gains,
            "held_share": r.simulation.as_ref().map(|s| s.held_share),
            "broken": r.broken, "wall_s": r.wall_s, "peak_mib": r.peak_mib,
        })
    };
    json!({
        "schema": "dgd.proof/1",
        "seed": settings.seed, "count": settings.count, "only": settings.only, "jobs": settings.jobs,
        "short": settings.short, "dgd": origin.version, "dgd_sha256": origin.program, "commit": origin.commit, "cores": origin.cores,
        "seals": origin.seals.iter().map(|(l, h)| json!({"level": l, "sha256": h})).collect::<Vec<_>>(),
        "levels": summaries.iter().map(level).collect::<Vec<_>>(),
        "cases": rows.iter().map(case).collect::<Vec<_>>(),
    })
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
    fn a_folder_with_other_files_is_not_cleared() {
        let folder = tempfile::tempdir().unwrap();
        let cases = folder.path().join("cases");
        fs::create_dir(&cases).unwrap();
        assert!(clear(folder.path()).is_err());
        assert!(cases.exists());
        fs::write(folder.path().join(MARKER), "").unwrap();
        clear(folder.path()).unwrap();
        assert!(!cases.exists());
    }
}
