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
