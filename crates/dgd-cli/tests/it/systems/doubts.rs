//! What a recording leaves in doubt is told before a system is held against it.

use super::benches;
use crate::bench::Bench;
use serde_json::Value;

/// Two tanks, every row of whose recording is written anew; `None` leaves it out.
fn altered(alter: impl Fn(usize, &[&str]) -> Option<Vec<String>>) -> Bench {
    let bench = benches();
    let text = bench.text("two_tanks.csv");
    let mut lines = text.lines();
    let heads = lines.by_ref().take(2).map(ToOwned::to_owned);
    let mut rows: Vec<String> = heads.collect();
    rows.extend(lines.enumerate().filter_map(|(i, line)| {
        let cells: Vec<&str> = line.split(',').collect();
        Some(alter(i, &cells)?.join(","))
    }));
    bench.write("two_tanks.csv", rows.join("\n") + "\n");
    bench
}

fn kept(cells: &[&str]) -> Vec<String> {
    cells.iter().map(|&cell| cell.to_owned()).collect()
}

/// What a fit says on the way, and its JSON.
fn fitted(bench: &Bench) -> (String, Value) {
    let ran = bench.dgd("fit two_tanks.csv --system two_tanks.toml --out m.toml");
    assert_eq!(ran.status, 0, "{}", ran.err);
    (ran.err, super::document(bench, "m.json"))
}

#[test]
fn a_gap_and_inputs_without_a_value_are_told_with_the_place() {
    let bench = altered(|i, cells| (!(100..200).contains(&i)).then(|| kept(cells)));
    let (said, json) = fitted(&bench);
    assert!(said.contains("no samples from 396 to 800 s"), "{said}");
    assert!(
        json["issues"].to_string().contains("396 to 800 s"),
        "{json:#}"
    );

    let bench = altered(|i, cells| {
        let mut row = kept(cells);
        if (50..79).contains(&i) {
            row[1] = String::new();
        }
        Some(row)
    });
    let (said, _) = fitted(&bench);
    let told = "`u`, the input `pump.input`, has no value in 29 samples";
    assert_eq!(said.matches(told).count(), 1, "{said}");
}

#[test]
fn rows_without_a_time_are_left_out_and_times_that_run_back_are_refused_with_the_sample() {
    let bench = altered(|i, cells| {
        let mut row = kept(cells);
        if i == 590 {
            row[0] = String::new();
        }
        Some(row)
    });
    let (said, json) = fitted(&bench);
    let told = "left out 1 row without a value of `t`";
    assert!(said.contains(told), "{said}");
    assert!(json["issues"].to_string().contains(told), "{json:#}");
    let bench = altered(|i, cells| {
        let mut row = kept(cells);
        if i == 199 {
            row[0] = "4".to_owned();
        }
        Some(row)
    });
    bench
        .dgd("fit two_tanks.csv --system two_tanks.toml --out m.toml")
        .refused(&["two_tanks.csv", "`t` is 4 in sample 200, after 792"]);
}

#[test]
fn a_transmitter_that_never_moves_is_told_and_gives_no_cause() {
    let bench = altered(|_, cells| {
        let mut row = kept(cells);
        row[2] = "5.0".to_owned();
        Some(row)
    });
    let (said, _) = fitted(&bench);
    assert!(
        said.contains("`level` reads 5 cm in all 401 fitted samples"),
        "{said}"
    );
    bench
        .dgd("diagnose two_tanks.csv --system two_tanks.toml --out d")
        .refused(&["two_tanks.csv", "no instrument changes", "channels"]);
    assert!(!bench.path("d").exists());
    let bench = altered(|_, cells| {
        let mut row = kept(cells);
        row[2] = String::new();
        Some(row)
    });
    bench
        .dgd("fit two_tanks.csv --system two_tanks.toml --out m.toml")
        .refused(&["two_tanks.csv", "no reading of `level`", "hold no number"]);
}

#[test]
fn samples_that_are_fitted_and_held_out_are_told() {
    let bench = benches();
    let system = bench.text("two_tanks.toml");
    bench.write(
        "two_tanks.toml",
        system.replace("[[0.0, 1600.0]]", "[[0.0, 1800.0]]"),
    );
    let (said, _) = fitted(&bench);
    assert!(said.contains("that record.train also contains"), "{said}");
    for (window, why) in [
        ("[[1600.0, 0.0]]", "ends before it begins"),
        ("[[9000.0, 9100.0]]", "the record runs from 0 to 2400"),
    ] {
        bench.write("bad.toml", system.replace("[[0.0, 1600.0]]", window));
        bench
            .dgd("fit two_tanks.csv --system bad.toml --out m.toml")
            .refused(&["two_tanks.csv", "record.train", why]);
    }
}

