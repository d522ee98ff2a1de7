//! Claims about the numbers that a spectrum with swell gives.

use crate::heave::{Unseen, evidence_of, highest_of_noise, swell};
use crate::test_rig::normals;
use dgd_units::STANDARD_GRAVITY_M_S2;

const DENSITY: f64 = 1080.0;
const NOISE_PA: f64 = 1e3;

/// Amplitude in Pa of a swell in m.
fn pa(amplitude_m: f64) -> f64 {
    DENSITY * STANDARD_GRAVITY_M_S2 * amplitude_m
}

/// Inlet pressure with swells of some amplitude, m, and period, s, and white noise.
fn pressure(n: usize, step_s: f64, swells: &[(f64, f64)]) -> Vec<f64> {
    (normals(4, n).iter().enumerate())
        .map(|(i, noise)| {
            let t = step_s * i as f64;
            let sine = |s: &(f64, f64)| pa(s.0) * (std::f64::consts::TAU * t / s.1).sin();
            2e6 + swells.iter().map(sine).sum::<f64>() + NOISE_PA * noise
        })
        .collect()
}

/// Of two hundred recordings' amplitudes, 1 in 22 lies beyond two standard deviations of its own: 9, give or take two deviations of that count.
#[test]
fn an_amplitude_is_as_certain_as_it_says() {
    let beyond = (0..200).filter(|seed| {
        let noise = normals(100 + seed, 7200);
        let series: Vec<f64> = (noise.iter().enumerate())
            .map(|(i, noise)| 2e6 + pa(0.2) * (0.7 * i as f64).sin() + NOISE_PA * noise)
            .collect();
        let found = swell(&series, 1.0, DENSITY).unwrap();
        assert!((0.001..0.02).contains(&found.amplitude_sd_m), "{found:?}");
        (found.amplitude_m - 0.2).abs() > 2.0 * found.amplitude_sd_m
    });
    let beyond = beyond.count();
    assert!((4..=15).contains(&beyond), "{beyond}");
}

/// A mean of the last readings has notches at the periods that its length is a multiple of, between which power stands.
#[test]
fn means_of_seconds_of_noise_are_no_swell_and_keep_one_that_is_there() {
    let mean = |values: &[f64], of: usize| -> Vec<f64> {
        let all = values
            .windows(of)
            .map(|w| w.iter().sum::<f64>() / of as f64);
        all.collect()
    };
    for of in [5, 8, 10, 12, 15, 20, 30, 40] {
        for (seed, wander) in (40..60).zip([0.0, 0.3].into_iter().cycle()) {
            let (noise, level) = (normals(seed, 7200), normals(seed + 100, 7200));
            let mut at = 2e6;
            let series: Vec<f64> = (noise.iter().zip(&level))
                .map(|(noise, moved)| {
                    at += wander * NOISE_PA * moved;
                    at + NOISE_PA * noise
                })
                .collect();
            let found = swell(&mean(&series, of), 1.0, DENSITY).unwrap();
            assert!(found.ratio < found.believed, "{of} s, {seed}: {found:?}");
        }
        if of <= 10 {
            let swelling = pressure(7200, 1.0, &[(0.5, 13.0)]);
            let found = swell(&mean(&swelling, of), 1.0, DENSITY).unwrap();
            assert!(found.ratio > 2.0 * found.believed, "{of} s: {found:?}");
            assert!((found.period_s - 13.0).abs() < 0.2, "{of} s: {found:?}");
        }
    }
}

/// A broad swell, of many sines between 11 and 15 s, is seen however often it is read, and what lies beside it is taken for no notch.
#[test]
fn a_broad_swell_is_no_mean_of_seconds() {
    for (step_s, seed) in [0.2, 0.5, 1.0].into_iter().zip(70..) {
        let phases = normals(seed, 60);
        let swells: Vec<(f64, f64)> = (0..60)
            .map(|k| 1.0 / 15.0 + f64::from(k) / 60.0 * (1.0 / 11.0 - 1.0 / 15.0))
            .zip(&phases)
            .map(|(f, phase)| (f, 9.0 * phase))
            .collect();
        #[allow(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a count"
        )]
        let n = (7200.0 / step_s) as usize;
        let noise = normals(seed + 10, n);
        let series: Vec<f64> = (noise.iter().enumerate())
            .map(|(i, noise)| {
                let t = step_s * i as f64;
                let sine =
                    |s: &(f64, f64)| pa(0.03) * (std::f64::consts::TAU * s.0 * t + s.1).sin();
                2e6 + swells.iter().map(sine).sum::<f64>() + NOISE_PA * noise
            })
            .collect();
        let found = swell(&series, step_s, DENSITY).unwrap();
        assert!(found.ratio > found.believed, "{step_s}: {found:?}");
        assert!(
            (10.5..15.5).contains(&found.period_s),
            "{step_s}: {found:?}"
        );
    }
}

