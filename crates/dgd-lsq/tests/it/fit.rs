use dgd_lsq::{Accumulator, CONDITION_LIMIT, Fit};

use crate::noise;

/// Rows of a cubic in a flow in m³/s: columns of size 1, 1e-3 and 1e-5.
fn cubic(rows: u32, truth: [f64; 3], sigma: f64) -> Vec<([f64; 3], f64)> {
    (0..rows)
        .map(|i| {
            let q = 0.02 + 0.05 * f64::from(i % 997) / 997.0;
            let row = [1.0, q * q, q * q * q];
            let y: f64 = row.iter().zip(truth).map(|(x, c)| x * c).sum();
            (row, y + sigma * noise(i))
        })
        .collect()
}

fn fit(rows: &[([f64; 3], f64)]) -> Fit {
    let mut all = Accumulator::new(["B", "D", "E"]).unwrap();
    for (row, y) in rows {
        all.push(row, *y).unwrap();
    }
    all.finish().unwrap()
}

#[test]
fn a_known_truth_in_si_units_is_recovered() {
    let truth = [2e4, 9e7, -3e8];
    let found = fit(&cubic(5000, truth, 0.0));
    for (c, t) in found.coefficients.iter().zip(truth) {
        assert!((c / t - 1.0).abs() < 1e-10, "{c} is not {t}");
    }
    assert!(found.condition < 100.0, "scaled, the columns are benign");
    assert!((found.r2 - 1.0).abs() < 1e-12);
}

#[test]
fn statistics_match_the_closed_form_of_a_line() {
    // Closed form of a straight line through (1,1) (2,2) (3,2) (4,5): slope 1.2, intercept -0.5,
    // rss 1.8, mse 0.9, var(slope) = mse/5, var(intercept) = mse·30/(4·5), cov = -mse·10/(4·5).
    let mut line = Accumulator::new(["1", "x"]).unwrap();
    for (x, y) in [(1.0, 1.0), (2.0, 2.0), (3.0, 2.0), (4.0, 5.0)] {
        line.push(&[1.0, x], y).unwrap();
    }
    let found = line.finish().unwrap();
    let close = |a: f64, b: f64| assert!((a - b).abs() < 1e-12, "{a} is not {b}");
    close(found.coefficients[0], -0.5);
    close(found.coefficients[1], 1.2);
    close(found.rss, 1.8);
    close(found.mse, 0.9);
    close(found.standard_errors[1], (0.9_f64 / 5.0).sqrt());
    close(found.standard_errors[0], (0.9_f64 * 1.5).sqrt());
    close(found.covariance[1], -0.45);
    close(found.covariance[1], found.covariance[2]);
    close(found.r2, 1.0 - 1.8 / 9.0);
    assert_eq!(found.n, 4);
    close(found.predict(&[1.0, 5.0]), 5.5);
}

#[test]
fn standard_errors_cover_the_truth_as_often_as_they_say() {
    let truth = [2e4, 9e7, -3e8];
    let runs = 400;
    let mut covered = 0;
    for run in 0..runs {
        let mut rows = cubic(200, truth, 0.0);
        for (i, (_, y)) in rows.iter_mut().enumerate() {
            *y += 1e3 * noise(run * 1000 + u32::try_from(i).unwrap());
        }
        let found = fit(&rows);
        covered += u32::from((found.coefficients[1] - truth[1]).abs() < found.standard_errors[1]);
    }
    // One sigma holds 68 %; 400 runs scatter by 2.3 %.
    let share = f64::from(covered) / f64::from(runs);
    assert!((share - 0.683).abs() < 0.07, "one sigma covers {share}");
}

