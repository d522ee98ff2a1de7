//! `cargo xtask calibrate`: hurdles, probabilities and intervals from ensembles that prove nothing.
//!
//! The plant makes recordings with seeds that `cargo xtask prove` refuses; `dgd diagnose --without calibration` tells the
//! evidence of every effect, the bare probability of every finding and the bare standard error of its size; hurdles follow from the
//! clean recordings, the calibration from the findings, the shares that widen intervals from sizes beside what was concealed. Prints and writes what the constants would be beside what they are: it edits no source.

mod belief;
mod hurdles;
pub(crate) mod logistic;
mod page;
mod sizes;
mod tail;

use crate::prove::answer::Answer;
use crate::prove::exam::{Paper, Scope};
use crate::prove::truth::Truth;
use crate::prove::{CALIBRATION_SEEDS, Levels, Shelf, ablation, batch, clear, seal};
use anyhow::{Context, Result, bail};
use belief::Belief;
use clap::Args;
use hurdles::{Hurdles, Rule};
use serde_json::{Value, json};
use sizes::Sizes;
use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

/// The step that is left out, so that findings carry their bare probabilities.
const STEP: &str = "calibration";
const MARKER: &str = ".dgd-calibration";
const FOLDERS: [&str; 2] = ["ensembles", "answers"];

/// What to calibrate on.
#[derive(Args)]
pub(crate) struct Settings {
    /// Seeds of the ensembles, 1 to 999, such as 11,12,13; those from 1000 on are for proving and refused
    #[arg(long, value_delimiter = ',', required = true)]
    seeds: Vec<u64>,
    /// Mixed recordings a seed and level; of twenty three are clean
    #[arg(long, default_value_t = 100, value_parser = clap::builder::RangedU64ValueParser::<usize>::new().range(1..=10_000))]
    count: usize,
    /// Clean recordings a seed and level besides: hurdles rest on them alone
    #[arg(long, default_value_t = 40, value_parser = clap::builder::RangedU64ValueParser::<usize>::new().range(0..=10_000))]
    clean: usize,
    /// Base physics: 1 clean, 2 what a model meets only approximately
    #[arg(long, value_enum, default_value = "both")]
    level: Levels,
    /// Clean recordings that may raise a false alarm, over the whole catalogue
    #[arg(long, default_value_t = 0.02)]
    rate: f64,
    /// Share of the clean evidence below the tail that is taken for exponential
    #[arg(long, default_value_t = 0.8)]
    tail: f64,
    /// Folder for recordings, answers, calibration.html and calibration.json
    #[arg(long, default_value = "target/calibration")]
    out: PathBuf,
    /// Diagnoses at a time
    #[arg(long, default_value_t = 1, value_parser = clap::builder::RangedU64ValueParser::<usize>::new().range(1..=256))]
    jobs: usize,
}

impl Settings {
    fn check(&self) -> Result<()> {
        let other = self
            .seeds
            .iter()
            .find(|s| !(1..=CALIBRATION_SEEDS).contains(s));
        if let Some(seed) = other {
            bail!("seed {seed} is not for calibrating: give seeds from 1 to {CALIBRATION_SEEDS}");
        }
        let distinct: BTreeSet<&u64> = self.seeds.iter().collect();
        if distinct.len() < self.seeds.len() {
            bail!(
                "a seed is given twice in {:?}: it would count twice",
                self.seeds
            );
        }
        for (name, share) in [("rate", self.rate), ("tail", self.tail)] {
            if !(share > 0.0 && share < 1.0) {
                bail!("--{name} is {share}, expected more than 0 and less than 1");
            }
        }
        Ok(())
    }

    fn rule(&self) -> Rule {
        Rule {
            rate: self.rate,
            below: self.tail,
        }
    }
}

/// A recording with what it conceals and what was said of it.
pub(crate) struct Case {
    pub(crate) seed: u64,
    pub(crate) level: u8,
    pub(crate) truth: Truth,
    pub(crate) answer: Answer,
}

/// What calibrating came to.
pub(crate) struct Calibration<'a> {
    pub(crate) settings: &'a Settings,
    pub(crate) cases: Vec<Case>,
    /// Runs that gave no answer.
    pub(crate) broken: Vec<String>,
    pub(crate) hurdles: Hurdles,
    pub(crate) belief: Belief,
    pub(crate) sizes: Sizes,
}