/// Two swells a tenth of a second apart beat over seventeen minutes: stretches of nine differ a lot.
#[test]
fn a_swell_in_groups_has_an_amplitude_that_is_less_certain() {
    let of = |other: f64| {
        let series = pressure(7200, 1.0, &[(0.3, 10.0), (0.3, other)]);
        swell(&series, 1.0, DENSITY).unwrap().amplitude_sd_m
    };
    let steady = swell(&pressure(7200, 1.0, &[(0.42, 10.0)]), 1.0, DENSITY);
    assert!(of(10.1) > 3.0 * steady.unwrap().amplitude_sd_m);
}

#[test]
fn evidence_is_that_of_exponential_powers_less_the_bins() {
    let by_hand = 1.86 * 14.0 * (3.0 - 1.0 - 3.0_f64.ln()) - 76.0_f64.ln();
    assert!((evidence_of(3.0, 14, 76) - by_hand).abs() < 1e-12);
    let found = swell(&pressure(7200, 1.0, &[(0.3, 10.0)]), 1.0, DENSITY).unwrap();
    assert!(
        found.evidence > found.hurdle && found.hurdle > 0.0,
        "{found:?}"
    );
    let none = swell(&pressure(7200, 1.0, &[]), 1.0, DENSITY).unwrap();
    assert!(none.evidence < none.hurdle, "{none:?}");
}

/// A sine of amplitude A in noise of deviation s stands, under Hann's window over m samples and the mean of three bins,
/// `A² m / 12 s²` above the floor: half of `(A m/4)²` over `3/8 m s²`. Its power is spread over `1/√3` bins of 1/512 Hz on
/// either side, and the means of 14 stretches know their middle by as much over `√14`.
#[test]
fn a_strong_swell_has_its_amplitude_period_and_power_whatever_the_clock() {
    for (step_s, period_s) in [
        (1.0, 10.0),
        (0.5, 7.3),
        (2.0, 13.1),
        (1.0, 5.4),
        (1.0, 18.0),
    ] {
        let n = (7200.0_f64 / step_s).round();
        let m = 512.0 / step_s - 1.0;
        #[allow(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a few thousand"
        )]
        let series = pressure(n as usize, step_s, &[(1.0, period_s)]);
        let found = swell(&series, step_s, DENSITY).unwrap();
        assert!((found.amplitude_m - 1.0).abs() < 0.02, "{found:?}");
        assert!(
            (found.period_s - period_s).abs() < found.period_sd_s,
            "{found:?}"
        );
        let sd = period_s * period_s / 512.0 / 42.0_f64.sqrt();
        assert!((found.period_sd_s / sd - 1.0).abs() < 0.05, "{found:?}");
        let ratio = (pa(1.0) / NOISE_PA).powi(2) * m / 12.0;
        assert!(
            (found.ratio / ratio - 1.0).abs() < 0.2,
            "{found:?} for {ratio}"
        );
    }
}

/// However many stretches there are, to a tenth of a bin.
#[test]
fn a_period_is_known_to_a_tenth_of_a_bin_at_best() {
    let found = swell(&pressure(50 * 512, 1.0, &[(1.0, 8.0)]), 1.0, DENSITY).unwrap();
    assert!(
        (found.period_sd_s - 64.0 / 5120.0).abs() < 1e-4,
        "{found:?}"
    );
}

#[test]
fn what_noise_adds_to_a_weak_swell_is_taken_off() {
    let found = swell(&pressure(57_600, 1.0, &[(0.05, 10.0)]), 1.0, DENSITY).unwrap();
    assert!((found.amplitude_m / 0.05 - 1.0).abs() < 0.08, "{found:?}");
}

