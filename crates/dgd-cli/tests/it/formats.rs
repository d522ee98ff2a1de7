use crate::bench::{Bench, DELAY_S, TAGS};
use std::collections::BTreeMap;

fn copies(bench: &Bench) {
    for target in ["rig.csv", "rig.mcap", "rig73.mat --mat-v73"] {
        bench.dgd(&format!("convert rig.mat {target}")).done();
    }
}

#[test]
fn one_recording_in_four_formats_gives_one_model() {
    let bench = Bench::new();
    copies(&bench);
    let mut models = Vec::new();
    for name in ["rig.mat", "rig73.mat", "rig.csv", "rig.mcap"] {
        bench
            .dgd(&format!("fit {name} --well well.toml --out model.toml"))
            .done();
        let model = bench.text("model.toml");
        assert!(model.contains(name), "{model}");
        models.push(model.replace(name, "rig"));
    }
    assert!(models.iter().all(|m| *m == models[0]), "{models:#?}");
}

#[test]
fn the_known_delay_is_found() {
    let bench = Bench::new();
    let fit = bench.json("fit rig.mat --well well.toml", "dgd.fit/1");
    assert_eq!(fit["delay"]["best_s"], DELAY_S);
    assert_eq!(fit["samples"], 4000);
    assert!(fit["kept"].as_u64().unwrap() > 3500, "{fit:#}");
}

/// In which rows the values of a shorter column belong, nothing says.
#[test]
fn a_column_of_another_length_does_not_get_into_rows() {
    let bench = Bench::new();
    let column = |tag: &str, values: usize| dgd_recording::Column {
        tag: tag.into(),
        unit: None,
        values: (0..values).map(|i| i as f64).collect(),
    };
    let table = dgd_recording::Table {
        columns: vec![column("t", 100), column("slow", 10), column("a", 100)],
        ..Default::default()
    };
    let mut file = std::io::Cursor::new(Vec::new());
    dgd_export::write_mat5(&table, "rig", &mut file).unwrap();
    bench.write("ragged.mat", file.into_inner());
    for target in ["ragged.csv", "ragged.mcap"] {
        let ran = bench.dgd(&format!("convert ragged.mat {target}"));
        assert!(ran.err.contains("`rig.slow` of 10"), "{}", ran.err);
        let said = ran.done();
        assert!(said.contains("2 columns"), "{said}");
    }
    assert!(!bench.text("ragged.csv").contains("slow"));
    bench.dgd("convert ragged.mat again.mat").done();
    let said = bench.dgd("inspect again.mat");
    assert!(said.done().contains("slow"));
}

/// A clock that is not called `t` keeps its name, and one that was set back is refused from a log as from a text.
#[test]
fn a_log_keeps_the_name_of_the_clock_and_that_it_was_set_back() {
    let bench = Bench::new();
    copies(&bench);
    let text = bench.text("rig.csv");
    let mut rows: Vec<&str> = text.lines().collect();
    let named = rows[0].replacen('t', "elapsed", 1);
    rows[0] = &named;
    bench.write("named.csv", rows.join("\n"));
    bench.write(
        "well2.toml",
        bench
            .text("well.toml")
            .replace("tag = \"t\"", "tag = \"elapsed\""),
    );
    let back = |line: &str| {
        let (time, rest) = line.split_once(',').unwrap();
        format!("{},{rest}", time.parse::<f64>().unwrap() - 600.0)
    };
    let later: Vec<String> = rows[2002..].iter().map(|line| back(line)).collect();
    let set_back = [rows[..2002].join("\n"), later.join("\n")].join("\n");
    bench.write("back.csv", set_back);
    bench.dgd("convert named.csv named.mcap").done();
    bench.dgd("convert back.csv back.mcap").done();
    bench.dgd("fit named.mcap --well well2.toml").done();
    for name in ["back.csv", "back.mcap"] {
        bench
            .dgd(&format!("fit {name} --well well2.toml"))
            .refused(&["the clock jumps back by 599 s", "share the same times"]);
    }
}

/// Writes rows of `rig.csv` as a file of its own, whose clock tells the date.
fn dated(bench: &Bench, rows: std::ops::Range<usize>, name: &str) {
    let text = bench.text("rig.csv");
    let mut lines = text.lines();
    let mut out = format!("{}\n", lines.next().unwrap());
    for (i, line) in lines.enumerate().filter(|(i, _)| rows.contains(i)) {
        let (_, values) = line.split_once(',').unwrap();
        let (hour, minute, second) = (i / 3600, i / 60 % 60, i % 60);
        out += &format!("2014-10-07T{hour:02}:{minute:02}:{second:02}Z,{values}\n");
    }
    bench.write(name, out);
}

