//! `cargo xtask figures`: the thesis's pipeline, stage by stage through `dgd`, on the stand-in recording.

use crate::tools::{self, run_json};
use anyhow::{Context, Result};
use serde_json::Value;
use std::fmt::Write as _;
use std::path::Path;
use std::process::Command;

/// The stand-in's seed, chosen as the nearest to the thesis of the first eight (crates/dgd-plant/README.md tells what
/// others give).
const SEED: &str = "5";
/// Window of Figures 4.1-4.4 in the thesis, s.
const WINDOW: &str = "14000:20000";
/// What stands above the rows of the comparison.
const HEAD: &str = "# The thesis's ladder on the stand-in recording\n\n\
    The thesis's field data are confidential. The right-hand column comes from a **stand-in**: a simulated rig of\n\
    higher fidelity than the model (`dgd-plant`), calibrated so that the same effects appear. Its agreement with\n\
    the thesis shows that the pipeline does what the thesis did; it says nothing about the field. Its seed (5) was\n\
    chosen as the nearest to the thesis of the first eight; `crates/dgd-plant/README.md` tells what others give.\n\
    The thesis gives its errors in percent of undisclosed references, so errors are compared as ratios.\n\n\
    | quantity | thesis | stand-in |\n|---|---|---|\n";

/// Makes the recording, fits, simulates, draws and compares.
pub(crate) fn draw(out: &Path) -> Result<()> {
    let dgd = tools::build("dgd-cli", "dgd")?;
    let plant = tools::build("dgd-plant", "dgd-plant")?;
    let data = out.join("data");
    std::fs::create_dir_all(&data).with_context(|| format!("cannot make {}", data.display()))?;

    println!("1/5 recording the stand-in (305,820 samples)");
    tools::run(
        Command::new(plant)
            .args(["gom", "--seed", SEED, "--out"])
            .arg(&data),
    )?;
    let series: Vec<_> = (1..=4).map(|n| data.join(format!("gom{n}.csv"))).collect();
    let (well, model) = (data.join("well.toml"), out.join("model.toml"));

    println!("2/5 inspecting");
    let inspected = run_json(
        Command::new(&dgd)
            .arg("inspect")
            .arg(&series[0])
            .arg("--json"),
    )?;
    println!("3/5 identifying; Figures 3.2-3.7, 3.9-3.11");
    let fitted = run_json(
        Command::new(&dgd)
            .arg("fit")
            .args(&series)
            .args(["--thesis-screening", "--json", "--well"])
            .arg(&well)
            .arg("--out")
            .arg(&model)
            .arg("--figures")
            .arg(out),
    )?;
    println!("4/5 simulating; Figures 4.1-4.4");
    let simulate = |kind: &str, figures: bool| {
        let mut command = Command::new(&dgd);
        command
            .arg("simulate")
            .arg(&series[0])
            .args(["--window", WINDOW, "--kind", kind, "--json", "--well"]);
        command
            .arg(&well)
            .arg("--model")
            .arg(&model)
            .arg("--out")
            .arg(data.join(format!("{kind}.csv")));
        if figures {
            command.arg("--figures").arg(out);
        }
        run_json(&mut command)
    };
    let runs = Runs {
        coupled: simulate("coupled", true)?,
        riser: simulate("riser", false)?,
        flow: simulate("flow", false)?,
        steady: simulate("steady", false)?,
    };
    println!("5/5 comparing");
    let table = compare(&inspected, &fitted, &runs)?;
    let page = out.join("comparison.md");
    tools::replace(&page, &table)?;
    println!(
        "\n{table}\nfigures and comparison.md are in {}",
        out.display()
    );
    Ok(())
}

struct Runs {
    coupled: Value,
    riser: Value,
    flow: Value,
    steady: Value,
}

/// The thesis's numbers beside the stand-in's.
fn compare(inspected: &Value, fitted: &Value, runs: &Runs) -> Result<String> {
    let mut text = String::from(HEAD);
    text.push_str(&screening(fitted)?);
    text.push_str(&friction(fitted)?);
    text.push_str(&pump(fitted)?);
    text.push_str(&simulated(runs)?);
    let seconds = number(fitted, "/seconds")?;
    let columns = inspected["columns"].as_array().map_or(0, Vec::len);
    writeln!(
        text,
        "\n{columns} columns a series; the fit took {seconds:.2} s, figures included."
    )?;
    Ok(text)
}

