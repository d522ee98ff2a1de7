//! What is done block by block gives what is done at once.

use crate::bench::Bench;
use std::process::Command;
use std::thread;

fn bench() -> Bench {
    let bench = Bench::new();
    bench.dgd("convert rig.mat rig.csv").done();
    bench.dgd("convert rig.mat rig.mcap").done();
    // A clock that is found by its growth, and damage that is told.
    let unnamed = bench.text("rig.csv").replacen("t,", "stamp_no,", 1);
    let unnamed = unnamed
        .replacen("\ns,", "\n,", 1)
        .replacen("\n9,", "\n9,x", 1);
    bench.write("unnamed.csv", unnamed);
    bench
}

#[test]
fn convert_writes_the_same_bytes() {
    let bench = bench();
    for input in ["rig.csv", "rig.mcap", "unnamed.csv"] {
        for output in ["csv", "mcap"] {
            let [whole, blocks] = ["whole", "blocks"].map(|name| format!("{name}.{output}"));
            bench.dgd(&format!("convert {input} {whole}")).done();
            bench
                .dgd(&format!("convert {input} {blocks} --in-blocks"))
                .done();
            assert!(
                bench.bytes(&whole) == bench.bytes(&blocks),
                "{input} to {output}"
            );
        }
    }
}

#[test]
fn inspect_finds_the_same() {
    let bench = bench();
    for input in ["rig.csv", "rig.mcap", "unnamed.csv"] {
        for option in ["", " --json"] {
            let whole = bench.dgd(&format!("inspect {input}{option}")).done();
            let blocks = bench.dgd(&format!("inspect {input}{option} --in-blocks"));
            assert_eq!(blocks.done(), whole, "{input}");
        }
    }
}

/// Columns of a file so wide that [`BLOCK`] of its rows are a block: a block is bounded by its values.
const WIDE: usize = 262;
const BLOCK: usize = (1 << 17) / WIDE;

/// Missing rows, missing values, a meter that rests, spikes and a pump that is off for a while; and where one block of the
/// wide file ends and the next begins, a rest of the meter, a longer one each time, and a spike.
fn holed(text: &str) -> String {
    let mut holed: Vec<String> = Vec::new();
    for (k, row) in text.lines().enumerate() {
        let mut cells: Vec<&str> = row.split(',').collect();
        match k {
            300..340 | 2000 | 3543..3550 => continue,
            500..620 | 3030..3050 => *cells.last_mut().unwrap() = "",
            900..960 => cells[4] = "700",
            1200..1500 | 2450..2600 => *cells.last_mut().unwrap() = "0",
            1510..1600 => cells[1] = "",
            2700..2730 => cells[5] = "9999",
            _ => {}
        }
        // Below two rows of names and units.
        let row = holed.len().saturating_sub(2);
        let border = (row + BLOCK / 2) / BLOCK;
        let from = border * BLOCK;
        let rests = [0, 3, 5, 8, 12, 20, 30, 45];
        if row.abs_diff(from) < rests.get(border).copied().unwrap_or(0) {
            cells[4] = "700";
        }
        if border > 0 && (from..from + 2).contains(&row) {
            cells[1] = "900";
        }
        holed.push(cells.join(","));
    }
    holed.join("\n")
}

/// The same with columns that nobody asks for.
fn widened(text: &str) -> String {
    let rows: Vec<String> = (text.lines().enumerate())
        .map(|(k, row)| {
            let more = row.split(',').count()..WIDE;
            let cells = more.map(|n| match k {
                0 => format!(",other{n}"),
                1 => ",".to_owned(),
                _ => format!(",{}", (k + n) % 10),
            });
            row.to_owned() + &cells.collect::<String>()
        })
        .collect();
    rows.join("\n")
}

/// Standard output of `--json` without times and the output's name, and what was warned of.
fn said(bench: &Bench, arguments: &str) -> (serde_json::Value, String) {
    let ran = bench.dgd(&format!("{arguments} --json"));
    let warned = ran.err.clone();
    let mut said: serde_json::Value = serde_json::from_str(&ran.done()).unwrap();
    assert_eq!(said["schema"], "dgd.simulate/1");
    for member in ["seconds", "seconds_by_stage", "out", "figures"] {
        said[member] = serde_json::Value::Null;
    }
    (said, warned)
}

#[test]
fn simulate_writes_the_same_bytes() {
    let bench = bench();
    bench
        .dgd("fit rig.csv --well well.toml --out model.toml")
        .done();
    bench.write("holed.csv", holed(&bench.text("rig.csv")));
    bench.write("wide.csv", widened(&bench.text("holed.csv")));
    bench.dgd("convert wide.csv wide.mcap").done();
    for (options, output) in [
        ("", "csv"),
        ("", "mcap"),
        ("--kind riser", "csv"),
        ("--kind flow --thesis-screening", "csv"),
        ("--kind steady", "csv"),
        ("--window 650:2222.5 --level 140m", "csv"),
        ("--tolerance 1e-7 --solver dormand-prince", "csv"),
    ] {
        for input in ["rig.csv", "rig.mcap", "holed.csv", "wide.csv", "wide.mcap"] {
            simulates_alike(&bench, input, options, output);
        }
    }
    draws_alike(&bench, "wide.csv");
    for (input, least) in [("wide.csv", 8), ("wide.mcap", 7)] {
        let blocks = walked(&bench, input);
        assert!(!blocks.is_empty(), "{input}");
        assert!(blocks.iter().all(|n| *n >= least), "{input}: {blocks:?}");
    }
}