#[test]
fn a_recording_cut_in_two_is_the_same_recording() {
    let bench = Bench::new();
    copies(&bench);
    for (rows, name) in [
        (0..4000, "whole.csv"),
        (0..2000, "early.csv"),
        (2000..4000, "late.csv"),
        (1900..4000, "shared.csv"),
    ] {
        dated(&bench, rows, name);
    }
    let fitted = |files: &str| {
        let ran = bench.dgd(&format!("fit {files} --well well.toml --out model.toml"));
        ran.done();
        let model = bench.text("model.toml");
        let (_, numbers) = model.split_once("[friction]").unwrap();
        let (numbers, _) = numbers.split_once("[data]").unwrap();
        numbers.to_owned()
    };
    let whole = fitted("whole.csv");
    assert_eq!(fitted("early.csv late.csv"), whole);
    assert_eq!(fitted("early.csv shared.csv"), whole);
    bench
        .dgd("fit late.csv early.csv --well well.toml")
        .refused(&["early.csv", "before late.csv", "in time order"]);
}

#[test]
fn clocks_without_dates_that_show_another_order_are_told_and_those_in_order_are_not() {
    let bench = Bench::new();
    copies(&bench);
    let text = bench.text("rig.csv");
    let mut lines = text.lines();
    let head = [lines.next().unwrap(), lines.next().unwrap()].join("\n");
    let rows: Vec<&str> = lines.take(4000).collect();
    for (rows, name) in [(&rows[..2000], "early.csv"), (&rows[2000..], "late.csv")] {
        bench.write(name, format!("{head}\n{}\n", rows.join("\n")));
    }
    let said = |files: &str| {
        let ran = bench.dgd(&format!("fit {files} --well well.toml --out model.toml"));
        assert_eq!(ran.status, 0, "{}", ran.err);
        ran.err
    };
    let reversed = said("late.csv early.csv");
    for part in [
        "early.csv: its clock reads 0 to 1999 s",
        "late.csv, given before it, 2000 to 3999 s",
        "in time order",
    ] {
        assert!(reversed.contains(part), "{reversed}");
    }
    let ordered = said("early.csv late.csv");
    assert!(!ordered.contains("time order"), "{ordered}");
}

#[test]
fn a_window_may_be_told_by_dates_and_the_answer_tells_them() {
    let bench = Bench::new();
    copies(&bench);
    dated(&bench, 0..4000, "whole.csv");
    // The first line below the names tells units, so that the first sample is of one second later.
    let of_dates = "--window 2014-10-07T00:10:01/01:00:00";
    let fitted = |window: &str| {
        bench
            .dgd(&format!("fit whole.csv --well well.toml {window}"))
            .done();
        let model = bench.text("model.toml");
        model
            .lines()
            .filter(|l| !l.contains("recordings"))
            .collect::<Vec<_>>()
            .join("\n")
    };
    assert_eq!(fitted(of_dates), fitted("--window 600:3599"));
    let ran = |window: &str| {
        bench
            .dgd(&format!(
                "simulate whole.csv --well well.toml {window} --out run.csv"
            ))
            .done();
        bench.text("run.csv")
    };
    assert_eq!(ran(of_dates), ran("--window 600:3599"));

    let said = bench.json(
        &format!("diagnose whole.csv --well well.toml {of_dates} --out d"),
        "dgd.diagnosis/1",
    );
    assert_eq!(said["began"], "2014-10-07T00:00:01Z");
    let report = bench.text("d/report.html");
    assert!(report.contains("0 is 2014-10-07 00:00:01 UTC"));
    assert!(report.contains("--window 2014-10-07T00:10:01/2014-10-07T01:00:00"));

    // Where nothing tells when all of it was taken, there are no dates.
    dated(&bench, 0..1000, "early.csv");
    dated(&bench, 3500..4000, "late.csv");
    for (files, keeps) in [
        ("rig.csv", "not all of the recordings have"),
        (
            "early.csv late.csv",
            "not all of the recordings lie where theirs say",
        ),
    ] {
        bench
            .dgd(&format!("fit {files} --well well.toml {of_dates}"))
            .refused(&[keeps, "3h:5h"]);
    }
}

