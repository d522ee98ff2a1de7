//! Builds and runs the workspace's binaries.

use anyhow::{Context, Result, bail};
use serde_json::Value;
use std::fs::File;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// The workspace's folder.
pub(crate) fn root() -> PathBuf {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    here.parent().unwrap_or(here).to_owned()
}

/// Builds a package in release and gives its binary.
pub(crate) fn build(package: &str, binary: &str) -> Result<PathBuf> {
    build_as("release", package, binary)
}

/// Builds a package as tests do and gives its binary.
pub(crate) fn build_debug(package: &str, binary: &str) -> Result<PathBuf> {
    build_as("dev", package, binary)
}

fn build_as(profile: &str, package: &str, binary: &str) -> Result<PathBuf> {
    let mut command = Command::new(env!("CARGO"));
    command.args([
        "build",
        "--profile",
        profile,
        "--quiet",
        "--package",
        package,
        "--message-format",
        "json",
    ]);
    command.current_dir(root()).stderr(Stdio::inherit());
    let output = command
        .output()
        .with_context(|| format!("cannot build {package}"))?;
    if !output.status.success() {
        bail!("building {package} failed");
    }
    let messages = String::from_utf8_lossy(&output.stdout);
    let artefacts = messages
        .lines()
        .filter_map(|line| serde_json::from_str::<Value>(line).ok());
    let executables = artefacts.filter(|a| a["target"]["name"] == binary);
    let path = executables
        .filter_map(|a| a["executable"].as_str().map(PathBuf::from))
        .next_back();
    path.with_context(|| format!("cargo built no binary `{binary}`"))
}

/// Writes a file beside its place and renames it: a page is whole or the old one.
pub(crate) fn replace(path: &Path, bytes: impl AsRef<[u8]>) -> Result<()> {
    let folder = match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    };
    let write = || -> std::io::Result<()> {
        // Under one name a file, so that the next run writes over what a killed one left.
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let hidden = folder.join(format!(".{name}.part"));
        let mut file = File::create(&hidden)?;
        let written = file
            .write_all(bytes.as_ref())
            .and_then(|()| file.sync_all());
        let placed = written.and_then(|()| std::fs::rename(&hidden, path));
        placed.inspect_err(|_| {
            let _ = std::fs::remove_file(&hidden);
        })
    };
    write().with_context(|| format!("cannot write {}", path.display()))
}

/// Runs a command; its failure is an error.
pub(crate) fn run(command: &mut Command) -> Result<()> {
    let status = command
        .status()
        .with_context(|| format!("cannot run {command:?}"))?;
    if !status.success() {
        bail!("{command:?} ended with {status}");
    }
    Ok(())
}

/// Runs a command and reads the JSON it prints.
pub(crate) fn run_json(command: &mut Command) -> Result<Value> {
    let output = command
        .stderr(Stdio::inherit())
        .output()
        .with_context(|| format!("cannot run {command:?}"))?;
    if !output.status.success() {
        bail!("{command:?} ended with {}", output.status);
    }
    serde_json::from_slice(&output.stdout).with_context(|| format!("{command:?} printed no JSON"))
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test may fail by panic")]
mod tests {
    use super::*;

    #[test]
    fn a_page_that_cannot_take_its_place_leaves_nothing_beside_it() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("proof.html");
        // Left by a killed run.
        std::fs::write(folder.path().join(".proof.html.part"), "half").unwrap();
        replace(&path, "whole").unwrap();
        assert_eq!(std::fs::read_to_string(&path).unwrap(), "whole");
        std::fs::remove_file(&path).unwrap();
        std::fs::create_dir(&path).unwrap();
        let failed = replace(&path, "again").unwrap_err().to_string();
        assert!(failed.contains("proof.html"), "{failed}");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
    }
}
