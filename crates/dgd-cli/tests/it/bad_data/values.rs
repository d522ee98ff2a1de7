//! Values that are missing, infinite or never change, and transmitters that are not there.

use super::rig::{CHANNELS, Rig, line_of, strings};
use dgd_recording::Column;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde_json::Value;

fn storm(share: f64) -> Rig {
    let mut random = ChaCha8Rng::seed_from_u64(11);
    let mut rig = Rig::sound();
    for tag in CHANNELS {
        for value in rig.column(tag) {
            if random.random::<f64>() < share {
                *value = f64::NAN;
            }
        }
    }
    rig
}

#[test]
fn nan_at_three_samples_of_ten_leaves_the_answer_right() {
    storm(0.3).fitted().right(1.0).suspects_nothing();
}

#[test]
fn nan_at_nine_samples_of_ten_is_refused_by_a_fit_and_costs_a_diagnosis_no_cause() {
    let ran = storm(0.9).fit();
    ran.refused(&[
        "samples passed the screening, expected at least",
        "gap",
        "no channel has a value at more than 10",
    ]);
    // Straight lines lie between, as of what is logged now and then; as at 0.1 Hz.
    let seldom = storm(0.9).diagnosed();
    seldom
        .finds("return_flow_delay", "delay_s", 12.0, 5.0)
        .finds("line_drainage", "rate_m_s", 0.036, 0.004)
        // The stand-in's return meter reads 4 to 5 % too little where most mud flows: a gain of the two flows, whichever has it.
        .finds("inflow_gain", "gain", 1.048, 0.012);
    assert_eq!(seldom.claimed().len(), 3, "{:#}", seldom.json["findings"]);
    let (_, ran) = storm(0.985).diagnose();
    ran.refused(&["can be used in 0 of 720 blocks of 10 s", "`dgd fit`"]);
}

/// A channel is filed when it reads another value: a third of the speed's readings, and nearly all of the pressures'.
#[test]
fn readings_that_are_filed_when_they_change_stand_until_the_next() {
    let mut rig = Rig::of_hours();
    let tags: Vec<String> = rig.table.columns.iter().map(|c| c.tag.clone()).collect();
    for tag in tags.iter().filter(|tag| *tag != "t") {
        let mut last = f64::NAN;
        for value in rig.column(tag) {
            let read = std::mem::replace(&mut last, *value);
            if read == *value {
                *value = f64::NAN;
            }
        }
    }
    let ran = rig.fit();
    let told = "hardly one of them equal to the one before: each is taken to stand until the next";
    assert!(ran.err.contains(told), "{}", ran.err);
    let found = rig.diagnosed();
    found.finds("influx", "rate_m3_s", 0.0021, 0.0003);
    assert_eq!(found.claimed(), ["influx"], "{:#}", found.json["findings"]);
}

/// Each channel is read every five seconds, at seconds of its own; some readings are spikes.
#[test]
fn channels_that_are_read_apart_keep_the_answer_and_lose_readings_that_stand_alone() {
    let mut rig = Rig::of_hours();
    let tags: Vec<String> = rig.table.columns.iter().map(|c| c.tag.clone()).collect();
    for (phase, tag) in tags.iter().filter(|tag| *tag != "t").enumerate() {
        for (i, value) in rig.column(tag).iter_mut().enumerate() {
            if i % 5 != phase % 5 {
                *value = f64::NAN;
            } else if tag == "PT1" && i % 3000 == 1000 + phase % 5 {
                *value *= 0.6;
            }
        }
    }
    let found = rig.diagnosed();
    found.finds("influx", "rate_m3_s", 0.0021, 0.0003);
    let told = "`pump_inlet_pressure 1`: 6 readings far off those before and after; left out";
    let warnings = strings(&found.json["warnings"]);
    assert!(warnings.iter().any(|w| w.contains(told)), "{warnings:?}");
    assert_eq!(found.claimed(), ["influx"], "{:#}", found.json["findings"]);
}

