//! From samples to means of blocks, a row of the mass balance at a time.

use super::{LevelRate, LineFlow};
use crate::layout::BALANCE_BLOCKS;
use crate::numbers::{mean, mean_of};
use crate::record::Record;
use dgd_effects::{Changes, leaking_m3_s};
use dgd_units::STANDARD_GRAVITY_M_S2;

/// Block means before flows and speed are calmed and the line's inertia is taken out of its drop.
#[derive(Debug, Clone)]
pub(crate) struct Parts {
    pub(super) flow: Vec<f64>,
    pub(super) through: Vec<f64>,
    pub(super) speed: Vec<f64>,
    pub(super) drop: Vec<f64>,
    pub(super) friction_factor: Vec<f64>,
    pub(super) lift: Vec<f64>,
    pub(super) head_factor: Vec<f64>,
    pub(super) difference: Vec<f64>,
    /// One a [`BALANCE_BLOCKS`] blocks.
    pub(super) imbalance: Vec<f64>,
}

impl Parts {
    /// Those of a recording before anything is laid: not a number.
    pub(crate) fn blank(record: &Record) -> Self {
        let blocks = record.t_s.len() / record.per_block;
        let empty = || vec![f64::NAN; blocks];
        Self {
            flow: empty(),
            through: empty(),
            speed: empty(),
            drop: empty(),
            friction_factor: empty(),
            lift: empty(),
            head_factor: empty(),
            difference: if record.outlets.len() == 2 {
                empty()
            } else {
                Vec::new()
            },
            imbalance: vec![f64::NAN; blocks / BALANCE_BLOCKS],
        }
    }
}

/// Parts that are other than what is known of them.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) struct Touched(u16);

impl Touched {
    const FLOW: u16 = 1;
    const THROUGH: u16 = 1 << 1;
    const SPEED: u16 = 1 << 2;
    const DROP: u16 = 1 << 3;
    const FRICTION_FACTOR: u16 = 1 << 4;
    const LIFT: u16 = 1 << 5;
    const HEAD_FACTOR: u16 = 1 << 6;
    const DIFFERENCE: u16 = 1 << 7;
    const IMBALANCE: u16 = 1 << 8;

    /// What the flow of the line enters.
    pub(crate) const METERED: Self = Self(Self::FLOW | Self::THROUGH | Self::IMBALANCE);

    /// Nothing is known yet.
    pub(crate) const ALL: Self = Self((1 << 9) - 1);

    /// What changes from one set of changes to the other, digit for digit.
    pub(crate) fn between(a: &Changes, b: &Changes) -> Self {
        // Every member by its name, so that a new one is not passed over.
        let Changes {
            inflow_m3_s,
            area_factor,
            entering_kg_m3,
            riser_kg_m3,
            line_kg_m3,
            line_drop_pa,
            friction_factor,
            line_fall_m,
            head_factor,
            head_pa,
            speed_pct,
            recirculation_m3_s,
            leak_m3_s,
            meter_gain,
            outlet_bias_pa: [outlet, other_outlet],
            inlet_bias_pa: [inlet, other_inlet],
            // No relation holds the riser's reading.
            riser_bias_pa: _,
        } = *a;
        // Bits that differ, of all that touch the same parts at once: it is asked of every sample.
        let bits = |a: f64, b: f64| a.to_bits() ^ b.to_bits();
        let of = |differs: u64, parts: u16| u16::from(differs != 0) * parts;
        let balance = bits(inflow_m3_s, b.inflow_m3_s)
            | bits(area_factor, b.area_factor)
            | bits(entering_kg_m3, b.entering_kg_m3);
        let riser = bits(riser_kg_m3, b.riser_kg_m3);
        let line = bits(line_kg_m3, b.line_kg_m3);
        let drop = bits(line_drop_pa, b.line_drop_pa) | bits(line_fall_m, b.line_fall_m);
        let friction = bits(friction_factor, b.friction_factor);
        let head = bits(head_factor, b.head_factor);
        let lift = bits(head_pa, b.head_pa);
        let speed = bits(speed_pct, b.speed_pct);
        let through = bits(recirculation_m3_s, b.recirculation_m3_s);
        let meter = bits(leak_m3_s, b.leak_m3_s) | bits(meter_gain, b.meter_gain);
        let outlet = bits(outlet, b.outlet_bias_pa[0]) | bits(other_outlet, b.outlet_bias_pa[1]);
        let inlet = bits(inlet, b.inlet_bias_pa[0]) | bits(other_inlet, b.inlet_bias_pa[1]);
        Self(
            of(balance, Self::IMBALANCE)
                | of(riser, Self::HEAD_FACTOR | Self::IMBALANCE)
                | of(line, Self::DROP | Self::FRICTION_FACTOR)
                | of(drop, Self::DROP)
                | of(friction, Self::FRICTION_FACTOR)
                | of(head, Self::HEAD_FACTOR)
                | of(lift, Self::LIFT)
                | of(speed, Self::SPEED)
                | of(through, Self::THROUGH)
                | of(meter, Self::METERED.0)
                | of(outlet, Self::DROP | Self::LIFT | Self::DIFFERENCE)
                | of(inlet, Self::LIFT | Self::IMBALANCE),
        )
    }

