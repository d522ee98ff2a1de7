//! Which rows of the relations a recording supports.

use super::Blocks;
use crate::layout::Section;
use crate::numbers::mean;
use crate::record::{BALANCE_BLOCKS, Record};
use dgd_effects::STANDING_M3_S;

/// Rise of the outlet during a stop that only a pump makes, Pa: twenty times the 0.05 bar that transmitters wander by. Set by hand.
const HIDDEN_START_PA: f64 = 1e5;

/// Which rows may be used, and how they were excited; from the bare recording.
#[derive(Debug, Clone)]
pub(crate) struct Rows {
    /// Row of the friction relation, by block.
    pub friction: Vec<bool>,
    /// Whether that row is static: no flow.
    pub still: Vec<bool>,
    pub head: Vec<bool>,
    pub outlets: Vec<bool>,
    pub balance: Vec<bool>,
}

impl Rows {
    pub(crate) fn of_section(&self, section: Section) -> &[bool] {
        match section {
            Section::Friction => &self.friction,
            Section::Head => &self.head,
            Section::Outlets => &self.outlets,
            Section::Balance => &self.balance,
        }
    }

    /// Which rows the recording supports.
    pub(crate) fn of(record: &Record, base: &Blocks) -> Self {
        let m = record.per_block;
        let full =
            |values: &[f64], b: usize| values[b * m..(b + 1) * m].iter().all(|v| v.is_finite());
        let pumping = &record.filled.pumping;
        let n = record.blocks;
        // Blocks for which the pump has turned, or stood: about a start and a stop the check valve decides.
        let mut turned = vec![0.0_f64; n];
        let mut stood = vec![0.0_f64; n];
        let (mut on, mut off) = (0.0, 0.0);
        // A set-point that is stuck at 0 hides a start; the outlet tells it by what it reads above the lowest of the stop so far, for
        // two blocks together: a reading that drops out once is no low.
        let outlet = |b: usize| mean(&record.outlet[b * m..(b + 1) * m]);
        let mut lowest = f64::INFINITY;
        for b in 0..n {
            let r = b * m..(b + 1) * m;
            let turns = pumping[r.clone()].iter().all(|p| *p)
                && record.filled.flow[r.clone()]
                    .iter()
                    .all(|q| *q > 2.0 * STANDING_M3_S);
            let shut = pumping[r.clone()].iter().all(|p| !*p)
                && record.filled.flow[r].iter().all(|q| *q < STANDING_M3_S);
            lowest = match (shut, b.checked_sub(1)) {
                (true, Some(before)) => lowest.min(outlet(before).max(outlet(b))),
                _ => f64::INFINITY,
            };
            let driven = outlet(b) > lowest + HIDDEN_START_PA;
            let standing = shut && !driven;
            on = if turns { on + 1.0 } else { 0.0 };
            off = if standing { off + 1.0 } else { 0.0 };
            turned[b] = on;
            stood[b] = off;
        }
        // Near shut-off the curve folds and the check valve flutters: no evidence there.
        let least_flow = 0.08 * base.flow.iter().copied().fold(0.0, f64::max);
        let head: Vec<bool> = (0..n)
            .map(|b| {
                turned[b] > 1.0
                    && base.flow[b] > least_flow
                    && turned.get(b + 1).is_none_or(|s| *s > 0.0)
                    && full(&record.flow, b)
                    && full(&record.speed, b)
                    && base.lift[b].is_finite()
                    && base.drop[b].is_finite()
            })
            .collect();
        let still: Vec<bool> = (0..n)
            .map(|b| {
                stood[b] > 2.0
                    && stood.get(b + 1).is_none_or(|s| *s > 0.0)
                    && base.drop[b].is_finite()
            })
            .collect();
        let friction: Vec<bool> = (0..n)
            .map(|b| {
                still[b]
                    || (turned[b] > 1.0
                        && turned.get(b + 1).is_none_or(|s| *s > 0.0)
                        && full(&record.flow, b)
                        && base.drop[b].is_finite())
            })
            .collect();
        // A transmitter that repeats one value through its noise is stuck, whatever the screening made of it.
        let limit_s = |b: usize| match turned.get(b) {
            Some(blocks) if *blocks > 0.0 => 24.0,
            _ => 60.0,
        };
        let mut frozen = vec![false; n];
        for outlet in &record.outlets {
            for (frozen, repeats) in frozen.iter_mut().zip(repeats(record, outlet, limit_s)) {
                *frozen |= repeats;
            }
        }
        let friction: Vec<bool> = friction
            .iter()
            .zip(&frozen)
            .map(|(v, f)| *v && !f)
            .collect();
        let head: Vec<bool> = head.iter().zip(&frozen).map(|(v, f)| *v && !f).collect();
        let outlets = base
            .difference
            .iter()
            .zip(&frozen)
            .map(|(d, f)| d.is_finite() && !f)
            .collect();
        let balance = (0..n / BALANCE_BLOCKS)
            .map(|k| {
                let inputs = (k * BALANCE_BLOCKS..(k + 1) * BALANCE_BLOCKS).all(|b| {
                    full(&record.mud_pump, b)
                        && full(&record.booster, b)
                        && (turned[b] > 1.0 || stood[b] > 0.0)
                });
                inputs && base.imbalance[k].is_finite()
            })
            .collect();
        Self {
            friction,
            still,
            head,
            outlets,
            balance,
        }
    }
}

/// The blocks, and one or two behind them, in which a reading repeats one value for as long as a limit by block, s.
pub(crate) fn repeats(
    record: &Record,
    values: &[f64],
    limit_s: impl Fn(usize) -> f64,
) -> Vec<bool> {
    let (m, n) = (record.per_block, record.blocks);
    let mut out = vec![false; n];
    // Samples that repeat the one before, and the first block that they have not marked yet.
    let (mut run, mut unmarked) = (0_usize, 0);
    for i in 1..values.len() {
        if values[i] == values[i - 1] {
            run += 1;
        } else {
            (run, unmarked) = (0, 0);
        }
        if run as f64 * record.dt_s >= limit_s(i / m) {
            let last = (i / m + 2).min(n - 1);
            let from = unmarked.max((i - run) / m);
            out[from.min(last)..=last].fill(true);
            unmarked = last;
        }
    }
    out
}

#[cfg(test)]
mod tests;
