//! Recordings that are whole files with wrong data: a right answer or a clear refusal, row by row of BAD-DATA.md.
//!
//! Each row changes the demo's recording or its well description and runs the binary.

use crate::bench::{Bench, Ran, mat5};
use dgd_ingest::ReadOptions;
use dgd_plant::{Kind, Level, Order, Severity, conceal, record, write_case, write_case_well_toml};
use dgd_recording::Table;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde_json::Value;

const RECORDING: &[u8] = include_bytes!("../../../../fixtures/demo/recording.mat");
const WELL: &str = include_str!("../../../../fixtures/demo/well.toml");

/// The demo's recording and description, to be spoilt.
struct Rig {
    table: Table,
    well: String,
}

impl Rig {
    fn sound() -> Self {
        let mut table = dgd_ingest::read(RECORDING, &ReadOptions::default())
            .unwrap()
            .1;
        for column in &mut table.columns {
            // The description alone says the unit, so that it can be wrong.
            column.unit = None;
            column.tag = column.tag.rsplit('.').next().unwrap().to_owned();
        }
        Self {
            table,
            well: WELL.to_owned(),
        }
    }

    /// The first samples alone.
    fn first(samples: usize) -> Self {
        let mut rig = Self::sound();
        for column in &mut rig.table.columns {
            column.values.truncate(samples);
        }
        rig
    }

    fn column(&mut self, tag: &str) -> &mut Vec<f64> {
        let mut columns = self.table.columns.iter_mut();
        &mut columns.find(|c| c.tag == tag).unwrap().values
    }

    fn each(mut self, tags: &[&str], change: impl Fn(usize, f64) -> f64) -> Self {
        for tag in tags {
            for (i, value) in self.column(tag).iter_mut().enumerate() {
                *value = change(i, *value);
            }
        }
        self
    }

    fn swapped(mut self, a: &str, b: &str) -> Self {
        let one = std::mem::take(self.column(a));
        let other = std::mem::replace(self.column(b), one);
        *self.column(a) = other;
        self
    }

    /// What the description says, in other words.
    fn saying(mut self, found: &str, instead: &str) -> Self {
        assert!(self.well.contains(found), "{found}");
        self.well = self.well.replace(found, instead);
        self
    }

    /// Every so many samples.
    fn every(mut self, step: usize) -> Self {
        for column in &mut self.table.columns {
            column.values = column.values.iter().copied().step_by(step).collect();
        }
        self
    }

    fn set_up(&self) -> Bench {
        let bench = Bench::bare();
        bench.write("rig.mat", mat5(&self.table));
        bench.write("well.toml", &self.well);
        bench
    }

    fn fit(&self) -> Ran {
        self.set_up().dgd("fit rig.mat --well well.toml --json")
    }

    /// `dgd fit`, which must give an answer.
    #[track_caller]
    fn fitted(&self) -> Fitted {
        let ran = self.fit();
        let err = ran.err.clone();
        Fitted {
            json: serde_json::from_str(&ran.done()).unwrap(),
            err,
        }
    }

    /// `dgd simulate` with the sound recording's model.
    fn simulate(&self) -> Ran {
        let bench = self.set_up();
        bench.write("sound.mat", mat5(&Self::sound().table));
        bench.write("sound.toml", WELL);
        bench.dgd("fit sound.mat --well sound.toml").done();
        bench.dgd("simulate rig.mat --well well.toml --model model.toml --json")
    }

    fn diagnose(&self) -> (Bench, Ran) {
        let bench = self.set_up();
        let ran = bench.dgd("diagnose rig.mat --well well.toml --out d --json");
        (bench, ran)
    }
}

struct Fitted {
    json: Value,
    err: String,
}

impl Fitted {
    fn delay_s(&self) -> f64 {
        self.json["delay"]["best_s"].as_f64().unwrap()
    }

