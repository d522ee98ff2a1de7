//! What things are called, and how much may be said of a finding.

use dgd_diagnose::{Diagnosis, Finding, ParameterEstimate};
use dgd_effects::Relation;
use dgd_recording::Moment;

use super::quantity::{clock, percent, percent_interval, split};

/// How much a finding says; each rung holds those below it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Rung {
    /// Something is left out here; its cause is none of the catalogue's.
    Located,
    /// One of a few causes that the recording cannot tell apart.
    Class,
    /// One cause.
    Cause,
    /// One cause, with its strength and interval.
    Measured,
}

/// The rungs in words, lowest first.
pub(super) const RUNGS: [(Rung, &str); 4] = [
    (Rung::Located, "place"),
    (Rung::Class, "kind of cause"),
    (Rung::Cause, "one cause"),
    (Rung::Measured, "one cause and its size"),
];

/// A single cause is claimed from here on.
const SURE: f64 = 0.8;

impl Rung {
    pub(super) fn of(finding: &Finding) -> Self {
        if finding.is_unknown() {
            return Self::Located;
        }
        if !(finding.probability >= SURE) {
            return Self::Class;
        }
        match strength(finding) {
            Some(p) if p.estimate.is_finite() && p.ci95.0.is_finite() && p.ci95.1.is_finite() => {
                Self::Measured
            }
            _ => Self::Cause,
        }
    }
}

/// The parameter that says how strong an effect is: the first one of the catalogue, otherwise the first one given.
pub(super) fn strength(finding: &Finding) -> Option<&ParameterEstimate> {
    let first = dgd_effects::find(&finding.effect)
        .and_then(|effect| effect.about().parameters.first())
        .map(|p| p.name);
    finding
        .parameters
        .iter()
        .find(|p| Some(p.name.as_str()) == first)
        .or_else(|| finding.parameters.first())
}

/// `126 L/min (95 % interval 114 to 138 L/min)`.
pub(super) fn estimated(p: &ParameterEstimate) -> String {
    let (_, unit) = split(&p.name);
    let value = unit.estimate(p.estimate, p.ci95);
    match unit.interval(p.estimate, p.ci95) {
        Some(interval) => format!("{value} (95\u{a0}% interval {interval})"),
        None => value,
    }
}

/// What stands against a finding without a serious alternative.
pub(super) fn other_or_nothing(finding: &Finding) -> String {
    let rest = 1.0 - finding.probability;
    if rest >= Finding::SERIOUS {
        format!("{} for something else, or nothing", percent(rest))
    } else {
        "no serious alternative".to_owned()
    }
}

/// An effect of the catalogue in words; its id where the catalogue does not hold it.
pub(super) fn title_of(id: &str) -> String {
    if id == "unknown" {
        return "a cause outside the catalogue".to_owned();
    }
    dgd_effects::find(id).map_or_else(
        || id.replace('_', " "),
        |effect| effect.about().title.to_owned(),
    )
}

/// The effects of the model to start from, if it holds any.
pub(super) fn held(diagnosis: &Diagnosis) -> Option<String> {
    let titles: Vec<String> = diagnosis
        .started_from
        .iter()
        .map(|id| held_title(id))
        .collect();
    (!titles.is_empty()).then(|| listed(&titles, "and"))
}

/// An effect of the model to start from, as a clause.
pub(super) fn held_title(id: &str) -> String {
    if id == "unknown" {
        "an empirical correction acts".to_owned()
    } else {
        title_of(id)
    }
}

/// What is to be known beside suspects of which none is likely.
pub(super) fn beside_suspects(diagnosis: &Diagnosis) -> String {
    let each: Vec<String> = (diagnosis.unsuspected().iter())
        .map(|t| {
            let title = title_of(t.effect);
            format!("{title} (ln BF {:.0}, needed {:.0})", t.evidence, t.hurdle)
        })
        .collect();
    if each.is_empty() {
        return "nothing else was fitted except swell".to_owned();
    }
    format!(
        "nothing else was fitted, but this also stands out: {}",
        each.join("; ")
    )
}

/// The finding's own words, or those of the catalogue.
pub(super) fn title(finding: &Finding) -> String {
    if finding.title.trim().is_empty() {
        title_of(&finding.effect)
    } else {
        finding.title.clone()
    }
}

