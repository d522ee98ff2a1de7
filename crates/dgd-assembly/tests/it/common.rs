//! The examples, and signals for them.

use dgd_assembly::{Assembly, Record, Window};

pub(crate) const TWO_TANKS: &str = include_str!("../../examples/two_tanks.toml");
pub(crate) const PUMP_LOOP: &str = include_str!("../../examples/pump_loop.toml");
pub(crate) const RETURN_LINE: &str = include_str!("../../examples/return_line.toml");

/// Uniform in ±0.5, the same on every machine.
pub(crate) struct Noise(pub(crate) u64);

impl Noise {
    pub(crate) fn next(&mut self) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        f64::from(u32::try_from(self.0 >> 32).unwrap()) / f64::from(u32::MAX) - 0.5
    }
}

pub(crate) fn clock(n: u32, step: f64) -> Vec<f64> {
    (0..n).map(|i| f64::from(i) * step).collect()
}

/// Held steps of random height between `low` and `high`, each of `hold` samples.
pub(crate) fn steps(n: usize, hold: usize, low: f64, high: f64) -> Vec<f64> {
    let mut noise = Noise(11);
    let mut value = 0.0;
    (0..n)
        .map(|i| {
            if i % hold == 0 {
                value = low + (high - low) * (noise.next() + 0.5);
            }
            value
        })
        .collect()
}

/// The first training window of `columns`.
pub(crate) fn window(assembly: &Assembly, columns: &[(&str, &[f64])]) -> Window {
    let record = Record {
        columns: columns.to_vec(),
    };
    assembly
        .windows(&record, dgd_assembly::Portion::Train)
        .unwrap()
        .remove(0)
}

/// Largest absolute difference.
pub(crate) fn apart(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len());
    a.iter()
        .zip(b)
        .map(|(a, b)| (a - b).abs())
        // `max` drops a NaN on either side.
        .fold(0.0, |m: f64, d| {
            if m.is_nan() || d.is_nan() {
                f64::NAN
            } else {
                m.max(d)
            }
        })
}