    /// Whether the flow through the line is among them: what is done between line and meter, and by nothing else.
    pub(crate) fn meter(self) -> bool {
        self.has(Self::FLOW)
    }

    /// The parts of both.
    pub(crate) fn or(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    fn has(self, part: u16) -> bool {
        self.0 & part != 0
    }
}

/// A row of the mass balance, and the blocks that it spans.
pub(super) struct Row<'a> {
    record: &'a Record,
    /// Flow of the line, with its gaps.
    flow: &'a [f64],
    rates: &'a LevelRate,
    /// What effects change, sample by sample.
    pub(super) changes: Vec<Changes>,
}

impl<'a> Row<'a> {
    pub(super) fn of(record: &'a Record, line: &'a LineFlow, rates: &'a LevelRate) -> Self {
        Self {
            record,
            flow: line.of(record).0,
            rates,
            changes: Vec::new(),
        }
    }

    /// Lays the means of its whole blocks into `parts`, of what is touched; `first` is the number of its first sample.
    pub(super) fn lay_into(&self, parts: &mut Parts, first: usize, touched: Touched) {
        let record = self.record;
        let (m, rho, g) = (
            record.per_block,
            record.setting.density_kg_m3,
            STANDARD_GRAVITY_M_S2,
        );
        let (column, length) = (record.column_pa(), record.setting.line_length_m);
        let outlet =
            |i: usize, c: &Changes| record.outlet[i] - c.read_outlet_bias_pa(record.outlets.len());
        let lay = Means {
            row: self,
            first,
            touched,
        };
        lay.part(Touched::FLOW, &mut parts.flow, |i, c| self.through(i, c));
        lay.part(Touched::THROUGH, &mut parts.through, |i, c| {
            self.through(i, c) + c.recirculation_m3_s
        });
        lay.part(Touched::SPEED, &mut parts.speed, |i, c| {
            record.speed[i] + c.speed_pct
        });
        lay.part(Touched::DROP, &mut parts.drop, |i, c| {
            outlet(i, c) - column - c.line_kg_m3 * g * length + rho * g * c.line_fall_m
                - c.line_drop_pa
        });
        lay.part(
            Touched::FRICTION_FACTOR,
            &mut parts.friction_factor,
            |_, c| c.friction_factor * (1.0 + c.line_kg_m3 / rho),
        );
        lay.part(Touched::LIFT, &mut parts.lift, |i, c| {
            outlet(i, c) - record.inlet[i] + c.read_inlet_bias_pa() - c.head_pa
        });
        lay.part(Touched::HEAD_FACTOR, &mut parts.head_factor, |_, c| {
            c.head_factor * (1.0 + c.riser_kg_m3 / rho)
        });
        if let ([one, two], true) = (record.outlets.as_slice(), touched.has(Touched::DIFFERENCE)) {
            for b in first / m..(first + self.changes.len()) / m {
                let there = b * m..(b + 1) * m;
                let bias = (self.changes[b * m - first..][..m].iter())
                    .map(|c| c.outlet_bias_pa[0] - c.outlet_bias_pa[1]);
                parts.difference[b] = mean(&one[there.clone()]) - mean(&two[there]) - mean_of(bias);
            }
        }
        if touched.has(Touched::IMBALANCE) && self.changes.len() == m * BALANCE_BLOCKS {
            parts.imbalance[first / self.changes.len()] = self.imbalance(first);
        }
    }

