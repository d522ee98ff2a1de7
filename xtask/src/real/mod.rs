//! `cargo xtask prove --real DIR`: recordings of real physics, diagnosed, and the held-out error computed again.
//!
//! The recordings belong to others: they are read from where the user has put them (`fixtures/real/README.md` says where they
//! come from), their checksums are checked, and only tables made from them are written, below the folder for results.

mod cases;
mod page;
mod prepare;
mod score;

use crate::prove::seal::sha256;
use crate::tools;
use anyhow::{Context, Result, bail};
use cases::{Aim, CASES, Case, Source};
use prepare::Columns;
use score::Score;
use serde_json::{Value, json};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Instant;

/// What came of one case.
pub(crate) enum Outcome {
    /// Files that are not there.
    Absent(Vec<&'static str>),
    Done(Box<Done>),
}

pub(crate) struct Done {
    pub(crate) score: Score,
    /// Held-out error of the textbook model by `dgd fit`.
    pub(crate) fitted: f64,
    /// Held-out error of the diagnosis's model as written down, run by `dgd simulate`.
    pub(crate) rerun: f64,
    pub(crate) seconds: f64,
    pub(crate) diagnosis: Value,
    /// Samples that were left out before the diagnosis.
    pub(crate) left_out: usize,
    /// Held-out axis, measured, before and after, for the picture.
    pub(crate) curves: [Vec<f64>; 4],
}

impl Done {
    pub(crate) fn verdict(&self) -> &str {
        self.diagnosis["verdict"].as_str().unwrap_or_default()
    }

    /// `component.effect` of what is named.
    pub(crate) fn named(&self) -> Vec<String> {
        let findings = self.diagnosis["findings"].as_array();
        findings
            .into_iter()
            .flatten()
            .filter(|f| f["effect"] != "unknown")
            .map(|f| format!("{}.{}", word(&f["component"]), word(&f["effect"])))
            .collect()
    }

    /// Whether the aim is met.
    pub(crate) fn meets(&self, aim: Aim) -> bool {
        match aim {
            Aim::AtMost { after, .. } => self.score.after <= after && !self.named().is_empty(),
            Aim::Consistent => self.verdict() == "consistent",
            Aim::Located => {
                let sections = self.diagnosis["sections"].as_array().map_or(0, Vec::len);
                sections > 1 && self.score.after <= 1.001 * self.score.before
            }
        }
    }
}

/// Text of a value; empty if it is none.
pub(crate) fn word(value: &Value) -> &str {
    value.as_str().unwrap_or_default()
}

/// Runs what is there below `from`, writes into `out/real`. Fails where a file is not what its publisher gives or a run breaks,
/// not on a missed aim.
pub(crate) fn run(from: &Path, out: &Path) -> Result<()> {
    if !from.is_dir() {
        bail!(
            "{} is no folder: fixtures/real/README.md says where the recordings come from",
            from.display()
        );
    }
    let out = out.join("real");
    fs::create_dir_all(&out).with_context(|| format!("cannot make {}", out.display()))?;
    let folder = tempfile::tempdir().context("cannot make a temporary folder")?;
    let program = folder.path().join("dgd");
    let built = tools::build("dgd-cli", "dgd")?;
    fs::copy(&built, &program).with_context(|| format!("cannot copy {}", built.display()))?;
    let mut outcomes = Vec::new();
    for case in &CASES {
        let outcome =
            one(case, from, &out, &program).with_context(|| format!("{}: no result", case.id))?;
        println!("{}", line(case, &outcome));
        outcomes.push(outcome);
    }
    let write = |name: &str, text: String| tools::replace(&out.join(name), text);
    write("real.html", page::write(&outcomes))?;
    let all: Vec<Value> = CASES
        .iter()
        .zip(&outcomes)
        .map(|(c, o)| as_json(c, o))
        .collect();
    write(
        "real.json",
        serde_json::to_string_pretty(&json!({ "schema": "dgd.real/1", "cases": all }))? + "\n",
    )?;
    let skipped = outcomes
        .iter()
        .filter(|o| matches!(o, Outcome::Absent(_)))
        .count();
    println!(
        "{} of {} recordings run, {skipped} skipped; open {}",
        CASES.len() - skipped,
        CASES.len(),
        out.join("real.html").display()
    );
    Ok(())
}

fn line(case: &Case, outcome: &Outcome) -> String {
    match outcome {
        Outcome::Absent(files) => format!("{}: skipped, no {}", case.title, files.join(", ")),
        Outcome::Done(d) => format!(
            "{}: {} {}, {} to {} {} on {} held-out samples, {:.1} s; {}",
            case.title,
            d.verdict(),
            d.named().join(", "),
            page::short(d.score.before),
            page::short(d.score.after),
            case.unit,
            d.score.samples,
            d.seconds,
            if d.meets(case.aim) { "met" } else { "missed" }
        ),
    }
}

fn as_json(case: &Case, outcome: &Outcome) -> Value {
    let aim = match case.aim {
        Aim::AtMost { after, from } => json!({ "at_most": after, "from": from }),
        Aim::Consistent => json!("consistent"),
        Aim::Located => json!("located"),
    };
    let mut value = json!({
        "id": case.id, "title": case.title, "unit": case.unit, "aim": aim, "history": case.history,
        "published": case.published.iter().map(|(who, v)| json!({ "who": who, "rms": v })).collect::<Vec<_>>(),
    });
    match outcome {
        Outcome::Absent(files) => value["skipped"] = json!(files),
        Outcome::Done(d) => {
            value["met"] = json!(d.meets(case.aim));
            value["held_out"] = json!({ "samples": d.score.samples, "before": d.score.before, "after": d.score.after,
                "textbook_fit": d.fitted, "after_run_again": d.rerun });
            value["seconds"] = json!(d.seconds);
            value["samples_left_out"] = json!(d.left_out);
            for key in [
                "verdict",
                "findings",
                "also_possible",
                "classes",
                "sections",
                "checks",
                "outputs",
            ] {
                value[key] = d.diagnosis[key].clone();
            }
        }
    }
    value
}

/// Checks the files of a case; what is not there is told.
fn absent(case: &Case, folder: &Path) -> Result<Vec<&'static str>> {
    let mut missing = Vec::new();
    for file in case.files {
        let path = folder.join(file.name);
        if !path.exists() {
            missing.push(file.name);
            continue;
        }
        let bytes = fs::read(&path).with_context(|| format!("cannot read {}", path.display()))?;
        let found = sha256(&bytes);
        if found != file.sha256 {
            bail!(
                "{} has the SHA-256 {found}, published is {}: download it again",
                path.display(),
                file.sha256
            );
        }
    }
    Ok(missing)
}

