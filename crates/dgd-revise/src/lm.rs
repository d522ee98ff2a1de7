//! Levenberg-Marquardt within a box, over a choice of rows.
//!
//! Nocedal, J. and Wright, S. J., *Numerical Optimization* (2006), 10.3; variables at a bound whose gradient points
//! outwards are held (Bertsekas 1982). Between fresh Jacobians Broyden's update serves, because a fresh one costs a
//! simulation for each parameter.

use nalgebra::{DMatrix, DVector};

/// Bounds of the parameters.
#[derive(Debug, Clone, Default)]
pub(crate) struct Box_ {
    pub low: Vec<f64>,
    pub high: Vec<f64>,
}

impl Box_ {
    fn span(&self, i: usize) -> f64 {
        (self.high[i] - self.low[i]).max(1e-300)
    }

    pub(crate) fn clamp(&self, theta: &mut [f64]) {
        for (i, t) in theta.iter_mut().enumerate() {
            *t = t.max(self.low[i]).min(self.high[i]);
        }
    }
}

/// Where a minimisation ended.
#[derive(Debug, Clone)]
pub(crate) struct Minimum {
    pub theta: Vec<f64>,
    /// All rows, kept or not.
    pub residuals: Vec<f64>,
    /// Half the sum of squares of the kept rows; infinite if the start could not be run.
    pub cost: f64,
    /// By parameters scaled to 0..1 of their bounds, at or near `theta`; all rows.
    pub jacobian: DMatrix<f64>,
}

/// Residuals at `theta`; `None` if there are none.
pub(crate) type Residuals<'a> = dyn FnMut(&[f64]) -> Option<Vec<f64>> + 'a;

/// How far to go.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Effort {
    /// Steps tried.
    pub steps: usize,
    /// Relative gain of the cost below which it stops.
    pub tolerance: f64,
    /// Jacobians by differences, the first included if it is not known; between them Broyden's update.
    pub fresh: usize,
}

fn half_square(r: &[f64], keep: Option<&[bool]>) -> f64 {
    0.5 * match keep {
        Some(k) => r
            .iter()
            .zip(k)
            .filter(|(_, k)| **k)
            .map(|(r, _)| r * r)
            .sum::<f64>(),
        None => r.iter().map(|r| r * r).sum::<f64>(),
    }
}

