//! Development: ranks the catalogue on recordings given as folders.
#![allow(clippy::print_stdout, clippy::unwrap_used)]
fn main() {
    for folder in std::env::args().skip(1) {
        let file = std::fs::read_dir(&folder).unwrap().filter_map(|e| Some(e.ok()?.path())).find(|p| p.file_stem().is_some_and(|s| s == "recording")).unwrap();
        let (well, _) = dgd_documents::read_well(&std::fs::read_to_string(format!("{folder}/well.toml")).unwrap()).unwrap();
        let bytes = std::fs::read(&file).unwrap();
        let (_, table) = dgd_ingest::read(&bytes, &dgd_ingest::ReadOptions { name_hint: Some(file.to_str().unwrap().into()), ..Default::default() }).unwrap();
        let (recording, _) = dgd_recording::Recording::from_table(table, &well).unwrap();
        let (recording, step, _) = recording.onto_grid().unwrap();
        let prepared = dgd_identify::prepare(recording, step, &dgd_screen::ScreenOptions::default()).unwrap();
        if let Ok(t) = std::env::var("GAIN") { let mut w = t.split(' '); let id = w.next().unwrap(); println!("{}", dgd_diagnose::gains(&well, &prepared, id, w.map(|v| v.parse().unwrap()).collect())); continue; }
        if let Ok(t) = std::env::var("TRY") { let mut w = t.split(' '); let id = w.next().unwrap(); println!("{}", dgd_diagnose::try_one(&well, &prepared, id, w.map(|v| v.parse().unwrap()).collect())); continue; }
        if std::env::var("CHOOSE").is_ok() { println!("{folder}: {}", dgd_diagnose::choose(&well, &prepared)); continue; }
        if std::env::var("BETA").is_ok() { println!("{}", dgd_diagnose::betas(&well, &prepared)); continue; }
        if let (Ok(a), Ok(b)) = (std::env::var("FROM"), std::env::var("TO")) { println!("{}", dgd_diagnose::dump(&well, &prepared, a.parse().unwrap(), b.parse().unwrap())); continue; }
        println!("{folder}: {}", dgd_diagnose::explore(&well, &prepared));
    }
}