#[test]
fn a_window_that_holds_nothing_is_refused_with_what_there_is_and_hours_that_are_seconds_are_told() {
    let bench = Bench::new();
    copies(&bench);
    dated(&bench, 0..4000, "whole.csv");
    let fit =
        |window: &str| bench.dgd(&format!("fit whole.csv --well well.toml --window {window}"));
    // The stamps are of UTC, the dates of who knows where.
    fit("2014-10-07T02:10:00/03:00:00").refused(&[
        "holds 0 samples",
        "it spans 2014-10-07T00:00:01Z to 2014-10-07T01:06:39Z; dates without a zone are read as UTC",
    ]);
    let zoned = fit("2014-10-07T02:10:00Z/2014-10-07T03:00:00Z");
    assert!(!zoned.err.contains("without a zone"), "{}", zoned.err);
    zoned.refused(&["it spans 2014-10-07T00:00:01Z"]);
    fit("2h:3h").refused(&["holds 0 samples", "for hours write 3h:5h"]);
    fit("3:5").refused(&["--window 3:5 is 2 s long; for hours write 3h:5h"]);
    let long = fit("0h:1h");
    assert!(!long.err.contains("hours are written"), "{}", long.err);
    long.done();
}

#[test]
fn files_of_one_job_in_other_units_are_refused_with_both_names() {
    let bench = Bench::new();
    copies(&bench);
    let text = bench.text("rig.csv");
    assert!(text.contains("gpm"), "{}", &text[..300]);
    bench.write("day1.csv", &text);
    bench.write("day2.csv", text.replacen("gpm", "l/min", 1));
    bench
        .dgd("fit day1.csv day2.csv --well well.toml")
        .refused(&[
            "day2.csv",
            "is in l/min here but in gpm in day1.csv",
            "convert one of them",
        ]);
}

#[test]
fn a_clock_that_cannot_be_read_is_not_called_absent() {
    let bench = Bench::new();
    copies(&bench);
    let text = bench.text("rig.csv");
    let (head, rows) = text.split_once('\n').unwrap();
    let mut out = format!("{head}\n");
    for line in rows.lines() {
        let (stamp, values) = line.split_once(',').unwrap();
        out += &if stamp.starts_with(|c: char| c.is_ascii_digit()) {
            format!("26/10/24 at {stamp},{values}\n")
        } else {
            format!("{line}\n")
        };
    }
    bench.write("odd.csv", out);
    bench.dgd("fit odd.csv --well well.toml").refused(&[
        "without a number (the first is `26/10/24 at 0",
        "the year in four digits and first",
        "well.toml, line",
    ]);
}

#[test]
fn a_date_beside_the_clock_does_not_tell_when_a_recording_began() {
    let bench = Bench::new();
    copies(&bench);
    let text = bench.text("rig.csv");
    let mut lines = text.lines();
    let head = lines.next().unwrap();
    // Two of one day, each from 0 s on.
    let samples: Vec<&str> = lines
        .filter(|line| line.starts_with(|c: char| c.is_ascii_digit()))
        .collect();
    let of_a_day = |samples: &[&str]| {
        let mut out = format!("{head},Date\n");
        for (i, line) in samples.iter().enumerate() {
            let (_, values) = line.split_once(',').unwrap();
            out += &format!("{i},{values},2014-10-07\n");
        }
        out
    };
    bench.write("a.csv", of_a_day(&samples[..2000]));
    bench.write("b.csv", of_a_day(&samples[2000..4000]));
    let ran = bench.dgd("fit a.csv b.csv --well well.toml");
    assert!(!ran.err.contains("left out"), "{}", ran.err);
    ran.done();
    let fit = bench.json("fit a.csv b.csv --well well.toml", "dgd.fit/1");
    assert_eq!(fit["samples"], 4000, "{fit:#}");
}

/// Columns of a CSV as text, under the last part of their tag: HDF5 orders them by name.
fn by_tag(text: &str) -> BTreeMap<String, Vec<String>> {
    let mut rows = text.lines().map(|line| line.split(','));
    let tags: Vec<&str> = rows.next().unwrap().collect();
    let mut columns = vec![Vec::new(); tags.len()];
    for row in rows {
        for (column, cell) in columns.iter_mut().zip(row) {
            column.push(cell.to_owned());
        }
    }
    let short = |tag: &&str| tag.rsplit('.').next().unwrap().to_owned();
    tags.iter().map(short).zip(columns).collect()
}

