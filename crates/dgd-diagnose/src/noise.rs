//! The noise in the residuals, estimated from the recording: its size, its memory (autocorrelation), and its coupling (what head and friction
//! share).

mod apply;
mod memory;

use crate::layout::{Layout, Section};
use crate::numbers::spread;
use crate::relations::Rows;
use dgd_recording::{Rank, quantile};
use memory::{autoregression, high_pass};
use std::slice::SliceIndex;

/// Most that a spread of pressures may be, Pa, and of the balance, m³/s. Set by hand.
const MOST_PA: f64 = 1e5;
const MOST_M3_S: f64 = 1e-2;

/// Most that the memory of one row may be where only one stands before it: as one of a first order it is then stationary.
const MOST_MEMORY: f64 = 0.95;

/// A whitening of stacked residuals: head less its share of friction, then an autoregression, then a scale.
#[derive(Debug, Clone)]
pub(crate) struct Whitening {
    pub layout: Layout,
    pub valid: Vec<bool>,
    /// Share of the friction row in the head row of the same block: both hold the outlet's noise.
    pub coupling: f64,
    /// Two coefficients for each section.
    pub memory: [[f64; 2]; 4],
    /// 1 over the standard deviation of each row's innovation, wander left out.
    pub weight: Vec<f64>,
    still: Vec<bool>,
    /// Factor on a row that lacks predecessors.
    start: Vec<f64>,
    /// Share of something slow that is left of a row once its predecessors are taken off.
    passes: Vec<f64>,
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
    pub outlets_pa: f64,
    pub balance_m3_s: f64,
    /// Correlation time over the length of a block.
    pub blocks: f64,
    /// Movements of the flow that its meter's noise hides, as they come through the friction curve.
    pub hidden_friction_pa: f64,
    /// The same through the head curve.
    pub hidden_head_pa: f64,
    /// Their correlation time over the length of a block.
    pub hidden_blocks: f64,
}