#[test]
fn rescaling_a_column_rescales_its_coefficient_only() {
    let rows = cubic(1000, [2e4, 9e7, -3e8], 500.0);
    let plain = fit(&rows);
    let scaled: Vec<_> = rows
        .iter()
        .map(|([a, b, c], y)| ([*a, b * 1e60, *c], *y))
        .collect();
    let scaled = fit(&scaled);
    for j in [0, 2] {
        assert!((scaled.coefficients[j] / plain.coefficients[j] - 1.0).abs() < 1e-9);
    }
    assert!((scaled.coefficients[1] * 1e60 / plain.coefficients[1] - 1.0).abs() < 1e-9);
    assert!((scaled.standard_errors[1] * 1e60 / plain.standard_errors[1] - 1.0).abs() < 1e-9);
    assert!((scaled.condition / plain.condition - 1.0).abs() < 1e-9);
    assert!((scaled.mse / plain.mse - 1.0).abs() < 1e-9);
}

#[test]
fn an_integer_weight_is_a_row_repeated() {
    let rows = cubic(300, [2e4, 9e7, -3e8], 500.0);
    let mut weighted = Accumulator::new(["B", "D", "E"]).unwrap();
    let mut repeated = weighted.clone();
    for (i, (row, y)) in rows.iter().enumerate() {
        let times = i % 4;
        weighted.push_weighted(row, *y, times as f64).unwrap();
        for _ in 0..times {
            repeated.push(row, *y).unwrap();
        }
    }
    let (weighted, repeated) = (weighted.finish().unwrap(), repeated.finish().unwrap());
    assert_eq!(weighted.n, 225, "rows of weight 0 are not counted");
    assert_eq!(repeated.n, 450);
    assert!((weighted.rss / repeated.rss - 1.0).abs() < 1e-10);
    assert!((weighted.r2 - repeated.r2).abs() < 1e-12);
    for (a, b) in weighted.coefficients.iter().zip(&repeated.coefficients) {
        assert!((a / b - 1.0).abs() < 1e-9);
    }
}

#[test]
fn merged_halves_are_the_whole() {
    let rows = cubic(1111, [2e4, 9e7, -3e8], 500.0);
    let whole = fit(&rows);
    let mut first = Accumulator::new(["B", "D", "E"]).unwrap();
    let mut second = first.clone();
    for (i, (row, y)) in rows.iter().enumerate() {
        let half = if i < 400 { &mut first } else { &mut second };
        half.push(row, *y).unwrap();
    }
    first.merge(second).unwrap();
    assert_eq!(first.rows(), 1111);
    let merged = first.finish().unwrap();
    assert!((merged.mse / whole.mse - 1.0).abs() < 1e-11);
    assert!((merged.r2 - whole.r2).abs() < 1e-12);
    for (a, b) in merged.coefficients.iter().zip(&whole.coefficients) {
        assert!((a / b - 1.0).abs() < 1e-9);
    }
}

#[test]
fn columns_are_rows_pushed_one_by_one() {
    let rows = cubic(1111, [2e4, 9e7, -3e8], 500.0);
    let column = |j: usize| rows.iter().map(|(row, _)| row[j]).collect::<Vec<_>>();
    let y: Vec<f64> = rows.iter().map(|(_, y)| *y).collect();
    let (a, b, c) = (column(0), column(1), column(2));
    let mut together = Accumulator::new(["B", "D", "E"]).unwrap();
    for (from, to) in [(0, 100), (100, 100), (100, 900), (900, 1111)] {
        together
            .push_columns(&[&a[from..to], &b[from..to], &c[from..to]], &y[from..to])
            .unwrap();
    }
    assert_eq!(together.finish().unwrap(), fit(&rows));
}

#[test]
fn the_same_rows_give_the_same_bytes() {
    let rows = cubic(777, [2e4, 9e7, -3e8], 500.0);
    assert_eq!(fit(&rows), fit(&rows));
}

#[test]
fn residuals_are_orthogonal_to_every_column() {
    let rows = cubic(2000, [2e4, 9e7, -3e8], 500.0);
    let found = fit(&rows);
    for j in 0..3 {
        let (mut sum, mut size) = (0.0, 0.0);
        for (row, y) in &rows {
            let term = row[j] * (y - found.predict(row));
            sum += term;
            size += term.abs();
        }
        assert!(sum.abs() < 1e-9 * size, "column {j}: {sum} of {size}");
    }
}