/// Forward differences in scaled parameters.
pub(crate) fn jacobian(
    f: &mut Residuals<'_>,
    theta: &[f64],
    r: &[f64],
    bounds: &Box_,
) -> DMatrix<f64> {
    let mut out = DMatrix::zeros(r.len(), theta.len());
    let mut moved = theta.to_vec();
    for j in 0..theta.len() {
        let span = bounds.span(j);
        // Small beside the value where that is small beside its bounds.
        let size = 1e-4 * theta[j].abs().max(2e-3 * span).min(span);
        for way in [1.0, -1.0] {
            let way = if theta[j] + size > bounds.high[j] {
                -way
            } else {
                way
            };
            moved[j] = theta[j] + way * size;
            let step = (moved[j] - theta[j]) / span;
            // A parameter that cannot be moved keeps a column of zeros and stays where it is.
            if let Some(there) = f(&moved) {
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

/// Minimises over the rows in `keep` (all if `None`) from `start`, with the Jacobian there if it is known.
pub(crate) fn minimise(
    f: &mut Residuals<'_>,
    start: &[f64],
    bounds: &Box_,
    keep: Option<&[bool]>,
    known: Option<(&[f64], &DMatrix<f64>)>,
    effort: Effort,
) -> Minimum {
    let p = start.len();
    let mut theta = start.to_vec();
    bounds.clamp(&mut theta);
    let first = match known {
        Some((r, _)) => Some(r.to_vec()),
        None => f(&theta),
    };
    let Some(mut r) = first else {
        return Minimum {
            theta,
            residuals: Vec::new(),
            cost: f64::INFINITY,
            jacobian: DMatrix::zeros(0, p),
        };
    };
    let mut cost = half_square(&r, keep);
    let mut jac = match known {
        Some((_, j)) => j.clone(),
        None => jacobian(f, &theta, &r, bounds),
    };
    let (mut age, mut damping, mut done, mut small) = (0, 1e-3, 0, 0);
    let mut fresh = if known.is_some() { 0 } else { 1 };
    let mut refused = 0;
    while done < effort.steps && p > 0 && cost > 0.0 {
        done += 1;
        let (normal, gradient) = normal_equations(&jac, &r, keep);
        let step = step(&normal, &gradient, &theta, bounds, damping);
        let trial = step.map(|s| {
            let mut t = theta.clone();
            for i in 0..p {
                t[i] += s[i] * bounds.span(i);
            }
            bounds.clamp(&mut t);
            t
        });
        let Some(trial) = trial else {
            break;
        };
        let d: Vec<f64> = (0..p)
            .map(|i| (trial[i] - theta[i]) / bounds.span(i))
            .collect();
        if d.iter().all(|d| d.abs() < 1e-12) {
            break;
        }
        let there = f(&trial);
        let new = there
            .as_ref()
            .map_or(f64::INFINITY, |r| half_square(r, keep));
        if let Some(there) = there
            && new < cost
        {
            let gain = (cost - new) / cost;
            // Broyden: what the step taught of its own direction.
            let square: f64 = d.iter().map(|d| d * d).sum();
            let expected = &jac * DVector::from_column_slice(&d);
            for i in 0..r.len() {
                let wrong = (there[i] - r[i] - expected[i]) / square;
                for j in 0..p {
                    jac[(i, j)] += wrong * d[j];
                }
            }
            (theta, r, cost) = (trial, there, new);
            age += 1;
            refused = 0;
            damping = (damping * 0.3_f64).max(1e-9);
            small = if gain < effort.tolerance {
                small + 1
            } else {
                0
            };
            if small >= 2 {
                break;
            }
            // Two steps on one; more only while they lead far.
            if (age > 2 || gain < 0.02) && fresh < effort.fresh && done < effort.steps {
                jac = jacobian(f, &theta, &r, bounds);
                (age, fresh) = (0, fresh + 1);
            }
        } else if age > 0 && fresh < effort.fresh {
            // The fault may be the old Jacobian's.
            jac = jacobian(f, &theta, &r, bounds);
            (age, fresh) = (0, fresh + 1);
        } else {
            refused += 1;
            damping *= 8.0;
            if refused > 5 {
                break;
            }
        }
    }
    Minimum {
        theta,
        residuals: r,
        cost,
        jacobian: jac,
    }
}

/// `JᵀJ` and `Jᵀr` of the kept rows.
pub(crate) fn normal_equations(
    jac: &DMatrix<f64>,
    r: &[f64],
    keep: Option<&[bool]>,
) -> (DMatrix<f64>, DVector<f64>) {
    let p = jac.ncols();
    let mut normal = DMatrix::zeros(p, p);
    let mut gradient = DVector::zeros(p);
    let kept = |i: usize| keep.is_none_or(|k| k[i]);
    for a in 0..p {
        let ca = jac.column(a);
        for b in a..p {
            let cb = jac.column(b);
            let mut sum = 0.0;
            for i in 0..r.len() {
                if kept(i) {
                    sum += ca[i] * cb[i];
                }
            }
            normal[(a, b)] = sum;
            normal[(b, a)] = sum;
        }
        gradient[a] = (0..r.len())
            .filter(|&i| kept(i))
            .map(|i| ca[i] * r[i])
            .sum();
    }
    (normal, gradient)
}

/// Damped step in scaled parameters; those that would leave their bounds are held there and the rest solved again.
fn step(
    normal: &DMatrix<f64>,
    gradient: &DVector<f64>,
    theta: &[f64],
    bounds: &Box_,
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

    const EFFORT: Effort = Effort {
        steps: 200,
        tolerance: 1e-12,
        fresh: 100,
    };

    #[test]
    fn the_valley_is_followed_to_its_end() {
        let mut f = |t: &[f64]| Some(vec![10.0 * (t[1] - t[0] * t[0]), 1.0 - t[0]]);
        let bounds = Box_ {
            low: vec![-2.0; 2],
            high: vec![2.0; 2],
        };
        let found = minimise(&mut f, &[-1.2, 1.0], &bounds, None, None, EFFORT);
        assert!((found.theta[0] - 1.0).abs() < 1e-5, "{found:?}");
    }

    #[test]
    fn a_minimum_outside_the_box_is_met_at_its_wall() {
        let mut f = |t: &[f64]| Some(vec![t[0] + t[1] - 3.0, t[0] - t[1]]);
        let bounds = Box_ {
            low: vec![0.0; 2],
            high: vec![1.0, 5.0],
        };
        let found = minimise(&mut f, &[0.2, 4.0], &bounds, None, None, EFFORT);
        // With the first at 1: (b - 2)² + (b - 1)² is least at 1.5.
        assert!((found.theta[0] - 1.0).abs() < 1e-9 && (found.theta[1] - 1.5).abs() < 1e-6);
    }

    #[test]
    fn rows_left_out_do_not_pull() {
        let mut f = |t: &[f64]| Some(vec![t[0] - 0.3, t[0] - 0.9]);
        let bounds = Box_ {
            low: vec![0.0],
            high: vec![1.0],
        };
        let keep = [true, false];
        let found = minimise(&mut f, &[0.5], &bounds, Some(&keep), None, EFFORT);
        assert!((found.theta[0] - 0.3).abs() < 1e-6 && found.residuals.len() == 2);
    }
}
