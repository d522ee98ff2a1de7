//! Levenberg-Marquardt within a box, over a choice of rows.
//!
//! Nocedal, J. and Wright, S. J., *Numerical Optimization* (2006), 10.3; variables at a bound whose gradient points
//! outwards are held (Bertsekas 1982). Between fresh Jacobians Broyden's update serves where one costs a simulation for each
//! parameter.

use crate::LsqError;
use nalgebra::{DMatrix, DVector};

/// The box that the parameters are sought in; that of no parameter by default.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Bounds {
    low: Vec<f64>,
    high: Vec<f64>,
}

impl Bounds {
    /// From the least and the greatest values, shape `(p,)` each, in the units of the parameters. Where the two are equal the parameter
    /// is held.
    ///
    /// Steps are taken in shares of the box, so none may be infinite: where nothing is known, a generous number will do.
    ///
    /// # Errors
    /// [`LsqError::BoundCount`] if the two differ in length; [`LsqError::Bound`] with the first parameter whose bounds are not finite, not
    /// finitely apart or not in order.
    ///
    /// ```
    /// use dgd_lsq::{LsqError, lm::Bounds};
    /// assert_eq!(Bounds::new(vec![0.0], vec![2.0])?.span(0), 2.0);
    /// assert!(Bounds::new(vec![0.0], vec![f64::INFINITY]).is_err());
    /// # Ok::<(), LsqError>(())
    /// ```
    pub fn new(low: Vec<f64>, high: Vec<f64>) -> Result<Self, LsqError> {
        if low.len() != high.len() {
            return Err(LsqError::BoundCount {
                low: low.len(),
                high: high.len(),
            });
        }
        for (index, (&low, &high)) in low.iter().zip(&high).enumerate() {
            // Negated, so that a NaN is refused too.
            if !(low <= high && (high - low).is_finite()) {
                return Err(LsqError::Bound { index, low, high });
            }
        }
        Ok(Self { low, high })
    }

    /// From 0 to 1 for each of `p` parameters.
    #[must_use]
    pub fn unit(p: usize) -> Self {
        Self {
            low: vec![0.0; p],
            high: vec![1.0; p],
        }
    }

    /// Least values, shape `(p,)`.
    #[must_use]
    pub fn low(&self) -> &[f64] {
        &self.low
    }

    /// Greatest values, shape `(p,)`.
    #[must_use]
    pub fn high(&self) -> &[f64] {
        &self.high
    }

    /// Width of the box along parameter `i`; never 0.
    ///
    /// # Panics
    /// On a parameter that there is not.
    #[must_use]
    pub fn span(&self, i: usize) -> f64 {
        (self.high[i] - self.low[i]).max(1e-300)
    }

    /// Puts `theta`, shape `(p,)`, inside; a NaN stays one.
    ///
    /// # Panics
    /// On more values than parameters.
    pub fn clamp(&self, theta: &mut [f64]) {
        for (i, t) in theta.iter_mut().enumerate() {
            *t = t.clamp(self.low[i], self.high[i]);
        }
    }
}

/// What is minimised: half the sum of squares of the residuals. Closures of `theta` are such.
pub trait Residuals {
    /// Residuals at `theta`, shape `(n,)`; `None` if there are none. Those of another length than at the start count as none.
    fn at(&mut self, theta: &[f64]) -> Option<Vec<f64>>;

