//! What a diagnosis adds to `model.toml`.

use crate::model::{MODEL, finite, geometry, model};
use dgd_documents::{
    Base, ModelDocument, Problem, read_model, read_model_document, write_model,
    write_model_document,
};
use dgd_effects::{
    AppliedEffect, AugmentedModel, Curves, FRICTION_TERMS, HEAD_TERMS, Laminar, Parameter, Place,
    Quantity, Role, Scale, catalogue, find, unknown,
};
use proptest::prelude::*;

fn kick() -> AppliedEffect {
    let parameters = find("influx").unwrap().about().parameters;
    AppliedEffect {
        id: "influx".into(),
        parameters: parameters.iter().map(|p| p.usual).collect(),
    }
}

fn augmented(effects: Vec<AppliedEffect>) -> AugmentedModel {
    AugmentedModel {
        curves: Curves {
            scale: Scale {
                flow_m3_s: 0.06,
                speed_pct: 55.0,
                laminar: None,
            },
            friction: [1e4; FRICTION_TERMS],
            head: [-2.5e3; HEAD_TERMS],
        },
        speed_range_pct: (20.0, 80.0),
        ratio_range: (0.0, 0.001),
        span_s: None,
        inlet_range_pa: None,
        effects,
    }
}

/// The example of the two-state model, with a kick.
pub(crate) fn example() -> String {
    let (model, _) = read_model(MODEL).unwrap();
    write_model_document(&ModelDocument {
        base: Base::Identified(Box::new(model)),
        augmented: Some(augmented(vec![kick()])),
    })
}

/// The one problem of the example with `from` replaced, which must be told at its line, and its help.
#[track_caller]
fn told_once(from: &str, to: &str) -> (String, String) {
    let source = example();
    let (before, _) = source.split_once(from).unwrap();
    let line = before.matches('\n').count() + 1;
    let error = read_model_document(&source.replacen(from, to, 1)).unwrap_err();
    assert_eq!(error.problems.len(), 1, "{error}");
    assert_eq!(error.places[0].0, line, "{error}");
    let problem = &error.problems[0];
    (
        problem.message.clone(),
        problem.help.clone().unwrap_or_default(),
    )
}

#[test]
fn a_document_without_effects_is_the_model_alone() {
    let (model, _) = read_model(MODEL).unwrap();
    let (document, warnings) = read_model_document(&write_model(&model)).unwrap();
    assert!(warnings.is_empty());
    assert_eq!(document.augmented, None);
    assert_eq!(write_model_document(&document), write_model(&model));
    assert_eq!(write_model(document.model().unwrap()), write_model(&model));
}

#[test]
fn an_effect_goes_by_the_names_of_its_parameters() {
    let source = example();
    let table: toml::Table = source.parse().unwrap();
    let effect = &table["augmented"]["effects"][0];
    assert_eq!(effect["id"].as_str(), Some("influx"));
    let parameters = effect["parameters"].as_table().unwrap();
    for p in find("influx").unwrap().about().parameters {
        assert_eq!(parameters[p.name].as_float(), Some(p.usual));
    }
}

#[test]
fn an_effect_that_ends_is_told_by_its_duration() {
    let leak = |parameters: &[f64]| AppliedEffect {
        id: "line_leak".into(),
        parameters: parameters.to_vec(),
    };
    let effects = vec![leak(&[0.002, 900.0]), leak(&[0.002, 900.0, 3600.0])];
    let (model, _) = read_model(MODEL).unwrap();
    let source = write_model_document(&ModelDocument {
        base: Base::Identified(Box::new(model)),
        augmented: Some(augmented(effects.clone())),
    });
    assert_eq!(source.matches("duration_s = 3600.0").count(), 1, "{source}");
    let (document, warnings) = read_model_document(&source).unwrap();
    assert!(warnings.is_empty());
    assert_eq!(document.augmented.unwrap().effects, effects);
    // What has no such form does not take one.
    let other = source.replacen("id = \"line_leak\"", "id = \"inflow_gain\"", 2);
    assert!(read_model_document(&other).is_err());
}

