//! Shares with their doubt, medians, the normal distribution and curves that only rise.

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

/// Forecasts by tenth of probability: their mean probability and how many are right; tenths without any are left out.
pub(crate) fn reliability(forecasts: &[(f64, bool)]) -> Vec<(f64, Tally)> {
    let mut bins = vec![(0.0, Tally::default()); 10];
    for (p, right) in forecasts {
        let bin = (1..10).rfind(|i| *p >= f64::from(*i) / 10.0).unwrap_or(0);
        let bin = &mut bins[usize::try_from(bin).unwrap_or(0)];
        bin.0 += p;
        bin.1.add(*right);
    }
    bins.retain(|(_, tally)| tally.of > 0);
    bins.iter_mut()
        .for_each(|(sum, tally)| *sum /= tally.of as f64);
    bins
}

/// Share of a standard normal distribution below `z` (Abramowitz and Stegun 1964, 7.1.26: off by less than 1.5e-7).
pub(crate) fn normal_share(z: f64) -> f64 {
    const A: [f64; 5] = [
        0.254_829_592,
        -0.284_496_736,
        1.421_413_741,
        -1.453_152_027,
        1.061_405_429,
    ];
    let x = z.abs() / std::f64::consts::SQRT_2;
    let t = 1.0 / (1.0 + 0.327_591_1 * x);
    let tail = t * A.iter().rev().fold(0.0, |sum, a| sum * t + a) * (-x * x).exp();
    if z < 0.0 {
        0.5 * tail
    } else {
        1.0 - 0.5 * tail
    }
}

/// The value below which `share` of a standard normal distribution lies (P. J. Acklam's rational approximation, off by less
/// than 1.2e-9 of itself).
pub(crate) fn normal_quantile(share: f64) -> f64 {
    const A: [f64; 6] = [
        -3.969_683_028_665_376e1,
        2.209_460_984_245_205e2,
        -2.759_285_104_469_687e2,
        1.383_577_518_672_69e2,
        -3.066_479_806_614_716e1,
        2.506_628_277_459_239,
    ];
    const B: [f64; 6] = [
        -5.447_609_879_822_406e1,
        1.615_858_368_580_409e2,
        -1.556_989_798_598_866e2,
        6.680_131_188_771_972e1,
        -1.328_068_155_288_572e1,
        1.0,
    ];
    const C: [f64; 6] = [
        -7.784_894_002_430_293e-3,
        -3.223_964_580_411_365e-1,
        -2.400_758_277_161_838,
        -2.549_732_539_343_734,
        4.374_664_141_464_968,
        2.938_163_982_698_783,
    ];
    const D: [f64; 5] = [
        7.784_695_709_041_462e-3,
        3.224_671_290_700_398e-1,
        2.445_134_137_142_996,
        3.754_408_661_907_416,
        1.0,
    ];
    const TAIL: f64 = 0.024_25;
    let series = |of: &[f64], x: f64| of.iter().fold(0.0, |sum, c| sum * x + c);
    if share < TAIL {
        let x = (-2.0 * share.ln()).sqrt();
        series(&C, x) / series(&D, x)
    } else if share > 1.0 - TAIL {
        -normal_quantile(1.0 - share)
    } else {
        let x = share - 0.5;
        x * series(&A, x * x) / series(&B, x * x)
    }
}

/// Two-sided chance that `a` of `a + b` even flips, or fewer or more alike, fall on one side.
pub(crate) fn sign_test(a: usize, b: usize) -> f64 {
    let n = a + b;
    let (mut term, mut below) = (0.5_f64.powf(n as f64), 0.0);
    for k in 0..=a.min(b) {
        below += term;
        term *= (n - k) as f64 / (k + 1) as f64;
    }
    (2.0 * below).min(1.0)
}

/// A run of the curve that only rises: everything from `from` to `to` has this share.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Step {
    pub(crate) from: f64,
    pub(crate) to: f64,
    pub(crate) tally: Tally,
}

