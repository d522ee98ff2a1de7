//! The exponents of the head curve by Nelder-Mead: thesis section 3.4.2.

use std::cell::RefCell;
use std::ops::RangeInclusive;
use std::sync::{Arc, Mutex};

use argmin::core::observers::{Observe, ObserverMode};
use argmin::core::{CostFunction, Error, Executor, IterState, KV, State, TerminationReason};
use argmin::solver::neldermead::NelderMead;
use nalgebra::Vector2;

use crate::fit::{check_head, reduce_powers};
use crate::joint::{JointErrors, joint_errors};
use crate::pass::hash;
use crate::table::Table;
use crate::{CONDITION_LIMIT, CurveFit, PumpError, Samples};

/// Side of the first simplex as a share of the start, as in MATLAB's `fminsearch`.
const SIMPLEX: f64 = 0.05;

/// Share of the mean squared head to which sums of the table are rounded.
const ROUNDING: f64 = 3e-14;

/// Share of the mean squared head below which errors are as good as none.
const CLOSE: f64 = 1e-6;

/// A term with less than this share of the head counts as gone, for [`Limit`].
const GONE: f64 = 1e-4;

/// Pairs per exponent tried when the start is not feasible.
const GRID: u32 = 13;

/// Trials of a search by [`Rule::Refuse`] that are looked at again, each by a pass over the rows, where the best does not comply.
const CONFIRMED: usize = 64;

/// Places kept of powers already taken, as a power of 2.
const MEMO_BITS: u32 = 14;

/// What becomes of exponents whose least-squares estimates break `c1, c2 > 0` (thesis Eq. 3.44).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Rule {
    /// The offending coefficient is held at 0 and the others are fitted: least squares under `c1, c2 >= 0`.
    /// The cost is continuous, so the search cannot come to rest against a wall. An optimum with
    /// `c1, c2 > 0` is the same as by the other rule.
    #[default]
    Hold,
    /// The pair is refused, cost infinite: the procedure of the thesis. A simplex against the wall of refused
    /// pairs flattens and may stop far from the best of them, see [`SearchStatus::AtWall`].
    Refuse,
}

/// How to search.
#[derive(Debug, Clone, PartialEq)]
pub struct SearchOptions {
    /// What becomes of exponents that break the conditions on c1 and c2. Default [`Rule::Hold`].
    pub rule: Rule,
    /// First guess of (n0, n2). Default (1.9, 1.6).
    pub start: (f64, f64),
    /// Allowed n0; from 0.1 to 10, fixed where both ends are one. Default 1 to 4: below 1 the slope at standstill is infinite, and simulations (`dgd-dynamics`) refuse the curve.
    pub n0: RangeInclusive<f64>,
    /// Allowed n2; from 1, which itself is excluded (thesis Eq. 3.44), to 10, fixed where both ends are one. Default 1 to 4.
    pub n2: RangeInclusive<f64>,
    /// Stop a search when the costs of the simplex scatter by less than this share of the best, and
    /// the whole when no restart gains more. Default 1e-9.
    pub tolerance: f64,
    /// Most iterations of one search. Default 400.
    pub max_iterations: u64,
    /// Most new searches from the best point so far; 0 is a single search. Default 20.
    pub restarts: u32,
}

impl Default for SearchOptions {
    fn default() -> Self {
        Self {
            rule: Rule::default(),
            start: (1.9, 1.6),
            n0: 1.0..=4.0,
            n2: 1.0..=4.0,
            tolerance: 1e-9,
            max_iterations: 400,
            restarts: 20,
        }
    }
}

impl SearchOptions {
    /// The exponents that a corner of the simplex stands for: one that is fixed does not move with it.
    fn pair(&self, corner: &Vector2<f64>) -> (f64, f64) {
        let exponent = |range: &RangeInclusive<f64>, n: f64| {
            if range.start() == range.end() {
                *range.start()
            } else {
                n
            }
        };
        (exponent(&self.n0, corner[0]), exponent(&self.n2, corner[1]))
    }
}

