//! Output-error fit: parameters and initial states by which the free run follows the record.

use crate::assembly::Assembly;
use crate::error::AssemblyError;
use crate::record::Window;
use crate::residual::Residual;
use crate::simulate::{RunStatus, SimulationOptions};
use dgd_lsq::lm::{self, Bounds, Effort, Ending, Minimum, Residuals};
use nalgebra::{DMatrix, SymmetricEigen};

/// How residuals count.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Loss {
    /// By their square.
    #[default]
    Square,
    /// By their square up to `k` robust standard deviations (1.4826 times the median size; of those that are not 0 where
    /// most are), beyond that by their size (Huber 1964).
    Huber(f64),
}

/// Settings of a fit.
#[derive(Debug, Clone, PartialEq)]
pub struct FitOptions {
    /// First guess; that of the assembly if absent.
    pub start: Option<Vec<f64>>,
    /// Further starts within the bounds (Halton's points), each tried for a few steps before the best is followed; 0 by
    /// default.
    pub more_starts: usize,
    /// Loss; squares by default.
    pub loss: Loss,
    /// Steps of the minimisation; 100 by default.
    pub iterations: usize,
    /// Relative gain of the cost below which it stops; 1e-9 by default.
    pub tolerance: f64,
    /// Instruments to fit; all that were recorded if empty.
    pub outputs: Vec<String>,
    /// Parameters (paths) to hold at their start.
    pub held: Vec<String>,
    /// Settings of the simulations.
    pub simulation: SimulationOptions,
}

impl Default for FitOptions {
    fn default() -> Self {
        Self {
            start: None,
            more_starts: 0,
            loss: Loss::Square,
            iterations: 100,
            tolerance: 1e-9,
            outputs: Vec::new(),
            held: Vec::new(),
            simulation: SimulationOptions {
                relative: 1e-6,
                ..SimulationOptions::default()
            },
        }
    }
}

impl FitOptions {
    /// Checks the numbers that no fit can use.
    pub(crate) fn check(&self) -> Result<(), AssemblyError> {
        let refused = |name: &str, found, expected| {
            Err(AssemblyError::Value {
                name: name.into(),
                found,
                expected,
            })
        };
        match self.loss {
            Loss::Huber(k) if !(k.is_finite() && k > 0.0) => {
                refused("loss: k of Huber", k, "a number above 0")
            }
            _ if !(self.tolerance.is_finite() && self.tolerance >= 0.0) => {
                refused("tolerance", self.tolerance, "a number of at least 0")
            }
            _ => Ok(()),
        }
    }
}

/// How a fit ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum FitStatus {
    /// A minimum, to the tolerance.
    Converged,
    /// [`FitOptions::iterations`] were used up.
    IterationLimit,
    /// No step improved the cost, and it is no minimum either.
    NoProgress,
    /// No start could be simulated.
    NoStart,
    /// There is nothing to fit: no free parameter.
    NothingFree,
}

/// A fitted assembly.
#[derive(Debug, Clone, PartialEq)]
pub struct Fit {
    /// Parameters in the order of [`Assembly::parameters`].
    pub theta: Vec<f64>,
    /// Standard errors; infinite for what the record does not tell, 0 for what was held or sits on a bound. They take
    /// the residuals' lag-one correlation into account ([`inflation`](Self::inflation)), not a wrong model.
    pub standard_error: Vec<f64>,
    /// Covariance, row-major, `p × p`, with the inflation.
    pub covariance: Vec<f64>,
    /// Parameters on a bound.
    pub at_bound: Vec<bool>,
    /// Root mean square of the residuals of each instrument, in SI; NaN if it was not fitted.
    pub rms: Vec<f64>,
    /// Half the sum of squares of the scaled residuals (of the weighted ones with a robust loss).
    pub cost: f64,
    /// Factor on variances from the residuals' correlation, `(1 + r)/(1 − r)`, at least 1.
    pub inflation: f64,
    /// Simulated less measured, by window and instrument, each of shape `(n,)`; NaN where nothing was measured.
    pub residuals: Vec<Vec<Vec<f64>>>,
    /// Residuals counted.
    pub samples: usize,
    /// How it ended.
    pub status: FitStatus,
    /// Steps tried.
    pub iterations: usize,
    /// Simulations of a window.
    pub runs: usize,
}

