//! Smooth curves through knots.

use crate::bayes::ln_mean_exp;
use dgd_effects::KNOTS;
use nalgebra::{DMatrix, DVector, SymmetricEigen};

/// Correlation lengths of the curve, in elevenths of it: constant, which only the mass balance has no term for; rough, smooth,
/// nearly straight.
const SMOOTHNESS: [f64; 4] = [f64::INFINITY, ROUGH, 2.5, 5.0];
/// Shortest correlation length, in knots.
const ROUGH: f64 = 1.2;

/// A smooth curve through the knots: a Gaussian process of one correlation length (Rasmussen and Williams 2006, chapter 2).
pub(super) struct Smooth {
    pub(super) coefficients: DVector<f64>,
    pub(super) evidence: f64,
    pub(super) freedom: f64,
}

impl Smooth {
    /// From normal equations of knots of unit prior width; `None` if they cannot be solved. A `round` curve ends where it begins.
    fn fit(gram: &DMatrix<f64>, right: &DVector<f64>, reach: f64, round: bool) -> Option<Self> {
        let n = right.len();
        let covariance = DMatrix::from_fn(n, n, |a, b| {
            let straight = a.abs_diff(b);
            let apart = if round {
                straight.min(n - 1 - straight)
            } else {
                straight
            };
            let apart = apart as f64 / reach;
            (-0.5 * apart * apart).exp()
        });
        let eigen = SymmetricEigen::try_new(covariance, 1e-12, 1000)?;
        let root = &eigen.eigenvectors
            * DMatrix::from_diagonal(&eigen.eigenvalues.map(|v| v.max(0.0).sqrt()));
        let own = root.transpose() * gram * &root;
        let pull = root.transpose() * right;
        let factor = (&own + DMatrix::identity(n, n)).cholesky()?;
        let solved = factor.solve(&pull);
        let ln_volume: f64 = factor.l().diagonal().iter().map(|d| d.ln()).sum();
        Some(Self {
            evidence: 0.5 * pull.dot(&solved) - ln_volume,
            freedom: factor.solve(&own).trace(),
            coefficients: root * solved,
        })
    }
}

/// A curve of each smoothness; a constant only where the relation has no term for it.
pub(super) fn smoothed(
    gram: &DMatrix<f64>,
    right: &DVector<f64>,
    constant: bool,
    round: bool,
) -> Vec<Smooth> {
    let apart = right.len().saturating_sub(1) as f64 / (KNOTS - 1) as f64;
    let finer = (right.len() > KNOTS).then_some(ROUGH);
    (SMOOTHNESS.iter().skip(usize::from(!constant)))
        .map(|reach| reach * apart)
        .chain(finer)
        .filter_map(|reach| Smooth::fit(gram, right, reach, round))
        .collect()
}

/// Evidence of one level throughout, or of a straight line where it may slope, of up to about one width; 0 if it cannot be told.
pub(super) fn of_straight(gram: &DMatrix<f64>, right: &DVector<f64>, slopes: bool) -> f64 {
    let last = right.len().saturating_sub(1).max(1) as f64;
    let terms = 1 + usize::from(slopes);
    let straight = DMatrix::from_fn(right.len(), terms, |knot, term| match term {
        0 => 1.0,
        _ => 2.0 * knot as f64 / last - 1.0,
    });
    let pull = straight.transpose() * right;
    let own = straight.transpose() * gram * &straight;
    let free = own + DMatrix::identity(terms, terms);
    free.cholesky().map_or(0.0, |factor| {
        let ln_volume: f64 = factor.l().diagonal().iter().map(|d| d.ln()).sum();
        0.5 * pull.dot(&factor.solve(&pull)) - ln_volume
    })
}