    /// `∂residual/∂parameter` by parameters scaled to 0..1 of their bounds, shape `(n, p)`, where the residuals are `r`;
    /// `None` if there is none. By forward [`differences`] unless written otherwise.
    ///
    /// ```
    /// use dgd_lsq::lm::{Bounds, Effort, Residuals, minimise};
    /// use dgd_lsq::nalgebra::DMatrix;
    /// struct Line;
    /// impl Residuals for Line {
    ///     fn at(&mut self, t: &[f64]) -> Option<Vec<f64>> {
    ///         Some(vec![2.0 * t[0] - 3.0])
    ///     }
    ///     fn jacobian(&mut self, _: &[f64], _: &[f64], bounds: &Bounds) -> Option<DMatrix<f64>> {
    ///         Some(DMatrix::from_element(1, 1, 2.0 * bounds.span(0)))
    ///     }
    /// }
    /// let bounds = Bounds::new(vec![0.0], vec![5.0])?;
    /// let found = minimise(&mut Line, &[0.0], &bounds, None, None, Effort::default());
    /// assert!((found.theta[0] - 1.5).abs() < 1e-9);
    /// # Ok::<(), dgd_lsq::LsqError>(())
    /// ```
    fn jacobian(&mut self, theta: &[f64], r: &[f64], bounds: &Bounds) -> Option<DMatrix<f64>> {
        Some(differences(self, theta, r, bounds))
    }

    /// Weights of the squares, for a robust loss, shape `(n,)`; all 1 if absent.
    fn weights(&self, r: &[f64]) -> Option<Vec<f64>> {
        let _ = r;
        None
    }
}

impl<F: FnMut(&[f64]) -> Option<Vec<f64>> + ?Sized> Residuals for F {
    fn at(&mut self, theta: &[f64]) -> Option<Vec<f64>> {
        self(theta)
    }
}

/// Where a minimisation ended.
#[derive(Debug, Clone, PartialEq)]
pub struct Minimum {
    /// Parameters, shape `(p,)`.
    pub theta: Vec<f64>,
    /// All rows, kept or not; empty if the start could not be run.
    pub residuals: Vec<f64>,
    /// Half the weighted sum of squares of the kept rows; infinite if the start could not be run.
    pub cost: f64,
    /// By parameters scaled to 0..1 of their bounds, at or near `theta`; all rows.
    pub jacobian: DMatrix<f64>,
    /// Steps tried.
    pub steps: usize,
    /// How it ended.
    pub ending: Ending,
}

/// How a minimisation ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Ending {
    /// At a minimum, to the tolerance; or, after a gain, as near to one as the residuals can tell.
    Converged,
    /// [`Effort::steps`] were used up.
    StepLimit,
    /// No step lowered the cost, though the Jacobian promises more than the tolerance: the residuals have a kink, or their Jacobian is wrong.
    /// Or there was no Jacobian, or none of numbers.
    NoProgress,
    /// The start has a NaN, or another length than the bounds; or there are no residuals there, or a kept one is not a number.
    NoStart,
}

/// How far to go.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Effort {
    /// Steps tried.
    pub steps: usize,
    /// Relative gain of the cost below which it stops, twice in a row.
    pub tolerance: f64,
    /// Jacobians, the first included if it is not known.
    pub fresh: usize,
    /// Steps that may be taken on one Jacobian, updated, before there is a fresh one; more are where no more is left.
    pub stale: usize,
    /// Refusals in a row, each with eight times the damping, before it gives up.
    pub patience: usize,
}

impl Default for Effort {
    /// A fresh Jacobian at each step, to the end.
    fn default() -> Self {
        Self {
            steps: 100,
            tolerance: 1e-9,
            fresh: usize::MAX,
            stale: 0,
            patience: 14,
        }
    }
}

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

fn half_square(r: &[f64], keep: Option<&[bool]>, weights: Option<&[f64]>) -> f64 {
    0.5 * r
        .iter()
        .enumerate()
        .map(|(i, r)| weighed(weight(keep, weights, i), r * r))
        .sum::<f64>()
}