#[test]
fn a_frozen_reading_with_rounding_errors_on_it_is_still_frozen() {
    let mut random = ChaCha8Rng::seed_from_u64(12);
    let mut rig = Rig::sound();
    for tag in CHANNELS {
        for (i, value) in rig.column(tag).iter_mut().enumerate() {
            if tag == "PT1" && (2000..2900).contains(&i) {
                *value = 390.0;
            }
            *value *= 1.0 + 1e-10 * (random.random::<f64>() - 0.5);
        }
    }
    let fitted = rig.fitted();
    fitted.right(1.0);
    fitted.warns("repeats one value from 2000 to 2900 s");
}

#[test]
fn a_pump_that_is_not_logged_is_told_and_not_called_a_gain() {
    for (tag, channel) in [("FT1", "mud_pump_flow"), ("FT2", "booster_flow")] {
        let found = Rig::of_hours().each(&[tag], |_, _| 0.0).diagnosed();
        assert!(
            found.claimed().iter().all(|id| *id == "unknown"),
            "{tag}: {:#}",
            found.json["findings"]
        );
        let told = format!("a pump that is not logged: `{channel}` reads 0 throughout");
        assert!(
            found.same_as().iter().any(|(_, same)| **same == told),
            "{tag}: {:?}",
            found.same_as()
        );
    }
}

/// As someone writes who knows no tag of the booster.
#[test]
fn a_booster_that_is_described_as_none_is_asked_about_where_it_ran() {
    let found = Rig::of_hours()
        .saying("{ tag = \"FT2\", unit = \"gpm\" }", "\"0 gpm\"")
        .diagnosed();
    assert!(
        found.claimed().iter().all(|id| *id == "unknown"),
        "{:#}",
        found.json["findings"]
    );
    let told = "a pump that is not logged: `booster_flow` is described as 0";
    assert!(found.same_as().iter().any(|(_, same)| *same == told));
}

/// Half of the mud goes through a second pump, whose strokes are counted.
#[test]
fn the_flows_of_two_mud_pumps_are_added() {
    const STROKE_GAL: f64 = 4.2;
    let mut rig = Rig::of_hours();
    let halves: Vec<f64> = rig.column("FT1").iter().map(|q| 0.5 * q).collect();
    let strokes = halves.iter().map(|q| q / STROKE_GAL).collect();
    *rig.column("FT1") = halves;
    rig.table.columns.push(Column {
        tag: "SPM2".into(),
        unit: None,
        values: strokes,
    });
    let found = rig
        .saying(
            "{ tag = \"FT1\", unit = \"gpm\" }",
            "[{ tag = \"FT1\", unit = \"gpm\" }, { tag = \"SPM2\", unit = \"spm\", stroke = \"4.2 gal\" }]",
        )
        .diagnosed();
    assert_eq!(found.claimed(), Rig::of_hours().diagnosed().claimed());
}

/// Every ten minutes the signal of a pump is lost for 20 s.
#[test]
fn a_pump_whose_signal_drops_out_for_seconds_is_told_and_makes_no_cause() {
    let lost = |i: usize| (i + 300) % 600 < 20;
    let sound = Rig::of_hours().diagnosed();
    for (tag, channel) in [("FT1", "mud_pump_flow"), ("FT2", "booster_flow")] {
        let dropped = Rig::of_hours().each(&[tag], |i, q| if lost(i) { 0.0 } else { q });
        let found = dropped.diagnosed();
        assert_eq!(
            found.claimed(),
            sound.claimed(),
            "{tag}: {:#}",
            found.json["findings"]
        );
        let told = format!("`{channel}` jumps to one value for seconds and back");
        assert!(found.err.contains(&told), "{}", found.err);
    }
}

