use dgd_lsq::{Accumulator, Reduced};
use dgd_pump::{
    ConstrainedOptions, HeadCurve, PumpError, SolverStatus, fit_constrained,
    fit_free_and_constrained, fit_unconstrained,
};

use crate::{CONVEX, PUMP, Recording};

fn triangle(recording: &Recording, n0: f64, n2: f64) -> Reduced {
    let mut rows = Accumulator::new(["c0", "c1", "c2"]).unwrap();
    for ((w, q), h) in recording
        .speed
        .iter()
        .zip(&recording.flow)
        .zip(&recording.head)
    {
        rows.push(&[w.powf(n0), -w * q, -q.powf(n2)], *h).unwrap();
    }
    rows.reduce()
}

fn rss(triangle: &Reduced, c: [f64; 3]) -> f64 {
    (0..4)
        .map(|i| {
            let fitted: f64 = (0..3).map(|j| triangle.r(i, j) * c[j]).sum();
            (triangle.r(i, 3) - fitted).powi(2)
        })
        .sum()
}

/// Best of all eight active sets that is feasible.
fn enumerate(triangle: &Reduced, floors: [f64; 3]) -> ([f64; 3], f64) {
    let mut best = (floors, rss(triangle, floors));
    for set in 0..7_u32 {
        let held: Vec<(usize, f64)> = (0..3)
            .filter(|j| set & (1 << j) != 0)
            .map(|j| (j, floors[j]))
            .collect();
        let free = triangle.hold(&held).unwrap().solve(1e12).unwrap();
        let mut values = free.coefficients.iter();
        let mut c = floors;
        for (j, c) in c.iter_mut().enumerate() {
            if set & (1 << j) == 0 {
                *c = *values.next().unwrap();
            }
        }
        if c.iter().zip(floors).all(|(c, floor)| *c >= floor) && rss(triangle, c) < best.1 {
            best = (c, rss(triangle, c));
        }
    }
    best
}

#[test]
fn the_programme_agrees_with_every_active_set_enumerated() {
    let flat = HeadCurve { c1: -2.0, ..PUMP };
    let none = HeadCurve {
        c1: -1.0,
        c2: -1e3,
        ..PUMP
    };
    let upside_down = HeadCurve {
        c0: -0.05,
        c1: -20.0,
        ..PUMP
    };
    let nothing = HeadCurve {
        c0: -0.05,
        c1: -100.0,
        c2: 0.0,
        ..PUMP
    };
    let cases = [PUMP, CONVEX, flat, none, upside_down, nothing];
    let mut sets = Vec::new();
    for truth in cases {
        let recording = Recording::new(3000, &truth, 1.0);
        for share in [1e-9, 1e-6, 1e-3] {
            let options = ConstrainedOptions {
                floor_share: share,
                ..ConstrainedOptions::default()
            };
            let found = fit_constrained(&recording.samples(), 2.0, 2.0, &options).unwrap();
            let (expected, least) = enumerate(&triangle(&recording, 2.0, 2.0), found.floors);
            let c = [found.fit.curve.c0, found.fit.curve.c1, found.fit.curve.c2];
            for (a, b) in c.iter().zip(expected) {
                assert!(
                    (a - b).abs() <= 1e-8 * b.abs(),
                    "{c:?} against {expected:?}"
                );
            }
            let degrees = 3000.0 - f64::from(found.active.map(|a| u8::from(!a)).iter().sum::<u8>());
            assert!((found.fit.mse_m2 * degrees / least - 1.0).abs() < 1e-9);
            assert!(found.kkt_residual < 1e-9, "{found:?}");
            assert!(found.polished);
            assert_eq!(found.status, SolverStatus::Solved);
            for j in 0..3 {
                assert!(c[j] >= found.floors[j]);
                assert_eq!(found.active[j], c[j] == found.floors[j]);
                assert_eq!(found.fit.standard_errors[j].is_none(), found.active[j]);
            }
            sets.push(found.active);
        }
    }
    assert!(sets.contains(&[true; 3]) && sets.contains(&[false; 3]));
    sets.dedup();
    assert!(
        sets.len() >= 4,
        "the cases reach several active sets: {sets:?}"
    );
}

#[test]
fn a_curve_of_good_shape_is_the_unconstrained_fit() {
    let recording = Recording::new(3000, &PUMP, 1.0);
    let free = fit_unconstrained(&recording.samples(), 2.0, 2.0).unwrap();
    let options = ConstrainedOptions::default();
    let bound = fit_constrained(&recording.samples(), 2.0, 2.0, &options).unwrap();
    assert_eq!(bound.active, [false; 3]);
    assert!((bound.fit.curve.c2 / free.curve.c2 - 1.0).abs() < 1e-9);
    assert!((bound.fit.mse_m2 / free.mse_m2 - 1.0).abs() < 1e-12);
    assert!((bound.fit.r2 - free.r2).abs() < 1e-12);
    assert_eq!(bound.fit.standard_errors, free.standard_errors);
}

#[test]
fn both_answers_of_one_pass_are_those_of_two_and_refusals_are_each_its_own() {
    for truth in [PUMP, CONVEX] {
        let recording = Recording::new(3000, &truth, 1.0);
        let samples = recording.samples();
        let both = |options: &ConstrainedOptions, n0: f64| {
            let apart = (
                fit_unconstrained(&samples, n0, 1.8),
                fit_constrained(&samples, n0, 1.8, options),
            );
            assert_eq!(fit_free_and_constrained(&samples, n0, 1.8, options), apart);
            apart
        };
        let options = ConstrainedOptions::default();
        assert!(matches!(both(&options, 2.0), (Ok(_), Ok(_))));
        assert!(matches!(both(&options, -1.0), (Err(_), Err(_))));
        let floor_share = 0.0;
        let no_floor = ConstrainedOptions {
            floor_share,
            ..options
        };
        assert!(matches!(both(&no_floor, 2.0), (Ok(_), Err(_))));
    }
}

