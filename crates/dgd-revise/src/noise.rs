//! What is left over when nothing is left out: an autoregression for each output, with a robust scale.

use crate::stack::Data;
use crate::tangent::dot;
use nalgebra::{DMatrix, DVector};

/// Noise of each output.
#[derive(Debug, Clone)]
pub(crate) struct Noise {
    /// By output.
    pub of: Vec<Ar>,
}

/// Autoregression of one output's residual.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Ar {
    /// Coefficients, the last sample's first; none for white noise.
    pub a: Vec<f64>,
    /// Robust standard deviation of the innovations.
    pub sigma: f64,
    /// Rows.
    pub rows: usize,
    /// Samples from one row to the next.
    pub stride: usize,
}

/// Longest memory tried, in samples.
const LONGEST: usize = 4;

impl Noise {
    /// Order by Akaike's criterion from no memory up to four samples, coefficients by least squares, scale by the median.
    pub(crate) fn of(data: &Data, residual: &[f64], outputs: usize) -> Self {
        let of = (0..outputs)
            .map(|o| {
                let runs = runs(data, o);
                let mut best = (f64::INFINITY, Ar::without_memory(data, residual, o));
                for order in 0..=LONGEST {
                    if let Some(ar) = Ar::fit(residual, &runs, order) {
                        let n = ar.rows as f64;
                        let square: f64 = innovations(&ar.a, residual, &runs)
                            .iter()
                            .map(|e| e * e)
                            .sum();
                        let aic = n * (square / n).max(1e-300).ln() + 2.0 * order as f64;
                        if aic < best.0 - 4.0 {
                            best = (aic, ar);
                        }
                    }
                }
                best.1.stride = stride(data, o);
                best.1
            })
            .collect();
        Self { of }
    }

    /// The longest memory of an output, in samples.
    pub(crate) fn memory(&self) -> usize {
        self.of.iter().map(Ar::memory).max().unwrap_or(1)
    }

    /// Rows turned into innovations in standard deviations; 0 where there is no past.
    pub(crate) fn whiten(&self, data: &Data, values: &[f64]) -> Vec<f64> {
        let mut out = vec![0.0; values.len()];
        for (o, ar) in self.of.iter().enumerate() {
            if !(ar.sigma > 0.0) {
                continue;
            }
            let p = ar.a.len();
            for run in runs(data, o) {
                for i in run.start + p..run.end {
                    let past: f64 = (0..p).map(|k| ar.a[k] * values[i - 1 - k]).sum();
                    out[i] = (values[i] - past) / ar.sigma;
                }
            }
        }
        out
    }
}

/// Samples from one row of an output to the next, usually: a slow instrument leaves cells empty.
fn stride(data: &Data, output: usize) -> usize {
    let rows = data.of_output(output);
    let mut apart: Vec<usize> = rows
        .windows(2)
        .map(|w| (&data.rows[w[0]], &data.rows[w[1]]))
        .filter(|(a, b)| a.window == b.window)
        .map(|(a, b)| b.sample - a.sample)
        .collect();
    apart.sort_unstable();
    apart.get(apart.len() / 2).copied().unwrap_or(1)
}

/// Rows of an output without a gap: no two further apart than one and a half times as usual.
pub(crate) fn runs(data: &Data, output: usize) -> Vec<std::ops::Range<usize>> {
    let most = 3 * stride(data, output) / 2;
    let mut all: Vec<std::ops::Range<usize>> = Vec::new();
    for (i, row) in data
        .rows
        .iter()
        .enumerate()
        .filter(|(_, r)| r.output == output)
    {
        match all.last_mut() {
            Some(last)
                if last.end == i
                    && data.rows[i - 1].window == row.window
                    && row.sample - data.rows[i - 1].sample <= most =>
            {
                last.end = i + 1;
            }
            _ => all.push(i..i + 1),
        }
    }
    all
}

fn innovations(a: &[f64], r: &[f64], runs: &[std::ops::Range<usize>]) -> Vec<f64> {
    let p = a.len();
    let mut all = Vec::new();
    for run in runs {
        // The same rows for every order, so that orders can be compared.
        for i in run.start + LONGEST..run.end {
            all.push(r[i] - (0..p).map(|k| a[k] * r[i - 1 - k]).sum::<f64>());
        }
    }
    all
}

impl Ar {
    /// All rows of an output, whatever lies between them.
    fn without_memory(data: &Data, residual: &[f64], output: usize) -> Self {
        let rows = data.of_output(output);
        let values: Vec<f64> = rows.iter().map(|&i| residual[i]).collect();
        Self {
            sigma: robust(&values),
            rows: rows.len(),
            ..Self::default()
        }
    }