/// How the search ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum SearchStatus {
    /// Converged, and restarts found nothing better.
    Converged,
    /// Converged by [`Rule::Refuse`] beside refused pairs (c1 or c2 next to 0): a better pair may lie along
    /// that wall, or across it.
    AtWall,
    /// The last search converged, but restarts were used up (or not allowed) before they stopped gaining.
    RestartLimit,
    /// The last search that gained ran into the iteration limit.
    IterationLimit,
    /// The optimiser stopped for a reason of its own.
    Stopped,
}

/// A limit of the model that the optimum rests on: the data would like to go beyond.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Limit {
    /// c1 is next to 0: its term has less than 1e-4 of the head.
    C1Zero,
    /// c2 is next to 0: its term has less than 1e-4 of the head.
    C2Zero,
    /// n2 is at the lower end of its range (1 is where concavity ends).
    N2Lower,
    /// n2 is at the upper end of its range.
    N2Upper,
    /// n0 is at the lower end of its range.
    N0Lower,
    /// n0 is at the upper end of its range.
    N0Upper,
}

/// A pair of exponents that was evaluated, in order.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Trial {
    /// Search it belongs to: 0 is the first, 1 and up are restarts.
    pub search: u32,
    /// Exponent of the speed.
    pub n0: f64,
    /// Exponent of the flow.
    pub n2: f64,
    /// Mean squared error (over n - 3), m²; `None` where the pair is refused: out of range, or by
    /// [`Rule::Refuse`] with c1 or c2 not above 0.
    pub mse_m2: Option<f64>,
}

/// Best corner of the simplex after an iteration: the path of thesis Figure 3.10.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PathPoint {
    /// Search it belongs to: 0 is the first, 1 and up are restarts.
    pub search: u32,
    /// Iteration of that search; 0 is the start.
    pub iteration: u64,
    /// Exponent of the speed.
    pub n0: f64,
    /// Exponent of the flow.
    pub n2: f64,
    /// Mean squared error, m².
    pub mse_m2: f64,
}

/// The exponents found, the fit there, and how it came about.
#[derive(Debug, Clone, PartialEq)]
pub struct ExponentSearch {
    /// Fit by QR at the best exponents; its standard errors take the exponents as known, which makes that of c0 far too small: see
    /// [`Self::joint`].
    pub fit: CurveFit,
    /// Standard errors of coefficients and exponents together; `None` where the rows do not tell them apart.
    pub joint: Option<JointErrors>,
    /// How the search ended.
    pub status: SearchStatus,
    /// Limits the optimum rests on; empty for an optimum in the open.
    pub limits: Vec<Limit>,
    /// Where the first search started: the guess, or the best of a grid if the guess is not feasible.
    pub start: (f64, f64),
    /// Where the first search ended: what the thesis' procedure gives without restarts.
    pub first: PathPoint,
    /// Best corner by iteration.
    pub path: Vec<PathPoint>,
    /// Every pair evaluated, in order.
    pub trials: Vec<Trial>,
    /// Difference between the mean squared error the search saw (by interpolated sums) and that of the QR fit, relative to it
    /// and a millionth of the mean squared head together: what fits closer than to a thousandth of the head is told apart no
    /// further. About 1e-10; the search is not to be trusted above 1e-6.
    pub table_error: f64,
}