#[test]
fn a_shape_that_an_earlier_model_does_not_tell_is_the_usual_one() {
    let kick = example();
    let (from, _) = kick.split_once("[[augmented.effects]]").unwrap();
    let with = |effect: &str| {
        read_model_document(&format!("{from}[[augmented.effects]]\n{effect}\n"))
            .map(|(document, _)| document.augmented.unwrap().effects)
    };
    let effects = with("id = \"u_tube\"\nparameters = { tau_s = 40.0 }").unwrap();
    assert_eq!(effects[0].parameters, [40.0, 1.0, 0.0]);
    // A strength, and a time, must be told.
    for lacking in [
        "id = \"u_tube\"\nparameters = { drains = 1.0, evenly = 0.0 }",
        "id = \"influx\"\nparameters = { rate_m3_s = 0.002, duration_s = 900.0, ramp = 0.2 }",
    ] {
        assert!(with(lacking).is_err(), "{lacking}");
    }
}

#[test]
fn an_augmented_model_stands_without_a_two_state_one() {
    let (model, _) = read_model(MODEL).unwrap();
    let document = ModelDocument {
        base: Base::WellOnly {
            density_kg_m3: model.density_kg_m3,
            geometry: model.geometry,
        },
        augmented: Some(augmented(Vec::new())),
    };
    let written = write_model_document(&document);
    let (again, warnings) = read_model_document(&written).unwrap();
    assert!(warnings.is_empty(), "{warnings:?}");
    assert_eq!(again, document);
    assert_eq!(again.well().0, 1080.0);
    let error = read_model(&written).unwrap_err();
    assert!(error.to_string().contains("expected a two-state model"));
}

#[test]
fn half_a_two_state_model_is_told_as_ever() {
    let source = example().replacen("[return_flow_meter]", "[meter]", 1);
    let error = read_model_document(&source).unwrap_err();
    assert!(
        error
            .to_string()
            .contains("the section [return_flow_meter] is missing"),
        "{error}"
    );
}

#[test]
fn whoever_knows_no_effects_is_told_that_there_are_some() {
    let source = example();
    let error = read_model(&source).unwrap_err();
    assert_eq!(
        error.problems[0].message,
        "the model contains effects (influx), expected a two-state model without effects"
    );
    let line = source.lines().nth(error.places[0].0 - 1).unwrap();
    assert_eq!(line, "[augmented]");
    // Without effects the two-state model is what it says.
    let (model, _) = read_model(MODEL).unwrap();
    let clean = write_model_document(&ModelDocument {
        base: Base::Identified(Box::new(model.clone())),
        augmented: Some(augmented(Vec::new())),
    });
    assert_eq!(
        write_model(&read_model(&clean).unwrap().0),
        write_model(&model)
    );
}

#[test]
fn an_unknown_effect_is_told_with_the_nearest() {
    let (message, help) = told_once("id = \"influx\"", "id = \"inflx\"");
    assert_eq!(message, "effect `inflx` is not in the catalogue");
    assert_eq!(help, "did you mean `influx`?");
    let (_, help) = told_once("id = \"influx\"", "id = \"Flying Dutchman\"");
    assert_eq!(
        help,
        "the effects are listed in the README of the catalogue"
    );
}

#[test]
fn a_parameter_that_the_effect_does_not_take_is_told_with_the_nearest() {
    let source = example().replacen("rate_m3_s =", "rate =", 1);
    let error = read_model_document(&source).unwrap_err();
    let told: Vec<&str> = error.problems.iter().map(|p| p.message.as_str()).collect();
    assert!(
        told.contains(&"effect `influx` has no parameter `rate`"),
        "{told:?}"
    );
    assert!(
        told.contains(&"[augmented.effects.parameters] has no `rate_m3_s`"),
        "{told:?}"
    );
    let lines: Vec<&str> = error
        .places
        .iter()
        .map(|(line, _)| source.lines().nth(line - 1).unwrap())
        .collect();
    assert!(
        lines.iter().all(|l| l.starts_with("parameters = {")),
        "{lines:?}"
    );
    let (message, help) = told_once("onset_s =", "onset_s = 1.0, onsets =");
    assert_eq!(message, "effect `influx` has no parameter `onsets`");
    assert_eq!(help, "did you mean `onset_s`?");
}

/// The example with a correction of no catalogued effect, whose codes are these.
fn corrected(relation: &str, quantity: &str) -> String {
    let about = find("unknown").unwrap().about();
    let values = about.parameters.iter().map(|p| {
        let value = match p.name {
            "relation" => relation,
            "quantity" => quantity,
            _ => "1.0",
        };
        format!("{} = {value}", p.name)
    });
    let values: Vec<String> = values.collect();
    let effect = "[[augmented.effects]]\nid = \"unknown\"\nparameters";
    format!("{}\n{effect} = {{ {} }}\n", example(), values.join(", "))
}