#[test]
fn a_unit_of_another_dimension_is_refused_unless_the_reading_is_its_own() {
    let bench = benches();
    let system = bench.text("two_tanks.toml");
    bench.write(
        "bar.toml",
        system.replace("unit = \"cm\"", "unit = \"bar\""),
    );
    bench.dgd("system check bar.toml").refused(&[
        "level.unit",
        "`bar` is not a unit of level",
        "gain",
    ]);
    bench.write(
        "own.toml",
        system.replace("unit = \"cm\"", "gain = 9806.65, unit = \"Pa\""),
    );
    bench.dgd("system check own.toml").done();
    let free = system.replace("unit = \"cm\"", "unit = \"Pa\"").replace(
        "[free]\n",
        "[free]\n\"level.gain\" = { start = 9806.65, low = 9000.0, high = 11000.0 }\n",
    );
    bench.write("free.toml", free);
    bench.dgd("system check free.toml").done();
    bench
        .dgd("linearise --system own.toml --at pump.input=5 --out lin")
        .done();
    let linear = super::document(&bench, "lin/linear.json");
    assert_eq!(linear["output_units"], serde_json::json!(["Pa"]));
}

#[test]
fn a_fit_that_is_worse_than_the_mean_is_told() {
    let bench = benches();
    let system = bench.text("two_tanks.toml");
    // Centimetres read as metres.
    bench.write(
        "two_tanks.toml",
        system.replace("unit = \"cm\"", "unit = \"m\""),
    );
    let (said, json) = fitted(&bench);
    for part in [
        "`level` has an error of",
        "its own mean",
        "units and channels",
    ] {
        assert!(said.contains(part), "{said}");
    }
    assert!(
        json["issues"].to_string().contains("its own mean"),
        "{json:#}"
    );
}

#[test]
fn a_shared_end_jittering_stamps_and_a_plant_at_rest_raise_no_doubt() {
    let bench = benches();
    let system = bench.text("two_tanks.toml");
    let (said, _) = fitted(&bench);
    assert!(!said.contains("WARN"), "{said}");
    // The two parts share the sample at 1600 s.
    assert!(system.contains("[[0.0, 1600.0]]"));
    bench.write("two_tanks.toml", system.replace("[[1604.0", "[[1600.0"));
    let (said, _) = fitted(&bench);
    assert!(!said.contains("WARN"), "{said}");
    let bench = altered(|i, cells| {
        let mut row = kept(cells);
        let t = 4 * i32::try_from(i).unwrap() + [0, 1, -1][i % 3] * i32::from(i > 0);
        row[0] = t.to_string();
        Some(row)
    });
    let (said, _) = fitted(&bench);
    assert!(!said.contains("WARN"), "{said}");
}

#[test]
fn a_dead_transmitter_beside_an_empty_one_gives_no_cause_either() {
    let bench = altered(|_, cells| {
        let mut row = kept(cells);
        row[2] = "5.0".to_owned();
        row.push(String::new());
        Some(row)
    });
    let text = bench
        .text("two_tanks.csv")
        .replace("t,u,h2\ns,V,cm", "t,u,h2,h1\ns,V,cm,cm");
    bench.write("two_tanks.csv", text);
    let system = bench.text("two_tanks.toml").replace(
        "[components]\n",
        "[components]\nempty = { kind = \"instrument\", measures = \"level\", of = \"upper\", channel = \"h1\", unit = \"cm\" }\n",
    );
    bench.write("two_tanks.toml", system);
    bench
        .dgd("diagnose two_tanks.csv --system two_tanks.toml --out d")
        .refused(&["no instrument changes"]);
}

#[test]
fn kinds_are_listed_with_what_each_may_hold() {
    let bench = Bench::bare();
    let listed = bench.json("system kinds", "dgd.kinds/1");
    let kinds = listed["kinds"].as_array().unwrap();
    assert_eq!(kinds.len(), 10);
    let tank = kinds.iter().find(|k| k["name"] == "tank").unwrap();
    let area = &tank["properties"][0];
    assert_eq!(
        (&area["name"], &area["unit"]),
        (&"area".into(), &"m2".into())
    );
    assert_eq!(area["needed"], true);
    assert_eq!(
        (&area["low"], &area["low_excluded"]),
        (&0.0.into(), &true.into())
    );
    let ran = bench.dgd("system kinds line");
    for part in [
        "bore",
        "needed for `friction = \"darcy\"`",
        "a number above 0",
    ] {
        assert!(ran.out.contains(part), "{}", ran.out);
    }
    bench
        .dgd("system kinds pipe")
        .refused(&["`pipe` is not a kind", "line", "tank"]);
}

