//! Means of blocks: calmed flows and speed, and drops without the line's inertia.

use super::{Applied, LevelRate, LineFlow, Metered, Parts, Touched, begun, run};
use crate::record::Record;

/// Block means under a hypothesis, before any curve.
#[derive(Debug, Clone)]
pub(crate) struct Blocks {
    /// Flow through the line, m³/s.
    pub flow: Vec<f64>,
    /// Blocks averaged in each value of the flow.
    pub averaged: Vec<f64>,
    /// Flow through the pump's impeller, m³/s.
    pub through: Vec<f64>,
    /// True speed, %.
    pub speed: Vec<f64>,
    /// Outlet pressure less column, inertia and further drops, Pa.
    pub drop: Vec<f64>,
    /// Factor on the friction curve.
    pub friction_factor: Vec<f64>,
    /// Outlet less inlet pressure, Pa.
    pub lift: Vec<f64>,
    /// Factor on the head curve.
    pub head_factor: Vec<f64>,
    /// First less second outlet transmitter, Pa.
    pub difference: Vec<f64>,
    /// Imbalance of the riser, m³/s, one a [`BALANCE_BLOCKS`] blocks.
    pub imbalance: Vec<f64>,
}

impl Blocks {
    /// Runs a hypothesis over the recording.
    pub(crate) fn under(record: &Record, applied: &[Applied]) -> Self {
        let line = LineFlow::under(record, applied);
        let rates = LevelRate::of(record);
        let mut act = begun(record, applied);
        let mut parts = Parts::blank(record);
        run(
            record,
            (&line, &rates),
            0..record.t_s.len(),
            Metered::default(),
            &mut parts,
            |moment, c| {
                act(moment, c);
                Touched::ALL
            },
        );
        Self::of(record, parts, None)
    }

    /// Calms what is averaged, and takes the line's inertia out of its drop. What `known` parts have alike, digit for
    /// digit, is not calmed again.
    pub(crate) fn of(record: &Record, parts: Parts, known: Option<(&Parts, &Self)>) -> Self {
        let same = |a: &[f64], b: &[f64]| a.iter().zip(b).all(|(a, b)| a.to_bits() == b.to_bits());
        let (flow, averaged) = match known {
            Some((before, blocks)) if same(&before.flow, &parts.flow) => {
                (blocks.flow.clone(), blocks.averaged.clone())
            }
            _ => calmed(&parts.flow, 0.0),
        };
        let through = match known {
            Some((before, blocks)) if same(&before.through, &parts.through) => {
                blocks.through.clone()
            }
            _ => calmed(&parts.through, 0.0).0,
        };
        let speed = match known {
            Some((before, blocks)) if same(&before.speed, &parts.speed) => blocks.speed.clone(),
            _ => calmed(&parts.speed, 0.0).0,
        };
        let inertia = record.inertia();
        let seconds = record.dt_s * record.per_block as f64;
        let mut drop = parts.drop;
        for b in 0..drop.len() {
            // Rate across the block from its neighbours; one-sided where one is missing.
            let before = b.checked_sub(1).map_or(f64::NAN, |k| flow[k]);
            let after = flow.get(b + 1).copied().unwrap_or(f64::NAN);
            let rate = match (before.is_finite(), after.is_finite()) {
                (true, true) => (after - before) / (2.0 * seconds),
                (true, false) => (flow[b] - before) / seconds,
                (false, true) => (after - flow[b]) / seconds,
                _ => 0.0,
            };
            if rate.is_finite() {
                drop[b] -= inertia * rate;
            }
        }
        Self {
            flow,
            averaged,
            through,
            speed,
            drop,
            friction_factor: parts.friction_factor,
            lift: parts.lift,
            head_factor: parts.head_factor,
            difference: parts.difference,
            imbalance: parts.imbalance,
        }
    }
}

/// A series averaged over its calm surroundings, up to six values on either side (a minute of blocks), and left alone where it moves.
///
/// A curve fitted to noisy flow leans towards the mean (errors in variables); in steady operation, where flow varies by
/// noise alone, it would lose its slope altogether.
///
/// Steps of up to `least` are calm in any case. Returns the averages and the number of blocks in each.
pub(super) fn calmed(values: &[f64], least: f64) -> (Vec<f64>, Vec<f64>) {
    const REACH: usize = 6;
    let noise = crate::numbers::spread(values.windows(2).map(|w| w[1] - w[0]));
    if !noise.is_finite() {
        return (values.to_vec(), vec![1.0; values.len()]);
    }
    // The median step is calm: its spread is that of a difference of two.
    let gate = (2.2 * noise).max(2.2e-9).max(least);
    (0..values.len())
        .map(|b| {
            let (mut sum, mut count) = (values[b], 1.0);
            for k in 1..=REACH {
                let (Some(a), Some(z)) = (b.checked_sub(k).map(|i| values[i]), values.get(b + k))
                else {
                    break;
                };
                if !((a - values[b]).abs() < gate && (z - values[b]).abs() < gate) {
                    break;
                }
                sum += a + z;
                count += 2.0;
            }
            (sum / count, count)
        })
        .unzip()
}

#[cfg(test)]
mod tests;
