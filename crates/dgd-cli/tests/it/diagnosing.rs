//! `dgd diagnose`, and `dgd simulate` with the model it writes.

use crate::bench::{Bench, WELL, mat5, recording};
use dgd_documents::{Base, ModelDocument, read_model, write_model_document};
use dgd_effects::{
    AppliedEffect, AugmentedModel, Curves, FRICTION_TERMS, HEAD_TERMS, Scale, friction_terms,
    head_terms,
};

/// The two-state model of a fit with exponents 2 and 2, and the same as an augmented one.
fn twins(effects: Vec<AppliedEffect>) -> Bench {
    let bench = Bench::new();
    bench
        .dgd("fit rig.mat --well well.toml --fixed-exponents --out two-state.toml")
        .done();
    let (model, _) = read_model(&bench.text("two-state.toml")).unwrap();
    let scale = Scale {
        flow_m3_s: 0.05,
        speed_pct: 50.0,
        laminar: None,
    };
    let (q, w) = (scale.flow_m3_s, scale.speed_pct);
    let weight = model.density_kg_m3 * 9.806_65;
    let mut friction = [0.0; FRICTION_TERMS];
    for (power, z) in [(0, 0), (1, 1), (2, 2), (3, 3)] {
        let term = |q: f64| friction_terms(q, scale).to_vec();
        let at = position(&[0.02, 0.03, 0.07].map(|x| (term(x), (x / q).powi(z))));
        friction[at] = model.friction.coefficient(power) * q.powi(z);
    }
    let mut head = [0.0; HEAD_TERMS];
    let pump = &model.pump;
    for (c, x, z) in [
        (pump.c0.value, 2, 0),
        (-pump.c1.value, 1, 1),
        (-pump.c2.value, 0, 2),
    ] {
        let points = [(20.0, 0.02), (50.0, 0.03), (70.0, 0.07)];
        let at = position(&points.map(|(speed, flow)| {
            let wanted = (speed / w).powi(x) * (flow / q).powi(z);
            (head_terms(speed, flow, scale).to_vec(), wanted)
        }));
        head[at] = weight * c * w.powi(x) * q.powi(z);
    }
    let document = ModelDocument {
        base: Base::Identified(Box::new(model)),
        augmented: Some(AugmentedModel {
            curves: Curves {
                scale,
                friction,
                head,
            },
            speed_range_pct: (1.0, 100.0),
            ratio_range: (0.0, 0.01),
            span_s: None,
            inlet_range_pa: None,
            effects,
        }),
    };
    bench.write("augmented.toml", write_model_document(&document));
    bench
}

/// The term that has the wanted values at all points.
fn position(points: &[(Vec<f64>, f64)]) -> usize {
    let near = |a: f64, b: f64| (a - b).abs() < 1e-9 * b.abs().max(1.0);
    let right = |k: &usize| {
        points
            .iter()
            .all(|(terms, wanted)| near(terms[*k], *wanted))
    };
    (0..points[0].0.len()).find(right).unwrap()
}

fn kick() -> AppliedEffect {
    let about = dgd_effects::find("influx").unwrap().about();
    let value = |name: &str, usual: f64| match name {
        "rate_m3_s" => 0.002,
        "onset_s" => 1000.0,
        "duration_s" => 2000.0,
        _ => usual,
    };
    AppliedEffect {
        id: "influx".into(),
        parameters: about
            .parameters
            .iter()
            .map(|p| value(p.name, p.usual))
            .collect(),
    }
}

/// A column of a written simulation.
fn column(bench: &Bench, file: &str, name: &str) -> Vec<f64> {
    let text = bench.text(file);
    let mut lines = text.lines();
    let at = lines
        .next()
        .unwrap()
        .split(',')
        .position(|tag| tag == name)
        .unwrap();
    lines
        .skip(1)
        .map(|line| line.split(',').nth(at).unwrap().parse().unwrap_or(f64::NAN))
        .collect()
}

