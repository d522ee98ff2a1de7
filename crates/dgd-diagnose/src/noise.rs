//! What the residuals of a right model look like: their size, memory and kinship, estimated from the recording.

mod apply;
mod memory;

use crate::relations::Rows;
use dgd_recording::{Rank, quantile};
use memory::{autoregression, high_pass};

/// Where each relation's rows begin in a stacked vector.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Layout {
    pub blocks: usize,
    pub difference: usize,
    pub mass: usize,
}

impl Layout {
    pub(crate) fn len(self) -> usize {
        2 * self.blocks + self.difference + self.mass
    }
    pub(crate) fn head(self) -> usize {
        self.blocks
    }
    pub(crate) fn difference_at(self) -> usize {
        2 * self.blocks
    }
    pub(crate) fn mass_at(self) -> usize {
        2 * self.blocks + self.difference
    }
    /// Rows of friction, head, difference, mass.
    pub(crate) fn sections(self) -> [std::ops::Range<usize>; 4] {
        [
            0..self.head(),
            self.head()..self.difference_at(),
            self.difference_at()..self.mass_at(),
            self.mass_at()..self.len(),
        ]
    }
}

/// A whitening of stacked residuals: head less its share of friction, then an autoregression, then a scale.
#[derive(Debug, Clone)]
pub(crate) struct Whitening {
    pub layout: Layout,
    pub valid: Vec<bool>,
    /// Share of the friction row in the head row of the same block: both hold the outlet's noise.
    pub kinship: f64,
    /// Two coefficients for friction, head, difference, mass.
    pub memory: [[f64; 2]; 4],
    /// 1 over the standard deviation of each row's innovation, wander left out.
    pub weight: Vec<f64>,
    still: Vec<bool>,
    /// Factor on a row that lacks predecessors.
    start: Vec<f64>,
    /// Share of an innovation by which the filter moves its estimate of the wander, by row.
    gain: Vec<[f64; 2]>,
    /// Decay of the wander since the section's previous row, by row.
    decay: Vec<[f64; 2]>,
    /// 1 over the standard deviation of the filter's innovation, by row.
    scale: Vec<f64>,
    /// Predecessors that a row has in its autoregression, 0 to 2.
    predecessors: Vec<usize>,
}

/// How far instruments wander within their accuracy, by section (one standard deviation, in the section's unit).
#[derive(Debug, Clone, Copy)]
pub(crate) struct Wander {
    pub friction_pa: f64,
    pub head_pa: f64,
    pub difference_pa: f64,
    pub mass_m3_s: f64,
    /// Correlation time over the length of a block.
    pub blocks: f64,
    /// Movements of the flow that its meter's noise hides, as they come through the friction curve.
    pub hidden_friction_pa: f64,
    /// The same through the head curve.
    pub hidden_head_pa: f64,
    /// Their correlation time over the length of a block.
    pub hidden_blocks: f64,
}

/// Median absolute value of the finite values over 0.6745: the standard deviation of a clean core; NaN if there is none.
pub(crate) fn spread(values: impl IntoIterator<Item = f64>) -> f64 {
    let sizes = values.into_iter().map(f64::abs);
    quantile(sizes, Rank::MEDIAN).map_or(f64::NAN, |v| v / 0.6745)
}

