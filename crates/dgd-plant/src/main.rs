//! `dgd-plant`: writes a stand-in recording into a folder.

use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

mod bench_command;
mod conceal_command;
mod progress;

use dgd_plant::{Plan, record, write_csv, write_provenance, write_well_toml};

const USAGE: &str = "\
Writes a simulated dual-gradient drilling recording.

usage: dgd-plant <gom|short> --out DIR [--seed N] [--hours H]
       dgd-plant conceal --out DIR [--truth DIR] [--seed N] [--count N] [--level 1|2]
                 [--kind single|pair|several|passing|recurring|clean|foreign|beside|mix] [--severity S] [--effect ID] [--hours H] [--viscosity N] [--sealed]
       dgd-plant bench --out DIR ...      (two benches that are no rig: `dgd-plant bench --help`)

  gom          four series, 305,820 samples at 1 Hz: gom1.csv .. gom4.csv
  short        one series, 7,200 samples at 1 Hz: short.csv
  --out DIR    folder to write into; made if absent
  --seed N     seed of noise and timing; default 5 for gom, 3 for short
  --hours H    another length than the preset's

Beside the series it writes well.toml and PROVENANCE.md.

  conceal      cases for the proof: DIR/cNNN/recording.mat|csv|mcap, DIR/cNNN/well.toml
  --truth DIR  folder for cNNN.truth.json; default the folder of the cases
  --count N    number of cases; default 1
  --level 1|2  clean base physics (default), or what a model meets only approximately
  --kind K     what is concealed; default mix
  --severity S trace, faint, subtle, moderate or strong; default all in turn
  --effect ID  only this effect
  --hours H    how long each recording lasts, up to 2400; default 4 to 8, as drawn
  --viscosity N how many times as viscous the mud is as drawn, 0.1 to 100; default 1. At 6, half the usual flow is laminar in nearly half of the wells
  --sealed     print the SHA-256 of all truths, one after the other

The same arguments give the same bytes.
";

struct Arguments {
    preset: String,
    out: PathBuf,
    seed: u64,
    hours: Option<f64>,
}

fn parse(mut words: impl Iterator<Item = String>) -> Result<Option<Arguments>, String> {
    let (mut preset, mut out, mut seed, mut hours) = (None, None, None, None);
    while let Some(word) = words.next() {
        let mut value = || words.next().ok_or(format!("`{word}` needs a value"));
        match word.as_str() {
            "-h" | "--help" => return Ok(None),
            "--out" => out = Some(PathBuf::from(value()?)),
            "--seed" => {
                let text = value()?;
                let n = text.parse::<u64>();
                seed =
                    Some(n.map_err(|_| format!("`--seed` is `{text}`, expected a whole number"))?);
            }
            "--hours" => hours = Some(conceal_command::hours(&value()?)?),
            "gom" | "short" if preset.is_none() => preset = Some(word),
            _ => {
                return Err(format!(
                    "`{word}` is not understood, expected gom, short or an option"
                ));
            }
        }
    }
    let preset = preset.ok_or("no preset given, expected gom or short")?;
    let out = out.ok_or("no folder given, expected `--out DIR`")?;
    let seed = seed.unwrap_or(if preset == "gom" {
        Plan::GOM_SEED
    } else {
        Plan::SHORT_SEED
    });
    Ok(Some(Arguments {
        preset,
        out,
        seed,
        hours,
    }))
}

fn write_to(
    path: &Path,
    body: impl FnOnce(&mut BufWriter<File>) -> io::Result<()>,
) -> Result<(), String> {
    let write = || {
        let mut file = BufWriter::new(File::create(path)?);
        body(&mut file)?;
        file.flush()
    };
    write().map_err(|e: io::Error| format!("{}: {e}", path.display()))
}

fn run(a: &Arguments) -> Result<(), String> {
    let mut plan = if a.preset == "gom" {
        Plan::gom(a.seed)
    } else {
        Plan::short(a.seed)
    };
    if let Some(hours) = a.hours {
        plan = plan.with_hours(hours);
    }
    let recording = record(&plan).map_err(|e| e.to_string())?;
    fs::create_dir_all(&a.out).map_err(|e| format!("{}: {e}", a.out.display()))?;
    let many = plan.series.len() > 1;
    let mut files = Vec::new();
    for (i, (&first, &count)) in recording.starts.iter().zip(&plan.series).enumerate() {
        let name = if many {
            format!("{}{}.csv", plan.name, i + 1)
        } else {
            format!("{}.csv", plan.name)
        };
        write_to(&a.out.join(&name), |f| {
            write_csv(&recording, first..first + count, f)
        })?;
        files.push(name);
    }
    write_to(&a.out.join("well.toml"), |f| write_well_toml(&plan.well, f))?;
    write_to(&a.out.join("PROVENANCE.md"), |f| {
        write_provenance(&plan, &files, f)
    })
}

fn main() -> ExitCode {
    if std::env::args().nth(1).as_deref() == Some("conceal") {
        let asked_help = std::env::args().any(|a| a == "-h" || a == "--help");
        if !asked_help {
            let done = conceal_command::parse(std::env::args().skip(2))
                .map_err(|message| format!("{message}\n\n{USAGE}"))
                .and_then(|asked| conceal_command::run(&asked));
            return match done {
                Ok(()) => ExitCode::SUCCESS,
                Err(message) => refuse(&message),
            };
        }
    }
    if std::env::args().nth(1).as_deref() == Some("bench") {
        if std::env::args().any(|a| a == "-h" || a == "--help") {
            return match io::stdout().write_all(bench_command::USAGE.as_bytes()) {
                Ok(()) => ExitCode::SUCCESS,
                Err(_) => ExitCode::FAILURE,
            };
        }
        let done = bench_command::parse(std::env::args().skip(2))
            .map_err(|message| format!("{message}\n\n{}", bench_command::USAGE))
            .and_then(|asked| bench_command::run(&asked));
        return match done {
            Ok(()) => ExitCode::SUCCESS,
            Err(message) => refuse(&message),
        };
    }
    let arguments = match parse(std::env::args().skip(1)) {
        Ok(Some(a)) => a,
        Ok(None) => {
            return match io::stdout().write_all(USAGE.as_bytes()) {
                Ok(()) => ExitCode::SUCCESS,
                Err(_) => ExitCode::FAILURE,
            };
        }
        Err(message) => return refuse(&format!("{message}\n\n{USAGE}")),
    };
    match run(&arguments) {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => refuse(&message),
    }
}

fn refuse(message: &str) -> ExitCode {
    // Nothing is left to do if even the message cannot be written.
    let _ = writeln!(io::stderr(), "dgd-plant: {message}");
    ExitCode::from(2)
}