    fn warnings(&self) -> Vec<&str> {
        strings(&self.json["warnings"])
    }

    /// The model is the sound recording's: same delay within `slack_s`, friction at 0.05 m3/s within 3 %.
    #[track_caller]
    fn right(&self, slack_s: f64) -> &Self {
        let sound = Rig::sound().fitted();
        assert!(
            (self.delay_s() - sound.delay_s()).abs() <= slack_s,
            "{:#}",
            self.json
        );
        let ratio = self.friction_pa() / sound.friction_pa();
        assert!((0.97..1.03).contains(&ratio), "{ratio}");
        self
    }

    fn friction_pa(&self) -> f64 {
        let terms = self.json["model"]["friction"].as_array().unwrap();
        let term = |t: &Value| {
            let power: i32 = t["power"].as_u64().unwrap().try_into().unwrap();
            t["estimate"]["value"].as_f64().unwrap() * 0.05f64.powi(power)
        };
        terms.iter().map(term).sum()
    }

    /// One suspicion, told alike on the terminal and in JSON, at this line and with these words.
    #[track_caller]
    fn suspects(&self, line: usize, parts: &[&str]) {
        let place = format!("well.toml:{line}: ");
        let told = self.warnings();
        let found: Vec<&&str> = told
            .iter()
            .filter(|w| w.starts_with("well.toml:"))
            .collect();
        assert_eq!(found.len(), 1, "{told:#?}");
        assert!(found[0].starts_with(&place), "{}", found[0]);
        for part in parts {
            assert!(found[0].contains(part), "`{part}` is not in: {}", found[0]);
        }
        assert!(self.err.contains(*found[0]), "{}", self.err);
    }

    #[track_caller]
    fn warns(&self, part: &str) {
        let told = self.warnings();
        assert!(
            told.iter().any(|w| w.contains(part)),
            "`{part}` is not in: {told:#?}"
        );
    }

    #[track_caller]
    fn suspects_nothing(&self) -> &Self {
        let told = self.warnings();
        assert!(
            told.iter().all(|w| !w.starts_with("well.toml:")),
            "{told:#?}"
        );
        self
    }
}

fn strings(list: &Value) -> Vec<&str> {
    list.as_array()
        .unwrap()
        .iter()
        .map(|w| w.as_str().unwrap())
        .collect()
}

const PRESSURES: [&str; 5] = ["PT1", "PT2", "PT3", "PT4", "PT5"];
const CHANNELS: [&str; 10] = [
    "FT1", "FT2", "FT3", "FT4", "PT1", "PT2", "PT3", "PT4", "PT5", "SPM",
];

fn line_of(part: &str) -> usize {
    WELL.lines().position(|l| l.contains(part)).unwrap() + 1
}

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
fn nan_at_three_samples_of_ten_leaves_the_answer_right() {
    storm(0.3).fitted().right(1.0).suspects_nothing();
}

#[test]
fn nan_at_nine_samples_of_ten_is_refused_with_what_is_left() {
    let ran = storm(0.9).fit();
    ran.refused(&[
        "samples passed the screening, expected at least",
        "gap",
        "return_flow `FT4` has a value at only",
    ]);
    let (_, ran) = storm(0.9).diagnose();
    ran.refused(&["blocks of 10 s with flow and pressure can be used"]);
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
    rested.warns("explains only 0 % of the head's variance");
}

#[test]
fn swapped_sides_of_the_pump_are_told() {
    Rig::sound().swapped("PT1", "PT3").fitted().suspects(
        line_of("PT1"),
        &[
            "pump_inlet_pressure `PT1` and pump_outlet_pressure `PT3`",
            "if their tags are swapped",
        ],
    );
    let both = Rig::sound().swapped("PT1", "PT3").swapped("PT2", "PT4");
    both.fit().refused(&[
        "the pressure falls by",
        "if their tags are swapped",
        "no pressure rise",
    ]);
}

