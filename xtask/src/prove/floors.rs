//! What the scores of a proof must not fall below: a floor that is not reached fails it, and names the recordings.

use super::failures::{concealed, said};
use super::summary::Row;
use super::truth::Sort;
use anyhow::{Result, bail};
use std::fmt::Write;
use std::str::FromStr;

/// What is counted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Counted {
    /// Runs that gave no answer.
    Silent,
    /// Clean recordings with a finding.
    Alarms,
    /// Recordings with a wrong finding of probability 0.9 or more.
    Sure,
    /// Strong and moderate single effects that are named, and nothing beside them.
    Named,
}

/// Name on the command line, words, and which they are.
const COUNTED: [(&str, &str, Counted); 4] = [
    ("silent", "recordings without an answer", Counted::Silent),
    ("alarms", "clean recordings with a finding", Counted::Alarms),
    ("sure", "recordings confidently wrong", Counted::Sure),
    (
        "named",
        "strong and moderate single effects named exactly",
        Counted::Named,
    ),
];

/// A bound on one count: a floor under what is named, a ceiling over what is wrong.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Floor {
    counted: Counted,
    bound: usize,
}

/// Of the short form, chosen on what it showed when they were: all 24 answered, no finding on its 4 clean recordings, no wrong one among
/// the 9 of probability 0.9 or more, and all 6 strong and moderate singles named. The first three have no room: what breaks them is
/// looked into whoever broke it. One single may go, as 44 of 48 were named in a proof of two hundred: a better search loses one now
/// and then, and two of six seldom (one time in twelve).
pub(crate) const SHORT: [Floor; 4] = [
    at(Counted::Silent, 0),
    at(Counted::Alarms, 0),
    at(Counted::Sure, 0),
    at(Counted::Named, 5),
];

const fn at(counted: Counted, bound: usize) -> Floor {
    Floor { counted, bound }
}

impl FromStr for Floor {
    type Err = String;

    fn from_str(text: &str) -> Result<Floor, String> {
        let known = COUNTED.map(|c| c.0).join(", ");
        let (name, bound) = text
            .split_once('=')
            .ok_or_else(|| format!("expected NAME=COUNT with a name of {known}"))?;
        let counted = COUNTED.iter().find(|c| c.0 == name).map(|c| c.2);
        Ok(Floor {
            counted: counted.ok_or_else(|| format!("`{name}` is none of {known}"))?,
            bound: (bound.parse()).map_err(|_| format!("`{bound}` is no count"))?,
        })
    }
}

impl Counted {
    fn words(self) -> &'static str {
        let of = COUNTED.iter().find(|c| c.2 == self);
        of.map_or("", |c| c.1)
    }

    /// Whether it counts what is right, of which there must be enough.
    fn is_right(self) -> bool {
        self == Counted::Named
    }

    /// Whether a recording is asked for it at all.
    fn asks(self, row: &Row) -> bool {
        match self {
            Counted::Silent | Counted::Sure => true,
            Counted::Alarms => row.sort() == Sort::Clean,
            Counted::Named => {
                row.sort() == Sort::Single
                    && ["strong", "moderate"].contains(&row.truth.effects[0].severity.as_str())
            }
        }
    }

    fn counts(self, row: &Row) -> bool {
        match self {
            Counted::Silent => row.answer.is_none(),
            Counted::Alarms => !row.marks.found.is_empty(),
            Counted::Sure => row.marks.confidently_wrong() > 0,
            Counted::Named => row.marks.exact,
        }
    }
}

impl Floor {
    /// The count, and of how many.
    fn count(self, rows: &[Row]) -> (usize, usize) {
        let asked = rows.iter().filter(|r| self.counted.asks(r));
        asked.fold((0, 0), |(count, of), row| {
            (count + usize::from(self.counted.counts(row)), of + 1)
        })
    }

    fn holds(self, rows: &[Row]) -> bool {
        let (count, _) = self.count(rows);
        if self.counted.is_right() {
            count >= self.bound
        } else {
            count <= self.bound
        }
    }

