//! Disks that are full, folders that may not be written, files that are in the way: what stood before still stands.

use crate::bench::{Bench, Ran};
use std::process::Command;

/// Every command that writes, with the old file that must survive it.
const WRITERS: [(&str, &str); 11] = [
    (
        // Which it would not write over.
        "inspect rig.mat --propose out/proposed.toml",
        "another.toml",
    ),
    (
        "fit rig.mat --well well.toml --out out/model.toml",
        "model.toml",
    ),
    (
        "fit rig.mat --well well.toml --out out/model.toml --figures out",
        "figure-3-3.svg",
    ),
    (
        "simulate rig.mat --well well.toml --out out/run.csv",
        "run.csv",
    ),
    (
        "simulate rig.mat --well well.toml --out out/run.mcap --figures out",
        "figure-4-1.png",
    ),
    (
        "mask rig.mat --well well.toml --out out --references private/references.toml",
        "recording.csv",
    ),
    ("convert rig.mat out/rig.csv", "rig.csv"),
    ("convert rig.mat out/rig.mcap", "rig.mcap"),
    ("convert rig.mat out/rig.mat --mat-v73", "rig.mat"),
    (
        "linearise --well well.toml --at inflow.flow=0.04 pump.speed=70 --out out",
        "linear.mat",
    ),
    ("demo --out out", "recording.mat"),
];

/// The same for systems of one's own.
const SYSTEM_WRITERS: [(&str, &str); 6] = [
    (
        "system check two_tanks.toml --draw out/system.svg",
        "system.svg",
    ),
    (
        "fit two_tanks.csv --system two_tanks.toml --out out/fitted.toml",
        "fitted.html",
    ),
    (
        "simulate two_tanks.csv --system two_tanks.toml --out out/run.csv",
        "run.json",
    ),
    (
        "diagnose two_tanks.csv --system two_tanks.toml --out out",
        "model.toml",
    ),
    (
        "sensitivities two_tanks.csv --system two_tanks.toml --out out",
        "sensitivities.csv",
    ),
    (
        "linearise --system two_tanks.toml --at-time 100 --recording two_tanks.csv --out out",
        "linear.json",
    ),
];

fn bench() -> Bench {
    let bench = Bench::new();
    bench.dgd("fit rig.mat --well well.toml").done();
    std::fs::create_dir(bench.path("out")).unwrap();
    bench
}

fn tanks() -> Bench {
    let bench = crate::systems::benches();
    std::fs::create_dir(bench.path("out")).unwrap();
    bench
}

/// Runs `dgd` from a shell that says `first` before.
pub(crate) fn from_shell(bench: &Bench, first: &str, arguments: &str) -> Ran {
    let script = format!("{first}\nexec {} {arguments}", env!("CARGO_BIN_EXE_dgd"));
    let output = Command::new("sh")
        .args(["-c", &script])
        .current_dir(bench.path(""))
        .output()
        .unwrap();
    Ran::of(&output)
}

fn names(bench: &Bench, folder: &str) -> Vec<String> {
    let entries = std::fs::read_dir(bench.path(folder)).unwrap();
    entries
        .map(|e| e.unwrap().file_name().into_string().unwrap())
        .collect()
}

#[test]
fn a_disk_that_takes_nothing_more_leaves_the_old_file_and_no_other() {
    for (arguments, old) in WRITERS.into_iter().chain(SYSTEM_WRITERS) {
        let bench = if arguments.contains("two_tanks") {
            tanks()
        } else {
            bench()
        };
        bench.write(&format!("out/{old}"), "old");
        // No file may grow, which fails as a full disk does.
        let ran = from_shell(&bench, "ulimit -f 0", arguments);
        assert_eq!(ran.status, 1, "{arguments}: {ran:?}");
        for part in [
            "out/",
            "cannot be written",
            "help: no partial file was left",
            "ulimit",
        ] {
            // The references are written first.
            let part = if arguments.starts_with("mask") {
                part.trim_start_matches("out/")
            } else {
                part
            };
            assert!(ran.err.contains(part), "{arguments}: {}", ran.err);
        }
        assert_eq!(names(&bench, "out"), [old], "{arguments}");
        assert_eq!(bench.text(&format!("out/{old}")), "old", "{arguments}");
    }
}

#[test]
fn a_disk_that_fills_up_halfway_leaves_nothing() {
    let bench = bench();
    for target in ["rig.csv", "rig.mcap", "big.mat", "big73.mat --mat-v73"] {
        let ran = from_shell(
            &bench,
            "ulimit -f 32",
            &format!("convert rig.mat out/{target}"),
        );
        assert_eq!(ran.status, 1, "{target}: {ran:?}");
        assert!(ran.err.contains("cannot be written"), "{}", ran.err);
    }
    assert_eq!(names(&bench, "out"), [""; 0]);
}

