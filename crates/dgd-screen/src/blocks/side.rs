//! The transmitters of one pump side: how they differ slowly, and where for a short while.

use super::series::Known;
use super::window::Window;
use crate::redundant::{self, BESIDE, DisagreeRule, RESPITE, Slow};
use crate::scan;
use crate::screening::Rules;
use std::ops::Range;

/// One side of the pump.
#[derive(Debug, Default)]
pub(super) struct Side {
    /// Its transmitters' places among the channels.
    members: Vec<usize>,
    rule: Option<DisagreeRule>,
    differences: Vec<Difference>,
    /// Stretches in which a transmitter disagrees, as far as they are not settled.
    marks: Vec<(usize, Range<usize>)>,
}

/// A difference of transmitters.
#[derive(Debug, Default)]
struct Difference {
    /// Medians of the blocks so far.
    rough: Vec<f64>,
    /// Differences of the medians of those without.
    of_medians: Vec<f64>,
    /// Values at every so many samples.
    some: Vec<f64>,
    slow: Option<Slow>,
    /// Distance from the slow median that is a disagreement; `None` if none is.
    least: Option<f64>,
    search: Search,
}

/// Where the difference leaves its slow median.
#[derive(Debug, Default)]
struct Search {
    /// The next sample to look at.
    next: usize,
    /// A stretch that may go on.
    open: Option<Range<usize>>,
    /// Stretches that are not judged yet.
    waiting: Vec<Range<usize>>,
}

impl Side {
    pub(super) fn of(members: Vec<usize>) -> Self {
        let differences = redundant::differences(members.len());
        Self {
            members,
            differences: (0..differences).map(|_| Difference::default()).collect(),
            ..Self::default()
        }
    }

    pub(super) fn begin(&mut self, known: &[Known], rules: Rules<'_>) {
        let quanta = self.members.iter().map(|n| known[*n].steps.quantum);
        self.rule = Some(rules.disagree(quanta.fold(0.0, f64::max)));
    }

    /// Whether there are transmitters that can disagree.
    pub(super) fn differs(&self) -> bool {
        !self.differences.is_empty()
    }

    pub(super) fn rewind(&mut self) {
        self.marks.clear();
        for difference in &mut self.differences {
            difference.search = Search::default();
        }
    }

    fn block(&self) -> usize {
        self.rule.map_or(1, |rule| rule.block.max(1))
    }

    /// First sample of the next block of the slow median.
    pub(super) fn next_block(&self) -> usize {
        let blocks = self.differences.iter().map(|d| d.rough.len());
        blocks.min().map_or(usize::MAX, |k| k * self.block())
    }

    /// Gathers what the slow medians are taken from, of the samples before `to`.
    pub(super) fn add_slow(&mut self, window: &Window, to: usize, samples: usize, at_end: bool) {
        let block = self.block();
        let (start, series, faults) = window.of(&self.members);
        for (n, it) in self.differences.iter_mut().enumerate() {
            let difference = |i: usize| redundant::difference(&series, &faults, n, i - start);
            loop {
                let from = it.rough.len() * block;
                let end = (from + block).min(samples);
                if from >= samples || end > to {
                    break;
                }
                let rough = Slow::rough(from..end, block, difference);
                // Of use only where no block has any.
                it.of_medians.push(if rough.is_nan() {
                    Slow::of_medians(&series, &faults, from - start..end - start)
                } else {
                    f64::NAN
                });
                it.rough.push(rough);
            }
            // No further than the blocks have come: what lies behind is kept.
            let reached = if at_end {
                samples
            } else {
                it.rough.len() * block
            };
            let stride = scan::stride(samples);
            while it.some.len() * stride < reached {
                it.some.push(difference(it.some.len() * stride));
            }
        }
    }

    /// Ends the pass over what [`Self::add_slow`] was given.
    pub(super) fn know_slow(&mut self, samples: usize) {
        let (block, rule) = (self.block(), self.rule);
        let stride = scan::stride(samples);
        for it in &mut self.differences {
            let rough = std::mem::take(&mut it.rough);
            let of_medians = std::mem::take(&mut it.of_medians);
            it.slow = Slow::smooth(rough, block).or_else(|| Slow::read_apart(of_medians, block));
            let some = std::mem::take(&mut it.some);
            it.least = it.slow.as_ref().zip(rule).and_then(|(slow, rule)| {
                let off = some.iter().enumerate();
                let off = off.map(|(k, d)| (d - slow.at(k * stride)).abs());
                redundant::least(off.collect(), rule)
            });
        }
    }

    /// Looks at the differences before `to` and judges the stretches behind which enough has come.
    pub(super) fn find_disagreement(
        &mut self,
        window: &Window,
        to: usize,
        samples: usize,
        at_end: bool,
    ) {
        let longest = self.longest();
        let (start, series, faults) = window.of(&self.members);
        for (n, it) in self.differences.iter_mut().enumerate() {
            let difference = |i: usize| redundant::difference(&series, &faults, n, i);
            let (Some(slow), Some(least)) = (&it.slow, it.least) else {
                continue;
            };
            let search = &mut it.search;
            for i in search.next..to {
                if (difference(i - start) - slow.at(i)).abs() > least {
                    let ended = redundant::go_on(&mut search.open, i);
                    search.waiting.extend(ended);
                }
            }
            search.next = search.next.max(to);
            if at_end
                || search
                    .open
                    .as_ref()
                    .is_some_and(|last| to > last.end + RESPITE)
            {
                search.waiting.extend(search.open.take());
            }
            search.waiting.retain(|range| {
                if range.len() > longest {
                    return false;
                }
                if !at_end && range.end + BESIDE > to {
                    return true;
                }
                let here = range.start - start..range.end - start;
                if redundant::returns(&here, samples - start, longest, difference) {
                    let blamed = redundant::blamed(&series, n, &here);
                    let blamed = blamed.into_iter().map(|n| self.members[n]);
                    self.marks.extend(blamed.map(|n| (n, range.clone())));
                }
                false
            });
        }
    }

    fn longest(&self) -> usize {
        self.rule.map_or(0, |rule| rule.longest)
    }

    /// The first sample before `to` that may yet be found to disagree.
    pub(super) fn undecided(&self, to: usize) -> usize {
        let longest = self.longest();
        let searches = self.differences.iter().map(|d| &d.search);
        let open = searches.flat_map(|s| s.open.iter().chain(&s.waiting));
        let short = open.filter(|range| range.len() <= longest);
        short.map(|range| range.start).fold(to, usize::min)
    }

    /// The first sample that is still to be looked at.
    pub(super) fn needed(&self, to: usize) -> usize {
        self.undecided(to).saturating_sub(BESIDE)
    }

    /// The stretches in which transmitters disagree, that begin before a sample; forgets those that end before it too.
    pub(super) fn marks(&mut self, to: usize) -> Vec<(usize, Range<usize>)> {
        let begun = self.marks.iter().filter(|(_, range)| range.start < to);
        let begun = begun.cloned().collect();
        self.marks.retain(|(_, range)| range.end > to);
        begun
    }

    /// Mean of the trusted transmitters over settled samples.
    pub(super) fn means(&self, window: &Window, range: Range<usize>) -> Vec<f64> {
        let (series, faults) = window.stretch(&self.members, &range);
        // Only of two is the slow difference taken off.
        let slow = match &self.differences[..] {
            [only] => only.slow.as_ref(),
            _ => None,
        };
        redundant::trusted_mean(&series, &faults, slow, range)
    }
}
