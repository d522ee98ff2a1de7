//! `--system`: any assembly checked, drawn, fitted, simulated, linearised, its sensitivities told.

mod diagnosis;
mod doubts;
mod fitting;
mod page;
#[path = "../../examples/benches/physics.rs"]
mod physics;
mod refusals;
mod structure;

use crate::bench::Bench;
use serde_json::Value;

/// The three benches, each as `<name>.toml` and `<name>.csv`.
pub(crate) fn benches() -> Bench {
    let bench = Bench::bare();
    for (name, system, recording) in physics::all() {
        bench.write(&format!("{name}.toml"), system);
        bench.write(&format!("{name}.csv"), recording);
    }
    bench
}

/// Writes `both.toml`: two tanks whose upper outlet has a free area, beside its coefficient.
pub(crate) fn free_area(bench: &Bench) {
    let system = bench
        .text("two_tanks.toml")
        .replace(
            "[free]\n",
            "[free]\n\"upper_outlet.area\" = { start = 1e-4, low = 5e-5, high = 2e-4 }\n",
        )
        .replace(
            "upper_outlet = { kind = \"orifice\", area = 1e-4 }",
            "upper_outlet = { kind = \"orifice\" }",
        );
    bench.write("both.toml", system);
}

fn document(bench: &Bench, name: &str) -> Value {
    serde_json::from_str(&bench.text(name)).unwrap()
}

/// Estimate and interval of a parameter.
fn estimate(fit: &Value, path: &str) -> (f64, f64, f64) {
    let all = fit["parameters"].as_array().unwrap();
    let found = all.iter().find(|p| p["path"] == path).unwrap();
    let end = |k: usize| found["ci95"][k].as_f64().unwrap();
    (found["value"].as_f64().unwrap(), end(0), end(1))
}

#[track_caller]
fn recovers(fit: &Value, path: &str, truth: f64, share: f64) {
    let (value, low, high) = estimate(fit, path);
    assert!(low < value && value < high, "{path}: {low} {value} {high}");
    assert!(
        (value / truth - 1.0).abs() < share,
        "{path} {value}, truth {truth}"
    );
    let half = 0.5 * (high - low);
    assert!(
        (value - truth).abs() < 3.0 * half,
        "{path} {value} ± {half}, truth {truth}"
    );
}

fn rms(fit: &Value, output: &str, part: &str) -> f64 {
    let all = fit["outputs"].as_array().unwrap();
    let found = all.iter().find(|o| o["name"] == output).unwrap();
    found[part]["rms"].as_f64().unwrap()
}
