//! Which rows of the relations a recording supports.

use super::Blocks;
use crate::layout::{BALANCE_BLOCKS, Section};
use crate::numbers::{mean, mean_of, whole};
use crate::record::Record;
use dgd_effects::STANDING_M3_S;

/// A top-fill is started and stopped by hand, now and then: so near to a reading it is what that says, s. Set by hand.
const TOPPED_S: f64 = 60.0;

/// Rise of the outlet during a stop that only a pump makes, Pa: twenty times the 0.05 bar that transmitters wander by. Set by hand.
const HIDDEN_START_PA: f64 = 1e5;
/// Share of the rise until a flow is told, and rise, Pa, from which on the pump had started before: a shallow pump lifts the outlet by less than
/// [`HIDDEN_START_PA`]. Set by hand.
const STARTED_SHARE: f64 = 0.25;
const STARTED_PA: f64 = 2e4;
/// Share of the greatest flow below which the head tells nothing: near shut-off the curve folds and the check valve flutters. Set by hand.
const LEAST_FLOW: f64 = 0.08;
/// How many times [`STANDING_M3_S`] a flow must be at the least while the pump turns. Set by hand.
const FLOWS: f64 = 2.0;
/// Share of the usual drop of flowing mud within which the line stands while the pump turns: a meter that reads nothing may have failed, the
/// outlet then says so. Set by hand.
const RESTS_SHARE: f64 = 0.25;
/// How long an outlet transmitter repeats one value, s, before it is taken to be stuck: while the pump turns, and otherwise. Set by hand.
const STUCK_TURNING_S: f64 = 24.0;
const STUCK_S: f64 = 60.0;

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
    /// Stops of the pump that tell the path of the meter, by stop.
    pub stops: Vec<bool>,
}

/// Whether a channel has all its samples in a block.
pub(crate) fn is_full(record: &Record, values: &[f64], b: usize) -> bool {
    let m = record.per_block;
    values[b * m..(b + 1) * m].iter().all(|v| v.is_finite())
}

/// Whether a block is near enough to a reading of the top-fill.
pub(crate) fn is_topped(record: &Record, b: usize) -> bool {
    let m = record.per_block;
    let reach = whole(TOPPED_S / record.dt_s);
    let last = ((b + 1) * m + reach).min(record.topfill.len());
    let about = &record.topfill[(b * m).saturating_sub(reach)..last];
    about.iter().any(|v| v.is_finite())
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
        let full = |values: &[f64], b: usize| is_full(record, values, b);
        let n = record.blocks;
        let pump = PumpRuns::of(record);
        let frozen = frozen(record, &pump);
        let mut rows = Self {
            friction: vec![false; n],
            still: vec![false; n],
            head: vec![false; n],
            outlets: (base.difference.iter().zip(&frozen))
                .map(|(difference, frozen)| difference.is_finite() && !frozen)
                .collect(),
            balance: vec![false; n / BALANCE_BLOCKS],
            stops: vec![true; record.stops.len()],
        };
        let usual_drop = mean_of(
            (0..n)
                .filter(|b| pump.turned[*b] > 0)
                .map(|b| base.drop[b])
                .filter(|drop| drop.is_finite()),
        );
        let dead_headed =
            |b: usize| pump.dead_headed[b] > 2 && base.drop[b].abs() < RESTS_SHARE * usual_drop;
        let least_flow = LEAST_FLOW * base.flow.iter().copied().fold(0.0, f64::max);
        for b in 0..n {
            let flowing = pump.turns_about(b) && full(&record.flow, b) && base.drop[b].is_finite();
            rows.still[b] = pump.stands_about(b) && base.drop[b].is_finite();
            rows.friction[b] = (rows.still[b] || flowing) && !frozen[b];
            rows.head[b] = flowing
                && base.flow[b] > least_flow
                && full(&record.speed, b)
                && base.lift[b].is_finite()
                && !frozen[b];
        }
        for (k, row) in rows.balance.iter_mut().enumerate() {
            let told = |b| {
                full(&record.mud_pump, b)
                    && full(&record.booster, b)
                    && is_topped(record, b)
                    && (pump.turned[b] > 1 || pump.stood[b] > 0 || dead_headed(b))
            };
            *row = (k * BALANCE_BLOCKS..(k + 1) * BALANCE_BLOCKS).all(told)
                && base.imbalance[k].is_finite();
        }
        rows
    }
}