#[test]
fn a_correction_s_codes_are_those_of_the_catalogue() {
    for (place, quantity) in [(0, 0), (Place::ALL.len() - 1, Quantity::ALL.len() - 1)] {
        let source = corrected(&place.to_string(), &format!("{quantity}.0"));
        let (document, warnings) = read_model_document(&source).unwrap();
        assert!(warnings.is_empty(), "{warnings:?}");
        let effects = document.augmented.unwrap().effects;
        assert_eq!(effects[1].parameters[..2], [place as f64, quantity as f64]);
    }
    let last = Place::ALL.len() - 1;
    for wrong in ["12", "-1", "2.5", "1e300"] {
        let source = corrected(wrong, "0");
        let error = read_model_document(&source).unwrap_err();
        assert_eq!(error.problems.len(), 1, "{error}");
        let problem = &error.problems[0];
        assert!(
            problem
                .message
                .starts_with("`relation` of effect `unknown` is "),
            "{error}"
        );
        let expected = format!("expected a code from 0 to {last}");
        assert!(problem.message.ends_with(&expected), "{error}");
        assert!(problem.message.len() < 80, "{error}");
        let help = problem.help.as_deref().unwrap();
        assert!(
            help.starts_with("0 return line friction, 1 pump head, "),
            "{help}"
        );
        let line = source.lines().nth(error.places[0].0 - 1).unwrap();
        assert!(line.starts_with("parameters = { relation = "), "{line}");
    }
    let error = read_model_document(&corrected("12", "10")).unwrap_err();
    let told: Vec<&str> = error.problems.iter().map(|p| p.message.as_str()).collect();
    assert_eq!(told.len(), 2, "{error}");
    let quantity = "`quantity` of effect `unknown` is 10.0, expected a code from 0 to 9";
    assert_eq!(told[1], quantity);
    let help = error.problems[1].help.as_deref().unwrap();
    assert!(help.ends_with("9 time within an episode"), "{help}");
}

/// Reads back what a document with one effect is written as.
fn read_back(effect: AppliedEffect) -> Result<(), Vec<Problem>> {
    let (model, _) = read_model(MODEL).unwrap();
    let source = write_model_document(&ModelDocument {
        base: Base::Identified(Box::new(model)),
        augmented: Some(augmented(vec![effect])),
    });
    read_model_document(&source)
        .map(|_| ())
        .map_err(|error| error.problems)
}

#[test]
fn a_strength_or_shape_beyond_its_bounds_is_told_and_a_time_may_lie_anywhere() {
    let influx = find("influx").unwrap().about();
    let told = |name: &str, value: f64| {
        let mut one = kick();
        one.parameters[influx.position(name).unwrap()] = value;
        read_back(one)
    };
    for p in influx.parameters {
        if matches!(p.role, Role::Onset | Role::Duration(_)) {
            assert!(told(p.name, 1e9).is_ok(), "{}", p.name);
            continue;
        }
        assert!(told(p.name, p.low).is_ok() && told(p.name, p.high).is_ok());
        for beyond in [p.low - 1.0, p.high + 1.0] {
            let problems = told(p.name, beyond).unwrap_err();
            let [problem] = &problems[..] else {
                panic!("{problems:?}");
            };
            let expected = format!(
                "`{}` of effect `influx` is {beyond:?}, expected {:?} to {:?}",
                p.name, p.low, p.high
            );
            assert_eq!(problem.message, expected);
            assert!(problem.help.as_ref().unwrap().contains(p.meaning));
        }
    }
}

#[test]
fn swell_and_corrections_have_no_bounds() {
    // What the spectrum told of swell is no strength of a run, and a knot is as high as the relation asks.
    let heave = find("heave").unwrap().about();
    let high = heave.parameters.iter().map(|p| 2.0 * p.high);
    let swell = AppliedEffect {
        id: heave.id.into(),
        parameters: high.collect(),
    };
    assert_eq!(read_back(swell), Ok(()));
    let (document, _) = read_model_document(&corrected("2", "8")).unwrap();
    let mut correction = document.augmented.unwrap().effects.remove(1);
    let knot = unknown().about().position("c0").unwrap();
    correction.parameters[knot] = 1e12;
    assert_eq!(read_back(correction), Ok(()));
}

