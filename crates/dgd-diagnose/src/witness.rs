//! The riser's transmitter as a witness of those at the pump inlet: it hangs a few metres away, and their readings differ by
//! little but a constant, what the suction loses, and a difference of their spans.

use crate::empirical::is_correction;
use crate::noise::{Layout, Wander, Whitening};
use crate::record::{Record, bridged, mean};
use crate::relations::{Applied, Rows};
use crate::scan::ln_mean_exp;
use crate::tangent::dot;
use crate::unrest::WANDER_S;
use crate::vectors::most_within;
use dgd_effects::{Action, Changes, KNOTS, Moment, Rank, quantile};
use nalgebra::{DMatrix, DVector};
use std::ops::Range;

/// What the inlets may lose at the suction, and by how much the spans of the transmitters may differ, Pa.
const SUCTION_PA: f64 = 1.0e4;
const SPAN_PA: f64 = 3.0e3;

/// Size and time over which they part where one of them is at fault, Pa and s: more, or faster, than they wander within accuracy.
const PARTING: [(f64, f64); 4] = [
    (1.5e4, 1000.0),
    (1.5e4, WANDER_S),
    (6.0e4, 1000.0),
    (6.0e4, WANDER_S),
];

/// Evidence from which on they do.
const PARTS: f64 = 15.0;

/// Inlet less riser pressure, block by block, beside the noise that the two have.
pub(crate) struct Witness {
    whitening: Whitening,
    /// Less its median, Pa; NaN where either cannot be trusted.
    residual: Vec<f64>,
    /// The same, whitened.
    apart: Vec<f64>,
    /// What the two may differ by at its prior width, as it is and whitened.
    may: Vec<Vec<f64>>,
    free: Vec<Vec<f64>>,
    wander: Wander,
    /// Middle of each block, s.
    t_s: Vec<f64>,
}

impl Witness {
    /// `None` without the riser's transmitter. What `state` corrects either reading by is taken off; `excluded` blocks
    /// carry no weight.
    pub(crate) fn of(
        record: &Record,
        state: &[Applied],
        wander: Wander,
        excluded: &[bool],
    ) -> Option<Self> {
        let riser = record.riser.as_ref()?;
        let (m, n) = (record.per_block, record.blocks);
        let block = |values: &[f64], b: usize| mean(&values[b * m..(b + 1) * m]);
        let t_s: Vec<f64> = (0..n)
            .map(|b| mean(&record.t_s[b * m..(b + 1) * m]))
            .collect();
        let held = held_apart(record, state, &t_s);
        let apart: Vec<f64> = (0..n)
            .map(|b| block(&record.inlet, b) - block(riser, b) - held[b])
            .collect();
        let middle = quantile(apart.iter().copied(), Rank::MEDIAN)?;
        let residual: Vec<f64> = apart.iter().map(|v| v - middle).collect();
        let valid = (0..n)
            .map(|b| residual[b].is_finite() && !excluded.get(b).copied().unwrap_or(false))
            .collect();
        let layout = Layout {
            blocks: 0,
            difference: n,
            mass: 0,
        };
        let rows = Rows {
            friction: Vec::new(),
            still: Vec::new(),
            head: Vec::new(),
            difference: valid,
            mass: Vec::new(),
        };
        let whitening = Whitening::of(layout, &rows, &residual, &vec![0.0; n], wander);
        let flow = &record.filled.flow;
        let typical = quantile(flow.iter().copied(), Rank::MEDIAN)?.max(1e-3);
        let (low, high) = record.setting.inlet_range_pa;
        let square = |b: usize| SUCTION_PA * (block(flow, b) / typical).powi(2);
        let span =
            |b: usize| SPAN_PA * (block(&record.filled.inlet, b) - low) / (high - low).max(SPAN_PA);
        let column = |of: &dyn Fn(usize) -> f64| -> Vec<f64> { (0..n).map(of).collect() };
        let may = vec![column(&|_| 1e5), column(&square), column(&span)];
        Some(Self {
            apart: whitening.apply_whole(&residual),
            residual,
            free: may.iter().map(|c| whitening.apply_whole(c)).collect(),
            may,
            wander,
            t_s,
            whitening,
        })
    }

