//! Each error variant.

use super::rig::{Rig, well};
use dgd_identify::{
    Identification, IdentifyError, IdentifyOptions, ScreenOptions, identify, prepare,
};
use dgd_recording::Recording;
use dgd_screen::ScreenError;

fn tried(recording: Recording) -> Result<Identification, IdentifyError> {
    let prepared = prepare(recording, 1.0, &ScreenOptions::default()).unwrap();
    identify(&prepared, &well(), &IdentifyOptions::default())
}

fn short() -> Rig {
    Rig {
        samples: 600,
        ..Rig::default()
    }
}

#[test]
fn a_pump_that_never_ran_is_the_reason_given() {
    let mut recording = short().recording();
    recording.pump_speed_pct.fill(0.0);
    recording.return_flow_m3_s[..50].fill(-0.001);
    let error = tried(recording).unwrap_err();
    assert_eq!(
        error.to_string(),
        "none of 600 samples passed the screening; most were rejected for: pump off (600 samples)"
    );
}

#[test]
fn an_empty_recording_has_no_reason() {
    let empty = Recording {
        pump_inlet_pressure_pa: vec![Vec::new()],
        pump_outlet_pressure_pa: vec![Vec::new()],
        ..Recording::default()
    };
    let expected = IdentifyError::NothingKept {
        samples: 0,
        most: "no samples at all".to_owned(),
    };
    assert_eq!(tried(empty).unwrap_err(), expected);
}

#[test]
fn a_recording_shorter_than_the_sweep_is_refused() {
    let rig = Rig {
        samples: 25,
        ..Rig::default()
    };
    let error = tried(rig.recording()).unwrap_err();
    assert_eq!(
        error.to_string(),
        "return line friction: delays 0..=30 samples in a recording of 25 samples, expected a rising range within it"
    );
}

#[test]
fn a_search_out_of_its_domain_falls_back_with_the_reason() {
    let prepared = prepare(short().recording(), 1.0, &ScreenOptions::default()).unwrap();
    let mut options = IdentifyOptions::default();
    options.search.n2 = 3.0..=2.0;
    let found = identify(&prepared, &well(), &options).unwrap();
    assert_eq!((found.model.pump.n0, found.model.pump.n2), (2.0, 2.0));
    assert!(
        found.warnings.iter().any(|w| w.contains("a rising range")),
        "{:?}",
        found.warnings
    );
}

#[test]
fn exponents_are_two_and_two_unless_searched_for() {
    let prepared = prepare(Rig::default().recording(), 1.0, &ScreenOptions::default()).unwrap();
    let options = IdentifyOptions {
        free_exponents: false,
        ..IdentifyOptions::default()
    };
    let found = identify(&prepared, &well(), &options).unwrap();
    assert_eq!((found.model.pump.n0, found.model.pump.n2), (2.0, 2.0));
    assert!(found.pump.search.is_none());
    assert!(found.model.pump.c2.value > 0.0 && found.model.pump.c1.value > 0.0);
}

#[test]
fn series_of_unequal_length_are_refused_with_the_culprit() {
    let mut prepared = prepare(short().recording(), 1.0, &ScreenOptions::default()).unwrap();
    prepared.recording.pump_speed_pct.pop();
    let error = identify(&prepared, &well(), &IdentifyOptions::default()).unwrap_err();
    assert_eq!(
        error.to_string(),
        "`pump_speed` has 599 samples, expected 600 to match the time"
    );
    prepared.recording.pump_speed_pct.push(50.0);
    prepared.keep.pop();
    let error = identify(&prepared, &well(), &IdentifyOptions::default()).unwrap_err();
    assert_eq!(
        error.to_string(),
        "`keep` has 599 samples, expected 600 to match the time"
    );
}

#[test]
fn a_clock_that_is_not_even_is_refused_when_prepared_and_after() {
    let options = ScreenOptions::default();
    let mut jumped = short().recording();
    jumped.time_s[300..].iter_mut().for_each(|t| *t += 60.0);
    let error = prepare(jumped, 1.0, &options).unwrap_err();
    assert!(matches!(error, ScreenError::Uneven(_)), "{error}");
    assert!(prepare(short().recording(), 1.3, &options).is_err());
    let mut prepared = prepare(short().recording(), 1.0, &options).unwrap();
    prepared.step_s = 10.0;
    let error = identify(&prepared, &well(), &IdentifyOptions::default()).unwrap_err();
    assert_eq!(
        error.to_string(),
        "the clock steps by 1 s after sample 1, expected 10 s: put the recording on an even clock"
    );
}
