//! The scores of a level as one list, each beside its target: for the terminal, the page and the JSON.

use super::stats::{Tally, median};
use super::summary::{SIGNAL_TITLES, Summary};
use super::targets;
use super::truth::SEVERITIES;
use serde_json::{Value, json};

pub(crate) struct Measure {
    pub(crate) title: String,
    pub(crate) score: Score,
    pub(crate) target: Option<Target>,
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Score {
    Share(Tally),
    /// Value, how many stand behind it, unit.
    Number(Option<f64>, usize, &'static str),
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Target {
    AtLeast(f64),
    AtMost(f64),
    Between(f64, f64),
}

impl Target {
    pub(crate) fn met(self, score: Score) -> Option<bool> {
        let value = match score {
            Score::Share(tally) => tally.share()?,
            Score::Number(value, ..) => value?,
        };
        Some(match self {
            Target::AtLeast(bound) => value >= bound,
            Target::AtMost(bound) => value <= bound,
            Target::Between(low, high) => low <= value && value <= high,
        })
    }

    pub(crate) fn text(self, score: Score) -> String {
        let number = |v: f64| match score {
            Score::Share(_) => format!("{:.0} %", 100.0 * v),
            Score::Number(_, _, unit) => format!("{}{unit}", plain(v, unit)),
        };
        match self {
            Target::AtLeast(v) => format!("≥ {}", number(v)),
            Target::AtMost(v) => format!("≤ {}", number(v)),
            Target::Between(a, b) => format!("{} to {}", number(a), number(b)),
        }
    }
}

impl Score {
    /// The value alone.
    pub(crate) fn value(self) -> String {
        match self {
            Score::Share(tally) => tally
                .share()
                .map_or("–".into(), |s| format!("{:.0} %", 100.0 * s)),
            Score::Number(value, _, unit) => {
                value.map_or("–".into(), |v| format!("{}{unit}", plain(v, unit)))
            }
        }
    }

    /// What stands behind it: counts, and the 95 % interval of a share.
    pub(crate) fn basis(self) -> String {
        match self {
            Score::Share(tally) => match tally.interval() {
                Some((low, high)) => format!(
                    "{}/{}, {:.0}–{:.0} %",
                    tally.right,
                    tally.of,
                    100.0 * low,
                    100.0 * high
                ),
                None => "none".into(),
            },
            Score::Number(_, n, _) => format!("n = {n}"),
        }
    }

    pub(crate) fn json(self) -> Value {
        match self {
            Score::Share(tally) => share_json(tally),
            Score::Number(value, n, unit) => json!({"value": value, "n": n, "unit": unit.trim()}),
        }
    }
}

pub(crate) fn share_json(tally: Tally) -> Value {
    json!({"right": tally.right, "of": tally.of, "share": tally.share(), "wilson95": tally.interval()})
}

fn plain(value: f64, unit: &str) -> String {
    match unit {
        " MiB" => format!("{value:.0}"),
        " s" => format!("{value:.1}"),
        _ => format!("{value:.3}"),
    }
}

/// Every measure of a level, in the same order for each.
pub(crate) fn measures(s: &Summary) -> Vec<Measure> {
    let mut list = Vec::new();
    let mut put = |title: &str, score: Score, target: Option<Target>| {
        list.push(Measure {
            title: title.to_owned(),
            score,
            target,
        });
    };
    let share = Score::Share;
    let number = |values: &[f64], unit| Score::Number(median(values), values.len(), unit);
    put(
        "recordings answered",
        share(s.ran),
        Some(Target::AtLeast(1.0)),
    );
    for i in (0..SEVERITIES.len()).rev() {
        let title = format!("one effect, {}: named exactly", SEVERITIES[i]);
        let target = named_target(s.level, SEVERITIES[i]).map(Target::AtLeast);
        put(&title, share(s.by_severity[i].exact), target);
    }
    put(
        "one effect, any severity: named exactly",
        share(s.singles.exact),
        None,
    );
    put(
        "one effect, any severity: named at all",
        share(s.singles.hit),
        None,
    );
    put(
        "one effect, any severity: within the alternatives",
        share(s.singles.within),
        None,
    );
    put(
        "one effect, any severity: a wrong name claimed",
        share(s.singles.wrong),
        None,
    );
    put(
        "effects named within twice the limit of their recordings",
        share(s.within_limit),
        Some(Target::AtLeast(1.0)),
    );
    put(
        "size of even odds over that limit, median of effects",
        number(&s.factors, " times"),
        None,
    );
    put(
        "clean: false alarms",
        share(s.false_alarms),
        Some(Target::AtMost(targets::FALSE_ALARMS)),
    );
    put(
        "outside the catalogue: called unknown",
        share(s.foreign),
        Some(Target::AtLeast(targets::FOREIGN_UNKNOWN)),
    );
    put("pairs: named exactly", share(s.pairs.exact), None);
    put(
        "pairs: within the alternatives",
        share(s.pairs.within),
        None,
    );
    put(
        "pairs in one relation: named exactly",
        share(s.pairs_meeting.exact),
        Some(Target::AtLeast(targets::PAIRS_EXACT)),
    );
    put(
        "pairs in one relation: within the alternatives",
        share(s.pairs_meeting.within),
        Some(Target::AtLeast(targets::PAIRS_WITHIN)),
    );
    put("relation right, where named", share(s.relation), None);
    put(
        "interval, intersection over union, median",
        number(&s.overlap, ""),
        Some(Target::AtLeast(targets::OVERLAP)),
    );
    put(
        "parameter, relative error, median",
        number(&s.parameter.errors, ""),
        Some(Target::AtMost(targets::PARAMETER_ERROR)),
    );
    put(
        "parameter, ci95 holds the truth",
        share(s.parameter.covered),
        Some(Target::Between(targets::COVERAGE.0, targets::COVERAGE.1)),
    );
    put("transmitter right, where named", share(s.sensor), None);
    put(
        "confidently wrong (probability 0.9 or more)",
        share(s.confidently_wrong),
        Some(Target::AtMost(targets::CONFIDENTLY_WRONG)),
    );
    let judged = s.forecasts.len() + s.passed_over;
    put("Brier score", Score::Number(s.brier, judged, ""), None);
    put("verdict right", share(s.verdict), None);
    for (title, ratios) in SIGNAL_TITLES.iter().zip(&s.gains) {
        let title = format!("held-out {title}, after / before, median");
        put(&title, number(ratios, ""), None);
    }
    put(
        "held-out gain over that of a fit that knows the truth, median",
        number(&s.truth_shares, ""),
        Some(Target::AtLeast(targets::TRUTH_SHARE)),
    );
    put(
        "held-out signals made worse, effect concealed",
        share(s.worse),
        None,
    );
    put(
        "held-out signals made worse, clean",
        share(s.clean_worse),
        None,
    );
    put("claimed but not modelled", share(s.unmodelled), None);
    put(
        "rules of held-out windows kept",
        share(s.rules),
        Some(Target::AtLeast(1.0)),
    );
    put("wall time, median", number(&s.walls_s, " s"), None);
    let most = |values: &[f64]| values.iter().copied().reduce(f64::max);
    let six: Vec<f64> = s
        .by_hours
        .range(..=6)
        .flat_map(|(_, w)| w)
        .copied()
        .collect();
    put(
        "wall time, longest of recordings up to 6 h",
        Score::Number(most(&six), six.len(), " s"),
        Some(Target::AtMost(targets::SECONDS_SIX_HOURS)),
    );
    put(
        "peak memory, largest",
        Score::Number(most(&s.peaks_mib), s.peaks_mib.len(), " MiB"),
        None,
    );
    list
}

/// Level one is asked for what stands well above its noise.
pub(crate) fn named_target(level: u8, severity: &str) -> Option<f64> {
    if level == 1 {
        let above = ["strong", "moderate", "subtle"].contains(&severity);
        return above.then_some(targets::NAMED_LEVEL_ONE);
    }
    let mut of = targets::NAMED_LEVEL_TWO.iter();
    of.find(|(s, _)| *s == severity).map(|(_, t)| *t)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn targets_are_met_at_their_bounds_and_undecided_without_data() {
        let share = |right, of| Score::Share(Tally { right, of });
        assert_eq!(Target::AtLeast(0.9).met(share(9, 10)), Some(true));
        assert_eq!(Target::AtMost(0.02).met(share(1, 20)), Some(false));
        assert_eq!(Target::Between(0.9, 0.98).met(share(20, 20)), Some(false));
        assert_eq!(Target::AtLeast(0.9).met(share(0, 0)), None);
        assert_eq!(Target::AtMost(5.0).met(Score::Number(None, 0, " s")), None);
    }

    #[test]
    fn nothing_counted_is_a_dash_and_never_a_number() {
        let none = Summary::default();
        for measure in measures(&none) {
            assert_eq!(measure.score.value(), "–", "{}", measure.title);
        }
    }

    #[test]
    fn both_levels_list_the_same_measures() {
        let of = |level| {
            let summary = Summary {
                level,
                ..Summary::default()
            };
            measures(&summary)
                .into_iter()
                .map(|m| m.title)
                .collect::<Vec<_>>()
        };
        assert_eq!(of(1), of(2));
        assert_eq!(named_target(1, "subtle"), Some(0.99));
        assert_eq!(named_target(1, "trace"), None);
        assert_eq!(named_target(2, "faint"), Some(0.60));
    }
}
