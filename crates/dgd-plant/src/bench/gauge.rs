//! Instruments: a unit, white noise, and steps in which the reading comes.

use crate::noise::Noise;

/// An instrument as it files its readings.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gauge {
    /// Instrument of the system description; of an input, the property that it drives.
    pub name: &'static str,
    /// Column.
    pub tag: &'static str,
    /// Unit of the column.
    pub unit: &'static str,
    /// SI value of one unit.
    pub si: f64,
    /// Standard deviation of the noise, in the unit.
    pub noise: f64,
    /// Step of the readings, in the unit.
    pub quantum: f64,
}

impl Gauge {
    /// The reading of a true value in SI.
    pub(crate) fn read(&self, true_si: f64, noise: &mut Noise) -> f64 {
        let exact = true_si / self.si + self.noise * noise.normal();
        let steps = (exact / self.quantum).round();
        // Dividing by the whole number of steps a unit gives 0.3 where multiplying would give 0.30000000000000004.
        let per_unit = (1.0 / self.quantum).round();
        if per_unit >= 1.0 && (per_unit * self.quantum - 1.0).abs() < 1e-9 {
            steps / per_unit
        } else {
            steps * self.quantum
        }
    }
}
