//! Recordings of other rigs, if there are any at hand.

use crate::bench::run_in;
use serde_json::Value;
use std::path::PathBuf;

/// `DGD_EXAM_CASES` names a folder whose subfolders hold `recording.*` and `well.toml`.
#[test]
fn every_case_at_hand_is_fitted_and_simulated() {
    let Some(cases) = std::env::var_os("DGD_EXAM_CASES").map(PathBuf::from) else {
        println!("skipped: DGD_EXAM_CASES names no folder");
        return;
    };
    let entries = std::fs::read_dir(&cases)
        .unwrap()
        .map(|e| e.unwrap().path());
    let mut folders: Vec<PathBuf> = entries.filter(|p| p.join("well.toml").is_file()).collect();
    folders.sort();
    assert!(!folders.is_empty(), "{} holds no case", cases.display());
    let mut failures = Vec::new();
    for folder in &folders {
        let files = std::fs::read_dir(folder)
            .unwrap()
            .map(|e| e.unwrap().path());
        let mut recordings: Vec<PathBuf> = files
            .filter(|p| p.file_stem().is_some_and(|s| s == "recording"))
            .collect();
        recordings.sort();
        for recording in recordings {
            if let Err(told) = exam(&recording, &folder.join("well.toml")) {
                failures.push(format!("{}: {told}", recording.display()));
            }
        }
    }
    assert!(failures.is_empty(), "{failures:#?}");
}

fn exam(recording: &std::path::Path, well: &std::path::Path) -> Result<(), String> {
    let out = tempfile::tempdir().unwrap();
    let (recording, well) = (
        std::path::absolute(recording).unwrap(),
        std::path::absolute(well).unwrap(),
    );
    let (recording, well) = (recording.to_str().unwrap(), well.to_str().unwrap());
    let steps: [(&[&str], &str); 3] = [
        (&["inspect", recording], "dgd.inspect/1"),
        (&["fit", recording, "--well", well], "dgd.fit/1"),
        (&["simulate", recording, "--well", well], "dgd.simulate/1"),
    ];
    for (arguments, schema) in steps {
        let ran = run_in(
            out.path(),
            arguments.iter().copied().chain(["--json", "--quiet"]),
        );
        if ran.status != 0 {
            return Err(format!("{} gave {}: {}", arguments[0], ran.status, ran.err));
        }
        let said: Value = serde_json::from_str(&ran.out).map_err(|e| e.to_string())?;
        if said["schema"] != schema {
            return Err(format!("{} said {}", arguments[0], said["schema"]));
        }
        let found = [
            &said["delay"]["best_s"],
            &said["deviation"]["riser_level_m"]["rmse"],
        ];
        for number in found.iter().filter(|n| !n.is_null()) {
            println!("{recording}: {} {number}", arguments[0]);
        }
    }
    Ok(())
}
