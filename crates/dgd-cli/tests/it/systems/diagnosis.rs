//! Diagnoses of the benches.

use super::{benches, document, rms};

#[test]
fn a_clean_bench_is_diagnosed_as_consistent() {
    let bench = benches();
    let told = bench.json(
        "diagnose two_tanks.csv --system two_tanks.toml --out d",
        "dgd.system-diagnosis/1",
    );
    assert_eq!(told["verdict"], "consistent");
    assert_eq!(told["findings"].as_array().unwrap().len(), 0);
    assert_eq!(document(&bench, "d/diagnosis.json"), told);
    bench
        .dgd("diagnose two_tanks.csv --system two_tanks.toml --model m.toml --out d")
        .refused(&["cannot be used with"]);
}

#[test]
fn a_level_that_is_read_late_is_named_and_the_model_with_it_runs() {
    let bench = benches();
    let text = bench.text("two_tanks.csv");
    let rows: Vec<Vec<&str>> = text.lines().map(|l| l.split(',').collect()).collect();
    let mut late = String::from("t,u,h2\ns,V,cm\n");
    for i in 2..rows.len() {
        // Four samples of 4 s.
        let shown = rows[i.saturating_sub(4).max(2)][2];
        late.push_str(&format!("{},{},{shown}\n", rows[i][0], rows[i][1]));
    }
    bench.write("late.csv", late);
    let told = bench.json(
        "diagnose late.csv --system two_tanks.toml --out d",
        "dgd.system-diagnosis/1",
    );
    assert_eq!(told["verdict"], "explained");
    let finding = &told["findings"][0];
    assert_eq!(
        (finding["component"].as_str(), finding["effect"].as_str()),
        (Some("level"), Some("reading_delay"))
    );
    let delay = finding["parameters"][0]["value"].as_f64().unwrap();
    assert!((delay - 16.0).abs() < 1.0, "{delay}");
    let (before, after) = (
        &told["outputs"][0]["test"][0],
        &told["outputs"][0]["test"][1],
    );
    assert!(after.as_f64().unwrap() < 0.5 * before.as_f64().unwrap());
    let page = bench.text("d/report.html");
    assert!(
        page.contains("reading_delay")
            && page.contains("Verdict: explained. Left out: level.reading_delay")
    );
    let answer = told["answer"].as_str().unwrap();
    assert!(
        answer.starts_with("left out: level.reading_delay"),
        "{answer}"
    );
    // A mismatch is why effects are sought, and fails no check.
    let checks = told["checks"].as_array().unwrap();
    assert!(!checks.is_empty());
    assert!(checks.iter().all(|c| c["passed"] == true), "{checks:?}");
    // What would have shown at an instrument that is read in centimetres.
    let tested = told["tested"].as_array().unwrap();
    let drift = tested
        .iter()
        .find(|t| t["effect"] == "reading_drift")
        .unwrap();
    assert_eq!(
        (&drift["parameter"], &drift["unit"]),
        (&"change".into(), &"cm".into())
    );
    // In metres it would be a hundredth of that.
    let limit = drift["limit"].as_f64().unwrap();
    assert!((0.005..50.0).contains(&limit), "{drift}");
    assert!(
        bench
            .text("d/simulation.csv")
            .starts_with("t,held_out,level_measured,level_before,level_after")
    );
    let run = bench.json(
        "simulate late.csv --system d/model.toml --out run.csv",
        "dgd.system-simulation/1",
    );
    assert!(rms(&run, "level", "test") < 0.1);
}

/// A curve along time is no component: what the answer says of `model.toml` is what a simulation of it gives.
#[test]
fn a_correction_that_no_model_holds_is_told_with_what_the_model_leaves() {
    let bench = benches();
    let text = bench.text("two_tanks.csv");
    let mut tilted = String::new();
    for (i, line) in text.lines().enumerate() {
        let (rest, level) = line.rsplit_once(',').unwrap();
        let Ok(level) = level.parse::<f64>() else {
            tilted += &format!("{line}\n");
            continue;
        };
        // Up and down again, as nothing in the catalogue goes.
        let t = f64::from(u32::try_from(i).unwrap());
        let tent = 4.0 - (t / 20.0 - 4.0).abs();
        tilted += &format!("{rest},{}\n", level + tent.max(0.0));
    }
    bench.write("tilted.csv", tilted);
    let told = bench.json(
        "diagnose tilted.csv --system two_tanks.toml --out d",
        "dgd.system-diagnosis/1",
    );
    assert_eq!(told["verdict"], "unexplained", "{told:#}");
    assert_eq!(told["findings"][0]["shape"]["along"], "time", "{told:#}");
    assert_eq!(told["after_is_model"], false);
    let [before, after] = [0, 1].map(|k| told["outputs"][0]["test"][k].as_f64().unwrap());
    assert!(after < before);
    let run = bench.json(
        "simulate tilted.csv --system d/model.toml --out run.csv",
        "dgd.system-simulation/1",
    );
    let left = rms(&run, "level", "test");
    assert!(
        (left / before - 1.0).abs() < 1e-3,
        "{left} {before} {after}"
    );
    let line = format!(
        "it is not in model.toml, which simulates as before it (off by, rms, held out: level {left:.2} cm)"
    );
    let model = bench.text("d/model.toml");
    let head = model.lines().next().unwrap().to_owned();
    let again = bench.dgd("diagnose tilted.csv --system two_tanks.toml --out e -v");
    for said in [head, bench.text("d/report.html"), again.out] {
        assert!(said.contains(&line), "{line}: {said}");
    }
    for stage in [
        "re-fitting the system as described",
        "screening the catalogue",
        "fitting sets of 1",
        "confirming on the test part",
    ] {
        assert!(again.err.contains(stage), "{stage}: {}", again.err);
    }
}
