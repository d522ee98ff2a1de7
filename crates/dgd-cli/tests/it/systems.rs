//! `--system`: any assembly checked, drawn, fitted, simulated, linearised, its sensitivities told.

#[path = "../../examples/benches/physics.rs"]
mod physics;

use crate::bench::{Bench, Ran};
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

#[test]
fn two_tanks_are_recovered_from_the_lower_level_alone() {
    let bench = benches();
    let fit = bench.json(
        "fit two_tanks.csv --system two_tanks.toml --out fitted.toml",
        "dgd.system-fit/1",
    );
    let [upper, lower, x0, x1] = physics::TWO_TANKS;
    recovers(&fit, "upper_outlet.discharge_coefficient", upper, 0.005);
    recovers(&fit, "lower_outlet.discharge_coefficient", lower, 0.005);
    recovers(&fit, "upper.level", x0, 0.02);
    recovers(&fit, "lower.level", x1, 0.02);
    // Uniform noise of 1 mm, rounded to 1 mm: 0.65 mm. Held out starts from a run through the training part.
    for part in ["train", "test"] {
        let off = rms(&fit, "level", part);
        assert!((0.055..0.075).contains(&off), "{part} {off} cm");
    }
    assert_eq!(fit["converged"], true);
    assert_eq!(fit["identifiability"]["rank"], 4);
    assert_eq!(
        bench
            .names()
            .iter()
            .filter(|n| n.starts_with("fitted."))
            .count(),
        4
    );
    let page = bench.text("fitted.html");
    assert!(page.contains("upper_outlet.discharge_coefficient") && page.contains("<svg"));
    for outside in ["http://", "https://", "<script", "src="] {
        let found = page.replace("http://www.w3.org", "");
        assert!(!found.contains(outside), "{outside}");
    }
}

#[test]
fn the_pump_loop_and_the_return_line_are_recovered() {
    let bench = benches();
    let fit = bench.json(
        "fit pump_loop.csv --system pump_loop.toml --out a.toml",
        "dgd.system-fit/1",
    );
    let [c0, roughness, valve] = physics::PUMP_LOOP;
    recovers(&fit, "pump.c0", c0, 0.001);
    recovers(&fit, "line.roughness", roughness, 0.03);
    recovers(&fit, "throttle.flow_coefficient", valve, 0.005);
    let fit = bench.json(
        "fit return_line.csv --system return_line.toml --out b.toml",
        "dgd.system-fit/1",
    );
    let [c0, quadratic, level] = physics::RETURN_LINE;
    recovers(&fit, "pump.c0", c0, 0.001);
    recovers(&fit, "line.quadratic", quadratic, 0.005);
    recovers(&fit, "riser.level", level, 0.001);
}

#[test]
fn simulate_reads_what_fit_wrote_and_gives_the_same_table() {
    let bench = benches();
    bench
        .dgd("fit return_line.csv --system return_line.toml --out fitted.toml")
        .done();
    bench
        .dgd("simulate return_line.csv --system fitted.toml --out run.csv")
        .done();
    assert_eq!(bench.text("run.csv"), bench.text("fitted.csv"));
    assert_eq!(document(&bench, "run.json")["fitted"], true);
    // Fitted again from where it stands, the same.
    let again = bench.json(
        "fit return_line.csv --system fitted.toml --out again.toml",
        "dgd.system-fit/1",
    );
    let (before, low, high) = estimate(&document(&bench, "fitted.json"), "pump.c0");
    let (after, _, _) = estimate(&again, "pump.c0");
    assert!(
        (after - before).abs() < 0.05 * (high - low),
        "{before} {after}"
    );
}

#[test]
fn one_recording_in_any_format_gives_the_same_model() {
    let bench = benches();
    bench
        .dgd("fit two_tanks.csv --system two_tanks.toml --out csv.toml")
        .done();
    let plain = bench.text("csv.toml");
    for (name, more) in [
        ("five.mat", ""),
        ("seven.mat", " --mat-v73"),
        ("log.mcap", ""),
    ] {
        bench
            .dgd(&format!("convert two_tanks.csv {name}{more}"))
            .done();
        bench
            .dgd(&format!(
                "fit {name} --system two_tanks.toml --out other.toml"
            ))
            .done();
        assert_eq!(
            bench.text("other.toml").replace(name, "two_tanks.csv"),
            plain,
            "{name}"
        );
    }
    // Without its row of units as well: the instruments say theirs.
    let bare = bench.text("two_tanks.csv").replacen("s,V,cm\n", "", 1);
    bench.write("bare.csv", bare);
    bench
        .dgd("fit bare.csv --system two_tanks.toml --out other.toml")
        .done();
    assert_eq!(
        bench
            .text("other.toml")
            .replace("bare.csv", "two_tanks.csv"),
        plain
    );
}

