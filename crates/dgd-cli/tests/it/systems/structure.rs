//! What a description says without a recording, and what stands around an operating point.

use super::{benches, free_area};
use crate::bench::{Bench, Ran};
use std::fs;
use std::path::Path;

#[test]
fn check_tells_states_inputs_free_values_and_effects() {
    let bench = benches();
    let said = bench
        .dgd("system check two_tanks.toml --draw two.svg")
        .done();
    for part in [
        "well posed",
        "3 unknowns",
        "3 equations",
        "upper.level",
        "pump.input",
        "u",
        "cm",
        "overflow_caught",
        "discharge_coefficient",
        "two.svg",
    ] {
        assert!(said.contains(part), "`{part}` is not in {said}");
    }
    let drawing = bench.text("two.svg");
    for part in [
        "upper_outlet",
        "displacement pump",
        "free: discharge_coefficient",
        ">LT<",
        "level [cm]",
    ] {
        assert!(drawing.contains(part), "{part}");
    }
    roxmltree::Document::parse(&drawing).unwrap();
    bench
        .dgd("system check two_tanks.toml --draw two.png")
        .done();
    assert_eq!(&bench.bytes("two.png")[1..4], b"PNG");
    let told = bench.json("system check pump_loop.toml", "dgd.system-check/1");
    assert_eq!(
        told["states"],
        serde_json::json!(["tank.level", "line.flow"])
    );
    // Pump, line and throttle stand in series: three laws, two junctions.
    assert_eq!(told["equations"], 5);
    assert_eq!(told["unknowns"]["pressures"].as_array().unwrap().len(), 2);
    assert!(told["effects"].as_array().unwrap().len() > 30);
}

#[test]
fn a_system_that_is_not_well_posed_is_told_by_line_with_its_mend_and_drawn_all_the_same() {
    let bench = benches();
    let loose = bench
        .text("two_tanks.toml")
        .replace(" -> lower_outlet -> atmosphere", " -> lower_outlet");
    bench.write("loose.toml", loose);
    let ran: Ran = bench.dgd("system check loose.toml --draw loose.svg");
    ran.refused(&["loose.toml:", "lower_outlet", "leads nowhere", "atmosphere"]);
    assert!(bench.text("loose.svg").contains("lower_outlet"));
    bench.write("typo.toml", "connections = [\n");
    bench.dgd("system check typo.toml").refused(&["typo.toml:"]);
    bench
        .dgd("system check two_tanks.toml --draw two.jpg")
        .refused(&["two.jpg", ".svg or .png"]);
    bench
        .dgd("system check no.toml")
        .refused(&["no.toml", "cannot be read"]);
}

#[test]
fn linearise_gives_the_matrices_that_stand_in_the_book() {
    let bench = benches();
    let system = bench
        .text("two_tanks.toml")
        .replace("start = 0.5", "start = 0.6");
    bench.write("two.toml", system);
    let told = bench.json(
        "linearise --system two.toml --at pump.input=5 --step 4 --out lin",
        "dgd.linear/1",
    );
    // Torricelli: q = C a √(2 g h), so dq/dh = q/(2 h).
    let q: f64 = 2e-5 * 5.0;
    let level = |area: f64| (q / (0.6 * area)).powi(2) / (2.0 * 9.806_65);
    let (lower, upper) = (level(1.2e-4), level(1e-4));
    let a = |i: usize, j: usize| told["continuous"]["A"][i][j].as_f64().unwrap();
    assert_eq!(
        told["states"],
        serde_json::json!(["lower.level", "upper.level"])
    );
    let close = |found: f64, truth: f64| {
        assert!(
            (found - truth).abs() < 1e-5 * truth.abs().max(1e-9),
            "{found} {truth}"
        )
    };
    close(a(0, 0), -q / (2.0 * lower) / 0.02);
    close(a(0, 1), q / (2.0 * upper) / 0.02);
    close(a(1, 1), -q / (2.0 * upper) / 0.02);
    close(told["continuous"]["B"][1][0].as_f64().unwrap(), 2e-5 / 0.02);
    close(
        told["continuous"]["time_constants_s"][0].as_f64().unwrap(),
        0.04 * upper / q,
    );
    let discrete = told["discrete"]["A"][1][1].as_f64().unwrap();
    close(discrete, (4.0 * a(1, 1)).exp());
    // The same numbers in MATLAB's file.
    bench.dgd("convert lin/linear.mat lin.csv").done();
    let csv = bench.text("lin.csv");
    let head = csv.lines().next().unwrap();
    assert!(
        head.contains("A(:,1)") && head.contains("discrete.B"),
        "{head}"
    );
    assert!(
        csv.contains(&told["continuous"]["A"][0][1].to_string()),
        "{csv}"
    );
}

