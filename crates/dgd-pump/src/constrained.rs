//! Least squares with the signs of the thesis (Eq. 3.44) as bounds: a small quadratic programme.

use crate::fit::{check_exponents, check_head, reduce};
use crate::{CONDITION_LIMIT, CurveFit, HeadCurve, PumpError, Samples};
use clarabel::algebra::CscMatrix;
use clarabel::solver::{
    DefaultSettings, DefaultSolver, IPSolver, NonnegativeConeT, SolverStatus as Clarabel,
};
use dgd_lsq::{Fit, Reduced};

/// What [`fit_constrained`] holds the coefficients to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ConstrainedOptions {
    /// Least share of the head that the c1 and the c2 term must have, each by itself, in root mean square
    /// over the samples: the ε of `c1, c2 >= ε > 0`, free of units. Default 1e-6.
    pub floor_share: f64,
    /// Iterations allowed to the interior-point solver. Default 200.
    pub max_iterations: u32,
}

impl Default for ConstrainedOptions {
    fn default() -> Self {
        Self {
            floor_share: 1e-6,
            max_iterations: 200,
        }
    }
}

/// How the quadratic programme ended. The coefficients are to be used after the first two, or if they are polished
/// ([`ConstrainedFit::polished`]).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum SolverStatus {
    /// Solved to full accuracy.
    Solved,
    /// Solved to reduced accuracy.
    AlmostSolved,
    /// Reported infeasible: not possible for bounds of this kind, so a numerical failure.
    Infeasible,
    /// Iteration limit reached.
    IterationLimit,
    /// Time limit reached (none is set).
    TimeLimit,
    /// Numerical error, or no progress.
    NumericalFailure,
    /// Did not run, or was stopped from outside.
    NotRun,
}

impl From<Clarabel> for SolverStatus {
    fn from(status: Clarabel) -> Self {
        match status {
            Clarabel::Solved => Self::Solved,
            Clarabel::AlmostSolved => Self::AlmostSolved,
            Clarabel::PrimalInfeasible
            | Clarabel::DualInfeasible
            | Clarabel::AlmostPrimalInfeasible
            | Clarabel::AlmostDualInfeasible => Self::Infeasible,
            Clarabel::MaxIterations => Self::IterationLimit,
            Clarabel::MaxTime => Self::TimeLimit,
            Clarabel::NumericalError | Clarabel::InsufficientProgress => Self::NumericalFailure,
            Clarabel::Unsolved | Clarabel::CallbackTerminated => Self::NotRun,
        }
    }
}

/// A head curve fitted under sign bounds.
#[derive(Debug, Clone, PartialEq)]
pub struct ConstrainedFit {
    /// The fit; standard errors are `None` for coefficients at a bound, and those of the others take
    /// the bound as given.
    pub fit: CurveFit,
    /// Least allowed c0, c1, c2, in their units (0 for c0).
    pub floors: [f64; 3],
    /// Which of c0, c1, c2 sit at their floor.
    pub active: [bool; 3],
    /// How the solver ended.
    pub status: SolverStatus,
    /// Largest violation of the optimality conditions (stationarity, bounds, signs of multipliers), in the
    /// scaled problem where columns and head have unit length. Below 1e-9 when all is well, infinite if a coefficient is no number.
    pub kkt_residual: f64,
    /// Whether the solver's answer was refined by solving for the free coefficients alone; then it meets the optimality conditions, whatever
    /// the status.
    pub polished: bool,
}

/// Fits c0, c1, c2 for given exponents with `c0 >= 0` and `c1, c2 >= ε > 0`.
///
/// The problem is scaled to columns and head of unit length, solved by an interior-point method
/// (Clarabel, tolerances 1e-12), and polished: the coefficients found at their bounds are held there and the rest is
/// solved by least squares on the triangle. The polished answer is kept only if it meets the
/// optimality conditions: then it is the optimum even where the solver ran into its limit. Where it is not kept, match the status: after an
/// iteration limit or a numerical failure the coefficients are only where the solver stopped.
///
/// # Errors
/// Those of [`fit_unconstrained`](crate::fit_unconstrained); [`PumpError::Domain`] on a floor share
/// outside 0 to 1 (0 excluded) or a head of 0 in all kept samples; [`PumpError::Solver`] if the solver does not accept the problem.
///
/// # Source
/// Thesis Eqs. 3.31 and 3.44; against all active sets: `tests/it/constrained.rs`. Solver: Goulart
/// and Chen, Clarabel (2024).
pub fn fit_constrained(
    samples: &Samples,
    n0: f64,
    n2: f64,
    options: &ConstrainedOptions,
) -> Result<ConstrainedFit, PumpError> {
    samples.check()?;
    check_exponents(n0, n2)?;
    options.check()?;
    let reduced = reduce(samples, n0, n2)?;
    let free = reduced.solve(CONDITION_LIMIT)?;
    constrain(&reduced, &free, (n0, n2), options)
}

