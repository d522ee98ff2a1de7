//! The readings of several tags on one clock.

use super::super::rows::SPARE_CELLS;
use crate::nearest::{median_step, nearest};
use crate::{IngestError, count};
use dgd_recording::{Issue, IssueKind};
use std::f64::consts::TAU;

/// Cells that the table may have for every byte of the text, and beyond: few of them are readings where each tag has its own times.
const CELLS_A_BYTE: u64 = 4;

/// Parts of a unit of the clock in which stamps are held: of a second, nanoseconds.
const PARTS: f64 = 1e9;
const SECOND: u64 = 1_000_000_000;
/// Readings come at one part of a second if the mean of their directions on its circle is longer than this share of the radius. Set by hand.
const TOGETHER: f64 = 0.5;

/// The readings of all tags, and the stamps that they share in the end.
pub(in crate::csv) struct Readings {
    /// What the clock reads at stamp 0.
    from: f64,
    tags: Vec<Series>,
    at: Vec<u64>,
    /// Readings without a tag or a time.
    without_place: u64,
}

/// The readings of a tag.
#[derive(Default)]
struct Series {
    at: Vec<u64>,
    values: Vec<f64>,
}

impl Readings {
    /// Of so many tags, none yet; on a clock that reads so.
    pub(in crate::csv) fn new(tags: usize, clock: &[f64]) -> Self {
        Self {
            from: clock.iter().copied().fold(f64::INFINITY, f64::min),
            tags: (0..tags).map(|_| Series::default()).collect(),
            at: Vec::new(),
            without_place: 0,
        }
    }

    /// Adds a reading, if it has a tag and a time.
    pub(in crate::csv) fn add(&mut self, tag: Option<usize>, at: f64, value: f64) {
        match tag.and_then(|tag| self.tags.get_mut(tag)) {
            Some(series) if at.is_finite() => {
                series.at.push(parts(at - self.from));
                series.values.push(value);
            }
            _ => self.without_place += 1,
        }
    }

    /// Finds the clock. Where tags share their times that is all of them; where each is polled at its own instants, those of the tag that has most
    /// readings; and where readings come by events, the whole seconds near them. Gives what is to be said of it, `None` if most readings have the tag
    /// and the time of another.
    pub(in crate::csv) fn onto_one_clock(
        &mut self,
        names: &[String],
        unit: &str,
    ) -> Option<Vec<Issue>> {
        let readings: usize = self.tags.iter().map(|series| series.at.len()).sum();
        let mut issues = Vec::new();
        if self.without_place > 0 {
            let lines = count(self.without_place, "line");
            issues.push(issue(
                IssueKind::MissingTime,
                "text",
                format!("{lines} without a time or a tag; left out"),
            ));
        }
        let repeats = self.put_in_order();
        if 2 * repeats > readings {
            return None;
        }
        if repeats > 0 {
            let repeats = count(repeats as u64, "reading");
            issues.push(issue(IssueKind::DuplicateTime, "text", format!("{repeats} with the tag and the time of another; of each such time the first was kept")));
        }
        let busiest = self.tags.iter().rev().max_by_key(|series| series.at.len());
        let busiest = busiest.map_or_else(Vec::new, |series| series.at.clone());
        self.at = self.all();
        let share = 2 * self.at.len() <= 3 * busiest.len();
        let polled = self.tags.iter().filter(|series| series.is_polled()).count();
        if !share && 2 * polled > self.tags.len() {
            self.at = busiest;
            issues.extend(self.onto_the_busiest(names, unit));
        } else if !share && unit == "s" && self.at.iter().any(|at| at % SECOND != 0) {
            issues.extend(self.onto_seconds());
        }
        Some(issues)
    }

    /// Puts the readings of each tag in order, and gives how many went because another has their time.
    fn put_in_order(&mut self) -> usize {
        self.tags.iter_mut().map(Series::put_in_order).sum()
    }

    /// The stamps of all tags.
    fn all(&self) -> Vec<u64> {
        let mut all: Vec<u64> = self
            .tags
            .iter()
            .flat_map(|series| series.at.iter().copied())
            .collect();
        all.sort_unstable();
        all.dedup();
        all
    }

    /// Moves readings that come by events to whole seconds: their own times would make a clock of milliseconds.
    fn onto_seconds(&mut self) -> impl Iterator<Item = Issue> {
        let phase = self.phase();
        self.from += phase as f64 / PARTS;
        for series in &mut self.tags {
            for at in &mut series.at {
                let middle = at.saturating_add(SECOND / 2);
                *at = middle.saturating_add_signed(-phase) / SECOND * SECOND;
            }
        }
        let left = self.put_in_order();
        self.at = self.all();
        let moved =
            "readings of each tag at times of its own were moved to whole seconds".to_owned();
        let left = (left > 0).then(|| {
            let readings = count(left as u64, "reading");
            issue(
                IssueKind::Crowded,
                "text",
                format!("{readings} in the second of another of the same tag; left out"),
            )
        });
        [issue(IssueKind::Jitter, "text", moved)]
            .into_iter()
            .chain(left)
    }

    /// The part of a second at which most readings come, from half a second before whole ones to half a second behind: where they come about its half,
    /// whole ones would part them. 0 where they come at any.
    #[expect(clippy::cast_possible_truncation, reason = "half a second at the most")]
    fn phase(&self) -> i64 {
        let angle = |at: &u64| (at % SECOND) as f64 / SECOND as f64 * TAU;
        let all = self.tags.iter().flat_map(|series| &series.at);
        let (mut sine, mut cosine, mut readings) = (0.0, 0.0, 0.0);
        for (s, c) in all.map(|at| angle(at).sin_cos()) {
            sine += s;
            cosine += c;
            readings += 1.0;
        }
        let told = sine.hypot(cosine) > TOGETHER * readings;
        let angle = if told { sine.atan2(cosine) } else { 0.0 };
        (angle / TAU * SECOND as f64) as i64
    }

