//! `dgd-plant conceal`: writes cases and their truths.

use crate::progress::progress;
use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use dgd_plant::{
    Case, EFFECTS, FOREIGN, Kind, Level, Order, PASSING, RECURRING, Severity, conceal, record,
    write_case, write_case_well_toml, write_truth,
};
use sha2::{Digest, Sha256};

/// What the command is asked for.
pub(crate) struct Conceal {
    order: Order,
    count: usize,
    out: PathBuf,
    truth: PathBuf,
    sealed: bool,
}

/// Reads the words after `conceal`.
pub(crate) fn parse(mut words: impl Iterator<Item = String>) -> Result<Conceal, String> {
    let (mut out, mut truth, mut sealed, mut count) = (None, None, false, 1);
    let mut order = Order {
        seed: 1,
        level: Level::One,
        kind: Kind::Mix,
        severity: None,
        effect: None,
        hours: None,
        viscosity: 1.0,
    };
    while let Some(word) = words.next() {
        if word == "--sealed" {
            sealed = true;
            continue;
        }
        let mut value = || words.next().ok_or(format!("`{word}` needs a value"));
        match word.as_str() {
            "--out" => out = Some(PathBuf::from(value()?)),
            "--truth" => truth = Some(PathBuf::from(value()?)),
            "--seed" => order.seed = whole(&word, &value()?)?,
            "--count" => {
                let n = whole(&word, &value()?)?;
                count = usize::try_from(n.min(100_000)).unwrap_or(100_000);
            }
            "--hours" => order.hours = Some(hours(&value()?)?),
            "--viscosity" => order.viscosity = viscosity(&value()?)?,
            "--level" => {
                let text = value()?;
                order.level = match text.as_str() {
                    "1" => Level::One,
                    "2" => Level::Two,
                    _ => return Err(format!("`--level` is `{text}`, expected 1 or 2")),
                };
            }
            "--kind" => {
                let text = value()?;
                order.kind = match text.as_str() {
                    "single" => Kind::Single,
                    "pair" => Kind::Pair,
                    "several" => Kind::Several,
                    "passing" => Kind::Passing,
                    "recurring" => Kind::Recurring,
                    "clean" => Kind::Clean,
                    "foreign" => Kind::Foreign,
                    "beside" => Kind::Beside,
                    "mix" => Kind::Mix,
                    _ => {
                        return Err(format!(
                            "`--kind` is `{text}`, expected single, pair, several, passing, recurring, clean, foreign, beside or mix"
                        ));
                    }
                };
            }
            "--severity" => {
                let text = value()?;
                order.severity = Some(Severity::named(&text).ok_or(format!(
                    "`--severity` is `{text}`, expected trace, faint, subtle, moderate or strong"
                ))?);
            }
            "--effect" => {
                let text = value()?;
                let known = EFFECTS.iter().chain(&FOREIGN).find(|e| **e == text);
                order.effect = Some(*known.ok_or(format!(
                    "`--effect` is `{text}`, expected one of {}, or {}",
                    EFFECTS.join(", "),
                    FOREIGN.join(", ")
                ))?);
            }
            _ => return Err(format!("`{word}` is not an option of conceal")),
        }
    }
    let out = out.ok_or("no folder given, expected `--out DIR`")?;
    if let Some(effect) = order.effect {
        // A chosen effect says what kind of case it is.
        let foreign = FOREIGN.contains(&effect);
        match order.kind {
            Kind::Mix if foreign => order.kind = Kind::Foreign,
            Kind::Mix => order.kind = Kind::Single,
            Kind::Foreign if foreign => {}
            Kind::Passing if PASSING.contains(&effect) => {}
            Kind::Recurring if RECURRING.contains(&effect) => {}
            Kind::Single | Kind::Pair | Kind::Several | Kind::Beside if !foreign => {}
            _ => return Err(format!("`{effect}` does not go with that `--kind`")),
        }
    }
    Ok(Conceal {
        truth: truth.unwrap_or_else(|| out.clone()),
        order,
        count,
        out,
        sealed,
    })
}

fn whole(option: &str, text: &str) -> Result<u64, String> {
    text.parse()
        .map_err(|_| format!("`{option}` is `{text}`, expected a whole number"))
}

/// Reads how many times as viscous the mud is.
fn viscosity(text: &str) -> Result<f64, String> {
    let times: f64 = text.parse().unwrap_or(f64::NAN);
    if (0.1..=100.0).contains(&times) {
        return Ok(times);
    }
    Err(format!(
        "`--viscosity` is `{text}`, expected a number from 0.1 to 100"
    ))
}

/// Reads the length of a recording, h.
pub(crate) fn hours(text: &str) -> Result<f64, String> {
    let hours: f64 = text.parse().unwrap_or(f64::NAN);
    if hours > 0.0 && hours <= 2400.0 {
        return Ok(hours);
    }
    Err(format!(
        "`--hours` is `{text}`, expected a number up to 2400"
    ))
}

fn save(path: &Path, bytes: &[u8]) -> Result<(), String> {
    fs::write(path, bytes).map_err(|e| format!("{}: {e}", path.display()))
}

fn folder(path: &Path) -> Result<(), String> {
    fs::create_dir_all(path).map_err(|e| format!("{}: {e}", path.display()))
}

/// Writes the cases; with the seal asked for, the SHA-256 of all truths goes to standard output.
pub(crate) fn run(asked: &Conceal) -> Result<(), String> {
    folder(&asked.out)?;
    folder(&asked.truth)?;
    let mut seal = Sha256::new();
    for index in 0..asked.count {
        let case = conceal(&asked.order, index);
        let truth = write(&case, asked)?;
        seal.update(&truth);
        progress(index + 1, asked.count);
    }
    if asked.sealed {
        let text: String = seal.finalize().iter().map(|b| format!("{b:02x}")).collect();
        writeln!(io::stdout(), "{text}").map_err(|e| format!("standard output: {e}"))?;
    }
    Ok(())
}

fn write(case: &Case, asked: &Conceal) -> Result<Vec<u8>, String> {
    let recording = record(&case.plan).map_err(|e| format!("{}: {e}", case.id))?;
    let dir = asked.out.join(&case.id);
    folder(&dir)?;
    let in_memory = |e: io::Error| format!("{}: {e}", case.id);
    let mut bytes = Vec::new();
    write_case(case, &recording, &mut bytes).map_err(in_memory)?;
    save(
        &dir.join(format!("recording.{}", case.form.ending())),
        &bytes,
    )?;
    bytes.clear();
    write_case_well_toml(case, &mut bytes).map_err(in_memory)?;
    save(&dir.join("well.toml"), &bytes)?;
    let mut truth = Vec::new();
    write_truth(case, &recording, &mut truth).map_err(in_memory)?;
    save(&asked.truth.join(format!("{}.truth.json", case.id)), &truth)?;
    Ok(truth)
}
