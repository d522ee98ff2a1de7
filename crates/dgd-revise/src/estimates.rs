//! Parameters with their doubt.

use crate::context::{Context, Trial};
use crate::noise::{Ar, Noise};
use crate::revision::Estimate;
use crate::validate::LeftOut;
use nalgebra::{DMatrix, SymmetricEigen};

/// 97.5 % point of the normal distribution.
const TWO_SIDED_95: f64 = 1.959_963_984_540_054;

/// Estimates of all parameters of a fitted set: the interval is the wider of curvature with the residual's memory and of
/// the jackknife over the validation's folds.
pub(crate) fn estimates(
    context: &Context<'_>,
    trial: &Trial,
    jacobian: &DMatrix<f64>,
    left: &LeftOut,
) -> Vec<Estimate> {
    let r = &trial.minimum.residuals;
    let p = trial.paths.len();
    let noise = Noise::of(context.data, r, context.scale.len());
    // Variance of a mean of correlated residuals against that of white ones.
    let inflation = noise.of.iter().map(Ar::inflation).fold(1.0, f64::max);
    let free = r.len().saturating_sub(p).max(1) as f64;
    let variance = 2.0 * trial.cost() / free * inflation;
    let at_bound: Vec<bool> = (0..p)
        .map(|i| trial.bounds.touches(i, trial.minimum.theta[i]))
        .collect();
    let loose: Vec<usize> = (0..p).filter(|&i| !at_bound[i]).collect();
    let mut curvature = vec![0.0; p];
    if !loose.is_empty() && jacobian.ncols() == p {
        let j = jacobian.select_columns(&loose);
        let eigen = SymmetricEigen::new(j.transpose() * &j);
        let top = eigen.eigenvalues.max();
        for (value, vector) in eigen
            .eigenvalues
            .iter()
            .zip(eigen.eigenvectors.column_iter())
        {
            for (k, &i) in loose.iter().enumerate() {
                // A direction that nothing tells leaves its parameters anywhere within their bounds.
                curvature[i] += if *value > 1e-12 * top {
                    vector[k].powi(2) * variance / value
                } else if vector[k].abs() > 1e-3 {
                    1.0
                } else {
                    0.0
                };
            }
        }
    }
    (0..p)
        .map(|i| {
            let (low, high) = (trial.bounds.low()[i], trial.bounds.high()[i]);
            let value = trial.minimum.theta[i];
            let folds: Vec<f64> = left.thetas.iter().take(5).map(|t| t[i]).collect();
            let n = folds.len().max(1) as f64;
            let mean = folds.iter().sum::<f64>() / n;
            let jackknife =
                ((n - 1.0) / n * folds.iter().map(|f| (f - mean).powi(2)).sum::<f64>()).sqrt();
            let error = (curvature[i].sqrt() * (high - low)).max(jackknife);
            let half = TWO_SIDED_95 * error;
            Estimate {
                path: trial.paths[i].clone(),
                meaning: String::new(),
                value,
                standard_error: error,
                ci95: ((value - half).max(low), (value + half).min(high)),
                at_bound: at_bound[i],
            }
        })
        .collect()
}