    /// Flow through the line at a sample, m³/s.
    fn through(&self, i: usize, c: &Changes) -> f64 {
        // Hardly any effect changes the gain, and to divide is dear.
        let read = self.flow[i];
        let outflow = if c.meter_gain == 1.0 {
            read
        } else {
            read / c.meter_gain
        };
        outflow + leaking_m3_s(c.leak_m3_s, outflow)
    }

    /// What flows in less what flows out and what the riser stores, m³/s: Eq. 3.45 over the row.
    fn imbalance(&self, first: usize) -> f64 {
        let record = self.record;
        let setting = &record.setting;
        let (rho, filled) = (setting.density_kg_m3, &record.filled);
        let per_area = record.riser_m3_per_pa();
        let (mut net, mut counted) = (0.0, 0);
        for (i, c) in (first..).zip(&self.changes) {
            let through = self.through(i, c);
            let inflow = filled.mud_pump[i] + filled.booster[i] + filled.topfill[i];
            let kept = inflow * (1.0 + c.entering_kg_m3 / rho) + c.inflow_m3_s
                - through * (1.0 + c.riser_kg_m3 / rho);
            if kept.is_finite() {
                net += kept;
                counted += 1;
            }
        }
        let samples = self.changes.len();
        let bad = samples - counted;
        let (Some(begin), Some(end)) = (self.changes.first(), self.changes.last()) else {
            return f64::NAN;
        };
        if bad * 10 > samples {
            return f64::NAN;
        }
        let row = first / samples;
        let drift = (end.read_inlet_bias_pa() - begin.read_inlet_bias_pa())
            / (record.dt_s * (samples - 1) as f64);
        // Exactly 0 for the area that the well has: then the last term is none, to the bit.
        let excess = mean_of(self.changes.iter().map(|c| c.area_factor - 1.0));
        net / counted as f64
            - per_area * (self.rates.read(row) - drift)
            - per_area * excess * self.rates.told(row, drift)
    }
}

/// Lays means of blocks into the parts of a row that are touched.
struct Means<'a> {
    row: &'a Row<'a>,
    first: usize,
    touched: Touched,
}

impl Means<'_> {
    fn part(&self, part: u16, into: &mut [f64], value: impl Fn(usize, &Changes) -> f64) {
        if !self.touched.has(part) {
            return;
        }
        let m = self.row.record.per_block;
        let samples = self.row.changes.chunks_exact(m);
        for ((b, changes), block) in samples.enumerate().zip(&mut into[self.first / m..]) {
            let here = self.first + b * m;
            *block = trimmed((here..).zip(changes).map(|(i, c)| value(i, c)));
        }
    }
}

/// Mean of a block without its greatest and least value, so that a spike costs nothing.
fn trimmed(values: impl Iterator<Item = f64>) -> f64 {
    let (mut sum, mut count, mut low, mut high) = (0.0, 0.0, f64::INFINITY, f64::NEG_INFINITY);
    for v in values {
        // A plain comparison: `f64::min` also asks for what is not a number, which costs as much as all the rest.
        if v.is_finite() {
            sum += v;
            count += 1.0;
            low = if v < low { v } else { low };
            high = if v > high { v } else { high };
        }
    }
    if count >= 4.0 {
        (sum - low - high) / (count - 2.0)
    } else {
        sum / count
    }
}

#[cfg(test)]
mod tests {
    use super::trimmed;

    #[test]
    fn a_spike_in_a_block_costs_nothing() {
        assert_eq!(trimmed([1.0, 1.0, 1e9, 1.0, 1.0].into_iter()), 1.0);
        assert_eq!(trimmed([1.0, f64::NAN, 3.0].into_iter()), 2.0);
        assert!(trimmed([f64::NAN].into_iter()).is_nan());
    }
}