#[test]
fn of_two_swells_the_stronger_is_told_by_itself() {
    for weaker in [6.0, 16.0] {
        let series = pressure(7200, 1.0, &[(0.5, 10.0), (0.25, weaker)]);
        let found = swell(&series, 1.0, DENSITY).unwrap();
        assert!((found.period_s - 10.0).abs() < 0.05, "{found:?}");
        assert!((found.amplitude_m / 0.5 - 1.0).abs() < 0.03, "{found:?}");
    }
}

#[test]
fn what_is_faster_than_five_seconds_or_slower_than_twenty_is_no_swell() {
    for period_s in [3.5, 40.0] {
        let found = swell(&pressure(7200, 1.0, &[(1.0, period_s)]), 1.0, DENSITY);
        assert!(
            found.is_err() || found.is_ok_and(|s| s.ratio < s.believed),
            "{period_s} s: {found:?}"
        );
    }
}

#[test]
fn stretches_that_are_stuck_or_have_gaps_tell_nothing_and_spikes_little() {
    let series = pressure(12 * 512, 1.0, &[(0.5, 10.0)]);
    let whole = swell(&series, 1.0, DENSITY).unwrap();
    let mut longer = series[..2048].to_vec();
    longer.extend([2e6; 512]);
    longer.extend(&series[..509]);
    longer.extend([f64::NAN; 3]);
    longer.extend(&series[2048..]);
    let same = swell(&longer, 1.0, DENSITY).unwrap();
    assert_eq!(format!("{same:?}"), format!("{whole:?}"));
    // A spike moves two rates, either way, by six times what is usual at the most.
    let mut spiked = series;
    for (k, value) in spiked.iter_mut().skip(99).step_by(512).enumerate() {
        *value += if k % 2 == 0 { 1e8 } else { -1e8 };
    }
    let found = swell(&spiked, 1.0, DENSITY).unwrap();
    assert!(
        (found.amplitude_m / whole.amplitude_m - 1.0).abs() < 0.1,
        "{found:?}"
    );
    assert!((found.period_s - 10.0).abs() < 0.1, "{found:?}");
}

/// Few samples, one or two at a time, are bridged; every seventh is too many, and three at a time are too long.
#[test]
fn few_missing_samples_do_not_hide_a_swell() {
    let series = pressure(12 * 512, 1.0, &[(0.5, 10.0)]);
    let whole = swell(&series, 1.0, DENSITY).unwrap();
    for (every, run, seen) in [
        (97, 1, true),
        (97, 2, true),
        (15, 1, true),
        (97, 3, false),
        (7, 1, false),
    ] {
        let mut holes = series.clone();
        for start in (0..holes.len() - run).step_by(every) {
            holes[start..start + run].fill(f64::NAN);
        }
        let found = swell(&holes, 1.0, DENSITY);
        if seen {
            let found = found.unwrap();
            assert!(found.ratio > 3.0 * found.believed, "{every} {found:?}");
            assert!((found.period_s - whole.period_s).abs() < 0.1);
            assert!(
                (found.amplitude_m / whole.amplitude_m - 1.0).abs() < 0.1,
                "{every} {found:?}"
            );
        } else {
            assert_eq!(found.err(), Some(Unseen::Short));
        }
    }
}

#[test]
fn six_stretches_are_enough_and_a_clock_of_six_seconds_for_a_long_swell() {
    let series = pressure(3072, 1.0, &[(0.5, 10.0)]);
    assert!(swell(&series, 1.0, DENSITY).is_ok());
    assert_eq!(
        swell(&series[..3071], 1.0, DENSITY).err(),
        Some(Unseen::Short)
    );
    let slow = pressure(2400, 6.0, &[(0.5, 16.0)]);
    let found = swell(&slow, 6.0, DENSITY).unwrap();
    // 85 samples last 510 s, and their bins are that much wider.
    assert!((found.period_s / 16.0 - 1.0).abs() < 1e-3, "{found:?}");
    assert_eq!(swell(&slow, 6.5, DENSITY).err(), Some(Unseen::Slow));
}

