//! What `dgd diagnose` said: `diagnosis.json`, held against the form it must have.

use anyhow::{Context, Result};
use serde_json::Value;

/// The effects that can be named, `unknown` last.
pub(crate) const EFFECTS: [&str; 25] = [
    "return_flow_delay",
    "return_flow_gain",
    "inflow_gain",
    "outlet_pressure_bias",
    "outlet_pressure_bias_step",
    "mud_density_change",
    "cuttings_loading",
    "yield_stress",
    "gel_strength",
    "line_drainage",
    "pump_wear",
    "gas_in_pump",
    "pump_speed_lag",
    "influx",
    "lost_circulation",
    "u_tube",
    "booster_line_storage",
    "annulus_area",
    "pipe_displacement",
    "heave",
    "viscosity_drift",
    "line_restriction",
    "line_leak",
    "line_gas_storage",
    "unknown",
];
const VERDICTS: [&str; 4] = ["consistent", "explained", "partly_explained", "unexplained"];
const RELATIONS: [&str; 5] = [
    "return_line_friction",
    "pump_head",
    "riser_mass_balance",
    "momentum",
    "instrument",
];
/// The signals that are compared before and after.
pub(crate) const SIGNALS: [&str; 4] = [
    "return_flow_m3_s",
    "riser_level_m",
    "pump_outlet_pressure_pa",
    "pump_head_m",
];

#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Answer {
    pub(crate) verdict: String,
    pub(crate) findings: Vec<Finding>,
    /// What was looked for, with what each effect showed before anything was named.
    pub(crate) tested: Vec<Tested>,
}

/// An effect of the catalogue that was looked for; of what is not told there is nothing.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Tested {
    pub(crate) effect: String,
    /// Whether the recording can show it.
    pub(crate) testable: bool,
    /// Whether it may be named at all, whatever its evidence: its size, bounds and place are plausible. Taken for yes where it
    /// is not told.
    pub(crate) admissible: bool,
    /// Name of its strength.
    pub(crate) strength: String,
    /// Natural logarithm of its Bayes factor.
    pub(crate) evidence: Option<f64>,
    pub(crate) hurdle: Option<f64>,
    /// Of the strength, SI.
    pub(crate) standard_error: Option<f64>,
}

#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Finding {
    pub(crate) effect: String,
    pub(crate) probability: f64,
    pub(crate) alternatives: Vec<(String, f64)>,
    pub(crate) relation: String,
    pub(crate) intervals_s: Vec<(f64, f64)>,
    pub(crate) parameters: Vec<Estimate>,
    pub(crate) evidence: Option<f64>,
    pub(crate) hurdle: Option<f64>,
}

#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Estimate {
    pub(crate) name: String,
    pub(crate) value: f64,
    pub(crate) ci95: Option<(f64, f64)>,
}

impl Answer {
    /// The answer, and each breach of the form it must have.
    ///
    /// # Errors
    /// When it is no JSON or has no findings to read.
    pub(crate) fn read(bytes: &[u8]) -> Result<(Answer, Vec<String>)> {
        let value: Value = serde_json::from_slice(bytes).context("diagnosis.json: no JSON")?;
        let list = value["findings"]
            .as_array()
            .context("diagnosis.json: `findings` is no list")?;
        let mut wrong = Vec::new();
        let schema = value["schema"].as_str().unwrap_or("");
        if schema != "dgd.diagnosis/1" {
            wrong.push(format!(
                "`schema` is `{schema}`, expected `dgd.diagnosis/1`"
            ));
        }
        let verdict = value["verdict"].as_str().unwrap_or("").to_owned();
        if !VERDICTS.contains(&verdict.as_str()) {
            wrong.push(format!(
                "`verdict` is `{verdict}`, expected one of {VERDICTS:?}"
            ));
        }
        if verdict == "consistent" && !list.is_empty() {
            wrong.push(format!("`consistent` with {} findings", list.len()));
        }
        if ["explained", "partly_explained"].contains(&verdict.as_str()) && list.is_empty() {
            wrong.push(format!("`{verdict}` without findings"));
        }
        let findings = list
            .iter()
            .enumerate()
            .map(|(i, f)| finding(f, &mut |what| wrong.push(format!("finding {i}: {what}"))))
            .collect();
        // No part of the form, only read where it is there.
        let tested = value["tested"].as_array().into_iter().flatten();
        let answer = Answer {
            verdict,
            findings,
            tested: tested.map(tested_of).collect(),
        };
        Ok((answer, wrong))
    }

