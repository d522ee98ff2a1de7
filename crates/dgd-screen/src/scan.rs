//! The cheap passes over one series: everything that touches every sample.

use crate::{Faults, Limits};

/// Step statistics of a series, from a few thousand of its steps.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Steps {
    /// Standard deviation of white noise with these steps.
    pub(crate) noise: f64,
    /// Small step that occurs: the quantum of a quantised series.
    pub(crate) quantum: f64,
    /// Median of the steps that are not zero.
    pub(crate) typical: f64,
    /// So many of those looked at are not zero.
    pub(crate) moves: usize,
}

/// Normal standard deviations in a median absolute deviation.
pub(crate) const SIGMA_OF_MAD: f64 = 1.4826;

/// Of so many samples one in so many is looked at, so that a few thousand are.
pub(crate) fn stride(samples: usize) -> usize {
    const LOOKED_AT: usize = 4096;
    (samples / LOOKED_AT).max(1)
}

/// Looks at a few thousand steps spread evenly over the series.
pub(crate) fn steps(values: &[f64]) -> Steps {
    let found = (1..values.len())
        .step_by(stride(values.len()))
        .map(|i| (values[i] - values[i - 1]).abs())
        .filter(|d| d.is_finite());
    Steps::of(found.collect())
}

impl Steps {
    /// The statistics of finite steps, in any order.
    pub(crate) fn of(mut found: Vec<f64>) -> Self {
        found.sort_unstable_by(f64::total_cmp);
        let zeros = found.partition_point(|d| *d == 0.0);
        let moving = &found[zeros..];
        if moving.is_empty() {
            return Self::default();
        }
        Self {
            noise: SIGMA_OF_MAD * found[found.len() / 2] / std::f64::consts::SQRT_2,
            // The hundredth part leaves rounding errors of a conversion alone.
            quantum: moving[moving.len() / 100],
            typical: moving[moving.len() / 2],
            moves: moving.len(),
        }
    }
}

/// What one look at every sample finds.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Scan {
    /// Samples that repeat their predecessor.
    pub(crate) equal: usize,
    /// Pairs of finite neighbours.
    pub(crate) pairs: usize,
    /// Samples that differ from their predecessor by more than asked.
    pub(crate) jumps: Vec<usize>,
}

/// Looks at every sample once: marks missing and impossible values, counts repeats and
/// lists jumps of more than `least`.
pub(crate) fn scan(values: &[f64], limits: Limits, least: f64, faults: &mut [Faults]) -> Scan {
    // Most parts are in order; without a branch inside, the compiler can vectorise, and a
    // part stays in the cache for all three questions.
    const PART: usize = 64;
    let (low, high) = (limits.low.max(f64::MIN), limits.high.min(f64::MAX));
    // NaN compares false, and the limits are finite.
    let fine = |v: f64| (v >= low) & (v <= high);
    let mut found = Scan::default();
    let mut before_fine = false;
    for start in (0..values.len()).step_by(PART) {
        let end = (start + PART).min(values.len());
        let from = start.saturating_sub(1);
        let wrong: u64 = values[start..end]
            .iter()
            .map(|v| u64::from(!fine(*v)))
            .sum();
        let largest = if wrong == 0 && before_fine {
            let (equal, largest) = steps_of(&values[from..end]);
            found.equal += equal;
            found.pairs += end - start;
            largest
        } else {
            for i in (start..end).filter(|i| !fine(values[*i])) {
                faults[i] |= if values[i].is_finite() {
                    Faults::OUT_OF_RANGE
                } else {
                    Faults::MISSING
                };
            }
            let (equal, pairs) = repeats(&values[from..end]);
            found.equal += equal;
            found.pairs += pairs;
            f64::INFINITY
        };
        if largest > least {
            let jump = |i: &usize| (values[*i] - values[*i - 1]).abs() > least;
            found.jumps.extend((from + 1..end).filter(jump));
        }
        before_fine = fine(values[end - 1]);
    }
    found
}

/// Samples that repeat their predecessor, and the largest step, of finite values.
///
/// In lanes: neither a count nor a largest value waits for the one before.
fn steps_of(values: &[f64]) -> (usize, f64) {
    const LANES: usize = 4;
    let (mut equal, mut largest) = ([0.0; LANES], [0.0; LANES]);
    let (after, rest) = values.get(1..).unwrap_or_default().as_chunks::<LANES>();
    let (before, _) = values.as_chunks::<LANES>();
    for (a, b) in before.iter().zip(after) {
        let step: [f64; LANES] = std::array::from_fn(|k| (b[k] - a[k]).abs());
        for k in 0..LANES {
            equal[k] += if step[k] == 0.0 { 1.0 } else { 0.0 };
        }
        for k in 0..LANES {
            largest[k] = if step[k] > largest[k] {
                step[k]
            } else {
                largest[k]
            };
        }
    }
    let (mut equal, mut largest) = (
        equal.iter().sum::<f64>(),
        largest.iter().fold(0.0, |m: f64, l| m.max(*l)),
    );
    for (a, b) in values[after.len() * LANES..].iter().zip(rest) {
        let step = (b - a).abs();
        equal += if step == 0.0 { 1.0 } else { 0.0 };
        largest = largest.max(step);
    }
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a count of a few samples"
    )]
    let equal = equal as usize;
    (equal, largest)
}

/// Samples that repeat their predecessor, and pairs of finite neighbours.
pub(crate) fn repeats(values: &[f64]) -> (usize, usize) {
    let mut equal = 0u64;
    let mut pairs = 0u64;
    for (a, b) in values.iter().zip(values.iter().skip(1)) {
        let step = b - a;
        equal += u64::from(step == 0.0);
        pairs += u64::from(step.is_finite());
    }
    (
        usize::try_from(equal).unwrap_or(usize::MAX),
        usize::try_from(pairs).unwrap_or(usize::MAX),
    )
}

/// Median of a list (the upper one of an even number), which it orders; `None` if it is empty.
pub(crate) fn median(list: &mut [f64]) -> Option<f64> {
    const SHORT: usize = 24;
    let middle = list.len() / 2;
    if list.len() > SHORT {
        return Some(*list.select_nth_unstable_by(middle, f64::total_cmp).1);
    }
    // Tens of thousands of short lists: plain insertion is several times faster.
    for i in 1..list.len() {
        let value = list[i];
        let mut hole = i;
        while hole > 0 && list[hole - 1] > value {
            list[hole] = list[hole - 1];
            hole -= 1;
        }
        list[hole] = value;
    }
    list.get(middle).copied()
}

/// Median and robust standard deviation of a short list.
pub(crate) fn level(list: &mut [f64]) -> Option<(f64, f64)> {
    let centre = median(list)?;
    list.iter_mut().for_each(|v| *v = (*v - centre).abs());
    Some((centre, SIGMA_OF_MAD * median(list)?))
}