/// The recording as `dgd` reads it, its held-out readings with their axis, and how many rows were left out.
struct Prepared {
    recording: PathBuf,
    axis: Vec<f64>,
    measured: Vec<f64>,
    left_out: usize,
}

fn prepare(case: &Case, folder: &Path, out: &Path, program: &Path) -> Result<Prepared> {
    let table = out.join("recording.csv");
    let keep =
        |columns: &Columns, name: &str, spans: &[(f64, f64)], left_out| -> Result<Prepared> {
            tools::replace(&table, columns.text())?;
            let axis = columns.values.first().map_or(&[][..], Vec::as_slice);
            let readings = axis.iter().zip(columns.named(name)?);
            let held = readings.filter(|(at, _)| spans.iter().any(|(a, b)| *at >= a && *at <= b));
            let (axis, measured) = held.map(|(a, v)| (*a, *v)).unzip();
            Ok(Prepared {
                recording: table.clone(),
                axis,
                measured,
                left_out,
            })
        };
    match case.source {
        Source::AsItIs { held_out } => {
            let recording = folder.join(case.files[0].name);
            run_dgd(
                program,
                &["convert".as_ref(), recording.as_ref(), table.as_ref()],
            )?;
            let columns = prepare::read(&table, held_out)?;
            let measured = columns.named(held_out)?.to_vec();
            // Where the publisher gives the same as text, it is the same to its digits.
            let beside = recording.with_extension("csv");
            if beside.exists() {
                let text = prepare::read(&beside, held_out)?;
                let text = text.named(held_out)?;
                let close = |(a, b): (&f64, &f64)| (a - b).abs() <= 1e-4 * b.abs().max(1.0);
                if text.len() != measured.len() || !text.iter().zip(&measured).all(close) {
                    bail!(
                        "{} is not what {} holds",
                        beside.display(),
                        recording.display()
                    );
                }
            }
            #[expect(clippy::cast_precision_loss, reason = "sample numbers")]
            let axis = (0..measured.len()).map(|i| i as f64).collect();
            Ok(Prepared {
                recording,
                axis,
                measured,
                left_out: 0,
            })
        }
        Source::Drilling { held_out } => {
            let log = prepare::read(&folder.join(case.files[0].name), "Depth")?;
            let (columns, left_out) = prepare::drilling(&log)?;
            keep(&columns, "standpipe", &[held_out], left_out)
        }
        Source::Bench { held_out } => {
            let files = case.files.iter();
            let files = files.map(|f| prepare::read(&folder.join(f.name), "time"));
            let columns = prepare::bench(&files.collect::<Result<Vec<_>>>()?)?;
            keep(&columns, "pre1", held_out, 0)
        }
    }
}

