use dgd_documents::{read_model, write_model};
use dgd_identify::{DataUsed, Estimate, FrictionModel, FrictionTerm, Model, PumpModel};
use dgd_recording::Geometry;
use proptest::prelude::*;

pub(crate) const MODEL: &str = include_str!("../data/model.toml");

/// Line and message of every problem.
fn told(source: &str) -> Vec<(usize, String)> {
    let error = read_model(source).unwrap_err();
    let problems = error.problems.iter().zip(&error.places);
    problems
        .map(|(p, (line, _))| (*line, p.message.clone()))
        .collect()
}

/// Line of the example's first `text`, from 1.
fn line_of(text: &str) -> usize {
    let (before, _) = MODEL.split_once(text).unwrap();
    before.matches('\n').count() + 1
}

/// The one problem of the example with `from` replaced, which must be told at its line.
fn told_once(from: &str, to: &str) -> String {
    let mut told = told(&MODEL.replacen(from, to, 1));
    assert_eq!(told.len(), 1, "{told:#?}");
    let (line, message) = told.remove(0);
    assert_eq!(line, line_of(from), "{message}");
    message
}

fn warned(from: &str, to: &str) -> Vec<String> {
    let (_, warnings) = read_model(&MODEL.replacen(from, to, 1)).unwrap();
    warnings.into_iter().map(|w| w.message).collect()
}

#[test]
fn the_example_is_read_in_si_without_warnings() {
    let (model, warnings) = read_model(MODEL).unwrap();
    assert!(warnings.is_empty());
    assert_eq!(model.density_kg_m3, 1080.0);
    assert_eq!(model.friction.coefficient(0), 2e4);
    assert_eq!(model.friction.coefficient(1), 0.0);
    assert_eq!(
        model.friction.terms[0].coefficient.standard_error,
        Some(400.0)
    );
    assert_eq!(model.delay_s, 12.0);
    assert!(model.pump.mse_m2.is_nan() && model.pump.samples == 0);
    assert_eq!(
        model.data.rejected,
        [("pump off".to_owned(), 50_000), ("gap".to_owned(), 12)]
    );
    model.return_line().check().unwrap();
}

#[test]
fn each_missing_section_is_told() {
    let pump = line_of("[pump]");
    for (section, line) in [
        ("[well]", 1),
        ("[friction]", 1),
        ("[return_flow_meter]", 1),
        ("[pump]", 1),
        ("[pump.c1]", pump),
    ] {
        let inner = section.trim_matches(['[', ']']);
        // A renamed section is missing, and its new name is not read.
        let source = MODEL
            .replace(&format!("[{inner}]"), "[odd]")
            .replace(&format!("[{inner}."), "[odd.")
            .replace("[[odd.", "[[other.");
        let told = told(&source);
        assert_eq!(
            told,
            [(line, format!("the section {section} is missing"))],
            "{source}"
        );
    }
}

#[test]
fn all_problems_are_told_at_once_in_the_order_of_the_document() {
    let source = MODEL
        .replace("value = 1.2e8", "value = \"much\"")
        .replace("n2 = 1.62", "n2 = 0.9")
        .replace("kept = 250000", "kept = -1");
    let lines: Vec<usize> = told(&source).iter().map(|(line, _)| *line).collect();
    assert_eq!(
        lines,
        ["value = 1.2e8", "n2 = 1.62", "kept = 250000"].map(line_of)
    );
}

#[test]
fn the_document_without_a_schema_or_of_another_is_refused() {
    assert_eq!(
        told_once("schema = \"dgd.model/1\"", ""),
        "the document has no `schema`"
    );
    assert_eq!(
        told_once("dgd.model/1", "dgd.model/2"),
        "the schema is `dgd.model/2`, expected `dgd.model/1`"
    );
    assert_eq!(
        told_once("\"dgd.model/1\"", "1"),
        "`schema` is an integer, expected a string in quotes"
    );
}

#[test]
fn a_power_the_line_does_not_have_is_refused() {
    for power in ["5", "-1", "1.5", "1e300"] {
        let message = told_once("power = 2", &format!("power = {power}"));
        assert!(message.ends_with("expected 0, 1, 2 or 3"), "{message}");
    }
}