fn screening(fitted: &Value) -> Result<String> {
    let kept = number(fitted, "/kept")?;
    let measured = number(fitted, "/samples")?;
    let rows = [
        row("samples", "305,820", &format!("{measured:.0}")),
        row(
            "kept by the screening",
            "52,579 (17.2 %)",
            &format!("{kept:.0} ({:.1} %)", 100.0 * kept / measured),
        ),
    ];
    Ok(rows.concat())
}

fn friction(fitted: &Value) -> Result<String> {
    let (f14, f23, f26) = (
        "/friction/eq_3_14",
        "/friction/eq_3_23",
        "/friction/eq_3_26",
    );
    let mse = |stage: &str| number(fitted, &format!("{stage}/mse_pa2"));
    let coefficient =
        |stage: &str, index: usize| number(fitted, &format!("{stage}/coefficients/{index}"));
    let rows = [
        row("C in Eq. 3.14", "negative", sign(coefficient(f14, 0)?)),
        row(
            "best delay (Eq. 3.24)",
            "13 s",
            &format!("{} s", number(fitted, "/delay/best_s")?),
        ),
        row(
            "MSE of 3.23 over that of 3.14",
            "0.676 (14.79 / 21.89)",
            &format!("{:.3}", mse(f23)? / mse(f14)?),
        ),
        row("C in Eq. 3.23", "negative", sign(coefficient(f23, 0)?)),
        row(
            "MSE of 3.26 over that of 3.23",
            "0.988 (14.61 / 14.79)",
            &format!("{:.3}", mse(f26)? / mse(f23)?),
        ),
        row(
            "D and E in Eq. 3.26",
            "positive, positive",
            &format!(
                "{}, {}",
                sign(coefficient(f26, 1)?),
                sign(coefficient(f26, 2)?)
            ),
        ),
    ];
    Ok(rows.concat())
}

fn pump(fitted: &Value) -> Result<String> {
    let head = |stage: &str| number(fitted, &format!("/pump/{stage}/mse_m2"));
    let rows = [
        row(
            "c2 in Eq. 3.31, unconstrained",
            "negative",
            sign(number(fitted, "/pump/eq_3_31/c/2")?),
        ),
        row(
            "MSE of 3.39 over that of 3.31",
            "0.051 (0.071 / 1.3907)",
            &format!("{:.3}", head("eq_3_39")? / head("eq_3_31")?),
        ),
        row(
            "exponents n0, n2",
            "not given",
            &format!(
                "{:.3}, {:.3}",
                number(fitted, "/pump/eq_3_39/n0")?,
                number(fitted, "/pump/eq_3_39/n2")?
            ),
        ),
    ];
    Ok(rows.concat())
}

fn simulated(runs: &Runs) -> Result<String> {
    let deviation = |run: &Value, signal: &str| number(run, &format!("/deviation/{signal}/rmse"));
    let rows = [
        row(
            "riser level simulated alone (Figure 4.1)",
            "drifts off, same trends",
            &format!(
                "{:.2} m off (root mean square)",
                deviation(&runs.riser, "riser_level_m")?
            ),
        ),
        row(
            "riser level simulated coupled (Figure 4.4)",
            "much more consistent",
            &format!("{:.2} m off", deviation(&runs.coupled, "riser_level_m")?),
        ),
        row(
            "flow simulated alone, dynamic and steady (Figure 4.3)",
            "inseparable",
            &format!(
                "{:.1} and {:.1} L/min off",
                6e4 * deviation(&runs.flow, "pump_flow_m3_s")?,
                6e4 * deviation(&runs.steady, "pump_flow_m3_s")?
            ),
        ),
        row(
            "flow simulated coupled (Figure 4.4)",
            "somewhat less consistent than alone",
            &format!(
                "{:.1} L/min off",
                6e4 * deviation(&runs.coupled, "pump_flow_m3_s")?
            ),
        ),
    ];
    Ok(rows.concat())
}

fn number(value: &Value, path: &str) -> Result<f64> {
    value
        .pointer(path)
        .and_then(Value::as_f64)
        .with_context(|| format!("`dgd` gave no number at {path}"))
}

fn sign(x: f64) -> &'static str {
    if x < 0.0 { "negative" } else { "positive" }
}

fn row(name: &str, thesis: &str, ours: &str) -> String {
    format!("| {name} | {thesis} | {ours} |\n")
}