#[test]
fn a_reading_of_0_for_half_an_hour_that_the_others_contradict_is_told_and_makes_no_cause() {
    let sound = Rig::of_hours().diagnosed();
    let agree = "readings of 0 agree with the others";
    assert!(!sound.json["checks"].to_string().contains(agree));
    for (tag, channel) in [
        ("FT1", "mud_pump_flow"),
        ("FT4", "return_flow"),
        ("SPM", "pump_speed"),
    ] {
        let dead = |i: usize, v: f64| if (4000..5800).contains(&i) { 0.0 } else { v };
        let found = Rig::of_hours().each(&[tag], dead).diagnosed();
        assert_eq!(
            found.claimed(),
            sound.claimed(),
            "{tag}: {:#}",
            found.json["findings"]
        );
        let told = format!("`{channel}` reads 0 from 4000 to 5799 s");
        assert!(found.err.contains(&told), "{}", found.err);
        let checks = found.json["checks"].as_array().unwrap();
        let failed = |check: &&Value| check["name"] == agree && check["passed"] == false;
        assert_eq!(checks.iter().filter(failed).count(), 1, "{tag}");
    }
}

#[test]
fn words_for_rest_are_told_of_the_columns_that_are_used() {
    let bench = Rig::first(3600).set_up();
    bench.dgd("convert rig.mat rig.csv").done();
    let text = bench.text("rig.csv");
    let at = text
        .lines()
        .next()
        .unwrap()
        .split(',')
        .position(|tag| tag.ends_with("FT2"));
    let rows = text.lines().enumerate().map(|(n, line)| {
        let mut cells: Vec<&str> = line.split(',').collect();
        let word = (100..160).contains(&n);
        if word {
            cells[at.unwrap()] = "Off";
        }
        // A column that nothing uses, though its name ends alike.
        cells.push(if n == 0 {
            "OLD_FT2"
        } else if word {
            "Off"
        } else {
            "1"
        });
        cells.join(",")
    });
    let rows: Vec<String> = rows.collect();
    bench.write("rig.csv", rows.join("\n"));
    let ran = bench.dgd("fit rig.csv --well well.toml --json").done();
    let told: Value = serde_json::from_str(&ran).unwrap();
    let told = told["warnings"].to_string();
    assert!(
        told.contains("FT2`: 60 cells with a word that may stand for 0"),
        "{told}"
    );
    assert!(!told.contains("OLD_FT2"), "{told}");
}

#[test]
fn infinite_values_are_gaps() {
    let rig = Rig::sound().each(&["FT4"], |i, q| {
        if (2000..2300).contains(&i) {
            f64::INFINITY
        } else {
            q
        }
    });
    rig.fitted().right(1.0);
}

#[test]
fn a_channel_without_values_is_named_and_only_what_needs_it_is_refused() {
    for (tag, usable) in [
        ("FT1", true),
        ("FT2", true),
        ("PT1", true),
        ("PT5", true),
        ("FT4", false),
        ("SPM", false),
    ] {
        let rig = Rig::sound().each(&[tag], |_, _| f64::NAN);
        let told = format!("`{tag}` has no value in the whole recording");
        if usable {
            rig.fitted()
                .right(1.0)
                .suspects(line_of(&format!("\"{tag}\"")), &[&told]);
        } else {
            rig.fit()
                .refused(&[&told, "none of 7200 samples passed the screening"]);
        }
    }
    let without_inflow = Rig::sound().each(&["FT1"], |_, _| f64::NAN);
    without_inflow
        .simulate()
        .refused(&["`mud_pump_flow` has no trusted value"]);
}