    /// The findings that count as claimed.
    pub(crate) fn claimed(&self) -> impl Iterator<Item = &Finding> {
        let claimed = |f: &&Finding| f.probability >= super::targets::CLAIMED;
        self.findings.iter().filter(claimed)
    }
}

fn tested_of(value: &Value) -> Tested {
    let text = |key: &str| value[key].as_str().unwrap_or("").to_owned();
    Tested {
        effect: text("effect"),
        testable: value["outcome"] != "not_testable",
        admissible: value["admissible"].as_bool().unwrap_or(true),
        strength: text("strength"),
        evidence: value["evidence_ln"].as_f64(),
        hurdle: value["hurdle_ln"].as_f64(),
        standard_error: value["standard_error"].as_f64(),
    }
}

fn finding(value: &Value, wrong: &mut dyn FnMut(String)) -> Finding {
    let effect = known(&value["effect"], &EFFECTS, "effect", wrong);
    let relation = known(&value["relation"], &RELATIONS, "relation", wrong);
    let probability = chance(&value["probability"], "probability", wrong);
    let alternatives = listed(&value["alternatives"], "alternatives", wrong)
        .iter()
        .map(|a| {
            (
                known(&a["effect"], &EFFECTS, "alternatives.effect", wrong),
                chance(&a["probability"], "alternatives.probability", wrong),
            )
        })
        .collect();
    let intervals_s = listed(&value["intervals_s"], "intervals_s", wrong)
        .iter()
        .filter_map(|i| ordered(i, "intervals_s", wrong))
        .collect();
    if !value["region"].is_string() {
        wrong("`region` is no text".into());
    }
    let mut finding = Finding {
        effect,
        probability,
        alternatives,
        relation,
        intervals_s,
        parameters: Vec::new(),
        evidence: value["evidence_ln"].as_f64(),
        hurdle: value["hurdle_ln"].as_f64(),
    };
    let Some(parameters) = value["parameters"].as_object() else {
        wrong("`parameters` is no table".into());
        return finding;
    };
    finding.parameters = parameters
        .iter()
        .filter_map(|(name, p)| {
            let ci95 = ordered(&p["ci95"], &format!("parameters.{name}.ci95"), wrong);
            let Some(value) = p["estimate"].as_f64() else {
                wrong(format!("`parameters.{name}.estimate` is no number"));
                return None;
            };
            Some(Estimate {
                name: name.clone(),
                value,
                ci95,
            })
        })
        .collect();
    held_out(&value["held_out"], wrong);
    finding
}

/// What shows the gain; the numbers themselves are recomputed from simulation.csv.
fn held_out(value: &Value, wrong: &mut dyn FnMut(String)) {
    if !value.is_object() {
        wrong(format!("`held_out` is `{value}`, expected a table"));
        return;
    }
    known(&value["signal"], &SIGNALS, "held_out.signal", wrong);
    for key in ["rmse_before", "rmse_after"] {
        if !value[key].is_number() {
            wrong(format!("`held_out.{key}` is no number"));
        }
    }
    let interval = &value["improvement_ci95"];
    ordered(interval, "held_out.improvement_ci95", wrong);
}

fn known(value: &Value, names: &[&str], key: &str, wrong: &mut dyn FnMut(String)) -> String {
    let text = value.as_str().unwrap_or("");
    if !names.contains(&text) {
        wrong(format!("`{key}` is `{text}`, which the form does not know"));
    }
    text.to_owned()
}

fn chance(value: &Value, key: &str, wrong: &mut dyn FnMut(String)) -> f64 {
    match value.as_f64() {
        Some(p) if (0.0..=1.0).contains(&p) => p,
        _ => {
            wrong(format!("`{key}` is `{value}`, expected 0 to 1"));
            0.0
        }
    }
}

fn listed<'a>(value: &'a Value, key: &str, wrong: &mut dyn FnMut(String)) -> &'a [Value] {
    value.as_array().map(Vec::as_slice).unwrap_or_else(|| {
        wrong(format!("`{key}` is no list"));
        &[]
    })
}