impl Whitening {
    /// Estimates the noise from residuals of a robust fit. `unrest` is each row's further standard deviation from
    /// its timing: what half a second is worth while things move.
    pub(crate) fn of(
        layout: Layout,
        rows: &Rows,
        residual: &[f64],
        unrest: &[f64],
        wander: Wander,
    ) -> Self {
        let mut valid = vec![false; layout.len()];
        valid[..layout.blocks].copy_from_slice(&rows.friction);
        valid[layout.head()..layout.difference_at()].copy_from_slice(&rows.head);
        valid[layout.difference_at()..layout.mass_at()].copy_from_slice(&rows.difference);
        valid[layout.mass_at()..].copy_from_slice(&rows.mass);
        for (v, r) in valid.iter_mut().zip(residual) {
            *v &= r.is_finite();
        }
        let mut whitening = Self {
            layout,
            valid,
            kinship: 0.0,
            memory: [[0.0; 2]; 4],
            weight: vec![0.0; layout.len()],
            still: rows.still.clone(),
            start: Vec::new(),
            gain: Vec::new(),
            decay: Vec::new(),
            scale: Vec::new(),
            predecessors: Vec::new(),
        };
        let n = layout.blocks;
        let flowing: Vec<bool> = (0..n)
            .map(|b| whitening.valid[b] && !rows.still[b])
            .collect();
        let heads: Vec<bool> = whitening.valid[n..2 * n].to_vec();
        let friction = high_pass(&residual[..n], &flowing, 15);
        let head = high_pass(&residual[n..2 * n], &heads, 15);
        let calm = |k: usize, limit: f64| unrest[k] < limit;
        let pick = |values: &[f64], valid: &[bool], from: usize, limit: f64| -> Vec<f64> {
            (0..values.len())
                .filter(|&b| valid[b] && calm(from + b, limit))
                .map(|b| values[b])
                .collect()
        };
        let scale_f = spread(pick(&friction, &flowing, 0, 1500.0)).clamp(500.0, 1e5);
        let scale_h = spread(pick(&head, &heads, n, 1500.0)).clamp(500.0, 1e5);
        let (mut sff, mut sfh) = (0.0, 0.0);
        for b in 0..n {
            if flowing[b]
                && heads[b]
                && friction[b].abs() < 4.0 * scale_f
                && head[b].abs() < 4.0 * scale_h
            {
                sff += friction[b] * friction[b];
                sfh += friction[b] * head[b];
            }
        }
        whitening.kinship = if sff > 0.0 {
            (sfh / sff).clamp(0.0, 1.5)
        } else {
            0.0
        };
        let kin = whitening.kinship;
        let own: Vec<f64> = (0..n)
            .map(|b| {
                if flowing[b] {
                    head[b] - kin * friction[b]
                } else {
                    head[b]
                }
            })
            .collect();
        whitening.section(0, &friction, &flowing, (scale_f, 1500.0), &unrest[..n]);
        let scale = spread(pick(&own, &heads, n, 1500.0)).clamp(2500.0, 1e5);
        whitening.section(1, &own, &heads, (scale, 2500.0), &unrest[n..2 * n]);
        // Standing mud: no ripple, its own noise.
        let standing: Vec<bool> = (0..n)
            .map(|b| whitening.valid[b] && rows.still[b])
            .collect();
        let still = high_pass(&residual[..n], &standing, 6);
        // Where nothing stands there is no row to weigh.
        let scale = spread(pick(&still, &standing, 0, f64::INFINITY));
        let scale = scale.max(800.0).min(scale_f);
        for b in 0..n {
            if standing[b] {
                whitening.weight[b] = 1.0 / scale;
            }
        }
        if layout.difference > 0 {
            let at = layout.difference_at();
            let valid = whitening.valid[at..at + layout.difference].to_vec();
            let values = high_pass(&residual[at..at + layout.difference], &valid, 30);
            let zero = vec![0.0; layout.difference];
            let scale = spread(pick(&values, &valid, at, f64::INFINITY)).clamp(200.0, 1e5);
            whitening.section(2, &values, &valid, (scale, 200.0), &zero);
        }
        let at = layout.mass_at();
        let valid = whitening.valid[at..].to_vec();
        let values = high_pass(&residual[at..], &valid, 30);
        let limit = 2e-4;
        let scale = spread(pick(&values, &valid, at, limit)).clamp(2e-5, 1e-2);
        whitening.section(3, &values, &valid, (scale, 2e-5), &unrest[at..]);
        whitening.starts();
        whitening.filter(wander);
        whitening
    }

    /// The same rows with another wander, but for some that are not used.
    pub(crate) fn with_wander(&self, wander: Wander, unused: std::ops::Range<usize>) -> Self {
        let mut other = self.clone();
        other.valid[unused.clone()].fill(false);
        other.weight[unused].fill(0.0);
        other.starts();
        other.filter(wander);
        other
    }

    /// Logarithm of each row's scale: what its likelihood gains where innovations are expected to be small; 0 where it has none.
    pub(crate) fn ln_scales(&self) -> impl Iterator<Item = f64> {
        let ln = |s: &f64| if *s > 0.0 { s.ln() } else { 0.0 };
        self.scale.iter().map(ln)
    }

    /// Prepares the filter that takes the wander (an Ornstein-Uhlenbeck process) out of white rows: gains and
    /// innovation variances of a scalar Kalman filter, which do not depend on the data.
    fn filter(&mut self, wander: Wander) {
        let l = self.layout;
        let total = l.len();
        self.gain = vec![[0.0; 2]; total];
        self.decay = vec![[1.0; 2]; total];
        self.scale = vec![0.0; total];
        let sections = [
            (
                0,
                l.blocks,
                [wander.friction_pa, wander.hidden_friction_pa],
                1.0,
            ),
            (
                l.blocks,
                l.blocks,
                [wander.head_pa, wander.hidden_head_pa],
                1.0,
            ),
            (
                l.difference_at(),
                l.difference,
                [wander.difference_pa, 0.0],
                1.0,
            ),
            (
                l.mass_at(),
                l.mass,
                [wander.mass_m3_s, 0.0],
                crate::record::MASS_BLOCKS as f64,
            ),
        ];
        for (k, (from, len, sd, blocks)) in sections.into_iter().enumerate() {
            // The autoregression lets slow things pass with this gain.
            let pass = 1.0 - self.memory[k][0] - self.memory[k][1];
            let stationary = sd.map(|s| (s * pass).powi(2));
            let mut p = [[stationary[0], 0.0], [0.0, stationary[1]]];
            let mut last: Option<usize> = None;
            for i in 0..len {
                let row = from + i;
                if !self.valid[row] || self.weight[row] <= 0.0 {
                    continue;
                }
                let gap = last.map_or(f64::INFINITY, |j| (i - j) as f64) * blocks;
                let d = [
                    (-gap / wander.blocks).exp(),
                    (-gap / wander.hidden_blocks).exp(),
                ];
                p = [
                    [
                        d[0] * d[0] * p[0][0] + (1.0 - d[0] * d[0]) * stationary[0],
                        d[0] * d[1] * p[0][1],
                    ],
                    [
                        d[0] * d[1] * p[1][0],
                        d[1] * d[1] * p[1][1] + (1.0 - d[1] * d[1]) * stationary[1],
                    ],
                ];
                let seen = [p[0][0] + p[0][1], p[1][0] + p[1][1]];
                let total = seen[0] + seen[1] + 1.0 / (self.weight[row] * self.weight[row]);
                let gain = [seen[0] / total, seen[1] / total];
                for a in 0..2 {
                    for b in 0..2 {
                        p[a][b] -= gain[a] * seen[b];
                    }
                }
                self.decay[row] = d;
                self.gain[row] = gain;
                self.scale[row] = 1.0 / total.sqrt();
                last = Some(i);
            }
        }
    }