/// Jacobian by forward differences in scaled parameters, a ten-thousandth of the value (of a 500th of the bounds at least); to the
/// other side where that leaves the bounds or has no residuals, or another number of them. A parameter that cannot be moved gets zeros. Nothing outside the bounds is asked for.
///
/// # Panics
/// On bounds that are fewer than the parameters.
pub fn differences<R: Residuals + ?Sized>(
    problem: &mut R,
    theta: &[f64],
    r: &[f64],
    bounds: &Bounds,
) -> DMatrix<f64> {
    let mut out = DMatrix::zeros(r.len(), theta.len());
    let mut moved = theta.to_vec();
    for j in 0..theta.len() {
        let span = bounds.span(j);
        // Small beside the value where that is small beside its bounds.
        let size = 1e-4 * theta[j].abs().max(2e-3 * span).min(span);
        for to in [theta[j] + size, theta[j] - size] {
            if to < bounds.low[j] || to > bounds.high[j] {
                continue;
            }
            moved[j] = to;
            let step = (moved[j] - theta[j]) / span;
            if step == 0.0 {
                // Held by bounds that meet, or by the last digit.
                break;
            }
            if let Some(there) = problem.at(&moved).filter(|there| there.len() == r.len()) {
                for ((o, a), b) in out.column_mut(j).iter_mut().zip(&there).zip(r) {
                    *o = (a - b) / step;
                }
                break;
            }
        }
        moved[j] = theta[j];
    }
    out
}

