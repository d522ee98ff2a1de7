//! Cases of the plant, by way of the files that a user would have.

use dgd_diagnose::{DiagnoseError, Diagnosis, Options, diagnose};
use dgd_identify::{Prepared, prepare};
use dgd_plant::{Case, Kind, Level, Order, Severity, conceal, record, write_case};
use dgd_recording::{Recording, Well};
use dgd_screen::ScreenOptions;

/// A level-one case of four hours at most: long enough for every effect to set in.
pub(crate) fn case(seed: u64, effect: Option<&'static str>) -> Case {
    let order = Order {
        seed,
        level: Level::One,
        kind: effect.map_or(Kind::Clean, |_| Kind::Single),
        severity: Some(Severity::Moderate),
        effect,
        hours: None,
        viscosity: 1.0,
    };
    let mut case = conceal(&order, 0);
    let samples = case.plan.samples().min(14_400);
    case.plan.series = vec![samples];
    case
}

/// Its recording as bytes, read back and put on an even clock.
pub(crate) fn recorded(case: &Case) -> (Well, Recording, f64) {
    let (mut file, mut toml) = (Vec::new(), Vec::new());
    write_case(case, &record(&case.plan).unwrap(), &mut file).unwrap();
    dgd_plant::write_case_well_toml(case, &mut toml).unwrap();
    let (well, _) = dgd_documents::read_well(std::str::from_utf8(&toml).unwrap()).unwrap();
    let (_, table) = dgd_ingest::read(&file, &dgd_ingest::ReadOptions::default()).unwrap();
    let (recording, _) = Recording::from_table(table, &well).unwrap();
    let (recording, step_s, _) = recording.onto_grid().unwrap();
    (well, recording, step_s)
}

pub(crate) fn screened(recording: Recording, step_s: f64) -> Prepared {
    prepare(recording, step_s, &ScreenOptions::default()).unwrap()
}

pub(crate) fn tried(
    well: &Well,
    recording: Recording,
    step_s: f64,
) -> Result<Diagnosis, DiagnoseError> {
    let prepared = screened(recording, step_s);
    diagnose(well, &prepared, &Options::default(), &mut |_| {})
}

/// A case from the plan to the answer.
pub(crate) fn answer(case: &Case) -> Diagnosis {
    let (well, recording, step_s) = recorded(case);
    tried(&well, recording, step_s).unwrap()
}