#[test]
fn a_linear_model_tells_the_units_of_its_numbers() {
    let bench = benches();
    bench
        .dgd("linearise --system two_tanks.toml --at pump.input=5 --out lin")
        .done();
    let linear = super::document(&bench, "lin/linear.json");
    // The instrument reads cm; the model's numbers are SI.
    assert_eq!(linear["output_units"], serde_json::json!(["m"]));
    assert_eq!(linear["input_units"], serde_json::json!(["V"]));
    assert_eq!(linear["state_units"], serde_json::json!(["m", "m"]));
}

#[test]
fn what_has_no_name_asks_for_the_accuracy_that_would_excuse_it() {
    let bench = altered(|i, cells| {
        let mut row = kept(cells);
        let level: f64 = row[2].parse().unwrap();
        let t = f64::from(u32::try_from(i).unwrap());
        row[2] = format!("{:.1}", level + 1.2 * (t / 9.0).sin() * (t / 31.0).cos());
        Some(row)
    });
    let diagnose = "diagnose two_tanks.csv --system two_tanks.toml --out d";
    let ran = bench.dgd(diagnose);
    let hint = "no `accuracy` is given for level: a mismatch within accuracy is not counted";
    assert!(
        ran.out.contains("unexplained") && ran.out.contains(hint),
        "{}",
        ran.out
    );
    let stated = bench
        .text("two_tanks.toml")
        .replace("unit = \"cm\"", "unit = \"cm\", accuracy = 1.0");
    bench.write("two_tanks.toml", stated);
    let ran = bench.dgd(diagnose);
    assert!(
        ran.out.contains("consistent") && !ran.out.contains(hint),
        "{}",
        ran.out
    );
}

/// A tank that empties through a valve, with its recording: times, opening, level and one more column.
fn valve(opening: &str, input: &str) -> Bench {
    let bench = Bench::bare();
    bench.write(
        "valve.toml",
        format!(
            r#"
connections = ["tank -> valve -> atmosphere"]
[components]
tank = {{ kind = "tank", area = 1.0 }}
valve = {{ kind = "valve", flow_coefficient = 1e-5 }}
level = {{ kind = "instrument", measures = "level", of = "tank", channel = "h" }}
[initial]
"tank.level" = 1.0
[record]
time = "t"
{input}
"#
        ),
    );
    let row = |i: u32| format!("{i},{opening},{},7\n", 1.0 - 0.01 * f64::from(i));
    let rows: String = (0..30).map(row).collect();
    bench.write("valve.csv", format!("t,z,h,spare\n{rows}"));
    bench
}

/// What a simulation says on the way.
fn said(bench: &Bench) -> String {
    let ran = bench.dgd("simulate valve.csv --system valve.toml --out run.csv");
    assert_eq!(ran.status, 0, "{}", ran.err);
    ran.err
}

#[test]
fn an_opening_beyond_one_is_suspected_to_be_in_per_cent() {
    let bare = "[inputs]\n\"valve.opening\" = { channel = \"z\" }";
    let told = "`z`, the input `valve.opening`, reaches 70, above 1: did you mean `unit = \"%\"`?";
    let found = said(&valve("70", bare));
    assert!(found.contains(told), "{found}");
    let share = said(&valve("0.7", bare));
    // A transmitter that is a little off at its end.
    let end = said(&valve("1.01", bare));
    let percent = bare.replace("\"z\"", "\"z\", unit = \"%\"");
    let percent = said(&valve("70", &percent));
    for found in [share, end, percent] {
        assert!(!found.contains("valve.opening"), "{found}");
    }
}

#[test]
fn an_opening_at_its_default_is_told_beside_columns_that_nothing_uses() {
    let bench = valve("0.7", "");
    let found = said(&bench);
    let told =
        "`valve.opening` stands fully open, as by default, and nothing uses the columns z, spare";
    assert!(found.contains(told), "{found}");
    let checked = bench.dgd("system check valve.toml").done();
    assert!(
        checked.contains("at its default, fully open: valve.opening"),
        "{checked}"
    );
    let told = bench.json("system check valve.toml", "dgd.system-check/1");
    assert_eq!(told["at_default"], serde_json::json!(["valve.opening"]));
}

