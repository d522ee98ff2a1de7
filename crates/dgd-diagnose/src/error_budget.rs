//! What stands between a sound model and a sound recording besides white noise: wander, timing, starts.

use crate::layout::{BALANCE_BLOCKS, Layout, Section};
use crate::noise::Wander;
use crate::numbers::{finite_or_0, mean};
use crate::record::Record;
use crate::relations::Blocks;
use dgd_effects::{Curves, STANDING_M3_S};
use dgd_recording::{Rank, quantile};

/// Wander of a pressure transmitter that is still within its accuracy, Pa (one standard deviation).
const PRESSURE_WANDER_PA: f64 = 2.5e3;
/// The same of a flow meter, relative.
const FLOW_WANDER: f64 = 0.0025;
/// The same of the pump's speed, relative: it is a set-point, whose drive hardly slips.
const SPEED_WANDER: f64 = 0.0005;
/// Correlation time of a wander, s: hours, and shorter than most recordings.
pub(crate) const WANDER_S: f64 = 8000.0;
/// What the model lacks right after a start of the pump, Pa.
const START_PA: f64 = 2.5e4;
/// How long movements of the flow last that its meter's noise hides, s.
const HIDDEN_S: f64 = 300.0;
/// Share of the meter's block noise up to which true movements of the flow hide in it. Set by hand.
const HIDDEN_SHARE: f64 = 0.57;

/// How far the sections wander while every instrument keeps its accuracy.
pub(crate) fn wander(record: &Record, curves: &Curves) -> Wander {
    // Of a pump that stands for most of a recording, the hours in which it turns tell.
    let turning = |values: &[f64]| -> Vec<f64> {
        let all = values.iter().zip(&record.filled.pumping);
        all.filter_map(|(v, turns)| turns.then_some(*v)).collect()
    };
    let middle = |values: &[f64]| -> f64 { quantile(turning(values), Rank::MEDIAN).unwrap_or(0.0) };
    let (q, w, pump) = (
        middle(&record.flow),
        middle(&record.speed),
        middle(&record.mud_pump),
    );
    let slope = |f: &dyn Fn(f64) -> f64| (f(1.01 * q) - f(0.99 * q)) / 0.02;
    let friction = FLOW_WANDER * slope(&|q| curves.friction_pa(q));
    let head = (FLOW_WANDER * slope(&|q| curves.head_pa(w, q)))
        .hypot(2.0 * SPEED_WANDER * curves.head_pa(w, q));
    // Movements of the flow below its meter's noise last minutes and come through the slope of the curves.
    let hidden = HIDDEN_SHARE * record.setting.noise.flow_m3_s
        / (record.per_block as f64).sqrt()
        / q.max(1e-3);
    Wander {
        friction_pa: PRESSURE_WANDER_PA.hypot(friction),
        head_pa: PRESSURE_WANDER_PA.hypot(head),
        outlets_pa: 1.5 * PRESSURE_WANDER_PA,
        balance_m3_s: FLOW_WANDER * q.hypot(pump),
        blocks: WANDER_S / record.block_s(),
        hidden_friction_pa: hidden * slope(&|q| curves.friction_pa(q)).abs(),
        hidden_head_pa: hidden * slope(&|q| curves.head_pa(w, q)).abs(),
        hidden_blocks: HIDDEN_S / record.block_s(),
    }
}

/// By how much instruments and drives may answer sooner or later than the model thinks, s.
const TIMING_S: f64 = 0.5;
/// Blocks that the noise's memory reaches beyond its cause.
const RING: usize = 2;

/// Blocks in which the head moves so fast that the timing is worth more than the transmitters' accuracy, and their neighbours.
///
/// `seconds` is the length of a block; one whose head is not known does not move.
pub(crate) fn moving(head_pa: &[f64], seconds: f64) -> Vec<bool> {
    let n = head_pa.len();
    let fast = |k: usize| {
        let (a, z) = (k.saturating_sub(1), (k + 1).min(n - 1));
        let rate = (head_pa[z] - head_pa[a]) / ((z - a).max(1) as f64 * seconds);
        TIMING_S * rate.abs() > PRESSURE_WANDER_PA
    };
    let fast: Vec<bool> = (0..n).map(fast).collect();
    (0..n)
        .map(|k| fast[k.saturating_sub(RING)..(k + RING + 1).min(n)].contains(&true))
        .collect()
}

