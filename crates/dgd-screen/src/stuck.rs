//! Stuck runs: one value repeated for longer than the channel repeats by chance.
//!
//! A run goes on over samples that are missing: a frozen transmitter stays frozen where a logger drops some of its values.

use crate::scan::{Scan, Steps, repeats};
use dgd_recording::Run;
use std::ops::Range;

/// What makes a run of equal values a stuck one.
#[derive(Debug, Clone, Copy)]
pub(crate) struct StuckRule {
    /// Never fewer samples than this.
    pub(crate) floor: usize,
    /// Chance of an honest run of the length, at a given sample.
    pub(crate) chance: f64,
    /// So many missing samples in a row do not end a run.
    pub(crate) gap: usize,
}

/// A run of equal values, missing ones among them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Held {
    /// From the first equal value to the last.
    pub(crate) run: Run,
    /// How many equal values it has.
    pub(crate) told: usize,
    /// How many times values are missing between them.
    pub(crate) gaps: usize,
    /// Samples that have been missing since the last of them.
    missing: usize,
}

impl Held {
    /// A run that begins with a value.
    pub(crate) fn at(start: usize, value: f64) -> Self {
        Self::of(start, 1, value)
    }

    /// A run of which no value is missing.
    fn of(start: usize, length: usize, value: f64) -> Self {
        Self {
            run: Run {
                start,
                length,
                value,
            },
            told: length,
            gaps: 0,
            missing: 0,
        }
    }

    /// Takes the next sample in; says whether it still may be the same run.
    pub(crate) fn goes_on(&mut self, value: f64, gap: usize) -> bool {
        if value == self.run.value && value.is_finite() {
            self.run.length += self.missing + 1;
            self.told += 1;
            self.gaps += usize::from(self.missing > 0);
            self.missing = 0;
            return true;
        }
        if value.is_nan() && self.run.value.is_finite() && self.missing < gap {
            self.missing += 1;
            return true;
        }
        false
    }

    /// Whether the sample that was last taken in is one of its own.
    pub(crate) fn is_told(&self) -> bool {
        self.missing == 0
    }

    /// Samples in it that repeat their predecessor.
    pub(crate) fn repeats(&self) -> usize {
        self.told - 1 - self.gaps
    }
}

/// Stuck runs and the statistics they were judged by.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Stuck {
    pub(crate) runs: Vec<Run>,
    pub(crate) shortest: usize,
    pub(crate) repeat_share: f64,
}

/// Samples on either side of a run that tell how often the channel repeats there.
pub(crate) const NEIGHBOURHOOD: usize = 300;
/// Weight of the whole recording's share against the neighbourhood's, samples.
const PRIOR: f64 = 30.0;
/// Long runs that are more than this share of all runs are how the channel always is: it
/// is updated slowly, or its quantum is coarse against its noise.
const HABIT: f64 = 0.01;
/// So few runs are no habit.
const FEW: usize = 10;
/// A share of 1 would make every run honest.
const MOST_SHARE: f64 = 0.999;

/// A run of one value that may be stuck.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Rest {
    pub(crate) value: f64,
    /// It is the whole series.
    pub(crate) whole: bool,
    /// Fewest equal samples that are no chance.
    pub(crate) shortest: usize,
}

/// The samples on either side of a run, nearest first; NaN where there is none.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Beside {
    pub(crate) before: [f64; NEXT],
    pub(crate) behind: [f64; NEXT],
}

/// So many samples on a side tell a ramp.
pub(crate) const NEXT: usize = 3;

impl Beside {
    pub(crate) fn of(run: &Run, values: &[f64]) -> Self {
        let at = |i: Option<usize>| i.and_then(|i| values.get(i)).copied().unwrap_or(f64::NAN);
        Self {
            before: std::array::from_fn(|k| at(run.start.checked_sub(k + 1))),
            behind: std::array::from_fn(|k| at(Some(run.start + run.length + k))),
        }
    }

