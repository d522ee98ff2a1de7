//! The curves that lead to the linearisation, and what they leave over.

use super::columns::{FRICTION_PRIOR_PA, head_priors};
use crate::noise::{Layout, spread};
use crate::relations::{Blocks, Rows};
use dgd_effects::{Curves, FRICTION_TERMS, HEAD_TERMS, Scale, friction_terms, head_terms};
use nalgebra::{DMatrix, DVector};

/// Fits both curves robustly to the valid rows.
pub(super) fn robust_curves(rows: &Rows, b: &Blocks, scale: Scale) -> Curves {
    // These only lead to the linearisation: their priors need no means.
    let head_widths = head_priors(rows, b).map(|(mean, width)| mean.hypot(width));
    let scaled = |terms: &[f64], factor: f64| terms.iter().map(|v| v * factor).collect();
    let mut curves = Curves {
        scale,
        friction: [0.0; FRICTION_TERMS],
        head: [0.0; HEAD_TERMS],
    };
    curves.friction.copy_from_slice(&robust_over(
        &rows.friction,
        &b.drop,
        |k| scaled(&friction_terms(b.flow[k], scale), b.friction_factor[k]),
        &FRICTION_PRIOR_PA,
    ));
    curves.head.copy_from_slice(&robust_over(
        &rows.head,
        &b.lift,
        |k| {
            scaled(
                &head_terms(b.speed[k], b.through[k], scale),
                b.head_factor[k],
            )
        },
        &head_widths,
    ));
    curves
}

/// The robust fit of `terms` to the rows of `y` that are valid.
fn robust_over(
    valid: &[bool],
    y: &[f64],
    terms: impl Fn(usize) -> Vec<f64>,
    widths: &[f64],
) -> Vec<f64> {
    let kept: Vec<usize> = (0..valid.len())
        .filter(|&k| valid[k] && y[k].is_finite())
        .collect();
    let table: Vec<Vec<f64>> = kept.iter().map(|&k| terms(k)).collect();
    let columns: Vec<Vec<f64>> = (0..widths.len())
        .map(|a| table.iter().map(|r| r[a]).collect())
        .collect();
    let values: Vec<f64> = kept.iter().map(|&k| y[k]).collect();
    robust(&columns, &values, widths)
}

/// A robust straight least-squares fit; returns the coefficients.
fn robust(columns: &[Vec<f64>], y: &[f64], widths: &[f64]) -> Vec<f64> {
    let p = columns.len();
    let mut weight = vec![1.0; y.len()];
    let mut beta = vec![0.0; p];
    for _ in 0..8 {
        let mut normal = DMatrix::<f64>::zeros(p, p);
        let mut right = DVector::<f64>::zeros(p);
        for i in 0..y.len() {
            for a in 0..p {
                let wa = weight[i] * columns[a][i];
                right[a] += wa * y[i];
                for b in 0..=a {
                    normal[(a, b)] += wa * columns[b][i];
                }
            }
        }
        for a in 0..p {
            for b in a + 1..p {
                normal[(a, b)] = normal[(b, a)];
            }
            // A noise of 5 kPa stands against the prior; a whisper keeps collinear terms apart.
            normal[(a, a)] += (5e3 / widths[a]).powi(2) + 1e-10 * normal[(a, a)].max(1e-12);
        }
        let Some(factor) = normal.cholesky() else {
            break;
        };
        let solved = factor.solve(&right);
        beta.copy_from_slice(solved.as_slice());
        let residual: Vec<f64> = (0..y.len())
            .map(|i| y[i] - (0..p).map(|a| columns[a][i] * beta[a]).sum::<f64>())
            .collect();
        let scale = spread(residual.iter().copied()).max(200.0);
        for (w, r) in weight.iter_mut().zip(&residual) {
            let u = r.abs() / scale;
            *w = if u < 2.0 { 1.0 } else { 2.0 / u };
            if u > 8.0 {
                *w *= 8.0 / u;
            }
        }
    }
    beta
}

/// Both curves at the blocks of one hypothesis: others share most of its blocks, and bumps are dear.
#[derive(Debug, Clone)]
pub(super) struct Evaluated {
    flow: Vec<f64>,
    friction_pa: Vec<f64>,
    speed: Vec<f64>,
    through: Vec<f64>,
    pub(super) head_pa: Vec<f64>,
}

impl Evaluated {
    pub(super) fn of(curves: &Curves, b: &Blocks, known: Option<&Self>) -> Self {
        let n = b.flow.len();
        let friction_pa = (0..n)
            .map(|k| match known {
                Some(v) if v.flow[k] == b.flow[k] => v.friction_pa[k],
                _ => curves.friction_pa(b.flow[k]),
            })
            .collect();
        let head_pa = (0..n)
            .map(|k| match known {
                Some(v) if v.speed[k] == b.speed[k] && v.through[k] == b.through[k] => v.head_pa[k],
                _ => curves.head_pa(b.speed[k], b.through[k]),
            })
            .collect();
        Self {
            flow: b.flow.clone(),
            friction_pa,
            speed: b.speed.clone(),
            through: b.through.clone(),
            head_pa,
        }
    }

    /// Stacked residuals of the curves under the same hypothesis.
    pub(super) fn residual(&self, layout: Layout, b: &Blocks) -> Vec<f64> {
        let mut out = Vec::with_capacity(layout.len());
        let n = layout.blocks;
        out.extend((0..n).map(|k| b.drop[k] - b.friction_factor[k] * self.friction_pa[k]));
        out.extend((0..n).map(|k| b.lift[k] - b.head_factor[k] * self.head_pa[k]));
        out.extend_from_slice(&b.difference);
        out.extend_from_slice(&b.imbalance);
        out
    }
}