/// Searches the exponents (n0, n2) of least mean squared error for a falling, concave curve.
///
/// - `samples`: speed, flow (delay taken out), head and which to use.
///
/// For each pair c0, c1, c2 are the least-squares estimates and the cost is their mean squared
/// error; `n2 > 1` always, and pairs with c1 or c2 not above 0 are treated as the [`Rule`] says. Nelder-Mead is restarted
/// from the best point with simplices of all four orientations until none gains. If `start` is
/// refused, the best of a 13 × 13 grid over the ranges is taken instead.
///
/// Evaluations do not touch the rows: one pass takes the sums of the normal equations at 28 × 28 Chebyshev
/// nodes of the exponents, and a pair costs under a microsecond. The final fit is by QR over the rows and checks this.
///
/// # Errors
/// Those of [`fit_unconstrained`](crate::fit_unconstrained); [`PumpError::Range`] on exponents out of domain; [`PumpError::Domain`] on a
/// start or a tolerance out of domain, no kept sample with speed and flow above 0, a head of 0 in all of them, or one that is upside down:
/// best met with c0 below 0; [`PumpError::NoFeasibleExponents`].
///
/// # Source
/// Thesis Eqs. 3.39-3.44 and Figure 3.10; recovery of known exponents: `tests/it/search.rs`.
pub fn search_exponents(
    samples: &Samples,
    options: &SearchOptions,
) -> Result<ExponentSearch, PumpError> {
    samples.check()?;
    check(options)?;
    let table = Table::new(samples, &options.n0, &options.n2)?;
    if table.rows() <= 3 {
        // The fit itself says what is missing.
        crate::fit_unconstrained(samples, options.start.0, options.start.1)?;
    }
    check_head(table.mean_square_head())?;
    let log = RefCell::new(Vec::new());
    let path = Arc::new(Mutex::new(Vec::new()));
    let cost = |search| Cost {
        table: &table,
        options,
        log: &log,
        search,
    };
    let start = feasible_start(&cost(0)).ok_or_else(|| refusal(samples, options, &log))?;

    let mut best = start;
    let mut first = None;
    let mut status = SearchStatus::RestartLimit;
    let mut idle = 0;
    for search in 0..=options.restarts {
        let signs = [(1.0, 1.0), (-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0)][search as usize % 4];
        let run = run(cost(search), best, signs, &path);
        let gained = run.mse < best.mse - tell(options, &table, best.mse);
        if run.mse < best.mse {
            best = run.point();
        }
        first.get_or_insert(run.last);
        idle = if gained { 0 } else { idle + 1 };
        status = match run.ended {
            SearchStatus::Converged if idle < 4 => SearchStatus::RestartLimit,
            ended => ended,
        };
        // All four orientations of the simplex have been tried from here.
        if idle == 4 {
            break;
        }
    }
    let mut found = fit_at(samples, &table, options.rule, &best)?;
    if options.rule == Rule::Refuse && !complies(&found.fit) {
        (best, found) = confirmed(samples, &table, &log.borrow())?;
    }
    let FitAt { fit, shares, rss } = found;
    if fit.curve.c0 < 0.0 {
        return Err(PumpError::Domain {
            name: "c0",
            found: fit.curve.c0,
            expected: "a head that rises with the speed, c0 of at least 0",
        });
    }
    let limits = limits(shares, options, &best);
    let walled = limits.contains(&Limit::C1Zero) || limits.contains(&Limit::C2Zero);
    if options.rule == Rule::Refuse && walled && status == SearchStatus::Converged {
        status = SearchStatus::AtWall;
    }
    // The search counts three coefficients whether held or not.
    #[expect(clippy::cast_precision_loss, reason = "row counts stay far below 2^53")]
    let [seen, squares] = [
        best.mse * (fit.n - 3) as f64,
        table.mean_square_head() * fit.n as f64,
    ];
    let path = path.lock().map(|path| path.clone()).unwrap_or_default();
    Ok(ExponentSearch {
        joint: joint_errors(samples, &fit, &limits, options),
        limits,
        table_error: (seen - rss).abs() / (rss + CLOSE * squares),
        fit,
        status,
        start: (start.n0, start.n2),
        first: first.unwrap_or(PathPoint {
            search: 0,
            iteration: 0,
            n0: start.n0,
            n2: start.n2,
            mse_m2: start.mse,
        }),
        path,
        trials: log.into_inner(),
    })
}

