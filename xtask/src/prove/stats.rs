//! Shares with their doubt, and medians.

/// So many of so many.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) struct Tally {
    pub(crate) right: usize,
    pub(crate) of: usize,
}

impl Tally {
    pub(crate) fn add(&mut self, right: bool) {
        self.right += usize::from(right);
        self.of += 1;
    }

    /// `None` where nothing was counted.
    pub(crate) fn share(self) -> Option<f64> {
        (self.of > 0).then(|| self.right as f64 / self.of as f64)
    }

    /// Wilson's 95 % interval of the share (E. B. Wilson, 1927); `None` where nothing was counted.
    pub(crate) fn interval(self) -> Option<(f64, f64)> {
        const Z: f64 = 1.959_963_984_540_054;
        let share = self.share()?;
        let n = self.of as f64;
        let denominator = 1.0 + Z * Z / n;
        let centre = (share + Z * Z / (2.0 * n)) / denominator;
        let half = Z * (share * (1.0 - share) / n + Z * Z / (4.0 * n * n)).sqrt() / denominator;
        // At none and at all of n the formula meets 0 and 1 but for rounding.
        let low = if self.right == 0 { 0.0 } else { centre - half };
        let high = if self.right == self.of {
            1.0
        } else {
            centre + half
        };
        Some((low, high))
    }
}

/// The value below which `share` of the values lie, linear between neighbours.
pub(crate) fn quantile(values: &[f64], share: f64) -> Option<f64> {
    let mut sorted: Vec<f64> = values.iter().copied().filter(|v| v.is_finite()).collect();
    sorted.sort_by(f64::total_cmp);
    let last = sorted.len().checked_sub(1)?;
    let at = share.clamp(0.0, 1.0) * last as f64;
    let below = sorted.iter().enumerate().rfind(|(i, _)| *i as f64 <= at);
    let (i, low) = below?;
    let high = sorted.get(i + 1).unwrap_or(low);
    Some(low + (at - i as f64) * (high - low))
}

pub(crate) fn median(values: &[f64]) -> Option<f64> {
    quantile(values, 0.5)
}

pub(crate) fn mean(values: &[f64]) -> Option<f64> {
    (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may")]
    use super::*;

    #[test]
    fn wilson_meets_the_published_example() {
        // Newcombe (1998), Statistics in Medicine 17:857, table I: 81 of 263 and 0 of 20, 1 of 29.
        let close = |t: Tally, low: f64, high: f64| {
            let (a, b) = t.interval().unwrap();
            assert!((a - low).abs() < 5e-5 && (b - high).abs() < 5e-5, "{a} {b}");
        };
        close(Tally { right: 81, of: 263 }, 0.2553, 0.3662);
        close(Tally { right: 15, of: 148 }, 0.0624, 0.1605);
        close(Tally { right: 0, of: 20 }, 0.0, 0.1611);
        close(Tally { right: 1, of: 29 }, 0.0061, 0.1718);
    }

    #[test]
    fn counting_nothing_claims_nothing() {
        assert_eq!(Tally::default().share(), None);
        assert_eq!(Tally::default().interval(), None);
        assert_eq!(median(&[]), None);
        assert_eq!(mean(&[]), None);
    }

    #[test]
    fn the_median_of_an_even_number_lies_between() {
        assert_eq!(median(&[4.0, 1.0, 3.0, 2.0]), Some(2.5));
        assert_eq!(quantile(&[1.0, f64::NAN, 3.0], 1.0), Some(3.0));
        assert_eq!(quantile(&[1.0, 3.0], 0.25), Some(1.5));
    }
}
