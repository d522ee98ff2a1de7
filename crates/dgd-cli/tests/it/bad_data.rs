//! Recordings that are whole files with wrong data: a right answer or a clear refusal, row by row of BAD-DATA.md.
//!
//! Each row changes the demo's recording or its well description and runs the binary.

mod clocks;
mod rig;
mod tags;
mod units;
mod values;

use crate::bench::Bench;
use dgd_plant::{Kind, Level, Order, Severity, conceal, record, write_case, write_case_well_toml};
use rig::{Rig, strings};
use serde_json::Value;

#[test]
fn a_sound_recording_is_not_suspected() {
    Rig::sound().fitted().suspects_nothing();
    let ran: Value = serde_json::from_str(&Rig::sound().simulate().done()).unwrap();
    assert_eq!(ran["warnings"], serde_json::json!([]));
}

#[test]
fn neither_a_fixture_nor_a_concealed_effect_is_suspected() {
    let fixture = include_bytes!("../../../../fixtures/demo-concealed/recording.mat");
    let well = include_str!("../../../../fixtures/demo-concealed/well.toml");
    unsuspected("demo-concealed", fixture, well);
    for level in [Level::One, Level::Two] {
        for effect in [
            None,
            Some("return_flow_gain"),
            Some("inflow_gain"),
            Some("outlet_pressure_bias"),
            Some("mud_density_change"),
            Some("annulus_area"),
            Some("line_leak"),
        ] {
            let order = Order {
                seed: 77,
                level,
                kind: effect.map_or(Kind::Clean, |_| Kind::Single),
                severity: Some(Severity::Strong),
                effect,
                hours: None,
                viscosity: 1.0,
            };
            let mut case = conceal(&order, 0);
            // Four hours: effects have set in by then.
            let samples = case.plan.samples().min(14_400);
            case.plan.series = vec![samples];
            let (mut file, mut toml) = (Vec::new(), Vec::new());
            write_case(&case, &record(&case.plan).unwrap(), &mut file).unwrap();
            write_case_well_toml(&case, &mut toml).unwrap();
            let what = format!("{level:?} {effect:?}");
            unsuspected(&what, &file, std::str::from_utf8(&toml).unwrap());
        }
    }
}

#[track_caller]
fn unsuspected(what: &str, recording: &[u8], well: &str) {
    let bench = Bench::bare();
    bench.write("rig", recording);
    bench.write("well.toml", well);
    let fit = bench.json("fit rig --well well.toml", "dgd.fit/1");
    let told = strings(&fit["warnings"]);
    let suspected = |w: &&str| w.starts_with("well.toml:") || w.contains("clock");
    assert!(!told.iter().any(suspected), "{what}: {told:#?}");
}

#[test]
fn too_short_a_recording_is_refused_or_told() {
    Rig::first(1).fit().refused(&["at least 2 are needed"]);
    Rig::first(30)
        .fit()
        .refused(&["in a recording of 30 samples"]);
    Rig::first(600).fitted().warns("the flow hardly changes");
    let (bench, ran) = Rig::first(1800).diagnose();
    ran.refused(&["holds 180 blocks of 10 s, a diagnosis needs 190 (32 min)"]);
    assert!(!bench.path("d").exists());
}

#[test]
fn an_hour_is_enough() {
    Rig::first(3600).fitted().right(1.0).suspects_nothing();
    let (_, ran) = Rig::first(3600).diagnose();
    let diagnosis: Value = serde_json::from_str(&ran.done()).unwrap();
    assert_eq!(diagnosis["warnings"], serde_json::json!([]));
    let named = &diagnosis["findings"][0]["effect"];
    assert_eq!(named, "return_flow_delay", "{diagnosis:#}");
}

#[test]
fn a_month_in_half_minutes_is_fitted() {
    let mut rig = Rig::sound().every(30);
    let (rows, times) = (240, 360);
    for column in &mut rig.table.columns {
        let once = column.values.clone();
        let again = |k: u32| once.iter().map(move |v| (k, *v)).collect::<Vec<_>>();
        let clock = column.tag == "t";
        column.values = (0..times)
            .flat_map(again)
            .map(|(k, v)| if clock { v + 7200.0 * f64::from(k) } else { v })
            .collect();
    }
    let fitted = rig.fitted();
    assert_eq!(fitted.json["samples"], rows * times);
    fitted.suspects_nothing();
}

#[test]
fn a_diagnosis_tells_its_suspicion_before_its_answer() {
    let rig = Rig::first(3600).saying("\"FT4\", unit = \"gpm\"", "\"FT4\", unit = \"l/min\"");
    let (bench, ran) = rig.diagnose();
    let told = "as gpm return_flow `FT4` would be";
    assert!(ran.err.contains(told), "{}", ran.err);
    let diagnosis: Value = serde_json::from_str(&ran.done()).unwrap();
    let warnings = strings(&diagnosis["warnings"]);
    assert_eq!(warnings.len(), 1, "{warnings:#?}");
    assert!(
        warnings[0].starts_with("well.toml:19: return_flow `FT4`"),
        "{}",
        warnings[0]
    );
    let report = bench.text("d/report.html");
    let (before, answer) = (
        report.find("Before you read on").unwrap(),
        report.find("The answer").unwrap(),
    );
    assert!(before < answer);
    assert!(report.contains("well.toml:19: return_flow `FT4`"));
    let simulated: Value = serde_json::from_str(&rig.simulate().done()).unwrap();
    assert!(strings(&simulated["warnings"])[0].contains(told));
}

#[test]
fn masking_tells_that_something_is_suspected_and_nothing_of_it() {
    let bench = Rig::sound().saying("psia", "kPa").set_up();
    let ran = bench.dgd("mask rig.mat --well well.toml --out masked --references r.toml");
    assert!(
        ran.err.contains("does not match its well description"),
        "{}",
        ran.err
    );
    for secret in ["PT1", "26.4", "kPa"] {
        assert!(
            !ran.err.contains(secret) && !ran.out.contains(secret),
            "{ran:?}"
        );
    }
}
