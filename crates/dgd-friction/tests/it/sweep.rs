use dgd_friction::{
    Loss, Minimum, RobustOptions, Samples, SweepOptions, Terms, delay_scan, delay_sweep, fit,
};

use crate::Recording;

fn quadratic(q: f64) -> f64 {
    1e6 * q + 9.5e7 * q * q
}

fn over(delays: std::ops::RangeInclusive<i64>) -> SweepOptions {
    SweepOptions {
        delays,
        ..SweepOptions::default()
    }
}

#[test]
fn a_meter_that_is_dead_at_some_delays_is_fitted_at_the_others() {
    let mut recording = Recording::new(200, 13, quadratic, 3e3);
    recording.keep = (0..200).map(|i| i < 60).collect();
    recording.flow[..60].fill(f64::NAN);
    let samples = recording.samples();
    let sweep = delay_sweep(&samples, &Terms::Quadratic, &over(0..=80)).unwrap();
    assert!(sweep.mse_pa2[0].is_nan() && sweep.n[0] == 0);
    assert!(sweep.mse_pa2[80].is_finite() && sweep.n[80] == 60);
    let exact = fit(&samples, 80, &Terms::Quadratic, Loss::Squared).unwrap();
    assert!((sweep.mse_pa2[80] / exact.mse_pa2 - 1.0).abs() < 1e-9);
    // Dead throughout, it is refused as the fit at the delay nearest 0 is.
    recording.flow.fill(f64::NAN);
    let refused = delay_sweep(&recording.samples(), &Terms::Quadratic, &over(0..=80));
    let at_rest = fit(&recording.samples(), 0, &Terms::Quadratic, Loss::Squared);
    assert_eq!(refused.unwrap_err(), at_rest.unwrap_err());
}

/// A delay as long as the recording leaves a dozen rows, and by a dozen rows any law fits.
#[test]
fn a_delay_with_fewer_than_half_of_the_rows_is_not_told() {
    for (samples, last) in [(600, 590), (120, 100)] {
        let recording = Recording::new(samples, 13, quadratic, 3e3);
        let sweep = delay_sweep(&recording.samples(), &Terms::Quadratic, &over(0..=last)).unwrap();
        assert_eq!(sweep.delays_s[sweep.best], 13.0, "of {samples}");
        let most = *sweep.n.iter().max().unwrap();
        for (n, mse) in sweep.n.iter().zip(&sweep.mse_pa2) {
            assert_eq!(mse.is_nan(), 2 * n < most, "{n} of {most}");
        }
    }
}

#[test]
fn a_scan_is_fitted_on_its_own_samples() {
    let recording = Recording::new(400, 13, quadratic, 3e3);
    let scan = delay_scan(&recording.samples(), &Terms::Quadratic, &over(0..=20)).unwrap();
    let other = Recording::new(390, 13, quadratic, 3e3);
    let refused = scan.clone().fit(&other.samples()).unwrap_err();
    assert!(
        refused.to_string().contains("samples at the best delay"),
        "{refused}"
    );
    assert!(scan.fit(&recording.samples()).is_ok());
}

#[test]
fn every_delay_agrees_with_its_own_qr_fit() {
    // Some samples beyond whole blocks: of the early ones delays of -120 and less use none.
    let recording = Recording::new(4160, 13, quadratic, 3e3).damaged();
    let all = [
        Terms::Quadratic,
        Terms::OffsetCubic,
        Terms::Powers(vec![1.75]),
        Terms::Powers(vec![0.0, 1.0, 2.0, 3.0]),
    ];
    for keep_delayed in [false, true] {
        let samples = Samples {
            keep_delayed,
            ..recording.samples()
        };
        for terms in &all {
            let ranges = [
                0..=30,
                -20..=25,
                5..=22,
                -40..=-3,
                7..=7,
                -130..=130,
                -150..=-120,
                120..=150,
            ];
            for delays in ranges {
                let first = *delays.start();
                let sweep = delay_sweep(&samples, terms, &over(delays)).unwrap();
                for (d, mse) in sweep.mse_pa2.iter().enumerate() {
                    let delay = first + i64::try_from(d).unwrap();
                    let exact = fit(&samples, delay, terms, Loss::Squared).unwrap();
                    assert_eq!(sweep.n[d], exact.n, "{terms:?} at {delay}");
                    assert!(
                        (mse / exact.mse_pa2 - 1.0).abs() < 1e-9,
                        "{terms:?} at {delay}: {mse} against {}",
                        exact.mse_pa2
                    );
                }
                let least = sweep.mse_pa2.iter().copied().fold(f64::INFINITY, f64::min);
                assert_eq!(sweep.mse_pa2[sweep.best], least);
                let at_best = fit(&samples, sweep.best_delay_samples, terms, Loss::Squared);
                assert_eq!(sweep.fit, at_best.unwrap());
            }
        }
    }
}