    /// Whether a run of this value is a rate that held, as a counter tells it that repeats most of its counts: it moves on to the next one, or
    /// along a ramp, and what froze has gone anywhere meanwhile. Where it goes on to the end or to a gap, nothing tells.
    pub(crate) fn is_counted(self, value: f64, steps: Steps) -> bool {
        /// More than one count, and less than two.
        const COUNTS: f64 = 1.5;
        /// Fewer movements tell no count.
        const FEWEST: usize = 20;
        let goes_on = |[first, second, third]: [f64; NEXT]| {
            let next = (first - value).abs() <= COUNTS * steps.quantum;
            let rises = first > value && second > first && third > second;
            let falls = first < value && second < first && third < second;
            next || rises || falls
        };
        let counts = steps.noise == 0.0 && steps.moves >= FEWEST;
        // A meter freezes at what it reads: a run may begin with the recording.
        let comes_on = self.before[0].is_nan() || goes_on(self.before);
        counts && comes_on && goes_on(self.behind)
    }
}

/// Finds stuck runs. `honest` says of a run, and of the fewest equal samples that are no chance,
/// that its quantity may well be constant (a flow of zero); it is not stuck.
///
/// Under a share `p` of honest repeats, a run of `m` equal samples begins at a given
/// sample with chance `p^(m-1)`. The share is counted outside runs that are too long
/// already (unless those are many), and again when that moved the limit; a run must pass by the share of its
/// own neighbourhood too, because a quiet stretch repeats more.
pub(crate) fn find(
    values: &[f64],
    scan: &Scan,
    rule: StuckRule,
    honest: impl Fn(&Run, usize) -> bool,
) -> Stuck {
    let mut found: Option<Vec<Held>> = None;
    let complete = scan.pairs + 1 >= values.len();
    let (shortest, share) = settle((scan.equal, scan.pairs), rule, |least| {
        // What is asked for only grows: the runs are looked for once.
        let runs = found.get_or_insert_with(|| long_runs(values, complete, least, rule.gap));
        runs.retain(|held| held.told >= least);
        (runs.len(), runs.iter().map(Held::repeats).sum())
    });
    let mut runs = found.unwrap_or_default();
    runs.retain(|held| held.told >= shortest && !honest(&held.run, shortest));
    judge_locally(&mut runs, values.len(), share, rule, |start, end| {
        repeats(&values[start..end])
    });
    Stuck {
        runs: runs.into_iter().map(|held| held.run).collect(),
        shortest,
        repeat_share: share,
    }
}

/// The fewest equal samples that are no chance, and the share of honest repeats.
///
/// `long` tells how many runs there are of at least so many samples, and how many repeats in them.
pub(crate) fn settle(
    (equal, pairs): (usize, usize),
    rule: StuckRule,
    mut long: impl FnMut(usize) -> (usize, usize),
) -> (usize, f64) {
    let mut shortest = rule.floor.max(3);
    let mut share = 0.0;
    // Each turn can only lengthen the limit; a few turns settle it.
    for _ in 0..6 {
        let (runs, repeats) = long(shortest);
        let habit = runs > FEW && runs as f64 > HABIT * (pairs - equal) as f64;
        let in_runs = if habit { 0 } else { repeats };
        share = (equal - in_runs) as f64 / (pairs - in_runs).max(1) as f64;
        let wanted = limit(share, rule);
        if wanted <= shortest {
            break;
        }
        shortest = wanted;
    }
    (shortest, share)
}

/// Keeps the runs that are too long for their own neighbourhood as well; `repeats` counts in a range of samples.
pub(crate) fn judge_locally(
    runs: &mut Vec<Held>,
    samples: usize,
    share: f64,
    rule: StuckRule,
    mut repeats: impl FnMut(usize, usize) -> (usize, usize),
) {
    let passed: Vec<bool> = runs
        .iter()
        .map(|held| {
            let local = local_share(samples, runs, &held.run, share, &mut repeats);
            held.told >= limit(local, rule)
        })
        .collect();
    let mut passed = passed.iter();
    runs.retain(|_| passed.next().copied().unwrap_or(false));
}

/// Fewest equal samples less likely than the rule's chance at this share of repeats.
fn limit(share: f64, rule: StuckRule) -> usize {
    let share = share.clamp(1e-9, MOST_SHARE);
    let most = 1.0 + rule.chance.ln() / share.ln();
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "between 1 and a few thousand times the logarithm of the chance"
    )]
    let samples = most.ceil() as usize;
    samples.max(rule.floor).max(3)
}

