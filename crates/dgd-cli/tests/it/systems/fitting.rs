//! Fits: the truth comes back, in any format, to the byte.

use super::{benches, document, estimate, physics, recovers, rms};
use crate::bench::Bench;

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