#[test]
fn a_full_disk_is_told_as_one() {
    let bench = bench();
    let script = format!(
        "mount -t tmpfs -o size=64k none out || exit 77\n{} convert rig.mat out/rig.csv\necho \"status $?\"\nls -A out",
        env!("CARGO_BIN_EXE_dgd")
    );
    let output = Command::new("unshare")
        .args(["--map-root-user", "--mount", "sh", "-c", &script])
        .current_dir(bench.path(""))
        .output();
    let output = match output {
        Ok(output) if output.status.code() == Some(0) => output,
        other => {
            println!("skipped: no disk of its own can be mounted here: {other:?}");
            return;
        }
    };
    let (out, err) = (
        String::from_utf8_lossy(&output.stdout),
        String::from_utf8_lossy(&output.stderr),
    );
    assert_eq!(out, "status 1\n", "{err}");
    assert!(
        err.contains("No space left") && err.contains("free space"),
        "{err}"
    );
}

#[test]
fn a_folder_that_takes_no_file_is_told_before_the_work() {
    let bench = bench();
    bench.write("file", "no folder");
    for out in ["/proc", "file", "file/deep"] {
        for (arguments, _) in WRITERS {
            let arguments = arguments.replace("out/", &format!("{out}/"));
            let arguments = arguments.replace("--out out", &format!("--out {out}"));
            if arguments.contains(" --figures out") {
                continue;
            }
            let ran = bench.dgd(&format!("{arguments} -vv"));
            assert_eq!(ran.status, 1, "{arguments}: {ran:?}");
            assert!(
                ran.err.contains("cannot be written"),
                "{arguments}: {}",
                ran.err
            );
            assert!(
                !ran.err.contains("identifying") && !ran.err.contains("simulating"),
                "{arguments}: {}",
                ran.err
            );
        }
    }
    assert!(
        !bench.path("private").exists(),
        "references without a masked recording"
    );
}

#[test]
fn a_folder_without_permission_is_told_with_what_to_ask_for() {
    let bench = bench();
    set_mode(&bench, "out", 0o555);
    let Some(ran) = unprivileged(&bench, "convert rig.mat out/rig.csv") else {
        return;
    };
    assert_eq!(ran.status, 1, "{ran:?}");
    assert!(ran.err.contains("ask for permission"), "{}", ran.err);
    assert_eq!(names(&bench, "out"), [""; 0]);
    // It is the folder's mode that it fails for, and nothing else of the user's.
    set_mode(&bench, "out", 0o777);
    if let Some(ran) = unprivileged(&bench, "convert rig.mat out/rig.csv") {
        ran.done();
    }
}

fn set_mode(bench: &Bench, name: &str, mode: u32) {
    use std::os::unix::fs::PermissionsExt;
    std::fs::set_permissions(bench.path(name), std::fs::Permissions::from_mode(mode)).unwrap();
}

/// Runs `dgd` as a user whom modes hold back: this one, or nobody where this one is root. `None` where root may be no other.
fn unprivileged(bench: &Bench, arguments: &str) -> Option<Ran> {
    use std::os::unix::{fs::MetadataExt, process::CommandExt};
    const NOBODY: u32 = 65_534;
    // What root's process has just made is root's.
    if std::fs::metadata(bench.path("out")).unwrap().uid() != 0 {
        return Some(bench.dgd(arguments));
    }
    // By another process: one that is forked meanwhile would hold a program open that was written here, and it would not run.
    let program = env!("CARGO_BIN_EXE_dgd");
    let copied = Command::new("install")
        .args(["-m", "755", program, "dgd"])
        .current_dir(bench.path(""))
        .status();
    assert!(copied.unwrap().success());
    // Where nobody may enter and read.
    set_mode(bench, "", 0o755);
    set_mode(bench, "rig.mat", 0o644);
    let output = Command::new(bench.path("dgd"))
        .args(arguments.split_whitespace())
        .current_dir(bench.path(""))
        .uid(NOBODY)
        .gid(NOBODY)
        .output();
    match output {
        Ok(output) => Some(Ran::of(&output)),
        Err(error) => {
            println!("skipped: root may be no other user here, or no other may enter: {error}");
            None
        }
    }
}

#[test]
fn standard_output_on_a_full_device_is_no_success() {
    let bench = bench();
    if !std::path::Path::new("/dev/full").exists() {
        println!("skipped: this system has no /dev/full");
        return;
    }
    let ran = from_shell(&bench, "exec > /dev/full", "inspect rig.mat");
    assert_eq!(ran.status, 1, "{ran:?}");
    assert!(ran.err.contains("standard output"), "{}", ran.err);
}

#[test]
fn of_a_mask_that_fails_late_not_even_the_references_are_left() {
    let bench = bench();
    std::fs::create_dir(bench.path("out/report.html")).unwrap();
    let ran =
        bench.dgd("mask rig.mat --well well.toml --out out --references private/references.toml");
    assert_eq!(ran.status, 1, "{ran:?}");
    assert_eq!(names(&bench, "out"), ["report.html"]);
    assert_eq!(names(&bench, "private"), [""; 0]);
}
