//! Arrows point down only: a crate may use crates of lower floors, and the base its own floor.
//!
//! Each crate says its floor in `[package.metadata.dgd]`. Development dependencies are exempt:
//! a test may hold a crate against any other.

use anyhow::{Context, Result, bail};
use serde_json::Value;
use std::collections::BTreeMap;
use std::process::Command;

/// From the ground up.
const FLOORS: &[&str] = &[
    "base", "dynamics", "estimate", "identify", "know", "use", "edge", "entry",
];
/// Stands apart: uses nothing of the house, and only tests may use it.
const APART: &str = "proof";

/// Checks every dependency of the workspace, and prints the house.
pub(crate) fn check() -> Result<()> {
    let crates = read_workspace()?;
    let wrong: Vec<String> = crates
        .iter()
        .flat_map(|(name, member)| {
            member
                .uses
                .iter()
                .filter_map(|used| objection(&crates, name, used))
        })
        .collect();
    for floor in FLOORS.iter().rev().chain([&APART]) {
        let here: Vec<&str> = crates
            .iter()
            .filter(|(_, c)| c.floor == *floor)
            .map(|(n, _)| n.as_str())
            .collect();
        if !here.is_empty() {
            println!("{floor:>9}  {}", here.join(" "));
        }
    }
    if wrong.is_empty() {
        println!("{} crates, every dependency points down", crates.len());
        return Ok(());
    }
    bail!("{}", wrong.join("\n"))
}

struct Member {
    floor: String,
    uses: Vec<String>,
}

fn read_workspace() -> Result<BTreeMap<String, Member>> {
    let output = Command::new(env!("CARGO"))
        .args([
            "metadata",
            "--format-version",
            "1",
            "--no-deps",
            "--offline",
        ])
        .output()
        .context("cannot run `cargo metadata`")?;
    let metadata: Value =
        serde_json::from_slice(&output.stdout).context("cannot read what `cargo metadata` said")?;
    let packages = metadata["packages"]
        .as_array()
        .context("`cargo metadata` lists no packages")?;
    let names: Vec<&str> = packages.iter().filter_map(|p| p["name"].as_str()).collect();
    packages
        .iter()
        .map(|package| {
            let name = package["name"]
                .as_str()
                .context("a package without a name")?;
            let floor = package["metadata"]["dgd"]["floor"].as_str();
            let floor = floor
                .with_context(|| format!("{name} has no `floor` in [package.metadata.dgd]"))?;
            if floor != APART && !FLOORS.contains(&floor) {
                bail!("{name} is on the floor `{floor}`, expected one of {FLOORS:?} or `{APART}`");
            }
            let dependencies = package["dependencies"].as_array().into_iter().flatten();
            let uses = dependencies
                .filter(|d| d["kind"].as_str() != Some("dev"))
                .filter_map(|d| d["name"].as_str())
                .filter(|d| names.contains(d))
                .map(str::to_owned)
                .collect();
            Ok((
                name.to_owned(),
                Member {
                    floor: floor.to_owned(),
                    uses,
                },
            ))
        })
        .collect()
}

/// Why `name` must not use `used`.
fn objection(crates: &BTreeMap<String, Member>, name: &str, used: &str) -> Option<String> {
    let (user, other) = (&crates[name].floor, &crates[used].floor);
    if user == APART || other == APART {
        return Some(format!(
            "{name} uses {used}: the plant stands apart, only tests may link it"
        ));
    }
    let height = |floor: &str| FLOORS.iter().position(|f| *f == floor);
    let down = height(other) < height(user);
    let within_base = user == "base" && other == "base";
    (!down && !within_base)
        .then(|| format!("{name} ({user}) uses {used} ({other}): dependencies point down only"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn house(edges: &[(&str, &str, &[&str])]) -> BTreeMap<String, Member> {
        edges
            .iter()
            .map(|(name, floor, uses)| {
                let uses = uses.iter().map(|u| (*u).to_owned()).collect();
                (
                    (*name).to_owned(),
                    Member {
                        floor: (*floor).to_owned(),
                        uses,
                    },
                )
            })
            .collect()
    }

    #[test]
    fn upward_and_sideways_edges_are_refused_and_downward_ones_are_not() {
        let crates = house(&[
            ("low", "base", &[]),
            ("mid", "estimate", &[]),
            ("peer", "estimate", &[]),
            ("top", "edge", &[]),
        ]);
        assert!(objection(&crates, "top", "low").is_none());
        assert!(objection(&crates, "low", "top").is_some());
        assert!(objection(&crates, "mid", "peer").is_some());
        assert!(objection(&crates, "low", "low").is_none());
    }

    #[test]
    fn nobody_may_use_the_plant_and_it_uses_nobody() {
        let crates = house(&[
            ("plant", "proof", &[]),
            ("cli", "entry", &[]),
            ("low", "base", &[]),
        ]);
        assert!(objection(&crates, "cli", "plant").is_some());
        assert!(objection(&crates, "plant", "low").is_some());
    }

    #[test]
    fn this_workspace_keeps_the_rule() {
        check().unwrap_or_else(|error| panic!("{error}"));
    }
}
