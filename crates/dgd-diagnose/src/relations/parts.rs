//! From samples to means of blocks, a row of the mass balance at a time.

use crate::record::{MASS_BLOCKS, Record, mean};
use dgd_effects::shrunk;
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
    /// One a [`MASS_BLOCKS`] blocks.
    pub(super) imbalance: Vec<f64>,
}

impl Parts {
    /// None yet, of so many blocks.
    pub(super) fn room_for(blocks: usize) -> Self {
        let empty = || Vec::with_capacity(blocks);
        Self {
            flow: empty(),
            through: empty(),
            speed: empty(),
            drop: empty(),
            friction_factor: empty(),
            lift: empty(),
            head_factor: empty(),
            difference: empty(),
            imbalance: Vec::with_capacity(blocks / MASS_BLOCKS),
        }
    }

    /// The parts with those of some rows of the mass balance, from row `from` on, in their place.
    pub(crate) fn with(mut self, other: &Self, from: usize) -> Self {
        let lay = |into: &mut Vec<f64>, part: &[f64], from: usize| {
            if let Some(place) = into.get_mut(from..from + part.len()) {
                place.copy_from_slice(part);
            }
        };
        let block = from * MASS_BLOCKS;
        for (into, part) in [
            (&mut self.flow, &other.flow),
            (&mut self.through, &other.through),
            (&mut self.speed, &other.speed),
            (&mut self.drop, &other.drop),
            (&mut self.friction_factor, &other.friction_factor),
            (&mut self.lift, &other.lift),
            (&mut self.head_factor, &other.head_factor),
            (&mut self.difference, &other.difference),
        ] {
            lay(into, part, block);
        }
        lay(&mut self.imbalance, &other.imbalance, from);
        self
    }
}

/// The same by sample, of a row of the mass balance.
#[derive(Default)]
pub(super) struct Native {
    pub(super) flow: Vec<f64>,
    pub(super) through: Vec<f64>,
    pub(super) speed: Vec<f64>,
    pub(super) drop: Vec<f64>,
    pub(super) friction_factor: Vec<f64>,
    pub(super) lift: Vec<f64>,
    pub(super) head_factor: Vec<f64>,
    pub(super) net: Vec<f64>,
    pub(super) area: Vec<f64>,
    pub(super) bias: Vec<f64>,
    pub(super) inlet_bias: Vec<f64>,
}

impl Native {
    /// Appends the means of whole blocks, and is empty again; the first sample is number `first`, where a row of the
    /// mass balance begins.
    pub(super) fn move_into(&mut self, parts: &mut Parts, record: &Record, first: usize) {
        let m = record.per_block;
        let blocks = self.flow.len() / m;
        let by = |values: &mut Vec<f64>, out: &mut Vec<f64>| {
            out.extend(values.chunks_exact(m).map(trimmed));
            values.clear();
        };
        if let [one, two] = record.outlets.as_slice() {
            let here = |b: usize| b * m..(b + 1) * m;
            let there = |b: usize| first + b * m..first + (b + 1) * m;
            parts.difference.extend(
                (0..blocks).map(|b| {
                    mean(&one[there(b)]) - mean(&two[there(b)]) - mean(&self.bias[here(b)])
                }),
            );
        }
        let per_mass = m * MASS_BLOCKS;
        let mass_seconds = record.dt_s * per_mass as f64;
        let edge = |i: usize| mean(&record.inlet[record.about_edge(i)]);
        let plain_area =
            record.setting.riser_area_m2 / (record.setting.density_kg_m3 * STANDARD_GRAVITY_M_S2);
        parts.imbalance.extend((0..blocks / MASS_BLOCKS).map(|k| {
            let r = k * per_mass..(k + 1) * per_mass;
            let net = &self.net[r.clone()];
            let bad = net.iter().filter(|v| !v.is_finite()).count();
            if bad * 10 > net.len() {
                return f64::NAN;
            }
            let read = (edge(first + r.end) - edge(first + r.start)) / mass_seconds;
            let drift = (self.inlet_bias[r.end - 1] - self.inlet_bias[r.start])
                / (mass_seconds - record.dt_s);
            let rate = read - drift;
            let noise = record.setting.noise.inlet_pa / mass_seconds;
            let area = mean(&self.area[r.clone()]);
            mean(net) - plain_area * rate - (area - plain_area) * shrunk(rate, noise)
        }));
        by(&mut self.flow, &mut parts.flow);
        by(&mut self.through, &mut parts.through);
        by(&mut self.speed, &mut parts.speed);
        by(&mut self.drop, &mut parts.drop);
        by(&mut self.friction_factor, &mut parts.friction_factor);
        by(&mut self.lift, &mut parts.lift);
        by(&mut self.head_factor, &mut parts.head_factor);
        for values in [
            &mut self.net,
            &mut self.area,
            &mut self.bias,
            &mut self.inlet_bias,
        ] {
            values.clear();
        }
    }
}

/// Mean of a block without its greatest and least value, so that a spike costs nothing.
fn trimmed(values: &[f64]) -> f64 {
    let (mut sum, mut count, mut low, mut high) = (0.0, 0.0, f64::INFINITY, f64::NEG_INFINITY);
    for v in values.iter().filter(|v| v.is_finite()) {
        sum += v;
        count += 1.0;
        low = low.min(*v);
        high = high.max(*v);
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
        assert_eq!(trimmed(&[1.0, 1.0, 1e9, 1.0, 1.0]), 1.0);
        assert_eq!(trimmed(&[1.0, f64::NAN, 3.0]), 2.0);
        assert!(trimmed(&[f64::NAN]).is_nan());
    }
}
