use dgd_friction::{FrictionError, Polynomial, Terms};

fn law() -> Polynomial {
    Polynomial {
        powers: vec![0.0, 1.0, 1.75, 2.0, 3.0],
        coefficients: vec![2e4, 1e6, 3e7, 9e7, -2e8],
    }
}

#[test]
fn terms_other_than_the_offset_are_odd() {
    for q in [0.01, 0.03, 0.07] {
        let offset = 2e4;
        assert!((law().eval(-q) - offset + (law().eval(q) - offset)).abs() < 1e-9);
        assert_eq!(law().derivative(-q), law().derivative(q));
    }
    assert_eq!(law().eval(0.0), 2e4);
}

#[test]
fn the_derivative_is_that_of_the_law() {
    let step = 1e-6;
    for q in [-0.05, -0.01, 0.02, 0.06] {
        let slope = (law().eval(q + step) - law().eval(q - step)) / (2.0 * step);
        assert!((law().derivative(q) / slope - 1.0).abs() < 1e-7);
    }
}

#[test]
fn coefficients_are_found_by_power() {
    assert_eq!(law().coefficient(2.0), Some(9e7));
    assert_eq!(law().coefficient(4.0), None);
}

#[test]
fn the_thesis_models_have_their_powers() {
    assert_eq!(Terms::Quadratic.powers().unwrap(), [1.0, 2.0]);
    assert_eq!(Terms::OffsetCubic.powers().unwrap(), [0.0, 2.0, 3.0]);
}

#[test]
fn senseless_powers_are_refused() {
    for powers in [
        vec![],
        vec![1.0, 1.0],
        vec![-1.0],
        vec![f64::NAN],
        (0..9).map(f64::from).collect(),
    ] {
        let refused = Terms::Powers(powers).powers();
        assert!(matches!(refused, Err(FrictionError::Powers { .. })));
    }
}

#[test]
fn up_to_eight_powers_are_a_model_and_a_ninth_is_refused_with_what_was_given() {
    let powers = |n: u32| Terms::Powers((0..n).map(f64::from).collect()).powers();
    assert_eq!(powers(8).unwrap().len(), 8);
    match powers(20) {
        Err(FrictionError::Powers { found, limit: 8 }) => {
            assert_eq!(found, [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0]);
        }
        other => panic!("{other:?}"),
    }
}

#[test]
fn a_law_whose_coefficients_are_not_as_many_as_its_powers_has_no_friction() {
    for coefficients in [vec![10.0], vec![10.0, 3.0, 1.0]] {
        let law = Polynomial {
            powers: vec![0.0, 2.0],
            coefficients,
        };
        assert!(law.eval(2.0).is_nan() && law.derivative(2.0).is_nan());
    }
}

#[test]
fn a_law_of_whole_powers_is_a_cubic_in_order_and_any_other_is_none() {
    let of = |powers: &[f64], coefficients: &[f64]| {
        let law = Polynomial {
            powers: powers.to_vec(),
            coefficients: coefficients.to_vec(),
        };
        law.cubic()
    };
    // In the order of the powers, not of the law.
    assert_eq!(
        of(&[3.0, 0.0, 2.0], &[4.0, 1.0, 3.0]),
        Some([1.0, 0.0, 3.0, 4.0])
    );
    assert_eq!(of(&[1.0, 1.75], &[2.0, 5.0]), None);
    assert_eq!(of(&[4.0], &[5.0]), None);
    assert_eq!(of(&[1.0, 2.0], &[2.0]), None);
}

#[test]
fn a_power_that_stands_twice_counts_twice_everywhere() {
    let law = Polynomial {
        powers: vec![0.0, 2.0, 2.0],
        coefficients: vec![10.0, 3.0, 4.0],
    };
    assert_eq!(law.eval(2.0), 38.0);
    assert_eq!(law.coefficient(2.0), Some(7.0));
    assert_eq!(law.cubic(), Some([10.0, 0.0, 7.0, 0.0]));
    assert_eq!(law.coefficient(1.0), None);
}
