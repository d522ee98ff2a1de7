//! Runs `dgd diagnose --system` on each case, in a folder that holds the recording, its description and nothing else.

use super::Settings;
use super::answer::{Answer, Off, held_out};
use crate::prove::batch;
use anyhow::{Context, Result, bail};
use std::collections::BTreeMap;
use std::fs::{self, File};
use std::path::Path;
use std::process::{Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};

/// A run of more than this is stopped, s.
pub(crate) const PATIENCE_S: u64 = 1800;

/// What a run left behind; read before any truth is opened.
#[derive(Default)]
pub(crate) struct Exam {
    pub(crate) answer: Option<Answer>,
    pub(crate) held_out: BTreeMap<String, Off>,
    pub(crate) broken: Vec<String>,
    pub(crate) wall_s: f64,
}

/// Diagnoses all cases; results in their order, however many run at a time.
pub(crate) fn all(dgd: &Path, settings: &Settings, todo: &[(&'static str, String)]) -> Vec<Exam> {
    batch::each(settings.jobs, todo, "", |(bench, id)| {
        let mut exam = Exam::default();
        if let Err(error) = sit(dgd, settings, bench, id, &mut exam) {
            exam.broken.push(format!("{error:#}"));
        }
        exam
    })
}

fn sit(dgd: &Path, settings: &Settings, bench: &str, id: &str, exam: &mut Exam) -> Result<()> {
    let folder = tempfile::tempdir().context("cannot make a temporary folder")?;
    let case = settings.out.join("cases").join(bench).join(id);
    for name in ["recording.csv", "system.toml"] {
        let from = case.join(name);
        fs::copy(&from, folder.path().join(name))
            .with_context(|| format!("cannot copy {}", from.display()))?;
    }
    let answers = settings.out.join("answers").join(bench);
    fs::create_dir_all(&answers).with_context(|| format!("cannot make {}", answers.display()))?;
    let (out, log) = (answers.join(id), answers.join(format!("{id}.log")));
    let file = File::create(&log).with_context(|| format!("cannot write {}", log.display()))?;
    let mut command = Command::new(dgd);
    command
        .args([
            "diagnose",
            "recording.csv",
            "--system",
            "system.toml",
            "--out",
        ])
        .arg(&out)
        .current_dir(folder.path())
        .stdin(Stdio::null())
        .stdout(file.try_clone().context("cannot share the log")?)
        .stderr(file);
    let begun = Instant::now();
    let status = patiently(&mut command)?;
    exam.wall_s = begun.elapsed().as_secs_f64();
    if !status.success() {
        let text = fs::read_to_string(&log).unwrap_or_default();
        let line = text
            .lines()
            .rfind(|l| !l.trim().is_empty())
            .unwrap_or("no word");
        bail!("dgd diagnose: {status}: {}", line.trim());
    }
    let bytes = fs::read(out.join("diagnosis.json")).context("diagnosis.json")?;
    exam.answer = Some(Answer::read(&bytes)?);
    let table = out.join("simulation.csv");
    exam.held_out = held_out(&fs::read_to_string(&table).context("simulation.csv")?)?;
    if !settings.keep {
        // All that is asked of it is known by now.
        let _ = fs::remove_file(table);
    }
    Ok(())
}

/// Waits for the end, but not for ever.
fn patiently(command: &mut Command) -> Result<ExitStatus> {
    let mut child = command
        .spawn()
        .with_context(|| format!("cannot run {command:?}"))?;
    let begun = Instant::now();
    while begun.elapsed() < Duration::from_secs(PATIENCE_S) {
        if let Some(status) = child.try_wait().context("cannot wait for dgd")? {
            return Ok(status);
        }
        std::thread::sleep(Duration::from_millis(50));
    }
    let _ = child.kill();
    let _ = child.wait();
    bail!("dgd diagnose: not done after {PATIENCE_S} s")
}
