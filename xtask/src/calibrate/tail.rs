//! The evidence that clean recordings exceed at a small rate, beyond what so few of them can show.

use crate::prove::stats::quantile;

/// Fewer exceedances tell nothing of their spread.
const LEAST: usize = 5;

/// Values above a threshold, which fall off by a factor e a scale.
///
/// The exponential tail is the simplest of peaks over a threshold (J. Pickands, 1975, *Ann. Statist.* 3:119: the shape is
/// zero). Evidence is half a sum of squares, whose tail is near enough exponential where noise is Gaussian; [`Tail::spread`]
/// tells when it is not.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Tail {
    pub(crate) values: usize,
    /// Values, and those that were not looked at because they could not exceed anything.
    all: usize,
    pub(crate) above: usize,
    /// Share of the values below the threshold.
    below: f64,
    pub(crate) threshold: f64,
    /// Mean exceedance.
    pub(crate) scale: f64,
    /// Standard deviation of the exceedances over their mean: 1 if they are exponential, more if the tail is heavier.
    pub(crate) spread: f64,
    pub(crate) largest: f64,
}

impl Tail {
    /// Of the values above those below which the share `below` of them lies; `None` with fewer than five of them, or where they
    /// are all alike. `silent` more count towards the rate alone: they exceed nothing.
    pub(crate) fn of(values: &[f64], silent: usize, below: f64) -> Option<Tail> {
        let values: Vec<f64> = values.iter().copied().filter(|v| v.is_finite()).collect();
        let threshold = quantile(&values, below)?;
        let over: Vec<f64> = values
            .iter()
            .map(|v| v - threshold)
            .filter(|v| *v > 0.0)
            .collect();
        if over.len() < LEAST {
            return None;
        }
        let n = over.len() as f64;
        let scale = over.iter().sum::<f64>() / n;
        let variance = over.iter().map(|v| (v - scale).powi(2)).sum::<f64>() / (n - 1.0);
        (scale > 1e-9).then(|| Tail {
            values: values.len(),
            all: values.len() + silent,
            above: over.len(),
            below,
            threshold,
            scale,
            spread: variance.sqrt() / scale,
            largest: over.iter().copied().fold(0.0, f64::max) + threshold,
        })
    }

    /// The value that is exceeded at this rate, at or above the threshold.
    pub(crate) fn exceeded_at(&self, rate: f64) -> f64 {
        self.threshold + self.scale * self.folds(rate)
    }

    /// Its standard error: of the threshold, an order statistic with the density of the tail, and of the scale. They are
    /// independent, as the spacings of an exponential sample are (A. Rényi, 1953, *Acta Math. Hung.* 4:191).
    pub(crate) fn error_at(&self, rate: f64) -> f64 {
        let threshold = self.below / (1.0 - self.below) / self.values as f64;
        let scale = self.folds(rate).powi(2) / self.above as f64;
        self.scale * (threshold + scale).sqrt()
    }

    fn folds(&self, rate: f64) -> f64 {
        (self.above as f64 / self.all as f64 / rate).ln().max(0.0)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may")]
    use super::*;
    use crate::calibrate::logistic::tests::Draw;

    /// Exponential with this scale from `from` on.
    fn drawn(n: usize, scale: f64, from: f64, seed: u64) -> Vec<f64> {
        let mut draw = Draw(seed);
        (0..n)
            .map(|_| from - scale * (1.0 - draw.unit()).ln())
            .collect()
    }

    #[test]
    fn exponential_values_give_their_scale_and_their_quantile() {
        let tail = Tail::of(&drawn(20_000, 3.0, -4.0, 7), 0, 0.8).unwrap();
        assert!((tail.scale - 3.0).abs() < 0.15, "{tail:?}");
        assert!((tail.spread - 1.0).abs() < 0.05, "{tail:?}");
        // Exceeded at 0.001: -4 + 3 ln 1000.
        let truth = -4.0 + 3.0 * 1000.0_f64.ln();
        let off = tail.exceeded_at(0.001) - truth;
        assert!(off.abs() < 3.0 * tail.error_at(0.001), "{off}");
        assert!(tail.error_at(0.001) < 0.4);
    }

    #[test]
    fn the_standard_error_is_the_scatter_of_repeated_samples() {
        let rate = 0.02 / 24.0;
        let all: Vec<Tail> = (0..400)
            .map(|seed| Tail::of(&drawn(60, 2.0, 0.0, seed), 0, 0.8).unwrap())
            .collect();
        let of: Vec<f64> = all.iter().map(|t| t.exceeded_at(rate)).collect();
        let mean = of.iter().sum::<f64>() / 400.0;
        let scatter = (of.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / 399.0).sqrt();
        let told = all.iter().map(|t| t.error_at(rate)).sum::<f64>() / 400.0;
        assert!((told / scatter - 1.0).abs() < 0.15, "{told} {scatter}");
        // 2 ln 1200 = 14.2
        assert!((mean - 14.18).abs() < 0.7, "{mean}");
    }

    #[test]
    fn a_shift_and_a_stretch_carry_through() {
        let values = drawn(100, 1.0, 0.0, 3);
        let moved: Vec<f64> = values.iter().map(|v| 5.0 + 2.0 * v).collect();
        let (a, b) = (
            Tail::of(&values, 0, 0.8).unwrap(),
            Tail::of(&moved, 0, 0.8).unwrap(),
        );
        assert!((b.exceeded_at(1e-3) - 5.0 - 2.0 * a.exceeded_at(1e-3)).abs() < 1e-9);
        assert!((b.error_at(1e-3) - 2.0 * a.error_at(1e-3)).abs() < 1e-9);
    }

    #[test]
    fn values_that_exceed_nothing_lower_what_the_others_may_reach() {
        let values = drawn(100, 2.0, 0.0, 3);
        let (alone, among) = (
            Tail::of(&values, 0, 0.8).unwrap(),
            Tail::of(&values, 100, 0.8).unwrap(),
        );
        // Half of all recordings can exceed it, so they may do so twice as often.
        let lower = alone.exceeded_at(1e-3) - among.exceeded_at(1e-3);
        assert!((lower - alone.scale * 2.0_f64.ln()).abs() < 1e-9);
    }

    #[test]
    fn too_few_values_or_none_that_differ_tell_nothing() {
        assert_eq!(Tail::of(&[], 0, 0.8), None);
        assert_eq!(Tail::of(&drawn(20, 1.0, 0.0, 1), 0, 0.8), None);
        assert_eq!(Tail::of(&[1.0; 100], 0, 0.8), None);
        assert_eq!(Tail::of(&[f64::NAN; 100], 0, 0.8), None);
    }
}