/// What a flow meter that answers a second late changes in the rows of the head, and what a drive that does: straight parameters
/// of a model that asks for more than timing. Friction has none: there it would pass for a hysteresis.
pub(crate) fn late(seconds: f64, curves: &Curves, b: &Blocks, layout: Layout) -> [Vec<f64>; 2] {
    let n = layout.blocks;
    let mut out = [vec![0.0; layout.len()], vec![0.0; layout.len()]];
    for k in 1..n.saturating_sub(1) {
        let (w, q) = (b.speed[k], b.flow[k]);
        // Half the way to either neighbour: what the head changes by within a block.
        let dq = 0.25 * (b.flow[k + 1] - b.flow[k - 1]);
        let dw = 0.25 * (b.speed[k + 1] - b.speed[k - 1]);
        let changes = [
            curves.head_pa(w, q + dq) - curves.head_pa(w, q - dq),
            curves.head_pa(w + dw, q) - curves.head_pa(w - dw, q),
        ];
        for (column, change) in out.iter_mut().zip(changes) {
            if change.is_finite() {
                column[n + k] = change / seconds;
            }
        }
    }
    out
}

/// What a mud pump that is told a second early changes in the rows of the balance, and what a meter of the line is that answers a second late.
///
/// Both hold for every change of a flow alike: a gain is told from another by how much goes in and out while the level moves, to which
/// part of a second at every step adds, or from which it takes.
pub(crate) fn late_flows(record: &Record, layout: Layout) -> [Vec<f64>; 2] {
    let row_s = record.row_s();
    let per_row = record.per_block * BALANCE_BLOCKS;
    let rows = layout.rows(Section::Balance);
    let filled = &record.filled;
    [&filled.mud_pump, &filled.flow].map(|flow| {
        let at_edge = |k: usize| mean(&flow[record.about_edge(k * per_row)]);
        let mut column = vec![0.0; layout.len()];
        let mut begin = at_edge(0);
        for (k, row) in column[rows.clone()].iter_mut().enumerate() {
            let end = at_edge(k + 1);
            *row = finite_or_0((end - begin) / row_s);
            begin = end;
        }
        column
    })
}

/// Standard deviation that each row has beyond white noise, in its unit: of timing, of starts, of the noise of flow and speed through the
/// curves, and of an inlet pressure that is read coarsely.
pub(crate) fn unrest(record: &Record, curves: &Curves, b: &Blocks, layout: Layout) -> Vec<f64> {
    let mut unrest = Unrest {
        record,
        curves,
        b,
        layout,
        sd: vec![0.0; layout.len()],
    };
    unrest.add_timing();
    unrest.add_starts();
    unrest.add_meter_noise();
    unrest.add_timing_of_balance();
    unrest.add_rounding_of_balance();
    unrest.sd
}

/// What that is made of, a part at a time; rows of friction and head stand at `k` and `blocks + k` of block `k`.
struct Unrest<'a> {
    record: &'a Record,
    curves: &'a Curves,
    b: &'a Blocks,
    layout: Layout,
    sd: Vec<f64>,
}

