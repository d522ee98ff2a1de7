//! Claims about when a pump speed that rests is taken for frozen.

mod lengths;

use super::{quantum, stopping_with_the_flow, without_late_steps, without_seldom_rest};
use dgd_effects::STANDING_M3_S;

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

#[test]
fn a_stop_that_a_frozen_speed_tells_late_begins_where_the_flow_ends() {
    // The flow dies at sample 1000, the speed is told to 1100; two seconds a sample.
    let told = |last_pct: f64, flow_m3_s: f64, fall_pa: f64| {
        let of = |flowing: f64, standing: f64| -> Vec<f64> {
            (0..1500)
                .map(|i| if i < 1000 { flowing } else { standing })
                .collect()
        };
        let (flow, outlet) = (of(0.03, flow_m3_s), of(40e5, 40e5 - fall_pa));
        let mut speed = vec![59.0; 1500];
        speed[1100] = last_pct;
        speed[1101..].fill(0.0);
        let frozen = stopping_with_the_flow(&speed, &flow, &outlet, 2.0);
        // A screening that saw it leaves a gap.
        speed[900..1100].fill(f64::NAN);
        let missing = stopping_with_the_flow(&speed, &flow, &outlet, 2.0);
        [frozen, missing].map(|speed| speed.iter().position(|w| *w <= 0.0))
    };
    for last_pct in [0.0, 29.5] {
        assert_eq!(told(last_pct, 0.0, 3e5), [Some(1000); 2], "{last_pct}");
    }
    // Where mud flows on, or the outlet does not know of a stop, the speed is believed.
    assert_eq!(told(0.0, STANDING_M3_S, 3e5), [Some(1100); 2]);
    assert_eq!(told(0.0, 0.0, 0.1e5), [Some(1100); 2]);
    // So is a pump that was run down slowly, and one that never stops.
    let slow: Vec<f64> = (0..1500_u16)
        .map(|i| (59.0 - 0.1 * f64::from(i.saturating_sub(800))).max(0.0))
        .collect();
    let outlet: Vec<f64> = (0..1500)
        .map(|i| if i < 1000 { 40e5 } else { 37e5 })
        .collect();
    for speed in [slow, vec![59.0; 1500]] {
        let told = stopping_with_the_flow(&speed, &vec![0.0; 1500], &outlet, 2.0);
        assert_eq!(told, speed);
    }
}

/// A speed that an operator steps from 60 to 62 % at 500 s and that is told so late, and a flow that follows it within three seconds.
fn stepped(late: usize, flow: impl Fn(usize) -> f64) -> (Vec<f64>, Vec<f64>) {
    let speed = (0..1500).map(|i| if i < 500 + late { 60.0 } else { 62.0 });
    let noise = |i: usize| 2e-5 * (digit(i) as f64 - 4.5);
    (
        speed.collect(),
        (0..1500).map(|i| flow(i) + noise(i)).collect(),
    )
}

fn answer(i: usize) -> f64 {
    0.04 + if i < 503 { 0.0 } else { 0.004 }
}

#[test]
fn a_step_that_the_flow_took_before_is_told_late() {
    let (speed, flow) = stepped(150, answer);
    let told = without_late_steps(&speed, &flow, 6e-5, 1.0);
    let gone: Vec<usize> = (0..speed.len()).filter(|i| told[*i].is_nan()).collect();
    // From about the flow's step to the reading's.
    assert!(
        gone.first().is_some_and(|i| (485..505).contains(i)),
        "{gone:?}"
    );
    assert_eq!(gone.last(), Some(&649));
    assert_eq!(gone.len(), 650 - gone[0]);
    // Slower readings as well.
    let thinned = |values: &[f64]| -> Vec<f64> { values.iter().step_by(2).copied().collect() };
    assert!(
        blanked(&without_late_steps(
            &thinned(&speed),
            &thinned(&flow),
            6e-5,
            2.0
        )) > 60
    );
}

#[test]
fn a_step_that_the_flow_answers_or_never_took_is_told_in_time() {
    let whole = |(speed, flow): (Vec<f64>, Vec<f64>)| {
        assert_eq!(blanked(&without_late_steps(&speed, &flow, 6e-5, 1.0)), 0);
    };
    whole(stepped(0, answer));
    // It answers by a lag of half a minute, or not at all.
    whole(stepped(0, |i| {
        0.04 + 0.004 * (1.0 - (-(i.saturating_sub(500) as f64) / 30.0).exp())
    }));
    whole(stepped(150, |_| 0.04));
    // What passes, or goes the other way, is no step of the speed.
    whole(stepped(150, |i| {
        if (503..560).contains(&i) { 0.044 } else { 0.04 }
    }));
    whole(stepped(150, |i| 0.08 - answer(i)));
    // Nothing is known of a flow that is not read; and a pump that starts is no step.
    whole(stepped(150, |_| f64::NAN));
    let (speed, flow) = stepped(150, answer);
    let starts: Vec<f64> = speed
        .iter()
        .map(|w| if *w > 60.0 { 60.0 } else { 0.0 })
        .collect();
    whole((starts, flow));
    // Neither is what is within the noise.
    let (speed, flow) = stepped(150, answer);
    assert_eq!(blanked(&without_late_steps(&speed, &flow, 2e-3, 1.0)), 0);
    whole((Vec::new(), Vec::new()));
}