/// The answers of [`fit_unconstrained`](crate::fit_unconstrained) and of [`fit_constrained`] at the same exponents,
/// for one pass over the samples.
///
/// # Errors
/// Each answer has its own; where both would be refused they are refused alike.
pub fn fit_free_and_constrained(
    samples: &Samples,
    n0: f64,
    n2: f64,
    options: &ConstrainedOptions,
) -> (
    Result<CurveFit, PumpError>,
    Result<ConstrainedFit, PumpError>,
) {
    let free = || {
        samples.check()?;
        check_exponents(n0, n2)?;
        let reduced = reduce(samples, n0, n2)?;
        let free = reduced.solve(CONDITION_LIMIT)?;
        Ok((reduced, free))
    };
    match free() {
        Ok((reduced, free)) => {
            let bounded =
                (options.check()).and_then(|()| constrain(&reduced, &free, (n0, n2), options));
            (Ok(CurveFit::from_free(&free, n0, n2)), bounded)
        }
        Err(refusal) => (Err(PumpError::clone(&refusal)), Err(refusal)),
    }
}

impl ConstrainedOptions {
    fn check(&self) -> Result<(), PumpError> {
        let share = self.floor_share;
        if share > 0.0 && share < 1.0 {
            return Ok(());
        }
        Err(PumpError::Domain {
            name: "floor_share",
            found: share,
            expected: "a share above 0 and below 1",
        })
    }
}

/// The fit under bounds from the triangle of the rows and the fit without bounds.
fn constrain(
    reduced: &Reduced,
    free: &Fit,
    (n0, n2): (f64, f64),
    options: &ConstrainedOptions,
) -> Result<ConstrainedFit, PumpError> {
    check_head(reduced.column_norm(3))?;
    let share = options.floor_share;
    let scaled = Scaled::new(reduced, [0.0, share, share]);
    let (status, solution) = scaled.solve(options.max_iterations)?;

    let floors = [0, 1, 2].map(|j| scaled.floors[j] * scaled.unit(j));
    let (x, active, polished) = match scaled.polish(&solution) {
        Some((x, active)) => (x, active, true),
        None => (solution.x, solution.active(), false),
    };
    // A held coefficient is its floor to the last bit; the scaled one is that to rounding.
    let c = [0, 1, 2].map(|j| {
        if active[j] {
            floors[j]
        } else {
            x[j] * scaled.unit(j)
        }
    });
    let held: Vec<(usize, f64)> = (0..3).filter(|&j| active[j]).map(|j| (j, c[j])).collect();
    let mut fit = CurveFit::from_free(free, n0, n2);
    fit.curve = HeadCurve {
        c0: c[0],
        c1: c[1],
        c2: c[2],
        n0,
        n2,
    };
    let rss = residual_squares(reduced, c);
    let degrees = fit.n.saturating_sub(3 - held.len() as u64);
    #[expect(clippy::cast_precision_loss, reason = "row counts stay far below 2^53")]
    let degrees = degrees as f64;
    fit.mse_m2 = rss / degrees;
    let total = reduced.total_about_mean();
    fit.r2 = if total > 0.0 {
        1.0 - rss / total
    } else {
        f64::NAN
    };
    if !held.is_empty() {
        fit.standard_errors = [None; 3];
        if held.len() < 3 {
            let rest = reduced.hold(&held)?.solve(CONDITION_LIMIT)?;
            let mut errors = rest.standard_errors.into_iter();
            for (se, _) in fit
                .standard_errors
                .iter_mut()
                .zip(active)
                .filter(|(_, active)| !active)
            {
                *se = errors.next();
            }
        }
    }
    Ok(ConstrainedFit {
        fit,
        floors,
        active,
        status,
        kkt_residual: scaled.kkt(x, active),
        polished,
    })
}