fn ordered(value: &Value, key: &str, wrong: &mut dyn FnMut(String)) -> Option<(f64, f64)> {
    let pair = value.as_array().filter(|a| a.len() == 2);
    let pair = pair.and_then(|a| Some((a[0].as_f64()?, a[1].as_f64()?)));
    if pair.is_none_or(|(a, b)| a > b) {
        wrong(format!(
            "`{key}` is `{value}`, expected two numbers in order"
        ));
        return None;
    }
    pair
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may")]
    use super::*;
    use serde_json::json;

    fn good() -> Value {
        json!({
            "schema": "dgd.diagnosis/1", "verdict": "explained",
            "findings": [{
                "effect": "influx", "probability": 0.97,
                "alternatives": [{"effect": "u_tube", "probability": 0.02}],
                "relation": "riser_mass_balance", "intervals_s": [[10230, 14012]], "region": "all",
                "parameters": {"rate_m3_s": {"estimate": 0.0021, "ci95": [0.0019, 0.0023]}},
                "held_out": {"signal": "riser_level_m", "rmse_before": 1.9, "rmse_after": 0.12, "improvement_ci95": [0.9, 0.95]}
            }]
        })
    }

    fn breaches(value: &Value) -> Vec<String> {
        Answer::read(value.to_string().as_bytes()).unwrap().1
    }

    #[test]
    fn the_form_of_the_contract_is_read_without_a_breach() {
        let (answer, wrong) = Answer::read(good().to_string().as_bytes()).unwrap();
        assert_eq!(wrong, [""; 0]);
        let f = &answer.findings[0];
        assert_eq!(f.intervals_s, [(10230.0, 14012.0)]);
        assert_eq!(f.parameters[0].ci95, Some((0.0019, 0.0023)));
        assert_eq!(f.alternatives, [("u_tube".to_owned(), 0.02)]);
    }

    #[test]
    fn what_was_tested_is_read_where_it_is_told_and_never_asked_for() {
        let mut value = good();
        assert!(breaches(&value).is_empty());
        value["tested"] = json!([
            {"effect": "influx", "outcome": "not_seen", "evidence_ln": 3.5, "hurdle_ln": 8, "strength": "rate_m3_s", "standard_error": 2e-4},
            {"effect": "gel_strength", "outcome": "not_testable", "standard_error": null, "admissible": false},
        ]);
        let tested = Answer::read(value.to_string().as_bytes()).unwrap().0.tested;
        assert_eq!(tested[0].evidence, Some(3.5));
        assert_eq!(tested[0].standard_error, Some(2e-4));
        assert!(tested[0].testable && !tested[1].testable);
        assert_eq!(tested[1].standard_error, None);
        assert!(tested[0].admissible && !tested[1].admissible);
    }

    #[test]
    fn each_breach_of_the_form_is_named() {
        type Spoil = (&'static str, Value, &'static str);
        let spoilt: [Spoil; 10] = [
            ("/schema", json!("dgd.diagnosis/2"), "schema"),
            ("/verdict", json!("consistent"), "consistent"),
            ("/verdict", json!("fine"), "verdict"),
            ("/findings/0/effect", json!("gremlins"), "gremlins"),
            ("/findings/0/probability", json!(1.2), "0 to 1"),
            ("/findings/0/relation", json!("riser"), "relation"),
            ("/findings/0/intervals_s/0", json!([5, 4]), "in order"),
            (
                "/findings/0/parameters/rate_m3_s/ci95",
                json!([1, null]),
                "ci95",
            ),
            ("/findings/0/held_out", json!(null), "held_out"),
            ("/findings/0/held_out/signal", json!("level"), "signal"),
        ];
        for (at, what, said) in spoilt {
            let mut value = good();
            *value.pointer_mut(at).unwrap() = what;
            let wrong = breaches(&value);
            assert_eq!(wrong.len(), 1, "{at}: {wrong:?}");
            assert!(wrong[0].contains(said), "{at}: {wrong:?}");
        }
        assert_eq!(
            breaches(&json!({"schema": "dgd.diagnosis/1", "verdict": "explained", "findings": []}))
                .len(),
            1
        );
        assert!(Answer::read(b"{}").is_err());
    }
}
