//! Runs `dgd diagnose` on one case, in a folder that holds the recording and nothing else.

use super::answer::Answer;
use super::simulation::Simulation;
use super::targets::PATIENCE_S;
use anyhow::{Context, Result, bail};
use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::{Command, ExitStatus, Stdio};
use std::sync::mpsc;
use std::time::{Duration, Instant};

/// What a run left behind; read before any truth is opened.
#[derive(Default)]
pub(crate) struct Exam {
    pub(crate) answer: Option<Answer>,
    pub(crate) simulation: Option<Simulation>,
    pub(crate) broken: Vec<String>,
    pub(crate) wall_s: f64,
    pub(crate) peak_mib: Option<f64>,
}

/// Where GNU time is, if it is here: it knows the peak memory.
pub(crate) fn gnu_time() -> Option<PathBuf> {
    let path = PathBuf::from("/usr/bin/time");
    let tried = Command::new(&path).args(["-f", "%M", "true"]).output();
    let text = tried.ok().filter(|o| o.status.success())?.stderr;
    let kib = String::from_utf8_lossy(&text).trim().parse::<f64>();
    kib.is_ok().then_some(path)
}

/// A case to be diagnosed.
pub(crate) struct Paper {
    /// Folder with the recording and its well description.
    pub(crate) case: PathBuf,
    /// Folder for the answer.
    pub(crate) out: PathBuf,
    /// Further options of `dgd diagnose`.
    pub(crate) options: Vec<String>,
    /// What is held against the rules.
    pub(crate) scope: Scope,
}

/// How much of an answer is read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Scope {
    /// Everything that is written; the simulation is kept or not.
    Whole { keep: bool },
    /// `diagnosis.json` and the simulation, which is not kept.
    Fit,
    /// `diagnosis.json` alone.
    Names,
}

/// Diagnoses a case; whatever goes wrong is a broken rule, not an error.
pub(crate) fn sit(dgd: &Path, time: Option<&Path>, paper: &Paper) -> Exam {
    let mut exam = Exam::default();
    if let Err(error) = attempt(dgd, time, paper, &mut exam) {
        exam.broken.push(format!("{error:#}"));
        return exam;
    }
    let out = &paper.out;
    match fs::read(out.join("diagnosis.json")) {
        Ok(bytes) => match Answer::read(&bytes) {
            Ok((answer, wrong)) => {
                exam.answer = Some(answer);
                exam.broken.extend(wrong);
            }
            Err(error) => exam.broken.push(format!("{error:#}")),
        },
        Err(error) => exam.broken.push(format!("diagnosis.json: {error}")),
    }
    let table = out.join("simulation.csv");
    if paper.scope != Scope::Names {
        match fs::read_to_string(&table) {
            Ok(text) => match Simulation::read(&text) {
                Ok(simulation) => exam.simulation = Some(simulation),
                Err(error) => exam.broken.push(format!("{error:#}")),
            },
            Err(error) => exam.broken.push(format!("simulation.csv: {error}")),
        }
    }
    if let Scope::Whole { .. } = paper.scope {
        exam.broken.extend(report(&out.join("report.html")));
    }
    if paper.scope != (Scope::Whole { keep: true }) {
        // Megabytes a case, and all that is asked of it is known by now.
        let _ = fs::remove_file(table);
    }
    exam
}

fn attempt(dgd: &Path, time: Option<&Path>, paper: &Paper, exam: &mut Exam) -> Result<()> {
    let folder = tempfile::tempdir().context("cannot make a temporary folder")?;
    let recording = copy(&paper.case, folder.path())?;
    let out = &paper.out;
    let parent = out.parent().context("no folder for answers")?;
    fs::create_dir_all(parent).with_context(|| format!("cannot make {}", parent.display()))?;
    let (log, peak) = (out.with_extension("log"), out.with_extension("peak"));
    let mut command = match time {
        Some(time) => {
            let mut command = Command::new(time);
            command.args(["-f", "%M", "-o"]).arg(&peak).arg(dgd);
            command
        }
        None => Command::new(dgd),
    };
    let recording = folder.path().join(recording);
    command.arg("diagnose").arg(&recording);
    command.arg("--well").arg(folder.path().join("well.toml"));
    command.arg("--out").arg(out).args(&paper.options);
    command.current_dir(folder.path());
    let file = File::create(&log).with_context(|| format!("cannot write {}", log.display()))?;
    command
        .stdin(Stdio::null())
        .stdout(file.try_clone().context("cannot share the log")?)
        .stderr(file);
    let begun = Instant::now();
    let status = patiently(&mut command)?;
    exam.wall_s = begun.elapsed().as_secs_f64();
    let text = fs::read_to_string(&peak).unwrap_or_default();
    let kib = text
        .lines()
        .last()
        .and_then(|l| l.trim().parse::<f64>().ok());
    exam.peak_mib = kib.map(|kib| kib / 1024.0);
    let _ = fs::remove_file(peak);
    if !status.success() {
        let text = fs::read_to_string(&log).unwrap_or_default();
        bail!("dgd diagnose: {status}: {}", last_words(&text));
    }
    if let Scope::Whole { .. } = paper.scope
        && let Some(word) = unreadable(dgd, folder.path(), &recording, &out.join("model.toml"))
    {
        exam.broken.push(word);
    }
    Ok(())
}