#[test]
fn an_operating_point_is_taken_from_the_recording_or_refused_with_what_is_missing() {
    let bench = benches();
    let told = bench.json(
        "linearise --system return_line.toml --at-time 2500 --recording return_line.csv --out lin",
        "dgd.linear/1",
    );
    let point = &told["operating_point"];
    assert_eq!(point["steady"], false);
    let rows = bench.text("return_line.csv");
    let row: Vec<&str> = rows.lines().nth(2502).unwrap().split(',').collect();
    assert_eq!(row[0], "2500");
    let speed = point["inputs"]["pump.speed"].as_f64().unwrap();
    assert!((speed - row[2].parse::<f64>().unwrap()).abs() < 1e-9);
    let refused = [
        ("--at pump.speed=60", "inflow.flow=..."),
        ("--at pump.speed=60 turbo=3", "turbo"),
        ("--at pump.speed=60bar", "pump.speed"),
        ("--at-time 2500", "--recording"),
        ("--at-time 9999 --recording return_line.csv", "9999"),
    ];
    for (arguments, part) in refused {
        bench
            .dgd(&format!(
                "linearise --system return_line.toml {arguments} --out no"
            ))
            .refused(&[part]);
    }
    bench
        .dgd("linearise --system pump_loop.toml --at pump.speed=60 --out no")
        .refused(&["throttle.opening=..."]);
    assert!(!bench.path("no").exists());
}

#[test]
fn a_tank_that_nothing_regulates_has_no_steady_state() {
    let bench = Bench::bare();
    bench.write(
        "pit.toml",
        r#"
connections = ["feed -> pit"]
[components]
feed = { kind = "boundary", flow = 0.0 }
pit = { kind = "tank", area = 2.0 }
gauge = { kind = "instrument", measures = "level", of = "pit" }
[inputs]
"feed.flow" = { channel = "q" }
[initial]
"pit.level" = 1.0
"#,
    );
    bench
        .dgd("linearise --system pit.toml --at feed.flow=0.01 --out lin")
        .refused(&[
            "pit.toml",
            "no steady state",
            "feed.flow=0.01 in m3/s was taken",
            "pit.level=...",
        ]);
    let told = bench.json(
        "linearise --system pit.toml --at feed.flow=0.01 pit.level=1.5 --out lin",
        "dgd.linear/1",
    );
    let b = told["continuous"]["B"][0][0].as_f64().unwrap();
    assert!((b - 0.5).abs() < 1e-9, "{b}");
    assert_eq!(told["operating_point"]["outputs"]["gauge"], 1.5);
}

#[test]
fn inputs_are_given_in_their_units_and_the_linear_model_tells_those_that_it_is_in() {
    let bench = Bench::bare();
    bench.write(
        "pit.toml",
        r#"
connections = ["feed -> pit -> valve -> atmosphere"]
[components]
feed = { kind = "displacement_pump" }
pit = { kind = "tank", area = 2.0 }
valve = { kind = "valve", flow_coefficient = 1e-5 }
gauge = { kind = "instrument", measures = "level", of = "pit" }
[inputs]
"feed.input" = { channel = "q", unit = "l/min" }
"valve.opening" = { channel = "z", unit = "%" }
[initial]
"pit.level" = 1.0
"#
        .replace("feed -> pit", "atmosphere -> feed -> pit"),
    );
    let at = |point: &str| format!("linearise --system pit.toml --at {point} --out lin");
    let told = bench.json(
        &at("feed.input=600l/min valve.opening=80% pit.level=1.5"),
        "dgd.linear/1",
    );
    assert_eq!(told["operating_point"]["inputs"]["feed.input"], 0.01);
    assert_eq!(told["operating_point"]["inputs"]["valve.opening"], 0.8);
    let linear = super::document(&bench, "lin/linear.json");
    assert_eq!(linear["input_units"], serde_json::json!(["m3/s", "1"]));
    // What is misspelt is told before its unit is.
    bench
        .dgd(&at("feed.input=600l/min valve.openin=80% pit.level=1.5"))
        .refused(&["valve.openin", "no such input or state", "valve.opening"]);
    bench
        .dgd(&at("feed.input=600psi valve.opening=0.8 pit.level=1.5"))
        .refused(&["feed.input", "psi"]);
    bench
        .dgd(&at("feed.input=600l/min valve.opening=80 pit.level=1.5"))
        .refused(&["valve.opening=80", "it is 80, expected 0 to 1"]);
}