#[test]
fn a_clock_is_converted_once_whoever_says_its_unit() {
    let bench = benches();
    let (plain, system) = (bench.text("two_tanks.csv"), bench.text("two_tanks.toml"));
    let values = |divisor: f64| -> String {
        let numbers = plain.lines().filter_map(|line| {
            let (t, rest) = line.split_once(',')?;
            Some(format!("{},{rest}\n", t.parse::<f64>().ok()? / divisor))
        });
        numbers.collect()
    };
    let tags: Vec<&str> = plain.lines().next().unwrap().split(',').collect();
    let head = |clock: &str| {
        let mut tags: Vec<String> = tags.iter().map(|t| (*t).to_owned()).collect();
        tags[0] = format!("t{clock}");
        tags.join(",") + "\n"
    };
    let in_minutes = system
        .replace("time = \"t\"", "time = \"t\"\nunit = \"min\"")
        .replace("[[0.0, 1600.0]]", "[[0.0, 26.67]]")
        .replace("[[1604.0, 2400.0]]", "[[26.7, 40.0]]");
    assert_ne!(in_minutes, system);
    let fitted = |file: String, system: &str| {
        bench.write("clock.csv", file);
        bench.write("clock.toml", system);
        let fit = bench.json(
            "fit clock.csv --system clock.toml --out out.toml",
            "dgd.system-fit/1",
        );
        estimate(&fit, "upper_outlet.discharge_coefficient").0
    };
    let expected = fitted(head("") + &values(1.0), &system);
    for (clock, divisor, system) in [
        ("", 60.0, &in_minutes),
        (" [min]", 60.0, &in_minutes),
        (" [s]", 1.0, &in_minutes),
        (" [min]", 60.0, &system),
        (" [s]", 1.0, &system),
    ] {
        let found = fitted(head(clock) + &values(divisor), system);
        let off = (found / expected - 1.0).abs();
        assert!(off < 1e-5, "t{clock}: {found} for {expected}");
    }
}

#[test]
fn train_and_test_may_be_columns_of_their_own_and_of_their_own_length() {
    let bench = benches();
    let text = bench.text("two_tanks.csv");
    let rows: Vec<Vec<&str>> = text
        .lines()
        .skip(2)
        .map(|l| l.split(',').collect())
        .collect();
    let mut own = String::from("uEst,yEst,uVal,yVal\n");
    for row in &rows {
        own.push_str(&format!("{0},{1},{0},{1}\n", row[1], row[2]));
    }
    bench.write("own.csv", own);
    let system = bench.text("two_tanks.toml");
    let head = system.split("[record]").next().unwrap();
    bench.write(
        "own.toml",
        format!(
            "{head}[record]\nstep = 4.0\ntrain = {{ channels = {{ u = \"uEst\", h2 = \"yEst\" }} }}\n\
             test = {{ channels = {{ u = \"uVal\", h2 = \"yVal\" }} }}\n"
        ),
    );
    let fit = bench.json(
        "fit own.csv --system own.toml --out own-fit.toml",
        "dgd.system-fit/1",
    );
    let (train, test) = (rms(&fit, "level", "train"), rms(&fit, "level", "test"));
    assert!((train - test).abs() < 1e-12, "{train} {test}");
    assert_eq!(fit["windows"][1]["held_out"], true);
}

#[test]
fn a_static_relation_over_depth_is_fitted_and_drawn_over_depth() {
    let bench = Bench::bare();
    let mut rows = String::from("depth,q,p\nft,l/s,bar\n");
    for i in 0..60 {
        let q = 20.0 + f64::from(i % 7);
        // 1e-4 m³/(s √Pa) through a valve to the open air.
        let drop = (q * 1e-3 / 1e-4_f64).powi(2);
        rows.push_str(&format!(
            "{},{q},{}\n",
            100 + 10 * i,
            (101_325.0 + drop) * 1e-5
        ));
    }
    bench.write("well.csv", rows);
    bench.write(
        "static.toml",
        r#"
independent = "depth"
connections = ["feed -> choke -> atmosphere"]
[components]
feed = { kind = "boundary", flow = 0.0 }
choke = { kind = "valve" }
gauge = { kind = "instrument", measures = "pressure", of = "choke.inlet", channel = "p", unit = "bar" }
[inputs]
"feed.flow" = { channel = "q", unit = "l/s" }
[free]
"choke.flow_coefficient" = { start = 3e-4, low = 1e-5, high = 1e-3 }
[record]
time = "depth"
train = { windows = [[100.0, 500.0]] }
test = { windows = [[510.0, 690.0]] }
"#,
    );
    let fit = bench.json(
        "fit well.csv --system static.toml --out f.toml",
        "dgd.system-fit/1",
    );
    // Depths are no clock: they are not converted, and another unit is told.
    let said = |unit: &str| {
        let system = bench.text("static.toml");
        let time = format!("time = \"depth\"\nunit = \"{unit}\"");
        bench.write("unit.toml", system.replace("time = \"depth\"", &time));
        bench
            .dgd("fit well.csv --system unit.toml --out u.toml")
            .err
    };
    assert!(
        said("m")
            .contains("column `depth` is written in ft, `[record]` of unit.toml reads it in m")
    );
    assert!(!said("ft").contains("is written in"));
    let (value, _, _) = estimate(&fit, "choke.flow_coefficient");
    assert!((value - 1e-4).abs() < 1e-9, "{value}");
    assert!(rms(&fit, "gauge", "test") < 1e-6);
    assert!(bench.text("f.html").contains(">Depth<"));
    assert!(bench.text("f.csv").starts_with("depth,window,held_out,"));
}