#[test]
fn two_terms_of_one_power_are_refused() {
    assert_eq!(
        told_once("power = 2", "power = 0"),
        "`power` 0 has two terms, expected one"
    );
}

#[test]
fn terms_come_by_rising_power_in_whatever_order_they_were_written() {
    let swapped = MODEL
        .replace("power = 0", "power = 3")
        .replace("value = 2.0e4", "value = 1e9");
    let (model, _) = read_model(&swapped).unwrap();
    let powers: Vec<u8> = model.friction.terms.iter().map(|t| t.power).collect();
    assert_eq!(powers, [2, 3]);
    assert_eq!(model.friction.coefficient(3), 1e9);
}

#[test]
fn exponents_below_one_are_refused() {
    assert_eq!(
        told_once("n2 = 1.62", "n2 = 0.99"),
        "`n2` is 0.99, expected at least 1"
    );
    assert_eq!(
        told_once("n0 = 1.95", "n0 = 0.5"),
        "`n0` is 0.5, expected at least 1"
    );
}

#[test]
fn negative_and_broken_counts_are_refused() {
    for (from, to) in [
        ("samples = 250000", "samples = -1"),
        ("kept = 250000", "kept = 2.5"),
        ("gap = 12", "gap = -12"),
        ("gap = 12", "gap = \"12\""),
        ("samples = 305820", "samples = 99999999999999999999999"),
    ] {
        let message = told_once(from, to);
        assert!(
            message.ends_with("expected a whole number of at least 0"),
            "{message}"
        );
    }
}

#[test]
fn texts_and_nothing_are_no_numbers() {
    for from in [
        "delay_s = 12",
        "value = 0.0688",
        "mse_pa2 = 1.2e9",
        "standard_error = 400.0",
        "n0 = 1.95",
    ] {
        let key = from.split(' ').next().unwrap();
        assert_eq!(
            told_once(from, &format!("{key} = \"12\"")),
            format!("`{key}` is a string, expected a finite number")
        );
    }
    // A parameter must be finite; only a statistic may be nan.
    for nothing in ["nan", "inf", "1e999"] {
        let message = told_once("value = 0.0688", &format!("value = {nothing}"));
        assert!(message.ends_with("expected a finite number"), "{message}");
    }
}

#[test]
fn a_list_that_is_none_is_told() {
    assert_eq!(
        told_once("active_constraints = []", "active_constraints = \"c1 > 0\""),
        "`active_constraints` is a string, expected a list of strings"
    );
    assert_eq!(
        told_once("[\"a.csv\", \"b.csv\"]", "[\"a.csv\", 7]"),
        "`recordings` is an integer, expected a string in quotes"
    );
    let one = MODEL.replacen("[[friction.term]]", "[friction.term]", 1);
    assert!(read_model(&one).is_err());
}

#[test]
fn keys_nobody_reads_are_warnings() {
    assert_eq!(
        warned("r2 = 0.99", "r22 = 0.99"),
        ["`r22` in [friction] is not read"]
    );
    assert_eq!(
        warned("standard_error = 400.0", "std = 400.0"),
        ["`std` in [friction.term] is not read"]
    );
    assert_eq!(
        warned("value = 3.1", "value = 3.1\nunit = \"m\""),
        ["`unit` in [pump.c1] is not read"]
    );
    assert_eq!(
        warned("step_s = 1.0", "step = 1.0"),
        ["`step` in [data] is not read"]
    );
    assert_eq!(
        warned("[well]", "[wells]\n[well]"),
        ["`wells` in the document is not read"]
    );
}

fn name() -> impl Strategy<Value = String> {
    // Quotes, backslashes, newlines, delete, other alphabets and the empty name.
    prop_oneof![
        any::<String>(),
        "[\"'\\\\\n\r\t\u{7f}\u{0} =#\\[\\]æøå漢]{0,12}",
    ]
}

fn statistic() -> impl Strategy<Value = f64> {
    use proptest::num::f64::{INFINITE, NEGATIVE, NORMAL, POSITIVE, SUBNORMAL, ZERO};
    prop_oneof![
        8 => NORMAL | SUBNORMAL | ZERO | POSITIVE | NEGATIVE,
        1 => INFINITE,
        1 => Just(f64::NAN),
    ]
}