#[test]
fn the_built_in_return_line_is_linearised_as_dgd_dynamics_does() {
    use dgd_dynamics::return_line::{LineState, linearise};
    let bench = Bench::new();
    bench.dgd("fit rig.mat --well well.toml").done();
    let at = "'inflow.flow=0.05' pump.speed=62 riser.level=200 line.flow=0.05".replace('\'', "");
    let told = bench.json(
        &format!("linearise --well well.toml --model model.toml --at {at} --out lin"),
        "dgd.linear/1",
    );
    let (model, _) = dgd_documents::read_model(&bench.text("model.toml")).unwrap();
    let line = model.return_line();
    let state = LineState {
        level_m: line.inlet_depth_m - 200.0,
        flow_m3_s: 0.05,
    };
    let known = linearise(&line, state, 62.0).unwrap();
    // The assembly counts the level upwards.
    let sign = [-1.0, 1.0];
    for i in 0..2 {
        for j in 0..2 {
            let found = told["continuous"]["A"][i][j].as_f64().unwrap();
            let truth = known.a[i][j] * sign[i] * sign[j];
            assert!(
                (found - truth).abs() <= 1e-6 * truth.abs().max(1e-9),
                "A {i} {j}: {found} {truth}"
            );
            let found = told["continuous"]["B"][i][j].as_f64().unwrap();
            let truth = known.b[i][j] * sign[i];
            assert!(
                (found - truth).abs() <= 1e-6 * truth.abs().max(1e-9),
                "B {i} {j}: {found} {truth}"
            );
        }
    }
    // It comes as a system of its own, which the other commands take.
    bench.dgd("system check lin/system.toml").done();
}

#[test]
fn every_description_in_the_fixtures_is_well_posed() {
    let fixtures = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures");
    let mut folders = vec![fixtures];
    let mut found = 0;
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else if path.file_name().is_some_and(|name| name == "system.toml") {
                let bench = Bench::bare();
                bench.write("system.toml", fs::read(&path).unwrap());
                bench.dgd("system check system.toml").done();
                found += 1;
            }
        }
    }
    assert!(found >= 5, "{found}");
}

#[test]
fn what_cannot_be_told_apart_is_named() {
    let bench = benches();
    // The two coefficients of one outlet act as their product alone.
    free_area(&bench);
    let told = bench.json(
        "sensitivities two_tanks.csv --system both.toml --out s",
        "dgd.sensitivities/1",
    );
    let found = &told["identifiability"];
    assert_eq!(found["rank"], 4);
    assert_eq!(found["of"], 5);
    let shares = found["near_null"][0]["shares"].as_array().unwrap();
    let mut named: Vec<&str> = shares.iter().map(|s| s["path"].as_str().unwrap()).collect();
    named.sort_unstable();
    assert_eq!(
        named,
        ["upper_outlet.area", "upper_outlet.discharge_coefficient"]
    );
    let page = bench.text("s/sensitivities.html");
    assert!(page.contains("not determined") && page.contains("<svg"));
    assert!(
        bench
            .text("s/sensitivities.csv")
            .starts_with("t,window,level by ")
    );
    let ranked = found["ranking"].as_array().unwrap();
    let first = ranked[0]["importance"].as_f64().unwrap();
    assert!(
        ranked
            .iter()
            .all(|r| r["importance"].as_f64().unwrap() <= first)
    );
}

#[test]
fn a_relation_is_linearised_without_tables_of_states_and_poles() {
    let bench = Bench::bare();
    bench.write(
        "string.toml",
        r#"
independent = "depth"
connections = ["mud -> string -> atmosphere"]
[components]
mud = { kind = "boundary" }
string = { kind = "line", length = 1.0, bore = 0.1, friction = "polynomial", quadratic = 1e8 }
loss = { kind = "instrument", measures = "drop", of = "string", unit = "bar" }
[inputs]
"mud.flow" = { channel = "q" }
"#,
    );
    let said = bench
        .dgd("linearise --system string.toml --at mud.flow=0.03 --out lin")
        .done();
    assert!(said.contains("without states"), "{said}");
    for part in ["pole", "rates need not be zero", "rotary"] {
        assert!(!said.contains(part), "`{part}` is in {said}");
    }
    let benches = benches();
    let said = benches
        .dgd("linearise --system pump_loop.toml --at pump.speed=80 throttle.opening=0.7 --out lin")
        .done();
    assert!(
        said.contains("integrator") && !said.contains("rotary"),
        "{said}"
    );
}
