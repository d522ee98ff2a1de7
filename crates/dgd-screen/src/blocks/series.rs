//! What the first two passes gather of one channel.

use crate::screening::Rules;
use crate::stuck::{self, Beside, Held, NEIGHBOURHOOD, NEXT, Rest, StuckRule};
use crate::{scan, scan::Steps};
use dgd_recording::{Channel, Run};
use std::collections::{BTreeMap, HashMap};

/// What is known of a channel.
#[derive(Debug, Clone)]
pub(super) struct Known {
    pub(super) channel: Channel,
    pub(super) steps: Steps,
    /// Fewest equal samples that are no chance.
    shortest: usize,
    /// Share of honest repeats.
    share: f64,
    /// Stuck runs, known after the second pass.
    pub(super) runs: Vec<Run>,
}

/// The first pass: steps, repeats, and how long runs of one value are.
#[derive(Debug, Clone, Default)]
pub(super) struct StepPass {
    taken: usize,
    last: f64,
    /// Steps at every so many samples.
    steps: Vec<f64>,
    equal: usize,
    pairs: usize,
    run: Option<Held>,
    /// Runs of at least three values, and the repeats in them, by their length: of the many lengths there cannot be many runs, so the list is short.
    lengths: BTreeMap<usize, (usize, usize)>,
}

impl StepPass {
    /// - `gap`: so many missing samples in a row do not end a run.
    pub(super) fn add(&mut self, values: &[f64], samples: usize, gap: usize) {
        let stride = scan::stride(samples);
        let mut rest = values.iter();
        if self.taken == 0
            && let Some(first) = rest.next()
        {
            (self.last, self.run, self.taken) = (*first, Some(Held::at(0, *first)), 1);
        }
        for v in rest {
            let step = v - self.last;
            if (self.taken - 1).is_multiple_of(stride) && step.is_finite() {
                self.steps.push(step.abs());
            }
            self.equal += usize::from(step == 0.0);
            self.pairs += usize::from(step.is_finite());
            if !self.run.as_mut().is_some_and(|run| run.goes_on(*v, gap)) {
                let ended = self.run.replace(Held::at(self.taken, *v));
                self.count(ended);
            }
            self.last = *v;
            self.taken += 1;
        }
    }

    fn count(&mut self, ended: Option<Held>) {
        if let Some(run) = ended.filter(|run| run.told > 2) {
            let alike = self.lengths.entry(run.told).or_default();
            alike.0 += 1;
            alike.1 += run.repeats();
        }
    }

    pub(super) fn known(mut self, channel: Channel, rules: Rules<'_>) -> Known {
        let ended = self.run.take();
        self.count(ended);
        let lengths = &self.lengths;
        let (shortest, share) =
            stuck::settle((self.equal, self.pairs), rules.stuck(channel), |least| {
                let long = lengths.range(least..);
                long.fold((0, 0), |(runs, repeats), (_, alike)| {
                    (runs + alike.0, repeats + alike.1)
                })
            });
        Known {
            channel,
            steps: Steps::of(self.steps),
            shortest,
            share,
            runs: Vec::new(),
        }
    }
}

/// Repeats and pairs of finite neighbours from the first sample up to one.
type Count = (usize, usize);

/// The second pass: runs that are too long for the channel.
#[derive(Debug, Clone, Default)]
pub(super) struct RunPass {
    count: Count,
    last: f64,
    /// The samples before the next one, nearest first.
    nearest: [f64; NEXT],
    /// So many of the samples behind the last run found are still to come.
    behind: usize,
    /// Counts at the latest samples.
    latest: Vec<Count>,
    open: Option<Open>,
    found: Vec<Found>,
    /// So many of those found have the count behind them.
    counted: usize,
}

/// A run that goes on.
#[derive(Debug, Clone, Copy)]
struct Open {
    held: Held,
    /// The samples before it, nearest first.
    before_it: [f64; NEXT],
    /// Samples at which the pump turns, up to its last value and since then.
    turning: usize,
    since: usize,
    before: Count,
    neighbourhood: Count,
}

/// A run, and what is counted up to the ends of itself and of its neighbourhood.
#[derive(Debug, Clone, Copy)]
struct Found {
    held: Held,
    beside: Beside,
    /// Up to the first sample of the neighbourhood, the last before the run, the first after it, the last of the neighbourhood.
    counts: [Count; 4],
}

impl Found {
    /// The first sample after it.
    fn end(&self) -> usize {
        self.held.run.start + self.held.run.length
    }
}