/// The fit by QR of the rows at a pair of exponents.
struct FitAt {
    fit: CurveFit,
    /// Of the c1 and the c2 term in the head, by the table; 0 where held there.
    shares: [f64; 2],
    /// Residual sum of squares, m².
    rss: f64,
}

fn fit_at(samples: &Samples, table: &Table, rule: Rule, at: &Point) -> Result<FitAt, PumpError> {
    let reduced = {
        let speed = Memo::new(at.n0);
        let flow = Memo::new(at.n2);
        reduce_powers(samples, |_, w, q| (speed.power(w), flow.power(q)))?
    };
    let answer = match rule {
        Rule::Hold => table.solve_bounded(at.n0, at.n2),
        Rule::Refuse => table.solve(at.n0, at.n2),
    };
    let shares = answer.map_or([1.0; 2], |answer| [answer.share1, answer.share2]);
    let held: Vec<(usize, f64)> = [1, 2]
        .into_iter()
        .zip(shares)
        .filter_map(|(j, share)| (share == 0.0).then_some((j, 0.0)))
        .collect();
    let free = if held.is_empty() {
        reduced
    } else {
        reduced.hold(&held)?
    }
    .solve(CONDITION_LIMIT)?;
    Ok(FitAt {
        fit: CurveFit::from_held(&free, &held, at.n0, at.n2),
        shares,
        rss: free.rss,
    })
}

/// What [`Rule::Refuse`] asks of a fit.
fn complies(fit: &CurveFit) -> bool {
    fit.curve.c1 > 0.0 && fit.curve.c2 > 0.0
}

/// The best trial that complies by QR too, where sums of the table were rounded to the right side of a wall.
fn confirmed(
    samples: &Samples,
    table: &Table,
    trials: &[Trial],
) -> Result<(Point, FitAt), PumpError> {
    let point = |trial: &Trial| {
        let Trial { n0, n2, .. } = *trial;
        trial.mse_m2.map(|mse| Point { n0, n2, mse })
    };
    let mut points: Vec<Point> = trials.iter().filter_map(point).collect();
    points.sort_by(|a, b| a.mse.total_cmp(&b.mse));
    points.dedup_by(|a, b| (a.n0, a.n2) == (b.n0, b.n2));
    for at in points.into_iter().take(CONFIRMED) {
        if let Ok(found) = fit_at(samples, table, Rule::Refuse, &at)
            && complies(&found.fit)
        {
            return Ok((at, found));
        }
    }
    let tried = trials.len();
    Err(PumpError::NoFeasibleExponents { tried })
}

/// Difference of two mean squared errors that tells them apart, m²: below it the sums themselves are rounded.
fn tell(options: &SearchOptions, table: &Table, mse_m2: f64) -> f64 {
    (options.tolerance * mse_m2).max(ROUNDING * table.mean_square_head())
}

fn check(options: &SearchOptions) -> Result<(), PumpError> {
    let domain = |name, found, expected| {
        Err(PumpError::Domain {
            name,
            found,
            expected,
        })
    };
    let n0 = (*options.n0.start(), *options.n0.end());
    let n2 = (*options.n2.start(), *options.n2.end());
    let rises = |(from, to): (f64, f64), least: f64| from >= least && from <= to && to <= 10.0;
    for (name, (from, to), legal, expected) in [
        (
            "n0",
            n0,
            rises(n0, 0.1),
            "a rising range, or one value, from 0.1 to at most 10",
        ),
        (
            "n2",
            n2,
            rises(n2, 1.0) && n2.1 > 1.0,
            "a rising range from 1, or one value above it, to at most 10",
        ),
    ] {
        if !legal {
            return Err(PumpError::Range {
                name,
                from,
                to,
                expected,
            });
        }
    }
    for (name, found) in [("start.0", options.start.0), ("start.1", options.start.1)] {
        if !found.is_finite() {
            return domain(name, found, "a finite guess");
        }
    }
    if !(options.tolerance > 0.0 && options.tolerance < 1.0) {
        return domain("tolerance", options.tolerance, "above 0 and below 1");
    }
    Ok(())
}

