//! Whether two transmitters part by more than instruments wander, and the curve by which they do.

use super::{Pair, Twins, precision};
use crate::bayes::ln_mean_exp;
use crate::error_budget::WANDER_S;
use crate::frozen_speed::quantum;
use crate::layout::BALANCE_BLOCKS;
use crate::noise::{Wander, Whitening};
use crate::numbers::{bridged, spread};
use crate::record::Record;
use crate::vectors::most_within;
use dgd_lsq::dot;
use dgd_recording::{Rank, quantile};
use nalgebra::DVector;
use std::ops::Range;
use tracing::debug;

/// Size and time over which they part where one of them is at fault, Pa and s: more, or faster, than they wander within accuracy.
const PARTING: [(f64, f64); 4] = [
    (1.5e4, 1000.0),
    (1.5e4, WANDER_S),
    (6.0e4, 1000.0),
    (6.0e4, WANDER_S),
];

/// Size by which one may leave the other without ever being faster than they wander, Pa: a reading that drifts all along.
const LEAVES_PA: f64 = 6.0e4;

/// Evidence from which on they do.
const PARTS: f64 = 15.0;

/// From so many standard deviations of its noise on a reading is an edge, where others are, and elsewhere a spike.
const SHARP: f64 = 4.0;

/// Noise of a block that any two have, be their last digit as coarse as it may, Pa.
const LEAST_NOISE_PA: f64 = 200.0;

/// What two transmitters that part differ by but for a constant, block by block, Pa.
pub(crate) struct Parting {
    /// Without its noise.
    pub(crate) curve: Vec<f64>,
    /// The curve less what they may differ by.
    pub(crate) beyond: Vec<f64>,
    /// As it is read, with its noise; NaN where either may not be looked at.
    read: Vec<f64>,
    /// Standard deviation of what was taken for noise.
    noise: f64,
    /// Logarithm of the Bayes factor against what they may differ by, and their wander within accuracy.
    pub(crate) evidence: f64,
    /// Whether they part as slowly as they wander, but further.
    pub(crate) creeps: bool,
}

impl Twins {
    /// How the two part, with the evidence of it without the so many blocks that show most; `None` where that does not stand out.
    ///
    /// It is seen, and needs no knots; only what comes and goes within ten minutes or so counts for nothing, however large.
    pub(crate) fn parting(&self, busiest: usize) -> Option<Parting> {
        let Parted {
            evidence,
            by_block,
            differ,
            creeps,
        } = self.parted(0..0)?;
        debug!("two transmitters part by {evidence:.1} of {PARTS}");
        if evidence <= PARTS {
            return None;
        }
        // A reading that freezes once leaves the two apart for no longer.
        let evidence = self.parted(most_within(&by_block, busiest).0)?.evidence;
        if evidence <= PARTS {
            return None;
        }
        // All of it, what they may differ by too, for the relations hold none of that but what the suction is known to lose. What may not be looked at, or is stuck, is
        // bridged.
        let read: Vec<f64> = (self.residual.iter().zip(&self.whitening.valid))
            .map(|(apart, valid)| if *valid { *apart } else { f64::NAN })
            .collect();
        // Bends, not steps: a curve that leans is no noise.
        let bends = read.windows(3).map(|w| w[0] - 2.0 * w[1] + w[2]);
        let noise = (spread(bends) / 6.0_f64.sqrt()).max(LEAST_NOISE_PA);
        let curve = straightened(&bridged(&read), noise);
        let may = |b: usize| -> f64 { self.may.iter().zip(&differ).map(|(c, w)| w * c[b]).sum() };
        let beyond = curve.iter().enumerate().map(|(b, v)| v - may(b)).collect();
        Some(Parting {
            curve,
            beyond,
            read,
            noise,
            evidence,
            creeps,
        })
    }

    /// The same where rows of the mass balance meet, of which each takes the curve for straight: as it is read there where
    /// that is beyond its noise, for what the pump's stops do to it is faster than a median.
    pub(crate) fn at_edges(&self, record: &Record, pair: Pair, parting: &Parting) -> Vec<f64> {
        let Some([first, second]) = pair.readings(record) else {
            return Vec::new();
        };
        let m = record.per_block;
        let apart = |samples: Range<usize>| pair.differ(record, [first, second], samples);
        // Few samples are as coarse as their last digit.
        let digit =
            quantum(first, record.dt_s).hypot(quantum(second, record.dt_s)) / 12.0_f64.sqrt();
        (0..=record.blocks / BALANCE_BLOCKS)
            .map(|row| {
                let b = row * BALANCE_BLOCKS;
                let beside = [b.saturating_sub(1), b.min(record.blocks - 1)];
                let of = |values: &[f64]| 0.5 * (values[beside[0]] + values[beside[1]]);
                let smooth = of(&parting.curve);
                let blocks = beside.map(|b| apart(b * m..(b + 1) * m));
                let about = record.about_edge(b * m);
                let noise = (parting.noise * (m as f64 / about.len() as f64).sqrt()).hypot(digit);
                let here = apart(about);
                let read = of(&parting.read) + here - 0.5 * (blocks[0] + blocks[1]);
                if (read - smooth).abs() > SHARP * noise {
                    read
                } else {
                    smooth
                }
            })
            .collect()
    }