#[test]
fn a_constant_channel_is_named() {
    for (tag, usable) in [
        ("PT1", true),
        ("PT3", true),
        ("PT5", true),
        ("FT1", true),
        ("FT4", false),
    ] {
        let rig = Rig::sound().each(&[tag], |_, _| 500.0);
        let told = format!("`{tag}` never changes (500 ");
        if usable {
            rig.fitted()
                .right(1.0)
                .suspects(line_of(&format!("\"{tag}\"")), &[&told]);
        } else {
            rig.fit().refused(&[&told, "stuck return flow"]);
        }
    }
    let rested = Rig::sound().each(&["SPM"], |_, _| 51.0).fitted();
    rested.suspects(line_of("SPM"), &["never changes (51 %"]);
    rested.warns("explains only 0 % of the head variance");
}

#[test]
fn a_transmitter_that_the_file_lacks_is_named() {
    for tag in CHANNELS {
        let mut rig = Rig::sound();
        rig.table.columns.retain(|c| c.tag != tag);
        let parts = [
            format!("is mapped to the tag `{tag}`, which the recording does not have"),
            format!(
                "it is mapped in well.toml, line {}",
                line_of(&format!("\"{tag}\""))
            ),
        ];
        let parts: Vec<&str> = parts.iter().map(String::as_str).collect();
        rig.fit().refused(&parts);
    }
}

#[test]
fn a_transmitter_that_the_rig_lacks_leaves_the_answer_right() {
    for (found, instead) in [
        ("[{ tag = \"PT1\", unit = \"psia\" }, ", "["),
        (", { tag = \"PT2\", unit = \"psia\" }]", "]"),
        ("[{ tag = \"PT3\", unit = \"psia\" }, ", "["),
        (", { tag = \"PT4\", unit = \"psia\" }]", "]"),
        ("riser_pressure = { tag = \"PT5\", unit = \"psia\" }\n", ""),
        ("{ tag = \"FT3\", unit = \"gpm\" }", "\"30 gpm\""),
    ] {
        Rig::sound()
            .saying(found, instead)
            .fitted()
            .right(1.0)
            .suspects_nothing();
    }
}

#[test]
fn a_transmitter_that_leaves_its_neighbour_is_told() {
    let saw = |i: usize| 8.0 * (i % 1100) as f64 / 1100.0;
    let slow = |i: usize| 10.0 * (i as f64 / 1500.0).sin();
    for (tag, name) in [
        ("PT1", "the first pump inlet transmitter"),
        ("PT2", "the second pump inlet transmitter"),
        ("PT3", "the first pump outlet transmitter"),
        ("PT4", "the second pump outlet transmitter"),
        ("PT5", "the riser transmitter"),
    ] {
        // Again and again, and slowly by some psi either way: of the riser's that might as well be a loss at the suction, as the
        // balance of the stand-in holds an inflow that is off.
        let drifts: [&dyn Fn(usize) -> f64; 2] = [&saw, &slow];
        for drift in &drifts[..if tag == "PT5" { 1 } else { 2 }] {
            let rig = Rig::sound().each(&[tag], |i, p| p + drift(i));
            let (bench, ran) = rig.diagnose();
            ran.done();
            let found: Value = serde_json::from_str(&bench.text("d/diagnosis.json")).unwrap();
            let told: Vec<&str> = (found["findings"].as_array().unwrap().iter())
                .map(|f| f["title"].as_str().unwrap())
                .collect();
            let expected =
                format!("something outside the catalogue: the reading of {name} drifts over time");
            // Beside what the stand-in has of its own.
            assert!(told.contains(&expected.as_str()), "{tag}: {told:?}");
        }
    }
}

