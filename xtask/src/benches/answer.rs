//! What `dgd diagnose --system` wrote: verdict and findings, and the held-out errors recomputed from its table.

use anyhow::{Context, Result, bail};
use serde_json::Value;
use std::collections::BTreeMap;

/// An answer.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Answer {
    pub(crate) verdict: String,
    pub(crate) findings: Vec<Finding>,
    /// Told as also possible.
    pub(crate) possible: Vec<Finding>,
}

/// A finding; `unknown` is one too.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Finding {
    pub(crate) component: String,
    pub(crate) effect: String,
    /// As `component.effect`.
    pub(crate) alternatives: Vec<String>,
    /// Where the answer states one.
    pub(crate) probability: Option<f64>,
    /// Path of each parameter and its 95 % interval.
    pub(crate) intervals: Vec<(String, (f64, f64))>,
}

impl Answer {
    pub(crate) fn read(bytes: &[u8]) -> Result<Answer> {
        let json: Value = serde_json::from_slice(bytes).context("diagnosis.json is no JSON")?;
        let verdict = json["verdict"]
            .as_str()
            .context("diagnosis.json has no `verdict`")?;
        let list = json["findings"].as_array();
        let list = list.context("diagnosis.json has no `findings`")?;
        let findings = list.iter().map(finding).collect::<Result<Vec<_>>>()?;
        let doubtful = json["also_possible"].as_array().into_iter().flatten();
        let possible = doubtful.map(finding).collect::<Result<Vec<_>>>()?;
        if (verdict == "consistent") != findings.is_empty() {
            bail!("verdict `{verdict}` with {} findings", findings.len());
        }
        Ok(Answer {
            verdict: verdict.to_owned(),
            findings,
            possible,
        })
    }
}

fn finding(value: &Value) -> Result<Finding> {
    let effect = value["effect"]
        .as_str()
        .context("a finding has no `effect`")?;
    let list = |key: &str| value[key].as_array().into_iter().flatten();
    Ok(Finding {
        component: value["component"].as_str().unwrap_or_default().to_owned(),
        effect: effect.to_owned(),
        alternatives: list("alternatives").filter_map(name).collect(),
        probability: value["probability"].as_f64(),
        intervals: list("parameters").filter_map(interval).collect(),
    })
}

/// Path and 95 % interval of a parameter.
fn interval(value: &Value) -> Option<(String, (f64, f64))> {
    let ends = (value["ci95"][0].as_f64()?, value["ci95"][1].as_f64()?);
    Some((value["path"].as_str()?.to_owned(), ends))
}

/// An alternative: text, or an object with component and effect.
fn name(value: &Value) -> Option<String> {
    if let Some(text) = value.as_str() {
        return Some(text.to_owned());
    }
    let effect = value["effect"].as_str()?;
    Some(match value["component"].as_str() {
        Some(component) => format!("{component}.{effect}"),
        None => effect.to_owned(),
    })
}

/// Held-out root mean squares of an instrument.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Off {
    pub(crate) before: f64,
    pub(crate) after: f64,
}

/// Recomputes the held-out errors from `simulation.csv`, by instrument.
pub(crate) fn held_out(table: &str) -> Result<BTreeMap<String, Off>> {
    let mut lines = table.lines();
    let head: Vec<&str> = lines
        .next()
        .context("simulation.csv is empty")?
        .split(',')
        .collect();
    let at = |name: &str| head.iter().position(|h| *h == name);
    let flag = at("held_out").context("simulation.csv has no `held_out`")?;
    let mut columns = Vec::new();
    for (i, title) in head.iter().enumerate() {
        if let Some(name) = title.strip_suffix("_measured") {
            let find = |part: &str| {
                let title = format!("{name}_{part}");
                at(&title).with_context(|| format!("simulation.csv has no `{title}`"))
            };
            columns.push((name.to_owned(), i, find("before")?, find("after")?));
        }
    }
    let mut sums = vec![(0.0, 0.0, 0_usize); columns.len()];
    for line in lines {
        let cells: Vec<&str> = line.split(',').collect();
        let number = |i: usize| cells.get(i).and_then(|c| c.parse::<f64>().ok());
        if number(flag) != Some(1.0) {
            continue;
        }
        for ((_, measured, before, after), sum) in columns.iter().zip(&mut sums) {
            if let (Some(m), Some(b), Some(a)) =
                (number(*measured), number(*before), number(*after))
            {
                sum.0 += (m - b) * (m - b);
                sum.1 += (m - a) * (m - a);
                sum.2 += 1;
            }
        }
    }
    let rms = |sum: f64, n: usize| (sum / n as f64).sqrt();
    columns
        .into_iter()
        .zip(sums)
        .map(|((name, ..), (before, after, n))| {
            if n == 0 {
                bail!("simulation.csv holds no held-out sample of {name}");
            }
            let off = Off {
                before: rms(before, n),
                after: rms(after, n),
            };
            Ok((name, off))
        })
        .collect()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may")]
    use super::*;

    #[test]
    fn a_verdict_and_its_findings_must_agree() {
        let read = |text: &str| Answer::read(text.as_bytes());
        let clean = read(r#"{"verdict": "consistent", "findings": []}"#).unwrap();
        assert!(clean.findings.is_empty());
        assert!(read(r#"{"verdict": "explained", "findings": []}"#).is_err());
        assert!(read(r#"{"verdict": "consistent"}"#).is_err());
        let one = read(
            r#"{"verdict": "explained", "findings": [{"component": "shaft", "effect": "taper",
                "alternatives": ["a.b", {"component": "c", "effect": "d"}], "probability": 0.7}]}"#,
        );
        let one = one.unwrap();
        assert_eq!(one.findings[0].alternatives, ["a.b", "c.d"]);
        assert_eq!(one.findings[0].probability, Some(0.7));
        let found = read(
            r#"{"verdict": "explained", "findings": [{"component": "shaft", "effect": "taper",
                "parameters": [{"path": "shaft.taper.slope", "ci95": [-1.0, 2.0]}, {"path": "no.interval"}]}]}"#,
        );
        let expected = [("shaft.taper.slope".to_owned(), (-1.0, 2.0))];
        assert_eq!(found.unwrap().findings[0].intervals, expected);
        let doubtful = read(
            r#"{"verdict": "explained", "findings": [{"effect": "taper"}], "also_possible": [{"effect": "vortex", "probability": 0.02}]}"#,
        );
        assert_eq!(doubtful.unwrap().possible[0].probability, Some(0.02));
    }

    #[test]
    fn only_held_out_rows_with_a_reading_count() {
        let table = "t,held_out,x_measured,x_before,x_after\ns,,m,m,m\n0,0,9,0,0\n1,1,1,4,1\n2,1,,7,7\n3,1,2,2,5\n";
        let off = held_out(table).unwrap();
        assert!((off["x"].before - (9.0_f64 / 2.0).sqrt()).abs() < 1e-12);
        assert!((off["x"].after - (9.0_f64 / 2.0).sqrt()).abs() < 1e-12);
        assert!(held_out("t,held_out,x_measured,x_before\n").is_err());
        assert!(held_out("t,held_out,x_measured,x_before,x_after\n0,0,1,1,1\n").is_err());
    }
}