    /// Moves readings to the stamps of the busiest tag.
    fn onto_the_busiest(&mut self, names: &[String], unit: &str) -> impl Iterator<Item = Issue> {
        let (mut farthest, mut left, mut tags) = (0, 0, Vec::new());
        for (series, name) in self.tags.iter_mut().zip(names) {
            let before = series.at.len();
            let moved = series.move_to(&self.at);
            left += before - series.at.len();
            farthest = farthest.max(moved);
            tags.extend((moved > 0).then_some(name));
        }
        let place = tags
            .first()
            .map_or("text".to_owned(), |first| format!("tag `{first}`"));
        let others = match tags.len() {
            0 | 1 => String::new(),
            tags => format!(" and of {}", count(tags as u64 - 1, "other tag")),
        };
        let moved = (farthest > 0).then(|| {
            let by = farthest as f64 / PARTS;
            let message = format!("its readings{others} were moved to the nearest ones of the busiest tag, by up to {by} {unit}");
            issue(IssueKind::Jitter, &place, message)
        });
        let left = (left > 0).then(|| {
            let readings = count(left as u64, "reading");
            let message = format!("{readings}, those of all tags together, are not the nearest to any of the busiest tag; left out");
            issue(IssueKind::Crowded, &place, message)
        });
        moved.into_iter().chain(left)
    }

    /// # Errors
    /// [`IngestError::TooLarge`] if there are more cells than so many bytes may say.
    pub(in crate::csv) fn check(&self, bytes: usize) -> Result<(), IngestError> {
        let (stamps, tags) = (self.at.len(), self.tags.len());
        let claimed = (stamps as u64).saturating_mul(tags as u64 + 1);
        let limit = CELLS_A_BYTE * bytes as u64 + SPARE_CELLS;
        if claimed <= limit {
            return Ok(());
        }
        Err(IngestError::TooLarge {
            what: format!(
                "a table of {tags} tags at {stamps} stamps (export the tags that are needed alone)"
            ),
            claimed,
            limit,
        })
    }

    /// Whether a tag has a reading.
    pub(in crate::csv) fn has(&self, tag: usize) -> bool {
        self.tags
            .get(tag)
            .is_some_and(|series| !series.at.is_empty())
    }

    /// What the clock reads.
    pub(in crate::csv) fn stamps(&self) -> Vec<f64> {
        self.at
            .iter()
            .map(|at| self.from + *at as f64 / PARTS)
            .collect()
    }

    /// The values of each tag at the stamps, NaN where it has none.
    pub(in crate::csv) fn columns(&self) -> impl Iterator<Item = Vec<f64>> {
        self.tags.iter().map(|series| series.on(&self.at))
    }
}

impl Series {
    /// Puts the readings in order of time; of those with one stamp the first stays that has a value. Gives how many went.
    fn put_in_order(&mut self) -> usize {
        let mut order: Vec<usize> = (0..self.at.len()).collect();
        order.sort_by_key(|i| (self.at[*i], self.values[*i].is_nan()));
        order.dedup_by_key(|i| self.at[*i]);
        let repeats = self.at.len() - order.len();
        self.at = order.iter().map(|i| self.at[*i]).collect();
        self.values = order.iter().map(|i| self.values[*i]).collect();
        repeats
    }

    /// Whether it is polled: most steps are as long as the usual one, give or take a fifth; of less than a second, which whole seconds would take apart, a half.
    fn is_polled(&self) -> bool {
        let usual = median_step(&self.at);
        let off = if usual >= SECOND {
            usual / 5
        } else {
            usual / 2
        };
        let steps = self.at.windows(2).map(|pair| pair[1] - pair[0]);
        let even = steps.filter(|step| step.abs_diff(usual) <= off).count();
        self.at.len() > 2 && 5 * even >= 4 * (self.at.len() - 1)
    }

    /// The values at stamps among which are its own.
    fn on(&self, stamps: &[u64]) -> Vec<f64> {
        let mut own = self.at.iter().zip(&self.values).peekable();
        let value = |at: &u64| {
            own.next_if(|(own, _)| *own == at)
                .map_or(f64::NAN, |(_, value)| *value)
        };
        stamps.iter().map(value).collect()
    }

    /// Moves each reading to the stamp that it is nearest to, if there is one within reach, and gives the farthest move.
    fn move_to(&mut self, stamps: &[u64]) -> u64 {
        let (sources, farthest) = nearest(&self.at, stamps);
        let placed = sources.iter().enumerate();
        let placed: Vec<(usize, usize)> = placed
            .filter_map(|(stamp, source)| Some((stamp, (*source)?)))
            .collect();
        // A slow tag is the nearest of several stamps; the nearest of these has it.
        let of_each = placed.chunk_by(|(_, one), (_, next)| one == next);
        let distance =
            |(stamp, source): &&(usize, usize)| self.at[*source].abs_diff(stamps[*stamp]);
        let placed: Vec<(usize, usize)> = of_each
            .filter_map(|one| one.iter().min_by_key(distance).copied())
            .collect();
        self.values = placed
            .iter()
            .map(|(_, source)| self.values[*source])
            .collect();
        self.at = placed.iter().map(|(stamp, _)| stamps[*stamp]).collect();
        farthest
    }
}

fn issue(kind: IssueKind, place: &str, message: String) -> Issue {
    Issue {
        kind,
        place: place.to_owned(),
        message,
    }
}

#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "not below the first; beyond five centuries it saturates"
)]
fn parts(after: f64) -> u64 {
    (after * PARTS).round() as u64
}
