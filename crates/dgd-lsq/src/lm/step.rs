//! The algebra of one step: weighted squares, normal equations, the damped step in its box, Broyden's update.

use super::Bounds;
use nalgebra::{DMatrix, DVector};

/// Row weights: the mask's and the loss's.
fn weight(keep: Option<&[bool]>, weights: Option<&[f64]>, i: usize) -> f64 {
    if keep.is_some_and(|k| !k[i]) {
        return 0.0;
    }
    weights.map_or(1.0, |w| w[i])
}

/// What counts for nothing adds nothing, whatever it is.
fn weighed(weight: f64, value: f64) -> f64 {
    if weight == 0.0 { 0.0 } else { weight * value }
}

pub(super) fn half_square(r: &[f64], keep: Option<&[bool]>, weights: Option<&[f64]>) -> f64 {
    0.5 * r
        .iter()
        .enumerate()
        .map(|(i, r)| weighed(weight(keep, weights, i), r * r))
        .sum::<f64>()
}

/// What the cost would fall by along `d` were the residuals straight.
pub(super) fn promise(normal: &DMatrix<f64>, gradient: &DVector<f64>, d: &[f64]) -> f64 {
    let d = DVector::from_column_slice(d);
    -d.dot(gradient) - 0.5 * d.dot(&(normal * &d))
}

/// Broyden's update: what the step `d` taught of its own direction.
pub(super) fn broyden(jac: &mut DMatrix<f64>, d: &[f64], before: &[f64], after: &[f64]) {
    let square: f64 = d.iter().map(|d| d * d).sum();
    let expected = &*jac * DVector::from_column_slice(d);
    for i in 0..before.len() {
        let wrong = (after[i] - before[i] - expected[i]) / square;
        for (j, d) in d.iter().enumerate() {
            jac[(i, j)] += wrong * d;
        }
    }
}

/// `JᵀWJ` and `JᵀWr` of the kept rows.
pub(super) fn normal_equations(
    jac: &DMatrix<f64>,
    r: &[f64],
    keep: Option<&[bool]>,
    weights: Option<&[f64]>,
) -> (DMatrix<f64>, DVector<f64>) {
    let p = jac.ncols();
    let mut normal = DMatrix::zeros(p, p);
    let mut gradient = DVector::zeros(p);
    let weight: Vec<f64> = (0..r.len()).map(|i| weight(keep, weights, i)).collect();
    let mut weighted = vec![0.0; r.len()];
    for a in 0..p {
        for ((out, c), w) in weighted.iter_mut().zip(jac.column(a).iter()).zip(&weight) {
            *out = weighed(*w, *c);
        }
        for b in a..p {
            let column = jac.column(b);
            let products = weighted.iter().zip(column.iter()).zip(&weight);
            let sum: f64 = products
                .map(|((a, b), w)| if *w == 0.0 { 0.0 } else { a * b })
                .sum();
            normal[(a, b)] = sum;
            normal[(b, a)] = sum;
        }
        let pulls = weighted.iter().zip(r).zip(&weight);
        gradient[a] = pulls
            .map(|((a, r), w)| if *w == 0.0 { 0.0 } else { a * r })
            .sum();
    }
    (normal, gradient)
}

/// What a parameter must tell to be moved, beside the one that tells most.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Moved {
    /// Its squared slope is more than [`SLIGHT`]; damping takes it for [`STIFF`] at least, so that noise in a slope leads not far.
    Plain,
    /// It tells anything at all.
    All,
}

/// Share of the greatest squared slope up to which a parameter waits for the others.
const SLIGHT: f64 = 1e-12;
const STIFF: f64 = 1e-9;

/// Greatest squared slope.
fn steepest(normal: &DMatrix<f64>) -> f64 {
    (0..normal.nrows())
        .map(|i| normal[(i, i)])
        .fold(0.0_f64, f64::max)
}

/// Whether a parameter waits that tells anything.
pub(super) fn any_waits(normal: &DMatrix<f64>) -> bool {
    let least = SLIGHT * steepest(normal);
    (0..normal.nrows()).any(|i| normal[(i, i)] > 0.0 && normal[(i, i)] <= least)
}

/// Damped step in scaled parameters; those that would leave their bounds are held there and the rest solved again.
pub(super) fn step(
    normal: &DMatrix<f64>,
    gradient: &DVector<f64>,
    theta: &[f64],
    bounds: &Bounds,
    damping: f64,
    which: Moved,
) -> Option<Vec<f64>> {
    let p = theta.len();
    let top = steepest(normal);
    let (least, stiff) = match which {
        Moved::Plain => (SLIGHT * top, STIFF * top),
        Moved::All => (0.0, 0.0),
    };
    let at = |i: usize| (theta[i] - bounds.low[i]) / bounds.span(i);
    let mut fixed: Vec<Option<f64>> = (0..p)
        .map(|i| {
            let out = at(i) <= 0.0 && gradient[i] > 0.0 || at(i) >= 1.0 && gradient[i] < 0.0;
            (out || !(normal[(i, i)] > least)).then_some(0.0)
        })
        .collect();
    for _ in 0..=p {
        let moving: Vec<usize> = (0..p).filter(|&i| fixed[i].is_none()).collect();
        if moving.is_empty() {
            break;
        }
        let k = moving.len();
        let mut a = DMatrix::zeros(k, k);
        let mut b = DVector::zeros(k);
        for (m, &i) in moving.iter().enumerate() {
            for (n, &j) in moving.iter().enumerate() {
                a[(m, n)] = normal[(i, j)];
            }
            a[(m, m)] += damping * normal[(i, i)].max(stiff);
            b[m] = -gradient[i];
            for (j, f) in fixed.iter().enumerate() {
                b[m] -= f.map_or(0.0, |f| normal[(i, j)] * f);
            }
        }
        let solved = a.cholesky()?.solve(&b);
        let mut outside = false;
        for (m, &i) in moving.iter().enumerate() {
            let to = at(i) + solved[m];
            if !(0.0..=1.0).contains(&to) {
                fixed[i] = Some(to.clamp(0.0, 1.0) - at(i));
                outside = true;
            }
        }
        if !outside {
            for (m, &i) in moving.iter().enumerate() {
                fixed[i] = Some(solved[m]);
            }
            break;
        }
    }
    Some(fixed.into_iter().map(|f| f.unwrap_or(0.0)).collect())
}
