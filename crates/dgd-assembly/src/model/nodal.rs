//! Pressures of several nodes at once.

use super::Work;
use crate::Dual;
use crate::network::{Island, Network};

/// Newton steps on flows and pressures: a cold start halves its flows from wherever it was.
const MAX_GRADIENT: usize = 120;
/// Newton steps of one nodal solution.
const MAX_NODAL: usize = 60;

impl Work {
    /// Pressures and flows of an island.
    pub(super) fn nodal(&mut self, net: &Network, number: usize, x: &[f64]) {
        let island = &net.islands[number];
        let slips = island
            .chains
            .iter()
            .any(|&c| net.chains[c].slipping.is_some());
        if slips || !self.gradient(net, island, x) {
            self.descend(net, island, x);
        }
    }

    /// Newton's method on flows and pressures together, the global gradient algorithm of Todini, E. and Pilati, S. (1988)
    /// as in EPANET: square laws converge as Heron's roots do, from anywhere, where balances of square roots have kinks.
    fn gradient(&mut self, net: &Network, island: &Island, x: &[f64]) -> bool {
        let n = island.nodes.len();
        for &c in &island.chains {
            // Cold: at rest square laws have hardly any slope.
            if self.flow[c] == 0.0 || !self.flow[c].is_finite() {
                self.flow[c] = self.flow_scale(net, c);
            }
        }
        for _ in 0..MAX_GRADIENT {
            self.matrix[..n * n].fill(0.0);
            for (k, &node) in island.nodes.iter().enumerate() {
                // What arrives by chains whose flow is known.
                let own: f64 = net.nodes[node]
                    .chains
                    .iter()
                    .filter(|(c, _)| island.chains.contains(c))
                    .map(|&(c, sign)| sign * self.flow[c])
                    .sum();
                self.residual[k] = self.arriving(net, node) - own;
            }
            for &c in &island.chains {
                let (from, to) = (net.chains[c].from, net.chains[c].to);
                let drop = self.one_way_drop(net, c, x);
                let g = 1.0 / drop.d;
                if !(drop.v.is_finite() && g.is_finite()) {
                    return false;
                }
                // q' = q + g (p_from − p_to − drop), of which the known part:
                let mut fixed = self.flow[c] - g * drop.v;
                let a = island.nodes.iter().position(|&m| m == from);
                let b = island.nodes.iter().position(|&m| m == to);
                if a.is_none() {
                    fixed += g * self.pressure[from];
                }
                if b.is_none() {
                    fixed -= g * self.pressure[to];
                }
                if let Some(a) = a {
                    self.matrix[a * n + a] += g;
                    self.residual[a] -= fixed;
                }
                if let Some(b) = b {
                    self.matrix[b * n + b] += g;
                    self.residual[b] += fixed;
                }
                if let (Some(a), Some(b)) = (a, b) {
                    self.matrix[a * n + b] -= g;
                    self.matrix[b * n + a] -= g;
                }
            }
            self.step[..n].copy_from_slice(&self.residual[..n]);
            if !solve_dense(&mut self.matrix[..n * n], &mut self.step[..n], n) {
                return false;
            }
            for (k, &node) in island.nodes.iter().enumerate() {
                self.pressure[node] = self.step[k];
            }
            let mut settled = true;
            for &c in &island.chains {
                let drop = self.one_way_drop(net, c, x);
                let push = self.pressure[net.chains[c].from] - self.pressure[net.chains[c].to];
                let moved = (push - drop.v) / drop.d;
                if !moved.is_finite() {
                    return false;
                }
                self.flow[c] += moved;
                settled &=
                    moved.abs() <= 1e-10 * self.flow[c].abs() + 1e-13 * self.flow_scale(net, c);
            }
            if settled {
                return true;
            }
        }
        false
    }

    /// Drop at the chain's flow; a check valve's grows steeply against the flow. Its slope is never zero, or a line
    /// without friction would make the equations singular.
    fn one_way_drop(&self, net: &Network, c: usize, x: &[f64]) -> Dual {
        let q = Dual::variable(self.flow[c]);
        let chain = &net.chains[c];
        let scale = &net.parts[chain.members[0].part].scale;
        if !chain.check_valve || q.v >= 0.0 {
            let drop = self.chain_drop(net, c, q, x);
            let least = 1e-9 * scale.pressure_pa / scale.flow_m3_s;
            return Dual {
                v: drop.v,
                d: drop.d.max(least),
            };
        }
        self.chain_drop(net, c, Dual::constant(0.0), x)
            + (1e9 * scale.pressure_pa / scale.flow_m3_s) * q
    }

