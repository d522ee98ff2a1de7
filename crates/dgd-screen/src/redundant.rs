//! Redundant transmitters: short disagreement, and the mean of those to be trusted.
//!
//! Only short-lived disagreement is a fault here. A step or a drift of one
//! transmitter stays: it is a finding, and it moves the slow median with it.

use crate::Faults;
use crate::scan::{SIGMA_OF_MAD, median, stride};
use std::ops::Range;

/// What counts as disagreement.
#[derive(Debug, Clone, Copy)]
pub(crate) struct DisagreeRule {
    pub(crate) sigmas: f64,
    /// Longest disagreement, samples.
    pub(crate) longest: usize,
    /// Samples in a block of the slow median.
    pub(crate) block: usize,
    /// Differences up to this are quantisation, SI.
    pub(crate) least: f64,
}

/// Values of a block that its median is taken from.
const OF_A_BLOCK: usize = 7;
/// Fewest readings of each of two transmitters in a block by which it is told what lies between them.
const FEWEST_READ: usize = 3;
/// Blocks on either side in the slow median.
const BLOCKS_BESIDE: usize = 2;
/// Samples on either side that tell the level around a disagreement.
pub(crate) const BESIDE: usize = 15;
/// So many samples back inside do not end a disagreement.
pub(crate) const RESPITE: usize = 2;

/// The slowly varying part of a difference: one value a block.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Slow {
    block: usize,
    values: Vec<f64>,
}

impl Slow {
    /// The slow median of the difference `n` of some transmitters; `None` if there is none.
    fn of(
        series: &[&[f64]],
        faults: &[impl AsRef<[Faults]>],
        n: usize,
        block: usize,
    ) -> Option<Self> {
        let (samples, block) = (series[n].len(), block.max(1));
        let blocks = || {
            (0..samples)
                .step_by(block)
                .map(|start| start..(start + block).min(samples))
        };
        let each = |i: usize| difference(series, faults, n, i);
        let rough = blocks().map(|inside| Self::rough(inside, block, each));
        Self::smooth(rough.collect(), block).or_else(|| {
            let of_medians = blocks().map(|inside| Self::of_medians(series, faults, inside));
            Self::read_apart(of_medians.collect(), block)
        })
    }

    /// The median of a block of so many samples, of which these are there; NaN if it has none.
    pub(crate) fn rough(
        inside: Range<usize>,
        block: usize,
        difference: impl Fn(usize) -> f64,
    ) -> f64 {
        let stride = (block / OF_A_BLOCK).max(1);
        few(inside.step_by(stride).map(difference)).unwrap_or(f64::NAN)
    }

    /// The difference of the medians of two transmitters over a block, for where they are never read at one sample; NaN of more, as any may be left out.
    pub(crate) fn of_medians(
        series: &[&[f64]],
        faults: &[impl AsRef<[Faults]>],
        inside: Range<usize>,
    ) -> f64 {
        let [a, b] = series else {
            return f64::NAN;
        };
        let own = |m: usize, values: &[f64]| {
            let read = |i: &usize| faults[m].as_ref()[*i].trusted() && values[*i].is_finite();
            let read: Vec<f64> = inside.clone().filter(read).map(|i| values[i]).collect();
            if read.len() < FEWEST_READ {
                return None;
            }
            few(read
                .iter()
                .copied()
                .step_by((read.len() / OF_A_BLOCK).max(1)))
        };
        own(0, a).zip(own(1, b)).map_or(f64::NAN, |(a, b)| a - b)
    }

    /// The slow median by [`Self::of_medians`], if there are enough: where one transmitter takes over from another, nothing tells what lies between them.
    pub(crate) fn read_apart(of_medians: Vec<f64>, block: usize) -> Option<Self> {
        /// Fewest blocks in which both are read, and their share, one in so many.
        const FEWEST: usize = 10;
        const ONE_IN: usize = 10;
        let both = of_medians.iter().filter(|d| d.is_finite()).count();
        let enough = both >= FEWEST && ONE_IN * both >= of_medians.len();
        enough.then(|| Self::smooth(of_medians, block)).flatten()
    }

    /// Medians over neighbouring blocks, of one value a block; `None` if there is none.
    pub(crate) fn smooth(mut rough: Vec<f64>, block: usize) -> Option<Self> {
        fill(&mut rough)?;
        let mut list = Vec::with_capacity(2 * BLOCKS_BESIDE + 1);
        let values = (0..rough.len())
            .map(|k| {
                list.clear();
                let to = (k + BLOCKS_BESIDE + 1).min(rough.len());
                list.extend_from_slice(&rough[k.saturating_sub(BLOCKS_BESIDE)..to]);
                median(&mut list).unwrap_or(f64::NAN)
            })
            .collect();
        Some(Self { block, values })
    }

    pub(crate) fn at(&self, index: usize) -> f64 {
        self.values[index / self.block]
    }
}