pub(crate) fn finite() -> impl Strategy<Value = f64> {
    use proptest::num::f64::{NEGATIVE, NORMAL, POSITIVE, SUBNORMAL, ZERO};
    NORMAL | SUBNORMAL | ZERO | POSITIVE | NEGATIVE
}

fn estimate() -> impl Strategy<Value = Estimate> {
    let error = proptest::option::of(statistic());
    (finite(), error).prop_map(|(value, standard_error)| Estimate {
        value,
        standard_error,
    })
}

pub(crate) fn geometry() -> impl Strategy<Value = Geometry> {
    let length = || 1e-3..1e4_f64;
    let known = || proptest::option::of(1e-3..1e4_f64);
    (
        length(),
        0.01..0.99_f64,
        known(),
        length(),
        known(),
        length(),
        length(),
        known(),
    )
        .prop_map(
            |(riser, share, casing, line, booster, inlet, outlet, sensor)| Geometry {
                riser_id_m: riser,
                drillpipe_od_m: share * riser,
                casing_od_m: casing,
                return_line_id_m: line,
                booster_line_id_m: booster,
                pump_inlet_depth_m: inlet,
                pump_outlet_depth_m: outlet,
                riser_pressure_sensor_depth_m: sensor,
            },
        )
}

fn friction() -> impl Strategy<Value = FrictionModel> {
    let terms = proptest::sample::subsequence(vec![0_u8, 1, 2, 3], 0..=4);
    let terms = (terms, [estimate(), estimate(), estimate(), estimate()]);
    (terms, statistic(), statistic(), any::<u64>(), statistic()).prop_map(
        |((powers, estimates), mse_pa2, r2, samples, condition)| FrictionModel {
            terms: powers
                .into_iter()
                .zip(estimates)
                .map(|(power, coefficient)| FrictionTerm { power, coefficient })
                .collect(),
            mse_pa2,
            r2,
            samples,
            condition,
        },
    )
}

fn pump() -> impl Strategy<Value = PumpModel> {
    let names = proptest::collection::vec(name(), 0..3);
    let statistics = (statistic(), statistic(), any::<u64>(), statistic());
    (
        [estimate(), estimate(), estimate()],
        1.0..5.0_f64,
        1.0..5.0_f64,
        statistics,
        names,
    )
        .prop_map(
            |([c0, c1, c2], n0, n2, (mse_m2, r2, samples, condition), active_constraints)| {
                PumpModel {
                    c0,
                    c1,
                    c2,
                    n0,
                    n2,
                    mse_m2,
                    r2,
                    samples,
                    condition,
                    active_constraints,
                }
            },
        )
}

fn data() -> impl Strategy<Value = DataUsed> {
    let recordings = proptest::collection::vec(name(), 0..4);
    let rejected = proptest::collection::hash_map(name(), any::<usize>(), 0..4);
    (
        recordings,
        any::<usize>(),
        any::<usize>(),
        statistic(),
        rejected,
    )
        .prop_map(|(recordings, samples, kept, step_s, rejected)| DataUsed {
            recordings,
            samples,
            kept,
            step_s,
            rejected: rejected.into_iter().collect(),
        })
}

pub(crate) fn model() -> impl Strategy<Value = Model> {
    (
        1e-3..1e5_f64,
        geometry(),
        friction(),
        pump(),
        finite(),
        data(),
    )
        .prop_map(
            |(density_kg_m3, geometry, friction, pump, delay_s, data)| Model {
                density_kg_m3,
                geometry,
                friction,
                pump,
                delay_s,
                data,
            },
        )
}

proptest! {
    #[test]
    fn every_model_is_read_back_to_the_last_bit(model in model()) {
        let written = write_model(&model);
        let (again, warnings) = match read_model(&written) {
            Ok(read) => read,
            Err(error) => return Err(TestCaseError::fail(format!("{error}\n{written}"))),
        };
        prop_assert!(warnings.is_empty(), "{warnings:?}\n{written}");
        // Debug shows the shortest digits that tell two floats apart, the sign of zero and NaN.
        prop_assert_eq!(format!("{again:?}"), format!("{model:?}"));
        prop_assert_eq!(write_model(&again), written);
    }
}
