//! The delay of the flow meter, found by fitting at every delay of a range.

use std::ops::RangeInclusive;

use crate::fit::{BATCH, fit_checked};
use crate::polynomial::fill_terms;
use crate::{CONDITION_LIMIT, FrictionError, Loss, PolynomialFit, Samples, Terms};
use dgd_lsq::{Accumulator, Reduced};
use rayon::prelude::*;

/// Delays correlated at once: their sums stay in registers.
const LANES: usize = 16;

/// Samples summed before the sums are added up: keeps rounding from growing with the recording.
const CHUNK: usize = 4096;

/// Of so many rows one is used to find the basis.
const THINNING: usize = 16;

/// What to sweep.
#[derive(Debug, Clone, PartialEq)]
pub struct SweepOptions {
    /// Delays to try, samples; negative means the meter leads. Default `0..=30`.
    pub delays: RangeInclusive<i64>,
    /// Sampling interval, s. Default 1.
    pub dt_s: f64,
    /// Loss of the reported fit at the best delay; the sweep itself is least squares. Default squared.
    pub loss: Loss,
}

impl Default for SweepOptions {
    fn default() -> Self {
        Self {
            delays: 0..=30,
            dt_s: 1.0,
            loss: Loss::Squared,
        }
    }
}

/// Where in the range the smallest error lies.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Minimum {
    /// Inside: both neighbours are worse (or equal).
    Interior,
    /// At the first delay: the range may be too short there.
    AtFirst,
    /// At the last delay: the range may be too short there.
    AtLast,
    /// Beside a delay that could not be fitted.
    BesideGap,
}

/// Errors of the fit against the assumed delay, and the full fit at the best.
#[derive(Debug, Clone, PartialEq)]
pub struct DelaySweep {
    /// Delays tried, s, rising, shape `(d,)`.
    pub delays_s: Vec<f64>,
    /// Mean squared error (over n - p) at each, Pa², shape `(d,)`; NaN where no fit was possible.
    pub mse_pa2: Vec<f64>,
    /// Samples used at each, shape `(d,)`.
    pub n: Vec<u64>,
    /// Index of the smallest error (the earliest, on a tie).
    pub best: usize,
    /// The delay at `best`, samples.
    pub best_delay_samples: i64,
    /// Vertex of the parabola through the smallest error and its neighbours, s; equals
    /// `delays_s[best]` unless [`Minimum::Interior`].
    pub refined_delay_s: f64,
    /// Where the minimum lies.
    pub minimum: Minimum,
    /// The fit at the best delay, by QR.
    pub fit: PolynomialFit,
}