/// The median of the first few finite values; `None` if there is none.
fn few(values: impl Iterator<Item = f64>) -> Option<f64> {
    let mut list = [0.0; 2 * OF_A_BLOCK];
    let mut count = 0;
    for (place, d) in list.iter_mut().zip(values.filter(|d| d.is_finite())) {
        *place = d;
        count += 1;
    }
    median(&mut list[..count])
}

/// Fills NaN from the nearest value before, at the start from the first after.
fn fill(values: &mut [f64]) -> Option<()> {
    let mut last = values.iter().copied().find(|v| v.is_finite())?;
    for v in values {
        if v.is_finite() {
            last = *v;
        } else {
            *v = last;
        }
    }
    Some(())
}

/// Marks short disagreement of the transmitters of one place; of two, returns the slow
/// median of the first less the second.
pub(crate) fn mark(
    series: &[&[f64]],
    faults: &mut [Vec<Faults>],
    rule: DisagreeRule,
) -> Option<Slow> {
    let mut pair = None;
    let mut marks: Vec<(usize, Range<usize>)> = Vec::new();
    for n in 0..differences(series.len()) {
        let (samples, known) = (series[n].len(), &*faults);
        let each = |i: usize| difference(series, known, n, i);
        let Some(slow) = Slow::of(series, known, n, rule.block) else {
            continue;
        };
        let stretch = |range, out: &mut Vec<f64>| stretch(series, known, n, range, out);
        for range in short_lived(samples, each, stretch, &slow, rule) {
            let blamed = blamed(series, n, &range);
            marks.extend(blamed.into_iter().map(|n| (n, range.clone())));
        }
        pair = Some(slow).filter(|_| series.len() == 2);
    }
    for (n, range) in marks {
        for fault in &mut faults[n][range] {
            *fault |= Faults::DISAGREES;
        }
    }
    pair
}

/// Of transmitters, or of their differences: one series of two, one each of more.
pub(crate) fn differences(transmitters: usize) -> usize {
    match transmitters {
        0 | 1 => 0,
        2 => 1,
        many => many,
    }
}

/// The difference that disagreement shows in; NaN where it is not to be trusted.
///
/// Of three or more it is from their middle: two outvote the third, two alone cannot.
pub(crate) fn difference(
    series: &[&[f64]],
    faults: &[impl AsRef<[Faults]>],
    n: usize,
    i: usize,
) -> f64 {
    match series {
        [a, b] => {
            let faults = |n: usize| faults[n].as_ref()[i];
            apart((a[i], faults(0)), (b[i], faults(1)))
        }
        many => from_middle(many, faults, n, i),
    }
}

/// The first of two less the second.
fn apart((a, of_a): (f64, Faults), (b, of_b): (f64, Faults)) -> f64 {
    if of_a.trusted() & of_b.trusted() {
        a - b
    } else {
        f64::NAN
    }
}

/// Appends [`difference`] at each of a stretch, of two without looking at each sample's place.
fn stretch(
    series: &[&[f64]],
    faults: &[Vec<Faults>],
    n: usize,
    range: Range<usize>,
    out: &mut Vec<f64>,
) {
    match series {
        [a, b] => {
            let values = a[range.clone()].iter().zip(&b[range.clone()]);
            let faults = faults[0][range.clone()].iter().zip(&faults[1][range]);
            let both = values.zip(faults);
            out.extend(both.map(|((a, b), (fa, fb))| apart((*a, *fa), (*b, *fb))));
        }
        many => out.extend(range.map(|i| from_middle(many, faults, n, i))),
    }
}

/// The transmitters to blame for a disagreement that shows in the difference `n`.
pub(crate) fn blamed(series: &[&[f64]], n: usize, range: &Range<usize>) -> Vec<usize> {
    match series {
        [a, b] => {
            let guilty = guilty(a, b, range);
            (0..2).filter(|n| guilty[*n]).collect()
        }
        many => (moved(many, n, range)).then_some(n).into_iter().collect(),
    }
}

/// Of three or more, one less the median of those that may be trusted.
fn from_middle(many: &[&[f64]], faults: &[impl AsRef<[Faults]>], n: usize, i: usize) -> f64 {
    let trusted = |m: usize| faults[m].as_ref()[i].trusted();
    let mut all: Vec<f64> = (0..many.len())
        .filter(|m| trusted(*m))
        .map(|m| many[m][i])
        .collect();
    let vote = all.len() > 2 && trusted(n);
    let middle = median(&mut all).filter(|_| vote);
    middle.map_or(f64::NAN, |middle| many[n][i] - middle)
}

/// The one that left is the liar; if neither did clearly, both are suspect.
fn guilty(a: &[f64], b: &[f64], range: &Range<usize>) -> [bool; 2] {
    let (ha, hb) = (height(a, range), height(b, range));
    [hb <= 2.0 * ha, ha <= 2.0 * hb]
}

/// The median changes hands when one leaves: only who moved itself is meant.
fn moved(many: &[&[f64]], n: usize, range: &Range<usize>) -> bool {
    let heights = many.iter().map(|series| height(series, range));
    2.0 * height(many[n], range) >= heights.fold(0.0, f64::max)
}

