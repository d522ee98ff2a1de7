//! Standard errors of the coefficients and the exponents together.

use crate::search::{Limit, SearchOptions};
use crate::{CurveFit, Samples};
use dgd_lsq::Accumulator;
use std::ops::RangeInclusive;

/// Rows that the curvature is taken from: of longer recordings every so many-th, which is as good a measure of it.
const ROWS: usize = 8192;

/// Condition up to which coefficients and exponents are told apart at all; scaled columns, of which those of an exponent and of its
/// coefficient differ by a logarithm alone.
const TOLD_APART: f64 = 1e7;

/// Standard errors of coefficients and exponents that were fitted together.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JointErrors {
    /// Of c0, c1, c2; `None` where the coefficient was held.
    pub coefficients: [Option<f64>; 3],
    /// Of n0, n2; `None` where the exponent is fixed, rests on an end of its range or its coefficient was held, and where the error is wider
    /// than the range, which tells nothing.
    pub exponents: [Option<f64>; 2],
}

/// Standard errors at the answer of a search, by its tangent (Gauss-Newton) in all that was free; `None` where the rows do not tell
/// coefficients and exponents apart.
///
/// Rows are taken to be independent.
pub(crate) fn joint_errors(
    samples: &Samples<'_>,
    fit: &CurveFit,
    limits: &[Limit],
    options: &SearchOptions,
) -> Option<JointErrors> {
    let curve = &fit.curve;
    let free = fit.standard_errors.map(|error| error.is_some());
    let width = |range: &RangeInclusive<f64>| range.end() - range.start();
    let widths = [width(&options.n0), width(&options.n2)];
    let moves = [
        free[0]
            && widths[0] > 0.0
            && !limits
                .iter()
                .any(|l| matches!(l, Limit::N0Lower | Limit::N0Upper)),
        free[2]
            && widths[1] > 0.0
            && !limits
                .iter()
                .any(|l| matches!(l, Limit::N2Lower | Limit::N2Upper)),
    ];
    let [c0, c1, c2] = free;
    let used = [c0, c1, c2, moves[0], moves[1]];
    let names = ["c0", "c1", "c2", "n0", "n2"].into_iter().zip(used);
    let names = names.filter_map(|(name, used)| used.then_some(name));
    let mut rows = Accumulator::new(names).ok()?;
    let kept = samples.keep.iter().filter(|keep| **keep).count();
    let kept_rows = (0..samples.keep.len()).filter(|i| samples.keep[*i]);
    let mut row = Vec::with_capacity(5);
    let mut taken = 0_u32;
    for i in kept_rows.step_by(kept.div_ceil(ROWS).max(1)) {
        let (w, q) = (samples.speed_pct[i], samples.flow_m3_s[i]);
        let (a, d) = (w.powf(curve.n0), q.powf(curve.n2));
        // The logarithm grows more slowly than any power falls.
        let log = |v: f64| if v > 0.0 { v.ln() } else { 0.0 };
        let all = [a, -w * q, -d, curve.c0 * a * log(w), -curve.c2 * d * log(q)];
        row.clear();
        row.extend(
            all.iter()
                .zip(used)
                .filter_map(|(v, used)| used.then_some(*v)),
        );
        rows.push(&row, samples.head_m[i] - curve.head_m(w, q))
            .ok()?;
        taken += 1;
    }
    let step = rows.reduce().solve(TOLD_APART).ok()?;
    // By the noise of all rows, of which there are more.
    let scale = (fit.mse_m2 / step.mse * f64::from(taken) / kept as f64).sqrt();
    let mut errors = step.standard_errors.iter().map(|error| error * scale);
    let all = used.map(|used| if used { errors.next() } else { None });
    let told = all.iter().flatten().all(|error| error.is_finite());
    told.then_some(JointErrors {
        coefficients: [all[0], all[1], all[2]],
        exponents: [0, 1].map(|i| all[3 + i].filter(|error| *error <= widths[i])),
    })
}
