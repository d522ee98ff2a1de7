//! Areas, balances and brims of tanks.

use super::{Mode, Work};
use crate::effect::Balance;
use crate::kinds::{boundary, tank};
use crate::network::{Network, NodeKind};

impl Work {
    /// Area of a tank's surface at a level.
    #[inline]
    pub(super) fn area(&self, net: &Network, number: usize, level: f64, x: &[f64]) -> f64 {
        let part = &net.parts[net.tanks[number]];
        let mut area = if part.profile.is_empty() {
            self.values[part.base + tank::AREA]
        } else {
            profile_area(&part.profile, level)
        };
        for attached in net.effects_of(net.tanks[number]) {
            area = attached
                .effect
                .area(&self.now(net, attached, x), level, area);
        }
        area.max(1e-12)
    }

    /// Volume between level 0 and the surface of a tank, negative below it.
    pub(super) fn filled(&self, net: &Network, number: usize, x: &[f64]) -> f64 {
        /// An effect may have a kink between two heights.
        const PARTS: u32 = 4;
        let part = &net.parts[net.tanks[number]];
        let (profile, level) = (part.profile.as_slice(), x[number]);
        if net.effects_of(net.tanks[number]).is_empty() {
            if profile.is_empty() {
                return self.values[part.base + tank::AREA] * level;
            }
            // Between two of the heights the area is straight, and so the rule of trapezia exact.
            let mean = |a, b| 0.5 * (profile_area(profile, a) + profile_area(profile, b));
            return slabs(profile, level, |low, high| mean(low, high) * (high - low));
        }
        let area = |level| self.area(net, number, level, x);
        slabs(profile, level, |low, high| {
            let step = (high - low) / f64::from(PARTS);
            // Simpson's rule is exact where an effect makes a parabola of the straight area.
            let simpson = |part: u32| {
                let a = low + step * f64::from(part);
                step / 6.0 * (area(a) + 4.0 * area(a + 0.5 * step) + area(a + step))
            };
            (0..PARTS).map(simpson).sum()
        })
    }

    pub(crate) fn balance(&mut self, net: &Network, x: &[f64]) {
        self.inflow.fill(0.0);
        self.outflow.fill(0.0);
        self.caught.fill(0.0);
        for node in &net.nodes {
            let NodeKind::Port { tank, .. } = node.kind else {
                continue;
            };
            for &source in &node.sources {
                self.inflow[tank] += self.values[net.parts[source].base + boundary::FLOW];
            }
            for &(c, sign) in &node.chains {
                let q = if sign > 0.0 {
                    self.leaving[c]
                } else {
                    -self.flow[c]
                };
                if q > 0.0 {
                    self.inflow[tank] += q
                } else {
                    self.outflow[tank] -= q
                }
            }
        }
        for &k in &net.tank_order {
            self.inflow[k] += self.caught[k];
            let effects = net.effects_of(net.tanks[k]);
            if effects.is_empty() {
                self.net_flow[k] = self.inflow[k] - self.outflow[k];
                self.surface[k] = self.area(net, k, x[k], x);
                continue;
            }
            self.surface[k] = self.area(net, k, x[k], x);
            let mut flows = Balance {
                level_m: x[k],
                brim_m: self.brim(net, k, x),
                area_m2: self.surface[k],
                inflow_m3_s: self.inflow[k],
                outflow_m3_s: self.outflow[k],
                ..Balance::default()
            };
            for attached in effects {
                attached
                    .effect
                    .balance(&self.now(net, attached, x), &mut flows);
            }
            let filling = flows.inflow_m3_s
                - flows.outflow_m3_s
                - flows.overflow_m3_s
                - flows.lost_m3_s
                - flows.passed_on_m3_s;
            self.net_flow[k] = filling;
            let spilled = flows.overflow_m3_s
                + if self.mode[k] == Mode::Full {
                    filling.max(0.0)
                } else {
                    0.0
                };
            if let Some(below) = net.below[k] {
                self.caught[below] += flows.passed_on_m3_s + flows.caught * spilled;
            }
        }
    }

    /// Height at which what comes is spilled at once.
    #[inline]
    pub(crate) fn brim(&self, net: &Network, k: usize, x: &[f64]) -> f64 {
        let part = &net.parts[net.tanks[k]];
        let mut brim = self.values[part.base + tank::BRIM];
        for attached in net.effects_of(net.tanks[k]) {
            brim = attached.effect.brim(&self.now(net, attached, x), brim);
        }
        brim
    }
}

/// Sum of the slabs between level 0 and another, of which the heights of a profile are edges; negative below 0.
fn slabs(profile: &[[f64; 2]], level: f64, slab: impl Fn(f64, f64) -> f64) -> f64 {
    let (from, to) = (level.min(0.0), level.max(0.0));
    let mut volume = 0.0;
    let mut low = from;
    for high in profile
        .iter()
        .map(|p| p[0])
        .filter(|h| *h > from && *h < to)
    {
        volume += slab(low, high);
        low = high;
    }
    (volume + slab(low, to)).copysign(level)
}

fn profile_area(profile: &[[f64; 2]], level: f64) -> f64 {
    let above = profile.partition_point(|p| p[0] <= level);
    match (above.checked_sub(1), profile.get(above)) {
        (None, Some(first)) => first[1],
        (Some(i), Some(next)) => {
            let [h, a] = profile[i];
            a + (next[1] - a) * (level - h) / (next[0] - h)
        }
        (Some(i), None) => profile[i][1],
        (None, None) => 1.0,
    }
}