#[test]
fn a_fine_correction_has_its_knots_in_a_list() {
    let (mut document, _) = read_model_document(&corrected("2", "8")).unwrap();
    let coarse = document.augmented.as_ref().unwrap().effects[1].clone();
    let mut fine = coarse.clone();
    fine.parameters.extend((0..25).map(|k| 0.5 * f64::from(k)));
    for effect in [coarse, fine] {
        let listed = effect.parameters.len() > 16;
        document.augmented.as_mut().unwrap().effects[1] = effect.clone();
        let written = write_model_document(&document);
        assert_eq!(written.contains("knots = [1.0, "), listed);
        assert_eq!(
            written.contains("c0 = "),
            !listed || written.contains("[pump.c0]\nc0")
        );
        let (read, warnings) = read_model_document(&written).unwrap();
        assert!(warnings.is_empty(), "{warnings:?}");
        assert_eq!(read.augmented.unwrap().effects[1], effect);
    }
}

#[test]
fn knots_that_are_no_list_of_enough_numbers_are_told() {
    let written = corrected("2", "0");
    let from = written.rfind("c0 = ").unwrap();
    let told = |knots: &str| {
        let source = format!("{}{knots} }}\n", &written[..from]);
        let error = read_model_document(&source).unwrap_err();
        assert_eq!(error.problems.len(), 1, "{error}");
        error.problems[0].message.clone()
    };
    assert_eq!(
        told("knots = [1.0, 2.0]"),
        "`knots` has 2 numbers, expected 12 or more"
    );
    assert_eq!(
        told("knots = 3.0"),
        "`knots` is a float, expected a list of numbers"
    );
    let twelve = "1.0, ".repeat(12);
    assert!(told(&format!("knots = [{twelve}\"x\"]")).starts_with("`knots` is a string"));
    assert_eq!(
        told(&format!("c0 = 1.0, knots = [{twelve}]")),
        "effect `unknown` has no parameter `c0`"
    );
    // No other effect has any.
    let (message, _) = told_once("onset_s =", "knots = [1.0], onset_s =");
    assert_eq!(message, "effect `influx` has no parameter `knots`");
}

#[test]
fn lists_of_another_length_and_ranges_the_wrong_way_are_told() {
    let (message, help) = told_once("friction = [10000.0, ", "friction = [");
    assert_eq!(
        message,
        format!(
            "`friction` has {} numbers, expected {FRICTION_TERMS}",
            FRICTION_TERMS - 1
        )
    );
    assert!(help.contains("another version"));
    let (message, _) = told_once("head = [-2500.0, ", "head = [0.0, 1.0, ");
    assert_eq!(
        message,
        format!(
            "`head` has {} numbers, expected {HEAD_TERMS}",
            HEAD_TERMS + 1
        )
    );
    let (message, _) = told_once(
        "speed_range_pct = [20.0, 80.0]",
        "speed_range_pct = [80, 20]",
    );
    assert_eq!(
        message,
        "`speed_range_pct` runs from 80 to 20, expected the lower one first"
    );
    let (message, _) = told_once("head = [-2500.0, ", "head = [nan, ");
    assert_eq!(message, "`head` is a float, expected a finite number");
    let (message, _) = told_once("flow_scale_m3_s = 0.06", "flow_scale_m3_s = 0");
    assert_eq!(message, "`flow_scale_m3_s` is 0, expected more than 0");
    let source = example().replacen("speed_scale_pct = 55.0\n", "", 1);
    let error = read_model_document(&source).unwrap_err().to_string();
    assert!(
        error.contains("[augmented] has no `speed_scale_pct`"),
        "{error}"
    );
}

#[test]
fn keys_nobody_reads_are_warnings_here_too() {
    let source = example()
        .replacen("ratio_range", "note = 1\nratio_range", 1)
        .replacen("id = \"influx\"", "id = \"influx\"\nwhy = \"so\"", 1);
    let (_, warnings) = read_model_document(&source).unwrap();
    let told: Vec<&str> = warnings.iter().map(|w| w.message.as_str()).collect();
    assert_eq!(
        told,
        [
            "`why` in [augmented.effects] is not read",
            "`note` in [augmented] is not read"
        ]
    );
}

#[test]
fn no_document_makes_the_reader_try_endless_effects() {
    let one = "\n[[augmented.effects]]\nid = \"inflx\"\nparameters = {}\n";
    let error = read_model_document(&(example() + &one.repeat(64))).unwrap_err();
    assert_eq!(error.problems.len(), 1);
    assert_eq!(
        error.problems[0].message,
        "`effects` has 65 effects, expected at most 64"
    );
}