/// Calibrates; fails where nothing can be told, not on what is found.
pub(crate) fn run(mut settings: Settings) -> Result<()> {
    settings.check()?;
    let shelf = Shelf::stock()?;
    let steps = ablation::steps(&shelf.dgd)?;
    if !steps.iter().any(|s| s == STEP) {
        bail!(
            "dgd diagnose cannot leave out `{STEP}`, only {}",
            steps.join(", ")
        );
    }
    fs::create_dir_all(&settings.out)
        .with_context(|| format!("cannot make {}", settings.out.display()))?;
    settings.out = fs::canonicalize(&settings.out).context("cannot resolve the folder")?;
    clear(&settings.out, MARKER, &FOLDERS)?;

    let mut known = Vec::new();
    let mut papers = Vec::new();
    for seed in &settings.seeds {
        for level in settings.level.list() {
            make(
                &shelf.plant,
                &settings,
                *seed,
                *level,
                &mut known,
                &mut papers,
            )?;
        }
    }
    let exams = batch::all(&shelf.dgd, settings.jobs, &papers, " without calibration");
    let (mut cases, mut broken) = (Vec::new(), Vec::new());
    for ((seed, level, name, truth), exam) in known.into_iter().zip(exams) {
        match exam.answer {
            Some(answer) => cases.push(Case {
                seed,
                level,
                truth,
                answer,
            }),
            None => broken.push(format!("{name}: {}", exam.broken.join("; "))),
        }
    }
    let calibration = Calibration {
        hurdles: Hurdles::of(&cases, settings.rule()),
        belief: Belief::of(&cases, belief::now()),
        sizes: Sizes::of(&cases, &sizes::now(&shelf.dgd)?),
        settings: &settings,
        cases,
        broken,
    };
    let save = |name: &str, text: String| {
        let path = settings.out.join(name);
        fs::write(&path, text).with_context(|| format!("cannot write {}", path.display()))
    };
    save("calibration.json", format!("{:#}\n", json_of(&calibration)))?;
    save("calibration.html", page::write(&calibration))?;
    tell(&calibration);
    println!("\n{}", settings.out.join("calibration.html").display());
    Ok(())
}

/// Seed, level, name and truth of a recording.
type Known = (u64, u8, String, Truth);

/// Makes the recordings of one seed and level: mixed ones, and clean ones that are not among them.
fn make(
    plant: &Path,
    settings: &Settings,
    seed: u64,
    level: u8,
    known: &mut Vec<Known>,
    papers: &mut Vec<Paper>,
) -> Result<()> {
    let mut seen = BTreeSet::new();
    for (kind, count) in [("mix", settings.count), ("clean", settings.clean)] {
        if count == 0 {
            continue;
        }
        let ensemble = format!("seed-{seed}-{kind}");
        let order = seal::Order {
            level,
            seed,
            count,
            kind,
            hours: None,
        };
        let folder = settings.out.join("ensembles").join(&ensemble);
        let made = seal::conceal(plant, &folder, &order)?;
        for id in &made.ids {
            let case = made.cases.join(id);
            // The same seed and number make the same clean recording, in the mix as well.
            if !seen.insert(seal::sha256(&recording(&case)?)) {
                continue;
            }
            let name = format!("{ensemble}/level-{level}/{id}");
            let truth = Truth::read(&made.truth(id)?).with_context(|| name.clone())?;
            papers.push(Paper {
                case,
                out: settings.out.join("answers").join(&name),
                options: vec!["--without".into(), STEP.into()],
                scope: Scope::Names,
            });
            known.push((seed, level, name, truth));
        }
    }
    Ok(())
}

/// The bytes of the recording in a case's folder.
fn recording(case: &Path) -> Result<Vec<u8>> {
    let entries = fs::read_dir(case).with_context(|| format!("cannot read {}", case.display()))?;
    for entry in entries {
        let entry = entry.with_context(|| format!("cannot read {}", case.display()))?;
        if entry
            .file_name()
            .to_string_lossy()
            .starts_with("recording.")
        {
            let path = entry.path();
            return fs::read(&path).with_context(|| format!("cannot read {}", path.display()));
        }
    }
    bail!("no recording in {}", case.display())
}