fn largest_difference(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len());
    let told = a.iter().zip(b).filter(|(a, b)| (*a - *b).is_finite());
    assert!(10 * told.count() > 9 * a.len(), "mostly nothing to compare");
    a.iter()
        .zip(b)
        .map(|(a, b)| (a - b).abs())
        .fold(0.0, f64::max)
}

#[test]
fn a_model_without_effects_runs_as_the_two_state_model_of_the_same_curves() {
    let bench = twins(Vec::new());
    for name in ["two-state", "augmented"] {
        bench
            .dgd(&format!(
                "simulate rig.mat --well well.toml --model {name}.toml --window 500:2500 --out {name}.csv"
            ))
            .done();
    }
    let of = |file: &str, name: &str| column(&bench, file, name);
    for signal in ["riser_level_m", "pump_head_m"] {
        let measured = format!("{signal}_measured");
        assert_eq!(
            of("two-state.csv", &measured),
            of("augmented.csv", &measured)
        );
    }
    let level = |file| of(file, "riser_level_m_simulated");
    // The level swings by 14 m; the two integrate differently, and this one starts on the meter's late flow.
    let apart = largest_difference(&level("two-state.csv"), &level("augmented.csv"));
    assert!(apart < 0.3, "{apart} m");
}

#[test]
fn an_effect_in_the_model_shows_in_its_run() {
    let bench = twins(vec![kick()]);
    let run = bench.json(
        "simulate rig.mat --well well.toml --model augmented.toml --out with.csv",
        "dgd.simulate/1",
    );
    assert_eq!(run["effects"], serde_json::json!(["influx"]));
    assert_eq!(run["samples"], 4000);
    let said = bench
        .dgd("simulate rig.mat --well well.toml --model augmented.toml --out with.csv")
        .done();
    assert!(said.contains("with influx"), "{said}");
    bench.write(
        "without.toml",
        bench
            .text("augmented.toml")
            .replace("rate_m3_s = 0.002", "rate_m3_s = 0.0"),
    );
    bench
        .dgd("simulate rig.mat --well well.toml --model without.toml --out without.csv")
        .done();
    let level = |file| column(&bench, file, "riser_level_m_simulated");
    let (with, without) = (level("with.csv"), level("without.csv"));
    assert_eq!(with[..990], without[..990]);
    // Mud above the pump: the level below the rotary table gets less.
    assert!(
        with[2500] < without[2500] - 1.0,
        "{} {}",
        with[2500],
        without[2500]
    );
}

#[test]
fn on_another_recording_what_has_set_in_goes_on_and_what_passed_is_over() {
    let leak = |onset_s: f64| AppliedEffect {
        id: "line_leak".into(),
        parameters: vec![2e-3, onset_s],
    };
    let bench = twins(vec![kick(), leak(2000.0)]);
    std::fs::copy(bench.path("rig.mat"), bench.path("next.mat")).unwrap();
    let run = |recording: &str, out: &str| {
        bench.json(
            &format!("simulate {recording} --well well.toml --model augmented.toml --out {out}"),
            "dgd.simulate/1",
        )
    };
    let same = run("rig.mat", "same.csv");
    assert_eq!(same["effects"], serde_json::json!(["influx", "line_leak"]));
    assert_eq!(same["warnings"], serde_json::json!([]));
    let next = run("next.mat", "next.csv");
    assert_eq!(next["effects"], serde_json::json!(["line_leak"]));
    let warned = next["warnings"][0].as_str().unwrap();
    for part in [
        "rig.mat",
        "line_leak acts from the start here",
        "influx is over here",
    ] {
        assert!(warned.contains(part), "{warned}");
    }
    // From its start the meter reads what the leak leaves.
    let flow = |file| column(&bench, file, "return_flow_m3_s_simulated");
    let (same, next) = (flow("same.csv"), flow("next.csv"));
    assert!(
        (300..900).all(|i| next[i] < same[i] - 1e-3),
        "{} {}",
        next[600],
        same[600]
    );
}

