use dgd_friction::{Loss, RobustOptions, RobustStatus, Terms, fit};

use crate::Recording;

#[test]
fn a_known_offset_cubic_law_is_recovered_through_gaps() {
    let law = |q: f64| 1.2e4 + 1.28e8 * q * q + 2.3e8 * q * q * q;
    let recording = Recording::new(6000, 9, law, 0.0).damaged();
    let found = fit(&recording.samples(), 9, &Terms::OffsetCubic, Loss::Squared).unwrap();
    for (power, truth) in [(0.0, 1.2e4), (2.0, 1.28e8), (3.0, 2.3e8)] {
        let c = found.law.coefficient(power).unwrap();
        assert!((c / truth - 1.0).abs() < 1e-9, "power {power}: {c}");
    }
    assert!((found.r2 - 1.0).abs() < 1e-12);
    assert!(found.n > 4000 && found.n < 6000);
}

#[test]
fn a_power_that_is_not_whole_is_recovered() {
    let recording = Recording::new(2000, 0, |q| 5e3 + 3e7 * q.powf(1.75), 0.0);
    let terms = Terms::Powers(vec![0.0, 1.75]);
    let found = fit(&recording.samples(), 0, &terms, Loss::Squared).unwrap();
    assert!((found.law.coefficient(1.75).unwrap() / 3e7 - 1.0).abs() < 1e-10);
}

#[test]
fn errors_are_the_size_their_standard_errors_say() {
    let recording = Recording::new(6000, 0, |q| 1e6 * q + 9.5e7 * q * q, 5e3);
    let found = fit(&recording.samples(), 0, &Terms::Quadratic, Loss::Squared).unwrap();
    // Uniform noise of ±5 kPa has a variance of 25/3 kPa².
    assert!((found.mse_pa2 / (25e6 / 3.0) - 1.0).abs() < 0.1);
    for (j, truth) in [1e6, 9.5e7].into_iter().enumerate() {
        let off = (found.law.coefficients[j] - truth).abs() / found.standard_errors[j];
        assert!(off < 3.5, "{off} standard errors");
        assert!(found.standard_errors[j] < 0.1 * truth);
    }
    assert_eq!(found.robust, None);
}

#[test]
fn reversing_flow_and_drop_leaves_the_law_unchanged() {
    let mut recording = Recording::new(3000, 4, |q| 1e6 * q + 9.5e7 * q * q, 5e3);
    let forth = fit(&recording.samples(), 4, &Terms::Quadratic, Loss::Squared).unwrap();
    for x in recording.flow.iter_mut().chain(&mut recording.friction) {
        *x = -*x;
    }
    let back = fit(&recording.samples(), 4, &Terms::Quadratic, Loss::Squared).unwrap();
    assert_eq!(forth, back);
}

#[test]
fn a_negative_delay_pairs_earlier_flow() {
    let recording = Recording::new(3000, -6, |q| 1e6 * q + 9.5e7 * q * q, 0.0);
    let found = fit(&recording.samples(), -6, &Terms::Quadratic, Loss::Squared).unwrap();
    assert!((found.law.coefficients[1] / 9.5e7 - 1.0).abs() < 1e-9);
    assert_eq!(found.n, 2994);
}

#[test]
fn spikes_move_least_squares_and_not_huber() {
    let mut recording = Recording::new(6000, 0, |q| 1e6 * q + 9.5e7 * q * q, 2e3);
    for f in recording.friction.iter_mut().step_by(20) {
        *f += 4e5;
    }
    let of = |loss| fit(&recording.samples(), 0, &Terms::Quadratic, loss).unwrap();
    let (plain, robust) = (of(Loss::Squared), of(Loss::Huber(RobustOptions::default())));
    let off = |c: &[f64]| (c[0] * 0.05 + c[1] * 0.0025 - (5e4 + 9.5e7 * 0.0025)).abs();
    assert!(off(&plain.law.coefficients) > 1e4);
    assert!(off(&robust.law.coefficients) < 500.0);
    let how = robust.robust.unwrap();
    assert_eq!(how.status, RobustStatus::Converged);
    assert!(how.weight_share > 0.93 && how.weight_share < 0.96);
    assert!(robust.r2 < plain.r2, "spikes cost the robust law squares");
}

