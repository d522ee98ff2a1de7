use dgd_lsq::{Accumulator, LsqError, MAX_COLUMNS, RobustOptions, fit_robust};

#[test]
fn dependent_columns_are_named_and_the_innocent_one_is_not() {
    let mut rows = Accumulator::new(["1", "q", "2q"]).unwrap();
    for i in 0..100_u32 {
        let q = f64::from(i) * 1e-4;
        rows.push(&[1.0, q, 2.0 * q], q).unwrap();
    }
    match rows.finish() {
        Err(LsqError::NotExcited {
            columns,
            condition,
            limit,
        }) => {
            assert_eq!(columns, ["q", "2q"]);
            assert!(condition > limit);
        }
        other => panic!("{other:?}"),
    }
}

#[test]
fn a_column_of_zeros_is_named() {
    let mut rows = Accumulator::new(["1", "q"]).unwrap();
    for _ in 0..5 {
        rows.push(&[1.0, 0.0], 1.0).unwrap();
    }
    match rows.finish() {
        Err(LsqError::NotExcited {
            columns, condition, ..
        }) => {
            assert_eq!(columns, ["q"]);
            assert_eq!(condition, f64::INFINITY);
        }
        other => panic!("{other:?}"),
    }
}

#[test]
fn a_stricter_limit_refuses_what_the_default_allows() {
    let mut rows = Accumulator::new(["1", "q"]).unwrap();
    for i in 0..100_u32 {
        rows.push(&[1.0, 10.0 + f64::from(i % 2)], f64::from(i))
            .unwrap();
    }
    let rows = rows.reduce();
    let condition = rows.solve(1e10).unwrap().condition;
    assert!((20.0..100.0).contains(&condition), "{condition}");
    assert!(matches!(
        rows.solve(10.0),
        Err(LsqError::NotExcited { limit: 10.0, .. })
    ));
}

#[test]
fn a_nan_is_refused_with_its_row_and_column() {
    let mut rows = Accumulator::new(["1", "q"]).unwrap();
    rows.push(&[1.0, 2.0], 3.0).unwrap();
    assert_eq!(
        rows.push(&[1.0, f64::NAN], 3.0),
        Err(LsqError::NonFinite {
            index: 1,
            column: "q".to_owned()
        })
    );
    assert_eq!(
        rows.push(&[1.0, 1.0], f64::INFINITY),
        Err(LsqError::NonFinite {
            index: 1,
            column: "y".to_owned()
        })
    );
    assert_eq!(rows.rows(), 1);
}

#[test]
fn a_row_of_the_wrong_width_is_refused() {
    let mut rows = Accumulator::new(["1", "q"]).unwrap();
    assert_eq!(
        rows.push(&[1.0], 3.0),
        Err(LsqError::Width {
            index: 0,
            found: 1,
            expected: 2
        })
    );
}

#[test]
fn a_negative_weight_is_refused() {
    let mut rows = Accumulator::new(["1"]).unwrap();
    assert_eq!(
        rows.push_weighted(&[1.0], 1.0, -0.5),
        Err(LsqError::Weight {
            index: 0,
            weight: -0.5
        })
    );
}

#[test]
fn as_many_rows_as_columns_leave_no_residual() {
    let mut rows = Accumulator::new(["1", "q"]).unwrap();
    rows.push(&[1.0, 2.0], 3.0).unwrap();
    rows.push(&[1.0, 3.0], 3.0).unwrap();
    assert_eq!(
        rows.finish(),
        Err(LsqError::TooFewRows {
            found: 2,
            columns: 2
        })
    );
}

#[test]
fn no_column_and_too_many_are_refused() {
    assert!(matches!(
        Accumulator::new(Vec::<String>::new()),
        Err(LsqError::Columns { found: 0, .. })
    ));
    assert!(matches!(
        Accumulator::new((0..=MAX_COLUMNS).map(|i| i.to_string())),
        Err(LsqError::Columns { .. })
    ));
}

#[test]
fn unlike_columns_do_not_merge() {
    let mut a = Accumulator::new(["1"]).unwrap();
    let b = Accumulator::new(["q"]).unwrap();
    assert!(matches!(a.merge(b), Err(LsqError::Names { .. })));
}

#[test]
fn squares_beyond_f64_are_refused_by_name() {
    let mut rows = Accumulator::new(["1", "huge"]).unwrap();
    for i in 0..9_u32 {
        rows.push(&[1.0, 1e200 * f64::from(i)], 1.0).unwrap();
    }
    assert_eq!(
        rows.finish(),
        Err(LsqError::Overflow {
            column: "huge".to_owned()
        })
    );
}

#[test]
fn all_coefficients_held_leaves_nothing_to_fit() {
    let rows = Accumulator::new(["1"]).unwrap().reduce();
    assert!(matches!(
        rows.hold(&[(0, 1.0)]),
        Err(LsqError::Columns { found: 0, .. })
    ));
}

