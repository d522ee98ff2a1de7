//! What is computed of any series.

use dgd_recording::{Rank, quantile};
use dgd_replay::fill_gaps;

/// The nearest whole number, at least 0.
pub(crate) fn whole(value: f64) -> usize {
    #[allow(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "clamped; NaN becomes 0"
    )]
    let count = value.round().clamp(0.0, 1e12) as usize;
    count
}

/// The value, 0 where it is none: what holds nothing moves nothing.
pub(crate) fn finite_or_0(value: f64) -> f64 {
    if value.is_finite() { value } else { 0.0 }
}

/// Mean of the finite values, NaN if none is.
pub(crate) fn mean(values: &[f64]) -> f64 {
    mean_of(values.iter().copied())
}

/// The same of values that are made one by one.
pub(crate) fn mean_of(values: impl Iterator<Item = f64>) -> f64 {
    let (mut sum, mut count) = (0.0, 0.0);
    for v in values.filter(|v| v.is_finite()) {
        sum += v;
        count += 1.0;
    }
    sum / count
}

/// Running sums of the finite values of a series, and of how many they are.
pub(crate) struct Means(Vec<(f64, usize)>);

impl Means {
    pub(crate) fn of(values: &[f64]) -> Self {
        let mut sums = Vec::with_capacity(values.len() + 1);
        let (mut sum, mut count) = (0.0, 0);
        sums.push((sum, count));
        for value in values {
            if value.is_finite() {
                (sum, count) = (sum + value, count + 1);
            }
            sums.push((sum, count));
        }
        Self(sums)
    }

    /// The mean from a sample to before another, NaN where none of them is known.
    pub(crate) fn between(&self, from: usize, to: usize) -> f64 {
        let at = |i: usize| self.0[i.min(self.0.len() - 1)];
        let ((low, few), (high, many)) = (at(from), at(to));
        (high - low) / (many - few) as f64
    }
}

/// The values that a `k`-th of the finite ones lies below and above; `None` if none is finite.
pub(crate) fn tails(values: &[f64], k: usize) -> Option<(f64, f64)> {
    let at = |rank| quantile(values.iter().copied(), rank);
    Some((at(Rank::Lower(k))?, at(Rank::Upper(k))?))
}

/// Median absolute value of the finite values over 0.6745: the standard deviation of a clean core; NaN if there is none.
pub(crate) fn spread(values: impl IntoIterator<Item = f64>) -> f64 {
    let sizes = values.into_iter().map(f64::abs);
    quantile(sizes, Rank::MEDIAN).map_or(f64::NAN, |v| v / 0.6745)
}

/// Every choice of one value from each grid, in their order.
pub(crate) fn product(grids: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let mut out = vec![Vec::new()];
    for grid in grids {
        out = out
            .iter()
            .flat_map(|head| {
                grid.iter().map(move |v| {
                    let mut next = head.clone();
                    next.push(*v);
                    next
                })
            })
            .collect();
    }
    out
}

/// Gaps bridged by straight lines, ends held; all 0 if nothing is finite.
pub(crate) fn bridged(values: &[f64]) -> Vec<f64> {
    let mut out = values.to_vec();
    if fill_gaps(&mut out).is_none() {
        out.fill(0.0);
    }
    out
}
