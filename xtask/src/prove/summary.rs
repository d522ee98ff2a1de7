//! All answers together.

use super::answer::SIGNALS;
use super::detection;
use super::informed::Informed;
use super::score::{Marks, mark};
use super::stats::{Even, Tally, mean, reliability};
use super::targets::CONFIDENT;
use super::truth::{SEVERITIES, Sort, Truth};
use super::{answer::Answer, simulation::Simulation};
use std::collections::BTreeMap;

/// A case with what was concealed, what was said, and what that is worth.
pub(crate) struct Row {
    pub(crate) level: u8,
    /// `c000`
    pub(crate) id: String,
    pub(crate) truth: Truth,
    pub(crate) answer: Option<Answer>,
    pub(crate) simulation: Option<Simulation>,
    pub(crate) marks: Marks,
    /// Rules broken: no answer, bad form.
    pub(crate) broken: Vec<String>,
    pub(crate) wall_s: f64,
    pub(crate) peak_mib: Option<f64>,
    /// Of a single effect of the catalogue, SI, in the terms of its strength.
    pub(crate) strength: Option<f64>,
    /// What a fit that knows the truth makes of it.
    pub(crate) informed: Option<Informed>,
}

impl Row {
    pub(crate) fn new(
        (level, id): (u8, String),
        truth: Truth,
        answer: Option<Answer>,
        simulation: Option<Simulation>,
    ) -> Row {
        Row {
            marks: mark(&truth, answer.as_ref()),
            level,
            id,
            truth,
            answer,
            simulation,
            broken: Vec::new(),
            wall_s: 0.0,
            peak_mib: None,
            strength: None,
            informed: None,
        }
    }

    pub(crate) fn sort(&self) -> Sort {
        self.truth.sort()
    }

    /// Place of its severity among [`SEVERITIES`]; of a pair, of its first.
    pub(crate) fn severity(&self) -> Option<usize> {
        let severity = &self.truth.effects.first()?.severity;
        SEVERITIES.iter().position(|s| s == severity)
    }
}

/// Names right.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) struct Named {
    /// The set found is the set concealed.
    pub(crate) exact: Tally,
    /// The effect is among those found.
    pub(crate) hit: Tally,
    /// The effect is found or a stated alternative.
    pub(crate) within: Tally,
    /// Something else is claimed, beside it or in its place.
    pub(crate) wrong: Tally,
}

impl Named {
    fn add(&mut self, marks: &Marks) {
        self.exact.add(marks.exact);
        self.hit.add(marks.hit.iter().all(|h| *h));
        self.within.add(marks.within.iter().all(|h| *h));
        self.wrong.add(!marks.extra.is_empty());
    }
}

/// Errors and coverage of one scored parameter.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Parameter {
    pub(crate) errors: Vec<f64>,
    pub(crate) covered: Tally,
    pub(crate) missing: usize,
}

impl Parameter {
    fn add(&mut self, error: Option<f64>, covered: bool) {
        match error {
            Some(error) => {
                self.errors.push(error);
                self.covered.add(covered);
            }
            None => self.missing += 1,
        }
    }
}

/// The scores of one level.
#[derive(Default)]
pub(crate) struct Summary {
    pub(crate) level: u8,
    /// Runs that gave an answer.
    pub(crate) ran: Tally,
    pub(crate) singles: Named,
    pub(crate) by_severity: [Named; 5],
    pub(crate) by_effect: BTreeMap<String, Named>,
    pub(crate) by_both: BTreeMap<(String, usize), Named>,
    /// Clean recordings with a finding.
    pub(crate) false_alarms: Tally,
    pub(crate) foreign: Tally,
    /// Called unknown; found nothing; given a name, by what it really is.
    pub(crate) by_foreign: BTreeMap<String, [usize; 3]>,
    pub(crate) pairs: Named,
    pub(crate) pairs_meeting: Named,
    pub(crate) relation: Tally,
    pub(crate) overlap: Vec<f64>,
    pub(crate) parameter: Parameter,
    pub(crate) by_parameter: BTreeMap<(String, String), Parameter>,
    pub(crate) sensor: Tally,
    pub(crate) forecasts: Vec<(f64, bool)>,
    pub(crate) passed_over: usize,
    pub(crate) brier: Option<f64>,
    pub(crate) confidently_wrong: Tally,
    /// After over before on held-out samples, by signal, where something is concealed.
    pub(crate) gains: [Vec<f64>; 4],
    pub(crate) worse: Tally,
    pub(crate) clean_worse: Tally,
    /// Claims that the model after does not hold.
    pub(crate) unmodelled: Tally,
    pub(crate) rules: Tally,
    pub(crate) verdict: Tally,
    pub(crate) walls_s: Vec<f64>,
    pub(crate) by_hours: BTreeMap<u32, Vec<f64>>,
    pub(crate) peaks_mib: Vec<f64>,
    /// Effects that are named within twice the limit of their recordings, of those of which it can be told.
    pub(crate) within_limit: Tally,
    /// Size of even odds over that limit, of the effects of which some cases were named and some were not.
    pub(crate) factors: Vec<f64>,
    /// Shares of the held-out gain of fits that know the truth.
    pub(crate) truth_shares: Vec<f64>,
}