/// For how many blocks the pump has turned or stood by each block, that one included; 0 in a block in which it does not throughout.
struct PumpRuns {
    turned: Vec<usize>,
    stood: Vec<usize>,
    /// Turned without lifting the check valve, or hardly.
    dead_headed: Vec<usize>,
}

impl PumpRuns {
    fn of(record: &Record) -> Self {
        let m = record.per_block;
        let mut runs = Self {
            turned: Vec::with_capacity(record.blocks),
            stood: Vec::with_capacity(record.blocks),
            dead_headed: Vec::with_capacity(record.blocks),
        };
        let outlet = |b: usize| mean(&record.outlet[b * m..(b + 1) * m]);
        // A set-point that is stuck at 0 hides a start; the outlet tells it by what it reads above the lowest of the stop so far, for
        // two blocks together: a reading that drops out once is no low.
        let mut lowest = f64::INFINITY;
        let (mut turned, mut stood, mut dead_headed) = (0, 0, 0);
        for b in 0..record.blocks {
            let pumping = &record.filled.pumping[b * m..(b + 1) * m];
            let flow = &record.filled.flow[b * m..(b + 1) * m];
            let driven_throughout = pumping.iter().all(|p| *p);
            let turns = driven_throughout && flow.iter().all(|q| *q > FLOWS * STANDING_M3_S);
            let shut = pumping.iter().all(|p| !*p) && flow.iter().all(|q| *q < STANDING_M3_S);
            let risen = outlet(b) - lowest;
            if !shut && risen > STARTED_PA {
                // Speed and flow may both be told late: a block in which the outlet has risen already is none of the stop.
                let from = lowest + (STARTED_SHARE * risen).max(STARTED_PA);
                let before = runs.stood.iter_mut().enumerate().rev();
                for (_, stood) in before.take_while(|(k, _)| outlet(*k) > from) {
                    *stood = 0;
                }
            }
            lowest = match (shut, b.checked_sub(1)) {
                (true, Some(before)) => lowest.min(outlet(before).max(outlet(b))),
                _ => f64::INFINITY,
            };
            let driven = outlet(b) > lowest + HIDDEN_START_PA;
            turned = if turns { turned + 1 } else { 0 };
            stood = if shut && !driven { stood + 1 } else { 0 };
            dead_headed = if driven_throughout && !turns {
                dead_headed + 1
            } else {
                0
            };
            runs.dead_headed.push(dead_headed);
            runs.turned.push(turned);
            runs.stood.push(stood);
        }
        runs
    }

    /// Whether the pump turns in a block and in those beside it: about a start and a stop the check valve decides.
    fn turns_about(&self, b: usize) -> bool {
        self.turned[b] > 1 && self.turned.get(b + 1).is_none_or(|blocks| *blocks > 0)
    }

    /// Whether it stands in a block, the two before and the one behind it.
    fn stands_about(&self, b: usize) -> bool {
        self.stood[b] > 2 && self.stood.get(b + 1).is_none_or(|blocks| *blocks > 0)
    }
}

/// Blocks in which an outlet transmitter repeats one value through its noise: it is stuck, whatever the screening made of it.
fn frozen(record: &Record, pump: &PumpRuns) -> Vec<bool> {
    let limit_s = |b: usize| match pump.turned.get(b) {
        Some(blocks) if *blocks > 0 => STUCK_TURNING_S,
        _ => STUCK_S,
    };
    let mut out = vec![false; record.blocks];
    for outlet in &record.outlets {
        for (frozen, repeats) in out.iter_mut().zip(repeats(record, outlet, limit_s)) {
            *frozen |= repeats;
        }
    }
    out
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
