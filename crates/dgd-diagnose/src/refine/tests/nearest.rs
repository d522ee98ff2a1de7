//! Claims about the search for the time of what is late.

use crate::refine::nearest_time;

/// A valley about `truth`, `depth` a second squared.
fn valley(truth: f64, depth: f64) -> impl Fn(f64) -> f64 + Sync {
    move |time| 40.0 + depth * (time - truth).powi(2)
}

#[test]
fn the_time_is_found_to_half_the_finest_step_from_either_side() {
    for truth in [2.0, 7.3, 11.9] {
        for from in [0.5, 6.0, 15.0] {
            let (time, misfit) = nearest_time(60.0, from, valley(truth, 100.0));
            // A fiftieth of a second more, for gains that are too small to count.
            assert!((time - truth).abs() < 0.195, "{time} for {truth}");
            assert_eq!(misfit, valley(truth, 100.0)(time));
        }
    }
}

#[test]
fn it_stays_between_half_a_second_and_the_longest_time() {
    assert_eq!(nearest_time(4.0, 3.0, valley(9.0, 100.0)).0, 4.0);
    assert_eq!(nearest_time(4.0, 3.0, valley(-9.0, 100.0)).0, 0.5);
}

#[test]
fn a_gain_of_less_than_a_twentieth_moves_nothing() {
    // Three seconds save 0.03, and then 0.06.
    for (slope, moves) in [(0.01, false), (0.02, true)] {
        let (time, _) = nearest_time(60.0, 30.0, |t| slope * t);
        assert_eq!(time < 30.0, moves, "{slope}");
    }
}

#[test]
fn a_valley_far_off_is_neared_by_six_steps_of_each_size() {
    let reach = 6.0 * (3.0 + 1.5 + 0.7 + 0.35);
    for (truth, end) in [(400.0, 100.0 + reach), (-200.0, 100.0 - reach)] {
        let (time, _) = nearest_time(500.0, 100.0, valley(truth, 1.0));
        assert!((time - end).abs() < 1e-9, "{time} for {end}");
    }
}