#[test]
fn a_swell_that_is_sampled_too_seldom_is_told_with_the_period_that_it_may_have() {
    let found = |step_s: f64, period_s: f64| {
        let series = pressure(3600, step_s, &[(0.5, period_s)]);
        swell(&series, step_s, DENSITY).unwrap()
    };
    // Every 5 s, 8 s look like 13.3 s, and the other way round.
    let folded = found(5.0, 8.0);
    let plain = found(5.0, 40.0 / 3.0);
    for one in [folded, plain] {
        assert!((one.period_s - 13.33).abs() < 0.1, "{one:?}");
        assert!((one.folded_s.unwrap() - 8.0).abs() < 0.05, "{one:?}");
    }
    assert_eq!(found(1.0, 8.0).folded_s, None);
    assert_eq!(found(2.0, 8.0).folded_s, None);
}

/// By their means: the power of a peak scatters by a third over the floor of 14 stretches.
#[test]
fn a_swell_above_its_limit_is_believed_whatever_its_period_and_one_far_below_is_not() {
    let nothing = swell(&pressure(7200, 1.0, &[]), 1.0, DENSITY).unwrap();
    // `A² m / 12 s²` above the floor; the highest of many floors stands somewhat above their mean.
    let above = nothing.believed - 1.0;
    let expected = (12.0 * above / 511.0).sqrt() * NOISE_PA / pa(1.0);
    let share = nothing.limit_m / expected;
    assert!((1.0..1.25).contains(&share), "{share}");
    for period_s in [6.3, 8.0, 10.1, 13.7, 18.0] {
        let found = |amplitude_m: f64| {
            let series = pressure(7200, 1.0, &[(amplitude_m, period_s)]);
            let s = swell(&series, 1.0, DENSITY).unwrap();
            s.ratio > s.believed
        };
        assert!(found(1.3 * nothing.limit_m), "{period_s}");
        assert!(!found(0.6 * nothing.limit_m), "{period_s}");
    }
}

/// A level that flows in and out move at random: its power falls with the square of the frequency, and nowhere stands out.
#[test]
fn a_level_that_wanders_is_no_swell_however_long_it_is_looked_at() {
    for hours in [3, 8, 24, 72] {
        let mut level = 2e6;
        let series: Vec<f64> = (normals(17, hours * 3600).iter())
            .map(|step| {
                level += NOISE_PA * step;
                level
            })
            .collect();
        let found = swell(&series, 1.0, DENSITY).unwrap();
        assert!(found.ratio < found.believed, "{hours} h: {found:?}");
        // Nor does it hide one.
        let swelling: Vec<f64> = (series.iter().enumerate())
            .map(|(i, p)| p + pa(0.3) * (std::f64::consts::TAU * i as f64 / 12.0).sin())
            .collect();
        let found = swell(&swelling, 1.0, DENSITY).unwrap();
        assert!(found.ratio > found.believed, "{hours} h: {found:?}");
        assert!((found.period_s - 12.0).abs() < 0.1, "{found:?}");
    }
}

#[test]
fn however_long_it_is_looked_at_a_swell_is_twice_its_surroundings() {
    let believed = |stretches: usize| {
        let series = pressure(stretches * 512, 1.0, &[]);
        swell(&series, 1.0, DENSITY).unwrap().believed
    };
    assert!(believed(6) > believed(14) && believed(14) > believed(40));
    assert_eq!(believed(100), 2.0);
}

/// Of 200 recordings of noise, of 6 to 50 stretches: the highest is that of noise about a floor that is known, and as much higher as few
/// stretches leave the floor unknown.
#[test]
fn of_noise_alone_nothing_is_believed_and_no_less_than_must_be() {
    for (stretches, beyond) in [(6, 1.25), (14, 1.1), (50, 1.1)] {
        let all = normals(9, 200 * stretches * 512);
        let highest = (all.chunks_exact(stretches * 512))
            .filter_map(|series| swell(series, 1.0, DENSITY).ok())
            .inspect(|s| assert!(s.ratio < s.believed, "{s:?}"))
            .map(|s| s.ratio)
            .fold(0.0, f64::max);
        // Bins of 5 to 20 s in stretches of 512 s.
        let most = highest_of_noise(stretches, 77);
        assert!(highest < beyond * most, "{stretches}: {highest} {most}");
        assert!(highest > 0.85 * most, "{stretches}: {highest} {most}");
    }
}
