use crate::bench::Bench;

const RUN: &str = "simulate rig.mat --well well.toml --model model.toml";

fn fitted() -> Bench {
    let bench = Bench::new();
    bench.dgd("fit rig.mat --well well.toml").done();
    bench
}

#[test]
fn all_four_kinds_follow_the_recording_they_were_fitted_to() {
    let bench = fitted();
    for kind in ["riser", "flow", "steady", "coupled"] {
        let run = bench.json(
            &format!("{RUN} --kind {kind} --window 200:3800 --out {kind}.csv"),
            "dgd.simulate/1",
        );
        assert_eq!(run["kind"], kind);
        assert_eq!(run["finished"], true, "{run:#}");
        assert_eq!(run["samples"], 3601);
        let rmse = |signal: &str| run["deviation"][signal]["rmse"].as_f64();
        // The level swings by 14 m, the flow by 0.018 m³/s: a model that does nothing is off by far more.
        if matches!(kind, "riser" | "coupled") {
            assert!(rmse("riser_level_m").unwrap() < 2.0, "{run:#}");
        }
        if kind != "riser" {
            assert!(rmse("pump_flow_m3_s").unwrap() < 2e-3, "{run:#}");
        }
    }
}

#[test]
fn what_a_simulation_writes_is_read_again() {
    let bench = fitted();
    bench
        .dgd(&format!("{RUN} --window 500:900 --out run.csv"))
        .done();
    bench
        .dgd(&format!("{RUN} --window 500:900 --out run.mcap"))
        .done();
    for name in ["run.csv", "run.mcap"] {
        let said = bench.json(&format!("inspect {name}"), "dgd.inspect/1");
        assert_eq!(said["rows"], 401, "{name}");
        assert_eq!(said["clock"]["step_s"], 1.0, "{name}");
        let columns = said["columns"].as_array().unwrap();
        assert!(
            columns.iter().any(|c| c["tag"]
                .as_str()
                .unwrap()
                .ends_with("riser_level_m_simulated")),
            "{said:#}"
        );
    }
}

#[test]
fn the_integrators_agree() {
    let bench = fitted();
    let level = |solver: &str| {
        let run = bench.json(
            &format!("{RUN} --solver {solver} --tolerance 1e-6"),
            "dgd.simulate/1",
        );
        run["deviation"]["riser_level_m"]["rmse"].as_f64().unwrap()
    };
    let rodas = level("rodas");
    for other in ["rodas3", "dormand-prince"] {
        let found = level(other);
        assert!((rodas - found).abs() < 1e-3 * rodas, "{rodas} {found}");
    }
}

#[test]
fn a_start_given_in_rig_units_is_where_the_run_starts() {
    let bench = Bench::new();
    bench.dgd("fit rig.mat --well well.toml").done();
    let line = format!("{RUN} --window 500:600 --out run.csv --level=140m --flow=800gpm");
    bench.dgd(&line).done();
    let text = bench.text("run.csv");
    let mut lines = text.lines();
    let tags: Vec<&str> = lines.next().unwrap().split(',').collect();
    let first: Vec<&str> = lines.nth(1).unwrap().split(',').collect();
    let of = |tag: &str| -> f64 {
        first[tags.iter().position(|t| *t == tag).unwrap()]
            .parse()
            .unwrap()
    };
    assert_eq!(of("riser_level_m_simulated"), 140.0);
    assert!((of("pump_flow_m3_s_simulated") - 800.0 * 6.3090e-5).abs() < 1e-12);
}

#[test]
fn a_model_of_another_well_is_used_with_a_warning() {
    let bench = fitted();
    bench.write("other.toml", crate::bench::WELL.replace("1083.7", "1200"));
    let ran = bench.dgd("simulate rig.mat --well other.toml --model model.toml");
    assert!(ran.err.contains("different mud or geometry"), "{}", ran.err);
    assert_eq!(ran.status, 0);
}