/// Fits the free parameters and initial states of `assembly` to the training windows by the free run (output error):
/// bounded Levenberg-Marquardt, residuals scaled by each instrument's accuracy or, without one, its deviation in the record.
///
/// - `windows`: the training windows, in the order of the description ([`Assembly::windows`]).
///
/// The result carries how it ended; a fit that ended badly is a result too.
///
/// # Errors
/// [`AssemblyError::Length`] on readings that are not as long as their times; that or [`AssemblyError::Value`] on a wrong start;
/// [`AssemblyError::Value`] on a loss or tolerance that cannot be; [`AssemblyError::Column`] on names that do not
/// exist, [`AssemblyError::NoReadings`] if no instrument was recorded; [`AssemblyError::Input`] on bad inputs.
///
/// # Source
/// Ljung, L., *System Identification* (1999), chapters 7 and 10.
///
/// ```
/// use dgd_assembly::{fit, Assembly, FitOptions, Portion, Record};
/// let text = r#"
/// connections = ["tank -> valve -> atmosphere"]
/// [components]
/// tank = { kind = "tank", area = 1.0 }
/// valve = { kind = "valve" }
/// gauge = { kind = "instrument", measures = "level", of = "tank", channel = "h" }
/// [initial]
/// "tank.level" = 1.0
/// [free]
/// "valve.flow_coefficient" = { start = 3e-5, low = 1e-6, high = 1e-3 }
/// "#;
/// let assembly = Assembly::parse(text)?;
/// // A tank that empties evenly in its root: q = c √(ρ g h) with c = 1e-4.
/// let fall = 0.5e-4 * (1000.0f64 * 9.80665).sqrt();
/// let h: Vec<f64> = (0..60).map(|t| (1.0 - fall * f64::from(t)).powi(2)).collect();
/// let windows = assembly.windows(&Record { columns: vec![("h", &h)] }, Portion::Train)?;
/// let found = fit(&assembly, &windows, &FitOptions::default())?;
/// assert!((found.theta[0] - 1e-4).abs() < 1e-8);
/// # Ok::<(), dgd_assembly::AssemblyError>(())
/// ```
pub fn fit(
    assembly: &Assembly,
    windows: &[Window],
    options: &FitOptions,
) -> Result<Fit, AssemblyError> {
    if windows.is_empty() {
        return Err(AssemblyError::Length {
            name: "windows".into(),
            expected: 1,
            found: 0,
        });
    }
    let mut problem = Residual::new(assembly, windows, options)?;
    let p = problem.moving.len();
    let first = problem.scaled(&problem.start);
    if p == 0 {
        let residuals = problem.at(&first);
        let cost = residuals.as_ref().map_or(f64::INFINITY, |r| {
            0.5 * r.iter().map(|r| r * r).sum::<f64>()
        });
        let minimum = Minimum {
            theta: first,
            residuals: residuals.unwrap_or_default(),
            cost,
            jacobian: DMatrix::zeros(0, 0),
            steps: 0,
            ending: Ending::Converged,
        };
        return Ok(Fit {
            status: FitStatus::NothingFree,
            ..conclude(assembly, problem, &minimum)
        });
    }
    let mut best: Option<Minimum> = None;
    let starts = std::iter::once(first)
        .chain((0..options.more_starts).map(|k| (0..p).map(|d| lm::halton(k, d)).collect()));
    let short = if options.more_starts == 0 {
        options.iterations
    } else {
        12.min(options.iterations)
    };
    for start in starts {
        let found = minimise(&mut problem, &start, short, options.tolerance);
        if best.as_ref().is_none_or(|b| found.cost < b.cost) {
            best = Some(found);
        }
    }
    // `starts` is never empty.
    let Some(mut minimum) = best else {
        return Err(AssemblyError::Length {
            name: "starts".into(),
            expected: 1,
            found: 0,
        });
    };
    if minimum.ending == Ending::StepLimit && short < options.iterations {
        let used = minimum.steps;
        minimum = minimise(
            &mut problem,
            &minimum.theta,
            options.iterations - short,
            options.tolerance,
        );
        minimum.steps += used;
    }
    Ok(conclude(assembly, problem, &minimum))
}