/// The difference from its slow median that is no disagreement yet, from those at every so many samples; `None` if
/// none is ever.
pub(crate) fn least(mut off: Vec<f64>, rule: DisagreeRule) -> Option<f64> {
    off.retain(|d| d.is_finite());
    let middle = median(&mut off)?;
    let least = (rule.sigmas * SIGMA_OF_MAD * middle).max(rule.least);
    (least > 0.0).then_some(least)
}

/// Takes a sample into the stretch that is open, or begins one with it; returns the one that ended, if it is too far behind.
pub(crate) fn go_on(open: &mut Option<Range<usize>>, i: usize) -> Option<Range<usize>> {
    match open {
        Some(last) if i - last.end <= RESPITE => {
            last.end = i + 1;
            None
        }
        open => open.replace(i..i + 1),
    }
}

/// Whether what left the slow median over `range` is short, and the level after it that of before.
pub(crate) fn returns(
    range: &Range<usize>,
    samples: usize,
    longest: usize,
    difference: impl Fn(usize) -> f64,
) -> bool {
    if range.len() > longest {
        return false;
    }
    let part = |r: Range<usize>| -> Option<f64> {
        let mut list: Vec<f64> = r.map(&difference).filter(|d| d.is_finite()).collect();
        median(&mut list)
    };
    let inside = part(range.clone());
    let before = part(range.start.saturating_sub(BESIDE)..range.start);
    let after = part(range.end..(range.end + BESIDE).min(samples));
    let (Some(inside), Some(before), Some(after)) = (inside, before, after) else {
        return false;
    };
    let height = (inside - 0.5 * (before + after)).abs();
    3.0 * (after - before).abs() <= height
}

/// Stretches where the difference leaves its slow median for a short while and returns; `differences` appends
/// those of a range.
fn short_lived(
    samples: usize,
    difference: impl Fn(usize) -> f64,
    differences: impl Fn(Range<usize>, &mut Vec<f64>),
    slow: &Slow,
    rule: DisagreeRule,
) -> Vec<Range<usize>> {
    let off = (0..samples)
        .step_by(stride(samples))
        .map(|i| (difference(i) - slow.at(i)).abs());
    let Some(least) = least(off.collect(), rule) else {
        return Vec::new();
    };
    let (mut open, mut found) = (None, Vec::new());
    let mut here = Vec::with_capacity(slow.block.min(samples));
    for (block, centre) in slow.values.iter().enumerate() {
        let start = block * slow.block;
        here.clear();
        differences(start..(start + slow.block).min(samples), &mut here);
        for (i, difference) in (start..).zip(&here) {
            if (difference - centre).abs() > least {
                found.extend(go_on(&mut open, i));
            }
        }
    }
    found.extend(open);
    found.retain(|range| returns(range, samples, rule.longest, &difference));
    found
}

/// How far the median over `range` lies off the level around it.
fn height(values: &[f64], range: &Range<usize>) -> f64 {
    let part = |r: Range<usize>| {
        let mut list: Vec<f64> = values[r]
            .iter()
            .copied()
            .filter(|v| v.is_finite())
            .collect();
        median(&mut list)
    };
    let before = part(range.start.saturating_sub(BESIDE)..range.start);
    let after = part(range.end..(range.end + BESIDE).min(values.len()));
    match (part(range.clone()), before, after) {
        (Some(inside), Some(before), Some(after)) => (inside - 0.5 * (before + after)).abs(),
        _ => f64::INFINITY,
    }
}

/// Mean of the transmitters that may be trusted; NaN where none may.
///
/// - `slow`: of two, the slow median of the first less the second.
/// - `range`: the samples of the recording that the series are.
///
/// Of two, one alone stands for the mean after half their slow difference is taken off,
/// so that the mean does not step by half their calibration difference whenever one of them drops out.
pub(crate) fn trusted_mean(
    series: &[&[f64]],
    faults: &[&[Faults]],
    slow: Option<&Slow>,
    range: Range<usize>,
) -> Vec<f64> {
    match (series, faults) {
        ([only], [f]) => only
            .iter()
            .zip(*f)
            .map(|(v, f)| if f.trusted() { *v } else { f64::NAN })
            .collect(),
        ([a, b], [fa, fb]) => {
            let half = |i: usize| slow.map_or(0.0, |s| 0.5 * s.at(range.start + i));
            let pairs = a.iter().zip(*b).zip(fa.iter().zip(*fb));
            pairs
                .enumerate()
                .map(
                    |(i, ((a, b), (fa, fb)))| match (fa.trusted(), fb.trusted()) {
                        (true, true) => 0.5 * (a + b),
                        (true, false) => a - half(i),
                        (false, true) => b + half(i),
                        (false, false) => f64::NAN,
                    },
                )
                .collect()
        }
        _ => (0..range.len())
            .map(|i| {
                let trusted = series.iter().zip(faults).filter(|(_, f)| f[i].trusted());
                let (sum, count) =
                    trusted.fold((0.0, 0.0), |(sum, count), (v, _)| (sum + v[i], count + 1.0));
                sum / count
            })
            .collect(),
    }
}
