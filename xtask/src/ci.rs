//! `cargo xtask ci`: the same script that guards submissions, then the short proof.

use crate::{prove, tools};
use anyhow::Result;
use std::process::Command;

/// Runs `.ci/run`, then proves in the short form: broken rules fail, scores are only printed.
pub(crate) fn run() -> Result<()> {
    tools::run(
        Command::new("bash")
            .arg(".ci/run")
            .current_dir(tools::root()),
    )?;
    prove::run(prove::Settings::short(
        tools::root().join("target/proof-short"),
    ))
}