/// Minimises from scaled parameters, which lie between 0 and 1.
fn minimise(problem: &mut Residual<'_>, start: &[f64], steps: usize, tolerance: f64) -> Minimum {
    let effort = Effort {
        steps,
        tolerance,
        ..Effort::default()
    };
    lm::minimise(
        problem,
        start,
        &Bounds::unit(start.len()),
        None,
        None,
        effort,
    )
}

fn conclude(assembly: &Assembly, mut problem: Residual<'_>, minimum: &Minimum) -> Fit {
    let all = assembly.parameters().len();
    let theta = problem.theta(&minimum.theta);
    let p = minimum.theta.len();
    let residuals = problem.differences(&theta).unwrap_or_default();
    let jacobian = problem.jacobian(&minimum.theta, &minimum.residuals, &Bounds::unit(p));
    // What no reading tells may well have been left on a bound; nothing holds it there.
    let on_bound: Vec<bool> = (minimum.theta.iter().zip(told(jacobian.as_ref(), minimum)))
        .map(|(z, told)| told && (*z <= 1e-9 || *z >= 1.0 - 1e-9))
        .collect();
    let loose: Vec<usize> = (0..p).filter(|&i| !on_bound[i]).collect();
    let (covariance, inflation) = match jacobian {
        // As many readings as values leave nothing to tell an error by.
        Some(jacobian) if minimum.residuals.len() > p => {
            let inflation = inflation(&residuals, &problem.scale);
            (covariance(&jacobian, &loose, minimum, inflation), inflation)
        }
        _ => (
            DMatrix::from_element(loose.len(), loose.len(), f64::INFINITY),
            1.0,
        ),
    };
    let mut full = vec![0.0; all * all];
    let mut standard_error = vec![0.0; all];
    for (a, &i) in loose.iter().enumerate() {
        let i = problem.moving[i];
        for (b, &j) in loose.iter().enumerate() {
            let j = problem.moving[j];
            full[i * all + j] = covariance[(a, b)] * problem.span[i] * problem.span[j];
        }
        standard_error[i] = full[i * all + i].max(0.0).sqrt();
    }
    let mut at_bound = vec![false; all];
    for (k, &i) in problem.moving.iter().enumerate() {
        at_bound[i] = on_bound[k];
    }
    let rms = (0..problem.scale.len())
        .map(|m| {
            let values: Vec<f64> = residuals
                .iter()
                .flat_map(|w| &w[m])
                .copied()
                .filter(|v| v.is_finite())
                .collect();
            if problem.scale[m].is_some() {
                root_mean_square(&values)
            } else {
                f64::NAN
            }
        })
        .collect();
    Fit {
        theta,
        standard_error,
        covariance: full,
        at_bound,
        rms,
        cost: minimum.cost,
        inflation,
        residuals,
        samples: minimum.residuals.len(),
        status: match minimum.ending {
            Ending::Converged => FitStatus::Converged,
            Ending::StepLimit => FitStatus::IterationLimit,
            Ending::NoStart => FitStatus::NoStart,
            _ => FitStatus::NoProgress,
        },
        iterations: minimum.steps,
        runs: problem.runs,
    }
}

pub(crate) fn root_mean_square(values: &[f64]) -> f64 {
    #[expect(clippy::cast_precision_loss, reason = "sample counts")]
    let n = values.len() as f64;
    (values.iter().map(|v| v * v).sum::<f64>() / n).sqrt()
}