impl Summary {
    pub(crate) fn of(level: u8, rows: &[Row]) -> Summary {
        let mut summary = Summary {
            level,
            ..Summary::default()
        };
        let seen = detection::seen(rows);
        for effect in detection::by_effect(&seen) {
            if effect.level == level {
                if let Even::At(_) = effect.even {
                    summary.factors.push(effect.factor());
                }
                let within = effect.within();
                within.iter().for_each(|w| summary.within_limit.add(*w));
            }
        }
        let rows: Vec<&Row> = rows.iter().filter(|r| r.level == level).collect();
        let informed = rows.iter().filter_map(|r| r.informed.as_ref()?.share);
        summary.truth_shares = informed.map(|s| s.whole).collect();
        rows.iter().for_each(|row| summary.add(row));
        let squares: Vec<f64> = rows.iter().flat_map(|r| r.marks.squares()).collect();
        summary.brier = mean(&squares);
        summary
    }

    fn add(&mut self, row: &Row) {
        let marks = &row.marks;
        let answered = row.answer.is_some();
        self.ran.add(answered);
        match row.sort() {
            // A run without an answer raised no alarm and kept no silence.
            Sort::Clean if answered => self.false_alarms.add(!marks.found.is_empty()),
            Sort::Clean => {}
            Sort::Single => self.single(row),
            Sort::Foreign => self.alien(row),
            Sort::Pair => {
                self.pairs.add(marks);
                if row.truth.meets() {
                    self.pairs_meeting.add(marks);
                }
            }
        }
        self.passed_over += marks.passed_over;
        if !answered {
            return;
        }
        marks.relation.iter().for_each(|r| self.relation.add(*r));
        self.overlap.extend(&marks.overlap);
        for p in &marks.parameters {
            self.parameter.add(p.error, p.covered);
            let key = (p.effect.clone(), p.name.clone());
            self.by_parameter
                .entry(key)
                .or_default()
                .add(p.error, p.covered);
        }
        marks.sensor.iter().for_each(|s| self.sensor.add(*s));
        self.forecasts.extend(&marks.forecasts);
        for (_, right) in marks.forecasts.iter().filter(|(p, _)| *p >= CONFIDENT) {
            self.confidently_wrong.add(!right);
        }
        self.verdict.add(marks.verdict_right);
        self.simulated(row);
        self.walls_s.push(row.wall_s);
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "hours are few, and the cast saturates"
        )]
        let hours = row.truth.hours.round() as u32;
        self.by_hours.entry(hours).or_default().push(row.wall_s);
        self.peaks_mib.extend(row.peak_mib);
    }

    fn single(&mut self, row: &Row) {
        self.singles.add(&row.marks);
        let effect = row.truth.effects[0].effect.clone();
        self.by_effect
            .entry(effect.clone())
            .or_default()
            .add(&row.marks);
        if let Some(severity) = row.severity() {
            self.by_severity[severity].add(&row.marks);
            let cell = self.by_both.entry((effect, severity)).or_default();
            cell.add(&row.marks);
        }
    }

    fn alien(&mut self, row: &Row) {
        self.foreign.add(row.marks.exact);
        let kind = row.truth.effects[0].kind.clone();
        let counts = self
            .by_foreign
            .entry(kind.unwrap_or_else(|| "not told".into()))
            .or_default();
        let place = match (row.marks.exact, row.marks.found.is_empty()) {
            (true, _) => 0,
            (false, true) => 1,
            (false, false) => 2,
        };
        counts[place] += 1;
    }

    fn simulated(&mut self, row: &Row) {
        let Some(simulation) = &row.simulation else {
            return;
        };
        self.rules.add(simulation.keeps_rules());
        for (i, gain) in simulation.gains.iter().enumerate() {
            let Some(gain) = gain else { continue };
            if row.sort() == Sort::Clean {
                self.clean_worse.add(gain.worse());
            } else {
                self.gains[i].push(gain.ratio());
                self.worse.add(gain.worse());
            }
        }
        if !row.marks.found.is_empty() {
            self.unmodelled.add(simulation.unmodelled());
        }
    }

    /// Findings by tenth of probability: their mean probability and how many are right.
    pub(crate) fn reliability(&self) -> Vec<(f64, Tally)> {
        reliability(&self.forecasts)
    }
}

