//! How small an effect is still named, held against what any test could do on that recording.

use super::stats::{Even, Tally, even_odds, isotonic, median, normal_quantile};
use super::strength::parameter_of;
use super::summary::Row;
use super::targets::{CATALOGUE, FALSE_ALARMS, LIMIT_FACTOR};
use super::truth::Sort;
use serde_json::{Value, json};
use std::collections::BTreeMap;

/// Full width of a 95 % interval in standard errors.
const CI95_WIDTH: f64 = 3.92;

/// Where a standard error comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Source {
    /// The Cramér-Rao bound of the strength beside the base model, as the blind run tells it.
    Bound,
    /// The 95 % interval of the fit that knows the truth: of what is no amplitude.
    Interval,
}

/// A single effect of the catalogue with its size in standard errors.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Seen {
    pub(crate) level: u8,
    pub(crate) id: String,
    pub(crate) effect: String,
    pub(crate) group: &'static str,
    /// SI.
    pub(crate) strength: f64,
    /// Of the strength, on this recording.
    pub(crate) error: f64,
    pub(crate) source: Source,
    pub(crate) named: bool,
}

impl Seen {
    /// Its strength in standard errors.
    pub(crate) fn sigmas(&self) -> f64 {
        self.strength / self.error
    }
}

/// Standard errors at which a test of known form has even odds, if over the whole catalogue it may raise a false alarm on
/// one clean recording in fifty (Neyman and Pearson 1933): the normal quantile of 1 - 0.02/24.
pub(crate) fn limit_sigmas() -> f64 {
    normal_quantile(1.0 - FALSE_ALARMS / CATALOGUE)
}

/// Single effects of the catalogue whose strength and standard error are known.
pub(crate) fn seen(rows: &[Row]) -> Vec<Seen> {
    let single = |r: &&Row| r.sort() == Sort::Single && r.answer.is_some();
    rows.iter().filter(single).filter_map(of).collect()
}

/// Single effects of the catalogue that [`seen`] leaves out: the recording cannot show them, or nothing gives an error.
pub(crate) fn unmeasured(rows: &[Row]) -> usize {
    let single = rows.iter().filter(|r| r.sort() == Sort::Single);
    single.count() - seen(rows).len()
}

fn of(row: &Row) -> Option<Seen> {
    let concealed = row.truth.effects.first()?;
    let tested = &row.answer.as_ref()?.tested;
    let told = tested.iter().find(|t| t.effect == concealed.effect);
    if told.is_some_and(|t| !t.testable) {
        return None;
    }
    let bound = told
        .and_then(|t| t.standard_error)
        .map(|e| (e, Source::Bound));
    let interval = || {
        let answer = row.informed.as_ref()?.answer.as_ref()?;
        let name = parameter_of(&concealed.effect).or(told.map(|t| t.strength.as_str()))?;
        let mut findings = answer.findings.iter();
        let finding = findings.find(|f| f.effect == concealed.effect)?;
        let (low, high) = finding.parameters.iter().find(|p| p.name == name)?.ci95?;
        Some(((high - low) / CI95_WIDTH, Source::Interval))
    };
    let (error, source) = bound.or_else(interval)?;
    let strength = row.strength?;
    (error > 0.0 && error.is_finite()).then(|| Seen {
        level: row.level,
        id: row.id.clone(),
        effect: concealed.effect.clone(),
        group: group(&concealed.relations),
        strength,
        error,
        source,
        named: row.marks.hit.iter().all(|h| *h),
    })
}

/// Effects are drawn together by where they show.
pub(crate) const GROUPS: [&str; 4] = [
    "return line friction",
    "pump head",
    "riser mass balance",
    "more than one relation",
];

fn group(relations: &[String]) -> &'static str {
    match relations {
        [one] => match one.as_str() {
            "return_line_friction" => GROUPS[0],
            "pump_head" => GROUPS[1],
            _ => GROUPS[2],
        },
        _ => GROUPS[3],
    }
}

/// Cases by doubling of their size: the middle in standard errors and how many were named.
pub(crate) fn bins<'a>(seen: impl IntoIterator<Item = &'a Seen>) -> Vec<(f64, Tally)> {
    let mut bins: BTreeMap<i64, (f64, Tally)> = BTreeMap::new();
    for one in seen {
        let doublings = one.sigmas().log2();
        #[expect(
            clippy::cast_possible_truncation,
            reason = "the cast saturates, and doublings are few"
        )]
        let bin = bins.entry(doublings.floor() as i64).or_default();
        bin.0 += doublings;
        bin.1.add(one.named);
    }
    bins.into_values()
        .map(|(sum, tally)| ((sum / tally.of as f64).exp2(), tally))
        .collect()
}