#[test]
fn an_instrument_without_its_column_is_told_with_the_columns_there_are() {
    let bench = benches();
    let system = bench.text("two_tanks.toml");
    let wrong = system.replace("channel = \"h2\"", "channel = \"h3\"");
    bench.write("wrong.toml", wrong);
    let ran = bench.dgd("simulate two_tanks.csv --system wrong.toml --out run.csv");
    for part in [
        "no column `h3`",
        "it has t, u, h2",
        "`channel` of `level`",
        "wrong.toml",
    ] {
        assert!(ran.err.contains(part), "{}", ran.err);
    }
    for command in [
        "fit two_tanks.csv --out m.toml",
        "diagnose two_tanks.csv --out d",
    ] {
        bench
            .dgd(&format!("{command} --system wrong.toml"))
            .refused(&[
                "two_tanks.csv",
                "no column of any instrument: `h3` for `level`",
                "it has t, u, h2",
                "under [components]",
            ]);
    }
}

#[test]
fn transmitters_without_readings_and_stuck_ones_are_told() {
    let replaced = |column: usize, rows: std::ops::Range<usize>, value: &'static str| {
        altered(move |i, cells| {
            let mut row = kept(cells);
            if rows.contains(&i) {
                value.clone_into(&mut row[column]);
            }
            Some(row)
        })
    };
    let told = |bench: &Bench, what: &str| {
        let (said, json) = fitted(bench);
        assert_eq!(said.matches(what).count(), 1, "{what}: {said}");
        assert!(json["issues"].to_string().contains(what), "{json:#}");
    };
    let blank = altered(|_, cells| Some([kept(cells), vec![String::new()]].concat()));
    let (system, text) = (blank.text("two_tanks.toml"), blank.text("two_tanks.csv"));
    blank.write(
        "two_tanks.csv",
        text.replacen("t,u,h2", "t,u,h2,h1", 1)
            .replacen("s,V,cm", "s,V,cm,cm", 1),
    );
    let upper = "[components]\nupper_level = { kind = \"instrument\", measures = \"level\", of = \"upper\", channel = \"h1\", unit = \"cm\" }\n";
    blank.write("two_tanks.toml", system.replace("[components]\n", upper));
    told(
        &blank,
        "`h1` has no reading in the fitted part: `upper_level` says nothing there",
    );
    told(&replaced(2, 30..9999, ""), "has 30 readings in");
    told(&replaced(2, 100..180, "4.2"), "repeats 4.2");
    // Where no window says where to begin.
    let late = replaced(1, 0..5, "");
    let system = late.text("two_tanks.toml");
    let record = system.find("[record]").unwrap();
    late.write(
        "two_tanks.toml",
        format!("{}[record]\ntime = \"t\"\n", &system[..record]),
    );
    told(
        &late,
        "`u`, the input `pump.input`, has no value in the first 5 samples: runs begin after",
    );
    let (said, _) = fitted(&benches());
    for what in ["repeats", "no reading", "has no value"] {
        assert!(!said.contains(what), "{said}");
    }
}

#[test]
fn a_diagnosis_doubts_the_unit_of_a_reading_that_no_model_comes_near() {
    let bench = benches();
    let system = bench.text("two_tanks.toml");
    let wrong = system.replace("unit = \"cm\"", "unit = \"m\"");
    assert_ne!(wrong, system);
    bench.write("two_tanks.toml", wrong);
    let ran = bench.dgd("diagnose two_tanks.csv --system two_tanks.toml --out d");
    assert_eq!(ran.status, 0, "{}", ran.err);
    let told = "the model does not explain it; are units and channels right?";
    assert!(ran.err.contains(told), "{}", ran.err);
    let json = super::document(&bench, "d/diagnosis.json");
    assert!(json["issues"].to_string().contains(told), "{json:#}");
}

#[test]
fn a_tank_that_spills_is_told_with_the_time() {
    let bench = benches();
    let system = bench.text("two_tanks.toml");
    let low = system.replacen("brim = \"", "brim = \"0.", 1);
    assert_ne!(low, system);
    let upper = "\"upper.level\" = { start = 0.1,";
    assert!(low.contains(upper));
    let low = low.replace(upper, "\"upper.level\" = { start = 0.002,");
    bench.write("low.toml", low);
    let ran = bench.dgd("simulate two_tanks.csv --system low.toml --out s.csv");
    assert_eq!(ran.status, 0, "{}", ran.err);
    let told = "level reaches its brim, from where on what is too much spills, at";
    assert!(ran.err.contains(told), "{}", ran.err);
    let sound = bench.dgd("simulate two_tanks.csv --system two_tanks.toml --out s.csv");
    assert!(!sound.err.contains("brim"), "{}", sound.err);
}
