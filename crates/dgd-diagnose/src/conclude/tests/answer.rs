//! Claims about a whole answer, on an hour and a half of drilling.

use crate::diagnosis::NOT_WORSE;
use crate::free_run::{Part, errors};
use crate::record::Record;
use crate::test_rig::{DT_S, Hidden, INFLUX_S, drilled, recorded};
use crate::{Check, DiagnoseError, Diagnosis, Options, Outcome, Stage, Verdict, diagnose};
use dgd_effects::AppliedEffect;
use dgd_identify::Prepared;
use dgd_recording::Well;
use std::ops::Range;

/// When the clocks start, s.
const START_S: f64 = 5000.0;

fn tried(recorded: &(Well, Prepared), options: &Options) -> Result<Diagnosis, DiagnoseError> {
    diagnose(&recorded.0, &recorded.1, options, &mut |_| {})
}

/// From a model that holds effects.
fn fitted(
    recorded: &(Well, Prepared),
    start: &[(&str, &[f64])],
) -> Result<Diagnosis, DiagnoseError> {
    let start = start.iter().map(|(id, parameters)| AppliedEffect {
        id: (*id).to_owned(),
        parameters: parameters.to_vec(),
    });
    let options = Options {
        start: start.collect(),
        ..Options::default()
    };
    tried(recorded, &options)
}

fn sound() -> (Well, Prepared) {
    recorded(&drilled(Hidden::default()), START_S)
}

/// The first blocks of sound drilling.
fn first(blocks: usize) -> Record {
    let mut record = drilled(Hidden::default());
    let n = blocks * record.per_block;
    record.t_s.truncate(n);
    for values in [
        &mut record.mud_pump,
        &mut record.booster,
        &mut record.topfill,
        &mut record.flow,
        &mut record.speed,
        &mut record.inlet,
        &mut record.outlet,
    ] {
        values.truncate(n);
    }
    record
}

/// The check on the held-out windows says how many of the four signals came out worse by more than a tenth.
fn assert_counted(found: &Diagnosis) {
    let check = &found.checks[0];
    let errors = errors(&found.simulation, Part::HeldOut);
    assert_eq!(check.name, NOT_WORSE);
    let worse = (errors.iter().flatten())
        .filter(|e| e.after / e.before > 1.1)
        .count();
    let said = format!("{worse} of 4 signals have an RMSE above 1.1 times that before");
    assert!(check.detail.starts_with(&said), "{}", check.detail);
    assert_eq!(check.passed, worse == 0);
}

#[test]
fn an_influx_is_named_where_it_is_and_modelled() {
    let hidden = Hidden {
        influx_m3_s: 3e-3,
        ..Hidden::default()
    };
    let (well, prepared) = recorded(&drilled(hidden), START_S);
    let mut stages = Vec::new();
    let options = Options::default();
    let found = diagnose(&well, &prepared, &options, &mut |s| stages.push(s)).unwrap();
    let rounds = [1, 2].map(Stage::Screening);
    let [fitting, confirming] = [Stage::Fitting, Stage::Confirming];
    assert_eq!(
        stages,
        [Stage::Baseline, rounds[0], rounds[1], fitting, confirming]
    );
    assert_eq!(found.verdict, Verdict::Explained);
    let [influx] = &found.findings[..] else {
        panic!("{:?}", found.findings);
    };
    assert!(influx.effect == "influx" && influx.probability > 0.9);
    // Every time is one of the recording's clock, which starts where it likes.
    let (from, to) = influx.intervals_s[0];
    let starts = START_S + INFLUX_S.0;
    assert!((from - starts).abs() < 60.0, "{from}");
    assert!((to - starts - INFLUX_S.1).abs() < 60.0, "{to}");
    let onset = influx.parameters.iter().find(|p| p.name == "onset_s");
    assert_eq!(onset.unwrap().estimate, from);
    assert_eq!(found.simulation.t_s[0], START_S);
    assert!((found.held_out_s.iter()).all(|w| w.0 >= START_S && w.1 <= found.setting.span_s.1));
    assert!((found.traces.iter()).all(|t| t.t_s[0] >= START_S && t.t_s[0] < START_S + 120.0));
    assert_eq!(found.after.span_s, Some(found.setting.span_s));
    let modelled: Vec<&str> = found.after.effects.iter().map(|e| e.id.as_str()).collect();
    assert!(found.before.effects.is_empty() && modelled == ["influx"]);
    assert_counted(&found);
    // Fitted without the held-out windows it is the same influx, and no signal runs worse for it.
    let rate = found
        .after
        .effects
        .iter()
        .find(|e| e.id == "influx")
        .unwrap()
        .parameters[0];
    assert!((rate - 3e-3).abs() < 3e-4, "{rate}");
    assert!(found.checks.iter().all(|c| c.passed), "{:?}", found.checks);
    // What each effect showed stands beside it, as it was before anything was named.
    let tested = |id: &str| found.tested.iter().find(|t| t.effect == id).unwrap();
    let seen = tested("influx");
    assert!(seen.outcome == Outcome::Found && seen.admissible && seen.evidence > seen.hurdle);
    let other = tested("lost_circulation");
    assert!(other.outcome == Outcome::NotSeen && other.limit.is_some_and(|l| l > 0.0));

    // Suspected, it is fitted and nothing else is.
    let options = Options {
        suspects: vec!["influx".to_owned()],
        ..Options::default()
    };
    let given = tried(&(well.clone(), prepared.clone()), &options).unwrap();
    assert_eq!(given.findings[0].effect, "influx");
    let options = Options {
        suspects: vec!["gremlins".to_owned()],
        ..Options::default()
    };
    let refused = tried(&(well, prepared), &options).unwrap_err();
    assert!(matches!(refused, DiagnoseError::NotInCatalogue { id } if id == "gremlins"));
}