#[test]
fn intervals_hold_the_truth_as_often_as_they_say() {
    const DRAWS: usize = 300;
    let truth = [1e6, 9.5e7];
    let mut held = [0; 2];
    for draw in 0..DRAWS {
        let mut recording = Recording::new(400, 0, |q| 1e6 * q + 9.5e7 * q * q, 0.0);
        for (i, friction) in recording.friction.iter_mut().enumerate() {
            *friction += 5e3 * crate::noise(i + 10_000 * draw);
        }
        let found = fit(&recording.samples(), 0, &Terms::Quadratic, Loss::Squared).unwrap();
        for j in 0..2 {
            let off = (found.law.coefficients[j] - truth[j]).abs() / found.standard_errors[j];
            held[j] += usize::from(off < 1.96);
        }
    }
    // Of 300 draws at 95 % the binomial gives fewer than 269 or more than 297 once in 5,000 times.
    for count in held {
        assert!((269..=297).contains(&count), "{held:?} of {DRAWS}");
    }
}

#[test]
fn the_order_of_samples_does_not_matter_without_a_delay() {
    let mut recording = Recording::new(3000, 0, |q| 1e6 * q + 9.5e7 * q * q, 5e3).damaged();
    let forth = fit(&recording.samples(), 0, &Terms::Quadratic, Loss::Squared).unwrap();
    recording.flow.reverse();
    recording.friction.reverse();
    recording.keep.reverse();
    let back = fit(&recording.samples(), 0, &Terms::Quadratic, Loss::Squared).unwrap();
    for (a, b) in forth.law.coefficients.iter().zip(&back.law.coefficients) {
        assert!((a / b - 1.0).abs() < 1e-10, "{a} {b}");
    }
    assert_eq!(forth.n, back.n);
}

/// Share of the variance about the mean that a law explains, and its mean squared error.
fn by_hand(recording: &Recording, found: &dgd_friction::PolynomialFit) -> (f64, f64) {
    let n = recording.friction.len() as f64;
    let mean = recording.friction.iter().sum::<f64>() / n;
    let (mut rss, mut total) = (0.0, 0.0);
    for (q, f) in recording.flow.iter().zip(&recording.friction) {
        rss += (f - found.law.eval(*q)).powi(2);
        total += (f - mean).powi(2);
    }
    let degrees = n - found.law.powers.len() as f64;
    (1.0 - rss / total, rss / degrees)
}

#[test]
fn r2_and_mse_are_those_of_the_law_that_is_reported_whatever_the_loss() {
    let mut recording = Recording::new(3000, 0, |q| 1e6 * q + 9.5e7 * q * q, 2e3);
    for f in recording.friction.iter_mut().step_by(20) {
        *f += 1e5;
    }
    for loss in [Loss::Squared, Loss::Huber(RobustOptions::default())] {
        let found = fit(&recording.samples(), 0, &Terms::Quadratic, loss).unwrap();
        let (r2, mse_pa2) = by_hand(&recording, &found);
        // Sums of 3000 squares.
        assert!((found.r2 - r2).abs() < 1e-11, "{} {r2}", found.r2);
        assert!((found.mse_pa2 / mse_pa2 - 1.0).abs() < 1e-11);
    }
}

#[test]
fn friction_that_a_law_meets_to_the_last_bit_is_wholly_explained_by_a_robust_fit_too() {
    // One sample flows: its row is met without rounding.
    let mut recording = Recording::new(300, 0, |_| 0.0, 0.0);
    recording.flow.fill(0.0);
    (recording.flow[7], recording.friction[7]) = (1.0, 64.0);
    let of = |loss| fit(&recording.samples(), 0, &Terms::Powers(vec![1.0]), loss).unwrap();
    let (plain, robust) = (of(Loss::Squared), of(Loss::Huber(RobustOptions::default())));
    assert_eq!((plain.mse_pa2, plain.r2), (0.0, 1.0));
    assert_eq!((robust.mse_pa2, robust.r2), (0.0, 1.0));
}