/// Share of repeats around a run, stuck runs left out, drawn towards the whole's.
fn local_share(
    samples: usize,
    runs: &[Held],
    run: &Run,
    share: f64,
    repeats: &mut impl FnMut(usize, usize) -> (usize, usize),
) -> f64 {
    let end = run.start + run.length;
    let from = run.start.saturating_sub(NEIGHBOURHOOD);
    let to = (end + NEIGHBOURHOOD).min(samples);
    let (mut equal, mut pairs) = (0usize, 0usize);
    let mut count = |start: usize, end: usize| {
        if end > start {
            let (e, p) = repeats(start, end);
            (equal, pairs) = (equal + e, pairs + p);
        }
    };
    // The other runs are cut out of both sides.
    for (mut start, end) in [(from, run.start), (end, to)] {
        let all = runs.iter().map(|held| held.run);
        let first = runs.partition_point(|held| held.run.start + held.run.length <= start);
        for other in all.skip(first).take_while(|r| r.start < end) {
            count(start, other.start);
            start = (other.start + other.length).min(end);
        }
        count(start, end);
    }
    ((equal as f64 + PRIOR * share) / (pairs as f64 + PRIOR)).max(share)
}

/// Runs of at least `least` (2 or more) equal values, of which so many in a row may be missing.
///
/// - `complete`: none is missing.
pub(crate) fn long_runs(values: &[f64], complete: bool, least: usize, gap: usize) -> Vec<Held> {
    if complete {
        striding(values, least)
    } else {
        over_gaps(values, least, gap)
    }
}

/// Whole stretches by strides; what holds at their ends may go on beyond what is missing.
fn over_gaps(values: &[f64], least: usize, gap: usize) -> Vec<Held> {
    let least = least.max(2);
    let mut runs = Vec::new();
    let keep = |held: Held, runs: &mut Vec<Held>| {
        if held.told >= least && held.run.value.is_finite() {
            runs.push(held);
        }
    };
    // The run at the end of the stretch before.
    let mut open: Option<Held> = None;
    for stretch in stretches(values) {
        let (start, end) = (stretch.start, stretch.end);
        let part = &values[stretch];
        let (first, last) = (part[0], part[part.len() - 1]);
        let head = part.iter().take_while(|v| **v == first).count();
        let continues = |before: &Held| {
            let apart = start - (before.run.start + before.run.length);
            before.run.value == first && first.is_finite() && apart <= gap
        };
        let held = match open.take() {
            Some(mut before) if continues(&before) => {
                before.told += head;
                before.gaps += 1;
                before.run.length = start + head - before.run.start;
                before
            }
            before => {
                before.into_iter().for_each(|held| keep(held, &mut runs));
                Held::of(start, head, first)
            }
        };
        if head == part.len() {
            open = Some(held);
            continue;
        }
        keep(held, &mut runs);
        let tail = part.iter().rev().take_while(|v| **v == last).count();
        let inside = striding(&part[head..part.len() - tail], least);
        runs.extend(inside.into_iter().map(|mut held| {
            held.run.start += start + head;
            held
        }));
        open = Some(Held::of(end - tail, tail, last));
    }
    open.into_iter().for_each(|held| keep(held, &mut runs));
    runs
}

/// The longest stretches of which no value is missing.
fn stretches(values: &[f64]) -> impl Iterator<Item = Range<usize>> {
    /// Values looked at together: without an early exit the compiler can vectorise.
    const TOGETHER: usize = 64;
    let whole = |part: &[f64]| part.iter().map(|v| u64::from(v.is_nan())).sum::<u64>() == 0;
    let mut at = 0;
    std::iter::from_fn(move || {
        at += values[at..].iter().position(|v| !v.is_nan())?;
        let start = at;
        while values[at..]
            .chunks_exact(TOGETHER)
            .next()
            .is_some_and(whole)
        {
            at += TOGETHER;
        }
        let rest = &values[at..];
        at += rest.iter().position(|v| v.is_nan()).unwrap_or(rest.len());
        Some(start..at)
    })
}