/// Fits a friction law at every delay of a range: thesis section 3.3.2, Eqs. 3.21-3.25.
///
/// - `samples`: flow and friction on one uniform grid, NaN flow in gaps.
/// - `terms`: the law.
///
/// Rows used at delay θ: `keep[t]`, with `t + θ` inside the recording and the flow there finite
/// (and kept, with [`Samples::keep_delayed`]).
///
/// The sweep does not solve one problem per delay. The regressors are rotated once into a basis
/// that is orthonormal at the delay of the range nearest 0, so the normal equations at the others are
/// well conditioned; their Gram matrix changes from one delay to the next only at the ends of kept
/// runs; the cross terms are a correlation, 16 delays at a time. Sums agree with QR to about 1e-10
/// of the error; the fit reported at the best delay is by QR of the rows.
///
/// # Errors
/// [`FrictionError::Length`], [`FrictionError::NonFinite`], [`FrictionError::Powers`],
/// [`FrictionError::Delays`] on an empty range or one that leaves the recording,
/// [`FrictionError::Domain`] on a sampling interval not above 0, and [`FrictionError::Fit`] on too
/// few rows or poor excitation (the condition is held against [`CONDITION_LIMIT`]).
///
/// # Source
/// Thesis section 3.3.2; against one QR per delay: `tests/it/sweep.rs`.
pub fn delay_sweep(
    samples: &Samples,
    terms: &Terms,
    options: &SweepOptions,
) -> Result<DelaySweep, FrictionError> {
    samples.check()?;
    let powers = terms.powers()?;
    let (first, last) = (*options.delays.start(), *options.delays.end());
    let count = delay_count(first, last, samples.flow_m3_s.len())?;
    if !(options.dt_s.is_finite() && options.dt_s > 0.0) {
        return Err(FrictionError::Domain {
            name: "dt_s",
            found: options.dt_s,
            expected: "a finite interval above 0",
        });
    }
    let basis = Basis::at(samples, 0_i64.clamp(first, last), &powers)?;
    let sums = Sums::of(samples, &basis, &powers, first, count);

    let mse_pa2: Vec<f64> = (0..count).map(|d| sums.mse(d)).collect();
    let best = mse_pa2
        .iter()
        .enumerate()
        .filter(|(_, mse)| mse.is_finite())
        .fold(None, |best: Option<(usize, f64)>, (d, &mse)| match best {
            Some((_, least)) if least <= mse => best,
            _ => Some((d, mse)),
        });
    // The basis was solved at one delay of the range, so some delay is fitted; if rounding denies
    // it, the QR below says why.
    let best = best.map_or(0, |(d, _)| d);
    let delay = |d: usize| first.saturating_add(i64::try_from(d).unwrap_or(i64::MAX));
    #[expect(
        clippy::cast_precision_loss,
        reason = "delays stay far below 2^53 samples"
    )]
    let delays_s: Vec<f64> = (0..count).map(|d| delay(d) as f64 * options.dt_s).collect();
    let (minimum, offset) = refine(&mse_pa2, best);
    Ok(DelaySweep {
        refined_delay_s: delays_s[best] + offset * options.dt_s,
        minimum,
        best,
        best_delay_samples: delay(best),
        fit: fit_checked(samples, delay(best), &powers, options.loss)?,
        n: sums.n,
        delays_s,
        mse_pa2,
    })
}

fn delay_count(first: i64, last: i64, samples: usize) -> Result<usize, FrictionError> {
    let n = i64::try_from(samples).unwrap_or(i64::MAX);
    let inside = first <= last && first > -n && last < n;
    let count = inside.then(|| usize::try_from(last - first + 1).ok());
    count.flatten().ok_or(FrictionError::Delays {
        first,
        last,
        samples,
    })
}

/// Place and sub-sample offset of a minimum, from its neighbours.
fn refine(mse: &[f64], best: usize) -> (Minimum, f64) {
    if best == 0 {
        return (Minimum::AtFirst, 0.0);
    }
    if best + 1 == mse.len() {
        return (Minimum::AtLast, 0.0);
    }
    let (before, at, after) = (mse[best - 1], mse[best], mse[best + 1]);
    if !(before.is_finite() && after.is_finite()) {
        return (Minimum::BesideGap, 0.0);
    }
    // The earliest of the least errors: `before` is larger, so the parabola bends up.
    let curvature = before - 2.0 * at + after;
    (Minimum::Interior, 0.5 * (before - after) / curvature)
}

/// Inverse of the triangle of the regressors at one delay: columns of a basis that is orthonormal there.
struct Basis {
    /// p×p, row-major, upper triangle.
    inverse: Vec<f64>,
    /// The triangle itself, which takes the basis back to the regressors.
    triangle: Vec<f64>,
}

impl Basis {
    fn at(samples: &Samples, delay: i64, powers: &[f64]) -> Result<Self, FrictionError> {
        // A sixteenth of the rows gives a basis that is orthonormal enough, unless it misses the
        // few rows that excite. Poor excitation is refused by name before anything is inverted.
        let mut reduced = samples.accumulate(delay, THINNING, powers)?.reduce();
        if reduced.solve(CONDITION_LIMIT).is_err() {
            reduced = samples.accumulate(delay, 1, powers)?.reduce();
            reduced.solve(CONDITION_LIMIT)?;
        }
        let p = powers.len();
        Ok(Self {
            inverse: invert(&reduced, p),
            triangle: (0..p * p).map(|k| reduced.r(k / p, k % p)).collect(),
        })
    }
}

