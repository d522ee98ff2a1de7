//! Redundant transmitters: short disagreement, and the mean of those to be trusted.
//!
//! Only short-lived disagreement is a fault here. A step or a drift of one
//! transmitter stays: it is a finding, and it moves the slow median with it.

use crate::Faults;
use crate::scan::{SIGMA_OF_MAD, median};
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
/// Blocks on either side in the slow median.
const BLOCKS_BESIDE: usize = 2;
/// Samples on either side that tell the level around a disagreement.
const BESIDE: usize = 15;

/// The slowly varying part of a difference: one value a block.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Slow {
    block: usize,
    values: Vec<f64>,
}

impl Slow {
    /// The slow median of `difference`, which gives NaN where it is not to be trusted.
    /// `None` if it is nowhere.
    pub(crate) fn of(
        samples: usize,
        block: usize,
        difference: impl Fn(usize) -> f64,
    ) -> Option<Self> {
        let block = block.max(1);
        let stride = (block / OF_A_BLOCK).max(1);
        let mut list = Vec::with_capacity(OF_A_BLOCK + 1);
        let mut rough: Vec<f64> = (0..samples)
            .step_by(block)
            .map(|start| {
                list.clear();
                let inside = (start..(start + block).min(samples)).step_by(stride);
                list.extend(inside.map(&difference).filter(|d| d.is_finite()));
                median(&mut list).unwrap_or(f64::NAN)
            })
            .collect();
        fill(&mut rough)?;
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

    fn at(&self, index: usize) -> f64 {
        self.values[index / self.block]
    }
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
    let marks: Vec<(usize, Range<usize>)> = match series {
        [] | [_] => Vec::new(),
        [a, b] => {
            let difference = |i: usize| {
                if faults[0][i].trusted() & faults[1][i].trusted() {
                    a[i] - b[i]
                } else {
                    f64::NAN
                }
            };
            let slow = Slow::of(a.len(), rule.block, difference)?;
            // The same, a stretch at a time.
            let differences = |range: Range<usize>, out: &mut Vec<f64>| {
                let values = a[range.clone()].iter().zip(&b[range.clone()]);
                let faults = faults[0][range.clone()].iter().zip(&faults[1][range]);
                out.extend(values.zip(faults).map(|((a, b), (fa, fb))| {
                    if fa.trusted() & fb.trusted() {
                        a - b
                    } else {
                        f64::NAN
                    }
                }));
            };
            let found = short_lived(a.len(), difference, differences, &slow, rule);
            pair = Some(slow);
            found
                .into_iter()
                .flat_map(|range| {
                    let (ha, hb) = (height(a, &range), height(b, &range));
                    // The one that left is the liar; if neither did clearly, both are suspect.
                    let guilty = [hb <= 2.0 * ha, ha <= 2.0 * hb];
                    (0..2)
                        .filter(move |n| guilty[*n])
                        .map(move |n| (n, range.clone()))
                })
                .collect()
        }
        many => (0..many.len())
            .flat_map(|n| {
                // Two of three outvote the third; two alone cannot.
                let difference = |i: usize| {
                    let mut all: Vec<f64> = (0..many.len())
                        .filter(|m| faults[*m][i].trusted())
                        .map(|m| many[m][i])
                        .collect();
                    let vote = all.len() > 2 && faults[n][i].trusted();
                    let middle = median(&mut all).filter(|_| vote);
                    middle.map_or(f64::NAN, |middle| many[n][i] - middle)
                };
                // The median changes hands when one leaves: only who moved itself is meant.
                let moved = |range: &Range<usize>| {
                    let heights = many.iter().map(|series| height(series, range));
                    2.0 * height(many[n], range) >= heights.fold(0.0, f64::max)
                };
                let slow = Slow::of(many[n].len(), rule.block, difference);
                slow.map_or(Vec::new(), |slow| {
                    let differences =
                        |range: Range<usize>, out: &mut Vec<f64>| out.extend(range.map(difference));
                    short_lived(many[n].len(), difference, differences, &slow, rule)
                })
                .into_iter()
                .filter(moved)
                .map(move |range| (n, range))
                .collect::<Vec<_>>()
            })
            .collect(),
    };
    for (n, range) in marks {
        for fault in &mut faults[n][range] {
            *fault |= Faults::DISAGREES;
        }
    }
    pair
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
    let stride = (samples / 4096).max(1);
    let mut off: Vec<f64> = (0..samples)
        .step_by(stride)
        .map(|i| (difference(i) - slow.at(i)).abs())
        .filter(|d| d.is_finite())
        .collect();
    let Some(middle) = median(&mut off) else {
        return Vec::new();
    };
    let least = (rule.sigmas * SIGMA_OF_MAD * middle).max(rule.least);
    if least <= 0.0 {
        return Vec::new();
    }
    let mut found: Vec<Range<usize>> = Vec::new();
    let mut here = Vec::with_capacity(slow.block.min(samples));
    for (block, centre) in slow.values.iter().enumerate() {
        let start = block * slow.block;
        here.clear();
        differences(start..(start + slow.block).min(samples), &mut here);
        for (i, difference) in (start..).zip(&here) {
            if (difference - centre).abs() > least {
                match found.last_mut() {
                    // One or two samples back inside do not end a disagreement.
                    Some(last) if i - last.end <= 2 => last.end = i + 1,
                    _ => found.push(i..i + 1),
                }
            }
        }
    }
    found.retain(|range| {
        if range.len() > rule.longest {
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
    });
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
///
/// Of two, one alone stands for the mean after half their slow difference is taken off,
/// so that the mean does not step by half their calibration difference whenever one of them drops out.
pub(crate) fn trusted_mean(
    series: &[&[f64]],
    faults: &[&[Faults]],
    slow: Option<&Slow>,
    samples: usize,
) -> Vec<f64> {
    match (series, faults) {
        ([only], [f]) => only
            .iter()
            .zip(*f)
            .map(|(v, f)| if f.trusted() { *v } else { f64::NAN })
            .collect(),
        ([a, b], [fa, fb]) => {
            let half = |i: usize| slow.map_or(0.0, |s| 0.5 * s.at(i));
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
        _ => (0..samples)
            .map(|i| {
                let trusted = series.iter().zip(faults).filter(|(_, f)| f[i].trusted());
                let (sum, count) =
                    trusted.fold((0.0, 0.0), |(sum, count), (v, _)| (sum + v[i], count + 1.0));
                sum / count
            })
            .collect(),
    }
}