fn simulates_alike(bench: &Bench, input: &str, options: &str, output: &str) {
    let run = format!("simulate {input} --well well.toml --model model.toml {options}");
    let [whole, blocks] = ["whole", "blocks"].map(|name| format!("{name}.{output}"));
    let expected = said(bench, &format!("{run} --out {whole}"));
    let found = said(bench, &format!("{run} --out {blocks} --in-blocks"));
    assert_eq!(found, expected, "{input} {options}");
    assert!(
        bench.bytes(&whole) == bench.bytes(&blocks),
        "{input} {options}"
    );
}

/// Of a run that is short enough to be drawn as it is, the same pictures.
fn draws_alike(bench: &Bench, input: &str) {
    let run = format!("simulate {input} --well well.toml --model model.toml --out run.csv");
    bench.dgd(&format!("{run} --figures whole")).done();
    bench
        .dgd(&format!("{run} --figures blocks --in-blocks"))
        .done();
    for number in 1..=4 {
        let [whole, blocks] = ["whole", "blocks"]
            .map(|folder| bench.text(&format!("{folder}/figure-4-{number}.svg")));
        assert!(whole == blocks, "Figure 4.{number}");
    }
}

/// How many blocks each pass over a recording went through.
fn walked(bench: &Bench, input: &str) -> Vec<usize> {
    let run = format!("simulate {input} --well well.toml --model model.toml --out run.csv");
    let ran = bench.dgd(&format!("{run} --in-blocks -vv"));
    assert_eq!(ran.status, 0, "{}", ran.err);
    let told = ran.err.lines().filter_map(|line| {
        let (_, blocks) = line.split_once("read in ")?;
        blocks.trim_end_matches(" blocks").parse().ok()
    });
    told.collect()
}

#[test]
fn what_cannot_be_simulated_is_refused_alike() {
    let bench = bench();
    bench
        .dgd("fit rig.csv --well well.toml --out model.toml")
        .done();
    let text = bench.text("rig.csv");
    let without: Vec<String> = text
        .lines()
        .map(|row| row.rsplit_once(',').unwrap().0.to_owned())
        .collect();
    bench.write("without.csv", without.join("\n"));
    let silent: Vec<String> = without
        .iter()
        .enumerate()
        .map(|(k, row)| format!("{row},{}", ["NXSPM17", "%"].get(k).unwrap_or(&"")))
        .collect();
    bench.write("silent.csv", silent.join("\n"));
    let jumping: Vec<String> = (text.lines())
        .enumerate()
        .map(|(k, row)| {
            if k > 3000 {
                format!("99999{row}")
            } else {
                row.to_owned()
            }
        })
        .collect();
    bench.write("jumping.csv", jumping.join("\n"));
    bench.write("before.csv", "mine");
    for arguments in [
        "without.csv",
        "silent.csv",
        "jumping.csv",
        "absent.csv",
        "rig.csv --window 8000:9000",
        "rig.csv --out rig.csv",
        "rig.csv --out well.toml/run.csv",
    ] {
        let mut line = format!("simulate {arguments} --well well.toml --model model.toml");
        if !arguments.contains("--out") {
            line += " --out before.csv";
        }
        let whole = bench.dgd(&line);
        let blocks = bench.dgd(&format!("{line} --in-blocks"));
        assert_ne!(whole.status, 0, "{arguments}");
        assert_eq!(blocks.status, whole.status, "{arguments}: {}", blocks.err);
        assert_eq!(blocks.err, whole.err, "{arguments}");
    }
    assert_eq!(bench.text("before.csv"), "mine");
    assert!(bench.names().iter().all(|name| !name.starts_with(".dgd")));
}

#[test]
fn a_unit_that_the_file_contradicts_is_in_every_answer() {
    let bench = bench();
    bench
        .dgd("fit rig.csv --well well.toml --out model.toml")
        .done();
    let text = bench.text("rig.csv");
    let (head, rows) = text.split_once('\n').unwrap();
    let (units, rows) = rows.split_once('\n').unwrap();
    assert!(units.contains("psia"), "{units}");
    let contradicted = units.replacen("psia", "bara", 1);
    bench.write("rig.csv", format!("{head}\n{contradicted}\n{rows}"));
    let simulate = "simulate rig.csv --well well.toml --model model.toml --out run.csv";
    for (line, schema) in [
        ("fit rig.csv --well well.toml --out other.toml", "dgd.fit/1"),
        (simulate, "dgd.simulate/1"),
        (&format!("{simulate} --in-blocks"), "dgd.simulate/1"),
    ] {
        let said = bench.json(line, schema);
        let warnings = said["warnings"].as_array().unwrap();
        let told = |w: &serde_json::Value| w.as_str().unwrap().contains("the file gives `bara`");
        assert!(warnings.iter().any(told), "{line}: {warnings:?}");
    }
}