fn run_dgd(program: &Path, arguments: &[&Path]) -> Result<()> {
    let output = Command::new(program)
        .args(arguments)
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .output()
        .with_context(|| format!("cannot run {}", program.display()))?;
    if !output.status.success() {
        let said = String::from_utf8_lossy(&output.stderr);
        bail!("dgd {}: {}", arguments[0].display(), said.trim());
    }
    Ok(())
}

fn one(case: &Case, from: &Path, out: &Path, program: &Path) -> Result<Outcome> {
    let folder = from.join(case.folder);
    let missing = absent(case, &folder)?;
    if !missing.is_empty() {
        return Ok(Outcome::Absent(missing));
    }
    let out = out.join(case.id);
    fs::create_dir_all(&out).with_context(|| format!("cannot make {}", out.display()))?;
    let described = tools::root()
        .join("fixtures/real")
        .join(case.folder)
        .join(case.system);
    // Diagnosed from a folder that holds the recording and its description alone.
    let system = out.join("system.toml");
    fs::copy(&described, &system)
        .with_context(|| format!("cannot copy {}", described.display()))?;
    let prepared = prepare(case, &folder, &out, program)?;
    let recording = prepared.recording.as_path();
    let diagnosis = out.join("diagnosis");
    let clock = Instant::now();
    run_dgd(
        program,
        &[
            "diagnose".as_ref(),
            recording,
            "--system".as_ref(),
            &system,
            "--out".as_ref(),
            &diagnosis,
        ],
    )?;
    let seconds = clock.elapsed().as_secs_f64();
    let (fitted, rerun) = (out.join("textbook.toml"), out.join("run.csv"));
    let model = diagnosis.join("model.toml");
    run_dgd(
        program,
        &[
            "fit".as_ref(),
            recording,
            "--system".as_ref(),
            &system,
            "--out".as_ref(),
            &fitted,
        ],
    )?;
    run_dgd(
        program,
        &[
            "simulate".as_ref(),
            recording,
            "--system".as_ref(),
            &model,
            "--out".as_ref(),
            &rerun,
        ],
    )?;
    let simulated = format!("{}_simulated", case.output);
    let of = |path: &Path| {
        score::of(
            &prepare::read(path, "held_out")?,
            &simulated,
            &prepared.measured,
        )
    };
    let table = prepare::read(&diagnosis.join("simulation.csv"), "held_out")?;
    let score = score::score(&table, case.output, &prepared.measured)?;
    let curve = |what: &str| score::held_out(&table, &format!("{}_{what}", case.output));
    let text = fs::read_to_string(diagnosis.join("diagnosis.json"))?;
    Ok(Outcome::Done(Box::new(Done {
        score,
        fitted: of(&fitted.with_extension("csv"))?,
        rerun: of(&rerun)?,
        seconds,
        diagnosis: serde_json::from_str(&text).context("diagnosis.json")?,
        left_out: prepared.left_out,
        curves: [
            prepared.axis,
            prepared.measured,
            curve("before")?,
            curve("after")?,
        ],
    })))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may")]
    use super::*;

    #[test]
    fn absent_files_are_named_and_changed_ones_refused() {
        let folder = tempfile::tempdir().unwrap();
        let case = &CASES[3];
        assert_eq!(absent(case, folder.path()).unwrap().len(), 5);
        fs::write(folder.path().join("3bengzc.csv"), "time,pre1\n").unwrap();
        let error = absent(case, folder.path()).unwrap_err().to_string();
        assert!(
            error.contains("3bengzc.csv") && error.contains("published is 94c1"),
            "{error}"
        );
    }

    #[test]
    fn every_case_has_its_descriptions_in_the_fixtures() {
        for case in &CASES {
            let folder = tools::root().join("fixtures/real").join(case.folder);
            let text = fs::read_to_string(folder.join(case.system)).unwrap();
            assert!(
                text.contains(&format!("{} = {{ kind = \"instrument\"", case.output)),
                "{}",
                case.id
            );
        }
        let sums = fs::read_to_string(tools::root().join("fixtures/real/SHA256SUMS")).unwrap();
        for file in CASES.iter().flat_map(|c| c.files) {
            assert!(
                sums.contains(&format!("{}  ", file.sha256)),
                "{}",
                file.name
            );
        }
    }
}
