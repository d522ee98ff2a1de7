use dgd_pump::{HeadCurve, fit_unconstrained};

use crate::{PUMP, Recording};

#[test]
fn a_known_curve_is_recovered() {
    for curve in [
        PUMP,
        HeadCurve {
            n0: 1.95,
            n2: 1.62,
            ..PUMP
        },
    ] {
        let recording = Recording::new(3001, &curve, 0.0);
        let found = fit_unconstrained(&recording.samples(), curve.n0, curve.n2).unwrap();
        for (c, t) in [
            (found.curve.c0, curve.c0),
            (found.curve.c1, curve.c1),
            (found.curve.c2, curve.c2),
        ] {
            assert!((c / t - 1.0).abs() < 1e-9, "{c} is not {t}");
        }
        assert_eq!(found.n, 3001);
        assert!(found.r2 > 1.0 - 1e-12);
    }
}

#[test]
fn errors_are_the_size_their_standard_errors_say() {
    let recording = Recording::new(20_000, &PUMP, 3.0);
    let found = fit_unconstrained(&recording.samples(), 2.0, 2.0).unwrap();
    // Uniform noise of ±3 m has a variance of 3 m².
    assert!((found.mse_m2 / 3.0 - 1.0).abs() < 0.05);
    let truth = [PUMP.c0, PUMP.c1, PUMP.c2];
    let c = [found.curve.c0, found.curve.c1, found.curve.c2];
    for j in 0..3 {
        let se = found.standard_errors[j].unwrap();
        assert!((c[j] - truth[j]).abs() < 3.5 * se, "c{j}");
        assert!(se < 0.1 * truth[j]);
    }
}

#[test]
fn rejected_samples_are_never_read() {
    let mut recording = Recording::new(2000, &PUMP, 0.0);
    for i in (0..2000).step_by(3) {
        recording.keep[i] = false;
        recording.speed[i] = f64::NAN;
        recording.flow[i] = -1.0;
        recording.head[i] = f64::INFINITY;
    }
    let found = fit_unconstrained(&recording.samples(), 2.0, 2.0).unwrap();
    assert!((found.curve.c1 / PUMP.c1 - 1.0).abs() < 1e-9);
    assert_eq!(found.n, 1333);
}

#[test]
fn measuring_head_in_other_units_scales_every_coefficient() {
    let mut recording = Recording::new(2000, &PUMP, 3.0);
    let metres = fit_unconstrained(&recording.samples(), 2.0, 2.0).unwrap();
    recording.head.iter_mut().for_each(|h| *h *= 100.0);
    let centimetres = fit_unconstrained(&recording.samples(), 2.0, 2.0).unwrap();
    assert!((centimetres.curve.c1 / metres.curve.c1 / 100.0 - 1.0).abs() < 1e-10);
    assert!((centimetres.mse_m2 / metres.mse_m2 / 1e4 - 1.0).abs() < 1e-10);
    assert!((centimetres.r2 - metres.r2).abs() < 1e-12);
}

#[test]
fn intervals_hold_the_truth_as_often_as_they_say() {
    const DRAWS: usize = 300;
    let truth = [PUMP.c0, PUMP.c1, PUMP.c2];
    let mut held = [0; 3];
    let mut recording = Recording::new(400, &PUMP, 0.0);
    let exact = recording.head.clone();
    for draw in 0..DRAWS {
        for (i, head) in recording.head.iter_mut().enumerate() {
            *head = exact[i] + 3.0 * crate::noise(i + 10_000 * draw);
        }
        let found = fit_unconstrained(&recording.samples(), 2.0, 2.0).unwrap();
        let c = [found.curve.c0, found.curve.c1, found.curve.c2];
        for j in 0..3 {
            let off = (c[j] - truth[j]).abs() / found.standard_errors[j].unwrap();
            held[j] += usize::from(off < 1.96);
        }
    }
    // Of 300 draws at 95 % the binomial gives fewer than 269 or more than 297 once in 5,000 times.
    for count in held {
        assert!((269..=297).contains(&count), "{held:?} of {DRAWS}");
    }
}

#[test]
fn the_order_of_samples_does_not_matter() {
    let mut recording = Recording::new(2000, &PUMP, 3.0);
    let forth = fit_unconstrained(&recording.samples(), 2.0, 2.0).unwrap();
    recording.speed.reverse();
    recording.flow.reverse();
    recording.head.reverse();
    let back = fit_unconstrained(&recording.samples(), 2.0, 2.0).unwrap();
    assert!((forth.curve.c0 / back.curve.c0 - 1.0).abs() < 1e-10);
    assert!((forth.curve.c1 / back.curve.c1 - 1.0).abs() < 1e-10);
    assert!((forth.curve.c2 / back.curve.c2 - 1.0).abs() < 1e-10);
}

#[test]
fn a_pump_at_rest_and_a_line_at_rest_are_samples_like_others() {
    let mut recording = Recording::new(2000, &PUMP, 0.0);
    for i in 0..50 {
        recording.speed[i] = 0.0;
        recording.flow[i + 50] = 0.0;
    }
    for i in 0..100 {
        recording.head[i] = PUMP.head_m(recording.speed[i], recording.flow[i]);
    }
    let found = fit_unconstrained(&recording.samples(), 2.0, 2.0).unwrap();
    assert_eq!(found.n, 2000);
    assert!((found.curve.c2 / PUMP.c2 - 1.0).abs() < 1e-9);
}