#[test]
fn a_known_delay_is_found_inside_the_range() {
    for delay in [-7, 0, 13] {
        let recording = Recording::new(5000, delay, quadratic, 3e3).damaged();
        let sweep = delay_sweep(&recording.samples(), &Terms::Quadratic, &over(-20..=30)).unwrap();
        assert_eq!(sweep.best_delay_samples, delay);
        assert_eq!(sweep.minimum, Minimum::Interior);
        let delay = f64::from(i32::try_from(delay).unwrap());
        assert!((sweep.refined_delay_s - delay).abs() < 0.2);
    }
}

#[test]
fn a_delay_between_samples_is_refined() {
    // Flow sampled at 2 Hz while the true delay is 6.5 samples: every second sample of a finer record.
    let fine = Recording::new(10_000, 13, quadratic, 0.0);
    let half = |x: &[f64]| x.iter().copied().step_by(2).collect::<Vec<_>>();
    let coarse = Recording {
        flow: half(&fine.flow),
        friction: half(&fine.friction),
        keep: vec![true; 5000],
    };
    let options = SweepOptions {
        dt_s: 2.0,
        ..SweepOptions::default()
    };
    let sweep = delay_sweep(&coarse.samples(), &Terms::Quadratic, &options).unwrap();
    assert!(
        (sweep.refined_delay_s - 13.0).abs() < 0.25,
        "{}",
        sweep.refined_delay_s
    );
    assert_eq!(sweep.delays_s[3], 6.0);
}

#[test]
fn a_minimum_at_the_edge_is_reported() {
    let recording = Recording::new(5000, 13, quadratic, 3e3);
    let edge = |delays| {
        delay_sweep(&recording.samples(), &Terms::Quadratic, &over(delays))
            .unwrap()
            .minimum
    };
    assert_eq!(edge(0..=10), Minimum::AtLast);
    assert_eq!(edge(15..=20), Minimum::AtFirst);
}

#[test]
fn shifting_the_meter_shifts_the_answer() {
    let law = |q: f64| 1e4 + 1.2e8 * q * q + 1e8 * q * q * q;
    let at = |delay| {
        let recording = Recording::new(5000, delay, law, 3e3);
        delay_sweep(&recording.samples(), &Terms::OffsetCubic, &over(0..=30))
            .unwrap()
            .best_delay_samples
    };
    assert_eq!(at(4) + 9, at(13));
}

#[test]
fn the_same_recording_gives_the_same_bytes() {
    let recording = Recording::new(5000, 13, quadratic, 3e3).damaged();
    let sweep = || delay_sweep(&recording.samples(), &Terms::OffsetCubic, &over(-5..=30)).unwrap();
    assert_eq!(sweep(), sweep());
}

#[test]
fn excitation_that_a_thinned_basis_misses_is_still_used() {
    // Flow stands still but for one sample in sixteen, never one that the basis looks at first.
    let mut recording = Recording::new(8000, 0, quadratic, 0.0);
    for (i, q) in recording.flow.iter_mut().enumerate() {
        *q = if i % 16 == 5 { *q } else { 0.05 };
        recording.friction[i] = quadratic(*q);
    }
    let sweep = delay_sweep(&recording.samples(), &Terms::Quadratic, &over(0..=5)).unwrap();
    assert_eq!(sweep.best_delay_samples, 0);
    assert!((sweep.fit.law.coefficients[1] / 9.5e7 - 1.0).abs() < 1e-9);
}

#[test]
fn recordings_longer_than_one_sum_agree_too() {
    // The sums are taken in chunks of some thousand samples.
    let recording = Recording::new(20_000, 13, quadratic, 3e3);
    let sweep = delay_sweep(&recording.samples(), &Terms::Quadratic, &over(10..=16)).unwrap();
    for (d, mse) in (10..).zip(&sweep.mse_pa2) {
        let exact = fit(&recording.samples(), d, &Terms::Quadratic, Loss::Squared).unwrap();
        assert!((mse / exact.mse_pa2 - 1.0).abs() < 1e-9, "at {d}");
    }
}

