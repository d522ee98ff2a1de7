//! The page of commands, and their help.

use super::benches;
use crate::bench::Bench;

#[test]
fn every_command_of_the_page_runs() {
    let page = include_str!("../../../SYSTEMS.md");
    let bench = benches();
    let commands: Vec<&str> = page
        .lines()
        .filter_map(|l| l.strip_prefix("$ dgd "))
        .collect();
    assert!(commands.len() > 8);
    for command in commands {
        bench.dgd(command).done();
    }
    // The description on the page is the one that was run.
    let shown = page
        .split("```toml\n")
        .nth(1)
        .unwrap()
        .split("```")
        .next()
        .unwrap();
    assert!(bench.text("two_tanks.toml").contains(shown.trim()));
}

#[test]
fn help_of_each_command_has_examples_with_a_system() {
    let bench = Bench::bare();
    for command in [
        "diagnose",
        "fit",
        "simulate",
        "linearise",
        "sensitivities",
        "system check",
    ] {
        let said = bench.dgd(&format!("{command} --help")).done();
        assert!(
            said.contains("Examples:") && said.contains("system"),
            "{command}"
        );
    }
}