fn invert(r: &Reduced, p: usize) -> Vec<f64> {
    let mut inverse = vec![0.0; p * p];
    for j in 0..p {
        inverse[j * p + j] = 1.0 / r.r(j, j);
        for i in (0..j).rev() {
            let sum: f64 = (i + 1..=j).map(|k| r.r(i, k) * inverse[k * p + j]).sum();
            inverse[i * p + j] = -sum / r.r(i, i);
        }
    }
    inverse
}

/// Everything the normal equations need, per delay.
struct Sums {
    p: usize,
    /// From the basis back to the regressors, p×p.
    triangle: Vec<f64>,
    n: Vec<u64>,
    /// Σ F², per delay.
    square: Vec<f64>,
    /// Σ z_i z_j, per delay p×p.
    gram: Vec<f64>,
    /// Σ z_j F, per delay p.
    cross: Vec<f64>,
}

impl Sums {
    fn of(samples: &Samples, basis: &Basis, powers: &[f64], first: i64, count: usize) -> Self {
        let p = powers.len();
        let n = samples.flow_m3_s.len();
        let runs = runs(samples.keep);
        // Regressors on a grid padded so that every delay of every sample lands inside it, at
        // `t + delay - first`; 0 where the flow is not usable.
        let pad_front = usize::try_from((-first).max(0)).unwrap_or(0);
        let skip = usize::try_from(first.max(0)).unwrap_or(0);
        let padded = n + count + LANES;
        let mut z = vec![vec![0.0; padded]; p];
        let mut usable = vec![false; padded];
        let mut q = [0.0; BATCH];
        let mut x = [0.0; BATCH];
        for from in (skip..n.min(skip + padded - pad_front)).step_by(BATCH) {
            let to = n.min(skip + padded - pad_front).min(from + BATCH);
            // Grid place of sample `at`: at - first.
            let place = from - skip + pad_front;
            let (q, x) = (&mut q[..to - from], &mut x[..to - from]);
            let usable = &mut usable[place..][..to - from];
            for (at, (q, usable)) in (from..to).zip(q.iter_mut().zip(usable.iter_mut())) {
                *usable = samples.flow_usable(at);
                *q = if *usable { samples.flow_m3_s[at] } else { 0.0 };
            }
            for (i, power) in powers.iter().enumerate() {
                if *power == 0.0 {
                    x.iter_mut()
                        .zip(usable.iter())
                        .for_each(|(x, u)| *x = f64::from(*u));
                } else {
                    fill_terms(x, q, *power);
                }
                for (j, column) in z.iter_mut().enumerate().skip(i) {
                    let share = basis.inverse[i * p + j];
                    for (z, x) in column[place..].iter_mut().zip(x.iter()) {
                        *z += x * share;
                    }
                }
            }
        }
        let mut sums = Self {
            p,
            triangle: basis.triangle.clone(),
            n: vec![0; count],
            square: vec![0.0; count],
            gram: vec![0.0; count * p * p],
            cross: vec![0.0; count * p],
        };
        // Side by side, each in its own order: the number of cores changes no digit.
        let (crosses, ()) = rayon::join(
            || -> Vec<Vec<f64>> {
                let of = |column: &Vec<f64>| crosses(column, samples.friction_pa, &runs, count);
                z.par_iter().map(of).collect()
            },
            || {
                sums.autos(&z, &usable, &runs);
                sums.squares(samples, &usable, &runs);
            },
        );
        for (j, column) in crosses.iter().enumerate() {
            for (d, cross) in column.iter().enumerate() {
                sums.cross[d * p + j] = *cross;
            }
        }
        sums
    }