#[test]
fn a_delay_without_rows_to_spare_has_no_error_and_is_told_beside_the_best() {
    // Two kept samples, whose flow is known for delays up to 1 and for one of them at 2.
    let mut recording = Recording::new(40, 0, |q| 3e7 * q.powf(1.75), 10.0);
    recording.keep.fill(false);
    recording.keep[10] = true;
    recording.keep[12] = true;
    recording.flow[14] = f64::NAN;
    // One row is met by the law to rounding, whichever way that falls.
    for more in 0..20 {
        recording.friction[10] += f64::from(more);
        let terms = Terms::Powers(vec![1.75]);
        let sweep = delay_sweep(&recording.samples(), &terms, &over(-2..=2)).unwrap();
        assert_eq!(sweep.n, [2, 2, 2, 2, 1]);
        assert!(sweep.mse_pa2[..4].iter().all(|mse| mse.is_finite()));
        assert!(sweep.mse_pa2[4].is_nan(), "{:?}", sweep.mse_pa2);
    }
}

#[test]
fn a_delay_at_which_the_flow_rests_has_no_error_as_the_fit_there_is_refused() {
    // The kept samples meet moving flow at delay 0 and flow at rest but for `share` from delay 40.
    for share in [0.0, 3e-6, 1e-5, 3e-5] {
        let mut recording = Recording::new(400, 0, quadratic, 3e3);
        recording.keep.fill(false);
        recording.keep[100..140].fill(true);
        for i in 140..220 {
            recording.flow[i] = 0.05 * (1.0 + share * crate::noise(i));
        }
        let samples = recording.samples();
        let sweep = delay_sweep(&samples, &Terms::Quadratic, &over(0..=60)).unwrap();
        for (d, mse) in (0..).zip(&sweep.mse_pa2) {
            let exact = fit(&samples, d, &Terms::Quadratic, Loss::Squared);
            assert_eq!(mse.is_nan(), exact.is_err(), "{share} at {d}: {exact:?}");
        }
        assert!(sweep.mse_pa2[40..].iter().all(|mse| mse.is_nan()));
        assert_eq!(sweep.n, [40; 61]);
    }
}

#[test]
fn of_equal_errors_the_earliest_delay_is_the_best() {
    // A flow that repeats every 8 samples fits alike 8 samples later.
    let mut recording = Recording::new(800, 0, quadratic, 0.0);
    let wave = [0.02, 0.03, 0.05, 0.06, 0.055, 0.04, 0.035, 0.025];
    for i in 0..800 {
        recording.flow[i] = wave[i % 8];
        recording.friction[i] = quadratic(wave[(i + 5) % 8]);
        recording.keep[i] = (100..700).contains(&i);
    }
    let sweep = delay_sweep(&recording.samples(), &Terms::Quadratic, &over(0..=20)).unwrap();
    assert_eq!(sweep.n, [600; 21]);
    let least = sweep.mse_pa2[sweep.best];
    let first = sweep.mse_pa2.iter().position(|mse| *mse == least);
    assert_eq!(first, Some(sweep.best));
    assert!(sweep.best == 5 || sweep.best == 13, "{:?}", sweep.mse_pa2);
}

/// Sums of squares a hundred million times the error: an offset of 2e7 Pa and a noise of 2 kPa.
#[test]
fn a_large_offset_does_not_round_the_error_away() {
    let law = |q: f64| 2e7 + 1.2e8 * q * q;
    let recording = Recording::new(5000, 13, law, 3e3).damaged();
    let samples = recording.samples();
    let sweep = delay_sweep(&samples, &Terms::OffsetCubic, &over(0..=30)).unwrap();
    assert_eq!(sweep.best_delay_samples, 13);
    for (delay, mse) in (0..).zip(&sweep.mse_pa2) {
        let exact = fit(&samples, delay, &Terms::OffsetCubic, Loss::Squared).unwrap();
        assert!((mse / exact.mse_pa2 - 1.0).abs() < 1e-9, "{delay}: {mse}");
    }
}

/// Next to no error beside much friction: what the sums leave is rounding, and the rows tell.
#[test]
fn the_error_at_the_best_delay_is_that_of_the_rows_and_the_others_are_rounded_to_the_squares() {
    let recording = Recording::new(5000, 13, quadratic, 1e-4);
    let samples = recording.samples();
    let squares = recording.friction.iter().map(|f| f * f).sum::<f64>() / 5000.0;
    let exact = |delay| fit(&samples, delay, &Terms::Quadratic, Loss::Squared).unwrap();
    for loss in [Loss::Squared, Loss::Huber(RobustOptions::default())] {
        let options = SweepOptions {
            loss,
            ..SweepOptions::default()
        };
        let sweep = delay_sweep(&samples, &Terms::Quadratic, &options).unwrap();
        assert_eq!(sweep.best_delay_samples, 13);
        assert_eq!(sweep.mse_pa2[13], exact(13).mse_pa2);
        for (delay, mse) in (0..).zip(&sweep.mse_pa2) {
            assert!((mse - exact(delay).mse_pa2).abs() < 1e-12 * squares);
        }
    }
}