#[derive(Debug, Clone, Copy)]
struct Point {
    n0: f64,
    n2: f64,
    mse: f64,
}

/// The thesis' objective: mean squared error, or refused.
struct Cost<'a> {
    table: &'a Table,
    options: &'a SearchOptions,
    log: &'a RefCell<Vec<Trial>>,
    search: u32,
}

impl Cost<'_> {
    fn mse(&self, n0: f64, n2: f64) -> Option<f64> {
        let inside = self.options.n0.contains(&n0) && self.options.n2.contains(&n2) && n2 > 1.0;
        let mse_m2 = inside
            .then(|| match self.options.rule {
                Rule::Hold => self.table.solve_bounded(n0, n2),
                Rule::Refuse => self
                    .table
                    .solve(n0, n2)
                    .filter(|answer| answer.share1 > 0.0 && answer.share2 > 0.0),
            })
            .flatten()
            .map(|answer| answer.mse);
        self.log.borrow_mut().push(Trial {
            search: self.search,
            n0,
            n2,
            mse_m2,
        });
        mse_m2
    }

    fn point(&self, n0: f64, n2: f64) -> Option<Point> {
        self.mse(n0, n2).map(|mse| Point { n0, n2, mse })
    }
}

impl CostFunction for Cost<'_> {
    type Param = Vector2<f64>;
    type Output = f64;

    fn cost(&self, n: &Self::Param) -> Result<f64, Error> {
        // Infinity in the thesis; the optimiser sums costs, so a large finite number here.
        let refused = 1e6 * self.table.mean_square_head();
        let (n0, n2) = self.options.pair(n);
        Ok(self.mse(n0, n2).unwrap_or(refused))
    }
}

/// The guess if it is feasible, else the best of a grid over the ranges.
fn feasible_start(cost: &Cost) -> Option<Point> {
    let (n0, n2) = cost.options.start;
    let (n0, n2) = cost.options.pair(&Vector2::new(n0, n2));
    cost.point(n0, n2).or_else(|| {
        let place = |range: &RangeInclusive<f64>, i: u32| {
            let share = (f64::from(i) + 0.5) / f64::from(GRID);
            range.start() + share * (range.end() - range.start())
        };
        (0..GRID * GRID)
            .filter_map(|k| {
                cost.point(
                    place(&cost.options.n0, k / GRID),
                    place(&cost.options.n2, k % GRID),
                )
            })
            .min_by(|a, b| a.mse.total_cmp(&b.mse))
    })
}

/// Why nothing is feasible: too little excitation if even the plain fit is refused.
fn refusal(samples: &Samples, options: &SearchOptions, log: &RefCell<Vec<Trial>>) -> PumpError {
    let (n0, n2) = options.pair(&Vector2::new(options.start.0, options.start.1));
    match crate::fit_unconstrained(samples, n0.max(0.1), n2.max(1.0)) {
        Err(refusal) => refusal,
        Ok(_) => PumpError::NoFeasibleExponents {
            tried: log.borrow().len(),
        },
    }
}

/// One Nelder-Mead search.
struct Run {
    mse: f64,
    last: PathPoint,
    ended: SearchStatus,
}

impl Run {
    fn point(&self) -> Point {
        Point {
            n0: self.last.n0,
            n2: self.last.n2,
            mse: self.mse,
        }
    }
}

