use dgd_pump::HeadCurve;

use crate::PUMP;

const SEARCHED: HeadCurve = HeadCurve {
    n0: 1.95,
    n2: 1.62,
    ..PUMP
};

#[test]
fn slopes_are_those_of_the_head() {
    let h = 1e-5;
    for curve in [PUMP, SEARCHED] {
        for (w, q) in [(30.0, 0.01), (60.0, 0.04), (95.0, 0.07), (60.0, -0.02)] {
            let by_flow = (curve.head_m(w, q + h) - curve.head_m(w, q - h)) / (2.0 * h);
            assert!((curve.slope_flow(w, q) / by_flow - 1.0).abs() < 1e-6);
            let by_speed = (curve.head_m(w + h, q) - curve.head_m(w - h, q)) / (2.0 * h);
            assert!((curve.slope_speed(w, q) / by_speed - 1.0).abs() < 1e-6);
            let bend = (curve.slope_flow(w, q + h) - curve.slope_flow(w, q - h)) / (2.0 * h);
            assert!((curve.bend_flow(q) / bend - 1.0).abs() < 1e-5);
        }
    }
}

#[test]
fn with_exponents_of_two_affinity_holds() {
    // H(k w, k q) = k² H(w, q).
    let (w, q, k) = (40.0, 0.03, 1.7);
    assert!((PUMP.head_m(k * w, k * q) / (k * k * PUMP.head_m(w, q)) - 1.0).abs() < 1e-12);
}

#[test]
fn the_curve_falls_through_rest_into_backflow() {
    for curve in [PUMP, SEARCHED] {
        let heads: Vec<f64> = (-5..=5)
            .map(|i| curve.head_m(50.0, 0.01 * f64::from(i)))
            .collect();
        assert!(heads.windows(2).all(|pair| pair[1] < pair[0]), "{heads:?}");
    }
}

#[test]
fn a_standing_pump_has_no_slope_but_the_loss() {
    assert_eq!(SEARCHED.head_m(0.0, 0.0), 0.0);
    assert_eq!(SEARCHED.head_m(-5.0, 0.0), 0.0);
    assert_eq!(SEARCHED.slope_flow(0.0, 0.0), 0.0);
    let without = HeadCurve {
        c2: 0.0,
        ..SEARCHED
    };
    assert_eq!(without.bend_flow(0.0), 0.0);
}

#[test]
fn at_rest_the_bend_is_that_of_forward_flow() {
    assert_eq!(PUMP.bend_flow(0.0), -2.0 * PUMP.c2);
    assert_eq!(PUMP.bend_flow(-0.01), 2.0 * PUMP.c2);
}

#[test]
fn a_missing_speed_has_no_head_and_one_below_rest_is_rest() {
    assert!(PUMP.head_m(f64::NAN, 0.05).is_nan());
    assert!(PUMP.slope_flow(f64::NAN, 0.05).is_nan());
    assert!(PUMP.slope_speed(f64::NAN, 0.05).is_nan());
    assert_eq!(PUMP.head_m(-3.0, 0.05), PUMP.head_m(0.0, 0.05));
}

/// Below rest the head is that at rest, whatever the speed.
#[test]
fn the_head_does_not_change_with_a_speed_below_rest() {
    assert_eq!(PUMP.head_m(-5.0, 0.05), PUMP.head_m(-6.0, 0.05));
    assert_eq!(PUMP.slope_speed(-5.0, 0.05), 0.0);
    assert!(PUMP.slope_speed(f64::NAN, 0.05).is_nan());
}
