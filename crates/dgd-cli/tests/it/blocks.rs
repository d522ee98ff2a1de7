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

/// Standard output of `--json` without times and the output's name.
fn said(bench: &Bench, arguments: &str) -> serde_json::Value {
    let mut said = bench.json(arguments, "dgd.simulate/1");
    for member in ["seconds", "seconds_by_stage", "out", "figures"] {
        said[member] = serde_json::Value::Null;
    }
    said
}

#[test]
fn simulate_writes_the_same_bytes() {
    let bench = bench();
    bench
        .dgd("fit rig.csv --well well.toml --out model.toml")
        .done();
    // Missing rows, a missing value, a meter that rests, and a pump that is off for a while.
    let text = bench.text("rig.csv");
    let rows: Vec<&str> = text.lines().collect();
    let mut holed: Vec<String> = Vec::new();
    for (k, row) in rows.iter().enumerate() {
        let mut cells: Vec<&str> = row.split(',').collect();
        match k {
            300..340 | 2000 => continue,
            500..620 => *cells.last_mut().unwrap() = "",
            900..960 => cells[4] = "700",
            1200..1500 => *cells.last_mut().unwrap() = "0",
            1510..1600 => cells[1] = "",
            2500..2530 => cells[5] = "9999",
            _ => {}
        }
        holed.push(cells.join(","));
    }
    bench.write("holed.csv", holed.join("\n"));
    bench.dgd("convert holed.csv holed.mcap").done();
    for input in ["rig.csv", "rig.mcap", "holed.csv", "holed.mcap"] {
        for (options, output) in [
            ("", "csv"),
            ("", "mcap"),
            ("--kind riser", "csv"),
            ("--kind flow --thesis-screening", "csv"),
            ("--kind steady", "csv"),
            ("--window 650:2222.5 --level 140m", "csv"),
            ("--tolerance 1e-7 --solver dormand-prince", "csv"),
        ] {
            let run = format!("simulate {input} --well well.toml --model model.toml {options}");
            let [whole, blocks] = ["whole", "blocks"].map(|name| format!("{name}.{output}"));
            let expected = said(&bench, &format!("{run} --out {whole}"));
            let found = said(&bench, &format!("{run} --out {blocks} --in-blocks"));
            assert_eq!(found, expected, "{input} {options}");
            assert!(
                bench.bytes(&whole) == bench.bytes(&blocks),
                "{input} {options}"
            );
            // What is warned of, too.
            let whole = bench.dgd(&format!("{run} --out {whole}"));
            let blocks = bench.dgd(&format!("{run} --out {blocks} --in-blocks"));
            assert_eq!(blocks.err, whole.err, "{input} {options}");
        }
    }
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
fn what_cannot_be_simulated_in_blocks_is_simulated_whole_and_says_why() {
    let bench = bench();
    bench
        .dgd("fit rig.csv --well well.toml --out model.toml")
        .done();
    let text = bench.text("rig.csv");
    let mut rows: Vec<&str> = text.lines().collect();
    rows.swap(400, 500);
    bench.write("disordered.csv", rows.join("\n"));
    for (arguments, why) in [
        ("rig.mat --out run.csv", "column after another"),
        ("rig.csv --out run.mat", "column after another"),
        ("rig.csv rig.csv --out run.csv", "is joined with"),
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