#[test]
fn swapped_flows_are_told() {
    for (a, b) in [("FT1", "FT4"), ("FT2", "FT4")] {
        Rig::sound().swapped(a, b).fitted().suspects(
            line_of(&format!("\"{a}\"")),
            &[
                "of what is pumped in",
                &format!("`{a}` and return_flow `FT4`"),
                "if their tags are swapped",
            ],
        );
    }
}

#[test]
fn swapped_speed_is_told() {
    for (other, line) in [("FT3", "FT3"), ("FT4", "FT4")] {
        Rig::sound().swapped("SPM", other).fitted().suspects(
            line_of(&format!("\"{line}\"")),
            &[
                &format!("`{other}` and pump_speed `SPM`"),
                "if their tags are swapped",
            ],
        );
    }
    let ran = Rig::sound().swapped("SPM", "PT1").fit();
    ran.refused(&[
        "`PT1` and pump_speed `SPM`",
        "if their tags are swapped",
        "out of range",
    ]);
}

#[test]
fn swapped_inflows_change_nothing() {
    Rig::sound()
        .swapped("FT1", "FT2")
        .fitted()
        .right(0.0)
        .suspects_nothing();
}

#[test]
fn one_pressure_in_another_unit_is_told_with_the_unit_that_fits() {
    for (tag, wrong) in [("PT1", "kPa"), ("PT3", "bar"), ("PT5", "bar")] {
        let told = format!("\"{tag}\", unit = \"psia\"");
        let rig = Rig::sound().saying(&told, &format!("\"{tag}\", unit = \"{wrong}\""));
        rig.fitted().suspects(
            line_of(&format!("\"{tag}\"")),
            &["read as", wrong, "as psia", &format!("`{tag}` would be")],
        );
    }
    let ran = Rig::sound()
        .saying("\"PT1\", unit = \"psia\"", "\"PT1\", unit = \"bar\"")
        .fit();
    ran.refused(&[
        "as psia pump_inlet_pressure `PT1` would be 26.4 bar",
        "no pressure rise",
    ]);
}

#[test]
fn all_pressures_in_another_unit_are_told_at_once() {
    for wrong in ["bar", "kPa"] {
        let rig = Rig::sound().saying("psia", wrong);
        rig.fitted().suspects(
            line_of("PT1"),
            &[
                &format!("is read as {wrong}"),
                "as psia all pressures would be 26.4 bar",
            ],
        );
    }
}

#[test]
fn a_gauge_reading_among_absolute_ones_is_told() {
    let rig = Rig::sound().saying("\"PT1\", unit = \"psia\"", "\"PT1\", unit = \"psig\"");
    rig.fitted().suspects(
        line_of("PT1"),
        &["an atmosphere apart", "both are gauge or both absolute"],
    );
}

#[test]
fn all_pressures_gauge_for_absolute_move_the_offset_alone() {
    let read = Rig::sound().saying("psia", "psig").fitted();
    read.suspects_nothing();
    let (offset, sound) = (read.friction_pa(), Rig::sound().fitted().friction_pa());
    assert!(
        (offset - sound - 101_325.0).abs() < 10.0,
        "{offset} {sound}"
    );
}

#[test]
fn flows_in_another_unit_are_told() {
    for wrong in ["l/min", "m3/h", "l/s", "bbl/min"] {
        let rig = Rig::sound().saying(
            "\"FT4\", unit = \"gpm\"",
            &format!("\"FT4\", unit = \"{wrong}\""),
        );
        rig.fitted().suspects(
            line_of("\"FT4\""),
            &[
                "of what is pumped in",
                wrong,
                "as gpm return_flow `FT4` would be 3,105 l/min",
            ],
        );
    }
    for wrong in ["l/min", "m3/h", "l/s"] {
        let rig = Rig::sound().saying("\"gpm\"", &format!("\"{wrong}\""));
        rig.fitted().suspects(
            line_of("\"FT1\""),
            &["as gpm all flows would be 2,132 l/min"],
        );
    }
}