/// The tables on standard output.
fn tell(c: &Calibration) {
    println!("{}", page::ensembles(c));
    println!(
        "\n{:<28}{:>7}{:>9}{:>9}{:>7}{:>9}{:>8}{:>10}{:>10}",
        "effect", "clean", "largest", "spread", "now", "derived", "+/-", "above now", "above der."
    );
    let number = |v: Option<f64>| v.map_or("-".into(), |v| format!("{v:.1}"));
    for h in &c.hurdles.effects {
        println!(
            "{:<28}{:>7}{:>9}{:>9}{:>7}{:>9}{:>8}{:>10}{:>10}",
            h.effect,
            h.clean.len(),
            number(h.tail.map(|t| t.largest)),
            h.tail.map_or("-".into(), |t| format!("{:.2}", t.spread)),
            number(h.now),
            number(h.derived()),
            number(h.error()),
            h.now.map_or("-".into(), |now| h.above(now).to_string()),
            h.derived().map_or("-".into(), |d| h.above(d).to_string()),
        );
    }
    println!("\n{}", page::alarms(&c.hurdles));
    let told = |v: &[f64]| -> String {
        let numbers = v.iter().map(|v| format!("{v:>8.2}"));
        numbers.collect()
    };
    println!("\ncalibration    {}", belief::NAMES.join("  "));
    if let Some(now) = c.belief.now {
        println!("now        {}", told(&now));
    }
    if let Some(fit) = &c.belief.fit {
        println!(
            "derived    {}\n+/-        {}",
            told(&fit.coefficients),
            told(&fit.errors)
        );
    }
    println!("{}", page::brier(&c.belief));
    println!(
        "\n{:<28}{:>7}{:>14}{:>8}{:>9}{:>10}",
        "size of", "told", "median error", "now", "derived", "held now"
    );
    let share = |v: Option<f64>| v.map_or("-".into(), |v| format!("{v:.3}"));
    for s in &c.sizes.effects {
        println!(
            "{:<28}{:>7}{:>14}{:>8}{:>9}{:>10}",
            s.effect,
            s.told.len(),
            share(s.typical()),
            share(Some(s.now)),
            share(s.derived()),
            s.held().right,
        );
    }
}

/// `calibration.json`
fn json_of(c: &Calibration) -> Value {
    json!({
        "schema": "dgd.calibration/1",
        "seeds": c.settings.seeds, "count": c.settings.count, "clean": c.settings.clean, "levels": c.settings.level.list(),
        "rate": c.settings.rate, "tail": c.settings.tail, "recordings": c.cases.len(), "clean_recordings": c.hurdles.clean,
        "no_answer": c.broken,
        "hurdles": c.hurdles.json(),
        "belief": c.belief.json(),
        "sizes": c.sizes.json(),
    })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may")]
    use super::*;

    pub(super) fn settings(seeds: &[u64]) -> Settings {
        Settings {
            seeds: seeds.to_vec(),
            count: 6,
            clean: 4,
            level: Levels::Two,
            rate: 0.02,
            tail: 0.8,
            out: "calibration".into(),
            jobs: 1,
        }
    }

    #[test]
    fn a_seed_for_proving_is_refused_and_so_is_one_given_twice() {
        for (seeds, said) in [
            (vec![11, 1000], "1000 is not for calibrating"),
            (vec![0], "0 is not for calibrating"),
            (vec![11, 12, 11], "given twice"),
        ] {
            let error = run(settings(&seeds)).unwrap_err().to_string();
            assert!(error.contains(said), "{error}");
        }
        settings(&[1, CALIBRATION_SEEDS]).check().unwrap();
    }

    #[test]
    fn rate_and_tail_are_shares() {
        for share in [0.0, 1.0, f64::NAN] {
            let with = |rate: f64, tail: f64| {
                let other = Settings {
                    rate,
                    tail,
                    ..settings(&[1])
                };
                other.check().unwrap_err().to_string()
            };
            assert!(with(share, 0.8).contains("--rate"));
            assert!(with(0.02, share).contains("--tail"));
        }
    }
}
