//! `cargo xtask prove --benches`: two benches that the catalogue was not written for, diagnosed blind, scored.
//!
//! `dgd-plant bench` simulates a surge shaft and a glycol loop with one thing left out of their textbook form, or none,
//! and seals what it was. `dgd diagnose --system` sees a folder with one recording and the description of the bench. Only after
//! the last run are the truths opened.

mod answer;
mod counterparts;
mod page;
mod run;
mod score;
mod summary;
mod truth;

use crate::prove::{CALIBRATION_SEEDS, Program, Shelf, clear};
use crate::tools;
use anyhow::{Context, Result, bail};
use score::Row;
use sha2::{Digest, Sha256};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use truth::Truth;

/// The benches, as the plant names them, in its order.
pub(crate) const BENCHES: [&str; 2] = ["surge-shaft", "glycol-loop"];
const MARKER: &str = ".dgd-benches";
const FOLDERS: [&str; 3] = ["cases", "sealed", "answers"];

/// What to prove, and how.
pub(crate) struct Settings {
    /// Recordings of each bench.
    pub(crate) count: usize,
    pub(crate) seed: u64,
    pub(crate) out: PathBuf,
    /// Diagnoses at a time.
    pub(crate) jobs: usize,
    /// Only these cases; all if empty.
    pub(crate) only: Vec<String>,
    /// Keep each simulation.csv.
    pub(crate) keep: bool,
}

/// What the page says about how it came to be.
struct Origin {
    program: Program,
    seal: String,
}

/// Runs the proof; fails on broken rules, never on a score.
pub(crate) fn run(mut settings: Settings) -> Result<()> {
    if settings.seed <= CALIBRATION_SEEDS {
        bail!(
            "seed {} is one of those for building (0 to {CALIBRATION_SEEDS}): prove with another",
            settings.seed
        );
    }
    let shelf = Shelf::stock()?;
    fs::create_dir_all(&settings.out)
        .with_context(|| format!("cannot make {}", settings.out.display()))?;
    settings.out = fs::canonicalize(&settings.out).context("cannot resolve the folder")?;
    clear(&settings.out, MARKER, &FOLDERS)?;
    let seal = conceal(&shelf.plant, &settings)?;
    check(&settings, &seal)?;
    println!(
        "sealed: {} recordings of each of {} benches, SHA-256 of their truths {seal}",
        settings.count,
        BENCHES.len()
    );
    let origin = Origin {
        program: Program::of(&shelf.dgd)?,
        seal,
    };

    let todo = asked(&settings)?;
    let exams = run::all(&shelf.dgd, &settings, &todo);
    check(&settings, &origin.seal).context("the seal is broken")?;
    println!("the seal holds");

    let mut rows = Vec::with_capacity(exams.len());
    for ((bench, id), exam) in todo.iter().zip(exams) {
        let path = truth_path(&settings.out, bench, id);
        let bytes = fs::read(&path).with_context(|| format!("cannot read {}", path.display()))?;
        let truth = Truth::read(&bytes).with_context(|| format!("{}", path.display()))?;
        rows.push(Row::new(truth, exam));
    }
    let save = |name: &str, text: String| tools::replace(&settings.out.join(name), text);
    let record = summary::json_of(&settings, &origin, &rows);
    save("benches.json", format!("{record:#}\n"))?;
    save("benches.html", page::write(&settings, &origin, &rows))?;
    print!("\n{}", summary::table(&rows));
    println!("\n{}", settings.out.join("benches.html").display());
    verdict(&rows)
}

