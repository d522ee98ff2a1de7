//! What the first two passes gather of one channel.

use crate::screening::Rules;
use crate::stuck::{self, NEIGHBOURHOOD, StuckRule};
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
    run: usize,
    /// Runs of at least three values, by their length: of the many lengths there cannot be many runs, so the list is short.
    lengths: BTreeMap<usize, usize>,
}

impl StepPass {
    pub(super) fn add(&mut self, values: &[f64], samples: usize) {
        let stride = scan::stride(samples);
        let mut rest = values.iter();
        if self.taken == 0
            && let Some(first) = rest.next()
        {
            (self.last, self.run, self.taken) = (*first, 1, 1);
        }
        for v in rest {
            let step = v - self.last;
            if (self.taken - 1).is_multiple_of(stride) && step.is_finite() {
                self.steps.push(step.abs());
            }
            self.equal += usize::from(step == 0.0);
            self.pairs += usize::from(step.is_finite());
            if step == 0.0 {
                self.run += 1;
            } else {
                self.end_run();
            }
            self.last = *v;
            self.taken += 1;
        }
    }

    fn end_run(&mut self) {
        if self.run > 2 {
            *self.lengths.entry(self.run).or_default() += 1;
        }
        self.run = 1;
    }

    pub(super) fn known(mut self, channel: Channel, rules: Rules<'_>) -> Known {
        self.end_run();
        let lengths = &self.lengths;
        let (shortest, share) =
            stuck::settle((self.equal, self.pairs), rules.stuck(channel), |least| {
                let long = lengths.range(least..);
                long.fold((0, 0), |(runs, repeats), (length, count)| {
                    (runs + count, repeats + count * (length - 1))
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
    run: Run,
    /// Samples at which the pump turns.
    turning: usize,
    before: Count,
    neighbourhood: Count,
}

/// A run, and what is counted up to the ends of itself and of its neighbourhood.
#[derive(Debug, Clone, Copy)]
struct Found {
    run: Run,
    /// Up to the first sample of the neighbourhood, the last before the run, the first after it, the last of the neighbourhood.
    counts: [Count; 4],
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
        let on = rules.options.pump_on_above_pct;
        for (i, (v, w)) in (from..).zip(values.iter().zip(speed_pct)) {
            let before = self.count;
            if i > 0 {
                let step = v - self.last;
                self.count.0 += usize::from(step == 0.0);
                self.count.1 += usize::from(step.is_finite());
            }
            while let Some(found) = self.found.get_mut(self.counted)
                && found.run.start + found.run.length + NEIGHBOURHOOD <= i + 1
            {
                found.counts[3] = self.count;
                self.counted += 1;
            }
            let turning = usize::from(*w > on);
            match &mut self.open {
                Some(open) if open.run.value == *v => {
                    open.run.length += 1;
                    open.turning += turning;
                }
                _ => {
                    self.end_run(None, known, rules);
                    let first = i.saturating_sub(NEIGHBOURHOOD);
                    self.open = Some(Open {
                        run: Run {
                            start: i,
                            length: 1,
                            value: *v,
                        },
                        turning,
                        before,
                        neighbourhood: self.latest[first % LATEST],
                    });
                }
            }
            self.latest[i % LATEST] = self.count;
            self.last = *v;
        }
    }

    /// - `samples`: of the recording, if that is where the run ends.
    fn end_run(&mut self, samples: Option<usize>, known: &Known, rules: Rules<'_>) {
        let Some(open) = self.open.take() else {
            return;
        };
        let run = open.run;
        if run.length < known.shortest || !run.value.is_finite() {
            return;
        }
        let whole = samples == Some(run.length);
        let (quantum, turning) = (known.steps.quantum, || open.turning);
        if !rules.is_honest(
            known.channel,
            run.value,
            quantum,
            whole,
            turning,
            known.shortest,
        ) {
            self.found.push(Found {
                run,
                counts: [open.neighbourhood, open.before, self.count, (0, 0)],
            });
        }
    }

    /// The stuck runs, once all samples have come.
    pub(super) fn stuck(mut self, samples: usize, known: &Known, rules: Rules<'_>) -> Vec<Run> {
        self.end_run(Some(samples), known, rules);
        for found in &mut self.found[self.counted..] {
            found.counts[3] = self.count;
        }
        let mut counts: HashMap<usize, Count> = HashMap::new();
        for Found { run, counts: known } in &self.found {
            let end = run.start + run.length;
            let places = [
                Some(run.start.saturating_sub(NEIGHBOURHOOD)),
                run.start.checked_sub(1),
                Some(end),
                (end + NEIGHBOURHOOD).min(samples).checked_sub(1),
            ];
            let places = places.into_iter().zip(known);
            counts.extend(places.filter_map(|(place, count)| Some((place?, *count))));
        }
        let upto = |place: usize| counts.get(&place).copied().unwrap_or_default();
        let mut runs: Vec<Run> = self.found.iter().map(|f| f.run).collect();
        let rule: StuckRule = rules.stuck(known.channel);
        stuck::judge_locally(&mut runs, samples, known.share, rule, |start, end| {
            let (from, to) = (upto(start), upto(end - 1));
            (to.0 - from.0, to.1 - from.1)
        });
        runs
    }
}
