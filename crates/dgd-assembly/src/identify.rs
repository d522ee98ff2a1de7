//! What a record can tell of the parameters: Gram matrix, collinearity, near-null directions, profiles.

use crate::assembly::Assembly;
use crate::error::AssemblyError;
use crate::fit::{FitOptions, FitStatus, fit};
use crate::record::Window;
use crate::sensitivity::Sensitivities;
use nalgebra::{DMatrix, Dyn, SymmetricEigen};

/// What sensitivities say about the parameters.
#[derive(Debug, Clone, PartialEq)]
pub struct Identifiability {
    /// Paths of the parameters.
    pub parameters: Vec<String>,
    /// Root mean square of each scaled sensitivity; 0: no output moves.
    pub importance: Vec<f64>,
    /// Gram matrix of the scaled sensitivities, row-major.
    pub gram: Vec<f64>,
    /// Its eigenvalues, falling.
    pub eigenvalues: Vec<f64>,
    /// Number of directions that are told at all: eigenvalues above 1e-10 of the largest.
    pub rank: usize,
    /// Collinearity index of all parameters that move something: 1 if they act apart, above 10-15 if some can stand in for
    /// each other (Brun, Reichert and Künsch 2001).
    pub collinearity: f64,
    /// Collinearity index of each pair that exceeds 5, largest first.
    pub pairs: Vec<(String, String, f64)>,
    /// Combinations that hardly move any output, worst first.
    pub near_null: Vec<NearNull>,
}

/// A direction in (scaled) parameters along which the outputs hardly move.
#[derive(Debug, Clone, PartialEq)]
pub struct NearNull {
    /// Its eigenvalue over the largest.
    pub relative: f64,
    /// Parameters that take part with more than a tenth, and their share.
    pub shares: Vec<(String, f64)>,
}

/// Directions below this share of the strongest are told so weakly that they are listed.
const WEAK: f64 = 1e-5;

/// Practical identifiability of the parameters from the sensitivities of one or more windows.
///
/// At parameters and inputs chosen at random, the rank is the local structural identifiability of the assembly with its
/// instruments.
///
/// # Errors
/// [`AssemblyError::Length`] if there are no windows or they are of different parameters; [`AssemblyError::Value`] if
/// sensitivities are beyond the range of numbers.
pub fn identifiability(windows: &[Sensitivities]) -> Result<Identifiability, AssemblyError> {
    let Some(first) = windows.first() else {
        return Err(AssemblyError::Length {
            name: "windows".into(),
            expected: 1,
            found: 0,
        });
    };
    let p = first.parameters.len();
    if let Some(other) = windows.iter().find(|w| w.parameters != first.parameters) {
        return Err(AssemblyError::Length {
            name: "parameters".into(),
            expected: p,
            found: other.parameters.len(),
        });
    }
    let mut columns = vec![Vec::new(); p];
    for window in windows {
        for (all, column) in columns.iter_mut().zip(window.columns()) {
            all.extend(column);
        }
    }
    let n = columns.first().map_or(0, Vec::len);
    let matrix = DMatrix::from_fn(n, p, |i, j| columns[j][i]);
    let gram = matrix.transpose() * &matrix;
    let eigen = eigen(gram.clone())?;
    let mut order: Vec<usize> = (0..p).collect();
    order.sort_by(|&a, &b| eigen.eigenvalues[b].total_cmp(&eigen.eigenvalues[a]));
    let eigenvalues: Vec<f64> = order
        .iter()
        .map(|&i| eigen.eigenvalues[i].max(0.0))
        .collect();
    let largest = eigenvalues
        .first()
        .copied()
        .unwrap_or(0.0)
        .max(f64::MIN_POSITIVE);
    let near_null = order
        .iter()
        .rev()
        .filter(|&&i| eigen.eigenvalues[i] < WEAK * largest)
        .map(|&i| {
            let vector = eigen.eigenvectors.column(i);
            // The sign of an eigenvector is free: the largest share is written positive.
            let lead = vector
                .iter()
                .copied()
                .fold(0.0_f64, |m, v| if v.abs() > m.abs() { v } else { m });
            let mut shares: Vec<(String, f64)> = (0..p)
                .filter(|&j| vector[j].abs() > 0.1)
                .map(|j| (first.parameters[j].clone(), vector[j] * lead.signum()))
                .collect();
            shares.sort_by(|a, b| b.1.abs().total_cmp(&a.1.abs()));
            NearNull {
                relative: (eigen.eigenvalues[i] / largest).max(0.0),
                shares,
            }
        })
        .collect();
    #[expect(clippy::cast_precision_loss, reason = "sample counts")]
    let importance: Vec<f64> = (0..p)
        .map(|j| (gram[(j, j)] / n.max(1) as f64).sqrt())
        .collect();
    let moving: Vec<usize> = (0..p).filter(|&j| gram[(j, j)] > 1e-20 * largest).collect();
    let mut pairs = Vec::new();
    for (a, &i) in moving.iter().enumerate() {
        for &j in &moving[a + 1..] {
            let index = collinearity(&gram, &[i, j]);
            if index > 5.0 {
                pairs.push((
                    first.parameters[i].clone(),
                    first.parameters[j].clone(),
                    index,
                ));
            }
        }
    }
    pairs.sort_by(|a, b| b.2.total_cmp(&a.2));
    Ok(Identifiability {
        parameters: first.parameters.clone(),
        importance,
        rank: eigenvalues.iter().filter(|v| **v > 1e-10 * largest).count(),
        collinearity: collinearity(&gram, &moving),
        gram: gram.transpose().as_slice().to_vec(),
        eigenvalues,
        pairs,
        near_null,
    })
}