#[test]
fn convert_keeps_every_value_there_and_back() {
    let bench = Bench::new();
    copies(&bench);
    for name in ["rig.mat", "rig73.mat", "rig.mcap"] {
        bench.dgd(&format!("convert {name} again.csv")).done();
        let (again, first) = (bench.text("again.csv"), bench.text("rig.csv"));
        assert!(by_tag(&again) == by_tag(&first), "{name}");
    }
}

#[test]
fn a_description_suits_what_its_file_was_converted_to() {
    let bench = Bench::new();
    copies(&bench);
    // As another struct would be called.
    bench.write(
        "gom.csv",
        bench.text("rig.csv").replace("recording.", "gom."),
    );
    for (from, to) in [
        ("gom.csv", "again.mat"),
        ("gom.csv", "again.mat --mat-v73"),
        ("gom.csv", "gom.mcap"),
        ("gom.mcap", "again.mat"),
        ("again.mat", "again.mcap"),
        ("again.mcap", "again.mat"),
    ] {
        bench.dgd(&format!("convert {from} {to}")).done();
        let file = to.split(' ').next().unwrap();
        bench.dgd(&format!("fit {file} --well well.toml")).done();
    }
    bench.dgd("convert rig.csv other.mat --root other").done();
    let said = bench.json("inspect other.mat", "dgd.inspect/1");
    let tags = said["columns"].as_array().unwrap().iter();
    let tags: Vec<&str> = tags.map(|c| c["tag"].as_str().unwrap()).collect();
    assert!(tags.iter().all(|tag| tag.starts_with("other.")), "{tags:?}");
}

#[test]
fn convert_says_the_formats_and_the_shape_as_json() {
    let bench = Bench::new();
    let said = bench.json("convert rig.mat rig.csv", "dgd.convert/1");
    assert_eq!(
        (&said["rows"], &said["columns"]),
        (&4000.into(), &10.into())
    );
}

#[test]
fn inspect_finds_clock_steps_and_channels() {
    let bench = Bench::new();
    copies(&bench);
    for name in ["rig.mat", "rig73.mat", "rig.csv", "rig.mcap"] {
        let said = bench.json(&format!("inspect {name}"), "dgd.inspect/1");
        assert_eq!(said["rows"], 4000, "{name}");
        assert_eq!(said["clock"]["step_s"], 1.0, "{name}");
        let columns = said["columns"].as_array().unwrap();
        let of = |tag: &str| {
            columns
                .iter()
                .find(|c| c["tag"].as_str().unwrap().ends_with(tag))
                .unwrap()
        };
        let quantum = of(TAGS[3])["quantum"].as_f64().unwrap();
        assert!((quantum - 0.5).abs() < 1e-9, "{name}: {quantum}");
        assert_eq!(of(TAGS[8])["samples"], 4000);
    }
}

#[test]
fn inspect_tells_samples_that_find_their_step_taken() {
    let bench = Bench::bare();
    // A mean of 1 s, but most steps near the median of 1.61 s.
    let stamps = (0..200).flat_map(|i| [1.61, 2.0].map(|t| f64::from(2 * i) + t));
    let rows: Vec<String> = stamps.map(|t| format!("{t},1\n")).collect();
    let rows = rows.concat();
    bench.write("rig.csv", format!("time [s],FT4\n0,1\n{rows}"));
    let said = bench.json("inspect rig.csv", "dgd.inspect/1");
    let clock = &said["clock"];
    assert!(clock["crowded"].as_u64() > Some(100), "{clock}");
    assert_eq!(clock["duplicates"], 0);
}

#[test]
fn a_table_without_time_is_inspected_and_says_so() {
    let bench = Bench::bare();
    bench.write("flow.csv", "FT4,PT1\ngpm,psia\n3,1\n1,2\n2,1\n");
    let said = bench.json("inspect flow.csv", "dgd.inspect/1");
    assert!(said["clock"].is_null());
    assert_eq!(said["rows"], 3);
    assert!(bench.dgd("inspect flow.csv").done().contains("FT4"));
}

#[test]
fn a_proposed_well_is_written_with_what_is_left_to_fill_in() {
    let bench = Bench::bare();
    bench.write("rig.csv", "t,FT4,PT1\ns,gpm,psia\n0,1,2\n1,2,3\n2,3,4\n");
    bench.dgd("inspect rig.csv --propose proposed.toml").done();
    assert!(bench.text("proposed.toml").contains("density = \"? sg\""));
    // Once it has been filled in nobody writes over it.
    let again = bench.dgd("inspect rig.csv --propose proposed.toml");
    assert_eq!(again.status, 1, "{again:?}");
    assert!(again.err.contains("completed by hand"), "{}", again.err);
    // Not yet a description: the fit shows the lines to fill in.
    bench
        .dgd("fit rig.csv --well proposed.toml")
        .refused(&["proposed.toml:4", "`density` is not filled in"]);
}