    fn fit(r: &[f64], runs: &[std::ops::Range<usize>], order: usize) -> Option<Self> {
        let mut normal = DMatrix::zeros(order, order);
        let mut right = DVector::zeros(order);
        for run in runs {
            for i in run.start + LONGEST..run.end {
                for k in 0..order {
                    right[k] += r[i] * r[i - 1 - k];
                    for l in 0..order {
                        normal[(k, l)] += r[i - 1 - k] * r[i - 1 - l];
                    }
                }
            }
        }
        let a = if order == 0 {
            Vec::new()
        } else {
            normal.cholesky()?.solve(&right).as_slice().to_vec()
        };
        let innovations = innovations(&a, r, runs);
        if innovations.len() < 2 * LONGEST {
            return None;
        }
        Some(Self {
            sigma: robust(&innovations),
            rows: innovations.len(),
            stride: 1,
            a,
        })
    }

    /// Response to one innovation; `None` if it does not die out.
    fn impulse(&self) -> Option<Vec<f64>> {
        let mut all = vec![1.0];
        while all.len() < RESPONSE {
            let past = all.iter().rev();
            let next: f64 = self.a.iter().zip(past).map(|(a, p)| a * p).sum();
            if !(next.abs() < GROWN) {
                return None;
            }
            all.push(next);
        }
        Some(all)
    }

    /// Samples over which the residual remembers itself, from the AR's own correlation; at most those of 200 rows.
    pub(crate) fn memory(&self) -> usize {
        let last = self.impulse().map_or(MEMORY, |psi| {
            let square = dot(&psi, &psi);
            let remembers = |k: &usize| (dot(&psi[*k..], &psi) / square).abs() > 0.2;
            (1..MEMORY).rev().find(remembers).map_or(1, |k| k + 1)
        });
        // A row of a slow instrument stands for the samples up to the next only where it remembers itself.
        1 + (last - 1) * self.stride.max(1)
    }

    /// Variance of a mean of many against that of white ones of the same deviation, (Σψ)²/Σψ²; between 1 and 199, that of a first
    /// order with 0.99.
    pub(crate) fn inflation(&self) -> f64 {
        let of = |psi: Vec<f64>| psi.iter().sum::<f64>().powi(2) / dot(&psi, &psi);
        self.impulse().map_or(INFLATION, of).clamp(1.0, INFLATION)
    }
}

/// Samples of a response to one innovation.
const RESPONSE: usize = 1000;
/// A response that grows so far does not die out.
const GROWN: f64 = 1e3;
/// Longest memory, in rows.
const MEMORY: usize = 200;
const INFLATION: f64 = 199.0;

/// 1.4826 times the median size; the root mean square where more than half are nought.
pub(crate) fn robust(values: &[f64]) -> f64 {
    let mut sizes: Vec<f64> = values.iter().map(|v| v.abs()).collect();
    sizes.sort_by(f64::total_cmp);
    let median = 1.4826 * sizes.get(sizes.len() / 2).copied().unwrap_or(0.0);
    if median > 0.0 {
        median
    } else {
        (values.iter().map(|v| v * v).sum::<f64>() / values.len().max(1) as f64).sqrt()
    }
}

/// Ljung and Box's portmanteau statistic over `lags` lags, and its normal deviate under white noise
/// (Wilson and Hilferty's root of the chi-square); 0 both where there are too few values to tell.
pub(crate) fn portmanteau(values: &[f64], lags: usize) -> (f64, f64) {
    let n = values.len() as f64;
    let square: f64 = values.iter().map(|v| v * v).sum();
    if !(square > 0.0) || lags == 0 || values.len() <= lags + 1 {
        return (0.0, 0.0);
    }
    let q: f64 = (1..=lags)
        .map(|k| {
            let r = values.windows(k + 1).map(|w| w[0] * w[k]).sum::<f64>() / square;
            r * r / (n - k as f64)
        })
        .sum::<f64>()
        * n
        * (n + 2.0);
    let d = lags as f64;
    let deviate = ((q / d).cbrt() - (1.0 - 2.0 / (9.0 * d))) / (2.0 / (9.0 * d)).sqrt();
    (q, deviate)
}

/// Probability that a standard normal number exceeds `z` (Abramowitz and Stegun 26.2.17).
pub(crate) fn upper_tail(z: f64) -> f64 {
    let t = 1.0 / (1.0 + 0.231_641_9 * z.abs());
    let polynomial = t
        * (0.319_381_530
            + t * (-0.356_563_782
                + t * (1.781_477_937 + t * (-1.821_255_978 + t * 1.330_274_429))));
    let tail = polynomial * (-0.5 * z * z).exp() / (2.0 * std::f64::consts::PI).sqrt();
    if z < 0.0 { 1.0 - tail } else { tail }
}