#[test]
fn on_another_recording_what_grows_is_told() {
    let wear = AppliedEffect {
        id: "pump_wear".into(),
        parameters: vec![1e-3],
    };
    let bench = twins(vec![wear]);
    std::fs::copy(bench.path("rig.mat"), bench.path("next.mat")).unwrap();
    let run = "simulate next.mat --well well.toml --model augmented.toml --out next.csv";
    let warned = |why: &str| {
        let said = bench.json(run, "dgd.simulate/1");
        let warned = said["warnings"][0].as_str().unwrap();
        assert!(warned.contains(why), "{warned}");
    };
    warned("pump_wear grows to its strength here, however long it takes");
    let section = "[augmented]\n";
    let spanned = format!("{section}span_s = [0.0, 1999.0]\n");
    let model = bench.text("augmented.toml");
    assert!(model.contains(section));
    bench.write("augmented.toml", model.replace(section, &spanned));
    warned("pump_wear grows here as fast as there");
}

#[test]
fn what_only_a_two_state_model_can_do_is_refused() {
    let bench = twins(vec![kick()]);
    bench
        .dgd("simulate rig.mat --well well.toml --model augmented.toml --kind riser")
        .refused(&["--kind riser", "augmented.toml", "dgd fit"]);
    bench
        .dgd("mask rig.mat --well well.toml --model augmented.toml --out m --references r.toml")
        .refused(&["augmented.toml:", "contains effects (influx)", "dgd fit"]);
    assert!(!bench.path("m").exists());
}

#[test]
fn a_window_outside_is_refused_and_a_start_is_taken() {
    let bench = twins(vec![kick()]);
    let run = "simulate rig.mat --well well.toml --model augmented.toml --out run.csv";
    bench
        .dgd(&format!("{run} --window 90000:91000"))
        .refused(&["rig.mat", "90000"]);
    bench
        .dgd(&format!("{run} --window 500:600 --level=140m"))
        .done();
    let level = column(&bench, "run.csv", "riser_level_m_simulated");
    assert!((level[0] - 140.0).abs() < 0.1, "{}", level[0]);
    bench
        .dgd(&format!("{run} --window 500:900 --figures figures"))
        .done();
    assert!(bench.path("figures/figure-4-4.svg").exists());
    assert!(!bench.path("figures/figure-4-1.svg").exists());
}