pub(super) fn relation(relation: Relation) -> &'static str {
    match relation {
        Relation::ReturnLineFriction => "friction of the return line",
        Relation::PumpHead => "pump head",
        Relation::RiserMassBalance => "mass balance of the riser",
        Relation::Momentum => "momentum of the mud",
        Relation::Instrument => "instruments",
    }
}

/// A signal of the simulation, or any name with a unit, in words.
pub(super) fn signal(name: &str) -> String {
    split(name).0
}

/// When a finding acts, as an adverb: `throughout the recording`, `from 2 h to 3 h (2024-10-26 05:00 to 06:00)`.
pub(super) fn when(finding: &Finding, diagnosis: &Diagnosis) -> String {
    let span_s = span(diagnosis);
    let told = on_the_clock(&finding.intervals_s, span_s);
    match dated(&finding.intervals_s, span_s, diagnosis.began) {
        Some(dates) => format!("{told} ({dates})"),
        None => told,
    }
}

/// The dates from the first beginning to the last end, unless that is the whole recording.
fn dated(intervals_s: &[(f64, f64)], span_s: (f64, f64), began: Option<Moment>) -> Option<String> {
    let (from, to) = reach(intervals_s)?;
    let at = |seconds| Some(began?.after(seconds)?.to_minute());
    match at_ends((from, to), span_s) {
        (true, true) => None,
        (true, false) => Some(format!("until {}", at(to)?)),
        (false, true) => Some(format!("since {}", at(from)?)),
        (false, false) => began?.stretch((from, to)),
    }
}

/// From the first beginning to the last end, s; `None` where none is told.
fn reach(intervals_s: &[(f64, f64)]) -> Option<(f64, f64)> {
    let told = intervals_s.iter().copied();
    told.filter(|(from, to)| from.is_finite() && to.is_finite())
        .reduce(|(low, high), (from, to)| (low.min(from), high.max(to)))
}

/// Whether a stretch begins with the recording, and whether it ends with it, but for a hundredth.
fn at_ends((from, to): (f64, f64), span_s: (f64, f64)) -> (bool, bool) {
    let slack = 0.01 * (span_s.1 - span_s.0).abs();
    (from <= span_s.0 + slack, to >= span_s.1 - slack)
}

fn on_the_clock(intervals_s: &[(f64, f64)], span_s: (f64, f64)) -> String {
    let stretch = |&(from, to): &(f64, f64)| match at_ends((from, to), span_s) {
        (true, true) => "throughout the recording".to_owned(),
        (true, false) => format!("from the start to {}", clock(to)),
        (false, true) => format!("from {} to the end", clock(from)),
        (false, false) => format!("from {} to {}", clock(from), clock(to)),
    };
    let given: Vec<(f64, f64)> = intervals_s
        .iter()
        .copied()
        .filter(|(from, to)| from.is_finite() && to.is_finite())
        .collect();
    match given.as_slice() {
        [] => "at an unknown time".to_owned(),
        [first @ .., last] if given.len() <= 3 => {
            let mut words: Vec<String> = first.iter().map(stretch).collect();
            words.push(stretch(last));
            listed(&words, "and")
        }
        all => {
            let sum: f64 = all.iter().map(|(from, to)| to - from).sum();
            let (from, to) = reach(all).unwrap_or(span_s);
            format!(
                "in {} stretches of {} in all, between {} and {}",
                all.len(),
                clock(sum),
                clock(from),
                clock(to)
            )
        }
    }
}

/// `a, b and c`.
pub(super) fn listed(words: &[String], last_word: &str) -> String {
    match words {
        [] => String::new(),
        [one] => one.clone(),
        [first @ .., last] => format!("{} {last_word} {last}", first.join(", ")),
    }
}

/// The held-out gain of a finding as a clause.
pub(super) fn gain(finding: &Finding, diagnosis: &Diagnosis, together: bool) -> Option<String> {
    let held = finding.held_out.as_ref()?;
    if !diagnosis.acts_held_out() {
        let acts = if together { "they act" } else { "it acts" };
        return Some(format!(
            "the windows that no fit has used do not reach where {acts}"
        ));
    }
    let share = improvement(held.rmse_before, held.rmse_after)?;
    let (low, high) = held.improvement_ci95;
    let takes = if together {
        "including them cuts"
    } else {
        "including it cuts"
    };
    let interval = if low.is_finite() && high.is_finite() {
        let told = if high < 0.0 {
            percent_interval((-high, -low))
        } else if low > 0.0 {
            percent_interval((low, high))
        } else {
            more_to_less(low, high)
        };
        format!(" (95\u{a0}% interval {told})")
    } else {
        String::new()
    };
    let signal = signal(&held.signal);
    Some(if low <= 0.0 && high >= 0.0 {
        format!(
            "on data that no fit has used, the change in {signal} error is not significant{interval}"
        )
    } else if share >= 0.0 {
        format!(
            "on data that no fit has used, {takes} the {signal} error by {}{interval}",
            percent(share)
        )
    } else {
        format!(
            "on data that no fit has used, the {signal} error grows by {}{interval}",
            percent(-share)
        )
    })
}