impl Wander {
    /// What is slow and what is hidden in a section, each one standard deviation.
    pub(crate) fn of(&self, section: Section) -> [f64; 2] {
        match section {
            Section::Friction => [self.friction_pa, self.hidden_friction_pa],
            Section::Head => [self.head_pa, self.hidden_head_pa],
            Section::Outlets => [self.outlets_pa, 0.0],
            Section::Balance => [self.balance_m3_s, 0.0],
        }
    }
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
        let mut whitening = Self {
            layout,
            valid: valid(layout, rows, residual),
            coupling: 0.0,
            memory: [[0.0; 2]; 4],
            weight: vec![0.0; layout.len()],
            still: rows.still.clone(),
            start: Vec::new(),
            passes: Vec::new(),
            gain: Vec::new(),
            decay: Vec::new(),
            scale: Vec::new(),
            predecessors: Vec::new(),
        };
        let flowing_pa = whitening.pressures(residual, unrest);
        whitening.standing(residual, unrest, flowing_pa);
        whitening.outlets(residual);
        whitening.balance(residual, unrest);
        whitening.starts();
        whitening.filter(wander);
        whitening
    }

    /// Standard deviation of noise in a row as it is in the middle of some rows, in the unit of the row; NaN where none counts.
    pub(crate) fn noise(&self, rows: impl SliceIndex<[f64], Output = [f64]>) -> f64 {
        let weights = self.weight[rows].iter().copied();
        quantile(weights.filter(|w| *w > 0.0), Rank::MEDIAN).map_or(f64::NAN, |w| 1.0 / w)
    }

    /// Coupling, memory and weights of friction and head where mud flows; returns how much the friction varies there, Pa.
    fn pressures(&mut self, residual: &[f64], unrest: &[f64]) -> f64 {
        /// Rows to either side whose mean is not noise: two and a half minutes. Set by hand.
        const REACH: usize = 15;
        /// Least spread of friction or head before their common noise is known, Pa. Set by hand.
        const LEAST_PA: f64 = 500.0;
        /// Spreads from which on a row is no ordinary one. Set by hand.
        const ORDINARY: f64 = 4.0;
        /// Most of the friction's noise that a head row may hold. Set by hand.
        const MOST_COUPLING: f64 = 1.5;
        /// A row whose timing is worth more tells nothing of the noise.
        const CALM_PA: f64 = 1500.0;
        /// Standard deviations that no rig is below.
        const LEAST_FRICTION_PA: f64 = 1500.0;
        const LEAST_HEAD_PA: f64 = 2500.0;
        let [of_friction, of_head] =
            [Section::Friction, Section::Head].map(|s| self.layout.rows(s));
        let flowing: Vec<bool> = of_friction.clone().map(|b| self.is_coupled(b)).collect();
        let heads = self.valid[of_head.clone()].to_vec();
        let friction = high_pass(&residual[of_friction.clone()], &flowing, REACH);
        let head = high_pass(&residual[of_head.clone()], &heads, REACH);
        let (late_friction, late_head) = (&unrest[of_friction], &unrest[of_head]);
        let friction_pa = spread(calm(&friction, &flowing, late_friction, CALM_PA));
        let friction_pa = friction_pa.clamp(LEAST_PA, MOST_PA);
        let head_pa = spread(calm(&head, &heads, late_head, CALM_PA)).clamp(LEAST_PA, MOST_PA);
        let ordinary = |b: &usize| {
            flowing[*b]
                && heads[*b]
                && friction[*b].abs() < ORDINARY * friction_pa
                && head[*b].abs() < ORDINARY * head_pa
        };
        let (mut squares, mut products) = (0.0, 0.0);
        for b in (0..self.layout.blocks).filter(ordinary) {
            squares += friction[b] * friction[b];
            products += friction[b] * head[b];
        }
        let coupling = if squares > 0.0 {
            (products / squares).clamp(0.0, MOST_COUPLING)
        } else {
            0.0
        };
        self.coupling = coupling;
        let of_its_own = |b: usize| {
            if flowing[b] {
                head[b] - coupling * friction[b]
            } else {
                head[b]
            }
        };
        let own: Vec<f64> = (0..self.layout.blocks).map(of_its_own).collect();
        let sizes = (friction_pa, LEAST_FRICTION_PA);
        self.weigh(Section::Friction, &friction, &flowing, sizes, late_friction);
        let own_pa = spread(calm(&own, &heads, late_head, CALM_PA)).clamp(LEAST_HEAD_PA, MOST_PA);
        self.weigh(
            Section::Head,
            &own,
            &heads,
            (own_pa, LEAST_HEAD_PA),
            late_head,
        );
        friction_pa
    }

    /// Weights of the friction's rows where mud stands: no ripple, a noise of its own, which is no more than that of flowing mud.
    fn standing(&mut self, residual: &[f64], unrest: &[f64], flowing_pa: f64) {
        /// Rows to either side whose mean is not noise: a minute. Set by hand.
        const REACH: usize = 6;
        /// Standard deviation that no rig is below. Set by hand.
        const LEAST_PA: f64 = 800.0;
        let rows = self.layout.rows(Section::Friction);
        let standing: Vec<bool> = (rows.clone())
            .map(|b| self.valid[b] && self.still[b])
            .collect();
        let values = high_pass(&residual[rows.clone()], &standing, REACH);
        // Where nothing stands there is no row to weigh.
        let scale = spread(calm(
            &values,
            &standing,
            &unrest[rows.clone()],
            f64::INFINITY,
        ));
        let scale = scale.max(LEAST_PA).min(flowing_pa);
        for b in rows.filter(|b| standing[*b]) {
            self.weight[b] = 1.0 / scale;
        }
    }

    /// Memory and weights of two outlet transmitters against each other, which no timing parts.
    fn outlets(&mut self, residual: &[f64]) {
        /// Rows to either side whose mean is not noise: five minutes. Set by hand.
        const REACH: usize = 30;
        /// Standard deviation that no pair of transmitters is below. Set by hand.
        const LEAST_PA: f64 = 200.0;
        let rows = self.layout.rows(Section::Outlets);
        if rows.is_empty() {
            return;
        }
        let valid = self.valid[rows.clone()].to_vec();
        let values = high_pass(&residual[rows], &valid, REACH);
        let zero = vec![0.0; values.len()];
        let scale = spread(calm(&values, &valid, &zero, f64::INFINITY)).clamp(LEAST_PA, MOST_PA);
        self.weigh(Section::Outlets, &values, &valid, (scale, LEAST_PA), &zero);
    }

    /// Memory and weights of the balance.
    fn balance(&mut self, residual: &[f64], unrest: &[f64]) {
        /// Rows to either side whose mean is not noise: a quarter of an hour. Set by hand.
        const REACH: usize = 30;
        /// A row whose timing is worth more tells nothing of the noise.
        const CALM_M3_S: f64 = 2e-4;
        /// Standard deviation that no rig is below. Set by hand.
        const LEAST_M3_S: f64 = 2e-5;
        let rows = self.layout.rows(Section::Balance);
        let valid = self.valid[rows.clone()].to_vec();
        let values = high_pass(&residual[rows.clone()], &valid, REACH);
        let unrest = &unrest[rows];
        // What every row has is no timing.
        let every = unrest.iter().copied().fold(MOST_M3_S, f64::min);
        let calm = calm(&values, &valid, unrest, CALM_M3_S + every);
        let scale = spread(calm).clamp(LEAST_M3_S, MOST_M3_S);
        self.weigh(
            Section::Balance,
            &values,
            &valid,
            (scale, LEAST_M3_S),
            unrest,
        );
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
    /// innovation variances of a Kalman filter with a scalar measurement, which do not depend on the data.
    fn filter(&mut self, wander: Wander) {
        let total = self.layout.len();
        self.gain = vec![[0.0; 2]; total];
        self.decay = vec![[1.0; 2]; total];
        self.scale = vec![0.0; total];
        for section in Section::ALL {
            let rows = self.layout.rows(section);
            let sd = wander.of(section);
            let blocks = section.blocks_per_row() as f64;
            let stationary = sd.map(|s| s * s);
            let mut p = [[stationary[0], 0.0], [0.0, stationary[1]]];
            let mut last: Option<usize> = None;
            for row in rows {
                if !self.valid[row] || self.weight[row] <= 0.0 {
                    continue;
                }
                let gap = last.map_or(f64::INFINITY, |last| (row - last) as f64) * blocks;
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
                let passes = self.passes[row];
                let seen = [p[0][0] + p[0][1], p[1][0] + p[1][1]].map(|sum| passes * sum);
                let total =
                    passes * (seen[0] + seen[1]) + 1.0 / (self.weight[row] * self.weight[row]);
                let gain = [seen[0] / total, seen[1] / total];
                for a in 0..2 {
                    for b in 0..2 {
                        p[a][b] -= gain[a] * seen[b];
                    }
                }
                self.decay[row] = d;
                self.gain[row] = gain;
                self.scale[row] = 1.0 / total.sqrt();
                last = Some(row);
            }
        }
    }

    /// Memory and weights of one section, of which a scale and the least one are known.
    fn weigh(
        &mut self,
        section: Section,
        values: &[f64],
        valid: &[bool],
        (scale, least): (f64, f64),
        unrest: &[f64],
    ) {
        /// Share of the scale from which on a row's timing tells too much of it for the memory. Set by hand.
        const CALM: f64 = 0.5;
        let scale = if scale.is_finite() { scale } else { least };
        let calm: Vec<bool> = valid
            .iter()
            .zip(unrest)
            .map(|(v, u)| *v && *u < CALM * scale)
            .collect();
        let memory = autoregression(values, &calm, scale);
        let innovations = (2..values.len())
            .filter(|&i| calm[i] && calm[i - 1] && calm[i - 2])
            .map(|i| values[i] - memory[0] * values[i - 1] - memory[1] * values[i - 2]);
        let sd = spread(innovations);
        let sd = if sd.is_finite() { sd.max(least) } else { scale };
        self.memory[section as usize] = memory;
        for (i, row) in self.layout.rows(section).enumerate() {
            if valid[i] {
                self.weight[row] = 1.0 / (sd * sd + unrest[i] * unrest[i]).sqrt();
            }
        }
    }

    /// Whether the head row of a block holds the friction row's noise.
    fn is_coupled(&self, b: usize) -> bool {
        self.valid[b] && !self.still[b]
    }

    /// Whether row `i` of a section can stand in an autoregression.
    fn linked(&self, section: Section, i: usize) -> bool {
        let row = self.layout.rows(section).start + i;
        self.valid[row] && !(section == Section::Friction && self.still[i])
    }

    /// The predecessors of a row with their weights; at the start of a run there are fewer.
    fn memory_of(&self, section: Section, i: usize) -> impl Iterator<Item = (usize, f64)> + use<> {
        let [a, b] = self.memory[section as usize];
        let one = i >= 1 && self.linked(section, i) && self.linked(section, i - 1);
        let two = one && i >= 2 && self.linked(section, i - 2);
        let pair = match (one, two) {
            (true, true) => [(1, a), (2, b)],
            (true, false) => [(1, alone([a, b])), (0, 0.0)],
            _ => [(0, 0.0), (0, 0.0)],
        };
        pair.into_iter().filter(|(back, _)| *back > 0)
    }

    /// Factors that bring the first rows of a run, which have no full memory, to the size of the others, and what each row lets pass.
    fn starts(&mut self) {
        /// Least variance of an innovation over that of a row without predecessors, and of a row with one. Set by hand.
        const LEAST_WITHOUT: f64 = 0.05;
        const LEAST_WITH_ONE: f64 = 0.1;
        let mut start = vec![1.0; self.layout.len()];
        let mut passes = vec![1.0; self.layout.len()];
        let mut predecessors = vec![0; self.layout.len()];
        for section in Section::ALL {
            let [a, b] = self.memory[section as usize];
            let r = alone([a, b]);
            for (i, row) in self.layout.rows(section).enumerate() {
                let back = self.memory_of(section, i).map(|(back, _)| back).max();
                predecessors[row] = back.unwrap_or(0);
                if section == Section::Friction && self.still[i] {
                    continue;
                }
                start[row] = match predecessors[row] {
                    0 => ((1.0 - b * b) * (1.0 - r * r)).max(LEAST_WITHOUT).sqrt(),
                    1 => (1.0 - b * b).max(LEAST_WITH_ONE).sqrt(),
                    _ => 1.0,
                };
                let taken: f64 = self.memory_of(section, i).map(|(_, share)| share).sum();
                passes[row] = start[row] * (1.0 - taken);
            }
        }
        self.start = start;
        self.passes = passes;
        self.predecessors = predecessors;
    }
}

/// What a row takes of the one before where it is the only one: the correlation of neighbours in an autoregression of second order.
fn alone([a, b]: [f64; 2]) -> f64 {
    (a / (1.0 - b)).clamp(-MOST_MEMORY, MOST_MEMORY)
}

/// Which rows of a stacked vector count: those that the recording supports and in which something is left.
fn valid(layout: Layout, rows: &Rows, residual: &[f64]) -> Vec<bool> {
    let mut valid = Vec::with_capacity(layout.len());
    for section in Section::ALL {
        valid.extend_from_slice(rows.of_section(section));
    }
    for (v, r) in valid.iter_mut().zip(residual) {
        *v &= r.is_finite();
    }
    valid
}

/// The valid values whose timing is worth less than so much.
fn calm<'a>(
    values: &'a [f64],
    valid: &'a [bool],
    unrest: &'a [f64],
    most: f64,
) -> impl Iterator<Item = f64> + 'a {
    let all = values.iter().zip(valid).zip(unrest);
    all.filter_map(move |((v, valid), unrest)| (*valid && *unrest < most).then_some(*v))
}

#[cfg(test)]
mod tests;
