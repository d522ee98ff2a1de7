//! `diagnosis.json`.

use dgd_diagnose::{
    Check, CorrectionCurve, Diagnosis, Finding, HeldOut, Outcome, ParameterEstimate, Simulation,
    Tested, Verdict, Work,
};
use dgd_documents::{DIAGNOSIS_SCHEMA, write_diagnosis};
use dgd_effects::{
    AugmentedModel, Curves, FRICTION_TERMS, HEAD_TERMS, Noise, Relation, Scale, Setting,
};
use dgd_recording::Moment;
use proptest::prelude::*;
use serde_json::{Value, json};

fn finding() -> Finding {
    Finding {
        effect: "influx".into(),
        resembles: None,
        title: "formation fluid enters the well".into(),
        probability: 0.97,
        alternatives: vec![("line_leak".into(), 0.02)],
        relation: Relation::RiserMassBalance,
        shows_in: vec![Relation::RiserMassBalance],
        pair: None,
        intervals_s: vec![(10_230.0, 14_012.0)],
        region: "at flows from 0.03 to 0.05 m³/s".into(),
        parameters: vec![ParameterEstimate {
            name: "rate_m3_s".into(),
            meaning: "rate of the plateau".into(),
            estimate: 0.0021,
            ci95: (0.0019, 0.0023),
        }],
        curve: None,
        held_out: Some(HeldOut {
            signal: "riser_level_m".into(),
            rmse_before: 1.9,
            rmse_after: 0.12,
            improvement_ci95: (0.9, 0.95),
        }),
        equation_before: "A dh/dt = q_in - q".into(),
        equation_after: "A dh/dt = q_in + rate s(t) - q".into(),
        source: "Eq. 3.45".into(),
        evidence: 120.5,
        hurdle: 9.0,
        separating_test: Some("flow check".into()),
        same_as: Some("another mud".into()),
    }
}

fn diagnosis(findings: Vec<Finding>) -> Diagnosis {
    let model = AugmentedModel {
        curves: Curves {
            scale: Scale {
                flow_m3_s: 0.06,
                speed_pct: 55.0,
                laminar: None,
            },
            friction: [0.0; FRICTION_TERMS],
            head: [0.0; HEAD_TERMS],
        },
        speed_range_pct: (20.0, 80.0),
        ratio_range: (0.0, 0.001),
        span_s: None,
        inlet_range_pa: None,
        effects: Vec::new(),
    };
    Diagnosis {
        verdict: if findings.is_empty() {
            Verdict::Consistent
        } else {
            Verdict::Explained
        },
        findings,
        started_from: Vec::new(),
        suspected: Vec::new(),
        tested: vec![
            Tested {
                effect: "heave",
                title: "rig motion",
                outcome: Outcome::NotSeen,
                evidence: -3.0,
                admissible: true,
                hurdle: 12.0,
                strength: "Pa",
                standard_error: None,
                limit: Some(900.0),
            },
            Tested {
                effect: "gel_strength",
                title: "gel",
                outcome: Outcome::NotTestable("no \"restart\"\n".into()),
                evidence: f64::NAN,
                admissible: true,
                hurdle: 12.0,
                strength: "Pa",
                standard_error: None,
                limit: None,
            },
        ],
        warnings: vec!["is \"FT1\" in psi?".into()],
        checks: vec![Check {
            name: "placebo".into(),
            passed: true,
            detail: "gain 0.1 %".into(),
        }],
        before: model.clone(),
        after: model,
        setting: Setting {
            density_kg_m3: 1080.0,
            riser_area_m2: 0.17,
            line_area_m2: 0.018,
            line_diameter_m: 0.1524,
            line_length_m: 350.0,
            riser_volume_m3: 30.0,
            span_s: (0.0, 14_400.0),
            inlet_range_pa: (2e6, 3e6),
            outlets: 2,
            connections: Vec::new(),
            noise: Noise::default(),
        },
        simulation: Simulation {
            t_s: Vec::new(),
            held_out: Vec::new(),
            valid: Vec::new(),
            signals: Vec::new(),
        },
        traces: Vec::new(),
        held_out_s: vec![(3600.0, 7200.0)],
        began: Moment::parse("2024-10-26 03:00"),
        settings: vec![("engine".into(), "1".into())],
        work: Work::default(),
    }
}

fn read(diagnosis: &Diagnosis) -> Value {
    serde_json::from_str(&write_diagnosis(diagnosis)).unwrap()
}

#[test]
fn a_reading_at_fault_tells_all_the_residuals_that_it_enters() {
    let reading = Finding {
        relation: Relation::Instrument,
        shows_in: vec![Relation::PumpHead, Relation::RiserMassBalance],
        pair: Some("inlet less riser"),
        ..finding()
    };
    let value = read(&diagnosis(vec![reading]));
    let finding = &value["findings"][0];
    assert_eq!(finding["relation"], "instrument");
    assert_eq!(
        finding["shows_in"],
        json!(["pump_head", "riser_mass_balance"])
    );
    assert_eq!(finding["shows_in_pair"], "inlet less riser");
}