/// An interval that no gain lies in.
fn more_to_less(low: f64, high: f64) -> String {
    format!("{} more to {} less", percent(-low), percent(high))
}

/// By how much less the error is, with its interval; no gain is none.
pub(super) fn less((low, high): (f64, f64)) -> String {
    if low <= 0.0 && high >= 0.0 {
        format!("not significant; 95\u{a0}%: {}", more_to_less(low, high))
    } else if high < 0.0 {
        format!("95\u{a0}%: {} more", percent_interval((-high, -low)))
    } else {
        format!("95\u{a0}%: {} less", percent_interval((low, high)))
    }
}

/// 1 - after/before.
pub(super) fn improvement(before: f64, after: f64) -> Option<f64> {
    let share = 1.0 - after / before;
    (share.is_finite() && before > 0.0).then_some(share)
}

/// First letter in upper case.
pub(super) fn capital(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or_else(String::new, |first| {
        first.to_uppercase().chain(letters).collect()
    })
}

/// Ends of the recording, s.
pub(super) fn span(diagnosis: &Diagnosis) -> (f64, f64) {
    let (from, to) = diagnosis.setting.span_s;
    if from.is_finite() && to.is_finite() && to > from {
        return (from, to);
    }
    let blocks = diagnosis.traces.iter().flat_map(|t| &t.t_s);
    let times = diagnosis.simulation.t_s.iter().chain(blocks);
    let (low, high) = times
        .copied()
        .filter(|t| t.is_finite())
        .fold((f64::MAX, f64::MIN), |(l, h), t| (l.min(t), h.max(t)));
    if high > low { (low, high) } else { (0.0, 1.0) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn intervals_are_told_by_where_they_reach() {
        let span = (0.0, 20_000.0);
        let when = |given: &[(f64, f64)], span| on_the_clock(given, span).replace('\u{a0}', " ");
        assert_eq!(when(&[(0.0, 20_000.0)], span), "throughout the recording");
        assert_eq!(when(&[(3600.0, 19_990.0)], span), "from 1 h to the end");
        assert_eq!(
            when(&[(3600.0, 7200.0), (10_800.0, 14_400.0)], span),
            "from 1 h to 2 h and from 3 h to 4 h"
        );
        let many: Vec<(f64, f64)> = (1..8)
            .map(|i| (f64::from(i) * 2000.0, f64::from(i) * 2000.0 + 900.0))
            .collect();
        assert!(when(&many, span).starts_with("in 7 stretches of 1 h 45 min in all"));
        assert_eq!(when(&[(f64::NAN, 1.0)], span), "at an unknown time");
    }

    #[test]
    fn dates_stand_beside_what_does_not_reach_over_all() {
        let span = (0.0, 100_000.0);
        let began = Moment::parse("2024-10-26 22:30");
        let told = |given: &[(f64, f64)]| dated(given, span, began);
        assert_eq!(told(&[(0.0, 100_000.0)]), None);
        assert_eq!(
            told(&[(3600.0, 100_000.0)]).as_deref(),
            Some("since 2024-10-26 23:30")
        );
        assert_eq!(
            told(&[(0.0, 7200.0)]).as_deref(),
            Some("until 2024-10-27 00:30")
        );
        assert_eq!(
            told(&[(7200.0, 9000.0), (10_800.0, 14_400.0), (f64::NAN, 5.0)]).as_deref(),
            Some("2024-10-27 00:30 to 02:30")
        );
        assert_eq!(told(&[]), None);
        assert_eq!(dated(&[(3600.0, 7200.0)], span, None), None);
    }

    #[test]
    fn words_are_listed_with_commas() {
        let words = ["a", "b", "c"].map(str::to_owned);
        assert_eq!(listed(&words, "or"), "a, b or c");
    }
}