#[test]
fn a_speed_that_is_no_percentage_is_told() {
    let share = Rig::sound().each(&["SPM"], |_, w| w / 100.0).fitted();
    share.suspects(
        line_of("SPM"),
        &["it reaches 0.58", "as a share of 1 it would reach 58"],
    );
    let rpm = Rig::sound().each(&["SPM"], |_, w| 18.0 * w).fit();
    rpm.refused(&["it reaches 1,060 %", "out of range"]);
}

#[test]
fn lengths_and_density_in_another_unit_are_told() {
    let feet = Rig::sound()
        .saying("350.30 m", "350.30 ft")
        .saying("352.10 m", "352.10 ft");
    feet.fitted().suspects(
        line_of("pump_inlet_depth"),
        &[
            "it would fit a pump at 350 m",
            "metres that are written as ft",
        ],
    );
    let metres = Rig::sound()
        .saying("350.30 m", "1149.3 m")
        .saying("352.10 m", "1155.2 m");
    metres.fitted().suspects(
        line_of("pump_inlet_depth"),
        &["it would fit a pump at 350 m"],
    );
    let ppg = Rig::sound().saying("1.080 sg", "1.080 ppg");
    ppg.fitted().suspects(
        line_of("density"),
        &["mud of 129 kg/m3 is no drilling mud", "mud of 1,080 kg/m3"],
    );
    let line = Rig::sound().saying("6.000 in", "6.000 cm");
    line.fitted().suspects(
        line_of("return_line_id"),
        &["friction factor", "a return line of 0.152 m"],
    );
    let riser = Rig::sound().saying("19.5 in", "19.5 cm");
    riser.fitted().suspects(
        line_of("riser_id"),
        &["the riser level moves", "a riser of 0.495 m"],
    );
}

#[test]
fn a_clock_in_another_unit_is_told() {
    for (wrong, words) in [
        ("min", "the riser level moves 0.0177 times"),
        ("h", "the samples are 3,600 s apart"),
    ] {
        let rig = Rig::sound().saying("unit = \"s\"", &format!("unit = \"{wrong}\""));
        rig.fitted()
            .suspects(line_of("time"), &[words, "as s they would be 1 s apart"]);
    }
    let ran = Rig::sound().saying("unit = \"s\"", "unit = \"ms\"").fit();
    ran.refused(&[
        "the samples are 0.001 s apart; as s they would be 1 s apart",
        "delays",
    ]);
}

#[test]
fn a_clock_that_skips_leaves_a_gap() {
    let rig = Rig::sound().each(&["t"], |i, t| if i < 3000 { t } else { t + 1000.0 });
    let fitted = rig.fitted();
    fitted.right(1.0);
    assert!(
        fitted.err.contains("1 gaps, 1000 samples missing"),
        "{}",
        fitted.err
    );
}

#[test]
fn a_clock_that_is_set_back_or_years_forward_is_refused_with_the_place() {
    let back = Rig::sound().each(&["t"], |i, t| if i < 3000 { t } else { t - 500.0 });
    for ran in [back.fit(), back.simulate(), back.diagnose().1] {
        ran.refused(&["jumps back by 499 s after 2999 s", "split the file there"]);
    }
    let years = Rig::sound().each(&["t"], |i, t| if i < 3000 { t } else { t + 3e7 });
    years
        .fit()
        .refused(&["the largest jump is at 2999 s", "split the file there"]);
}

#[test]
fn a_recording_that_is_there_twice_counts_once() {
    let mut rig = Rig::sound();
    for column in &mut rig.table.columns {
        let tail = column.values[3000..].to_vec();
        column.values.truncate(4000);
        column.values.extend(tail);
    }
    let fitted = rig.fitted();
    fitted.right(0.0);
    assert!(
        fitted.err.contains("1000 samples repeat a time stamp"),
        "{}",
        fitted.err
    );
}