/// Where no value is missing a run that long covers two
/// neighbours at one of every `least - 1` samples, so only those are looked at.
fn striding(values: &[f64], least: usize) -> Vec<Held> {
    let least = least.max(2);
    let mut runs = Vec::new();
    let mut at = least - 1;
    while at < values.len() {
        let value = values[at];
        let mut next = at + least - 1;
        // The run, if there is one, holds `at` and the sample before it.
        if values[at - 1] == value && value.is_finite() {
            let start = values[..at]
                .iter()
                .rposition(|v| *v != value)
                .map_or(0, |i| i + 1);
            let end = values[at..]
                .iter()
                .position(|v| *v != value)
                .map_or(values.len(), |i| at + i);
            if end - start >= least {
                runs.push(Held::of(start, end - start, value));
            }
            next = next.max(end + least - 1);
        }
        at = next;
    }
    runs
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn striding_finds_the_same_runs_as_looking_at_every_sample() {
        let mut state = 1u64;
        let values: Vec<f64> = (0..20_000)
            .map(|_| {
                state = state
                    .wrapping_mul(6_364_136_223_846_793_005)
                    .wrapping_add(1_442_695_040_888_963_407);
                f64::from(u8::from(state >> 62 != 0))
            })
            .collect();
        for least in 2..12 {
            let mut start = 0;
            let every = values.chunk_by(|a, b| a == b).map(|equal| {
                let (length, value) = (equal.len(), equal[0]);
                start += length;
                Run {
                    start: start - length,
                    length,
                    value,
                }
            });
            let slow: Vec<Run> = every.filter(|run| run.length >= least).collect();
            let runs = |of: Vec<Held>| of.into_iter().map(|held| held.run).collect::<Vec<_>>();
            assert_eq!(runs(striding(&values, least)), slow, "least {least}");
            assert_eq!(runs(over_gaps(&values, least, 3)), slow, "least {least}");
        }
    }

    /// Runs by [`Held::goes_on`], sample by sample, as in blocks.
    fn sample_by_sample(values: &[f64], least: usize, gap: usize) -> Vec<Held> {
        let mut runs = Vec::new();
        let mut start = 0;
        while let Some(value) = values.get(start) {
            let mut held = Held::at(start, *value);
            let after = &values[start + 1..];
            let end = after.iter().position(|v| !held.goes_on(*v, gap));
            runs.extend((held.told >= least).then_some(held));
            start = end.map_or(values.len(), |end| start + 1 + end);
        }
        runs
    }

    #[test]
    fn stretches_by_strides_find_the_same_runs_over_gaps_as_sample_by_sample() {
        let mut state = 3u64;
        let mut random = |of: u64| {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (state >> 33) % of
        };
        let mut value = 1.0;
        let values: Vec<f64> = (0..30_000)
            .map(|_| match random(64) {
                0..4 => f64::NAN,
                4 => f64::INFINITY,
                5..20 => {
                    value = random(3) as f64;
                    value
                }
                _ => value,
            })
            .collect();
        let of = |held: Held| (held.run, held.told, held.gaps);
        for (least, gap) in [(2, 0), (2, 1), (3, 2), (5, 3), (9, 30), (20, 3)] {
            let found = over_gaps(&values, least, gap).into_iter().map(of);
            let told = sample_by_sample(&values, least, gap).into_iter().map(of);
            let found: Vec<_> = found.collect();
            assert!(found.len() > 3, "least {least}");
            assert_eq!(found, told.collect::<Vec<_>>(), "least {least}, gap {gap}");
        }
    }

    #[test]
    fn a_run_goes_on_over_what_is_missing_but_not_for_long() {
        let n = f64::NAN;
        let values = [n, 1.0, 1.0, n, n, 1.0, n, 2.0, 2.0, n, n, n, 2.0, n];
        let of = |gap: usize| -> Vec<(usize, usize, usize, usize)> {
            let runs = over_gaps(&values, 2, gap);
            let of = |h: &Held| (h.run.start, h.run.length, h.told, h.repeats());
            runs.iter().map(of).collect()
        };
        assert_eq!(of(3), [(1, 5, 3, 1), (7, 6, 3, 1)]);
        assert_eq!(of(2), [(1, 5, 3, 1), (7, 2, 2, 1)]);
        assert_eq!(of(0), [(1, 2, 2, 1), (7, 2, 2, 1)]);
    }

    #[test]
    fn more_honest_repeats_ask_for_longer_runs() {
        let rule = StuckRule {
            floor: 5,
            chance: 1e-6,
            gap: 0,
        };
        assert_eq!(limit(0.0, rule), 5);
        // 0.5^20 is just below one in a million.
        assert_eq!(limit(0.5, rule), 21);
        assert!(limit(1.0, rule) > 10_000);
    }
}