    /// Gram matrices and counts: the window of each kept run slides by one sample per delay.
    fn autos(&mut self, z: &[Vec<f64>], usable: &[bool], runs: &[(usize, usize)]) {
        let p = self.p;
        let mut gram = vec![0.0; p * p];
        let mut n = 0_u64;
        for &(start, end) in runs {
            n += usable[start..end]
                .iter()
                .map(|u| u64::from(*u))
                .sum::<u64>();
            for i in 0..p {
                for j in i..p {
                    let sum: f64 = z[i][start..end]
                        .chunks(CHUNK)
                        .zip(z[j][start..end].chunks(CHUNK))
                        .map(|(a, b)| dot(a, b))
                        .sum();
                    gram[i * p + j] += sum;
                }
            }
        }
        for d in 0..self.n.len() {
            if d > 0 {
                let mut step = vec![0.0; p * p];
                for &(start, end) in runs {
                    let (out, come) = (start + d - 1, end + d - 1);
                    n = n + u64::from(usable[come]) - u64::from(usable[out]);
                    for i in 0..p {
                        for j in i..p {
                            step[i * p + j] += z[i][come] * z[j][come] - z[i][out] * z[j][out];
                        }
                    }
                }
                for (g, s) in gram.iter_mut().zip(&step) {
                    *g += s;
                }
            }
            self.n[d] = n;
            self.gram[d * p * p..][..p * p].copy_from_slice(&gram);
        }
    }

    /// Σ F² over the rows used: all kept rows less those whose flow is not usable.
    fn squares(&mut self, samples: &Samples, usable: &[bool], runs: &[(usize, usize)]) {
        let f = samples.friction_pa;
        let all: f64 = runs
            .iter()
            .flat_map(|&(start, end)| f[start..end].chunks(CHUNK))
            .map(|chunk| dot(chunk, chunk))
            .sum();
        let count = self.square.len();
        let mut lost = vec![0.0; count];
        let n = f.len();
        for place in (0..n + count).filter(|&place| !usable[place]) {
            // Delay d pairs grid place `place` with friction sample `place - d`.
            let least = (place + 1).saturating_sub(n);
            for (d, lost) in lost.iter_mut().enumerate().take(place + 1).skip(least) {
                let t = place - d;
                if samples.keep[t] {
                    *lost += f[t] * f[t];
                }
            }
        }
        for (square, lost) in self.square.iter_mut().zip(lost) {
            *square = all - lost;
        }
    }

    /// Mean squared error at a delay by Cholesky of its Gram matrix; NaN if that fails.
    fn mse(&self, d: usize) -> f64 {
        let p = self.p;
        let gram = &self.gram[d * p * p..][..p * p];
        let mut half = vec![0.0; p * p];
        let mut rest = self.square[d];
        let mut reduced = vec![0.0; p];
        for j in 0..p {
            for i in 0..=j {
                let sum: f64 = (0..i).map(|k| half[k * p + i] * half[k * p + j]).sum();
                let left = gram[i * p + j] - sum;
                if i < j {
                    half[i * p + j] = left / half[i * p + i];
                } else if left > 0.0 {
                    half[j * p + j] = left.sqrt();
                } else {
                    return f64::NAN;
                }
            }
            let sum: f64 = (0..j).map(|k| half[k * p + j] * reduced[k]).sum();
            reduced[j] = (self.cross[d * p + j] - sum) / half[j * p + j];
            rest -= reduced[j] * reduced[j];
        }
        if !self.is_excited(&half) {
            return f64::NAN;
        }
        match self.n[d].checked_sub(p as u64) {
            #[expect(clippy::cast_precision_loss, reason = "row counts stay far below 2^53")]
            Some(degrees) if degrees > 0 => rest.max(0.0) / degrees as f64,
            _ => f64::NAN,
        }
    }
}

impl Sums {
    /// Whether [`fit_checked`] would take the regressors whose triangle in the basis is `half`.
    ///
    /// Where they cannot be told apart, rounding of the sums leaves a condition far above the limit.
    fn is_excited(&self, half: &[f64]) -> bool {
        let p = self.p;
        let Ok(mut rows) = Accumulator::new((0..p).map(|j| j.to_string())) else {
            return false;
        };
        // A row of zeros makes one more than columns; the condition does not see it.
        let pushed = (0..=p).all(|i| {
            let product = |j| {
                (i..p)
                    .map(|k| half[i * p + k] * self.triangle[k * p + j])
                    .sum()
            };
            let row: Vec<f64> = (0..p).map(product).collect();
            rows.push(&row, 0.0).is_ok()
        });
        pushed && rows.reduce().solve(CONDITION_LIMIT).is_ok()
    }
}