#[test]
fn every_help_exits_0_and_shows_examples() {
    let bench = Bench::bare();
    assert!(bench.dgd("--help").done().contains("Examples:"));
    for command in ["inspect", "fit", "simulate", "mask", "convert"] {
        let help = bench.dgd(&format!("{command} --help")).done();
        assert!(help.contains("Examples:"), "{command}");
        assert!(help.contains("--json"), "{command}");
    }
    assert!(bench.dgd("demo --help").done().contains("--out"));
    assert!(bench.dgd("--version").done().starts_with("dgd "));
}

/// As historians write them: by time or by tag.
#[test]
fn one_reading_a_line_gives_the_answer_of_the_table() {
    let bench = Bench::new();
    copies(&bench);
    let text = bench.text("rig.csv");
    let rows: Vec<Vec<&str>> = text.lines().map(|l| l.split(',').collect()).collect();
    let (tags, units) = (&rows[0], &rows[1]);
    let reading =
        |row: &Vec<&str>, at: usize| format!("{},{},{},{}\n", row[0], tags[at], row[at], units[at]);
    let by_time = |row| (1..tags.len()).map(move |at| reading(row, at));
    let by_tag = |at| rows[2..].iter().map(move |row| reading(row, at));
    let (by_time, by_tag): (String, String) = (
        rows[2..].iter().flat_map(by_time).collect(),
        (1..tags.len()).flat_map(by_tag).collect(),
    );
    let model = |name: &str| {
        let fit = format!("fit {name} --well well.toml --out model.toml");
        bench.dgd(&fit).done();
        bench.text("model.toml").replace(name, "rig")
    };
    let table = model("rig.csv");
    for (name, readings) in [("by_time.csv", by_time), ("by_tag.csv", by_tag)] {
        bench.write(name, format!("t,tag,value,unit\n{readings}"));
        assert_eq!(model(name), table, "{name}");
    }
}

/// As archives file them: a reading of a channel where it differs from the last that was filed, and the one before; by time in a table, or one a line.
#[test]
fn readings_by_events_are_joined_and_give_the_delay_of_the_table() {
    let bench = Bench::new();
    copies(&bench);
    let text = bench.text("rig.csv");
    let rows: Vec<Vec<&str>> = text.lines().map(|l| l.split(',').collect()).collect();
    let (tags, readings) = (&rows[0], &rows[2..]);
    let value = |row: &[&str], at: usize| row[at].parse::<f64>().unwrap_or(f64::NAN);
    let filed: Vec<Vec<bool>> = (1..tags.len())
        .map(|at| {
            let mut filed = vec![false; readings.len()];
            let mut last = 0;
            for i in 1..readings.len() {
                let moved = (value(&readings[i], at) - value(&readings[last], at)).abs();
                // Half a percent of what it reads.
                if moved > 0.005 * value(&readings[last], at).abs() {
                    filed[i - 1] = true;
                    filed[i] = true;
                    last = i;
                }
            }
            (filed[0], filed[readings.len() - 1]) = (true, true);
            filed
        })
        .collect();
    let (mut wide, mut long) = (
        rows[0].join(",") + "\n" + &rows[1].join(",") + "\n",
        String::from("t,tag,value\n"),
    );
    for (i, row) in readings.iter().enumerate() {
        let of = |at: usize| if filed[at - 1][i] { row[at] } else { "" };
        let cells: Vec<&str> = (1..tags.len()).map(of).collect();
        if cells.iter().any(|cell| !cell.is_empty()) {
            wide += &format!("{},{}\n", row[0], cells.join(","));
        }
        for at in (1..tags.len()).filter(|at| filed[at - 1][i]) {
            long += &format!("{},{},{}\n", row[0], tags[at], row[at]);
        }
    }
    bench.write("wide.csv", wide);
    bench.write("long.csv", long);
    for name in ["wide.csv", "long.csv"] {
        let ran = bench.dgd(&format!("fit {name} --well well.toml --json"));
        assert!(ran.err.contains("as an archive files them"), "{}", ran.err);
        let fit: serde_json::Value = serde_json::from_str(&ran.done()).unwrap();
        let delay_s = fit["delay"]["best_s"].as_f64().unwrap();
        assert!((delay_s - DELAY_S).abs() <= 1.0, "{name}: {delay_s}");
    }
}