/// From the lag-one correlation of the residuals of the outputs that are fitted, those with a scale.
fn inflation(residuals: &[Vec<Vec<f64>>], scale: &[Option<f64>]) -> f64 {
    let (mut lagged, mut square) = (0.0, 0.0);
    let fitted = |window| std::iter::zip(window, scale).filter(|(_, s)| s.is_some());
    for (column, _) in residuals.iter().flat_map(fitted) {
        let size: f64 = column.iter().filter(|v| v.is_finite()).map(|v| v * v).sum();
        if !(size > 0.0) {
            continue;
        }
        for pair in column
            .windows(2)
            .filter(|p| p[0].is_finite() && p[1].is_finite())
        {
            lagged += pair[0] * pair[1] / size;
        }
        square += 1.0;
    }
    let r = if square > 0.0 {
        (lagged / square).clamp(0.0, 0.999)
    } else {
        0.0
    };
    (1.0 + r) / (1.0 - r)
}

/// Share of the most that is told of a direction, squared, below which nothing is.
const UNTOLD: f64 = 1e-13;

/// Whether the readings tell each parameter anything: over all that its bounds allow they turn by more than noise, were every
/// other parameter known. Of an unknown Jacobian, all are told.
fn told(jacobian: Option<&DMatrix<f64>>, minimum: &Minimum) -> Vec<bool> {
    let p = minimum.theta.len();
    let Some(jacobian) = jacobian else {
        return vec![true; p];
    };
    #[expect(clippy::cast_precision_loss, reason = "sample counts")]
    let variance = 2.0 * minimum.cost / minimum.residuals.len().max(1) as f64;
    let turns: Vec<f64> = jacobian.column_iter().map(|c| c.norm_squared()).collect();
    let most = turns.iter().copied().fold(0.0, f64::max);
    // Negated, so that what is no number counts as told.
    let nothing = |turn: &f64| *turn <= (UNTOLD * most).max(variance);
    turns.iter().map(|turn| !nothing(turn)).collect()
}

/// Covariance of the scaled parameters; directions that the record does not tell get infinity on the diagonal.
fn covariance(
    jacobian: &DMatrix<f64>,
    loose: &[usize],
    minimum: &Minimum,
    inflation: f64,
) -> DMatrix<f64> {
    let k = loose.len();
    if k == 0 {
        return DMatrix::zeros(0, 0);
    }
    let j = jacobian.select_columns(loose);
    let n = minimum.residuals.len();
    #[expect(clippy::cast_precision_loss, reason = "sample counts")]
    let variance = 2.0 * minimum.cost / (n.saturating_sub(k).max(1) as f64) * inflation;
    let gram = j.transpose() * &j;
    let untold_all = DMatrix::from_diagonal_element(k, k, f64::INFINITY);
    if gram.iter().any(|v| !v.is_finite()) {
        return untold_all;
    }
    let Some(eigen) = SymmetricEigen::try_new(gram, f64::EPSILON, 100_000) else {
        return untold_all;
    };
    let largest = eigen.eigenvalues.max();
    let mut covariance = DMatrix::zeros(k, k);
    let mut untold = vec![false; k];
    for (value, vector) in eigen
        .eigenvalues
        .iter()
        .zip(eigen.eigenvectors.column_iter())
    {
        if *value > UNTOLD * largest {
            covariance += vector * vector.transpose() * (variance / value);
        } else {
            for i in 0..k {
                untold[i] |= vector[i].abs() > 1e-3;
            }
        }
    }
    for i in 0..k {
        if untold[i] {
            covariance[(i, i)] = f64::INFINITY;
        }
    }
    covariance
}

impl Assembly {
    /// Root mean square of simulated less measured for each instrument over a window; NaN where nothing was measured or
    /// the run did not finish.
    ///
    /// # Errors
    /// As [`simulate`](Self::simulate).
    pub fn rms(
        &self,
        theta: &[f64],
        window: &Window,
        number: usize,
        options: &SimulationOptions,
    ) -> Result<Vec<f64>, AssemblyError> {
        let run = self.simulate(theta, window, number, options)?;
        let rms = |(output, reading): (&Vec<f64>, &Vec<f64>)| {
            let differences: Vec<f64> = output
                .iter()
                .zip(reading)
                .filter(|(_, r)| r.is_finite())
                .map(|(o, r)| o - r)
                .collect();
            if run.status == RunStatus::Finished {
                root_mean_square(&differences)
            } else {
                f64::NAN
            }
        };
        Ok(run.outputs.iter().zip(&window.readings).map(rms).collect())
    }
}
