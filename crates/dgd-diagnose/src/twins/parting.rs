//! Whether two transmitters part by more than instruments wander, and the curve by which they do.

use super::Twins;
use crate::noise::{Wander, Whitening};
use crate::record::bridged;
use crate::scan::ln_mean_exp;
use crate::tangent::dot;
use crate::unrest::WANDER_S;
use crate::vectors::most_within;
use dgd_effects::{Rank, quantile};
use nalgebra::{DMatrix, DVector};
use std::ops::Range;

/// Size and time over which they part where one of them is at fault, Pa and s: more, or faster, than they wander within accuracy.
const PARTING: [(f64, f64); 4] = [
    (1.5e4, 1000.0),
    (1.5e4, WANDER_S),
    (6.0e4, 1000.0),
    (6.0e4, WANDER_S),
];

/// Evidence from which on they do.
const PARTS: f64 = 15.0;

impl Twins {
    /// What the two differ by beyond what they may, block by block, Pa, and its evidence against their wander within accuracy,
    /// without the so many blocks that show most of it; `None` where that does not stand out.
    ///
    /// It is seen, and needs no knots; only what comes and goes within ten minutes or so is taken for the noise of the two.
    pub(crate) fn parting(&self, busiest: usize) -> Option<(Vec<f64>, f64)> {
        let (evidence, by_block, differ) = self.parted(0..0)?;
        if evidence <= PARTS {
            return None;
        }
        // A reading that freezes once leaves the two apart for no longer.
        let (evidence, ..) = self.parted(most_within(&by_block, busiest).0)?;
        if evidence <= PARTS {
            return None;
        }
        let known = |b: usize| -> f64 { self.may.iter().zip(&differ).map(|(c, w)| w * c[b]).sum() };
        // What may not be looked at, or is stuck, is bridged.
        let left: Vec<f64> = (self.residual.iter().enumerate())
            .map(|(b, r)| {
                if self.whitening.valid[b] {
                    r - known(b)
                } else {
                    f64::NAN
                }
            })
            .collect();
        Some((medians(&bridged(&left)), evidence))
    }

    /// Evidence that the two part, the same by block, and what they then differ by of what they may; without some blocks.
    fn parted(&self, unused: Range<usize>) -> Option<(f64, Vec<f64>, Vec<f64>)> {
        let of = |wander: Wander| {
            Likelihood::of(self, &self.whitening.with_wander(wander, unused.clone()))
        };
        let own = of(self.wander)?;
        let others: Vec<Likelihood> = PARTING
            .into_iter()
            .filter_map(|(size_pa, length_s)| {
                of(Wander {
                    difference_pa: size_pa,
                    blocks: self.wander.blocks * length_s / WANDER_S,
                    ..self.wander
                })
            })
            .collect();
        let evidence = ln_mean_exp(others.iter().map(|o| o.whole() - own.whole()));
        let best = (others.into_iter()).max_by(|a, b| a.whole().total_cmp(&b.whole()))?;
        let by_block = (best.by_block.iter().zip(&own.by_block))
            .map(|(best, own)| best - own)
            .collect();
        Some((evidence, by_block, best.differ))
    }
}

/// How likely the difference of two readings is while they wander by some size over some time.
struct Likelihood {
    /// Logarithm by block, but for a constant.
    by_block: Vec<f64>,
    /// What the freedom to differ costs.
    freedom: f64,
    /// What they then differ by, of what they may.
    differ: Vec<f64>,
}

impl Likelihood {
    fn whole(&self) -> f64 {
        self.by_block.iter().sum::<f64>() + self.freedom
    }

    fn of(twins: &Twins, whitening: &Whitening) -> Option<Self> {
        let mut left = whitening.apply_whole(&twins.residual);
        let free: Vec<Vec<f64>> = (twins.may.iter())
            .map(|column| whitening.apply_whole(column))
            .collect();
        let m = free.len();
        let own = DMatrix::from_fn(m, m, |a, b| {
            dot(&free[a], &free[b]) + f64::from(u8::from(a == b))
        });
        let pull = DVector::from_fn(m, |a, _| dot(&free[a], &left));
        let factor = own.cholesky()?;
        let differ = factor.solve(&pull);
        for (column, size) in free.iter().zip(&differ) {
            (left.iter_mut().zip(column)).for_each(|(left, v)| *left -= size * v);
        }
        let ln_volume: f64 = factor.l().diagonal().iter().map(|d| d.ln()).sum();
        let by_block = (whitening.ln_scales().zip(&left))
            .map(|(ln_scale, left)| ln_scale - 0.5 * left * left)
            .collect();
        Some(Self {
            by_block,
            freedom: -ln_volume - 0.5 * differ.norm_squared(),
            differ: differ.iter().copied().collect(),
        })
    }
}

/// Medians of seven blocks about each: edges stay, noise goes.
fn medians(values: &[f64]) -> Vec<f64> {
    const REACH: usize = 3;
    (0..values.len())
        .map(|b| {
            let near = &values[b.saturating_sub(REACH)..(b + REACH + 1).min(values.len())];
            quantile(near.iter().copied(), Rank::MEDIAN).unwrap_or(0.0)
        })
        .collect()
}