/// As slowly as instruments wander, but all the time and to one side: neither mud nor pump is at fault.
#[test]
fn a_transmitter_that_creeps_away_from_its_neighbour_for_hours_is_told() {
    for (tag, psi, name) in [
        ("PT1", 14.0, "the first pump inlet transmitter"),
        ("PT2", -14.0, "the second pump inlet transmitter"),
        ("PT3", -11.0, "the first pump outlet transmitter"),
        ("PT4", 11.0, "the second pump outlet transmitter"),
        ("PT5", 14.0, "the riser transmitter"),
    ] {
        let mut rig = Rig::of_hours();
        let samples = rig.table.columns[0].values.len();
        for (i, p) in rig.column(tag).iter_mut().enumerate() {
            *p += psi * i as f64 / samples as f64;
        }
        let told = rig.diagnosed();
        let findings = told.json["findings"].as_array().unwrap();
        let titles: Vec<&str> = findings
            .iter()
            .map(|f| f["title"].as_str().unwrap())
            .collect();
        let expected =
            format!("something outside the catalogue: the reading of {name} drifts over time");
        assert!(titles.contains(&expected.as_str()), "{tag}: {titles:?}");
        // What an outlet is off by in the mean is told beside it: two that part do not tell their constant.
        let known = ["influx", "unknown", "outlet_pressure_bias"];
        let claimed = told.claimed();
        assert!(claimed.contains(&"influx"), "{tag}: {titles:?}");
        assert!(
            claimed.iter().all(|effect| known.contains(effect)),
            "{tag}: {titles:?}"
        );
    }
}

/// Beside the kick that is concealed there; a balance of mud cannot tell a pump from the formation, where the reading is 0 from the start.
#[test]
fn a_pump_that_is_logged_as_still_at_first_is_told_as_an_influx_that_may_be_a_pump() {
    let still = |i: usize, v: f64| if i < 5800 { 0.0 } else { v };
    let found = Rig::of_hours().each(&["FT2"], still).diagnosed();
    let told = found.same_as();
    assert!(
        told.iter()
            .any(|(effect, same)| *effect == "influx" && same.starts_with("a pump of ")),
        "{told:?} {:?}",
        found.claimed()
    );
}

/// What an archive exports that keeps the ends of straight lines along which all readings lie within a tolerance: a swinging door (Bristol, US patent
/// 4,669,097 of 1987).
fn on_lines(values: &[f64], tolerance: f64) -> Vec<f64> {
    let mut lines = values.to_vec();
    let (mut from, mut least, mut most) = (0, f64::NEG_INFINITY, f64::INFINITY);
    for i in 1..=values.len() {
        let slope = |off: f64| (values[i] + off - values[from]) / (i - from) as f64;
        if i < values.len() {
            (least, most) = (least.max(slope(-tolerance)), most.min(slope(tolerance)));
        }
        if i == values.len() || least > most {
            let to = (i - 1).max(from + 1).min(values.len() - 1);
            let rise = (values[to] - values[from]) / (to - from).max(1) as f64;
            for (k, value) in lines[from..to].iter_mut().enumerate() {
                *value = values[from] + rise * k as f64;
            }
            from = to;
            (least, most) = (f64::NEG_INFINITY, f64::INFINITY);
        }
    }
    lines
}

#[test]
fn what_an_archive_leaves_out_of_the_pressures_is_no_mud_that_moves_to_and_fro() {
    let mut rig = Rig::of_hours();
    for tag in ["PT1", "PT2", "PT3", "PT4", "PT5"] {
        let values = rig.column(tag);
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        *values = on_lines(values, 0.002 * mean);
    }
    let found = rig.diagnosed();
    assert!(
        found.err.contains("move on straight lines"),
        "{}",
        found.err
    );
    let named = found.json["findings"].as_array().unwrap().iter();
    let named = named.filter(|f| f["probability"].as_f64() > Some(0.5) && f["effect"] != "unknown");
    let named: Vec<&str> = named.map(|f| f["effect"].as_str().unwrap()).collect();
    assert_eq!(named, ["influx"], "{:#}", found.json["findings"]);
    let others = found.json["findings"].as_array().unwrap().iter();
    let others = others.filter(|f| f["effect"] != "influx");
    let same_as: Vec<&str> = others.map(|f| f["same_as"].as_str().unwrap()).collect();
    assert!(
        !same_as.is_empty()
            && same_as
                .iter()
                .all(|told| told.contains("an archive left out"))
    );
}