    /// Whether the two part, without some blocks.
    fn parted(&self, unused: Range<usize>) -> Option<Parted> {
        let of = |wander: Wander| {
            Likelihood::of(self, &self.whitening.with_wander(wander, unused.clone()))
        };
        let own = of(self.wander)?;
        // As fast as they wander, for so much longer as it goes further.
        let further = LEAVES_PA / self.wander.outlets_pa;
        let leaving = (LEAVES_PA, WANDER_S * further * further);
        let others: Vec<Likelihood> = (PARTING.into_iter().chain([leaving]))
            .filter_map(|(size_pa, length_s)| {
                of(Wander {
                    outlets_pa: size_pa,
                    blocks: self.wander.blocks * length_s / WANDER_S,
                    ..self.wander
                })
            })
            .collect();
        let evidence = ln_mean_exp(others.iter().map(|o| o.whole() - own.whole()));
        let slowest = others.len().checked_sub(1)?;
        let (at, best) =
            (others.into_iter().enumerate()).max_by(|a, b| a.1.whole().total_cmp(&b.1.whole()))?;
        let by_block = (best.by_block.iter().zip(&own.by_block))
            .map(|(best, own)| best - own)
            .collect();
        Some(Parted {
            evidence,
            by_block,
            differ: best.differ,
            creeps: at == slowest,
        })
    }
}