/// Evidence of curves of which none is likelier beforehand.
pub(super) fn weighed(curves: &[Smooth]) -> f64 {
    ln_mean_exp(curves.iter().map(|c| c.evidence))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may fail by panic")]

    use super::{DMatrix, DVector, KNOTS, Smooth, of_straight, smoothed, weighed};

    #[test]
    fn a_constant_curve_is_one_straight_parameter() {
        let gram = DMatrix::from_diagonal(&DVector::from_vec(vec![4.0, 9.0, 2.0]));
        let right = DVector::from_vec(vec![1.0, 5.0, 2.0]);
        let curve = Smooth::fit(&gram, &right, f64::INFINITY, false).unwrap();
        let (energy, score): (f64, f64) = (15.0, 8.0);
        let expected = 0.5 * score * score / (1.0 + energy) - 0.5 * (1.0 + energy).ln();
        assert!((curve.evidence - expected).abs() < 1e-9);
        assert!((curve.freedom - energy / (1.0 + energy)).abs() < 1e-9);
        assert!(curve.coefficients.iter().all(|c| (c - 0.5).abs() < 1e-9));
    }

    #[test]
    fn more_knots_draw_what_fewer_do_and_what_is_finer() {
        let curves = |count: usize, waves: f64, constant: bool| {
            let last = (count - 1) as f64;
            let gram = DMatrix::identity(count, count) * (600.0 / count as f64);
            let wave = |k: usize| (waves * std::f64::consts::TAU * k as f64 / last).sin();
            let right = DVector::from_fn(count, |k, _| 600.0 / count as f64 * wave(k));
            smoothed(&gram, &right, constant, false)
        };
        assert_eq!(curves(KNOTS, 1.0, false).len(), 3);
        assert_eq!(curves(KNOTS, 1.0, true).len(), 4);
        let fine = 3 * (KNOTS - 1) + 1;
        let (coarse, finer) = (curves(KNOTS, 1.0, false), curves(fine, 1.0, false));
        assert_eq!(finer.len(), 4);
        for (coarse, fine) in coarse.iter().zip(&finer) {
            assert!(
                (fine.evidence / coarse.evidence - 1.0).abs() < 0.1,
                "{} {}",
                fine.evidence,
                coarse.evidence
            );
        }
        // Eight waves in a third of a knot's reach each: only the finest follows.
        let eight = curves(fine, 8.0, false);
        assert!(
            eight[3].evidence > 50.0 + eight[0].evidence,
            "{}",
            eight[3].evidence
        );
    }

    #[test]
    fn a_round_curve_ends_where_it_begins() {
        let gram = DMatrix::identity(KNOTS, KNOTS) * 50.0;
        let right = DVector::from_fn(KNOTS, |k, _| 10.0 * k as f64);
        for curve in smoothed(&gram, &right, false, true) {
            let c = &curve.coefficients;
            assert!((c[0] - c[KNOTS - 1]).abs() < 1e-6, "{c}");
            assert!((c[0] - c[KNOTS - 2]).abs() > 1e-3, "{c}");
        }
    }

    #[test]
    fn knots_far_apart_are_free_and_a_smooth_curve_has_less_freedom() {
        let gram = DMatrix::identity(6, 6) * 50.0;
        let right = DVector::from_fn(6, |k, _| 10.0 * k as f64);
        let free = Smooth::fit(&gram, &right, 1e-3, false).unwrap();
        assert!((free.freedom - 6.0 * 50.0 / 51.0).abs() < 1e-9);
        assert!((free.coefficients[5] - 50.0 / 51.0).abs() < 1e-9);
        let smooth = Smooth::fit(&gram, &right, 4.0, false).unwrap();
        assert!(smooth.freedom < 0.7 * free.freedom);
        // A straight line is smooth: the stiffer curve explains it at a lower price.
        assert!(smooth.evidence > free.evidence);
    }

    #[test]
    fn a_straight_line_is_worth_as_much_as_the_curve_that_is_one_and_little_of_a_bump() {
        // Each knot is told to a tenth of its width.
        let gram = DMatrix::from_diagonal_element(KNOTS, KNOTS, 100.0);
        let place = |k: usize| 2.0 * k as f64 / (KNOTS - 1) as f64 - 1.0;
        let of = |curve: &dyn Fn(f64) -> f64, slopes: bool| {
            let right = DVector::from_fn(KNOTS, |k, _| 100.0 * curve(place(k)));
            let whole = weighed(&smoothed(&gram, &right, false, false));
            (of_straight(&gram, &right, slopes), whole)
        };
        let (level, whole) = of(&|_| 0.7, false);
        assert!(level > 0.97 * whole && whole > 100.0, "{level} {whole}");
        let line = |x: f64| 0.5 - 0.4 * x;
        let (level, _) = of(&line, false);
        let (straight, whole) = of(&line, true);
        assert!(
            straight > 0.95 * whole && level < 0.9 * whole,
            "{level} {straight} {whole}"
        );
        let (straight, whole) = of(&|x: f64| (-20.0 * x * x).exp(), true);
        assert!(straight < 0.5 * whole, "{straight} {whole}");
    }
}
