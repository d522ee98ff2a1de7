//! How fast the level moves, as the pump inlet pressure tells it.

use super::blocks::calmed;
use crate::layout::BALANCE_BLOCKS;
use crate::numbers::mean;
use crate::record::Record;
use dgd_effects::shrunk;

/// A jump by one quantum is sqrt(6) standard deviations of a rate read from rounded values. Half a deviation more.
const JUMPS: f64 = 3.0;

/// Rate of the pump inlet pressure in each row of the mass balance.
#[derive(Debug, Clone)]
pub(crate) struct LevelRate {
    /// From edge to edge of the row, Pa/s.
    read: Vec<f64>,
    /// Averaged where it is steady, up to six rows to either side, Pa/s, and over how many rows.
    calm: Vec<f64>,
    averaged: Vec<f64>,
    /// Noise of what is read, Pa/s.
    noise: f64,
}

impl LevelRate {
    /// By what the suction loses, where that is known, the inlet reads less than the level is worth.
    pub(crate) fn of(record: &Record) -> Self {
        let read = from_edge_to_edge(record, |i| {
            mean(&record.inlet[record.about_edge(i)]) + record.suction_pa(edge_flow(record, i))
        });
        // Of a reading rounded coarsely, noise is not seen: it stands, and then jumps.
        let rounded = record.coarse_m3_s / record.riser_m3_per_pa();
        let (calm, averaged) = calmed(&read, JUMPS * rounded);
        Self {
            read,
            calm,
            averaged,
            noise: (record.setting.noise.inlet_pa / record.row_s()).hypot(rounded),
        }
    }

    /// The rate in a row, Pa/s.
    pub(super) fn read(&self, row: usize) -> f64 {
        self.read[row]
    }

    /// The same less a drift of the reading, as far as noise does not hide it, Pa/s: another area tells of nothing else. Noise of
    /// what is read would make every area look too small, for it is weighed by the area.
    pub(super) fn told(&self, row: usize, drift: f64) -> f64 {
        if drift != 0.0 {
            // The rows about it may drift otherwise.
            return shrunk(self.read[row] - drift, self.noise);
        }
        // Rates over rows that follow each other share their edges.
        shrunk(self.calm[row], self.noise / self.averaged[row])
    }
}

/// What a loss of one velocity head of the return line at the suction would add to the imbalance of each row, were it put back, m³/s.
pub(crate) fn imbalance_per_head(record: &Record) -> Vec<f64> {
    let rates = from_edge_to_edge(record, |i| record.velocity_head_pa(edge_flow(record, i)));
    let per_pa = record.riser_m3_per_pa();
    rates.into_iter().map(|rate| -per_pa * rate).collect()
}

/// Flow through the line about a sample at which two rows meet, m³/s.
fn edge_flow(record: &Record, edge: usize) -> f64 {
    mean(&record.filled.flow[record.about_edge(edge)])
}

/// Rate at which a value at the edges of rows goes from one to the next, per second.
fn from_edge_to_edge(record: &Record, value: impl Fn(usize) -> f64) -> Vec<f64> {
    let per_row = record.per_block * BALANCE_BLOCKS;
    let edges = record.t_s.len() / per_row + 1;
    let values: Vec<f64> = (0..edges).map(|k| value(k * per_row)).collect();
    (values.windows(2))
        .map(|pair| (pair[1] - pair[0]) / record.row_s())
        .collect()
}

#[cfg(test)]
mod tests {
    use super::LevelRate;
    use crate::record::Record;
    use crate::test_rig::steady;

    /// Rates told of a level that falls steadily, as a share of what it falls by, of a reading in steps of a psi.
    fn told(falls_pa_s: f64) -> Vec<f64> {
        const PSI_PA: f64 = 6895.0;
        let mut record: Record = steady(360);
        let rounded = |t: f64| ((1e7 - falls_pa_s * t) / PSI_PA).round() * PSI_PA;
        record.inlet = record.t_s.iter().map(|t| rounded(*t)).collect();
        record.coarse_m3_s = record.riser_m3_per_pa() * PSI_PA / 6.0_f64.sqrt() / record.row_s();
        let rates = LevelRate::of(&record);
        let rows = record.blocks / crate::layout::BALANCE_BLOCKS;
        (8..rows - 8)
            .map(|k| rates.told(k, 0.0) / -falls_pa_s)
            .collect()
    }

    #[test]
    fn a_jump_of_a_rounded_pressure_is_not_how_fast_the_level_moves() {
        // A psi in eight minutes: nothing, rather than nothing and then sixteen times as much in one row.
        assert!(told(15.0).iter().all(|share| (0.0..1.0).contains(share)));
        // Five psi a row.
        let fast = told(1150.0);
        assert!(
            fast.iter().all(|share| (0.95..1.01).contains(share)),
            "{fast:?}"
        );
    }
}