fn residual_squares(reduced: &Reduced, c: [f64; 3]) -> f64 {
    (0..4)
        .map(|i| {
            let fitted: f64 = (0..3).map(|j| reduced.r(i, j) * c[j]).sum();
            (reduced.r(i, 3) - fitted).powi(2)
        })
        .sum()
}

/// `min ½ x'Px - b'x` over `x >= floors`, with `x_j = c_j · |column j| / |H|`.
struct Scaled {
    gram: [[f64; 3]; 3],
    b: [f64; 3],
    floors: [f64; 3],
    units: [f64; 3],
    reduced: Reduced,
}

struct Solution {
    x: [f64; 3],
    slack: [f64; 3],
    multiplier: [f64; 3],
}

impl Solution {
    /// At an optimum one of slack and multiplier is zero: the larger one tells which.
    fn active(&self) -> [bool; 3] {
        [0, 1, 2].map(|j| self.multiplier[j] > self.slack[j])
    }
}

impl Scaled {
    fn new(reduced: &Reduced, floors: [f64; 3]) -> Self {
        let norms = [0, 1, 2].map(|j| reduced.column_norm(j));
        let size = reduced.column_norm(3);
        let r = |i: usize, j: usize| reduced.r(i, j) / norms[j];
        let inner = |i: usize, f: &dyn Fn(usize) -> f64| (0..3).map(|k| r(k, i) * f(k)).sum();
        Self {
            gram: [0, 1, 2].map(|i| [0, 1, 2].map(|j| inner(i, &|k| r(k, j)))),
            b: [0, 1, 2].map(|i| inner(i, &|k| reduced.r(k, 3) / size)),
            floors,
            units: norms.map(|norm| size / norm),
            reduced: reduced.clone(),
        }
    }

    fn unit(&self, j: usize) -> f64 {
        self.units[j]
    }

    fn solve(&self, max_iter: u32) -> Result<(SolverStatus, Solution), PumpError> {
        let p = CscMatrix::from(&self.gram).to_triu();
        let a = CscMatrix::from(&[[-1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, -1.0]]);
        let settings = DefaultSettings {
            verbose: false,
            max_iter,
            max_threads: 1,
            tol_gap_abs: 1e-12,
            tol_gap_rel: 1e-12,
            tol_feas: 1e-12,
            ..DefaultSettings::default()
        };
        let mut solver = DefaultSolver::new(
            &p,
            &self.b.map(|b| -b),
            &a,
            &self.floors.map(|floor| -floor),
            &[NonnegativeConeT(3)],
            settings,
        )
        .map_err(|_| PumpError::Solver)?;
        solver.solve();
        let triple = |v: &[f64]| <[f64; 3]>::try_from(v).map_err(|_| PumpError::Solver);
        Ok((
            solver.solution.status.into(),
            Solution {
                x: triple(&solver.solution.x)?,
                slack: triple(&solver.solution.s)?,
                multiplier: triple(&solver.solution.z)?,
            },
        ))
    }

    /// The exact answer on the set of held coefficients that is optimal: mostly the one the solver points to. Where columns are nearly alike,
    /// its interior point lies too far off to tell, and the other seven are tried.
    fn polish(&self, solution: &Solution) -> Option<([f64; 3], [bool; 3])> {
        let pointed = solution.active();
        let all = (0..8_u8).map(|set| [0, 1, 2].map(|j| set >> j & 1 == 1));
        let sets = std::iter::once(pointed).chain(all.filter(|set| *set != pointed));
        (sets.filter_map(|active| Some((self.holding(active)?, active))))
            .find(|(x, active)| self.kkt(*x, *active) < 1e-9)
    }

    /// The least squares with these coefficients held at their floors.
    fn holding(&self, active: [bool; 3]) -> Option<[f64; 3]> {
        let mut x = self.floors;
        let held: Vec<(usize, f64)> = (0..3)
            .filter(|&j| active[j])
            .map(|j| (j, self.floors[j] * self.units[j]))
            .collect();
        if held.len() < 3 {
            let rest = self.reduced.hold(&held).ok()?.solve(f64::INFINITY).ok()?;
            let mut free = rest.coefficients.iter();
            for j in (0..3).filter(|&j| !active[j]) {
                x[j] = free.next()? / self.units[j];
            }
        }
        Some(x)
    }

