//! Values by their rank.

/// Which of the sorted values is meant.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Rank {
    /// A `k`-th of the values stands before it; with 2 it is the median, of an even number the upper one.
    Lower(usize),
    /// A `k`-th of the values stands behind it.
    Upper(usize),
    /// At a fraction of the way from the least to the greatest, the nearest value.
    Nearest(f64),
    /// The same, the value at or before it.
    Before(f64),
}

impl Rank {
    /// The median, of an even number the upper one.
    pub const MEDIAN: Self = Self::Lower(2);

    /// Position among `count` sorted values, at least one.
    fn position(self, count: usize) -> usize {
        let last = count - 1;
        let along = |fraction: f64| last as f64 * fraction;
        #[allow(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a cast of floats saturates, and what is beyond the last is held below; NaN becomes 0"
        )]
        let position = match self {
            Self::Lower(k) => count / k.max(1),
            Self::Upper(k) => last.saturating_sub(count / k.max(1)),
            Self::Nearest(fraction) => along(fraction).round() as usize,
            Self::Before(fraction) => along(fraction).floor() as usize,
        };
        position.min(last)
    }
}

/// The finite value of a rank; `None` if no value is finite.
///
/// ```
/// use dgd_recording::{Rank, quantile};
///
/// let flows = [3.0, f64::NAN, 1.0, 2.0];
/// assert_eq!(quantile(flows, Rank::MEDIAN), Some(2.0));
/// assert_eq!(quantile([f64::NAN], Rank::MEDIAN), None);
/// ```
pub fn quantile(values: impl IntoIterator<Item = f64>, rank: Rank) -> Option<f64> {
    let mut finite: Vec<f64> = values.into_iter().filter(|v| v.is_finite()).collect();
    if finite.is_empty() {
        return None;
    }
    let position = rank.position(finite.len());
    Some(*finite.select_nth_unstable_by(position, f64::total_cmp).1)
}

#[cfg(test)]
mod tests {
    use super::{Rank, quantile};

    /// 0, 1, ... in a mixed order, with gaps among them.
    fn mixed(n: u32) -> impl Iterator<Item = f64> + Clone {
        // 7919 is prime: its multiples go through every remainder.
        (0..n).flat_map(move |i| [f64::from(i * 7919 % n), f64::NAN])
    }

    #[test]
    fn each_rank_counts_from_its_own_end() {
        for (n, rank, expected) in [
            (5, Rank::MEDIAN, 2.0),
            (6, Rank::MEDIAN, 3.0),
            (100, Rank::Lower(20), 5.0),
            (100, Rank::Upper(20), 94.0),
            (19, Rank::Lower(20), 0.0),
            (19, Rank::Upper(20), 18.0),
            (22, Rank::Before(0.95), 19.0),
            (22, Rank::Nearest(0.95), 20.0),
            (101, Rank::Nearest(0.02), 2.0),
        ] {
            assert_eq!(quantile(mixed(n), rank), Some(expected), "{n} {rank:?}");
        }
    }

    #[test]
    fn a_twentieth_from_above_counts_in_whole_numbers() {
        // 0.95 is no sum of powers of 2: the product must not fall below the whole number that it is.
        for n in 1..2000_usize {
            assert_eq!(Rank::Before(0.95).position(n), (n - 1) * 95 / 100, "{n}");
        }
    }

    #[test]
    fn no_rank_and_no_value_panics() {
        let ranks = [0, 1, usize::MAX].map(|k| [Rank::Lower(k), Rank::Upper(k)]);
        let odd = [f64::NAN, f64::INFINITY, -1.0, 2.0].map(|f| [Rank::Nearest(f), Rank::Before(f)]);
        for rank in ranks.into_iter().chain(odd).flatten() {
            assert!(quantile(mixed(7), rank).is_some(), "{rank:?}");
            assert_eq!(quantile([f64::INFINITY, f64::NAN], rank), None);
        }
    }
}