#[test]
fn a_window_is_all_that_a_fit_and_a_diagnosis_see_and_its_times_stay_those_of_the_clock() {
    let bench = Bench::new();
    let fit = "fit rig.mat --well well.toml";
    bench.dgd(&format!("{fit} --window 90000:91000")).refused(&[
        "rig.mat",
        "90000 to 91000 s",
        "0 samples",
    ]);
    let said = bench.json(&format!("{fit} --window 600:3599"), "dgd.fit/1");
    assert_eq!(said["samples"], 3000);
    let model = bench.text("model.toml");
    assert!(
        model.contains(r#"recordings = ["rig.mat (600 to 3599 s)"]"#),
        "{model}"
    );

    let said = bench.json(
        "diagnose rig.mat --well well.toml --window 600:3599 --out d",
        "dgd.diagnosis/1",
    );
    assert!(said["verdict"].is_string(), "{said:#}");
    let simulated = bench.text("d/simulation.csv");
    let mut times = simulated
        .lines()
        .skip(1)
        .filter_map(|l| l.split(',').next());
    assert_eq!((times.next(), times.last()), (Some("600"), Some("3599")));
    assert!(
        bench
            .text("d/model.toml")
            .contains("span_s = [600.0, 3599.0]")
    );
    let report = bench.text("d/report.html");
    assert!(report.contains("rig.mat (600 to 3599 s)"));
    assert!(report.contains("--window 600:3599"));
    bench
        .dgd("simulate rig.mat --well well.toml --model d/model.toml --window 600:3599 --out run.csv")
        .done();
}

#[test]
fn a_misspelt_effect_is_shown_at_its_line() {
    let bench = twins(vec![kick()]);
    let model = bench.text("augmented.toml");
    let line = model.lines().position(|l| l == "id = \"influx\"").unwrap() + 1;
    bench.write(
        "bad.toml",
        model.replace("id = \"influx\"", "id = \"inflxu\""),
    );
    let place = format!("bad.toml:{line}:");
    for command in [
        "simulate rig.mat --well well.toml --model bad.toml",
        "diagnose rig.mat --well well.toml --model bad.toml --out d",
    ] {
        bench.dgd(command).refused(&[&place, "inflxu", "influx"]);
    }
}

#[test]
fn bad_input_is_refused_and_nothing_is_written() {
    let bench = Bench::new();
    let diagnose = |rest: &str| bench.dgd(&format!("diagnose {rest} --out d"));
    diagnose("no.mat --well well.toml").refused(&["no.mat", "cannot be read"]);
    diagnose("rig.mat --well no.toml").refused(&["no.toml"]);
    bench.write("cut.mat", &bench.bytes("rig.mat")[..900]);
    diagnose("cut.mat --well well.toml").refused(&["cut.mat"]);
    bench.write("wrong.toml", WELL.replace("QXRET17", "QXRET18"));
    diagnose("rig.mat --well wrong.toml").refused(&["return_flow", "QXRET18"]);
    bench.write("short.mat", mat5(&recording(60)));
    diagnose("short.mat --well well.toml").refused(&[
        "short.mat",
        "blocks",
        "32 min",
        "record for longer",
    ]);
    bench
        .dgd("diagnose rig.mat --well well.toml")
        .refused(&["--out"]);
    assert!(!bench.path("d").exists());
}

#[test]
fn a_third_transmitter_is_said_not_to_be_used() {
    let bench = Bench::new();
    let mut table = recording(300);
    let mut third = table
        .columns
        .iter()
        .find(|c| c.tag == "PXOUB17")
        .unwrap()
        .clone();
    third.tag = "PXOUC17".into();
    table.columns.push(third);
    bench.write("three.mat", mat5(&table));
    let (second, third) = (
        r#""PXOUB17", unit = "psia" }"#,
        r#", { tag = "PXOUC17", unit = "psia" }"#,
    );
    assert!(WELL.contains(second));
    bench.write(
        "three.toml",
        WELL.replace(second, &format!("{second}{third}")),
    );
    // Too short to be diagnosed, which is found out after it was read.
    let ran = bench.dgd("diagnose three.mat --well three.toml --out d");
    assert!(
        ran.err.contains("`pump_outlet_pressure 3` is not used"),
        "{}",
        ran.err
    );
}

#[test]
fn a_model_that_is_read_is_not_replaced() {
    let bench = twins(vec![kick()]);
    std::fs::create_dir(bench.path("d")).unwrap();
    std::fs::copy(bench.path("augmented.toml"), bench.path("d/model.toml")).unwrap();
    bench
        .dgd("diagnose rig.mat --well well.toml --model d/model.toml --out d")
        .refused(&["d/model.toml", "input of this run"]);
    assert_eq!(bench.text("d/model.toml"), bench.text("augmented.toml"));
    assert_eq!(std::fs::read_dir(bench.path("d")).unwrap().count(), 1);
}

#[test]
fn a_file_in_the_place_of_the_folder_is_told_before_the_work() {
    let bench = Bench::new();
    bench.write("d", "not a folder");
    let ran = bench.dgd("diagnose rig.mat --well well.toml --out d");
    assert_eq!(ran.status, 1, "{ran:?}");
    assert!(
        ran.err.contains("d cannot be written: it is not a folder"),
        "{}",
        ran.err
    );
    assert_eq!(bench.text("d"), "not a folder");
}