fn run(cost: Cost, from: Point, signs: (f64, f64), path: &Arc<Mutex<Vec<PathPoint>>>) -> Run {
    let search = cost.search;
    let options = cost.options;
    let corner = |d0: f64, d2: f64| Vector2::new(from.n0 * (1.0 + d0), from.n2 * (1.0 + d2));
    let simplex = vec![
        corner(0.0, 0.0),
        corner(SIMPLEX * signs.0, 0.0),
        corner(0.0, SIMPLEX * signs.1),
    ];
    let unmoved = Run {
        mse: from.mse,
        last: PathPoint {
            search,
            iteration: 0,
            n0: from.n0,
            n2: from.n2,
            mse_m2: from.mse,
        },
        ended: SearchStatus::Stopped,
    };
    // The tolerance is checked to be above 0, so this is accepted.
    let told = tell(options, cost.table, from.mse);
    let Ok(solver) = NelderMead::new(simplex).with_sd_tolerance(told) else {
        return unmoved;
    };
    let outcome = Executor::new(cost, solver)
        .configure(|state| state.max_iters(options.max_iterations))
        .add_observer(
            Recorder {
                search,
                options: options.clone(),
                path: Arc::clone(path),
            },
            ObserverMode::Always,
        )
        .run();
    let Ok(outcome) = outcome else {
        return unmoved;
    };
    let state = outcome.state();
    let ended = match state.get_termination_reason() {
        Some(TerminationReason::SolverConverged | TerminationReason::TargetCostReached) => {
            SearchStatus::Converged
        }
        Some(TerminationReason::MaxItersReached) => SearchStatus::IterationLimit,
        _ => SearchStatus::Stopped,
    };
    let Some(n) = state.get_best_param() else {
        return unmoved;
    };
    let (n0, n2) = options.pair(n);
    Run {
        mse: state.get_best_cost(),
        last: PathPoint {
            search,
            iteration: state.get_iter(),
            n0,
            n2,
            mse_m2: state.get_best_cost(),
        },
        ended,
    }
}

/// Keeps the best corner of every iteration.
struct Recorder {
    search: u32,
    options: SearchOptions,
    path: Arc<Mutex<Vec<PathPoint>>>,
}

type Simplex = IterState<Vector2<f64>, (), (), (), (), f64>;

impl Recorder {
    fn keep(&self, state: &Simplex) {
        if let (Some(n), Ok(mut path)) = (state.get_param(), self.path.lock()) {
            // The iteration counter is still 0 after the first one.
            let (n0, n2) = self.options.pair(n);
            let begun = path.last().is_some_and(|last| last.search == self.search);
            path.push(PathPoint {
                search: self.search,
                iteration: state.get_iter() + u64::from(begun),
                n0,
                n2,
                mse_m2: state.get_cost(),
            });
        }
    }
}

impl Observe<Simplex> for Recorder {
    fn observe_init(&mut self, _: &str, state: &Simplex, _: &KV) -> Result<(), Error> {
        self.keep(state);
        Ok(())
    }

    fn observe_iter(&mut self, state: &Simplex, _: &KV) -> Result<(), Error> {
        self.keep(state);
        Ok(())
    }
}

fn limits(shares: [f64; 2], options: &SearchOptions, best: &Point) -> Vec<Limit> {
    let near = |n: f64, end: f64, range: &RangeInclusive<f64>| {
        (n - end).abs() < 1e-3 * (range.end() - range.start())
    };
    [
        (Limit::C1Zero, shares[0] < GONE),
        (Limit::C2Zero, shares[1] < GONE),
        (
            Limit::N2Lower,
            near(best.n2, *options.n2.start(), &options.n2),
        ),
        (
            Limit::N2Upper,
            near(best.n2, *options.n2.end(), &options.n2),
        ),
        (
            Limit::N0Lower,
            near(best.n0, *options.n0.start(), &options.n0),
        ),
        (
            Limit::N0Upper,
            near(best.n0, *options.n0.end(), &options.n0),
        ),
    ]
    .into_iter()
    .filter_map(|(limit, there)| there.then_some(limit))
    .collect()
}

/// Powers of values that come again and again, one place per hash.
struct Memo {
    n: f64,
    places: RefCell<Vec<(f64, f64)>>,
}

