//! What was concealed: `cNNN.truth.json`, opened only after the last run.

use anyhow::{Context, Result};
use serde_json::Value;

/// From the noise up.
pub(crate) const SEVERITIES: [&str; 5] = ["trace", "faint", "subtle", "moderate", "strong"];
/// Times the moderate size.
pub(crate) const SIZES: [f64; 5] = [0.08, 0.2, 0.5, 1.0, 2.0];

#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Truth {
    pub(crate) hours: f64,
    pub(crate) well: String,
    pub(crate) effects: Vec<Concealed>,
}

#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Concealed {
    pub(crate) effect: String,
    /// What a foreign effect really is.
    pub(crate) kind: Option<String>,
    pub(crate) severity: String,
    /// Scored.
    pub(crate) parameters: Vec<(String, f64)>,
    /// More about it, not scored.
    pub(crate) extra: Vec<(String, f64)>,
    pub(crate) interval_s: Option<(f64, f64)>,
    /// When it comes again.
    pub(crate) again_s: Option<(f64, f64)>,
    pub(crate) relations: Vec<String>,
}

impl Concealed {
    /// How many times it comes.
    pub(crate) fn times(&self) -> usize {
        1 + usize::from(self.again_s.is_some())
    }
}

/// What sort of case it is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Sort {
    Clean,
    Single,
    Foreign,
    Pair,
}

impl Truth {
    pub(crate) fn read(bytes: &[u8]) -> Result<Truth> {
        let value: Value = serde_json::from_slice(bytes).context("no JSON")?;
        let effects = value["effects"]
            .as_array()
            .context("`effects` is missing")?;
        Ok(Truth {
            hours: value["hours"].as_f64().context("`hours` is missing")?,
            well: value["well"].as_str().unwrap_or("").to_owned(),
            effects: effects.iter().map(concealed).collect::<Result<_>>()?,
        })
    }

    pub(crate) fn names(&self) -> impl Iterator<Item = &str> {
        self.effects.iter().map(|e| e.effect.as_str())
    }

    pub(crate) fn sort(&self) -> Sort {
        match self.effects.as_slice() {
            [] => Sort::Clean,
            [one] if one.effect == "unknown" => Sort::Foreign,
            [_] => Sort::Single,
            _ => Sort::Pair,
        }
    }

    /// Whether two effects meet in one relation.
    pub(crate) fn meets(&self) -> bool {
        let [a, b, ..] = self.effects.as_slice() else {
            return false;
        };
        a.relations.iter().any(|r| b.relations.contains(r))
    }
}

fn concealed(value: &Value) -> Result<Concealed> {
    let text = |key: &str| value[key].as_str().map(str::to_owned);
    let numbers = |key: &str| -> Vec<(String, f64)> {
        let all = value[key].as_object().into_iter().flatten();
        all.filter_map(|(name, v)| Some((name.clone(), v.as_f64()?)))
            .collect()
    };
    let relations = value["relation"].as_array().into_iter().flatten();
    let interval = |key: &str| {
        let ends = value[key].as_array()?;
        Some((ends.first()?.as_f64()?, ends.get(1)?.as_f64()?))
    };
    Ok(Concealed {
        effect: text("effect").context("an effect without a name")?,
        kind: text("kind"),
        severity: text("severity").context("an effect without a severity")?,
        parameters: numbers("params"),
        extra: numbers("extra"),
        interval_s: interval("interval"),
        again_s: interval("again"),
        relations: relations
            .filter_map(|r| r.as_str().map(str::to_owned))
            .collect(),
    })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may")]
    use super::*;

    #[test]
    fn a_pair_is_read_with_its_parameters_and_interval() {
        let truth = Truth::read(
            br#"{"id":"c004","hours":6,"well":"gom","effects":[
              {"effect":"line_drainage","severity":"moderate","params":{"rate_m_s":0.1},"interval":null,"relation":["return_line_friction"]},
              {"effect":"line_restriction","severity":"moderate","params":{"K":15.0},"interval":[11004.0,21600.0],"relation":["return_line_friction"]}],
              "stuck":[["w",1,2]]}"#,
        )
        .unwrap();
        assert_eq!(truth.sort(), Sort::Pair);
        assert!(truth.meets());
        assert_eq!(truth.effects[1].interval_s, Some((11004.0, 21600.0)));
        assert_eq!(truth.effects[0].parameters, [("rate_m_s".to_owned(), 0.1)]);
        assert_eq!(truth.effects[0].interval_s, None);
        assert_eq!(truth.effects[1].again_s, None);
    }

    #[test]
    fn what_comes_again_is_one_effect_at_two_times() {
        let truth = Truth::read(
            br#"{"hours":6,"effects":[{"effect":"influx","severity":"strong","interval":[100.0,200.0],"again":[400.0,500.0]}]}"#,
        )
        .unwrap();
        assert_eq!(truth.sort(), Sort::Single);
        assert_eq!(truth.effects[0].again_s, Some((400.0, 500.0)));
        assert_eq!(truth.effects[0].times(), 2);
    }

    #[test]
    fn foreign_and_clean_cases_are_told_apart_from_singles() {
        let of = |effects: &str| {
            let text = format!(r#"{{"hours":4,"well":"deep","effects":[{effects}]}}"#);
            Truth::read(text.as_bytes()).unwrap()
        };
        assert_eq!(of("").sort(), Sort::Clean);
        let foreign = of(r#"{"effect":"unknown","kind":"sticky_choke","severity":"strong"}"#);
        assert_eq!(foreign.sort(), Sort::Foreign);
        assert_eq!(foreign.effects[0].kind.as_deref(), Some("sticky_choke"));
        assert_eq!(
            of(r#"{"effect":"heave","severity":"trace"}"#).sort(),
            Sort::Single
        );
        assert!(Truth::read(br#"{"hours":4}"#).is_err());
    }
}
