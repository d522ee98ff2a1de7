//! Logistic regression, with standard errors.

/// Steps of Newton's method at the most.
const STEPS: usize = 60;

/// A regression of what was right on what was known.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Fit {
    pub(crate) coefficients: Vec<f64>,
    /// Square roots of the inverse information's diagonal; the prior counts.
    pub(crate) errors: Vec<f64>,
}

/// The most probable coefficients under a normal prior of this standard deviation on each, about zero, which keeps them finite
/// where the data would not. `None` without rows, or where they cannot be told apart.
pub(crate) fn fit(rows: &[(Vec<f64>, bool)], prior: f64) -> Option<Fit> {
    let width = rows.first()?.0.len();
    let mut at = vec![0.0; width];
    for _ in 0..STEPS {
        let (gradient, information) = slope(rows, &at, prior);
        let step = solve(&information, &gradient)?;
        // Newton's step may leap where chances are near 0 or 1: it is halved until it gains.
        let before = likelihood(rows, &at, prior);
        let mut share = 1.0;
        let next = loop {
            let next: Vec<f64> = at.iter().zip(&step).map(|(a, s)| a + share * s).collect();
            if likelihood(rows, &next, prior) >= before || share < 1e-6 {
                break next;
            }
            share *= 0.5;
        };
        let moved = next.iter().zip(&at).map(|(a, b)| (a - b).abs());
        let moved = moved.fold(0.0, f64::max);
        at = next;
        if moved < 1e-10 {
            break;
        }
    }
    let (_, information) = slope(rows, &at, prior);
    let variance = |k: usize| {
        let unit: Vec<f64> = (0..width).map(|j| f64::from(u8::from(j == k))).collect();
        Some(solve(&information, &unit)?[k])
    };
    let errors = (0..width)
        .map(|k| variance(k).map(f64::sqrt))
        .collect::<Option<Vec<f64>>>()?;
    Some(Fit {
        coefficients: at,
        errors,
    })
}

/// The chance that a row is right.
pub(crate) fn chance(coefficients: &[f64], row: &[f64]) -> f64 {
    let sum: f64 = coefficients.iter().zip(row).map(|(c, x)| c * x).sum();
    1.0 / (1.0 + (-sum).exp())
}

/// Of a chance, kept off its ends.
pub(crate) fn logit(chance: f64) -> f64 {
    let p = chance.clamp(0.01, 0.99);
    (p / (1.0 - p)).ln()
}

fn likelihood(rows: &[(Vec<f64>, bool)], at: &[f64], prior: f64) -> f64 {
    let of = |(row, right): &(Vec<f64>, bool)| {
        let p = chance(at, row);
        (if *right { p } else { 1.0 - p }).max(1e-300).ln()
    };
    let penalty: f64 = at.iter().map(|a| 0.5 * (a / prior).powi(2)).sum();
    rows.iter().map(of).sum::<f64>() - penalty
}

/// Gradient of the likelihood and its information.
fn slope(rows: &[(Vec<f64>, bool)], at: &[f64], prior: f64) -> (Vec<f64>, Vec<Vec<f64>>) {
    let width = at.len();
    let weight = prior.powi(-2);
    let mut gradient: Vec<f64> = at.iter().map(|a| -weight * a).collect();
    let mut information = vec![vec![0.0; width]; width];
    for (k, row) in information.iter_mut().enumerate() {
        row[k] = weight;
    }
    for (row, right) in rows {
        let p = chance(at, row);
        for j in 0..width {
            gradient[j] += (f64::from(u8::from(*right)) - p) * row[j];
            for k in 0..width {
                information[j][k] += p * (1.0 - p) * row[j] * row[k];
            }
        }
    }
    (gradient, information)
}