/// Minimises within `bounds` from `start`, shape `(p,)` and put inside them, over the rows in `keep` (all if `None`), with residuals and Jacobian at the start if they
/// are `known`.
///
/// A minimisation that ended badly is a result too: [`Minimum::ending`].
///
/// # Panics
/// On a mask, weights or a Jacobian that are fewer than the residuals, or a Jacobian of fewer columns than parameters.
///
/// ```
/// use dgd_lsq::lm::{Bounds, Effort, minimise};
/// // An exponential through three points.
/// let mut rows = |t: &[f64]| {
///     let points = [(0.0, 2.0), (1.0, 1.0), (2.0, 0.5)];
///     Some(points.iter().map(|(x, y): &(f64, f64)| t[0] * (-t[1] * x).exp() - y).collect::<Vec<f64>>())
/// };
/// let bounds = Bounds::new(vec![0.0; 2], vec![5.0; 2])?;
/// let found = minimise(&mut rows, &[1.0, 1.0], &bounds, None, None, Effort::default());
/// assert!((found.theta[1] - 2.0_f64.ln()).abs() < 1e-6);
/// # Ok::<(), dgd_lsq::LsqError>(())
/// ```
pub fn minimise<R: Residuals + ?Sized>(
    problem: &mut R,
    start: &[f64],
    bounds: &Bounds,
    keep: Option<&[bool]>,
    known: Option<(&[f64], &DMatrix<f64>)>,
    effort: Effort,
) -> Minimum {
    let p = start.len();
    let nowhere = |theta, ending| Minimum {
        theta,
        residuals: Vec::new(),
        cost: f64::INFINITY,
        jacobian: DMatrix::zeros(0, p),
        steps: 0,
        ending,
    };
    let mut theta = start.to_vec();
    if p != bounds.low.len() || start.iter().any(|t| t.is_nan()) {
        return nowhere(theta, Ending::NoStart);
    }
    bounds.clamp(&mut theta);
    let first = match known {
        Some((r, _)) => Some(r.to_vec()),
        None => problem.at(&theta),
    };
    let Some(mut r) = first else {
        return nowhere(theta, Ending::NoStart);
    };
    let jac = match known {
        Some((_, j)) => Some(j.clone()),
        None => problem.jacobian(&theta, &r, bounds),
    };
    let Some(mut jac) = jac else {
        return Minimum {
            cost: half_square(&r, keep, problem.weights(&r).as_deref()),
            residuals: r,
            ..nowhere(theta, Ending::NoProgress)
        };
    };
    let (mut age, mut damping, mut done, mut small, mut refused) = (0, 1e-3, 0, 0, 0);
    let mut fresh: usize = if known.is_some() { 0 } else { 1 };
    let mut ending = Ending::StepLimit;
    let (mut gained, mut promised) = (false, 0.0);
    // Where no step is accepted it is flat as far as the residuals can tell, if one was before or none was worth taking.
    let given_up = |gained: bool, promised: f64| {
        if gained || promised < effort.tolerance {
            Ending::Converged
        } else {
            Ending::NoProgress
        }
    };
    while done < effort.steps {
        // A robust loss weighs anew at each step; within it costs are compared by the same weights.
        let weights = problem.weights(&r);
        let weights = weights.as_deref();
        let cost = half_square(&r, keep, weights);
        if cost.is_nan() {
            ending = Ending::NoStart;
            break;
        }
        if p == 0 || cost <= 0.0 {
            ending = Ending::Converged;
            break;
        }
        done += 1;
        let (normal, gradient) = normal_equations(&jac, &r, keep, weights);
        let trial = step(&normal, &gradient, &theta, bounds, damping).map(|s| {
            let mut t = theta.clone();
            for i in 0..p {
                t[i] += s[i] * bounds.span(i);
            }
            bounds.clamp(&mut t);
            t
        });
        // A Jacobian with a NaN leads nowhere.
        let Some(trial) = trial.filter(|t| !t.iter().any(|t| t.is_nan())) else {
            ending = Ending::NoProgress;
            break;
        };
        let d: Vec<f64> = (0..p)
            .map(|i| (trial[i] - theta[i]) / bounds.span(i))
            .collect();
        if refused == 0 {
            promised = promise(&normal, &gradient, &d) / cost;
        }
        if d.iter().all(|d| d.abs() < 1e-12) {
            // Damping makes any step small.
            ending = if refused == 0 {
                Ending::Converged
            } else {
                given_up(gained, promised)
            };
            break;
        }
        let there = problem.at(&trial).filter(|there| there.len() == r.len());
        let new = there
            .as_ref()
            .map_or(f64::INFINITY, |r| half_square(r, keep, weights));
        if let Some(there) = there
            && new < cost
        {
            let gain = (cost - new) / cost;
            broyden(&mut jac, &d, &r, &there);
            (theta, r) = (trial, there);
            (age, refused, gained) = (age + 1, 0, true);
            damping = (damping * 0.3_f64).max(1e-9);
            small = if gain < effort.tolerance {
                small + 1
            } else {
                0
            };
            if small >= 2 {
                ending = Ending::Converged;
                break;
            }
            // Several steps on one; more only while they lead far.
            let due = age > effort.stale || gain < 0.02;
            if due && fresh < effort.fresh && done < effort.steps {
                let Some(j) = problem.jacobian(&theta, &r, bounds) else {
                    ending = Ending::NoProgress;
                    break;
                };
                (jac, age, fresh) = (j, 0, fresh + 1);
            }
        } else if age > 0 && fresh < effort.fresh {
            // The fault may be the old Jacobian's.
            let Some(j) = problem.jacobian(&theta, &r, bounds) else {
                ending = Ending::NoProgress;
                break;
            };
            (jac, age, fresh) = (j, 0, fresh + 1);
        } else {
            refused += 1;
            damping *= 8.0;
            if refused > effort.patience {
                ending = given_up(gained, promised);
                break;
            }
        }
    }
    Minimum {
        cost: half_square(&r, keep, problem.weights(&r).as_deref()),
        theta,
        residuals: r,
        jacobian: jac,
        steps: done,
        ending,
    }
}

/// What the cost would fall by along `d` were the residuals straight.
fn promise(normal: &DMatrix<f64>, gradient: &DVector<f64>, d: &[f64]) -> f64 {
    let d = DVector::from_column_slice(d);
    -d.dot(gradient) - 0.5 * d.dot(&(normal * &d))
}

