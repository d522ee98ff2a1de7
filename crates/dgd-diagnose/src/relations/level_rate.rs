//! How fast the level moves, as the pump inlet pressure tells it.

use super::blocks::calmed;
use crate::record::{MASS_BLOCKS, Record, mean};
use dgd_effects::shrunk;

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
    /// By what the suction loses the inlet reads less than the level is worth.
    pub(crate) fn of(record: &Record) -> Self {
        let per_row = record.per_block * MASS_BLOCKS;
        let seconds = record.dt_s * per_row as f64;
        let edge = |i: usize| mean(&record.inlet[record.about_edge(i)]) + record.suction_pa(i);
        let rows = record.t_s.len() / per_row;
        let read: Vec<f64> = (0..rows)
            .map(|k| (edge((k + 1) * per_row) - edge(k * per_row)) / seconds)
            .collect();
        let (calm, averaged) = calmed(&read);
        Self {
            read,
            calm,
            averaged,
            noise: record.setting.noise.inlet_pa / seconds,
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