/// One effect, or a group of them, at one level.
pub(crate) struct Reach<'a> {
    pub(crate) name: &'a str,
    pub(crate) level: u8,
    pub(crate) named: Tally,
    pub(crate) smallest_named: Option<&'a Seen>,
    pub(crate) largest_missed: Option<&'a Seen>,
    /// Median over its recordings of the strength that a test of known form names with even odds, SI.
    pub(crate) limit: f64,
    /// Where the rising curve passes even odds, in standard errors.
    pub(crate) even: Even,
}

impl Reach<'_> {
    /// The size of even odds over the limit.
    pub(crate) fn factor(&self) -> f64 {
        let (Even::At(x) | Even::Below(x) | Even::Above(x)) = self.even;
        x / limit_sigmas()
    }

    /// Whether it is named within twice the limit; `None` where no case lies near enough to tell.
    pub(crate) fn within(&self) -> Option<bool> {
        let near = self.factor() <= LIMIT_FACTOR;
        match self.even {
            Even::At(_) => Some(near),
            Even::Below(_) => near.then_some(true),
            Even::Above(_) => (!near).then_some(false),
        }
    }

    /// The factor with what is known of it.
    pub(crate) fn factor_text(&self) -> String {
        self.bounded(self.factor())
    }

    /// A number with the sign of what is known of the even odds.
    pub(crate) fn bounded(&self, value: f64) -> String {
        let sign = match self.even {
            Even::At(_) => "",
            Even::Below(_) => "≤ ",
            Even::Above(_) => "≥ ",
        };
        format!("{sign}{value:.2}")
    }
}

/// Effects in order, each level on its own.
pub(crate) fn by_effect(seen: &[Seen]) -> Vec<Reach<'_>> {
    by(seen, |s| s.effect.as_str())
}

/// Groups of effects, and all of them, each level on its own; a group's limit in the effects' own units means nothing.
pub(crate) fn by_group(seen: &[Seen]) -> Vec<Reach<'_>> {
    let mut list = by(seen, |s| s.group);
    list.extend(by(seen, |_| "all"));
    list
}

fn by<'a>(seen: &'a [Seen], name: fn(&Seen) -> &str) -> Vec<Reach<'a>> {
    let mut groups: BTreeMap<(&str, u8), Vec<&Seen>> = BTreeMap::new();
    for one in seen {
        let key = (name(one), one.level);
        groups.entry(key).or_default().push(one);
    }
    let by_size = |a: &&&Seen, b: &&&Seen| a.sigmas().total_cmp(&b.sigmas());
    groups
        .into_iter()
        .filter_map(|((name, level), all)| {
            let points: Vec<(f64, bool)> = all.iter().map(|s| (s.sigmas(), s.named)).collect();
            let limits: Vec<f64> = all.iter().map(|s| limit_sigmas() * s.error).collect();
            let named = || all.iter().filter(|s| s.named);
            Some(Reach {
                name,
                level,
                named: Tally {
                    right: named().count(),
                    of: all.len(),
                },
                smallest_named: named().min_by(by_size).copied(),
                largest_missed: all.iter().filter(|s| !s.named).max_by(by_size).copied(),
                limit: median(&limits)?,
                even: even_odds(&isotonic(&points))?,
            })
        })
        .collect()
}

/// For `proof.json`.
pub(crate) fn json_of(rows: &[Row]) -> Value {
    let seen = seen(rows);
    let case = |s: &Seen| {
        json!({"level": s.level, "id": s.id, "effect": s.effect, "strength": s.strength, "standard_error": s.error,
               "sigmas": s.sigmas(), "named": s.named,
               "error_from": match s.source { Source::Bound => "cramer_rao", Source::Interval => "ci95" }})
    };
    let group = |e: &Reach| {
        json!({"group": e.name, "level": e.level, "named": e.named.right, "of": e.named.of, "factor": e.factor(),
               "factor_text": e.factor_text(), "within_twice_the_limit": e.within()})
    };
    let effect = |e: &Reach| {
        json!({"effect": e.name, "level": e.level, "named": e.named.right, "of": e.named.of, "limit": e.limit,
               "smallest_named": e.smallest_named.map(|s| s.strength), "smallest_named_sigmas": e.smallest_named.map(Seen::sigmas),
               "largest_missed_sigmas": e.largest_missed.map(Seen::sigmas), "factor": e.factor(), "factor_text": e.factor_text(),
               "within_twice_the_limit": e.within()})
    };
    json!({"limit_sigmas": limit_sigmas(), "false_alarms": FALSE_ALARMS, "unmeasured": unmeasured(rows),
           "cases": seen.iter().map(case).collect::<Vec<_>>(),
           "groups": by_group(&seen).iter().map(group).collect::<Vec<_>>(),
           "effects": by_effect(&seen).iter().map(effect).collect::<Vec<_>>()})
}