/// Any value that a parameter may have.
fn allowed(parameter: &Parameter) -> BoxedStrategy<f64> {
    let bounds = parameter.low..=parameter.high;
    let timed = matches!(parameter.role, Role::Onset | Role::Duration(_));
    if timed || !(parameter.low.is_finite() && parameter.high.is_finite()) {
        finite().boxed()
    } else {
        prop_oneof![bounds, Just(parameter.low), Just(parameter.high)].boxed()
    }
}

fn applied() -> impl Strategy<Value = AppliedEffect> {
    (0..catalogue().len()).prop_flat_map(|index| {
        let about = catalogue()[index].about();
        let each: Vec<_> = about.parameters.iter().map(allowed).collect();
        each.prop_map(move |parameters| AppliedEffect {
            id: about.id.to_owned(),
            parameters,
        })
    })
}

fn any_augmented() -> impl Strategy<Value = AugmentedModel> {
    let range = || (finite(), finite()).prop_map(|(a, b)| if a <= b { (a, b) } else { (b, a) });
    (
        (1e-300..1e300_f64, 1e-300..1e300_f64),
        proptest::option::of((1e-300..1e300_f64, 1e-300..1e300_f64)),
        proptest::collection::vec(finite(), FRICTION_TERMS),
        proptest::collection::vec(finite(), HEAD_TERMS),
        range(),
        range(),
        proptest::option::of(range()),
        proptest::collection::vec(applied(), 0..4),
    )
        .prop_map(
            |(
                (flow_m3_s, speed_pct),
                laminar,
                friction,
                head,
                speed_range_pct,
                ratio_range,
                span_s,
                effects,
            )| {
                AugmentedModel {
                    curves: Curves {
                        scale: Scale {
                            flow_m3_s,
                            speed_pct,
                            laminar: laminar
                                .map(|(below_m3_s, index)| Laminar { below_m3_s, index }),
                        },
                        friction: friction.try_into().unwrap(),
                        head: head.try_into().unwrap(),
                    },
                    speed_range_pct,
                    ratio_range,
                    span_s,
                    // Another range than that one.
                    inlet_range_pa: span_s.map(|(from, to)| (-to, -from)),
                    effects,
                }
            },
        )
}

fn base() -> impl Strategy<Value = Base> {
    prop_oneof![
        model().prop_map(|m| Base::Identified(Box::new(m))),
        (1e-3..1e5_f64, geometry()).prop_map(|(density_kg_m3, geometry)| Base::WellOnly {
            density_kg_m3,
            geometry
        }),
    ]
}

#[test]
fn laminar_flow_needs_both_of_its_numbers() {
    let scale = "speed_scale_pct = 55.0\n";
    let with = |lines: &str| {
        read_model_document(&example().replacen(scale, &format!("{scale}{lines}"), 1))
    };
    let (read, warnings) = with("laminar_below_m3_s = 0.02\nlaminar_flow_index = 0.8\n").unwrap();
    assert!(warnings.is_empty(), "{warnings:?}");
    let laminar = read.augmented.unwrap().curves.scale.laminar.unwrap();
    assert_eq!((laminar.below_m3_s, laminar.index), (0.02, 0.8));
    for (lines, told) in [
        ("laminar_below_m3_s = 0.02\n", "laminar_flow_index"),
        (
            "laminar_below_m3_s = -0.02\nlaminar_flow_index = 0.8\n",
            "laminar_below_m3_s",
        ),
        (
            "laminar_below_m3_s = 0.02\nlaminar_flow_index = 0\n",
            "laminar_flow_index",
        ),
    ] {
        let error = with(lines).unwrap_err();
        assert_eq!(error.problems.len(), 1, "{error}");
        assert!(error.to_string().contains(told), "{error}");
    }
}

proptest! {
    #[test]
    fn every_augmented_model_is_read_back_to_the_last_bit(base in base(), augmented in any_augmented()) {
        let document = ModelDocument { base, augmented: Some(augmented) };
        let written = write_model_document(&document);
        let (again, warnings) = match read_model_document(&written) {
            Ok(read) => read,
            Err(error) => return Err(TestCaseError::fail(format!("{error}\n{written}"))),
        };
        prop_assert!(warnings.is_empty(), "{warnings:?}\n{written}");
        prop_assert_eq!(format!("{again:?}"), format!("{document:?}"));
        prop_assert_eq!(write_model_document(&again), written);
    }
}
