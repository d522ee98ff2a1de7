//! The demo: the embedded recording through the whole job.

use crate::bench::Bench;
use serde_json::Value;

/// What a diagnosis writes.
const FILES: [&str; 4] = [
    "diagnosis.json",
    "simulation.csv",
    "model.toml",
    "report.html",
];

#[test]
fn the_demo_writes_its_input_its_results_and_a_report() {
    let bench = Bench::bare();
    let said = bench.json("demo --out demo", "dgd.demo/1");
    assert!(said["level_rmse_m"].as_f64().unwrap().is_finite());
    for name in [
        "recording.mat",
        "well.toml",
        "model.toml",
        "simulation.csv",
        "simulation.mcap",
        "report.html",
    ] {
        assert!(!bench.bytes(&format!("demo/{name}")).is_empty(), "{name}");
    }
    // What is concealed in the second recording, as its README tells.
    let diagnosis = &said["diagnosis"];
    assert_eq!(diagnosis["effects"][0], "influx", "{diagnosis:#}");
    assert!(
        !bench
            .bytes(diagnosis["report"].as_str().unwrap())
            .is_empty()
    );
    // Every step of it can be repeated by hand, and gives the same.
    bench
        .dgd("fit demo/recording.mat --well demo/well.toml")
        .done();
    assert_eq!(bench.text("model.toml"), bench.text("demo/model.toml"));
    bench
        .dgd("simulate demo/recording.mat --well demo/well.toml")
        .done();
    assert_eq!(
        bench.text("simulation.csv"),
        bench.text("demo/simulation.csv")
    );
    the_concealed_influx_is_found_modelled_and_then_found_no_more(&bench);
}

/// One demo for all claims: a diagnosis takes seconds.
fn the_concealed_influx_is_found_modelled_and_then_found_no_more(bench: &Bench) {
    let run = "diagnose demo/diagnosis/recording.mat --well demo/diagnosis/well.toml";
    let said = bench.json(&format!("{run} --out d"), "dgd.diagnosis/1");
    let written: Value = serde_json::from_str(&bench.text("d/diagnosis.json")).unwrap();
    assert_eq!(said, written);
    // The same input gives the same bytes.
    for name in FILES {
        let (one, other) = (format!("d/{name}"), format!("demo/diagnosis/{name}"));
        assert!(bench.bytes(&one) == bench.bytes(&other), "{name}");
    }
    // The fixture's README: 9,776 s to 12,648 s, 0.00219 m³/s.
    let finding = &said["findings"][0];
    assert_eq!(finding["effect"], "influx", "{said:#}");
    assert_eq!(finding["relation"], "riser_mass_balance");
    assert!(finding["probability"].as_f64().unwrap() > 0.5);
    let rate = finding["parameters"]["rate_m3_s"]["estimate"]
        .as_f64()
        .unwrap();
    assert!((rate - 0.00219).abs() < 0.2 * 0.00219, "{rate}");
    let ends = [0, 1].map(|i| finding["intervals_s"][0][i].as_f64().unwrap());
    assert!(ends[0] > 9_000.0 && ends[0] < 10_500.0, "{ends:?}");
    assert!(ends[1] > 11_900.0 && ends[1] < 13_400.0, "{ends:?}");

    let rows = simulation(&bench.text("d/simulation.csv"));
    assert_eq!(rows.len(), 18_000);
    windows_are_long_and_many_enough(&rows);

    // The model with the effect is a model like any other: its run repeats what was claimed.
    let held: Vec<&Row> = rows.iter().filter(|row| row.held_out).collect();
    let window = held.chunk_by(|a, b| b.t_s - a.t_s < 1.5).next().unwrap();
    let (from, to) = (window[0].t_s, window[window.len() - 1].t_s);
    bench
        .dgd(&format!(
            "simulate demo/diagnosis/recording.mat --well demo/diagnosis/well.toml --model d/model.toml --window {from}:{to} --out run.csv"
        ))
        .done();
    let repeated = bench.text("run.csv");
    let at = repeated
        .lines()
        .next()
        .unwrap()
        .split(',')
        .position(|name| name == "riser_level_m_simulated");
    let levels = repeated
        .lines()
        .skip(2)
        .map(|line| line.split(',').nth(at.unwrap()).unwrap().parse::<f64>());
    assert_eq!(levels.clone().count(), window.len());
    for (level, row) in levels.zip(window) {
        // To the rounding of simulation.csv.
        let level = level.unwrap();
        assert!(
            (level - row.level_after_m).abs() < 1e-6,
            "{} {level}",
            row.t_s
        );
    }
    let again = bench.json(
        &format!("{run} --out again --model d/model.toml"),
        "dgd.diagnosis/1",
    );
    let still = again["findings"].as_array().unwrap();
    assert!(still.iter().all(|f| f["effect"] != "influx"), "{again:#}");
}

/// What the claims need of a row of simulation.csv.
struct Row {
    t_s: f64,
    held_out: bool,
    level_after_m: f64,
}

fn simulation(text: &str) -> Vec<Row> {
    let mut lines = text.lines();
    let names: Vec<&str> = lines.next().unwrap().split(',').collect();
    assert_eq!(names[..3], ["t_s", "held_out", "valid"]);
    assert_eq!(names.len(), 15);
    let level = names.iter().position(|n| *n == "riser_level_m_after");
    let row = |line: &str| {
        let cells: Vec<&str> = line.split(',').collect();
        assert_eq!(cells.len(), 15, "{line}");
        let flags = ["0", "1"];
        assert!(
            flags.contains(&cells[1]) && flags.contains(&cells[2]),
            "{line}"
        );
        Row {
            t_s: cells[0].parse().unwrap(),
            held_out: cells[1] == "1",
            level_after_m: cells[level.unwrap()].parse().unwrap_or(f64::NAN),
        }
    };
    lines.map(row).collect()
}

/// Each at least 20 minutes, together at least a fifth of the recording.
fn windows_are_long_and_many_enough(rows: &[Row]) {
    let held = rows.iter().filter(|row| row.held_out).count();
    assert!(5 * held >= rows.len(), "{held} of {}", rows.len());
    for window in rows
        .chunk_by(|a, b| a.held_out == b.held_out)
        .filter(|w| w[0].held_out)
    {
        let length = window[window.len() - 1].t_s - window[0].t_s;
        assert!(length >= 1190.0, "a window of {length} s");
    }
}
