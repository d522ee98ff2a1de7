//! The head curve beyond the ranges in which it was identified.

use crate::{close, model};

#[test]
fn head_within_the_ranges_is_the_curve() {
    let model = model(&[]);
    for (w, q) in [(40.0, 0.01), (70.0, 0.03), (100.0, 0.08)] {
        assert_eq!(model.head_pa(w, q), model.curves.head_pa(w, q));
    }
}

#[test]
fn head_falls_on_with_flow_beyond_the_range_and_is_continuous() {
    let model = model(&[]);
    for w in [20.0, 40.0, 80.0, 100.0, 120.0] {
        let heads: Vec<f64> = (0..400)
            .map(|k| model.head_pa(w, 1e-3 * f64::from(k)))
            .collect();
        for (k, pair) in heads.windows(2).enumerate() {
            assert!(pair[1] <= pair[0] + 1e-9, "rises at {w} %, {k}: {pair:?}");
            assert!(pair[0] - pair[1] < 1e5, "jumps at {w} %, {k}: {pair:?}");
        }
    }
}

#[test]
fn a_curve_that_rises_at_its_end_is_held_level_beyond() {
    let mut model = model(&[]);
    model.curves.head[3] = 5.6e5;
    let end = model.head_pa(80.0, 80.0 * 8e-4);
    assert_eq!(model.head_pa(80.0, 0.2), end);
}

#[test]
fn head_beyond_the_speeds_goes_by_affinity_and_rises_with_speed() {
    let model = model(&[]);
    for q_over_w in [2e-4, 6e-4, 1e-3] {
        close(
            model.head_pa(150.0, 150.0 * q_over_w),
            2.25 * model.head_pa(100.0, 100.0 * q_over_w),
            1e-9,
        );
        close(
            model.head_pa(20.0, 20.0 * q_over_w),
            0.25 * model.head_pa(40.0, 40.0 * q_over_w),
            1e-9,
        );
    }
    // Where flow over speed is in its range; slower, the straight continuation is no law of speed.
    let heads: Vec<f64> = (25..=200)
        .map(|w| model.head_pa(f64::from(w), 0.02))
        .collect();
    assert!(heads.windows(2).all(|p| p[0] < p[1]));
}

#[test]
fn flow_against_the_pump_meets_more_head() {
    let model = model(&[]);
    assert!(model.head_pa(80.0, -0.02) >= model.head_pa(80.0, 80.0 * 1e-4));
}