/// Row of what was concealed, column of what was said.
pub(crate) const NOTHING: &str = "nothing";

/// Counts by what was concealed and what was claimed, pairs left out: their claims have no one owner.
pub(crate) fn confusion<'a>(
    rows: impl IntoIterator<Item = &'a Row>,
) -> BTreeMap<(String, String), usize> {
    let mut counts = BTreeMap::new();
    let answered = rows.into_iter().filter(|r| r.answer.is_some());
    for row in answered.filter(|r| r.sort() != Sort::Pair) {
        let concealed = row.truth.names().next().unwrap_or(NOTHING);
        let mut said: Vec<&str> = row.marks.found.iter().map(String::as_str).collect();
        if said.is_empty() {
            said.push(NOTHING);
        }
        for claim in said {
            let key = (concealed.to_owned(), claim.to_owned());
            *counts.entry(key).or_default() += 1;
        }
    }
    counts
}

/// Short names of [`SIGNALS`].
pub(crate) const SIGNAL_TITLES: [&str; SIGNALS.len()] = [
    "return flow",
    "riser level",
    "pump outlet pressure",
    "pump head",
];

#[cfg(test)]
pub(crate) mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may")]
    use super::super::answer::Finding;
    use super::super::simulation::Gain;
    use super::super::truth::Concealed;
    use super::*;

    /// A case that conceals and says these effects; severities are moderate.
    pub(crate) fn row(concealed: &[&str], said: Option<&[(&str, f64)]>) -> Row {
        let effects = concealed.iter().map(|e| Concealed {
            effect: (*e).into(),
            severity: "moderate".into(),
            relations: vec!["pump_head".into()],
            ..Concealed::default()
        });
        let truth = Truth {
            hours: 4.0,
            well: "gom".into(),
            effects: effects.collect(),
        };
        let answer = said.map(|said| Answer {
            verdict: if said.is_empty() {
                "consistent"
            } else {
                "explained"
            }
            .into(),
            findings: said
                .iter()
                .map(|(effect, probability)| Finding {
                    effect: (*effect).into(),
                    probability: *probability,
                    relation: "pump_head".into(),
                    ..Finding::default()
                })
                .collect(),
            ..Answer::default()
        });
        Row::new((2, "c000".into()), truth, answer, None)
    }

    fn tally(right: usize, of: usize) -> Tally {
        Tally { right, of }
    }

    #[test]
    fn cases_are_counted_where_they_belong() {
        let rows = [
            row(&["influx"], Some(&[("influx", 0.95)])),
            row(&["influx"], Some(&[("heave", 0.95)])),
            row(&["heave"], Some(&[])),
            row(&["heave"], None),
            row(&[], Some(&[])),
            row(&[], Some(&[("heave", 0.6)])),
            row(&[], None),
            row(&["unknown"], Some(&[("unknown", 0.9)])),
            row(&["unknown"], Some(&[("influx", 0.7)])),
            row(
                &["influx", "heave"],
                Some(&[("heave", 0.9), ("influx", 0.8)]),
            ),
            row(
                &["influx", "heave"],
                Some(&[("heave", 0.9), ("influx", 0.3)]),
            ),
        ];
        let s = Summary::of(2, &rows);
        assert_eq!(s.ran, tally(9, 11));
        assert_eq!(s.singles.exact, tally(1, 4));
        assert_eq!(s.singles.wrong, tally(1, 4));
        assert_eq!(s.by_severity[3].exact, tally(1, 4));
        assert_eq!(s.by_effect["influx"].exact, tally(1, 2));
        assert_eq!(s.false_alarms, tally(1, 2), "no answer is no alarm");
        assert_eq!(s.foreign, tally(1, 2));
        assert_eq!(s.by_foreign["not told"], [1, 0, 1]);
        assert_eq!(s.pairs.exact, tally(1, 2));
        assert_eq!(s.pairs.within, tally(2, 2));
        assert_eq!(s.pairs_meeting.exact, tally(1, 2));
        // 0.95 wrong, of 0.95, 0.95, 0.9, 0.9 and 0.9.
        assert_eq!(s.confidently_wrong, tally(1, 5));
        // Passed over: influx named heave, heave twice in silence, unknown named influx.
        assert_eq!(s.passed_over, 4);
        assert_eq!(Summary::of(1, &rows).ran, tally(0, 0));
    }

    #[test]
    fn the_brier_score_holds_findings_and_silences() {
        let rows = [
            row(&["influx"], Some(&[("influx", 0.8)])),
            row(&["heave"], Some(&[])),
            row(&[], Some(&[("heave", 0.6)])),
        ];
        let brier = Summary::of(2, &rows).brier.unwrap();
        assert!((brier - (0.04 + 1.0 + 0.36) / 3.0).abs() < 1e-12);
    }

    #[test]
    fn reliability_bins_hold_their_edges() {
        let rows = [
            row(&["influx"], Some(&[("influx", 0.9)])),
            row(&["influx"], Some(&[("influx", 1.0)])),
            row(&["influx"], Some(&[("heave", 0.89)])),
        ];
        let bins = Summary::of(2, &rows).reliability();
        assert_eq!(bins.len(), 2);
        assert!((bins[0].0 - 0.89).abs() < 1e-12);
        assert_eq!(bins[0].1, tally(0, 1));
        assert!((bins[1].0 - 0.95).abs() < 1e-12);
        assert_eq!(bins[1].1, tally(2, 2));
    }

    #[test]
    fn the_confusion_matrix_counts_claims_and_silence_but_no_pairs() {
        let rows = [
            row(&["influx"], Some(&[("influx", 0.9), ("heave", 0.6)])),
            row(&["influx"], Some(&[("heave", 0.4)])),
            row(&[], Some(&[])),
            row(&["influx", "heave"], Some(&[("heave", 0.9)])),
            row(&["influx"], None),
        ];
        let counts = confusion(&rows);
        let of = |a: &str, b: &str| counts.get(&(a.into(), b.into())).copied().unwrap_or(0);
        assert_eq!(of("influx", "influx"), 1);
        assert_eq!(of("influx", "heave"), 1);
        assert_eq!(of("influx", NOTHING), 1);
        assert_eq!(of(NOTHING, NOTHING), 1);
        assert_eq!(counts.values().sum::<usize>(), 4);
    }

    #[test]
    fn a_clean_recording_made_worse_is_counted_apart_from_gains() {
        let gain = |before: f64, after: f64| {
            Some(Gain {
                rmse_before: before,
                rmse_after: after,
                samples: 100,
            })
        };
        let simulated = |mut row: Row, first, second| {
            row.simulation = Some(Simulation {
                held_share: 0.25,
                shortest_window_s: 1300.0,
                gains: [first, second, None, None],
            });
            row
        };
        let rows = [
            simulated(row(&[], Some(&[])), gain(1.0, 1.0), gain(1.0, 1.03)),
            simulated(
                row(&["influx"], Some(&[("influx", 0.9)])),
                gain(2.0, 1.0),
                gain(1.0, 1.1),
            ),
            simulated(
                row(&["heave"], Some(&[("influx", 0.9)])),
                gain(2.0, 2.0),
                None,
            ),
        ];
        let s = Summary::of(2, &rows);
        assert_eq!(s.clean_worse, tally(1, 2));
        assert_eq!(s.gains[0], [0.5, 1.0]);
        assert_eq!(s.worse, tally(1, 3));
        assert_eq!(s.unmodelled, tally(1, 2));
        assert_eq!(s.rules, tally(3, 3));
    }
}