/// Lets the plant make the cases; gives the SHA-256 of their truths that it printed.
fn conceal(plant: &Path, settings: &Settings) -> Result<String> {
    let output = Command::new(plant)
        .args(["bench", "--kind", "mix", "--sealed"])
        .arg("--out")
        .arg(settings.out.join("cases"))
        .arg("--truth")
        .arg(settings.out.join("sealed"))
        .args(["--seed", &settings.seed.to_string()])
        .args(["--count", &settings.count.to_string()])
        .stderr(Stdio::null())
        .output()
        .with_context(|| format!("cannot run {}", plant.display()))?;
    if !output.status.success() {
        bail!("dgd-plant bench ended with {}", output.status);
    }
    Ok(String::from_utf8_lossy(&output.stdout).trim().to_owned())
}

fn truth_path(out: &Path, bench: &str, id: &str) -> PathBuf {
    out.join("sealed")
        .join(bench)
        .join(format!("{id}.truth.json"))
}

fn ids(count: usize) -> impl Iterator<Item = String> {
    (0..count).map(|i| format!("c{i:03}"))
}

/// Whether the truths are still those that were sealed.
fn check(settings: &Settings, sealed: &str) -> Result<()> {
    let mut seal = Sha256::new();
    for bench in BENCHES {
        for id in ids(settings.count) {
            let path = truth_path(&settings.out, bench, &id);
            let bytes = fs::read(&path);
            seal.update(bytes.with_context(|| format!("cannot read {}", path.display()))?);
        }
    }
    let found: String = seal.finalize().iter().map(|b| format!("{b:02x}")).collect();
    if found != sealed {
        bail!("the truths have the SHA-256 {found}, sealed was {sealed}");
    }
    Ok(())
}

/// The cases to diagnose.
fn asked(settings: &Settings) -> Result<Vec<(&'static str, String)>> {
    let of = |bench: &'static str| ids(settings.count).map(move |id| (bench, id));
    let wanted = |id: &String| settings.only.is_empty() || settings.only.contains(id);
    let all = BENCHES.into_iter().flat_map(of);
    let todo: Vec<_> = all.filter(|(_, id)| wanted(id)).collect();
    if todo.is_empty() {
        bail!(
            "none of {:?} is a case, expected c000 and so on",
            settings.only
        );
    }
    Ok(todo)
}

/// Broken rules fail the proof.
fn verdict(rows: &[Row]) -> Result<()> {
    let broken: Vec<String> = rows
        .iter()
        .filter_map(|r| {
            let word = r.broken.first()?;
            Some(format!("\n  {} {}: {word}", r.truth.bench, r.truth.id))
        })
        .collect();
    if broken.is_empty() {
        return Ok(());
    }
    bail!(
        "{} of {} cases broke a rule{}",
        broken.len(),
        rows.len(),
        broken.concat()
    )
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may")]
    use super::*;

    fn settings(out: &Path) -> Settings {
        Settings {
            count: 1,
            seed: 5005,
            out: out.to_owned(),
            jobs: 1,
            only: Vec::new(),
            keep: false,
        }
    }

    #[test]
    fn a_touched_truth_breaks_the_seal() {
        let folder = tempfile::tempdir().unwrap();
        let settings = settings(folder.path());
        for (bench, text) in BENCHES.iter().zip(["a", "bc"]) {
            let path = truth_path(folder.path(), bench, "c000");
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(path, text).unwrap();
        }
        // Of "abc", the first example of FIPS 180-4.
        let sha256 = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";
        check(&settings, sha256).unwrap();
        fs::write(truth_path(folder.path(), BENCHES[1], "c000"), "bd").unwrap();
        assert!(check(&settings, sha256).is_err());
    }

    #[test]
    fn seeds_for_building_prove_nothing() {
        let mut settings = settings(Path::new("nowhere"));
        settings.seed = 999;
        assert!(
            run(settings)
                .unwrap_err()
                .to_string()
                .contains("for building")
        );
    }

    #[test]
    fn a_case_that_is_none_is_refused() {
        let mut settings = settings(Path::new("nowhere"));
        settings.only = vec!["c001".into()];
        assert!(asked(&settings).is_err());
        settings.only = vec!["c000".into()];
        assert_eq!(asked(&settings).unwrap().len(), 2);
    }
}