    /// Pressures of an island by Newton's method on its mass balances, halving steps that do not help.
    fn descend(&mut self, net: &Network, island: &Island, x: &[f64]) {
        let n = island.nodes.len();
        let scale = net.parts.first().map_or(1.0, |p| p.scale.flow_m3_s);
        let mut size = self.node_residual(net, island, x);
        for _ in 0..MAX_NODAL {
            if size <= 1e-11 * scale {
                return;
            }
            for k in 0..n {
                self.step[k] = self.residual[k];
            }
            if !solve_dense(&mut self.matrix[..n * n], &mut self.step[..n], n) {
                break;
            }
            for k in 0..n {
                self.trial[k] = self.pressure[island.nodes[k]];
            }
            let mut share = 1.0;
            let mut better = false;
            for _ in 0..40 {
                for k in 0..n {
                    self.pressure[island.nodes[k]] = self.trial[k] + share * self.step[k];
                }
                let now = self.node_residual(net, island, x);
                if now < size {
                    (size, better) = (now, true);
                    break;
                }
                share *= 0.5;
            }
            if !better {
                // Round-off: the residual falls no further.
                for k in 0..n {
                    self.pressure[island.nodes[k]] = self.trial[k];
                }
                size = self.node_residual(net, island, x);
                break;
            }
        }
        self.failed |= size > 1e-6 * scale || size.is_nan();
    }

    /// Largest mass imbalance of an island; writes imbalances and `−∂imbalance/∂pressure`.
    fn node_residual(&mut self, net: &Network, island: &Island, x: &[f64]) -> f64 {
        let n = island.nodes.len();
        for &c in &island.chains {
            self.flow[c] = if self.flow[c].is_finite() {
                self.flow[c]
            } else {
                0.0
            };
        }
        self.matrix[..n * n].fill(0.0);
        for &c in &island.chains {
            let (from, to) = (net.chains[c].from, net.chains[c].to);
            let q = self.flow_at(net, c, self.pressure[from] - self.pressure[to], x);
            self.flow[c] = q.v;
            let a = island.nodes.iter().position(|&m| m == from);
            let b = island.nodes.iter().position(|&m| m == to);
            // A trace of conductance keeps nodes between shut valves determined.
            let g = q.d.max(1e-18);
            if let Some(a) = a {
                self.matrix[a * n + a] += g;
            }
            if let Some(b) = b {
                self.matrix[b * n + b] += g;
            }
            if let (Some(a), Some(b)) = (a, b) {
                self.matrix[a * n + b] -= g;
                self.matrix[b * n + a] -= g;
            }
        }
        let mut worst = 0.0_f64;
        for (k, &node) in island.nodes.iter().enumerate() {
            self.residual[k] = self.arriving(net, node);
            worst = if self.residual[k].is_finite() {
                worst.max(self.residual[k].abs())
            } else {
                f64::INFINITY
            };
        }
        worst
    }
}

/// Gaussian elimination with partial pivoting, in place; false if singular.
fn solve_dense(a: &mut [f64], b: &mut [f64], n: usize) -> bool {
    for k in 0..n {
        let mut pivot = k;
        for i in k + 1..n {
            if a[i * n + k].abs() > a[pivot * n + k].abs() {
                pivot = i;
            }
        }
        if pivot != k {
            for j in 0..n {
                a.swap(k * n + j, pivot * n + j);
            }
            b.swap(k, pivot);
        }
        let inverse = 1.0 / a[k * n + k];
        if !inverse.is_finite() {
            return false;
        }
        for i in k + 1..n {
            let factor = a[i * n + k] * inverse;
            for j in k..n {
                a[i * n + j] -= factor * a[k * n + j];
            }
            b[i] -= factor * b[k];
        }
    }
    for i in (0..n).rev() {
        let mut sum = b[i];
        for j in i + 1..n {
            sum -= a[i * n + j] * b[j];
        }
        b[i] = sum / a[i * n + i];
    }
    true
}