#[test]
fn a_finding_has_the_members_that_the_schema_promises() {
    let value = read(&diagnosis(vec![finding()]));
    assert_eq!(value["schema"], "dgd.diagnosis/1");
    assert_eq!(value["schema"], DIAGNOSIS_SCHEMA);
    assert_eq!(value["verdict"], "explained");
    let finding = &value["findings"][0];
    let promised = json!({
        "effect": "influx",
        "probability": 0.97,
        "alternatives": [{ "effect": "line_leak", "probability": 0.02 }],
        "relation": "riser_mass_balance",
        "shows_in": ["riser_mass_balance"],
        "intervals_s": [[10230.0, 14012.0]],
        "region": "at flows from 0.03 to 0.05 m³/s",
        "held_out": {
            "signal": "riser_level_m", "rmse_before": 1.9, "rmse_after": 0.12, "improvement_ci95": [0.9, 0.95]
        },
        "title": "formation fluid enters the well",
        "evidence_ln": 120.5,
        "separating_test": "flow check",
        "same_as": "another mud",
        "equation_before": "A dh/dt = q_in - q",
        "equation_after": "A dh/dt = q_in + rate s(t) - q",
    });
    for (name, expected) in promised.as_object().unwrap() {
        assert_eq!(&finding[name], expected, "{name}");
    }
    assert!(finding.get("shows_in_pair").is_none());
    let rate = &finding["parameters"]["rate_m3_s"];
    assert_eq!(rate["estimate"], 0.0021);
    assert_eq!(rate["ci95"], json!([0.0019, 0.0023]));
    assert_eq!(value["tested"][0]["outcome"], "not_seen");
    assert_eq!(value["tested"][0]["detection_limit"], 900.0);
    assert_eq!(value["tested"][1]["outcome"], "not_testable");
    assert_eq!(value["tested"][1]["reason"], "no \"restart\"\n");
    assert_eq!(value["checks"][0]["passed"], true);
    assert_eq!(value["settings"]["engine"], "1");
}

#[test]
fn a_correction_has_its_curve_and_no_number_that_is_none() {
    let curve = CorrectionCurve {
        along: "time_s",
        adds: "correction_pa",
        knots: vec![(0.0, 12.5), (60.0, f64::NAN), (120.0, -3.0)],
        level: None,
    };
    let correction = Finding {
        curve: Some(curve),
        ..finding()
    };
    let value = read(&diagnosis(vec![correction, finding()]));
    let told = json!({ "along": "time_s", "adds": "correction_pa", "knots": [[0.0, 12.5], [120.0, -3.0]] });
    assert_eq!(value["findings"][0]["curve"], told);
    assert!(value["findings"][1].get("curve").is_none());
}

#[test]
fn a_consistent_recording_has_an_empty_list_of_findings() {
    let value = read(&diagnosis(Vec::new()));
    assert_eq!(value["verdict"], "consistent");
    assert_eq!(value["findings"], json!([]));
    assert_eq!(value["warnings"], json!(["is \"FT1\" in psi?"]));
}

#[test]
fn the_schema_stands_first_and_members_keep_their_order() {
    let text = write_diagnosis(&diagnosis(vec![finding()]));
    let at = |name: &str| text.find(&format!("\"{name}\":")).unwrap();
    let names = [
        "schema",
        "verdict",
        "findings",
        "probability",
        "held_out",
        "tested",
        "checks",
    ];
    assert!(
        names.windows(2).all(|two| at(two[0]) < at(two[1])),
        "{text}"
    );
    assert!(text.ends_with("}\n"));
}

#[test]
fn no_number_is_written_that_is_none() {
    let mut one = finding();
    one.probability = f64::NAN;
    one.evidence = f64::INFINITY;
    one.intervals_s.push((f64::NAN, 1.0));
    one.parameters[0].ci95 = (f64::NEG_INFINITY, 1.0);
    one.parameters.push(ParameterEstimate {
        name: "onset_s".into(),
        meaning: String::new(),
        estimate: f64::NAN,
        ci95: (0.0, 1.0),
    });
    one.held_out.as_mut().unwrap().rmse_after = f64::NAN;
    let value = read(&diagnosis(vec![one]));
    let finding = &value["findings"][0];
    assert_eq!(finding["probability"], 0.0);
    assert_eq!(finding["intervals_s"], json!([[10230.0, 14012.0]]));
    let parameters = finding["parameters"].as_object().unwrap();
    assert_eq!(parameters["rate_m3_s"]["estimate"], 0.0021);
    assert!(parameters["rate_m3_s"].get("ci95").is_none());
    assert!(!parameters.contains_key("onset_s"));
    for absent in ["held_out", "evidence_ln"] {
        assert!(finding.get(absent).is_none(), "{absent}");
    }
    assert!(value["tested"][1].get("evidence_ln").is_none());
}

proptest! {
    #[test]
    fn any_text_and_any_number_give_json_that_reads_back(
        text in any::<String>(), number in any::<f64>(), other in any::<f64>(),
    ) {
        let mut one = finding();
        one.region = text.clone();
        one.parameters[0].name = text.clone();
        one.parameters[0].estimate = number;
        one.parameters[0].ci95 = (number, other);
        one.probability = other;
        let mut whole = diagnosis(vec![one]);
        whole.settings = vec![(text.clone(), text.clone()), (text.clone(), String::new())];
        let written = write_diagnosis(&whole);
        let value: Value = serde_json::from_str(&written).unwrap();
        let finding = &value["findings"][0];
        prop_assert_eq!(finding["region"].as_str(), Some(text.as_str()));
        prop_assert_eq!(value["settings"][&text].as_str(), Some(text.as_str()));
        let probability = finding["probability"].as_f64().unwrap();
        prop_assert!((0.0..=1.0).contains(&probability));
        match finding["parameters"].get(&text) {
            // serde_json reads floats to within their last bits.
            Some(parameter) => {
                let read = parameter["estimate"].as_f64().unwrap();
                prop_assert!((read - number).abs() <= 1e-14 * number.abs(), "{read} {number}");
            }
            None => prop_assert!(!number.is_finite()),
        }
    }
}