/// Gaussian elimination with pivots; `None` where the matrix has no inverse.
fn solve(matrix: &[Vec<f64>], right: &[f64]) -> Option<Vec<f64>> {
    let n = right.len();
    let mut a: Vec<Vec<f64>> = matrix.to_vec();
    let mut b = right.to_vec();
    for k in 0..n {
        let pivot = (k..n).max_by(|i, j| a[*i][k].abs().total_cmp(&a[*j][k].abs()))?;
        if a[pivot][k].abs() < 1e-12 || !a[pivot][k].is_finite() {
            return None;
        }
        a.swap(k, pivot);
        b.swap(k, pivot);
        let (top, below) = a.split_at_mut(k + 1);
        let lead = &top[k];
        for (i, row) in below.iter_mut().enumerate() {
            let factor = row[k] / lead[k];
            for j in k..n {
                row[j] -= factor * lead[j];
            }
            b[k + 1 + i] -= factor * b[k];
        }
    }
    for k in (0..n).rev() {
        let known: f64 = (k + 1..n).map(|j| a[k][j] * b[j]).sum();
        b[k] = (b[k] - known) / a[k][k];
    }
    Some(b)
}

#[cfg(test)]
pub(crate) mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may")]
    use super::*;

    /// Evenly distributed numbers (SplitMix64, G. L. Steele and others 2014).
    pub(crate) struct Draw(pub(crate) u64);

    impl Draw {
        pub(crate) fn unit(&mut self) -> f64 {
            self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
            let mut z = self.0;
            z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
            z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
            ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
        }
    }

    fn drawn(n: usize, truth: &[f64], seed: u64) -> Vec<(Vec<f64>, bool)> {
        let mut draw = Draw(seed);
        let row = |draw: &mut Draw| -> Vec<f64> {
            let mut row = vec![1.0];
            row.extend((1..truth.len()).map(|_| 4.0 * draw.unit() - 2.0));
            row
        };
        (0..n)
            .map(|_| {
                let row = row(&mut draw);
                let right = draw.unit() < chance(truth, &row);
                (row, right)
            })
            .collect()
    }

    #[test]
    fn known_coefficients_are_recovered_within_their_errors() {
        let truth = [-0.9, 0.55, 0.5, -2.5];
        let fit = fit(&drawn(6000, &truth, 11), 10.0).unwrap();
        for ((found, error), truth) in fit.coefficients.iter().zip(&fit.errors).zip(truth) {
            assert!((found - truth).abs() < 3.0 * error, "{fit:?}");
            assert!(*error < 0.1, "{fit:?}");
        }
    }

    #[test]
    fn the_standard_error_is_the_scatter_of_repeated_samples() {
        let truth = [0.3, 1.0];
        let fits: Vec<Fit> = (0..200)
            .map(|seed| fit(&drawn(300, &truth, seed), 10.0).unwrap())
            .collect();
        let of: Vec<f64> = fits.iter().map(|f| f.coefficients[1]).collect();
        let mean = of.iter().sum::<f64>() / 200.0;
        let scatter = (of.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / 199.0).sqrt();
        let told = fits.iter().map(|f| f.errors[1]).sum::<f64>() / 200.0;
        assert!((told / scatter - 1.0).abs() < 0.15, "{told} {scatter}");
    }

    #[test]
    fn a_share_alone_gives_its_own_logit() {
        let rows: Vec<(Vec<f64>, bool)> = (0..100).map(|i| (vec![1.0], i < 80)).collect();
        let fit = fit(&rows, 1e6).unwrap();
        assert!((fit.coefficients[0] - logit(0.8)).abs() < 1e-9);
        // 1 / sqrt(n p (1 - p))
        assert!((fit.errors[0] - 0.25).abs() < 1e-9);
    }

    #[test]
    fn exchanging_right_and_wrong_turns_every_sign() {
        let rows = drawn(200, &[0.4, -1.2, 0.7], 5);
        let turned: Vec<_> = rows.iter().map(|(r, b)| (r.clone(), !b)).collect();
        let (a, b) = (fit(&rows, 10.0).unwrap(), fit(&turned, 10.0).unwrap());
        for (a, b) in a.coefficients.iter().zip(&b.coefficients) {
            assert!((a + b).abs() < 1e-6);
        }
    }

    #[test]
    fn what_separates_completely_stays_finite_and_nothing_tells_nothing() {
        let rows: Vec<(Vec<f64>, bool)> = (0..20)
            .map(|i| (vec![1.0, f64::from(i) - 9.5], i > 9))
            .collect();
        let fit_all = fit(&rows, 10.0).unwrap();
        assert!(fit_all.coefficients.iter().all(|c| c.is_finite()));
        assert!(fit_all.coefficients[1] > 1.0);
        assert_eq!(fit(&[], 10.0), None);
    }
}