/// Lags of the portmanteau test.
pub(crate) fn lags(rows: usize) -> usize {
    20.min(rows / 5)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may")]
    use super::*;
    use crate::draws::Draws;
    use dgd_assembly::Window;

    #[test]
    fn tails_are_those_of_the_table() {
        assert!((upper_tail(1.959_964) - 0.025).abs() < 1e-6);
        assert!((upper_tail(-1.0) - 0.841_345).abs() < 1e-6);
    }

    #[test]
    fn a_remembering_residual_is_not_white_and_its_memory_is_seen() {
        let mut x = 0.0;
        let r: Vec<f64> = (0..400_u32)
            .map(|i| {
                x = 0.9 * x + f64::from(i * i % 101) / 50.0 - 1.0;
                x
            })
            .collect();
        assert!(portmanteau(&r, 20).1 > 5.0);
        let ar = Ar {
            a: vec![0.9],
            sigma: 1.0,
            rows: 400,
            stride: 1,
        };
        // 0.9^15 = 0.206
        assert_eq!(ar.memory(), 16);
        assert!((ar.inflation() - 1.9 / 0.1).abs() < 1e-6);
        assert_eq!(Ar { stride: 3, ..ar }.memory(), 46);
    }

    #[test]
    fn of_four_readings_no_memory_is_told() {
        let values = [1.0, -0.4, 0.7, 0.2];
        assert_eq!(portmanteau(&values, lags(values.len())), (0.0, 0.0));
    }

    #[test]
    fn what_is_remembered_beyond_one_sample_lasts_and_counts_by_its_own_correlation() {
        let of = |a: &[f64]| Ar {
            a: a.to_vec(),
            ..Ar::default()
        };
        // Yule and Walker for x = 0.5 x₋₁ + 0.4 x₋₂: ρ₁ = 0.5/0.6, ρ₂ = 0.5 ρ₁ + 0.4, and so on.
        let mut rho = vec![1.0, 0.5 / 0.6];
        while rho.len() < 400 {
            let n = rho.len();
            rho.push(0.5 * rho[n - 1] + 0.4 * rho[n - 2]);
        }
        let ar = of(&[0.5, 0.4]);
        let last = rho.iter().rposition(|r| *r > 0.2).unwrap();
        assert_eq!(ar.memory(), last + 1);
        let inflation = 1.0 + 2.0 * rho[1..].iter().sum::<f64>();
        assert!((ar.inflation() / inflation - 1.0).abs() < 1e-6);
        // What only remembers two samples back is inflated as if each of two chains were a first order.
        assert!((of(&[0.0, 0.5]).inflation() - 3.0).abs() < 1e-6);
        // What does not die out, and what swings.
        assert_eq!((of(&[1.1]).memory(), of(&[1.1]).inflation()), (200, 199.0));
        assert_eq!(of(&[-0.5]).inflation(), 1.0);
        assert_eq!((of(&[]).memory(), of(&[]).inflation()), (1, 1.0));
    }

    /// Residual of a reading that is there in the samples of `there` only, and the noise found.
    fn noise_of(n: usize, there: impl Fn(usize) -> bool) -> (Data, Vec<f64>, Noise) {
        let mut draws = Draws::new(9, 0);
        let mut x = 0.0;
        let mut values: Vec<f64> = Vec::new();
        for i in 0..n {
            if there(i) {
                x = 0.8 * x + draws.below(20_001) as f64 / 10_000.0 - 1.0;
            }
            values.push(if there(i) { x } else { f64::NAN });
        }
        let data = Data::training(vec![Window {
            time: (0..n).map(|i| i as f64).collect(),
            readings: vec![values],
            ..Window::default()
        }]);
        let residual = data.measured.clone();
        let noise = Noise::of(&data, &residual, 1);
        (data, residual, noise)
    }

    #[test]
    fn a_slow_instrument_remembers_its_last_reading() {
        let (data, residual, noise) = noise_of(1200, |i| i % 3 == 0);
        let ar = &noise.of[0];
        assert!((ar.a[0] - 0.8).abs() < 0.1 && ar.stride == 3, "{ar:?}");
        let white = noise.whiten(&data, &residual);
        assert!(white.iter().filter(|w| **w != 0.0).count() > 390);
    }

    #[test]
    fn readings_too_scattered_to_have_neighbours_have_a_scale() {
        // Two by two, ever further apart.
        let (data, residual, noise) = noise_of(2000, |i| {
            (i as f64).sqrt() % 1.0 < 1e-9 || (i as f64 - 1.0).sqrt() % 1.0 < 1e-9
        });
        let ar = &noise.of[0];
        assert!(ar.a.is_empty() && ar.sigma > 0.0, "{ar:?}");
        let white = noise.whiten(&data, &residual);
        assert!(white.iter().all(|w| *w != 0.0));
    }
}