#[test]
fn exactly_one_of_well_and_system_is_taken() {
    let bench = benches();
    for command in ["fit two_tanks.csv", "simulate two_tanks.csv"] {
        let none = bench.dgd(command);
        none.refused(&["--well", "--system"]);
        bench
            .dgd(&format!(
                "{command} --well well.toml --system two_tanks.toml"
            ))
            .refused(&["cannot be used with"]);
    }
    for wrong in [
        "--delays 0:3",
        "--figures d",
        "--fixed-exponents",
        "--thesis-screening",
    ] {
        bench
            .dgd(&format!(
                "fit two_tanks.csv --system two_tanks.toml {wrong}"
            ))
            .refused(&["cannot be used with"]);
    }
    bench
        .dgd("fit two_tanks.csv two_tanks.csv --system two_tanks.toml")
        .refused(&["one recording"]);
}

#[test]
fn a_recording_that_does_not_fit_the_system_is_told_with_the_mend() {
    let bench = benches();
    let system = bench.text("two_tanks.toml");
    bench.write(
        "bad.toml",
        system.replace("channel = \"u\"", "channel = \"volts\""),
    );
    bench.dgd("fit two_tanks.csv --system bad.toml").refused(&[
        "two_tanks.csv",
        "no column `volts`",
        "pump.input",
        "t, u, h2",
        "[inputs]",
        "bad.toml",
    ]);
    bench.write(
        "bad.toml",
        system.replace("[[0.0, 1600.0]]", "[[9000.0, 9100.0]]"),
    );
    bench.dgd("fit two_tanks.csv --system bad.toml").refused(&[
        "two_tanks.csv",
        "record.train",
        "9000",
    ]);
    bench.write(
        "still.toml",
        system
            .split("[free]")
            .next()
            .unwrap()
            .replace("{ start = 0.1, low = 0.0, high = 0.4 }", "0.1")
            .replace("area = 1e-4", "area = 1e-4, discharge_coefficient = 0.6")
            .replace(
                "area = 1.2e-4",
                "area = 1.2e-4, discharge_coefficient = 0.6",
            )
            + "[record]\ntime = \"t\"\n",
    );
    bench
        .dgd("fit two_tanks.csv --system still.toml")
        .refused(&["still.toml", "nothing free", "[free]"]);
    bench
        .dgd("simulate two_tanks.csv --system still.toml")
        .done();
    bench
        .dgd("sensitivities two_tanks.csv --system still.toml --out s")
        .refused(&["nothing free"]);
}

#[test]
fn a_column_in_another_unit_than_the_instrument_reads_is_told() {
    let bench = benches();
    let recording = bench.text("two_tanks.csv").replacen("s,V,cm", "s,V,m", 1);
    bench.write("metres.csv", recording);
    let ran = bench.dgd("simulate metres.csv --system two_tanks.toml");
    assert!(
        ran.err.contains("written in m") && ran.err.contains("cm"),
        "{}",
        ran.err
    );
}

#[test]
fn results_never_replace_the_description_and_a_failed_fit_leaves_nothing() {
    let bench = benches();
    let before = bench.names();
    bench
        .dgd("fit two_tanks.csv --system two_tanks.toml --out two_tanks.toml")
        .refused(&["input of this run"]);
    // The simulation would stand where the recording stands.
    bench
        .dgd("fit two_tanks.csv --system return_line.toml --out fitted.toml")
        .refused(&["two_tanks.csv"]);
    bench
        .dgd("fit two_tanks.csv --system two_tanks.toml --out model.html")
        .refused(&["model.html"]);
    assert_eq!(bench.names(), before);
}

#[test]
fn the_same_fit_gives_the_same_bytes() {
    let bench = benches();
    let files = ["m.toml", "m.csv", "m.html", "m.json"];
    let run = || -> Vec<Vec<u8>> {
        bench
            .dgd("fit pump_loop.csv --system pump_loop.toml --out m.toml")
            .done();
        files.iter().map(|f| bench.bytes(f)).collect()
    };
    assert_eq!(run(), run());
}

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
        .refused(&["pit.toml", "no steady state", "pit.level=..."]);
    let told = bench.json(
        "linearise --system pit.toml --at feed.flow=0.01 pit.level=1.5 --out lin",
        "dgd.linear/1",
    );
    let b = told["continuous"]["B"][0][0].as_f64().unwrap();
    assert!((b - 0.5).abs() < 1e-9, "{b}");
    assert_eq!(told["operating_point"]["outputs"]["gauge"], 1.5);
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
    assert!(page.contains("not told") && page.contains("<svg"));
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
    assert!(bench.text("d/report.html").contains("reading_delay"));
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

#[test]
fn every_command_of_the_page_runs() {
    let page = include_str!("../../SYSTEMS.md");
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
