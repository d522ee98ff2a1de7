use dgd_lsq::{LsqError, RobustOptions, RobustStatus, fit_robust};

use crate::noise;

type Visit<'a> = dyn FnMut(&[f64], f64) + 'a;

/// y = 3 + 2x with noise of ±0.5 and every tenth row lifted by `outlier`.
fn rows(outlier: f64) -> impl Fn(&mut Visit) {
    move |visit| {
        for i in 0..2000_u32 {
            let x = f64::from(i % 100) / 10.0;
            let lift = if i % 10 == 3 { outlier } else { 0.0 };
            visit(&[1.0, x], 3.0 + 2.0 * x + 0.5 * noise(i) + lift);
        }
    }
}

#[test]
fn outliers_move_least_squares_and_not_huber() {
    let fit = fit_robust(["1", "x"], rows(50.0), &RobustOptions::default()).unwrap();
    assert_eq!(fit.status, RobustStatus::Converged);
    assert!((fit.least_squares.coefficients[0] - 3.0).abs() > 2.0);
    assert!((fit.coefficients[0] - 3.0).abs() < 0.15, "{fit:?}");
    assert!((fit.coefficients[1] - 2.0).abs() < 0.03, "{fit:?}");
    assert!(
        fit.weight_share > 0.88 && fit.weight_share < 0.92,
        "{fit:?}"
    );
    assert!(fit.iterations > 1);
}

#[test]
fn clean_rows_give_the_least_squares_answer_and_its_errors() {
    let fit = fit_robust(["1", "x"], rows(0.0), &RobustOptions::default()).unwrap();
    for (a, b) in fit
        .standard_errors
        .iter()
        .zip(&fit.least_squares.standard_errors)
    {
        assert!((a / b - 1.0).abs() < 0.15, "{a} against {b}");
    }
    for (j, c) in fit.coefficients.iter().enumerate() {
        let ls = &fit.least_squares;
        assert!((c - ls.coefficients[j]).abs() < ls.standard_errors[j]);
    }
}

#[test]
fn negating_y_negates_the_robust_fit() {
    let plain = fit_robust(["1", "x"], rows(50.0), &RobustOptions::default()).unwrap();
    let original = rows(50.0);
    let mirrored = fit_robust(
        ["1", "x"],
        |visit| original(&mut |row, y| visit(row, -y)),
        &RobustOptions::default(),
    )
    .unwrap();
    for (a, b) in plain.coefficients.iter().zip(&mirrored.coefficients) {
        assert!((a + b).abs() < 1e-9);
    }
}

#[test]
fn the_iteration_limit_is_reported() {
    let options = RobustOptions {
        max_iterations: 1,
        ..RobustOptions::default()
    };
    let fit = fit_robust(["1", "x"], rows(50.0), &options).unwrap();
    assert_eq!(fit.status, RobustStatus::IterationLimit);
    assert_eq!(fit.iterations, 1);
}

#[test]
fn a_majority_of_exact_rows_has_no_scale() {
    let fit = fit_robust(
        ["x"],
        |visit| (1..=9).for_each(|i| visit(&[f64::from(i)], 2.0 * f64::from(i))),
        &RobustOptions::default(),
    )
    .unwrap();
    assert_eq!(fit.status, RobustStatus::ZeroScale);
    assert_eq!(fit.coefficients, [2.0]);
}

/// A coarse reading that rests: most residuals meet one value, and their median says nothing of the rest.
#[test]
fn a_scale_that_shrinks_to_nothing_is_told_and_has_no_errors() {
    let coarse = |visit: &mut dyn FnMut(&[f64], f64)| {
        for i in 0..1000 {
            let x = if i % 4 == 0 { f64::from(i % 37) } else { 0.0 };
            visit(&[1.0, x], (x / 10.0).round());
        }
    };
    let fit = fit_robust(["1", "x"], coarse, &RobustOptions::default()).unwrap();
    assert_eq!(fit.status, RobustStatus::ZeroScale);
    assert!(fit.standard_errors.iter().all(|e| e.is_nan()), "{fit:?}");
    assert!(fit.least_squares.standard_errors[1] > 1e-4);
}

/// Of an even number the median is the mean of the two in the middle.
#[test]
fn the_scale_is_the_median_of_even_and_odd_numbers_of_rows() {
    let of = |deviations: &[f64]| {
        let rows = |visit: &mut Visit| {
            deviations.iter().for_each(|d| {
                visit(&[1.0], 10.0 + d);
                visit(&[1.0], 10.0 - d);
            });
        };
        let fit = fit_robust(["1"], rows, &RobustOptions::default()).unwrap();
        assert!((fit.coefficients[0] - 10.0).abs() < 1e-12);
        fit.scale * 0.674_489_750_196_081_7
    };
    // Each twice: of 4 the middle two are 1 and 2, of 6 both are 2.
    assert!((of(&[1.0, 2.0]) - 1.5).abs() < 1e-12);
    assert!((of(&[1.0, 2.0, 4.0]) - 2.0).abs() < 1e-12);
}

#[test]
fn without_a_residual_inside_errors_are_infinite_and_far_fewer_scales_are_refused() {
    let rows = |visit: &mut Visit| {
        [-1.0, 1.0, -2.0, 2.0]
            .iter()
            .for_each(|y| visit(&[1.0], *y))
    };
    let with = |k| {
        let options = RobustOptions {
            k,
            ..RobustOptions::default()
        };
        fit_robust(["1"], rows, &options)
    };
    assert_eq!(with(0.1).unwrap().standard_errors[0], f64::INFINITY);
    assert!(with(1.345).unwrap().standard_errors[0] > 0.0);
    let refused = with(1e-300).unwrap_err();
    assert!(
        matches!(refused, LsqError::Option { name: "k", .. }),
        "{refused}"
    );
}
