//! The demo: the embedded recording through the whole job.

use crate::bench::Bench;
use serde_json::Value;

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
    assert_eq!(diagnosis["verdict"], "explained", "{diagnosis:#}");
    assert_eq!(diagnosis["effects"], serde_json::json!(["influx"]));
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
}

#[test]
fn the_concealed_influx_is_found_modelled_and_then_found_no_more() {
    let bench = Bench::bare();
    let fixture = |name: &str| {
        let folder = concat!(
            env!("CARGO_MANIFEST_DIR"),
            "/../../fixtures/demo-concealed/"
        );
        std::fs::read(format!("{folder}{name}")).unwrap()
    };
    bench.write("recording.mat", fixture("recording.mat"));
    bench.write("well.toml", fixture("well.toml"));
    let run = "diagnose recording.mat --well well.toml";
    let said = bench.json(&format!("{run} --out d"), "dgd.diagnosis/1");
    let written: Value = serde_json::from_str(&bench.text("d/diagnosis.json")).unwrap();
    assert_eq!(said, written);
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

    // The model with the effect is a model like any other.
    bench
        .dgd("simulate recording.mat --well well.toml --model d/model.toml --out run.csv")
        .done();
    let again = bench.json(
        &format!("{run} --out again --model d/model.toml"),
        "dgd.diagnosis/1",
    );
    assert_eq!(again["verdict"], "consistent", "{again:#}");

    // The same input gives the same bytes.
    bench.dgd(&format!("{run} --out d2")).done();
    for name in [
        "diagnosis.json",
        "simulation.csv",
        "model.toml",
        "report.html",
    ] {
        assert!(
            bench.bytes(&format!("d/{name}")) == bench.bytes(&format!("d2/{name}")),
            "{name}"
        );
    }
}

/// Time and `held_out` of every row.
fn simulation(text: &str) -> Vec<(f64, bool)> {
    let mut lines = text.lines();
    let names: Vec<&str> = lines.next().unwrap().split(',').collect();
    assert_eq!(names[..3], ["t_s", "held_out", "valid"]);
    assert_eq!(names.len(), 15);
    let row = |line: &str| {
        let cells: Vec<&str> = line.split(',').collect();
        assert_eq!(cells.len(), 15, "{line}");
        assert!(
            ["0", "1"].contains(&cells[1]) && ["0", "1"].contains(&cells[2]),
            "{line}"
        );
        (cells[0].parse().unwrap(), cells[1] == "1")
    };
    lines.map(row).collect()
}

/// Each at least 20 minutes, together at least a fifth of the recording.
fn windows_are_long_and_many_enough(rows: &[(f64, bool)]) {
    let held = rows.iter().filter(|(_, held)| *held).count();
    assert!(5 * held >= rows.len(), "{held} of {}", rows.len());
    for window in rows.chunk_by(|a, b| a.1 == b.1).filter(|w| w[0].1) {
        let length = window[window.len() - 1].0 - window[0].0;
        assert!(length >= 1190.0, "a window of {length} s");
    }
}
