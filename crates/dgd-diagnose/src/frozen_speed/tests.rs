//! Claims about when a pump speed that rests is taken for frozen.

mod lengths;

use super::{quantum, without_seldom_rest};

/// A set-point that moves by a tenth now and then: at sample i if `moves(i)`.
fn speed(moves: impl Fn(usize) -> bool) -> Vec<f64> {
    let mut level = 600_i32;
    (0..4000_usize)
        .map(|i| {
            if moves(i) {
                level += if level > 600 { -1 } else { 1 };
            }
            f64::from(level) / 10.0
        })
        .collect()
}

/// A number from 0 to 9 for each sample, as good as drawn.
fn digit(i: usize) -> usize {
    (i.wrapping_mul(2_654_435_761) >> 16) % 10
}

fn blanked(values: &[f64]) -> usize {
    values.iter().filter(|v| v.is_nan()).count()
}

#[test]
fn digits_are_told_of_a_speed_that_is_logged_now_and_then() {
    let values = speed(|i| digit(i) < 5);
    let seldom: Vec<f64> = (values.iter().enumerate())
        .map(|(i, v)| if i % 5 == 0 { *v } else { f64::NAN })
        .collect();
    for values in [values, seldom] {
        assert!((quantum(&values, 1.0) - 0.1).abs() < 1e-9);
    }
}

#[test]
fn a_jittering_set_point_that_rests_for_minutes_is_blanked_there_alone() {
    let mut values = speed(|i| digit(i) < 5);
    let held = values[2000];
    values[2000..2200].fill(held);
    let kept = without_seldom_rest(&values, 1.0);
    assert!((2000..2200).all(|i| kept[i].is_nan()));
    assert!((200..206).contains(&blanked(&kept)), "{}", blanked(&kept));
}

#[test]
fn a_set_point_that_hardly_moves_and_one_that_is_held_keep_their_rests() {
    // Once in three minutes.
    assert_eq!(
        blanked(&without_seldom_rest(&speed(|i| i % 180 == 0), 1.0)),
        0
    );
    // A quarter of an hour by hand.
    let mut values = speed(|i| digit(i) < 5);
    values[1000..1900].fill(58.0);
    assert_eq!(blanked(&without_seldom_rest(&values, 1.0)), 0);
}

#[test]
fn a_standing_pump_rests_honestly() {
    let mut values = speed(|i| digit(i) < 5);
    values[1000..1300].fill(0.0);
    assert_eq!(blanked(&without_seldom_rest(&values, 1.0)), 0);
}

#[test]
fn the_quantum_is_the_least_usual_step() {
    assert!((quantum(&speed(|i| digit(i) < 5), 1.0) - 0.1).abs() < 1e-9);
    assert_eq!(quantum(&[60.0; 50], 1.0), 0.0);
    assert_eq!(quantum(&[], 1.0), 0.0);
}
