//! Claims about the swell that is found in a pressure.
#![allow(clippy::unwrap_used, reason = "a test may fail by panic")]

mod spectrum;

use super::{Unseen, once, passes_levels, spectral, swell};
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
    let still = swell(&[2e6; 7200], 1.0, DENSITY);
    assert!(still.is_err_and(|why| why == Unseen::Still));
    let short = swell(&[2e6; 2000], 1.0, DENSITY);
    assert!(short.is_err_and(|why| why == Unseen::Short));
}

/// Pressures of two seconds in a log of one, and of one in a log of ten a second.
#[test]
fn swell_is_found_in_readings_that_are_held_as_it_is_in_each_of_them_once() {
    for (every, held, step_s) in [(2, 2, 1.0), (1, 10, 0.1)] {
        let read: Vec<f64> = (pressure(1, 0.5, 10.0).into_iter().step_by(every)).collect();
        let once = swell(&read, held as f64 * step_s, DENSITY).unwrap();
        assert!(once.ratio > once.believed && (once.period_s - 10.0).abs() < 0.2);
        for phase in [0, 1] {
            let log: Vec<f64> = (read.iter())
                .flat_map(|v| std::iter::repeat_n(*v, held))
                .skip(phase)
                .collect();
            let found = swell(&log, step_s, DENSITY).unwrap();
            assert!(
                (found.period_s / once.period_s - 1.0).abs() < 1e-3,
                "{found:?}"
            );
            assert!(
                (found.amplitude_m / once.amplitude_m - 1.0).abs() < 1e-2,
                "{found:?}"
            );
            assert_eq!(found.folded_s, once.folded_s);
        }
        // What is not held is missing in other logs.
        let gaps: Vec<f64> = (read.iter())
            .flat_map(|v| (1..held).map(|_| f64::NAN).chain([*v]))
            .collect();
        let found = swell(&gaps, step_s, DENSITY).unwrap();
        assert_eq!(found.amplitude_m.to_bits(), once.amplitude_m.to_bits());
    }
}

#[test]
fn a_coarse_reading_shows_swell_and_no_more_than_is_there() {
    let coarse = |values: &[f64]| -> Vec<f64> {
        let quantum_pa = 1e4;
        let read = |v: &f64| quantum_pa * (v / quantum_pa).round();
        values.iter().map(read).collect()
    };
    for seed in 1..6 {
        let values = coarse(&pressure(seed, 0.5, 12.0));
        let same = values.windows(2).filter(|w| w[0] == w[1]).count();
        assert!(2 * same > values.len(), "most differences are 0");
        let found = swell(&values, 1.0, DENSITY).unwrap();
        assert!(found.ratio > found.believed, "{found:?}");
        assert!((found.period_s / 12.0 - 1.0).abs() < 0.02, "{found:?}");
        assert!((found.amplitude_m / 0.5 - 1.0).abs() < 0.4, "{found:?}");
        // A level that wanders by some quanta, read without swell.
        let calm: Vec<f64> = (pressure(seed, 0.0, 10.0).iter().enumerate())
            .map(|(i, v)| v + 3e4 * (i as f64 / 900.0).sin())
            .collect();
        let found = swell(&coarse(&calm), 1.0, DENSITY).unwrap();
        assert!(found.ratio < found.believed, "{found:?}");
    }
}

#[test]
fn swell_that_passes_from_level_to_level_of_a_coarse_reading_is_not_held() {
    // Without noise, two levels of 0.1 bar, each of which lasts about five samples: one value of each is too few.
    for (period_s, quanta, offset) in [(10.1, 0.8, 0.5), (9.9, 0.6, 0.5)] {
        let values: Vec<f64> = (0..7200)
            .map(|i| {
                let turns = f64::from(i) / period_s;
                2e6 + 1e4 * (offset + quanta * (2.0 * std::f64::consts::PI * turns).sin()).round()
            })
            .collect();
        assert_eq!(dgd_recording::held_for(&values), 5, "{period_s}");
        let found = swell(&values, 1.0, DENSITY).unwrap();
        assert!(found.ratio > found.believed, "{found:?}");
        assert!((found.period_s / period_s - 1.0).abs() < 0.01, "{found:?}");
        let thinned = spectral(&once(&values, 5), 5.0, DENSITY);
        assert!(thinned.is_ok_and(|s| (s.period_s / period_s - 1.0).abs() > 0.01));
    }
    // Held readings repeat themselves now and then if they are coarse, and move by any size if they are not.
    let fine = normals(3, 1000);
    let coarse: Vec<f64> = fine.iter().map(|v| f64::from(*v > 0.0)).collect();
    for read in [fine, coarse] {
        let log: Vec<f64> = (read.iter())
            .flat_map(|v| std::iter::repeat_n(*v, 5))
            .collect();
        assert!(!passes_levels(&log, 5));
    }
}
