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

/// The values that a `k`-th of the finite ones lies below and above; `None` if none is finite.
pub(crate) fn tails(values: &[f64], k: usize) -> Option<(f64, f64)> {
    let at = |rank| quantile(values.iter().copied(), rank);
    Some((at(Rank::Lower(k))?, at(Rank::Upper(k))?))
}

/// Gaps bridged by straight lines, ends held; all 0 if nothing is finite.
pub(crate) fn bridged(values: &[f64]) -> Vec<f64> {
    let mut out = values.to_vec();
    if fill_gaps(&mut out).is_none() {
        out.fill(0.0);
    }
    out
}