#[test]
fn what_cannot_be_simulated_in_blocks_is_simulated_whole_and_says_why() {
    let bench = bench();
    bench
        .dgd("fit rig.csv --well well.toml --out model.toml")
        .done();
    let text = bench.text("rig.csv");
    let mut rows: Vec<&str> = text.lines().collect();
    let (early, late) = rows.split_at(1000);
    bench.write("early.csv", early.join("\n"));
    bench.write("late.csv", [&rows[..2], late].concat().join("\n"));
    let sparse = rows.iter().enumerate().map(|(i, row)| {
        let cells = row.split(',').enumerate();
        let kept = |(k, cell)| {
            if k == 0 || i < 2 || (i + k) % 3 == 0 {
                cell
            } else {
                ""
            }
        };
        cells.map(kept).collect::<Vec<_>>().join(",")
    });
    bench.write("sparse.csv", sparse.collect::<Vec<_>>().join("\n"));
    rows.swap(400, 500);
    bench.write("disordered.csv", rows.join("\n"));
    for (arguments, why) in [
        ("sparse.csv --out run.csv", "fewer than half of the rows"),
        ("rig.mat --out run.csv", "column after another"),
        ("rig.csv --out run.mat", "column after another"),
        ("early.csv late.csv --out run.csv", "is joined with"),
        ("disordered.csv --out run.csv", "put in order"),
    ] {
        let line = format!("simulate {arguments} --well well.toml --model model.toml");
        let ran = bench.dgd(&format!("{line} --in-blocks"));
        assert!(ran.err.contains(why), "{}", ran.err);
        let output = arguments.rsplit(' ').next().unwrap();
        let first = bench.bytes(output);
        let told = ran.done();
        assert_eq!(bench.dgd(&line).done(), told);
        assert!(bench.bytes(output) == first);
    }
}

#[test]
fn a_large_recording_that_must_be_read_whole_is_told_without_being_asked() {
    let bench = bench();
    bench
        .dgd("fit rig.csv --well well.toml --out model.toml")
        .done();
    // Holes: they take no room, and nobody reads them, as the other recording is not there.
    for (mebibytes, told) in [(257, true), (255, false)] {
        let file = std::fs::File::create(bench.path("large.csv")).unwrap();
        file.set_len(mebibytes << 20).unwrap();
        let ran = bench.dgd("simulate absent.csv large.csv --well well.toml --model model.toml");
        ran.refused(&["absent.csv"]);
        let why = "is joined with the next recording; simulate them one by one";
        assert_eq!(ran.err.contains(why), told, "{}", ran.err);
        assert_eq!(ran.err.contains("(257 MiB; it takes"), told);
    }
}

#[test]
fn what_cannot_be_done_in_blocks_is_done_whole_and_says_why() {
    let bench = bench();
    let ran = bench.dgd("inspect rig.mat --in-blocks");
    assert!(ran.err.contains("column after another"), "{}", ran.err);
    assert_eq!(ran.done(), bench.dgd("inspect rig.mat").done());
    let ran = bench.dgd("convert rig.csv again.mat --in-blocks");
    assert!(ran.err.contains("column after another"), "{}", ran.err);
    ran.done();
    bench.dgd("convert rig.csv whole.mat").done();
    assert!(bench.bytes("again.mat") == bench.bytes("whole.mat"));
}

#[test]
fn refusals_are_those_of_the_whole_file() {
    let bench = Bench::bare();
    bench.write("words.csv", "a,b\nno,numbers\nat,all\n");
    bench.write("utf16.csv", b"\xff\xfet\0,\0a\0\n\x000\0,\x001\0\n\0");
    bench.write("backward.csv", "t,a\ns,1\n-5,1\n-4,2\n");
    for arguments in [
        "inspect words.csv",
        "inspect utf16.csv",
        "inspect absent.csv",
        "convert words.csv out.csv",
        "convert backward.csv out.mcap",
    ] {
        let whole = bench.dgd(arguments);
        let blocks = bench.dgd(&format!("{arguments} --in-blocks"));
        assert_ne!(whole.status, 0, "{arguments}");
        assert_eq!(blocks.status, whole.status, "{arguments}");
        // That it is read whole may be told before.
        assert!(blocks.err.ends_with(&whole.err), "{}", blocks.err);
        assert!(!bench.names().contains(&"out.mcap".to_owned()));
    }
}

#[test]
fn a_pipe_is_read_once() {
    let bench = Bench::bare();
    let pipe = bench.path("rig.csv");
    let made = Command::new("mkfifo").arg(&pipe).status().unwrap();
    assert!(made.success());
    for arguments in ["inspect rig.csv", "convert rig.csv out.csv --in-blocks"] {
        // The writer is done as soon as somebody has taken its bytes.
        let to = pipe.clone();
        let writer = thread::spawn(move || std::fs::write(to, "t,a\ns,1\n0,1\n1,2\n"));
        bench.dgd(arguments).done();
        writer.join().unwrap().unwrap();
    }
}
