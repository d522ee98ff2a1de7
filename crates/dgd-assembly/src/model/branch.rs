//! Drops, flows and inertia of branches and chains.

use super::Work;
use crate::Dual;
use crate::kinds::{displacement, fluid, line};
use crate::laws;
use crate::network::{ATMOSPHERE_PA, Member, Network, NodeKind};
use crate::spec::Kind;

/// Newton steps of one scalar solution.
const MAX_SCALAR: usize = 100;

impl Work {
    /// Flow of a displacement pump without back-pressure.
    pub(super) fn delivered(&self, net: &Network, part: usize) -> f64 {
        let own = &self.values[net.parts[part].base..];
        own[displacement::COEFFICIENT] * own[displacement::INPUT]
    }

    /// `k` of `dp = k q|q|` of a valve or orifice, as found by [`solve`](Self::solve).
    #[inline(always)]
    pub(super) fn square(&self, part: usize) -> f64 {
        self.squares[self.square_of[part]].k
    }

    /// Drop of a branch from inlet to outlet.
    #[inline]
    pub(super) fn part_drop(&self, net: &Network, i: usize, q: Dual, x: &[f64]) -> Dual {
        let effects = net.effects_of(i);
        if effects.is_empty() {
            return self.base_drop(net, i, q);
        }
        let mut through = q;
        for attached in effects {
            through = attached
                .effect
                .through(&self.now(net, attached, x), through);
        }
        let mut drop = self.base_drop(net, i, through);
        for attached in effects {
            drop = attached.effect.drop(&self.now(net, attached, x), q, drop);
        }
        drop
    }

    #[inline]
    pub(super) fn base_drop(&self, net: &Network, i: usize, q: Dual) -> Dual {
        let part = &net.parts[i];
        let own = &self.values[part.base..part.base + part.count];
        let density = self.values[fluid::DENSITY];
        let gravity = self.values[fluid::GRAVITY];
        match part.kind {
            Kind::Line => laws::line_drop(
                part.friction,
                own,
                density,
                self.values[fluid::VISCOSITY],
                gravity,
                q,
            ),
            Kind::Valve | Kind::Orifice => laws::square(self.square(i), q),
            Kind::CentrifugalPump => laws::centrifugal_drop(own, density * gravity, q),
            _ => Dual::constant(0.0),
        }
    }

    /// Drop along a chain, displacement pumps left out.
    #[inline]
    pub(super) fn chain_drop(&self, net: &Network, c: usize, q: Dual, x: &[f64]) -> Dual {
        let mut sum = Dual::constant(0.0);
        for member in &net.chains[c].members {
            let drop = self.part_drop(net, member.part, member.sign * q, x);
            sum = sum + member.sign * drop;
        }
        sum
    }

    /// Flow of a chain at the pressure difference `dp` between its ends, with its derivative.
    pub(super) fn flow_at(&mut self, net: &Network, c: usize, dp: f64, x: &[f64]) -> Dual {
        let chain = &net.chains[c];
        if chain.plain_valve {
            return laws::square_inverse(self.square(chain.members[0].part), dp);
        }
        if let Some(member) = chain.slipping {
            return self.slipping(net, c, member, dp, x);
        }
        if chain.check_valve {
            let still = self.chain_drop(net, c, Dual::variable(0.0), x);
            if dp <= still.v {
                return Dual { v: 0.0, d: 1e-15 };
            }
        }
        let scale = self.flow_scale(net, c);
        let found = newton(self.flow[c], scale, |q| {
            let drop = self.chain_drop(net, c, q, x);
            (drop.v - dp, drop.d)
        });
        self.failed |= found.is_none();
        let (q, slope) = found.unwrap_or((0.0, 1.0));
        Dual {
            v: q,
            d: 1.0 / slope,
        }
    }

    pub(super) fn flow_scale(&self, net: &Network, c: usize) -> f64 {
        net.parts[net.chains[c].members[0].part].scale.flow_m3_s
    }

    /// Flow of a displacement pump that slips: q = Q(rise(q)).
    pub(super) fn slipping(
        &mut self,
        net: &Network,
        c: usize,
        member: usize,
        dp: f64,
        x: &[f64],
    ) -> Dual {
        let Member { part, sign } = net.chains[c].members[member];
        let delivery = |rise: Dual| {
            let mut flow = Dual::constant(self.delivered(net, part));
            for attached in net.effects_of(part) {
                flow = attached
                    .effect
                    .delivery(&self.now(net, attached, x), rise, flow);
            }
            flow
        };
        let scale = self.flow_scale(net, c);
        let found = newton(self.flow[c], scale, |q| {
            let rise = sign * (self.chain_drop(net, c, q, x) - dp);
            let residual = q - sign * delivery(rise);
            (residual.v, residual.d)
        });
        let Some((q, slope)) = found else {
            self.failed = true;
            return Dual { v: 0.0, d: 1e-15 };
        };
        let rise = sign * (self.chain_drop(net, c, Dual::variable(q), x).v - dp);
        let by_rise = delivery(Dual::variable(rise)).d;
        Dual {
            v: q,
            d: -by_rise / slope,
        }
    }