/// Broyden's update: what the step `d` taught of its own direction.
fn broyden(jac: &mut DMatrix<f64>, d: &[f64], before: &[f64], after: &[f64]) {
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
fn normal_equations(
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

/// Damped step in scaled parameters; those that would leave their bounds are held there and the rest solved again.
fn step(
    normal: &DMatrix<f64>,
    gradient: &DVector<f64>,
    theta: &[f64],
    bounds: &Bounds,
    damping: f64,
) -> Option<Vec<f64>> {
    let p = theta.len();
    let top = (0..p).map(|i| normal[(i, i)]).fold(0.0_f64, f64::max);
    let at = |i: usize| (theta[i] - bounds.low[i]) / bounds.span(i);
    let mut fixed: Vec<Option<f64>> = (0..p)
        .map(|i| {
            let out = at(i) <= 0.0 && gradient[i] > 0.0 || at(i) >= 1.0 && gradient[i] < 0.0;
            (out || !(normal[(i, i)] > 1e-12 * top)).then_some(0.0)
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
            a[(m, m)] += damping * normal[(i, i)].max(1e-9 * top);
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

#[cfg(test)]
mod tests {
    use super::*;

    const SPARING: Effort = Effort {
        steps: 200,
        tolerance: 1e-12,
        fresh: 100,
        stale: 2,
        patience: 5,
    };

    fn within(low: &[f64], high: &[f64]) -> Bounds {
        Bounds::new(low.to_vec(), high.to_vec()).expect("bounds in order")
    }

    fn cube(low: f64, high: f64) -> Bounds {
        within(&[low; 2], &[high; 2])
    }

    #[test]
    fn the_valley_is_followed_to_its_end_with_few_jacobians_and_with_many() {
        let mut f = |t: &[f64]| Some(vec![10.0 * (t[1] - t[0] * t[0]), 1.0 - t[0]]);
        for effort in [SPARING, Effort::default()] {
            let found = minimise(&mut f, &[-1.2, 1.0], &cube(-2.0, 2.0), None, None, effort);
            assert!((found.theta[0] - 1.0).abs() < 1e-5, "{found:?}");
            assert_eq!(found.ending, Ending::Converged);
        }
    }

    #[test]
    fn a_minimum_outside_the_box_is_met_at_its_wall() {
        let mut f = |t: &[f64]| Some(vec![t[0] + t[1] - 3.0, t[0] - t[1]]);
        let bounds = within(&[0.0; 2], &[1.0, 5.0]);
        let found = minimise(&mut f, &[0.2, 4.0], &bounds, None, None, SPARING);
        // With the first at 1: (b - 2)² + (b - 1)² is least at 1.5.
        assert!((found.theta[0] - 1.0).abs() < 1e-9 && (found.theta[1] - 1.5).abs() < 1e-6);
    }

    #[test]
    fn rows_left_out_do_not_pull() {
        let mut f = |t: &[f64]| Some(vec![t[0] - 0.3, t[0] - 0.9]);
        let bounds = within(&[0.0], &[1.0]);
        let keep = [true, false];
        let found = minimise(&mut f, &[0.5], &bounds, Some(&keep), None, SPARING);
        assert!((found.theta[0] - 0.3).abs() < 1e-6 && found.residuals.len() == 2);
    }

    struct Weighted;
    impl Residuals for Weighted {
        fn at(&mut self, t: &[f64]) -> Option<Vec<f64>> {
            Some(vec![t[0], t[0] - 1.0])
        }
        fn weights(&self, _: &[f64]) -> Option<Vec<f64>> {
            Some(vec![3.0, 1.0])
        }
    }

    #[test]
    fn a_row_of_three_times_the_weight_pulls_three_times_as_much() {
        let bounds = within(&[-1.0], &[1.0]);
        let found = minimise(
            &mut Weighted,
            &[0.9],
            &bounds,
            None,
            None,
            Effort::default(),
        );
        assert!((found.theta[0] - 0.25).abs() < 1e-9);
        assert!((found.cost - 0.5 * (3.0 * 0.0625 + 0.5625)).abs() < 1e-9);
    }

    #[test]
    fn rows_that_do_not_count_may_be_anything_and_those_that_do_must_be_numbers() {
        let mut holed = |t: &[f64]| Some(vec![f64::NAN, t[0] - 0.3]);
        let start = |f: &mut dyn FnMut(&[f64]) -> Option<Vec<f64>>, keep: Option<&[bool]>| {
            minimise(f, &[0.5], &Bounds::unit(1), keep, None, Effort::default())
        };
        let found = start(&mut holed, Some(&[false, true]));
        assert_eq!(found.ending, Ending::Converged);
        assert!((found.theta[0] - 0.3).abs() < 1e-9, "{:?}", found.theta);
        assert_eq!(start(&mut holed, None).ending, Ending::NoStart);
    }

    #[test]
    fn a_parameter_whose_bounds_meet_is_held_and_the_others_go_on() {
        let bounds = within(&[0.0, 0.0, 3.0], &[1.0, 1.0, 3.0]);
        let mut f = |t: &[f64]| Some(vec![t[1] - 0.7, t[0] - 0.4, 0.1 * (t[2] - 3.0)]);
        let found = minimise(
            &mut f,
            &[0.5, 0.5, 3.0],
            &bounds,
            None,
            None,
            Effort::default(),
        );
        assert_eq!(found.ending, Ending::Converged);
        assert!((found.theta[0] - 0.4).abs() < 1e-8 && (found.theta[1] - 0.7).abs() < 1e-8);
        assert_eq!(found.theta[2], 3.0);
        assert!(found.jacobian.iter().all(|v| v.is_finite()));
    }

    /// Where there are no residuals to the one side, the other may lie outside.
    #[test]
    fn differences_ask_for_nothing_outside_the_bounds() {
        let bounds = within(&[0.0, -1.0], &[1.0, 1.0]);
        for theta in [[0.0, -1.0], [1.0, 1.0], [0.5, 0.0], [1e-5, 1.0 - 1e-5]] {
            for refused in 0..3_usize {
                let mut asked = Vec::new();
                let mut rows = |t: &[f64]| {
                    asked.push(t.to_vec());
                    (asked.len() > refused).then(|| vec![3.0 * t[0], t[1]])
                };
                let start = [3.0 * theta[0], theta[1]];
                let slopes = differences(&mut rows, &theta, &start, &bounds);
                if refused == 0 {
                    assert!((slopes[(0, 0)] - 3.0).abs() < 1e-9 && slopes[(1, 0)] == 0.0);
                    assert!((slopes[(1, 1)] - 2.0).abs() < 1e-9, "by half the box");
                }
                let inside = |t: &Vec<f64>| {
                    (t.iter().zip(&bounds.low)).all(|(t, low)| t >= low)
                        && (t.iter().zip(&bounds.high)).all(|(t, high)| t <= high)
                };
                assert!(asked.iter().all(inside), "{theta:?} {refused}: {asked:?}");
            }
        }
    }

    #[test]
    fn a_start_that_cannot_be_run_and_one_that_cannot_be_left_are_told() {
        let bounds = within(&[0.0], &[1.0]);
        let mut none = |_: &[f64]| None::<Vec<f64>>;
        let found = minimise(&mut none, &[0.5], &bounds, None, None, SPARING);
        assert!(found.ending == Ending::NoStart && found.cost.is_infinite());
        // The differences promise descent, no step keeps it. A high kink has a short step, which damping alone makes tiny.
        for kink in [1e-3, 2e-2, 5e-2] {
            let mut kinked = |t: &[f64]| Some(vec![1.0 + if t[0] == 0.5 { 0.0 } else { kink }]);
            for effort in [SPARING, Effort::default()] {
                let found = minimise(&mut kinked, &[0.5], &bounds, None, None, effort);
                assert_eq!((found.ending, found.theta[0]), (Ending::NoProgress, 0.5));
            }
        }
    }

    #[test]
    fn bounds_that_cannot_be_are_refused_with_the_parameter() {
        let wrong = [
            [1.0, 0.0],
            [f64::NAN, 1.0],
            [0.0, f64::NAN],
            [f64::NEG_INFINITY, 1.0],
            [0.0, f64::INFINITY],
            [-1e308, 1e308],
        ];
        for [low, high] in wrong {
            let refusal = Bounds::new(vec![0.0, low], vec![1.0, high]);
            assert!(matches!(refusal, Err(LsqError::Bound { index: 1, .. })));
        }
        let refusal = Bounds::new(vec![0.0], Vec::new());
        assert_eq!(refusal, Err(LsqError::BoundCount { low: 1, high: 0 }));
        assert_eq!(Bounds::unit(2), cube(0.0, 1.0));
    }

    #[test]
    fn a_start_of_another_length_or_that_is_no_number_is_none() {
        let mut f = |t: &[f64]| Some(vec![t.iter().sum::<f64>() - 0.3]);
        let starts: [&[f64]; 4] = [&[], &[0.5], &[0.5; 3], &[0.5, f64::NAN]];
        for start in starts {
            let none = minimise(&mut f, start, &cube(0.0, 1.0), None, None, SPARING);
            assert_eq!((none.ending, none.steps), (Ending::NoStart, 0));
            assert!(none.cost.is_infinite() && none.theta.len() == start.len());
        }
        // What is infinite has a nearest place inside.
        let start = [f64::INFINITY, f64::NEG_INFINITY];
        let found = minimise(&mut f, &start, &cube(0.0, 1.0), None, None, SPARING);
        assert_eq!(found.ending, Ending::Converged);
        let none = minimise(
            &mut f,
            &[0.5],
            &Bounds::default(),
            None,
            None,
            Effort::default(),
        );
        assert_eq!(none.ending, Ending::NoStart);
    }

    #[test]
    fn residuals_of_another_length_are_none() {
        // As many as there are readings on the way, of which there are fewer beyond 0.6.
        let mut f = |t: &[f64]| Some(vec![t[0] - 0.7; if t[0] > 0.6 { 1 } else { 2 }]);
        let bounds = within(&[0.0], &[1.0]);
        let found = minimise(&mut f, &[0.2], &bounds, None, None, Effort::default());
        assert!(
            found.residuals.len() == 2 && found.theta[0] <= 0.6,
            "{found:?}"
        );
        // The slope at the edge is that of the other side.
        let slope = differences(&mut f, &[0.6], &[-0.1; 2], &bounds);
        assert!((slope[(0, 0)] - 1.0).abs() < 1e-9 && (slope[(1, 0)] - 1.0).abs() < 1e-9);
    }

    #[test]
    fn a_jacobian_that_is_no_number_ends_where_it_began() {
        let mut asked = 0;
        let mut f = |t: &[f64]| {
            asked += 1;
            assert!(!t[0].is_nan());
            Some(vec![t[0] + t[1], t[1] - 0.2])
        };
        let (r, slopes) = ([1.0, 0.3], DMatrix::from_element(2, 2, f64::NAN));
        let known = Some((&r[..], &slopes));
        let found = minimise(&mut f, &[0.5; 2], &cube(0.0, 1.0), None, known, SPARING);
        assert!(found.theta == [0.5; 2] && found.ending != Ending::StepLimit);
        let half = DMatrix::from_row_slice(2, 2, &[1.0, f64::NAN, 0.0, 1.0]);
        let known = Some((&r[..], &half));
        let found = minimise(&mut f, &[0.5; 2], &cube(0.0, 1.0), None, known, SPARING);
        assert_eq!(
            (found.ending, found.theta),
            (Ending::NoProgress, vec![0.5; 2])
        );
        assert_eq!(asked, 0);
    }

    #[test]
    fn a_start_at_the_minimum_has_converged_though_nothing_is_gained() {
        let bounds = within(&[0.0], &[1.0]);
        let mut f = |t: &[f64]| Some(vec![t[0] - 0.3, t[0] - 0.9, 0.1 * (5.0 * t[0]).sin()]);
        let found = minimise(&mut f, &[0.5], &bounds, None, None, Effort::default());
        for effort in [SPARING, Effort::default()] {
            let again = minimise(&mut f, &found.theta, &bounds, None, None, effort);
            assert_eq!(again.ending, Ending::Converged, "{again:?}");
        }
    }
}
