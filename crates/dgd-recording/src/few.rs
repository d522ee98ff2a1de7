//! Channels with a reading at few of the samples, in recordings whose channels are not read at one instant.

use crate::{Channel, Recording, Table, Well};
use rayon::prelude::*;
use std::collections::BTreeMap;

/// Where all changes are filed, so many channels tell it, in which at the most one reading in so many is equal to that a sample before. Set by hand.
pub(crate) const FEWEST_CHANNELS: usize = 3;
pub(crate) const REPEATS: usize = 1000;

/// Whether so many readings are few of so many samples: a channel that comes with every other one is not said to lack them.
pub(crate) fn are_few(readings: usize, samples: usize) -> bool {
    2 * readings < samples
}

/// Whether so many channels with few readings are enough of those that vary: the rest of one table may lack a transmitter or two.
fn are_apart(few: usize, varying: usize) -> bool {
    3 * few > varying
}

/// How many of the values are readings. Without a branch, so that the compiler can vectorise it.
pub(crate) fn count(values: &[f64]) -> usize {
    values.iter().map(|v| usize::from(v.is_finite())).sum()
}

impl Recording {
    /// Whether a channel has a reading at fewer than half of the samples: then it is worth asking how its readings come.
    pub fn has_few_readings(&self) -> bool {
        let series = self.series().into_par_iter();
        series.any(|(_, values)| are_few(count(values), values.len()))
    }

    /// The channels that have a reading at fewer than half of the samples that hold any, where these are more than a third of those that vary: they are read
    /// at instants of their own. None where they are not.
    ///
    /// ```
    /// # use dgd_recording::Recording;
    /// assert!(Recording::default().read_apart().is_empty());
    /// ```
    #[must_use]
    pub fn read_apart(&self) -> Vec<(Channel, &[f64])> {
        if !self.has_few_readings() {
            return Vec::new();
        }
        let recorded = self.recorded();
        let varies = |values: &[f64]| {
            let mut finite = values.iter().filter(|v| v.is_finite());
            let first = finite.next();
            finite.any(|v| Some(v) != first)
        };
        let varying = self.series().into_iter();
        let varying: Vec<_> = varying.filter(|(_, values)| varies(values)).collect();
        let few: Vec<(Channel, &[f64])> = (varying.iter())
            .filter(|(_, values)| are_few(count(values), recorded))
            .copied()
            .collect();
        if are_apart(few.len(), varying.len()) {
            few
        } else {
            Vec::new()
        }
    }
}

/// Tells of a table that comes in blocks whether [`Recording::join_events`] or what looks at channels that are
/// [read apart](Recording::read_apart) may have anything to do, for which the recording must be whole.
///
/// Memory: a few numbers a channel. It tells of rows what those tell of the even clock, so that it errs where rows lie far apart.
///
/// ```
/// # use dgd_recording::ReadingSurvey;
/// assert!(!ReadingSurvey::default().may_be_joined());
/// ```
#[derive(Debug, Default)]
pub struct ReadingSurvey {
    rows: usize,
    channels: BTreeMap<String, Readings>,
}

#[derive(Debug, Default)]
struct Readings {
    count: usize,
    first: Option<f64>,
    /// Whether one differs from the first.
    varies: bool,
    /// The value in the last row.
    last: Option<f64>,
    /// Rows that repeat the value of the one before.
    repeats: usize,
}

impl ReadingSurvey {
    /// Takes the next block; columns that `well` does not name are passed over.
    pub fn add(&mut self, block: &Table, well: &Well) {
        self.rows += block.rows();
        for (_, tag) in well.channels.tags() {
            let Some(column) = block.column(tag) else {
                continue;
            };
            let channel = self.channels.entry(tag.to_owned()).or_default();
            column.values.iter().for_each(|value| channel.add(*value));
        }
    }

    /// Whether channels may be read apart, or filed by events.
    #[must_use]
    pub fn may_be_joined(&self) -> bool {
        let varying = || self.channels.values().filter(|channel| channel.varies);
        let few = varying().filter(|channel| are_few(channel.count, self.rows));
        let few = few.count();
        let filed = || varying().filter(|channel| channel.count < self.rows);
        let readings: usize = filed().map(|channel| channel.count).sum();
        let repeats: usize = filed().map(|channel| channel.repeats).sum();
        let may_be_changes = filed().count() >= FEWEST_CHANNELS && REPEATS * repeats < readings;
        are_apart(few, varying().count()) || (few > 0 && may_be_changes)
    }
}

impl Readings {
    fn add(&mut self, value: f64) {
        let before = self.last.replace(value);
        if value.is_finite() {
            let first = *self.first.get_or_insert(value);
            self.varies |= value != first;
            self.count += 1;
            self.repeats += usize::from(before == Some(value));
        }
    }
}