#[test]
fn a_convex_fit_is_held_at_the_bound_and_costs_more() {
    let recording = Recording::new(3000, &CONVEX, 1.0);
    let free = fit_unconstrained(&recording.samples(), 2.0, 2.0).unwrap();
    assert!(free.curve.c2 < 0.0);
    let options = ConstrainedOptions::default();
    let bound = fit_constrained(&recording.samples(), 2.0, 2.0, &options).unwrap();
    assert_eq!(bound.active, [false, false, true]);
    assert_eq!(bound.fit.curve.c2, bound.floors[2]);
    assert!(bound.floors[2] > 0.0);
    assert!(bound.fit.mse_m2 > free.mse_m2);
}

#[test]
fn an_iteration_limit_is_a_status_not_an_error() {
    let recording = Recording::new(500, &CONVEX, 1.0);
    let options = ConstrainedOptions {
        max_iterations: 1,
        ..ConstrainedOptions::default()
    };
    let found = fit_constrained(&recording.samples(), 2.0, 2.0, &options).unwrap();
    assert_eq!(found.status, SolverStatus::IterationLimit);
    // The sets of held coefficients that it does not point to are tried too.
    assert!(found.polished && found.kkt_residual < 1e-9, "{found:?}");
}

#[test]
fn of_nearly_alike_columns_the_optimum_is_found_too() {
    let (mut fitted, mut held) = (0, [0; 3]);
    for seed in 0..200_u32 {
        let recording = Recording::alike(seed);
        let options = ConstrainedOptions::default();
        let found = match fit_constrained(&recording.samples(), 2.0, 2.0, &options) {
            Ok(found) => found,
            // Too much alike to tell anything.
            Err(PumpError::Fit(_)) => continue,
            Err(other) => panic!("{seed}: {other}"),
        };
        fitted += 1;
        let (expected, _) = enumerate(&triangle(&recording, 2.0, 2.0), found.floors);
        let c = [found.fit.curve.c0, found.fit.curve.c1, found.fit.curve.c2];
        for j in 0..3 {
            let off = (c[j] - expected[j]).abs();
            assert!(
                off <= 1e-6 * expected[j].abs(),
                "{seed}: {c:?}, {expected:?}"
            );
            assert_eq!(found.active[j], expected[j] == found.floors[j], "{seed}");
            held[j] += u32::from(found.active[j]);
        }
        assert!(found.polished, "{seed}: {found:?}");
    }
    assert!(fitted > 120, "few are fitted: {fitted}");
    assert!(held[1] > 20 && held[2] > 20, "few lie on a bound: {held:?}");
}

#[test]
fn a_constant_head_has_no_variance_to_explain() {
    let mut recording = Recording::new(512, &PUMP, 0.0);
    recording.head.fill(128.0);
    let options = ConstrainedOptions::default();
    let found = fit_constrained(&recording.samples(), 2.0, 2.0, &options).unwrap();
    let free = fit_unconstrained(&recording.samples(), 2.0, 2.0).unwrap();
    assert!(found.fit.r2.is_nan() && free.r2.is_nan());
}

#[test]
fn r2_is_the_share_of_the_variance_that_the_bounded_curve_leaves() {
    let recording = Recording::new(3000, &CONVEX, 1.0);
    let options = ConstrainedOptions::default();
    let found = fit_constrained(&recording.samples(), 2.0, 2.0, &options).unwrap();
    let n = recording.head.len() as f64;
    let mean = recording.head.iter().sum::<f64>() / n;
    let (mut rss, mut total) = (0.0, 0.0);
    for i in 0..recording.head.len() {
        let h = recording.head[i];
        let fitted = found
            .fit
            .curve
            .head_m(recording.speed[i], recording.flow[i]);
        rss += (h - fitted).powi(2);
        total += (h - mean).powi(2);
    }
    assert!((found.fit.r2 - (1.0 - rss / total)).abs() < 1e-11);
    // The two free coefficients take a degree each.
    assert!((found.fit.mse_m2 / (rss / (n - 2.0)) - 1.0).abs() < 1e-10);
}

#[test]
fn a_floor_of_zero_is_refused() {
    let recording = Recording::new(500, &PUMP, 1.0);
    for floor_share in [0.0, 1.0, f64::NAN] {
        let options = ConstrainedOptions {
            floor_share,
            ..ConstrainedOptions::default()
        };
        assert!(matches!(
            fit_constrained(&recording.samples(), 2.0, 2.0, &options),
            Err(PumpError::Domain {
                name: "floor_share",
                ..
            })
        ));
    }
}

/// The solver's limit is no limit of the answer, as long as it tells what is held.
#[test]
fn a_polished_answer_is_the_optimum_whatever_the_status() {
    let recording = Recording::new(500, &PUMP, 1.0);
    let with = |max_iterations| {
        let options = ConstrainedOptions {
            max_iterations,
            ..ConstrainedOptions::default()
        };
        fit_constrained(&recording.samples(), 2.0, 2.0, &options).unwrap()
    };
    let (short, long) = (with(1), with(200));
    assert_eq!(short.status, SolverStatus::IterationLimit);
    assert!(short.polished && short.kkt_residual < 1e-9);
    assert_eq!(short.fit.curve, long.fit.curve);
}