    /// `12 of 14 strong and moderate single effects named exactly, at least 11`
    fn line(self, rows: &[Row]) -> String {
        let (count, of) = self.count(rows);
        let sign = if self.counted.is_right() {
            "least"
        } else {
            "most"
        };
        format!(
            "{count} of {of} {}, at {sign} {}",
            self.counted.words(),
            self.bound
        )
    }

    /// The recordings that keep the count from its bound.
    fn guilty(self, rows: &[Row]) -> impl Iterator<Item = &Row> {
        let asked = rows.iter().filter(move |r| self.counted.asks(r));
        asked.filter(move |r| self.counted.counts(r) != self.counted.is_right())
    }
}

/// The floors that hold for a run: those given, and of the built-in ones those that none given replaces.
pub(crate) fn in_force(given: &[Floor], built_in: &[Floor]) -> Vec<Floor> {
    let replaced = |floor: &&Floor| given.iter().any(|g| g.counted == floor.counted);
    let kept = built_in.iter().filter(|floor| !replaced(floor));
    kept.chain(given).copied().collect()
}

/// Broken rules fail the proof, and so do scores below their floors.
pub(crate) fn verdict(floors: &[Floor], rows: &[Row]) -> Result<()> {
    for line in standing(floors, rows) {
        println!("{line}");
    }
    let faults: Vec<String> = [broken(rows), missed(floors, rows)]
        .into_iter()
        .flatten()
        .collect();
    if faults.is_empty() {
        return Ok(());
    }
    bail!("{}\nall are in failures.md", faults.join("\n"))
}

/// The rules that were broken; `None` if all were kept.
fn broken(rows: &[Row]) -> Option<String> {
    let broken: Vec<&Row> = rows.iter().filter(|r| !r.broken.is_empty()).collect();
    if broken.is_empty() {
        return None;
    }
    let mut text = format!("{} of {} cases broke a rule", broken.len(), rows.len());
    for row in broken.iter().take(10) {
        text.push_str(&format!(
            "\n  level {} {}: {}",
            row.level, row.id, row.broken[0]
        ));
    }
    Some(text)
}

/// One line a floor that holds, and one if there is none to hold. One that no recording was asked for was not put to the test.
fn standing(floors: &[Floor], rows: &[Row]) -> Vec<String> {
    if floors.is_empty() {
        return vec!["no floors in force".to_owned()];
    }
    let told = |floor: &Floor| {
        let word = if floor.count(rows).1 > 0 {
            "kept"
        } else {
            "not tried"
        };
        format!("floor {word}: {}", floor.line(rows))
    };
    let holding = floors.iter().filter(|f| f.holds(rows));
    holding.map(told).collect()
}