    /// Largest violation of the Karush-Kuhn-Tucker conditions; infinite where a number is missing.
    fn kkt(&self, x: [f64; 3], active: [bool; 3]) -> f64 {
        // `f64::max` leaves a NaN out.
        let worse = |a: f64, b: f64| {
            if a.is_nan() || b.is_nan() {
                f64::INFINITY
            } else {
                a.max(b)
            }
        };
        (0..3)
            .map(|j| {
                let gradient = (0..3).map(|k| self.gram[j][k] * x[k]).sum::<f64>() - self.b[j];
                let bound = x[j] - self.floors[j];
                if active[j] {
                    // The multiplier is the gradient: it must not be negative.
                    worse(bound.abs(), -gradient)
                } else {
                    worse(gradient.abs(), -bound)
                }
            })
            .fold(0.0, worse)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `min ½ x'x - b'x` over `x >= floors`: every condition can be read off.
    fn plain(b: [f64; 3], floors: [f64; 3]) -> Scaled {
        let mut rows = dgd_lsq::Accumulator::new(["a", "b", "c"]).expect("three names");
        for j in 0..3 {
            let mut row = [0.0; 3];
            row[j] = 1.0;
            rows.push(&row, b[j]).expect("finite rows");
        }
        rows.push(&[0.0; 3], 1.0).expect("finite rows");
        Scaled {
            gram: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
            b,
            floors,
            units: [1.0; 3],
            reduced: rows.reduce(),
        }
    }

    #[test]
    fn each_broken_condition_is_the_residual_by_as_much_as_it_is_broken() {
        let problem = plain([0.5, -0.25, 0.75], [0.0, 0.125, 0.125]);
        let optimum = [0.5, 0.125, 0.75];
        let held = [false, true, false];
        assert_eq!(problem.kkt(optimum, held), 0.0);
        // Not stationary, above and below.
        assert_eq!(problem.kkt([0.75, 0.125, 0.75], held), 0.25);
        assert_eq!(problem.kkt([0.5, 0.125, 0.625], held), 0.125);
        // Held away from its bound, on either side of it.
        assert_eq!(problem.kkt([0.5, 0.1875, 0.75], held), 0.0625);
        assert_eq!(problem.kkt([0.5, 0.0625, 0.75], held), 0.0625);
        // Free, stationary and below its floor.
        assert_eq!(problem.kkt([0.5, -0.25, 0.75], [false; 3]), 0.375);
        // Held though it would rather rise.
        assert_eq!(problem.kkt([0.5, 0.125, 0.125], [false, true, true]), 0.625);
    }

    #[test]
    fn a_missing_number_is_no_optimum() {
        let problem = plain([0.5, -0.25, 0.75], [0.0, 0.125, 0.125]);
        let nan = f64::NAN;
        for held in [[false; 3], [false, true, false], [true; 3]] {
            for x in [[nan; 3], [nan, 0.125, 0.75], [0.5, nan, 0.75]] {
                assert_eq!(problem.kkt(x, held), f64::INFINITY);
            }
        }
    }

    #[test]
    fn the_larger_of_slack_and_multiplier_tells_what_is_held() {
        let solution = Solution {
            x: [0.0; 3],
            slack: [0.5, 1e-9, 0.0],
            multiplier: [1e-9, 0.5, 0.0],
        };
        assert_eq!(solution.active(), [false, true, false]);
    }

    #[test]
    fn the_optimum_is_found_whatever_set_the_solver_points_to() {
        let problem = plain([0.5, -0.25, 0.75], [0.0, 0.125, 0.125]);
        let pointing = |active: [bool; 3]| Solution {
            x: [0.0; 3],
            slack: active.map(|a| if a { 0.0 } else { 1.0 }),
            multiplier: active.map(|a| if a { 1.0 } else { 0.0 }),
        };
        let right = [false, true, false];
        for pointed in [right, [false; 3], [true, true, false], [true; 3]] {
            let (x, active) = problem.polish(&pointing(pointed)).expect("an optimum");
            assert_eq!(active, right, "{pointed:?}");
            for (x, truth) in x.into_iter().zip([0.5, 0.125, 0.75]) {
                assert!((x - truth).abs() < 1e-15);
            }
        }
        // What is no number has none.
        let lost = Scaled {
            b: [f64::NAN, -0.25, 0.75],
            ..problem
        };
        assert!(lost.polish(&pointing(right)).is_none());
    }
}