/// Eigenvalues of a symmetric matrix of finite numbers.
fn eigen(matrix: DMatrix<f64>) -> Result<SymmetricEigen<f64, Dyn>, AssemblyError> {
    let bad = matrix.iter().copied().find(|v| !v.is_finite());
    let found = if bad.is_none() {
        SymmetricEigen::try_new(matrix, f64::EPSILON, 100_000)
    } else {
        None
    };
    found.ok_or_else(|| AssemblyError::Value {
        name: "sensitivities".into(),
        found: bad.unwrap_or(f64::NAN),
        expected: "numbers whose squares are finite",
    })
}

/// `1/sqrt(least eigenvalue)` of the Gram matrix of normalised columns.
fn collinearity(gram: &DMatrix<f64>, which: &[usize]) -> f64 {
    if which.is_empty() {
        return 1.0;
    }
    let k = which.len();
    let normal = DMatrix::from_fn(k, k, |a, b| {
        let (i, j) = (which[a], which[b]);
        gram[(i, j)] / (gram[(i, i)] * gram[(j, j)]).sqrt()
    });
    let least = eigen(normal).map_or(0.0, |e| e.eigenvalues.min());
    1.0 / least.max(1e-30).sqrt()
}

/// One point of a profile.
#[derive(Debug, Clone, PartialEq)]
pub struct ProfilePoint {
    /// Value of the parameter.
    pub value: f64,
    /// Cost of the best fit of all others ([`Fit::cost`](crate::Fit::cost)).
    pub cost: f64,
    /// That fit's parameters.
    pub theta: Vec<f64>,
    /// How it ended.
    pub status: FitStatus,
}

/// Profile of the cost along one parameter: at each of `values` it is held and all others are fitted, each from the last.
///
/// A flat profile is a parameter the record does not tell (Raue, A. et al., Bioinformatics 25, 2009).
///
/// # Errors
/// [`AssemblyError::Free`] if `path` is no parameter; else as [`fit()`].
pub fn profile(
    assembly: &Assembly,
    windows: &[Window],
    options: &FitOptions,
    path: &str,
    values: &[f64],
) -> Result<Vec<ProfilePoint>, AssemblyError> {
    let parameters = assembly.parameters();
    let Some(index) = parameters.iter().position(|p| p.path == path) else {
        let known = crate::build::listed(parameters.iter().map(|p| p.path.as_str()));
        return Err(AssemblyError::Free {
            name: path.into(),
            known,
        });
    };
    let mut start = options.start.clone().unwrap_or_else(|| assembly.start());
    assembly.check_theta(&start)?;
    let mut held = options.held.clone();
    held.push(path.to_owned());
    let mut points = Vec::new();
    for &value in values {
        start[index] = value;
        let found = fit(
            assembly,
            windows,
            &FitOptions {
                start: Some(start),
                held: held.clone(),
                ..options.clone()
            },
        )?;
        start = found.theta.clone();
        points.push(ProfilePoint {
            value,
            cost: found.cost,
            theta: found.theta,
            status: found.status,
        });
    }
    Ok(points)
}
