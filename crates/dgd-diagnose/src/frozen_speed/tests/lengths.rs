//! Claims about how long a pump speed may rest before it is taken for frozen.

use crate::frozen_speed::without_seldom_rest;

/// A set-point that moves at every `k`-th sample, up and down by a tenth.
fn moved(n: usize, k: usize) -> Vec<f64> {
    let level = |i: usize| {
        if (i / k).is_multiple_of(2) {
            60.0
        } else {
            60.1
        }
    };
    (0..n).map(level).collect()
}

/// Whether a rest at a level of its own is blanked; nothing else ever is.
fn is_blanked(mut speed: Vec<f64>, from: usize, length: usize, step_s: f64) -> bool {
    speed[from..from + length].fill(55.5);
    let kept = without_seldom_rest(&speed, step_s);
    let blank = kept[from].is_nan();
    for (i, (kept, was)) in kept.iter().zip(&speed).enumerate() {
        let resting = (from..from + length).contains(&i);
        assert_eq!(kept.is_nan(), resting && blank, "sample {i}");
        assert!(kept.is_nan() || kept == was);
    }
    blank
}

#[test]
fn rests_are_looked_at_from_twenty_seconds_to_ten_minutes_whatever_the_clock() {
    for (step_s, shortest, longest) in [(0.5, 40, 1200), (1.0, 20, 600), (4.0, 5, 150)] {
        for (length, blank) in [
            (shortest - 1, false),
            (shortest, true),
            (longest, true),
            (longest + 1, false),
        ] {
            let found = is_blanked(moved(3000, 1), 1000, length, step_s);
            assert_eq!(found, blank, "{length} samples of {step_s} s");
        }
    }
}

/// Four of five samples repeat their predecessor: `0.8^62` is just below a millionth, `0.8^61` above.
#[test]
fn a_rest_is_blanked_once_chance_brings_it_less_than_once_in_a_million() {
    // The rest ends where the set-point would have moved; one sample and one repeat are added to what is counted.
    assert!(!is_blanked(moved(1000, 5), 502, 63, 1.0));
    assert!(is_blanked(moved(1000, 5), 501, 64, 1.0));
    // With 40 samples about it the share is 33 of 41.
    for (length, blank) in [(60, false), (65, true)] {
        assert_eq!(is_blanked(moved(40 + length, 5), 20, length, 1.0), blank);
    }
}

#[test]
fn what_counts_are_the_three_hundred_samples_on_either_side() {
    for near in [250, 301] {
        let about = 1002 - near..1065 + near;
        // Beyond them it moves at every sample.
        let mut speed = moved(2100, 1);
        speed[about.clone()].copy_from_slice(&moved(2100, 5)[about.clone()]);
        assert_eq!(is_blanked(speed, 1002, 63, 1.0), near < 300, "{near}");
    }
}

#[test]
fn other_rests_and_standing_tell_nothing_of_the_jitter() {
    // A rest of two minutes on either side would make one of a minute honest.
    let mut speed = moved(1200, 2);
    speed[420..540].fill(50.0);
    speed[640..760].fill(50.0);
    speed[570..600].fill(55.5);
    let kept = without_seldom_rest(&speed, 1.0);
    assert!(kept[570..600].iter().all(|v| v.is_nan()));
    // So would a pump that stands for seconds at a time.
    let mut speed = moved(1200, 2);
    for from in (300..900).step_by(20) {
        speed[from..from + 18].fill(0.0);
    }
    assert!(is_blanked(speed, 580, 30, 1.0));
}