/// Why `dgd simulate` does not run the model that was written; `None` if it does.
fn unreadable(dgd: &Path, folder: &Path, recording: &Path, model: &Path) -> Option<String> {
    let mut command = Command::new(dgd);
    command.arg("simulate").arg(recording).arg("--well");
    command
        .arg(folder.join("well.toml"))
        .arg("--model")
        .arg(model);
    command.arg("--out").arg(folder.join("simulated.csv"));
    match command.stdin(Stdio::null()).output() {
        Ok(output) if output.status.success() => None,
        Ok(output) => {
            let text = String::from_utf8_lossy(&output.stderr);
            let word = last_words(&text);
            Some(format!(
                "model.toml: dgd simulate: {}: {word}",
                output.status
            ))
        }
        Err(error) => Some(format!("model.toml: dgd simulate: {error}")),
    }
}

/// Copies the recording and its well description; gives the recording's name.
fn copy(case: &Path, folder: &Path) -> Result<String> {
    let entries = fs::read_dir(case).with_context(|| format!("cannot read {}", case.display()))?;
    let mut recording = None;
    for entry in entries {
        let entry = entry.with_context(|| format!("cannot read {}", case.display()))?;
        let name = entry.file_name().to_string_lossy().into_owned();
        if name.starts_with("recording.") || name == "well.toml" {
            fs::copy(entry.path(), folder.join(&name))
                .with_context(|| format!("cannot copy {}", entry.path().display()))?;
        }
        if name.starts_with("recording.") {
            recording = Some(name);
        }
    }
    recording.with_context(|| format!("no recording in {}", case.display()))
}

/// Waits for the end, but not for ever.
fn patiently(command: &mut Command) -> Result<ExitStatus> {
    #[cfg(unix)]
    {
        use std::os::unix::process::CommandExt;
        // A group of its own, so that what GNU time started can be stopped with it.
        command.process_group(0);
    }
    let mut child = command
        .spawn()
        .with_context(|| format!("cannot run {command:?}"))?;
    let id = child.id();
    let (sender, receiver) = mpsc::channel();
    std::thread::spawn(move || sender.send(child.wait()));
    match receiver.recv_timeout(Duration::from_secs(PATIENCE_S)) {
        Ok(status) => status.context("cannot wait for dgd"),
        Err(_) => {
            stop(id);
            let _ = receiver.recv_timeout(Duration::from_secs(5));
            bail!("dgd diagnose: not done after {PATIENCE_S} s")
        }
    }
}

fn stop(id: u32) {
    let group = format!("-{id}");
    let killed = Command::new("kill").args(["-KILL", "--", &group]).status();
    let _: Option<ExitStatus> = killed.ok();
}

/// The last line that says something, of bounded length.
fn last_words(text: &str) -> String {
    let line = text.lines().rfind(|l| !l.trim().is_empty());
    line.unwrap_or("no word").trim().chars().take(300).collect()
}

/// The report must be there, and need no network.
fn report(path: &Path) -> Option<String> {
    match fs::read_to_string(path) {
        Ok(text) => foreign_part(&text).map(|p| format!("report.html fetches something: `{p}`")),
        Err(error) => Some(format!("report.html: {error}")),
    }
}

/// What a page would fetch from elsewhere; links to be followed by hand are none of it.
fn foreign_part(html: &str) -> Option<&'static str> {
    const FETCHES: [&str; 6] = [
        "src=\"http",
        "src=\"//",
        "url(http",
        "@import",
        "<link",
        "<iframe",
    ];
    FETCHES.into_iter().find(|part| html.contains(part))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may")]
    use super::*;

    #[test]
    fn only_recording_and_well_are_copied() {
        let (case, copied) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
        for name in ["recording.csv", "well.toml", "c000.truth.json", "notes"] {
            fs::write(case.path().join(name), name).unwrap();
        }
        assert_eq!(copy(case.path(), copied.path()).unwrap(), "recording.csv");
        let mut names: Vec<_> = fs::read_dir(copied.path())
            .unwrap()
            .map(|e| e.unwrap().file_name())
            .collect();
        names.sort();
        assert_eq!(names, ["recording.csv", "well.toml"]);
        assert!(copy(&case.path().join("absent"), copied.path()).is_err());
    }

    #[test]
    fn a_report_that_fetches_is_not_self_contained_and_one_that_links_is() {
        assert!(foreign_part("<img src=\"https://example.org/x.png\">").is_some());
        assert!(foreign_part("<link rel=stylesheet href=x.css>").is_some());
        assert!(foreign_part("<a href=\"https://doi.org/1\">x</a><svg></svg>").is_none());
    }

    #[test]
    #[cfg(unix)]
    fn a_run_that_fails_is_a_broken_rule_with_its_last_words() {
        let (case, out) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
        fs::write(case.path().join("recording.csv"), "t\ns\n").unwrap();
        // Any program that does not know `diagnose` will do.
        let paper = Paper {
            case: case.path().to_owned(),
            out: out.path().join("c000"),
            options: Vec::new(),
            scope: Scope::Whole { keep: false },
        };
        let exam = sit(Path::new("/bin/ls"), None, &paper);
        assert!(exam.answer.is_none());
        assert_eq!(exam.broken.len(), 1);
        assert!(exam.broken[0].starts_with("dgd diagnose: exit status"));
        assert_eq!(last_words("first\n  the reason \n\n"), "the reason");
        assert_eq!(last_words(&"x".repeat(1000)).len(), 300);
        assert_eq!(last_words("\n"), "no word");
    }
}