    /// What leaves each chain's end.
    pub(super) fn leave(&mut self, net: &Network, x: &[f64]) {
        for (c, chain) in net.chains.iter().enumerate() {
            let mut q = self.flow[c];
            if chain.leaves_other {
                let last = chain.members.len() - 1;
                let inlet = net.ends[chain.members[last].part][0]
                    .map_or(ATMOSPHERE_PA, |l| self.pressure_at(net, l, x));
                for attached in net.effects_of(chain.members[last].part) {
                    q = attached
                        .effect
                        .outlet(&self.now(net, attached, x), q, inlet);
                }
            }
            self.leaving[c] = q;
        }
    }

    /// Inertia of a branch, kg/m⁴ (Eq. 2.19a and 2.46).
    pub(super) fn inertia(&self, net: &Network, c: usize, i: usize, x: &[f64]) -> f64 {
        let part = &net.parts[i];
        let own = &self.values[part.base..part.base + part.count];
        let density = self.values[fluid::DENSITY];
        let mut inertia = 0.0;
        if part.inertia {
            inertia += density * own[line::LENGTH] / laws::line_area(own);
            if let Some(tank) = part
                .column
                .and_then(|t| net.tanks.iter().position(|&k| k == t))
            {
                // The column stands above the port at which the chain meets the tank.
                let port =
                    [net.chains[c].from, net.chains[c].to]
                        .into_iter()
                        .find_map(|n| match net.nodes[n].kind {
                            NodeKind::Port {
                                tank: k,
                                height: Some(slot),
                            } if k == tank => Some(self.values[slot]),
                            _ => None,
                        });
                let height = (x[tank] - port.unwrap_or(0.0)).max(0.0);
                inertia += density * height / self.area(net, tank, x[tank], x);
            }
        }
        for attached in net.effects_of(i) {
            inertia += attached.effect.inertia(&self.now(net, attached, x));
        }
        inertia
    }

    pub(crate) fn accelerate(&mut self, net: &Network, x: &[f64]) {
        for &c in &net.inertial {
            let push = self.push(net, c, x);
            let chain = &net.chains[c];
            let inertia: f64 = chain
                .members
                .iter()
                .map(|m| self.inertia(net, c, m.part, x))
                .sum();
            // Lighter than a microsecond of its friction nothing can be told apart from no inertia at all.
            let least = 1e-6 * push.d.abs();
            self.acceleration[c] = if self.shut[c] {
                0.0
            } else {
                push.v / inertia.max(least).max(1e-300)
            };
        }
    }

    /// Pressure that accelerates a chain at its flow, and its negative slope.
    pub(crate) fn push(&self, net: &Network, c: usize, x: &[f64]) -> Dual {
        let chain = &net.chains[c];
        let dp = self.pressure[chain.from] - self.pressure[chain.to];
        dp - self.chain_drop(net, c, Dual::variable(self.flow[c]), x)
    }
}

/// Root of a rising function, safeguarded by the bracket its signs give; the root and the slope there.
fn newton(start: f64, scale: f64, f: impl Fn(Dual) -> (f64, f64)) -> Option<(f64, f64)> {
    let mut q = if start.is_finite() { start } else { 0.0 };
    let (mut low, mut high) = (f64::NEG_INFINITY, f64::INFINITY);
    let mut reach = scale;
    for _ in 0..MAX_SCALAR {
        let (residual, slope) = f(Dual::variable(q));
        if !residual.is_finite() {
            return None;
        }
        if residual == 0.0 {
            return Some((q, slope.max(1e-300)));
        }
        if residual > 0.0 {
            high = q
        } else {
            low = q
        }
        let mut next = q - residual / slope;
        // Steps shrink quadratically: after one of 1e-8 the next would be round-off.
        if slope > 0.0 && (next - q).abs() <= 1e-8 * next.abs() + 1e-15 * scale {
            return Some((next, slope));
        }
        if !(next > low && next < high) {
            if low.is_finite() && high.is_finite() {
                next = 0.5 * (low + high);
                if high - low <= 4.0 * f64::EPSILON * next.abs() + 1e-15 * scale {
                    return Some((next, slope.max(1e-300)));
                }
            } else {
                reach *= 2.0;
                next = if low.is_finite() {
                    low + reach
                } else {
                    high - reach
                };
            }
        }
        q = next;
    }
    None
}