#[test]
fn without_a_constant_r2_is_still_about_the_mean_and_may_be_negative() {
    let mut rows = Accumulator::new(["x"]).unwrap();
    for (x, y) in [(1.0, 10.0), (2.0, 9.0), (3.0, 8.0), (4.0, 7.0)] {
        rows.push(&[x], y).unwrap();
    }
    assert!(rows.finish().unwrap().r2 < 0.0);
}

#[test]
fn holding_a_coefficient_at_its_estimate_changes_no_other() {
    let rows = cubic(900, [2e4, 9e7, -3e8], 500.0);
    let mut all = Accumulator::new(["B", "D", "E"]).unwrap();
    for (row, y) in &rows {
        all.push(row, *y).unwrap();
    }
    let reduced = all.reduce();
    let free = reduced.solve(CONDITION_LIMIT).unwrap();
    let held = reduced
        .hold(&[(1, free.coefficients[1])])
        .unwrap()
        .solve(CONDITION_LIMIT)
        .unwrap();
    assert_eq!(held.names, ["B", "E"]);
    assert!((held.coefficients[0] / free.coefficients[0] - 1.0).abs() < 1e-9);
    assert!((held.coefficients[1] / free.coefficients[2] - 1.0).abs() < 1e-9);
    assert!((held.rss / free.rss - 1.0).abs() < 1e-11);
    assert!((held.r2 - free.r2).abs() < 1e-11);
}

mod property {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn adding_a_multiple_of_a_column_to_y_shifts_its_coefficient(
            shift in -1e3..1e3_f64, column in 0..3_usize, rows in 4..600_u32,
        ) {
            let base: Vec<_> = (0..rows)
                .map(|i| ([1.0, noise(i), noise(i + 10_000)], noise(i + 20_000)))
                .collect();
            let moved: Vec<_> = base.iter().map(|(row, y)| (*row, y + shift * row[column])).collect();
            // Four rows may leave the three columns nearly dependent; that is refused elsewhere.
            let (a, b) = (fit(&base), fit(&moved));
            prop_assume!(a.condition < 1e3);
            for j in 0..3 {
                let expected = a.coefficients[j] + if j == column { shift } else { 0.0 };
                prop_assert!((b.coefficients[j] - expected).abs() < 1e-8 * (1.0 + shift.abs()));
            }
        }
    }
}

#[test]
fn the_order_of_rows_and_the_unit_of_y_do_not_matter() {
    let rows = cubic(1000, [2e4, 9e7, -3e8], 500.0);
    let plain = fit(&rows);
    let mut mixed: Vec<_> = rows
        .iter()
        .map(|(row, y)| (*row, y / 6_894.757_29))
        .collect();
    mixed.reverse();
    mixed.rotate_left(317);
    let mixed = fit(&mixed);
    for j in 0..3 {
        let ratio = plain.coefficients[j] / mixed.coefficients[j];
        assert!((ratio / 6_894.757_29 - 1.0).abs() < 1e-9, "{ratio}");
        let ratio = plain.standard_errors[j] / mixed.standard_errors[j];
        assert!((ratio / 6_894.757_29 - 1.0).abs() < 1e-9, "{ratio}");
    }
}

/// What rounding leaves of equal observations is no variance to be explained.
#[test]
fn observations_that_are_all_the_same_have_no_share_explained() {
    for (y, n) in [(1e5 / 3.0, 1000), (0.1, 5000)] {
        let mut sums = dgd_lsq::Accumulator::new(["1", "x"]).unwrap();
        for i in 0..n {
            sums.push(&[1.0, f64::from(i % 17)], y).unwrap();
        }
        assert!(sums.finish().unwrap().r2.is_nan());
    }
    let mut sums = dgd_lsq::Accumulator::new(["1", "x"]).unwrap();
    for i in 0..1000 {
        sums.push(&[1.0, f64::from(i % 17)], 1e5 + 1e-6 * f64::from(i % 17))
            .unwrap();
    }
    assert!(sums.finish().unwrap().r2 > 0.9);
}
