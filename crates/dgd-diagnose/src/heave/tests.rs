//! Claims about the swell that is found in a pressure.
#![allow(clippy::unwrap_used, reason = "a test may fail by panic")]

mod spectrum;

use super::swell;
use crate::test_rig::normals;
use dgd_units::STANDARD_GRAVITY_M_S2;

const DENSITY: f64 = 1080.0;

/// Two hours of inlet pressure with swell of the given amplitude, m, and 1 kPa of noise.
fn pressure(seed: u64, amplitude_m: f64, period_s: f64) -> Vec<f64> {
    let a = DENSITY * STANDARD_GRAVITY_M_S2 * amplitude_m;
    normals(seed, 7200)
        .iter()
        .enumerate()
        .map(|(i, v)| {
            let angle = 2.0 * std::f64::consts::PI * i as f64 / period_s;
            2e6 + a * angle.sin() + 1e3 * v
        })
        .collect()
}

#[test]
fn swell_is_found_with_its_period_and_amplitude() {
    for (seed, amplitude, period) in [(1, 0.5, 10.0), (2, 0.3, 7.3), (3, 1.0, 13.1)] {
        let found = swell(&pressure(seed, amplitude, period), 1.0, DENSITY).unwrap();
        assert!(found.ratio > 6.0, "{found:?}");
        assert!((found.period_s / period - 1.0).abs() < 0.02, "{found:?}");
        assert!(
            (found.amplitude_m / amplitude - 1.0).abs() < 0.3,
            "{found:?}"
        );
    }
}

#[test]
fn white_noise_has_no_swell() {
    for seed in 10..30 {
        let found = swell(&pressure(seed, 0.0, 10.0), 1.0, DENSITY);
        assert!(found.is_ok_and(|s| s.ratio < 3.0), "seed {seed}: {found:?}");
    }
}

#[test]
fn a_slow_clock_and_a_short_or_empty_series_show_none() {
    let values = pressure(1, 0.5, 10.0);
    assert!(swell(&values, 10.0, DENSITY).is_err());
    assert!(swell(&values[..2000], 1.0, DENSITY).is_err());
    assert!(swell(&[], 1.0, DENSITY).is_err());
    assert!(swell(&[f64::NAN; 7200], 1.0, DENSITY).is_err());
    assert!(swell(&[2e6; 7200], 1.0, DENSITY).is_err());
}
