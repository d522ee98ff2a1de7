//! `dgd-plant bench`: writes cases of the two benches and their truths.

use crate::progress::progress;
use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use dgd_plant::bench::{
    Bench, Case, Kind, Order, Severity, draw, simulate, write_csv, write_truth,
};
use sha2::{Digest, Sha256};

pub(crate) const USAGE: &str = "\
usage: dgd-plant bench --out DIR [--truth DIR] [--bench NAME] [--seed N] [--count N]
                 [--kind single|clean|foreign|mix] [--severity S] [--thing NAME] [--sealed]

Writes cases of two benches that are no rig: DIR/NAME/cNNN/recording.csv with DIR/NAME/cNNN/system.toml.

  --out DIR      folder to write into; made if absent
  --truth DIR    folder for NAME/cNNN.truth.json; default the folder of the cases
  --bench NAME   surge-shaft or glycol-loop; default both
  --seed N       default 1
  --count N      cases of each bench; default 1; forty hold each thing in each severity once
  --kind K       what is concealed; default mix: of five cases three single, one clean, one foreign
  --severity S   subtle, moderate or strong; default all in turn
  --thing NAME   only this one, such as crest_overflow; needs --bench
  --sealed       print the SHA-256 of all truths, one after the other

example: dgd-plant bench --out work --bench surge-shaft --thing crest_overflow --severity strong

The same arguments give the same bytes.
";

/// What the command is asked for.
pub(crate) struct Asked {
    benches: Vec<Bench>,
    seed: u64,
    kind: Kind,
    severity: Option<Severity>,
    thing: Option<&'static str>,
    count: usize,
    out: PathBuf,
    truth: PathBuf,
    sealed: bool,
}

/// Reads the words after `bench`.
pub(crate) fn parse(mut words: impl Iterator<Item = String>) -> Result<Asked, String> {
    let (mut out, mut truth, mut thing, mut bench) = (None, None, None, None);
    let (mut seed, mut count, mut kind, mut severity, mut sealed) = (1, 1, Kind::Mix, None, false);
    while let Some(word) = words.next() {
        if word == "--sealed" {
            sealed = true;
            continue;
        }
        let mut value = || words.next().ok_or(format!("`{word}` needs a value"));
        let whole = |text: String| {
            let number: Result<u64, _> = text.parse();
            number.map_err(|_| format!("`{word}` is `{text}`, expected a whole number"))
        };
        match word.as_str() {
            "--out" => out = Some(PathBuf::from(value()?)),
            "--truth" => truth = Some(PathBuf::from(value()?)),
            "--seed" => seed = whole(value()?)?,
            "--count" => {
                count = usize::try_from(whole(value()?)?.min(100_000)).unwrap_or(100_000);
            }
            "--bench" => {
                let text = value()?;
                bench = Some(Bench::named(&text).ok_or(format!(
                    "`--bench` is `{text}`, expected surge-shaft or glycol-loop"
                ))?);
            }
            "--kind" => {
                let text = value()?;
                kind = match text.as_str() {
                    "single" => Kind::Single,
                    "clean" => Kind::Clean,
                    "foreign" => Kind::Foreign,
                    "mix" => Kind::Mix,
                    _ => {
                        return Err(format!(
                            "`--kind` is `{text}`, expected single, clean, foreign or mix"
                        ));
                    }
                };
            }
            "--severity" => {
                let text = value()?;
                severity = Some(Severity::named(&text).ok_or(format!(
                    "`--severity` is `{text}`, expected subtle, moderate or strong"
                ))?);
            }
            "--thing" => thing = Some(value()?),
            _ => return Err(format!("`{word}` is not an option of bench")),
        }
    }
    let out = out.ok_or("no folder given, expected `--out DIR`")?;
    let mut chosen = None;
    if let Some(text) = thing {
        let bench = bench.ok_or("`--thing` needs `--bench`")?;
        let (things, foreign) = (bench.things(), bench.foreign());
        let find = |names: &[&'static str]| names.iter().copied().find(|n| *n == text);
        // A chosen thing says what kind of case it is.
        let (known, own) = match (find(&things), find(&foreign)) {
            (Some(name), _) => (name, Kind::Single),
            (None, Some(name)) => (name, Kind::Foreign),
            (None, None) => {
                return Err(format!(
                    "`--thing` is `{text}`, expected one of {}, {}",
                    things.join(", "),
                    foreign.join(", ")
                ));
            }
        };
        if kind != Kind::Mix && kind != own {
            return Err(format!("`{text}` does not go with that `--kind`"));
        }
        (kind, chosen) = (own, Some(known));
    }
    Ok(Asked {
        benches: bench.map_or(Bench::ALL.to_vec(), |b| vec![b]),
        truth: truth.unwrap_or_else(|| out.clone()),
        thing: chosen,
        seed,
        kind,
        severity,
        count,
        out,
        sealed,
    })
}

fn save(path: &Path, bytes: &[u8]) -> Result<(), String> {
    fs::write(path, bytes).map_err(|e| format!("{}: {e}", path.display()))
}

fn folder(path: &Path) -> Result<(), String> {
    fs::create_dir_all(path).map_err(|e| format!("{}: {e}", path.display()))
}

/// Writes the cases; with the seal asked for, the SHA-256 of all truths goes to standard output.
pub(crate) fn run(asked: &Asked) -> Result<(), String> {
    let mut seal = Sha256::new();
    let (mut done, all) = (0, asked.benches.len() * asked.count);
    for &bench in &asked.benches {
        let order = Order {
            bench,
            seed: asked.seed,
            kind: asked.kind,
            severity: asked.severity,
            thing: asked.thing,
        };
        folder(&asked.truth.join(bench.name()))?;
        for index in 0..asked.count {
            seal.update(write(&draw(&order, index), asked)?);
            done += 1;
            progress(done, all);
        }
    }
    if asked.sealed {
        let text: String = seal.finalize().iter().map(|b| format!("{b:02x}")).collect();
        writeln!(io::stdout(), "{text}").map_err(|e| format!("standard output: {e}"))?;
    }
    Ok(())
}

fn write(case: &Case, asked: &Asked) -> Result<Vec<u8>, String> {
    let record = simulate(case);
    let dir = asked.out.join(case.bench.name()).join(&case.id);
    folder(&dir)?;
    let in_memory = |e: io::Error| format!("{}: {e}", case.id);
    let mut bytes = Vec::new();
    write_csv(case, &record, &mut bytes).map_err(in_memory)?;
    save(&dir.join("recording.csv"), &bytes)?;
    save(
        &dir.join("system.toml"),
        case.bench.system_toml().as_bytes(),
    )?;
    let mut truth = Vec::new();
    write_truth(case, &record, &mut truth).map_err(in_memory)?;
    let path = asked.truth.join(case.bench.name());
    save(&path.join(format!("{}.truth.json", case.id)), &truth)?;
    Ok(truth)
}