#[test]
fn stamps_that_are_missing_cost_their_samples_alone() {
    Rig::sound()
        .each(&["t"], |i, t| if i % 3 == 1 { f64::NAN } else { t })
        .fitted()
        .right(2.0);
}

fn late(tags: &[&str], by: usize) -> Rig {
    let mut rig = Rig::sound();
    for tag in tags {
        let column = rig.column(tag);
        let first = column[0];
        column.splice(0..0, std::iter::repeat_n(first, by));
        let keep = column.len() - by;
        column.truncate(keep);
    }
    rig
}

#[test]
fn channels_on_different_clocks_are_told() {
    late(&["FT4"], 20)
        .fitted()
        .warns("the best delay, 30 s, is the last of the range: sweep further up");
    late(&PRESSURES, 30)
        .fitted()
        .warns("the return flow is 17 s ahead of the pressures, which no meter is");
    late(&["SPM"], 30)
        .fitted()
        .warns("with the pump speed read 30 s later than recorded");
}

#[test]
fn a_meter_whose_clock_runs_fast_is_told() {
    let mut rig = Rig::sound();
    let column = rig.column("FT4");
    let before = column.clone();
    for (i, value) in column.iter_mut().enumerate() {
        *value = before.get(i + i / 50).copied().unwrap_or(f64::NAN);
    }
    rig.fitted()
        .warns("ahead of the pressures, which no meter is");
}

#[test]
fn steps_from_a_tenth_of_a_second_to_half_a_minute_give_one_answer() {
    let mut fast = Rig::first(1800);
    for column in &mut fast.table.columns {
        let between = |w: &[f64]| {
            (0..10)
                .map(|k| w[0] + f64::from(k) / 10.0 * (w[1] - w[0]))
                .collect::<Vec<f64>>()
        };
        column.values = column.values.windows(2).flat_map(between).collect();
    }
    let fast = fast.fitted();
    let step_s = fast.json["step_s"].as_f64().unwrap();
    assert!((step_s - 0.1).abs() < 1e-9, "{step_s}");
    assert!((fast.delay_s() - 13.0).abs() < 1.5, "{}", fast.delay_s());
    fast.suspects_nothing();
    for (step, slack_s) in [(2, 2.0), (5, 5.0), (10, 10.0)] {
        Rig::sound()
            .every(step)
            .fitted()
            .right(slack_s)
            .suspects_nothing();
    }
    Rig::sound().every(30).fitted().suspects_nothing();
}

#[test]
fn mixed_rates_held_or_left_empty_give_the_same_answer() {
    let empty = Rig::sound().each(&PRESSURES, |i, p| if i % 10 == 0 { p } else { f64::NAN });
    empty.fitted().right(3.0).warns("`PT1` has a value at only");
    let mut held = Rig::sound();
    for tag in PRESSURES {
        let column = held.column(tag);
        for i in 0..column.len() {
            column[i] = column[i - i % 10];
        }
    }
    held.fitted().right(5.0);
}

#[test]
fn a_transmitter_that_the_file_lacks_is_named() {
    for tag in CHANNELS {
        let mut rig = Rig::sound();
        rig.table.columns.retain(|c| c.tag != tag);
        let parts = [format!(
            "is mapped to the tag `{tag}`, which the recording does not have"
        )];
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
fn too_short_a_recording_is_refused_or_told() {
    Rig::first(1).fit().refused(&["expected at least 2"]);
    Rig::first(30)
        .fit()
        .refused(&["in a recording of 30 samples"]);
    Rig::first(600).fitted().warns("the flow hardly moves");
    let (bench, ran) = Rig::first(1800).diagnose();
    ran.refused(&["blocks of 10 s with flow and pressure can be used, a diagnosis needs"]);
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
        ran.err.contains("hardly fits its well description"),
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