impl Memo {
    fn new(n: f64) -> Self {
        Self {
            n,
            // NaN equals no value, so an empty place never matches.
            places: RefCell::new(vec![(f64::NAN, 0.0); 1 << MEMO_BITS]),
        }
    }

    fn power(&self, x: f64) -> f64 {
        let place = &mut self.places.borrow_mut()[hash(x, MEMO_BITS)];
        if place.0 != x {
            *place = (x, x.powf(self.n));
        }
        place.1
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Speed, flow and a head that rises with the flow up to exponents of about 2.
    fn rows() -> [Vec<f64>; 3] {
        let chance = |i: u32, k: u32| f64::from((i * k) % 601) / 601.0;
        let speed: Vec<f64> = (0..600).map(|i| 20.0 + 70.0 * chance(i, 37)).collect();
        let flow: Vec<f64> = (0..600).map(|i| 0.07 * chance(i, 229)).collect();
        let pairs = speed.iter().zip(&flow);
        let head = pairs.map(|(w, q)| 0.05 * w * w + 1.0 * w * q - 1.8e4 * q * q);
        let head = head.collect();
        [speed, flow, head]
    }

    /// The sums may round a pair to the right side of a wall; the rows decide.
    #[test]
    fn a_trial_that_the_rows_do_not_confirm_is_passed_over() {
        let [speed, flow, head] = rows();
        let samples = Samples {
            speed_pct: &speed,
            flow_m3_s: &flow,
            head_m: &head,
            keep: &[true; 600],
        };
        let table = Table::new(&samples, &(1.0..=4.0), &(1.0..=4.0)).expect("flows");
        let trial = |n0, n2, mse| Trial {
            search: 0,
            n0,
            n2,
            mse_m2: Some(mse),
        };
        let fit = |n0, n2| crate::fit_unconstrained(&samples, n0, n2).expect("rich data");
        let (wrong, right) = (trial(2.0, 2.0, 1.0), trial(2.3, 1.3, 2.0));
        assert!(!complies(&fit(2.0, 2.0)) && complies(&fit(2.3, 1.3)));
        let refused = Trial {
            mse_m2: None,
            ..right
        };
        let (at, found) = confirmed(&samples, &table, &[refused, right, wrong]).expect("one");
        assert_eq!((at.n0, at.n2), (2.3, 1.3));
        assert!(complies(&found.fit));
        assert!(matches!(
            confirmed(&samples, &table, &[refused, wrong]),
            Err(PumpError::NoFeasibleExponents { tried: 2 })
        ));
    }

    #[test]
    fn an_optimum_rests_on_a_limit_within_a_thousandth_of_the_range_or_of_the_head() {
        let options = SearchOptions {
            n0: 1.0..=4.0,
            n2: 1.5..=3.5,
            ..SearchOptions::default()
        };
        let at = |n0, n2, shares| limits(shares, &options, &Point { n0, n2, mse: 1.0 });
        let open = [0.1, 0.1];
        assert_eq!(at(2.0, 2.0, open), []);
        // Of widths 3 and 2.
        assert_eq!(at(1.0029, 2.0, open), [Limit::N0Lower]);
        assert_eq!(at(1.0031, 2.0, open), []);
        assert_eq!(at(3.9971, 2.0, open), [Limit::N0Upper]);
        assert_eq!(at(3.9969, 2.0, open), []);
        assert_eq!(at(2.0, 1.5019, open), [Limit::N2Lower]);
        assert_eq!(at(2.0, 1.5021, open), []);
        assert_eq!(at(2.0, 3.4981, open), [Limit::N2Upper]);
        assert_eq!(at(2.0, 3.4979, open), []);
        assert_eq!(at(2.0, 2.0, [0.9e-4, 0.1]), [Limit::C1Zero]);
        assert_eq!(at(2.0, 2.0, [0.1, 0.9e-4]), [Limit::C2Zero]);
        assert_eq!(at(2.0, 2.0, [1.1e-4, 1.1e-4]), []);
    }
}