/// Whether two readings part.
struct Parted {
    evidence: f64,
    by_block: Vec<f64>,
    /// What they then differ by, of what they may.
    differ: Vec<f64>,
    creeps: bool,
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
        let pull = DVector::from_fn(free.len(), |a, _| dot(&free[a], &left));
        let factor = precision(&free)?;
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

/// Values averaged over surroundings in which they are straight, up to thirty blocks on either side: edges stay, noise and spikes go.
///
/// What noise is left in the curve is noise in the relations, where it hides how much of it they find (errors in variables).
fn straightened(values: &[f64], noise: f64) -> Vec<f64> {
    const REACH: usize = 30;
    let middle = medians(values);
    let calm: Vec<f64> = (values.iter().zip(&middle))
        .map(|(v, m)| {
            if (v - m).abs() <= SHARP * noise {
                *v
            } else {
                *m
            }
        })
        .collect();
    // Of medians of seven such a bend stands out by half as much.
    let straight = |a: usize, b: usize, c: usize| {
        (middle[a] - 2.0 * middle[b] + middle[c]).abs() <= 2.0 * noise
    };
    (0..values.len())
        .map(|b| {
            let (mut sum, mut count) = (calm[b], 1.0);
            let beside = (1..=REACH.min(b)).map(|k| (b - k, b + k));
            for (before, after) in
                beside.take_while(|(a, c)| *c < values.len() && straight(*a, b, *c))
            {
                sum += calm[before] + calm[after];
                count += 2.0;
            }
            sum / count
        })
        .collect()
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

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may fail by panic")]

    use super::{Likelihood, Twins, straightened};
    use crate::noise::Wander;
    use crate::test_rig::normals;
    use crate::twins::tests::{BLOCKS, WANDER, drifting, twins};
    use dgd_lsq::dot;
    use nalgebra::{DMatrix, DVector};

    /// Two that drift apart within a quarter of an hour while the pressures swing.
    fn apart() -> Twins {
        let mut record = drifting(|share| 1e4 * (80.0 * share).sin());
        let n = record.t_s.len() as f64;
        for (i, p) in record.filled.inlet.iter_mut().enumerate() {
            *p += 1e5 * (9.0 * i as f64 / n).sin();
        }
        twins(&record, &[]).unwrap()
    }

    /// How likely their difference is by a wander of so many Pa over so many blocks.
    fn likelihood(twins: &Twins, outlets_pa: f64, blocks: f64) -> f64 {
        let wander = Wander {
            outlets_pa,
            blocks,
            ..WANDER
        };
        let whitening = twins.whitening.with_wander(wander, 0..0);
        Likelihood::of(twins, &whitening).unwrap().whole()
    }

    #[test]
    fn the_likelihood_is_that_of_a_gaussian_that_holds_what_the_two_may_differ_by() {
        let twins = apart();
        let whitening = &twins.whitening;
        let white = whitening.apply_whole(&twins.residual);
        let columns: Vec<Vec<f64>> = (twins.may.iter())
            .map(|column| whitening.apply_whole(column))
            .collect();
        let n = BLOCKS;
        let shared = DMatrix::from_fn(n, columns.len(), |b, k| columns[k][b]);
        let covariance = DMatrix::identity(n, n) + &shared * shared.transpose();
        let factor = covariance.cholesky().unwrap();
        let white = DVector::from_vec(white);
        let ln_volume: f64 = factor.l().diagonal().iter().map(|d| d.ln()).sum();
        let expected =
            whitening.ln_scales().sum::<f64>() - 0.5 * white.dot(&factor.solve(&white)) - ln_volume;
        let found = likelihood(&twins, WANDER.outlets_pa, WANDER.blocks);
        assert!((found - expected).abs() < 1e-6, "{found} {expected}");
        // What they may differ by counts in it.
        assert!((found + 0.5 * dot(&twins.apart, &twins.apart)).abs() > 1.0);
    }

    #[test]
    fn the_two_part_where_they_go_further_or_faster_than_instruments_wander() {
        let twins = apart();
        // 15 and 60 kPa, over 1000 and 8000 s.
        let own = likelihood(&twins, WANDER.outlets_pa, 800.0);
        let further = 6e4 / WANDER.outlets_pa;
        let slow = (6e4, 800.0 * further * further);
        let gains = [
            (1.5e4, 100.0),
            (1.5e4, 800.0),
            (6e4, 100.0),
            (6e4, 800.0),
            slow,
        ]
        .map(|(size_pa, blocks)| likelihood(&twins, size_pa, blocks) - own);
        let mean = gains.iter().map(|gain| gain.exp()).sum::<f64>() / 5.0;
        let evidence = twins.parting(0).unwrap().evidence;
        assert!((evidence - mean.ln()).abs() < 1e-6, "{evidence}");
        // Fast ones of no more than a wander's size part by how fast they are.
        assert!(gains[0] > 5.0 + gains[1], "{gains:?}");
        assert!(!twins.parting(0).unwrap().creeps);
    }

    #[test]
    fn the_noise_of_the_two_is_told_by_bends_beside_a_drift() {
        let noise = 800.0 * (2.0_f64 / 5.0).sqrt();
        let found = apart().parting(0).unwrap().noise;
        assert!((found / noise - 1.0).abs() < 0.1, "{found}");
    }

    #[test]
    fn a_curve_is_straightened_alike_in_every_unit() {
        let values: Vec<f64> = (normals(5, 400).iter().enumerate())
            .map(|(b, noise)| 20.0 * (b as f64 / 30.0).sin() + noise)
            .collect();
        // A power of two, so that digits stay.
        let finer: Vec<f64> = values.iter().map(|v| 1024.0 * v).collect();
        let coarse = straightened(&values, 1.0);
        let scaled: Vec<f64> = coarse.iter().map(|v| 1024.0 * v).collect();
        assert_eq!(straightened(&finer, 1024.0), scaled);
    }

    #[test]
    fn noise_goes_where_the_curve_is_straight_and_edges_stay() {
        let n: usize = 800;
        let truth = |b: usize| 0.05 * b as f64 + if b < 400 { 0.0 } else { 30.0 };
        let values: Vec<f64> = (normals(3, n).iter().enumerate())
            .map(|(b, noise)| truth(b) + noise)
            .collect();
        let found = straightened(&values, 1.0);
        let off = |b: usize| found[b] - truth(b);
        let calm = (40..360).chain(440..760);
        let square: f64 = calm.clone().map(|b| off(b).powi(2)).sum();
        assert!((square / calm.count() as f64).sqrt() < 0.3);
        for b in 390..410 {
            assert!(off(b).abs() < 3.0, "{b}: {}", off(b));
        }
        // Three blocks that are far off are no part of it.
        let mut spiked = values.clone();
        spiked[200..203].fill(1e3);
        for (b, (with, without)) in straightened(&spiked, 1.0).iter().zip(&found).enumerate() {
            assert!((with - without).abs() < 1.5, "{b}: {with} {without}");
        }
    }
}
