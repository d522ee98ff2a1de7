//! Builds and runs the workspace's binaries.

use anyhow::{Context, Result, bail};
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// The workspace's folder.
pub(crate) fn root() -> PathBuf {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    here.parent().unwrap_or(here).to_owned()
}

/// Builds a package in release and gives its binary.
pub(crate) fn build(package: &str, binary: &str) -> Result<PathBuf> {
    let mut command = Command::new(env!("CARGO"));
    command.args([
        "build",
        "--release",
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