/// The floors that are not reached, each with the recordings that fell short; `None` if all hold.
fn missed(floors: &[Floor], rows: &[Row]) -> Option<String> {
    let missed: Vec<&Floor> = floors.iter().filter(|f| !f.holds(rows)).collect();
    let mut text = match missed.len() {
        0 => return None,
        1 => String::from("a floor of the scores is not kept"),
        some => format!("{some} floors of the scores are not kept"),
    };
    for floor in missed {
        // Writing into a string cannot fail, here and below.
        let _ = write!(text, "\n  {}", floor.line(rows));
        for row in floor.guilty(rows) {
            let _ = write!(
                text,
                "\n    level {} {}: concealed {}; said {}",
                row.level,
                row.id,
                concealed(&row.truth),
                said(row.answer.as_ref())
            );
        }
    }
    Some(text)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may")]
    use super::super::summary::tests::row;
    use super::*;

    fn floor(text: &str) -> Floor {
        text.parse().unwrap()
    }

    fn of_severity(severity: &str, said: &[(&str, f64)]) -> Row {
        let mut row = row(&["heave"], Some(said));
        row.truth.effects[0].severity = severity.into();
        row
    }

    #[test]
    fn a_floor_is_a_name_and_a_count() {
        assert_eq!(floor("named=12"), at(Counted::Named, 12));
        assert_eq!(floor("alarms=0"), at(Counted::Alarms, 0));
        for (text, says) in [
            ("named", "NAME=COUNT"),
            ("gold=3", "`gold` is none of silent, alarms, sure, named"),
            ("named=most", "`most` is no count"),
            ("named=-1", "`-1` is no count"),
        ] {
            let error = text.parse::<Floor>().unwrap_err();
            assert!(error.contains(says), "{error}");
        }
    }

    #[test]
    fn an_alarm_on_a_clean_recording_fails_with_its_name_and_one_elsewhere_does_not() {
        let mut loud = row(&[], Some(&[("heave", 0.61)]));
        loud.id = "c009".into();
        let rows = [row(&["influx"], Some(&[("heave", 0.61)])), loud];
        let text = missed(&[floor("alarms=0")], &rows).unwrap();
        assert!(
            text.contains("1 of 1 clean recordings with a finding, at most 0"),
            "{text}"
        );
        assert!(
            text.contains("level 2 c009: concealed nothing; said explained: heave 0.61"),
            "{text}"
        );
        assert!(!text.contains("c000"), "{text}");
        assert_eq!(missed(&[floor("alarms=1")], &rows), None);
        assert_eq!(missed(&[floor("alarms=0")], &rows[..1]), None);
    }

    #[test]
    fn strong_and_moderate_effects_alone_are_asked_for_their_names() {
        let right = [("heave", 0.8)];
        let rows = [
            of_severity("strong", &right),
            of_severity("moderate", &[]),
            of_severity("subtle", &right),
            of_severity("trace", &[]),
            row(&["influx", "heave"], Some(&right)),
        ];
        assert_eq!(missed(&[floor("named=1")], &rows), None);
        let text = missed(&[floor("named=2")], &rows).unwrap();
        assert!(text.contains("1 of 2 strong and moderate"), "{text}");
        assert!(text.contains("concealed heave, moderate; said"), "{text}");
        assert!(!text.contains("trace"), "{text}");
    }

    #[test]
    fn a_name_beside_the_right_one_does_not_count_as_named() {
        let two = [of_severity("strong", &[("heave", 0.8), ("influx", 0.6)])];
        assert!(missed(&[floor("named=1")], &two).is_some());
    }

    #[test]
    fn a_sure_wrong_name_and_a_missing_answer_fail() {
        let rows = [row(&["heave"], Some(&[("influx", 0.9)])), row(&[], None)];
        let text = missed(&SHORT[..3], &rows).unwrap();
        assert!(text.starts_with("2 floors"), "{text}");
        assert!(text.contains("influx 0.90"), "{text}");
        assert!(text.contains("said no answer"), "{text}");
        let unsure = [row(&["heave"], Some(&[("influx", 0.89)]))];
        assert_eq!(missed(&SHORT[..3], &unsure), None);
        assert_eq!(standing(&SHORT[..3], &unsure).len(), 3);
    }

    #[test]
    fn a_floor_that_no_recording_is_asked_for_is_not_told_as_kept() {
        let rows = [row(&["heave"], Some(&[("heave", 0.9)]))];
        let told = standing(&[floor("silent=0"), floor("alarms=0")], &rows);
        assert_eq!(
            told,
            [
                "floor kept: 0 of 1 recordings without an answer, at most 0",
                "floor not tried: 0 of 0 clean recordings with a finding, at most 0",
            ]
        );
        // Of what is right there must be some.
        assert!(missed(&[floor("named=1")], &[row(&[], Some(&[]))]).is_some());
        assert_eq!(standing(&[floor("silent=0")], &[row(&[], None)]), [""; 0]);
        assert_eq!(standing(&[], &rows), ["no floors in force"]);
    }

    #[test]
    fn what_is_given_replaces_the_built_in_floor_of_its_name_alone() {
        let given = [floor("named=3")];
        assert_eq!(in_force(&given, &[]), given);
        let all = in_force(&given, &SHORT);
        assert_eq!(all.len(), SHORT.len());
        assert!(all.contains(&given[0]) && !all.contains(&SHORT[3]));
        assert_eq!(in_force(&[], &SHORT), SHORT);
    }
}