/// A power of two that is more than a neighbourhood.
const LATEST: usize = (NEIGHBOURHOOD + 1).next_power_of_two();

impl RunPass {
    /// - `from`: index of the first value.
    /// - `speed_pct`: of the same samples.
    pub(super) fn add(
        &mut self,
        from: usize,
        values: &[f64],
        speed_pct: &[f64],
        known: &Known,
        rules: Rules<'_>,
    ) {
        self.latest.resize(LATEST, (0, 0));
        let (on, gap) = (rules.options.pump_on_above_pct, rules.gap());
        for (i, (v, w)) in (from..).zip(values.iter().zip(speed_pct)) {
            let before = self.count;
            if i > 0 {
                let step = v - self.last;
                self.count.0 += usize::from(step == 0.0);
                self.count.1 += usize::from(step.is_finite());
            }
            while let Some(found) = self.found.get_mut(self.counted)
                && found.end() + NEIGHBOURHOOD <= i + 1
            {
                found.counts[3] = self.count;
                self.counted += 1;
            }
            let turning = usize::from(*w > on);
            let open = self.open.as_mut();
            if let Some(open) = open.and_then(|open| open.held.goes_on(*v, gap).then_some(open)) {
                open.since += turning;
                if open.held.is_told() {
                    open.turning += std::mem::take(&mut open.since);
                }
            } else {
                self.end_run(None, known, rules);
                let first = i.saturating_sub(NEIGHBOURHOOD);
                self.open = Some(Open {
                    held: Held::at(i, *v),
                    before_it: std::array::from_fn(
                        |k| if i > k { self.nearest[k] } else { f64::NAN },
                    ),
                    turning,
                    since: 0,
                    before,
                    neighbourhood: self.latest[first % LATEST],
                });
            }
            self.latest[i % LATEST] = self.count;
            self.last = *v;
            self.nearest.rotate_right(1);
            self.nearest[0] = *v;
            if let Some(found) = self.found.last_mut()
                && self.behind > 0
            {
                found.beside.behind[NEXT - self.behind] = *v;
                self.behind -= 1;
            }
        }
    }

    /// - `samples`: of the recording, if that is where the run ends.
    fn end_run(&mut self, samples: Option<usize>, known: &Known, rules: Rules<'_>) {
        let Some(open) = self.open.take() else {
            return;
        };
        let run = open.held.run;
        if open.held.told < known.shortest || !run.value.is_finite() {
            return;
        }
        let rest = Rest {
            value: run.value,
            whole: samples == Some(run.length),
            shortest: known.shortest,
        };
        if !rules.is_honest(known.channel, known.steps, rest, || open.turning) {
            self.found.push(Found {
                held: open.held,
                beside: Beside {
                    before: open.before_it,
                    behind: [f64::NAN; NEXT],
                },
                counts: [open.neighbourhood, open.before, self.count, (0, 0)],
            });
            // Where samples are missing behind it, the first of them has been.
            self.behind = if open.held.is_told() { NEXT } else { 0 };
        }
    }

    /// The stuck runs, once all samples have come.
    pub(super) fn stuck(mut self, samples: usize, known: &Known, rules: Rules<'_>) -> Vec<Run> {
        self.end_run(Some(samples), known, rules);
        for found in &mut self.found[self.counted..] {
            found.counts[3] = self.count;
        }
        let mut counts: HashMap<usize, Count> = HashMap::new();
        for found in &self.found {
            let (start, end, known) = (found.held.run.start, found.end(), &found.counts);
            let places = [
                Some(start.saturating_sub(NEIGHBOURHOOD)),
                start.checked_sub(1),
                Some(end),
                (end + NEIGHBOURHOOD).min(samples).checked_sub(1),
            ];
            let places = places.into_iter().zip(known);
            counts.extend(places.filter_map(|(place, count)| Some((place?, *count))));
        }
        let upto = |place: usize| counts.get(&place).copied().unwrap_or_default();
        let mut runs: Vec<Held> = self.found.iter().map(|f| f.held).collect();
        let rule: StuckRule = rules.stuck(known.channel);
        stuck::judge_locally(&mut runs, samples, known.share, rule, |start, end| {
            let (from, to) = (upto(start), upto(end - 1));
            (to.0 - from.0, to.1 - from.1)
        });
        let runs = runs.into_iter().map(|held| held.run).collect();
        let pairs = self.count.1;
        rules.unless_rates(known.channel, runs, pairs, known.steps, |run| {
            let start = |found: &Found| found.held.run.start;
            let at = self.found.partition_point(|found| start(found) < run.start);
            self.found[at].beside
        })
    }
}