    /// Memory and weights of one section.
    fn section(
        &mut self,
        k: usize,
        values: &[f64],
        valid: &[bool],
        scale: (f64, f64),
        unrest: &[f64],
    ) {
        let (scale, floor) = scale;
        let scale = if scale.is_finite() { scale } else { floor };
        let calm: Vec<bool> = valid
            .iter()
            .zip(unrest)
            .map(|(v, u)| *v && *u < 0.5 * scale)
            .collect();
        let memory = autoregression(values, &calm, scale);
        let innovations = (2..values.len())
            .filter(|&i| calm[i] && calm[i - 1] && calm[i - 2])
            .map(|i| values[i] - memory[0] * values[i - 1] - memory[1] * values[i - 2]);
        let sd = spread(innovations);
        let sd = if sd.is_finite() { sd.max(floor) } else { scale };
        self.memory[k] = memory;
        let from = [
            0,
            self.layout.head(),
            self.layout.difference_at(),
            self.layout.mass_at(),
        ][k];
        for i in 0..values.len() {
            if valid[i] {
                self.weight[from + i] = 1.0 / (sd * sd + unrest[i] * unrest[i]).sqrt();
            }
        }
    }

    /// Whether the head row of a block holds the friction row's noise.
    fn kin(&self, b: usize) -> bool {
        self.valid[b] && !self.still[b]
    }

    /// Whether row `i` of section `k` can stand in an autoregression.
    fn linked(&self, k: usize, i: usize) -> bool {
        let l = self.layout;
        match k {
            0 => self.valid[i] && !self.still[i],
            1 => self.valid[l.blocks + i],
            2 => self.valid[l.difference_at() + i],
            _ => self.valid[l.mass_at() + i],
        }
    }

    /// The predecessors of a row with their weights; at the start of a run there are fewer.
    fn memory_of(&self, k: usize, i: usize) -> impl Iterator<Item = (usize, f64)> + use<> {
        let [a, b] = self.memory[k];
        let one = i >= 1 && self.linked(k, i) && self.linked(k, i - 1);
        let two = one && i >= 2 && self.linked(k, i - 2);
        let pair = match (one, two) {
            (true, true) => [(1, a), (2, b)],
            (true, false) => [(1, (a / (1.0 - b)).clamp(-0.95, 0.95)), (0, 0.0)],
            _ => [(0, 0.0), (0, 0.0)],
        };
        pair.into_iter().filter(|(back, _)| *back > 0)
    }

    /// Factors that bring the first rows of a run, which have no full memory, to the size of the others.
    fn starts(&mut self) {
        let l = self.layout;
        let mut start = vec![1.0; l.len()];
        let mut predecessors = vec![0; l.len()];
        for (k, from, len) in [
            (0, 0, l.blocks),
            (1, l.blocks, l.blocks),
            (2, l.difference_at(), l.difference),
            (3, l.mass_at(), l.mass),
        ] {
            let [a, b] = self.memory[k];
            let r = (a / (1.0 - b)).clamp(-0.95, 0.95);
            for i in 0..len {
                let back = self.memory_of(k, i).map(|(back, _)| back).max();
                predecessors[from + i] = back.unwrap_or(0);
                if k == 0 && self.still[i] {
                    continue;
                }
                start[from + i] = match predecessors[from + i] {
                    0 => ((1.0 - b * b) * (1.0 - r * r)).max(0.05).sqrt(),
                    1 => (1.0 - b * b).max(0.1).sqrt(),
                    _ => 1.0,
                };
            }
        }
        self.start = start;
        self.predecessors = predecessors;
    }
}

#[cfg(test)]
mod tests;