/// Σ F(t) z(t + d) for `count` delays: a correlation over the kept runs.
fn crosses(z: &[f64], f: &[f64], runs: &[(usize, usize)], count: usize) -> Vec<f64> {
    let mut cross = Vec::with_capacity(count + LANES);
    for d0 in (0..count).step_by(LANES) {
        let mut total = [0.0; LANES];
        for &(start, end) in runs {
            for from in (start..end).step_by(CHUNK) {
                let to = end.min(from + CHUNK);
                let mut sum = [0.0; LANES];
                for (y, window) in f[from..to].iter().zip(z[from + d0..].windows(LANES)) {
                    for (s, z) in sum.iter_mut().zip(window) {
                        *s += y * z;
                    }
                }
                for (t, s) in total.iter_mut().zip(sum) {
                    *t += s;
                }
            }
        }
        cross.extend(total);
    }
    cross.truncate(count);
    cross
}

/// Eight partial sums: the compiler may not reorder a sum, so the order is spelled out.
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut sums = [0.0; 8];
    for (x, y) in a.chunks(8).zip(b.chunks(8)) {
        for ((s, x), y) in sums.iter_mut().zip(x).zip(y) {
            *s += x * y;
        }
    }
    sums.iter().sum()
}

/// Half-open runs of kept samples.
fn runs(keep: &[bool]) -> Vec<(usize, usize)> {
    let mut runs = Vec::new();
    let mut start = None;
    for (t, kept) in keep.iter().copied().chain([false]).enumerate() {
        match (kept, start) {
            (true, None) => start = Some(t),
            (false, Some(from)) => {
                runs.push((from, t));
                start = None;
            }
            _ => {}
        }
    }
    runs
}

#[cfg(test)]
mod tests {
    use super::*;
    use dgd_lsq::Accumulator;

    #[test]
    fn the_basis_is_the_inverse_of_the_triangle() {
        let mut rows = Accumulator::new(["a", "b", "c", "d"]).expect("four names");
        for i in 0..20 {
            let x = f64::from(i) / 7.0;
            let row = [1.0, x.sin(), x * x, (1.3 * x).cos()];
            rows.push(&row, x).expect("finite rows");
        }
        let r = rows.reduce();
        let inverse = invert(&r, 4);
        for i in 0..4 {
            for j in 0..4 {
                let product: f64 = (i..4).map(|k| r.r(i, k) * inverse[k * 4 + j]).sum();
                let identity = if i == j { 1.0 } else { 0.0 };
                assert!((product - identity).abs() < 1e-13, "{i}, {j}: {product}");
            }
        }
    }

    #[test]
    fn the_vertex_of_a_parabola_is_met_exactly() {
        // (d - 1.25)² + 3 at 0, 1, 2.
        let (minimum, offset) = refine(&[4.5625, 3.0625, 3.5625], 1);
        assert_eq!((minimum, offset), (Minimum::Interior, 0.25));
        // A tie with the delay after: the vertex lies halfway.
        assert_eq!(refine(&[2.0, 1.0, 1.0], 1).1, 0.5);
    }

    #[test]
    fn one_delay_that_cannot_be_fitted_is_a_gap_on_either_side() {
        for mse in [[f64::NAN, 1.0, 2.0], [2.0, 1.0, f64::NAN]] {
            assert_eq!(refine(&mse, 1), (Minimum::BesideGap, 0.0));
        }
    }

    #[test]
    fn runs_are_half_open_and_reach_both_ends() {
        let keep = [true, true, false, true, false, false, true];
        assert_eq!(runs(&keep), [(0, 2), (3, 4), (6, 7)]);
        assert_eq!(runs(&[false; 3]), []);
    }
}
