//! Two transmitters of one pressure: their readings differ by little but a constant, a difference of their spans and of their
//! answers, and those of the inlets and the riser by what the suction loses on the few metres between.

mod parting;

use crate::layout::Layout;
use crate::noise::{Wander, Whitening};
use crate::numbers::{mean, tails};
use crate::record::Record;
use crate::relations::{Applied, FINE_KNOTS, Rows, begun, repeats};
use dgd_effects::{Changes, Curve, KNOTS, Moment, Place, Quantity, STANDING_M3_S};
use dgd_lsq::dot;
use dgd_recording::{Rank, quantile};
use nalgebra::{Cholesky, DMatrix, DVector, Dyn};
use std::ops::Range;

/// What the inlets may lose at the suction, and by how much the spans of the transmitters may differ, Pa.
const SUCTION_PA: f64 = 1.0e4;
const SPAN_PA: f64 = 3.0e3;

/// By how much one of them may answer later than the other, s.
const LATE_S: f64 = 10.0;

/// A transmitter that repeats one value for so long while the other does not is stuck, s.
const STUCK_S: f64 = 60.0;

/// The curve of a correction that is seen, finer than any that is drawn: the shortest record has 64 rows of the balance.
pub(crate) fn seen_curve(one: &Applied) -> Option<Curve> {
    let seen = |curve: &Curve| {
        curve.knots.len() > FINE_KNOTS
            && curve.quantity == Quantity::Time
            && Pair::of(curve.place).is_some()
    };
    one.curve().filter(seen)
}

/// Which two.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Pair {
    /// The two at the pump inlet.
    Inlets,
    /// The two at the pump outlet.
    Outlets,
    /// Those at the pump inlet, and the riser's.
    InletAndRiser,
}

impl Pair {
    pub(crate) const ALL: [Self; 3] = [Self::Inlets, Self::Outlets, Self::InletAndRiser];

    /// Its name, for people.
    pub(crate) const fn name(self) -> &'static str {
        match self {
            Self::Inlets => "inlet transmitters, first less second",
            Self::Outlets => "outlet transmitters, first less second",
            Self::InletAndRiser => "pump inlet less riser pressure",
        }
    }

    /// The two that tell of a place.
    pub(crate) const fn of(place: Place) -> Option<Self> {
        match place {
            Place::FirstInlet | Place::SecondInlet => Some(Self::Inlets),
            Place::FirstOutlet | Place::SecondOutlet => Some(Self::Outlets),
            Place::InletReading | Place::Suction | Place::RiserReading => Some(Self::InletAndRiser),
            _ => None,
        }
    }

    /// The readings of the two, if the recording has both, on the working clock, Pa.
    fn readings(self, record: &Record) -> Option<[&[f64]; 2]> {
        fn two(side: &[Vec<f64>]) -> Option<[&[f64]; 2]> {
            match side {
                [first, second] => Some([first, second]),
                _ => None,
            }
        }
        match self {
            Self::Inlets => two(&record.inlets),
            Self::Outlets => two(&record.outlets),
            Self::InletAndRiser => Some([&record.inlet, record.riser.as_deref()?]),
        }
    }

    /// First less second of two readings over some samples, but for what the suction is known to lose between them, Pa.
    fn differ(self, record: &Record, [first, second]: [&[f64]; 2], samples: Range<usize>) -> f64 {
        let lost = match self {
            Self::InletAndRiser => record.suction_pa(mean(&record.filled.flow[samples.clone()])),
            Self::Inlets | Self::Outlets => 0.0,
        };
        mean(&first[samples.clone()]) + lost - mean(&second[samples])
    }

    /// By how much the first reads more than the second throughout (median), Pa; `None` where there are not two.
    pub(crate) fn offset(self, record: &Record) -> Option<f64> {
        let readings = self.readings(record)?;
        let m = record.per_block;
        let blocks = (0..record.blocks).map(|b| self.differ(record, readings, b * m..(b + 1) * m));
        quantile(blocks.filter(|v| v.is_finite()), Rank::MEDIAN)
    }

    /// By how much the first reads more than the second where readings are off, Pa.
    fn apart(self, changes: &Changes) -> f64 {
        let [first, second] = changes.inlet_bias_pa;
        match self {
            Self::Inlets => first - second,
            Self::Outlets => changes.outlet_bias_pa[0] - changes.outlet_bias_pa[1],
            Self::InletAndRiser => 0.5 * (first + second) - changes.riser_bias_pa,
        }
    }
}