    /// Inlet less riser pressure, less its median, by block, Pa.
    pub(crate) fn residual(&self) -> &[f64] {
        &self.residual
    }

    /// Middle of each block, s.
    pub(crate) fn t_s(&self) -> &[f64] {
        &self.t_s
    }

    /// Standard deviation of a block's noise, Pa.
    pub(crate) fn noise_pa(&self) -> f64 {
        let weights = self.whitening.weight.iter().copied();
        quantile(weights.filter(|w| *w > 0.0), Rank::MEDIAN).map_or(f64::NAN, |w| 1.0 / w)
    }

    /// What the two differ by beyond what they may, block by block, Pa, and its evidence against their wander within accuracy,
    /// without the so many blocks that show most of it; `None` where that does not stand out.
    ///
    /// However fast it comes and goes, it needs no knots: it is seen.
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
        let left: Vec<f64> = (self.residual.iter().enumerate())
            .map(|(b, r)| r - known(b))
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

    /// Normal equations of a curve over time that the inlet reads too much by: its knots, of width `unit`, from `from` to
    /// `to` s, with what the two may differ by at any time taken out.
    pub(crate) fn normal_equations(
        &self,
        (from, to): (f64, f64),
        unit: f64,
    ) -> Option<(DMatrix<f64>, DVector<f64>)> {
        let place = |t: f64| (t - from) / (to - from) * (KNOTS - 1) as f64;
        let knots: Vec<Vec<f64>> = (0..KNOTS)
            .map(|k| {
                let hat = |t: &f64| unit * (1.0 - (place(*t) - k as f64).abs()).max(0.0);
                let column: Vec<f64> = self.t_s.iter().map(hat).collect();
                self.whitening.apply_whole(&column)
            })
            .collect();
        let m = self.free.len();
        let own = DMatrix::from_fn(m, m, |a, b| {
            dot(&self.free[a], &self.free[b]) + f64::from(u8::from(a == b))
        });
        let factor = own.cholesky()?;
        let across = DMatrix::from_fn(m, KNOTS, |a, k| dot(&self.free[a], &knots[k]));
        let pull = DVector::from_fn(m, |a, _| dot(&self.free[a], &self.apart));
        let gram = DMatrix::from_fn(KNOTS, KNOTS, |a, b| dot(&knots[a], &knots[b]))
            - across.transpose() * factor.solve(&across);
        let right = DVector::from_fn(KNOTS, |k, _| dot(&knots[k], &self.apart))
            - across.transpose() * factor.solve(&pull);
        Some((gram, right))
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

    fn of(witness: &Witness, whitening: &Whitening) -> Option<Self> {
        let mut left = whitening.apply_whole(&witness.residual);
        let free: Vec<Vec<f64>> = (witness.may.iter())
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

/// Medians of a minute about each block: edges stay, noise goes.
fn medians(values: &[f64]) -> Vec<f64> {
    const REACH: usize = 3;
    (0..values.len())
        .map(|b| {
            let near = &values[b.saturating_sub(REACH)..(b + REACH + 1).min(values.len())];
            quantile(near.iter().copied(), Rank::MEDIAN).unwrap_or(0.0)
        })
        .collect()
}

/// By how much the corrections of a hypothesis hold the inlets to read more than the riser's, at some times, Pa.
fn held_apart(record: &Record, state: &[Applied], t_s: &[f64]) -> Vec<f64> {
    let corrections = state.iter().filter(|a| is_correction(a.effect));
    // They are corrected over time alone: the readings of a moment do not count.
    let mut actions: Vec<Action> = corrections
        .map(|a| a.effect.begin(&a.parameters, &record.setting))
        .collect();
    let seconds = record.block_s();
    (t_s.iter().enumerate())
        .map(|(index, t)| {
            let i = (index * record.per_block).min(record.t_s.len() - 1);
            let f = &record.filled;
            let moment = Moment {
                index,
                t_s: *t,
                dt_s: seconds,
                mud_pump_m3_s: f.mud_pump[i],
                booster_m3_s: f.booster[i],
                topfill_m3_s: f.topfill[i],
                flow_m3_s: f.flow[i],
                speed_pct: f.speed[i],
                inlet_pa: f.inlet[i],
                outlet_pa: f.outlet[i],
                pumping: f.pumping[i],
            };
            let mut changes = Changes::default();
            for action in &mut actions {
                action(&moment, &mut changes);
            }
            changes.inlet_bias_pa - changes.riser_bias_pa
        })
        .collect()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may fail by panic")]

    use super::Witness;
    use crate::claims::fixture::steady;
    use crate::draws::normals;
    use crate::noise::Wander;
    use crate::record::Record;
    use dgd_effects::KNOTS;
    use nalgebra::DMatrix;

    const BLOCKS: usize = 1200;
    /// Accuracy of a good transmitter, wandering over two hours.
    const WANDER: Wander = Wander {
        friction_pa: 0.0,
        head_pa: 0.0,
        difference_pa: 3e3,
        mass_m3_s: 0.0,
        blocks: 800.0,
        hidden_friction_pa: 0.0,
        hidden_head_pa: 0.0,
        hidden_blocks: 30.0,
    };
    const UNIT: f64 = 1.5e4;

    /// Inlets that read too much by `drift` at each share of the recording, 3 m of mud above the riser's transmitter.
    fn drifting(drift: impl Fn(f64) -> f64) -> Record {
        let mut record = steady(BLOCKS);
        let n = record.t_s.len();
        let noise = [normals(1, n), normals(2, n)];
        let truth = record.inlet.clone();
        let riser = (0..n).map(|i| truth[i] + 3.5e4 + 800.0 * noise[0][i]);
        record.riser = Some(riser.collect());
        for i in 0..n {
            record.inlet[i] += 800.0 * noise[1][i] + drift(i as f64 / n as f64);
        }
        record
    }

    /// Evidence of a curve of free knots, and the knots, Pa.
    fn curve(record: &Record, excluded: &[bool]) -> (f64, Vec<f64>) {
        let witness = Witness::of(record, &[], WANDER, excluded).unwrap();
        let (gram, right) = witness
            .normal_equations(record.setting.span_s, UNIT)
            .unwrap();
        let factor = (gram + DMatrix::identity(KNOTS, KNOTS)).cholesky().unwrap();
        let solved = factor.solve(&right);
        let price: f64 = factor.l().diagonal().iter().map(|d| d.ln()).sum();
        let knots = solved.iter().map(|v| v * UNIT).collect();
        (0.5 * right.dot(&solved) - price, knots)
    }

    #[test]
    fn the_riser_tells_how_the_inlets_drift_but_for_a_constant() {
        let of = |share: f64| 2.5e4 * (7.0 * share).sin();
        let (evidence, knots) = curve(&drifting(of), &[]);
        assert!(evidence > 100.0, "{evidence}");
        let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
        let truth: Vec<f64> = (0..KNOTS)
            .map(|k| of(k as f64 / (KNOTS - 1) as f64))
            .collect();
        let (shift, centre) = (mean(&knots), mean(&truth));
        for (found, truth) in knots.iter().zip(&truth) {
            assert!(((found - shift) - (truth - centre)).abs() < 5e3);
        }
    }

    #[test]
    fn transmitters_that_differ_by_a_constant_and_their_accuracy_tell_nothing() {
        let (evidence, _) = curve(&drifting(|share| 3e3 * (5.0 * share).sin()), &[]);
        assert!(evidence < 0.0, "{evidence}");
    }

    #[test]
    fn what_parts_the_two_is_told_by_block_beside_its_noise() {
        // Two transmitters of 800 Pa, five samples a block.
        let noise = 800.0 * (2.0_f64 / 5.0).sqrt();
        let found = |record: &Record, excluded: &[bool]| {
            let witness = Witness::of(record, &[], WANDER, excluded).unwrap();
            witness.noise_pa() / noise
        };
        let calm = found(&drifting(|_| 0.0), &[]);
        assert!((calm - 1.0).abs() < 0.1, "{calm}");
        // Blocks that are not looked at tell nothing of it.
        let mut noisy = drifting(|_| 0.0);
        for (i, p) in noisy.inlet.iter_mut().enumerate().skip(BLOCKS) {
            *p += if i % 2 == 0 { 1e5 } else { -1e5 };
        }
        let late: Vec<bool> = (0..BLOCKS).map(|b| 5 * b >= BLOCKS - 5).collect();
        let looked = found(&noisy, &late);
        assert!((looked - 1.0).abs() < 0.1, "{looked}");

        // The column between the two is taken out, a step is not.
        let step = |share: f64| if share >= 0.75 { 4e4 } else { 0.0 };
        let witness = Witness::of(&drifting(step), &[], WANDER, &[]).unwrap();
        let (residual, t_s) = (witness.residual(), witness.t_s());
        assert_eq!((residual.len(), t_s.len()), (BLOCKS, BLOCKS));
        for (b, (residual, t)) in residual.iter().zip(t_s).enumerate() {
            // Of samples at 0, 2, 4, 6 and 8 s.
            assert!((t - (10.0 * b as f64 + 4.0)).abs() < 1e-9);
            let off = residual - step(b as f64 / BLOCKS as f64);
            assert!(off.abs() < 6.0 * noise, "{b}: {off}");
        }
    }

    #[test]
    fn a_drift_is_the_same_by_a_clock_that_starts_later() {
        let early = drifting(|share| 2.5e4 * (7.0 * share).sin());
        let mut late = early.clone();
        late.t_s.iter_mut().for_each(|t| *t += 7e4);
        late.setting.span_s = (early.setting.span_s.0 + 7e4, early.setting.span_s.1 + 7e4);
        let (early, late) = (curve(&early, &[]), curve(&late, &[]));
        assert!((early.0 - late.0).abs() < 1e-3);
        for (early, late) in early.1.iter().zip(&late.1) {
            assert!((early - late).abs() < 0.1);
        }
    }

    #[test]
    fn what_the_suction_loses_and_a_difference_of_spans_are_no_drift() {
        let slow = |share: f64| (7.0 * share).sin();
        let flow = |share: f64| 0.04 * (1.0 + 0.3 * slow(share));
        let squared = |share: f64| -2e4 * (flow(share) / 0.04).powi(2);
        let spanned = |share: f64| 1.2e4 * slow(share);
        let told = |apart: &dyn Fn(f64) -> f64, flows: bool, spans: bool| {
            let mut record = drifting(apart);
            let n = record.t_s.len();
            let (low, high) = record.setting.inlet_range_pa;
            for i in 0..n {
                let share = i as f64 / n as f64;
                if flows {
                    record.filled.flow[i] = flow(share);
                }
                if spans {
                    record.filled.inlet[i] = 0.5 * (low + high + (high - low) * slow(share));
                }
            }
            curve(&record, &[]).0
        };
        // What follows neither flow nor pressure drifts.
        for (apart, flows) in [(&squared as &dyn Fn(f64) -> f64, true), (&spanned, false)] {
            let (alone, known) = (told(apart, false, false), told(apart, flows, !flows));
            assert!(alone > 5.0 && known < 0.0, "{alone} {known}");
        }
    }

    #[test]
    fn what_the_mud_does_moves_both_alike_and_a_constant_is_not_told() {
        let mut record = drifting(|_| 0.0);
        let n = record.t_s.len();
        for i in 0..n {
            let mud = 1e5 * (7.0 * i as f64 / n as f64).sin();
            record.inlet[i] += mud;
            record.riser.as_mut().unwrap()[i] += mud;
        }
        assert!(curve(&record, &[]).0 < 0.0);
        // Knots that are all alike are a constant, of which the two tell next to nothing.
        let witness = Witness::of(&record, &[], WANDER, &[]).unwrap();
        let span = record.setting.span_s;
        let (gram, right) = witness.normal_equations(span, UNIT).unwrap();
        assert!(
            gram.sum().abs() < 0.05 * gram.trace(),
            "{} {}",
            gram.sum(),
            gram.trace()
        );
        assert!(right.sum().abs() < 0.1 * gram.trace());
    }

    #[test]
    fn excluded_blocks_and_a_riser_without_transmitter_are_no_witness() {
        // A reading that jumps in the stretch that is not looked at.
        let jump = |share: f64| if share > 0.8 { 1e5 } else { 0.0 };
        let late: Vec<bool> = (0..BLOCKS).map(|b| b > 950).collect();
        assert!(curve(&drifting(jump), &[]).0 > 100.0);
        assert!(curve(&drifting(jump), &late).0 < 0.0);
        assert!(Witness::of(&steady(100), &[], WANDER, &[]).is_none());
    }
}