#[cfg(test)]
pub(crate) mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may")]
    use super::super::answer::{Answer, Estimate, Finding, Tested};
    use super::super::informed::Informed;
    use super::super::summary::tests::row;
    use super::*;

    fn one(strength: f64, named: bool) -> Seen {
        Seen {
            level: 2,
            id: "c000".into(),
            effect: "influx".into(),
            group: GROUPS[2],
            strength,
            error: 0.5,
            source: Source::Bound,
            named,
        }
    }

    /// An influx of that many standard errors, said with that probability.
    pub(crate) fn influx(sigmas: f64, probability: f64) -> Row {
        let mut case = row(&["influx"], Some(&[("influx", probability)]));
        case.strength = Some(1e-4 * sigmas);
        case.truth.effects[0].relations = vec!["riser_mass_balance".into()];
        case.answer.as_mut().unwrap().tested = vec![Tested {
            effect: "influx".into(),
            testable: true,
            strength: "rate_m3_s".into(),
            standard_error: Some(1e-4),
            ..Tested::default()
        }];
        case
    }

    #[test]
    fn the_limit_is_that_of_one_test_in_twenty_four() {
        assert!((limit_sigmas() - 3.144).abs() < 1e-3, "{}", limit_sigmas());
    }

    #[test]
    fn a_case_counts_in_standard_errors_of_its_own_recording() {
        let seen = seen(&[influx(6.0, 0.9), influx(2.0, 0.3)]);
        assert!((seen[0].sigmas() - 6.0).abs() < 1e-12 && seen[0].named);
        assert!((seen[1].sigmas() - 2.0).abs() < 1e-12 && !seen[1].named);
        assert_eq!(seen[0].source, Source::Bound);
        assert_eq!(seen[0].group, "riser mass balance");
    }

    #[test]
    fn what_is_no_amplitude_takes_its_error_from_the_fit_that_knows_the_truth() {
        let mut case = influx(6.0, 0.9);
        case.answer.as_mut().unwrap().tested[0].standard_error = None;
        assert!(seen(std::slice::from_ref(&case)).is_empty());
        assert_eq!(unmeasured(std::slice::from_ref(&case)), 1);
        let finding = Finding {
            effect: "influx".into(),
            parameters: vec![Estimate {
                name: "rate_m3_s".into(),
                value: 6e-4,
                ci95: Some((6e-4 - 1.96e-4, 6e-4 + 1.96e-4)),
            }],
            ..Finding::default()
        };
        case.informed = Some(Informed {
            answer: Some(Answer {
                findings: vec![finding],
                ..Answer::default()
            }),
            ..Informed::default()
        });
        let seen = seen(&[case]);
        assert!((seen[0].sigmas() - 6.0).abs() < 1e-9);
        assert_eq!(seen[0].source, Source::Interval);
    }

    #[test]
    fn what_a_recording_cannot_show_is_no_miss() {
        let mut case = influx(6.0, 0.1);
        case.answer.as_mut().unwrap().tested[0].testable = false;
        assert!(seen(&[case]).is_empty());
    }

    #[test]
    fn bins_double_and_hold_every_case() {
        let all = [one(0.6, false), one(0.9, true), one(4.5, true)];
        let bins = bins(&all);
        assert_eq!(bins.len(), 2);
        assert!((bins[0].0 - (1.2 * 1.8_f64).sqrt()).abs() < 1e-9);
        assert_eq!(bins[0].1, Tally { right: 1, of: 2 });
        assert_eq!(bins[1].1, Tally { right: 1, of: 1 });
    }

    #[test]
    fn the_factor_is_that_of_even_odds_and_bounds_stay_bounds() {
        let limit = 0.5 * limit_sigmas();
        let effects = |all: &[Seen]| {
            let of = by_effect(all);
            (of[0].factor(), of[0].within(), of[0].limit)
        };
        let (factor, within, at) = effects(&[one(limit, false), one(2.25 * limit, true)]);
        assert!((factor - 1.5).abs() < 1e-9 && within == Some(true));
        assert!((at - limit).abs() < 1e-12);
        assert_eq!(effects(&[one(9.0 * limit, true)]).1, None);
        let groups = [one(limit, false), one(2.25 * limit, true)];
        let groups = by_group(&groups);
        let names: Vec<&str> = groups.iter().map(|g| g.name).collect();
        assert_eq!(names, [GROUPS[2], "all"]);
        assert_eq!(effects(&[one(limit, true)]).1, Some(true));
        assert_eq!(effects(&[one(limit, false)]).1, None);
        assert_eq!(effects(&[one(9.0 * limit, false)]).1, Some(false));
    }
}
