//! Levenberg-Marquardt within a box, in variables scaled to 0..1.
//!
//! Nocedal, J. and Wright, S. J., *Numerical Optimization* (2006), 10.3; damping after Nielsen, H. B., IMM-REP-1999-05, DTU;
//! variables at a bound whose gradient points outwards are held (projected Newton, Bertsekas 1982).

use nalgebra::{DMatrix, DVector};

/// What is minimised: half the sum of squares of `residuals`.
pub(crate) trait Residuals {
    /// Residuals at `z`; `None` if there are none.
    fn at(&mut self, z: &[f64]) -> Option<Vec<f64>>;
    /// `∂residual/∂z` at `z`, where the residuals are `r`.
    fn jacobian(&mut self, z: &[f64], r: &[f64]) -> Option<DMatrix<f64>>;
    /// Weights of the residuals, for a robust loss; all 1 if it is not.
    fn weights(&self, r: &[f64]) -> Option<Vec<f64>>;
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Ending {
    Converged,
    IterationLimit,
    NoProgress,
    NoStart,
}

#[derive(Debug, Clone)]
pub(crate) struct Minimum {
    pub z: Vec<f64>,
    pub residuals: Vec<f64>,
    pub cost: f64,
    pub iterations: usize,
    pub ending: Ending,
}

fn cost(r: &[f64], weights: Option<&[f64]>) -> f64 {
    match weights {
        Some(w) => 0.5 * r.iter().zip(w).map(|(r, w)| w * r * r).sum::<f64>(),
        None => 0.5 * r.iter().map(|r| r * r).sum::<f64>(),
    }
}

/// Minimises from `start`; `tolerance` is the relative gain in cost below which it stops.
pub(crate) fn minimise(
    problem: &mut impl Residuals,
    start: &[f64],
    iterations: usize,
    tolerance: f64,
) -> Minimum {
    let n = start.len();
    let mut z: Vec<f64> = start.iter().map(|v| v.clamp(0.0, 1.0)).collect();
    let Some(mut r) = problem.at(&z) else {
        return Minimum {
            z,
            residuals: Vec::new(),
            cost: f64::INFINITY,
            iterations: 0,
            ending: Ending::NoStart,
        };
    };
    let mut damping = 1e-3;
    let mut growth = 2.0;
    let mut ending = Ending::IterationLimit;
    let mut done = 0;
    let mut small = 0;
    'outer: while done < iterations {
        let weights = problem.weights(&r);
        let now = cost(&r, weights.as_deref());
        let Some(jacobian) = problem.jacobian(&z, &r) else {
            ending = Ending::NoProgress;
            break;
        };
        let mut weighted = jacobian.clone();
        if let Some(w) = &weights {
            for (mut row, w) in weighted.row_iter_mut().zip(w) {
                row *= *w;
            }
        }
        let normal = weighted.transpose() * &jacobian;
        let gradient = weighted.transpose() * DVector::from_column_slice(&r);
        // Held: at a bound, with the descent leading out.
        let moving: Vec<usize> = (0..n)
            .filter(|&i| !(z[i] <= 0.0 && gradient[i] > 0.0 || z[i] >= 1.0 && gradient[i] < 0.0))
            .collect();
        if moving.is_empty()
            || moving
                .iter()
                .all(|&i| gradient[i].abs() <= 1e-14 * (1.0 + now))
        {
            ending = Ending::Converged;
            break;
        }
        loop {
            done += 1;
            let k = moving.len();
            let mut a = DMatrix::zeros(k, k);
            let mut b = DVector::zeros(k);
            let top = moving
                .iter()
                .map(|&i| normal[(i, i)])
                .fold(0.0_f64, f64::max);
            for (p, &i) in moving.iter().enumerate() {
                for (q, &j) in moving.iter().enumerate() {
                    a[(p, q)] = normal[(i, j)];
                }
                // A parameter that nothing depends on stays put instead of flying off.
                a[(p, p)] += damping * normal[(i, i)].max(1e-9 * top) + 1e-300;
                b[p] = -gradient[i];
            }
            let step = a.cholesky().map(|c| c.solve(&b));
            let mut trial = z.clone();
            if let Some(step) = &step {
                for (p, &i) in moving.iter().enumerate() {
                    trial[i] = (z[i] + step[p]).clamp(0.0, 1.0);
                }
            }
            let moved: f64 = trial
                .iter()
                .zip(&z)
                .map(|(a, b)| (a - b).abs())
                .fold(0.0, f64::max);
            if step.is_some() && moved < 1e-12 {
                ending = Ending::Converged;
                break 'outer;
            }
            let after = step.and_then(|_| problem.at(&trial));
            let new = after
                .as_ref()
                .map_or(f64::INFINITY, |r| cost(r, weights.as_deref()));
            if let Some(after) = after
                && new < now
            {
                let d = DVector::from_iterator(n, trial.iter().zip(&z).map(|(a, b)| a - b));
                let promised = -(gradient.dot(&d) + 0.5 * (&normal * &d).dot(&d));
                let ratio = (now - new) / promised.max(1e-300);
                damping *= (1.0 - (2.0 * ratio - 1.0).powi(3)).max(1.0 / 3.0);
                damping = damping.max(1e-12);
                growth = 2.0;
                (z, r) = (trial, after);
                // Two small gains in a row: one may be an unlucky damping.
                small = if now - new <= tolerance * now {
                    small + 1
                } else {
                    0
                };
                if small == 2 {
                    ending = Ending::Converged;
                    break 'outer;
                }
                break;
            }
            damping *= growth;
            growth *= 2.0;
            if damping > 1e12 {
                // No descent although the gradient says so: as flat as the simulation can tell.
                ending = if small > 0 || done > 15 {
                    Ending::Converged
                } else {
                    Ending::NoProgress
                };
                break 'outer;
            }
            if done >= iterations {
                break 'outer;
            }
        }
    }
    let weights = problem.weights(&r);
    let cost = cost(&r, weights.as_deref());
    Minimum {
        z,
        residuals: r,
        cost,
        iterations: done,
        ending,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Rosenbrock;
    impl Residuals for Rosenbrock {
        fn at(&mut self, z: &[f64]) -> Option<Vec<f64>> {
            let (x, y) = (4.0 * z[0] - 2.0, 4.0 * z[1] - 2.0);
            Some(vec![10.0 * (y - x * x), 1.0 - x])
        }
        fn jacobian(&mut self, z: &[f64], _: &[f64]) -> Option<DMatrix<f64>> {
            let x = 4.0 * z[0] - 2.0;
            Some(DMatrix::from_row_slice(2, 2, &[-80.0 * x, 40.0, -4.0, 0.0]))
        }
        fn weights(&self, _: &[f64]) -> Option<Vec<f64>> {
            None
        }
    }

    #[test]
    fn the_valley_is_followed_to_its_end() {
        let found = minimise(&mut Rosenbrock, &[0.2, 0.75], 200, 1e-14);
        assert!(
            (found.z[0] - 0.75).abs() < 1e-8 && (found.z[1] - 0.75).abs() < 1e-8,
            "{found:?}"
        );
        assert_eq!(found.ending, Ending::Converged);
    }

    struct Cornered;
    impl Residuals for Cornered {
        fn at(&mut self, z: &[f64]) -> Option<Vec<f64>> {
            Some(vec![z[0] + 1.0, z[1] - 0.3])
        }
        fn jacobian(&mut self, _: &[f64], _: &[f64]) -> Option<DMatrix<f64>> {
            Some(DMatrix::identity(2, 2))
        }
        fn weights(&self, _: &[f64]) -> Option<Vec<f64>> {
            None
        }
    }

    #[test]
    fn a_minimum_outside_the_box_is_met_at_its_wall() {
        let found = minimise(&mut Cornered, &[0.5, 0.9], 50, 1e-12);
        assert_eq!(found.z[0], 0.0);
        assert!((found.z[1] - 0.3).abs() < 1e-9);
    }
}
