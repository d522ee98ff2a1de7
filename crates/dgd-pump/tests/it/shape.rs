use dgd_pump::{HeadCurve, PumpError, check_shape};

use crate::{CONVEX, PUMP};

#[test]
fn corners_are_the_worst_of_a_fine_grid() {
    let odd = [
        PUMP,
        CONVEX,
        HeadCurve {
            n2: 1.4,
            n0: 1.2,
            ..PUMP
        },
        HeadCurve {
            n2: 3.1,
            c2: 1e5,
            n0: 2.6,
            ..PUMP
        },
        HeadCurve {
            n2: 0.7,
            c2: 30.0,
            ..PUMP
        },
        HeadCurve {
            c0: -0.01,
            c1: -3.0,
            c2: -2.0,
            n0: 0.8,
            n2: 0.5,
        },
    ];
    for curve in odd {
        let shape = check_shape(&curve, 20.0..=100.0, 0.001..=0.07).unwrap();
        let (mut slope, mut bend, mut gain) = (f64::MIN, f64::MIN, f64::MAX);
        for i in 0..=80_u32 {
            for j in 0..=69_u32 {
                let (w, q) = (20.0 + f64::from(i), 0.001 + 0.001 * f64::from(j));
                slope = slope.max(curve.slope_flow(w, q));
                bend = bend.max(curve.bend_flow(q));
                gain = gain.min(curve.slope_speed(w, q));
            }
        }
        for (found, grid) in [
            (shape.worst_slope.value, slope),
            (shape.worst_bend.value, bend),
            (shape.worst_gain.value, gain),
        ] {
            assert!(
                (found - grid).abs() <= 1e-9 * grid.abs(),
                "{curve:?}: {found} {grid}"
            );
        }
        assert_eq!(shape.falls_with_flow, slope <= 0.0);
        assert_eq!(shape.concave, bend <= 0.0);
        assert_eq!(shape.rises_with_speed, gain >= 0.0);
    }
}

#[test]
fn a_good_curve_passes_and_a_convex_one_is_caught_where_it_is_worst() {
    let good = check_shape(&PUMP, 30.0..=70.0, 0.0..=0.07).unwrap();
    assert!(good.falls_with_flow && good.concave && good.rises_with_speed);
    let bad = check_shape(&CONVEX, 30.0..=70.0, 0.0..=0.07).unwrap();
    assert!(!bad.concave);
    assert!(!bad.falls_with_flow);
    assert_eq!(bad.worst_slope.speed_pct, 30.0);
    assert_eq!(bad.worst_slope.flow_m3_s, 0.07);
    // The bend does not know the speed: of equal places the first is told.
    assert_eq!(bad.worst_bend.speed_pct, 30.0);
}

#[test]
fn the_place_holds_its_value() {
    let shape = check_shape(&CONVEX, 30.0..=70.0, 0.0..=0.07).unwrap();
    let at = shape.worst_slope;
    assert_eq!(at.value, CONVEX.slope_flow(at.speed_pct, at.flow_m3_s));
    let at = shape.worst_gain;
    assert_eq!(at.value, CONVEX.slope_speed(at.speed_pct, at.flow_m3_s));
}

#[test]
fn senseless_ranges_and_curves_are_refused() {
    let refused =
        |curve: &HeadCurve, w, q| matches!(check_shape(curve, w, q), Err(PumpError::Domain { .. }));
    assert!(refused(&PUMP, -1.0..=70.0, 0.0..=0.07));
    assert!(refused(&PUMP, 30.0..=f64::INFINITY, 0.0..=0.07));
    let empty = 0.07..=0.0;
    assert!(refused(&PUMP, 30.0..=70.0, empty));
    assert!(refused(&PUMP, 30.0..=70.0, f64::NAN..=0.07));
    let broken = HeadCurve {
        c1: f64::NAN,
        ..PUMP
    };
    assert!(refused(&broken, 30.0..=70.0, 0.0..=0.07));
}

#[test]
fn a_flat_curve_neither_rises_nor_bends_up_nor_falls_with_speed() {
    let flat = HeadCurve {
        c0: 0.0,
        c1: 0.0,
        c2: 0.0,
        ..PUMP
    };
    let shape = check_shape(&flat, 30.0..=70.0, 0.0..=0.07).unwrap();
    assert!(shape.falls_with_flow && shape.concave && shape.rises_with_speed);
}

#[test]
fn a_range_of_one_point_is_a_range_and_the_faulty_end_of_others_is_told() {
    let shape = check_shape(&PUMP, 50.0..=50.0, 0.02..=0.02).unwrap();
    assert_eq!(shape.worst_slope.value, PUMP.slope_flow(50.0, 0.02));
    let told = |w| match check_shape(&PUMP, w, 0.0..=0.07) {
        Err(PumpError::Domain { name, found, .. }) => (name, found),
        other => panic!("{other:?}"),
    };
    assert_eq!(told(-1.0..=70.0), ("speed_pct", -1.0));
    assert_eq!(told(30.0..=f64::INFINITY), ("speed_pct", f64::INFINITY));
    let falling = 30.0..=20.0;
    assert_eq!(told(falling), ("speed_pct", 20.0));
}