impl Unrest<'_> {
    /// What friction and head change by within [`TIMING_S`], and the inertia of a flow that bends.
    fn add_timing(&mut self) {
        /// Share of the inertia by means of blocks that a bend may miss. Set by hand.
        const BEND: f64 = 0.3;
        let Self { curves, b, .. } = *self;
        let (n, seconds) = (self.layout.blocks, self.record.block_s());
        let inertia = self.record.inertia();
        let rate = |f: &dyn Fn(usize) -> f64, k: usize| -> f64 {
            let (a, z) = (k.saturating_sub(1), (k + 1).min(n - 1));
            let change = (f(z) - f(a)) / ((z - a).max(1) as f64 * seconds);
            finite_or_0(TIMING_S * change.abs())
        };
        for k in 0..n {
            let bend = match (k.checked_sub(1), b.flow.get(k + 1)) {
                (Some(a), Some(z)) => {
                    (z - 2.0 * b.flow[k] + b.flow[a]).abs() / seconds * inertia * BEND
                }
                _ => 0.0,
            };
            self.sd[k] = rate(&|i| curves.friction_pa(b.flow[i]), k) + finite_or_0(bend);
            self.sd[n + k] = rate(&|i| curves.head_pa(b.speed[i], b.through[i]), k);
        }
    }

    /// In the first minute after a start the line fills and the check valve opens: the model does not hold there.
    fn add_starts(&mut self) {
        /// How fast that is over, s. Set by hand.
        const OVER_S: f64 = 25.0;
        let (n, seconds) = (self.layout.blocks, self.record.block_s());
        let filled = &self.record.filled;
        let mut running = f64::INFINITY;
        for k in 0..n {
            let samples = k * self.record.per_block..(k + 1) * self.record.per_block;
            let turning = filled.pumping[samples.clone()].iter().all(|p| *p)
                && filled.flow[samples].iter().all(|q| *q > STANDING_M3_S);
            running = if turning { running + seconds } else { 0.0 };
            let start = START_PA * (-running / OVER_S).exp();
            for row in [k, n + k] {
                self.sd[row] = self.sd[row].hypot(start);
            }
        }
    }

    /// The meter's noise, where calm surroundings do not average it out, comes through the slope of the curves; so does what the speed may be off
    /// by. Without it the head's slope would be lost to errors in variables.
    fn add_meter_noise(&mut self) {
        /// Flow below which noise is no share of it, m³/s.
        const LEAST_M3_S: f64 = 1e-3;
        /// Slopes are taken over 1 % to either side.
        const SIDES: (f64, f64) = (0.99, 1.01);
        let Self { curves, b, .. } = *self;
        let n = self.layout.blocks;
        let noise = self.record.setting.noise.flow_m3_s / (self.record.per_block as f64).sqrt();
        for k in 0..n {
            let (q, w) = (b.flow[k], b.speed[k]);
            let left = noise / b.averaged[k].sqrt() / q.max(LEAST_M3_S) / 0.02;
            let through = |f: &dyn Fn(f64) -> f64| (f(SIDES.1 * q) - f(SIDES.0 * q)).abs() * left;
            let by_speed = (curves.head_pa(SIDES.1 * w, q) - curves.head_pa(SIDES.0 * w, q)).abs()
                / (0.02 * w);
            self.sd[k] = self.sd[k].hypot(through(&|q| curves.friction_pa(q)));
            self.sd[n + k] = (self.sd[n + k].hypot(through(&|q| curves.head_pa(w, q))))
                .hypot(self.record.speed_error_pct * by_speed);
            for row in [k, n + k] {
                self.sd[row] = finite_or_0(self.sd[row]);
            }
        }
    }

    /// What pumps and line move within [`TIMING_S`], over a row of the balance.
    fn add_timing_of_balance(&mut self) {
        /// Noise adds up in a sum of absolute steps: only what exceeds it moves, m³/s. Set by hand.
        const QUIET_M3_S: f64 = 3.0e-4;
        let Self { b, .. } = *self;
        let (n, m) = (self.layout.blocks, self.record.per_block);
        let filled = &self.record.filled;
        let last = self.record.t_s.len() - 1;
        let first = self.layout.rows(Section::Balance).start;
        let over_s = self.record.row_s();
        for k in 0..self.layout.balance {
            let samples = k * m * BALANCE_BLOCKS..(k + 1) * m * BALANCE_BLOCKS;
            let pumped = |flow: &[f64]| -> f64 {
                let steps = (samples.clone())
                    .map(|i| finite_or_0((flow[(i + 1).min(last)] - flow[i.min(last)]).abs()));
                (steps.sum::<f64>() - QUIET_M3_S).max(0.0)
            };
            let line: f64 = (k * BALANCE_BLOCKS..(k + 1) * BALANCE_BLOCKS)
                .map(|i| finite_or_0((b.flow[(i + 1).min(n - 1)] - b.flow[i]).abs()))
                .sum();
            let moved = pumped(&filled.mud_pump) + pumped(&filled.booster) + line;
            self.sd[first + k] = TIMING_S * moved / over_s;
        }
    }

    /// What a row of the balance is off by as the inlet pressure is rounded.
    fn add_rounding_of_balance(&mut self) {
        for row in self.layout.rows(Section::Balance) {
            self.sd[row] = self.sd[row].hypot(self.record.coarse_m3_s);
        }
    }
}

#[cfg(test)]
mod tests;