/// First less second reading, block by block, beside the noise that the two have.
pub(crate) struct Twins {
    whitening: Whitening,
    /// Less the median of what can be trusted, Pa; NaN where either is missing.
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

impl Twins {
    /// `None` where there are not two. What `state` holds either reading to be off by is taken off; `excluded` blocks carry no
    /// weight.
    pub(crate) fn of(
        record: &Record,
        pair: Pair,
        state: &[Applied],
        wander: Wander,
        excluded: &[bool],
    ) -> Option<Self> {
        let [first, second] = pair.readings(record)?;
        let (m, n) = (record.per_block, record.blocks);
        let block = |values: &[f64], b: usize| mean(&values[b * m..(b + 1) * m]);
        let t_s: Vec<f64> = (0..n)
            .map(|b| mean(&record.t_s[b * m..(b + 1) * m]))
            .collect();
        let held = held_apart(record, pair, state, &t_s);
        let apart: Vec<f64> = (0..n)
            .map(|b| pair.differ(record, [first, second], b * m..(b + 1) * m) - held[b])
            .collect();
        let [one, other] = [first, second].map(|values| repeats(record, values, |_| STUCK_S));
        let valid: Vec<bool> = (0..n)
            .map(|b| {
                let excluded = excluded.get(b).copied().unwrap_or(false);
                apart[b].is_finite() && one[b] == other[b] && !excluded
            })
            .collect();
        let told = (apart.iter().zip(&valid)).filter_map(|(v, valid)| valid.then_some(*v));
        let middle = quantile(told, Rank::MEDIAN)?;
        let residual: Vec<f64> = apart.iter().map(|v| v - middle).collect();
        let layout = Layout {
            blocks: 0,
            outlets: n,
            balance: 0,
        };
        let rows = Rows {
            friction: Vec::new(),
            still: Vec::new(),
            head: Vec::new(),
            outlets: valid,
            balance: Vec::new(),
            stops: Vec::new(),
        };
        let whitening = Whitening::of(layout, &rows, &residual, &vec![0.0; n], wander);
        let (readings, (low, high)) = match pair {
            Pair::Outlets => (&record.filled.outlet, tails(&record.filled.outlet, 50)?),
            _ => (&record.filled.inlet, record.setting.inlet_range_pa),
        };
        let span = |b: usize| SPAN_PA * (block(readings, b) - low) / (high - low).max(SPAN_PA);
        let column = |of: &dyn Fn(usize) -> f64| -> Vec<f64> { (0..n).map(of).collect() };
        let ends = |b: usize| [b.saturating_sub(1), (b + 1).min(n - 1)];
        let rate = |b: usize| {
            let [before, after] = ends(b);
            (block(readings, after) - block(readings, before)) / (t_s[after] - t_s[before])
        };
        let mut may = vec![
            column(&|_| 1e5),
            column(&span),
            column(&|b| LATE_S * rate(b)),
        ];
        if pair == Pair::InletAndRiser {
            let flow = &record.filled.flow;
            let flowing = flow.iter().copied().filter(|q| *q > 2.0 * STANDING_M3_S);
            let typical = quantile(flowing, Rank::MEDIAN).unwrap_or(1.0);
            may.push(column(&|b| SUCTION_PA * (block(flow, b) / typical).powi(2)));
        }
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

    /// First less second reading, less its median, by block, Pa.
    pub(crate) fn residual(&self) -> &[f64] {
        &self.residual
    }

    /// Middle of each block, s.
    pub(crate) fn t_s(&self) -> &[f64] {
        &self.t_s
    }

    /// Standard deviation of a block's noise, Pa.
    pub(crate) fn noise_pa(&self) -> f64 {
        self.whitening.noise(..)
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
        let factor = precision(&self.free)?;
        let across = DMatrix::from_fn(m, KNOTS, |a, k| dot(&self.free[a], &knots[k]));
        let pull = DVector::from_fn(m, |a, _| dot(&self.free[a], &self.apart));
        let gram = DMatrix::from_fn(KNOTS, KNOTS, |a, b| dot(&knots[a], &knots[b]))
            - across.transpose() * factor.solve(&across);
        let right = DVector::from_fn(KNOTS, |k, _| dot(&knots[k], &self.apart))
            - across.transpose() * factor.solve(&pull);
        Some((gram, right))
    }
}

/// Precision of coefficients of unit prior width, factorised.
fn precision(columns: &[Vec<f64>]) -> Option<Cholesky<f64, Dyn>> {
    let m = columns.len();
    let gram = DMatrix::from_fn(m, m, |a, b| dot(&columns[a], &columns[b]));
    (gram + DMatrix::identity(m, m)).cholesky()
}

/// By how much a hypothesis holds the first of two to read more than the second, at some times, Pa.
fn held_apart(record: &Record, pair: Pair, state: &[Applied], t_s: &[f64]) -> Vec<f64> {
    let of_readings = |a: &&Applied| a.is_correction() || a.effect.about().sensor().is_some();
    // They are off by the time alone: the readings of a moment do not count.
    let mut act = begun(record, state.iter().filter(of_readings));
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
                outflow_m3_s: f.flow[i],
                speed_pct: f.speed[i],
                inlet_pa: f.inlet[i],
                outlet_pa: f.outlet[i],
                pumping: f.pumping[i],
            };
            let mut changes = Changes::default();
            act(&moment, &mut changes);
            pair.apart(&changes)
        })
        .collect()
}

#[cfg(test)]
mod tests;