#[test]
fn a_robust_constant_of_zero_is_refused() {
    let options = RobustOptions {
        k: 0.0,
        ..RobustOptions::default()
    };
    let fit = fit_robust(["1"], |row| row(&[1.0], 1.0), &options);
    assert!(matches!(fit, Err(LsqError::Option { name: "k", .. })));
}

#[test]
fn bad_columns_are_refused_whole() {
    let mut rows = Accumulator::new(["1", "q"]).unwrap();
    rows.push(&[1.0, 2.0], 3.0).unwrap();
    let (one, bad) = ([1.0; 3], [1.0, 2.0, f64::NAN]);
    assert_eq!(
        rows.push_columns(&[&one, &bad], &one),
        Err(LsqError::NonFinite {
            index: 3,
            column: "q".to_owned()
        })
    );
    assert_eq!(
        rows.push_columns(&[&one, &bad[..2]], &one),
        Err(LsqError::Length {
            column: "q".to_owned(),
            found: 2,
            expected: 3
        })
    );
    assert!(matches!(
        rows.push_columns(&[&one], &one),
        Err(LsqError::Width { found: 1, .. })
    ));
    assert_eq!(rows.rows(), 1);
}

#[test]
fn a_condition_limit_that_is_none_is_refused_and_an_infinite_one_is_not() {
    let mut rows = Accumulator::new(["1"]).unwrap();
    for y in [1.0, 2.0, 4.0] {
        rows.push(&[1.0], y).unwrap();
    }
    let rows = rows.reduce();
    let robust = |condition_limit| {
        let options = RobustOptions {
            condition_limit,
            ..RobustOptions::default()
        };
        let visit =
            |row: &mut dyn FnMut(&[f64], f64)| [1.0, 2.0, 4.0].iter().for_each(|y| row(&[1.0], *y));
        fit_robust(["1"], visit, &options).map(|fit| fit.least_squares)
    };
    for limit in [f64::NAN, 0.0, -1.0] {
        for refused in [rows.solve(limit), robust(limit)] {
            assert!(
                matches!(
                    refused,
                    Err(LsqError::Option {
                        name: "condition_limit",
                        ..
                    })
                ),
                "{limit}: {refused:?}"
            );
        }
    }
    assert_eq!(rows.solve(f64::INFINITY), robust(f64::INFINITY));
}

#[test]
fn squares_too_small_for_f64_are_refused_by_name() {
    let refused = |x: f64, y: f64| {
        let mut rows = Accumulator::new(["x", "z"]).unwrap();
        for i in 0..9_u32 {
            let (a, b) = (f64::from(i % 4), f64::from(i % 3));
            rows.push(&[x * a, b], y * (a + f64::from(i % 2))).unwrap();
        }
        rows.finish().err()
    };
    let underflow = |column: &str| {
        Some(LsqError::Underflow {
            column: column.to_owned(),
        })
    };
    assert_eq!(refused(1e-158, 1.0), underflow("x"));
    for y in [1e-160, 1e-200] {
        assert_eq!(refused(1.0, y), underflow("y"));
    }
    assert_eq!(refused(1e-140, 1e-140), None);
    assert_eq!(refused(1.0, 0.0), None, "zeros are no rounding");
}

#[test]
fn a_row_of_another_width_has_no_estimate() {
    let mut rows = Accumulator::new(["1", "q"]).unwrap();
    for i in 0..5_u32 {
        rows.push(&[1.0, f64::from(i)], f64::from(i)).unwrap();
    }
    let fit = rows.finish().unwrap();
    assert!(fit.predict(&[1.0]).is_nan() && fit.predict(&[1.0; 3]).is_nan());
    assert!((fit.predict(&[1.0, 7.0]) - 7.0).abs() < 1e-12);
}

#[test]
fn what_is_held_twice_or_at_no_number_is_refused() {
    let mut rows = Accumulator::new(["1", "q"]).unwrap();
    for i in 0..5_u32 {
        rows.push(&[1.0, f64::from(i)], 1.0).unwrap();
    }
    let rows = rows.reduce();
    let held = |held: &[(usize, f64)]| rows.hold(held).err();
    assert_eq!(
        held(&[(0, 1.0), (0, 2.0)]),
        Some(LsqError::Held {
            index: 0,
            value: 2.0
        })
    );
    for value in [f64::NAN, f64::INFINITY] {
        assert!(matches!(
            held(&[(1, value)]),
            Some(LsqError::Held { index: 1, .. })
        ));
    }
    let column = "y".to_owned();
    assert_eq!(held(&[(1, 1e308)]), Some(LsqError::Overflow { column }));
    assert_eq!(held(&[(7, f64::NAN), (1, 0.5)]), None, "there is no eighth");
}