#[test]
fn sound_drilling_is_not_accused() {
    let found = tried(&sound(), &Options::default()).unwrap();
    assert_eq!(found.verdict, Verdict::Consistent);
    assert!(found.findings.is_empty());
    assert_eq!(found.before, found.after);
    for signal in &found.simulation.signals {
        for (before, after) in signal.before.iter().zip(&signal.after) {
            assert_eq!(before.to_bits(), after.to_bits());
        }
    }
    assert!(found.checks[0].passed);
    assert_counted(&found);
}

#[test]
fn what_is_held_out_no_fit_sees_and_all_else_it_does() {
    let (well, prepared) = sound();
    let whole = fitted(&(well.clone(), prepared.clone()), &[]).unwrap();
    let [(from, to)] = whole.held_out_s[..] else {
        panic!("{:?}", whole.held_out_s);
    };
    assert!(from > START_S && to < START_S + 5400.0 && (to - from - 1260.0).abs() < 1e-6);
    for (a, b, seen) in [
        (from, to, false),
        // A block that lies in it in part is held out whole.
        (from - 30.0, from - 10.0, true),
        (to + 10.0, to + 30.0, true),
    ] {
        let mut other = prepared.clone();
        for (i, outlet) in other.outlet_pressure_pa.iter_mut().enumerate() {
            let t = START_S + DT_S * i as f64;
            *outlet += if t >= a && t < b { 2e3 } else { 0.0 };
        }
        let other = fitted(&(well.clone(), other), &[]).unwrap();
        assert_eq!(other.before != whole.before, seen, "{a}..{b}");
    }
}

#[test]
fn a_hundred_and_ninety_blocks_are_enough_and_fewer_are_refused_with_what_can_be_used() {
    let whole = fitted(&recorded(&first(190), START_S), &[]).unwrap();
    assert_eq!(whole.verdict, Verdict::Consistent);
    let refused = |record: &Record| fitted(&recorded(record, START_S), &[]).unwrap_err();
    let DiagnoseError::TooShort { blocks, needed, .. } = refused(&first(189)) else {
        panic!("189 blocks are enough");
    };
    assert_eq!((blocks, needed), (189, 190));
    // Without a speed the line can be judged still, the pump cannot.
    let usable = |lost: Range<usize>| {
        let mut record = first(190);
        record.speed[lost].fill(f64::NAN);
        let DiagnoseError::TooFew {
            usable,
            blocks,
            needed,
            ..
        } = refused(&record)
        else {
            panic!("enough blocks");
        };
        assert_eq!((blocks, needed), (190, 60));
        usable
    };
    assert_eq!(usable(100..200), usable(100..300) + 20);
}

#[test]
fn a_start_is_an_effect_of_the_catalogue_with_all_its_parameters() {
    let sound = sound();
    let held = fitted(&sound, &[("return_flow_gain", &[1e-4])]).unwrap();
    assert_eq!(held.before.effects[0].id, "return_flow_gain");
    for start in [
        ("return_flow_gain", &[0.01, 2.0][..]),
        ("poltergeist", &[1.0]),
    ] {
        let refused = fitted(&sound, &[start]).unwrap_err();
        assert!(matches!(refused, DiagnoseError::UnknownEffect(_)));
    }
}

#[test]
fn a_start_that_the_recording_speaks_against_is_left_out_aloud() {
    let found = fitted(&sound(), &[("return_flow_gain", &[0.05])]).unwrap();
    assert!(found.before.effects.is_empty());
    assert!(found.findings.is_empty(), "{:?}", found.findings);
    let told = |c: &&Check| {
        c.detail
            .contains("return_flow_gain: this recording contradicts it")
    };
    assert!(!found.checks.iter().find(told).unwrap().passed);
}

#[test]
fn swell_is_a_finding_unless_the_model_holds_it() {
    let (well, mut prepared) = sound();
    for (i, inlet) in prepared.inlet_pressure_pa.iter_mut().enumerate() {
        *inlet += 2e4 * (std::f64::consts::TAU * DT_S * i as f64 / 12.0).sin();
    }
    let swelling = (well, prepared);
    let found = fitted(&swelling, &[]).unwrap();
    let names: Vec<&str> = found.findings.iter().map(|f| f.effect.as_str()).collect();
    assert_eq!(names, ["heave"]);
    let held = fitted(&swelling, &[("heave", &[12.0, 1.0])]).unwrap();
    assert!(held.findings.is_empty(), "{:?}", held.findings);
}