/// The curve that only rises and fits best: pooled adjacent violators (Ayer and others 1955, *Ann. Math. Statist.* 26:641).
pub(crate) fn isotonic(points: &[(f64, bool)]) -> Vec<Step> {
    let mut sorted: Vec<(f64, bool)> = points.iter().copied().filter(|p| !p.0.is_nan()).collect();
    sorted.sort_by(|a, b| a.0.total_cmp(&b.0));
    // Equal places belong together, whatever their shares.
    let places = sorted.chunk_by(|a, b| a.0 == b.0).map(|same| Step {
        from: same[0].0,
        to: same[0].0,
        tally: Tally {
            right: same.iter().filter(|p| p.1).count(),
            of: same.len(),
        },
    });
    let mut steps: Vec<Step> = Vec::new();
    for mut last in places {
        while let Some(before) = steps.last() {
            let rises = before.tally.right * last.tally.of < last.tally.right * before.tally.of;
            if rises {
                break;
            }
            last.from = before.from;
            last.tally.right += before.tally.right;
            last.tally.of += before.tally.of;
            steps.pop();
        }
        steps.push(last);
    }
    steps
}

/// Where a curve that only rises passes one half.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Even {
    /// Between two cases, in the middle of their logarithms.
    At(f64),
    /// Below the smallest case.
    Below(f64),
    /// Above the largest case.
    Above(f64),
}

/// Where the curve passes one half; `None` without cases.
pub(crate) fn even_odds(steps: &[Step]) -> Option<Even> {
    let half = |s: &&Step| 2 * s.tally.right >= s.tally.of;
    let first = steps.first()?;
    Some(match steps.iter().position(|s| half(&s)) {
        Some(0) => Even::Below(first.from),
        Some(k) => Even::At((steps[k - 1].to * steps[k].from).sqrt()),
        None => Even::Above(steps.last()?.to),
    })
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

    #[test]
    fn the_normal_distribution_meets_published_quantiles() {
        for (share, z) in [
            (0.5, 0.0),
            (0.975, 1.959_963_984_540_054),
            (0.999, 3.090_232_306_167_814),
            (0.01, -2.326_347_874_040_841),
        ] {
            assert!((normal_quantile(share) - z).abs() < 1e-8, "{share}");
            assert!((normal_share(z) - share).abs() < 2e-7, "{z}");
        }
    }

    #[test]
    fn the_sign_test_meets_the_binomial_distribution() {
        assert_eq!(sign_test(0, 0), 1.0);
        assert_eq!(sign_test(4, 4), 1.0);
        // 2 (1 + 10) / 2^10
        assert!((sign_test(9, 1) - 22.0 / 1024.0).abs() < 1e-12);
        assert_eq!(sign_test(1, 9), sign_test(9, 1));
    }

    #[test]
    fn a_rising_curve_pools_what_falls_and_keeps_every_case() {
        let points = [
            (1.0, false),
            (2.0, true),
            (3.0, false),
            (4.0, true),
            (5.0, true),
        ];
        let steps = isotonic(&points);
        let shares: Vec<f64> = steps.iter().filter_map(|s| s.tally.share()).collect();
        assert_eq!(shares, [0.0, 0.5, 1.0]);
        assert_eq!(steps.iter().map(|s| s.tally.of).sum::<usize>(), 5);
        assert_eq!((steps[1].from, steps[1].to), (2.0, 3.0));
        assert_eq!(even_odds(&steps), Some(Even::At(2.0_f64.sqrt())));
    }

    #[test]
    fn a_rising_curve_does_not_ask_in_which_order_cases_came() {
        let mut points: Vec<(f64, bool)> = (0..40)
            .map(|i| (f64::from(i / 2), (i * 7) % 40 < i))
            .collect();
        let steps = isotonic(&points);
        points.reverse();
        assert_eq!(isotonic(&points), steps);
        let shares: Vec<f64> = steps.iter().filter_map(|s| s.tally.share()).collect();
        assert!(shares.windows(2).all(|w| w[0] < w[1]), "{shares:?}");
    }

    #[test]
    fn a_curve_without_a_passage_says_on_which_side_it_lies() {
        let of = |right| even_odds(&isotonic(&[(2.0, right), (8.0, right)]));
        assert_eq!(of(true), Some(Even::Below(2.0)));
        assert_eq!(of(false), Some(Even::Above(8.0)));
        assert_eq!(even_odds(&[]), None);
        let passes = isotonic(&[(2.0, false), (8.0, true)]);
        assert_eq!(even_odds(&passes), Some(Even::At(4.0)));
    }
}
