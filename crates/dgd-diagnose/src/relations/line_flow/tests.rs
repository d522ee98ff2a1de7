//! Claims about a meter's path turned round: what the line did is had again from what the meter read.

use super::{at, blurred, cleared, line_flow};
use dgd_effects::MeterPath;

const DT_S: f64 = 2.0;

fn path(delay_s: f64, lag_s: f64) -> MeterPath {
    MeterPath { delay_s, lag_s }
}

#[test]
fn a_value_between_samples_lies_on_the_line_between_them() {
    let values = [1.0, 3.0, f64::NAN, 5.0, 6.0];
    for (position, expected) in [(0.0, 1.0), (0.25, 1.5), (3.75, 5.75), (4.0, 6.0)] {
        assert!(
            (at(&values, position) - expected).abs() < 1e-12,
            "{position}"
        );
    }
    // On a sample beside a gap it is known, between the two and beyond the end it is not.
    assert_eq!(at(&values, 1.0), 3.0);
    for position in [1.5, 2.0, 2.5, 4.5, 6.0] {
        assert!(at(&values, position).is_nan(), "{position}");
    }
}

#[test]
fn a_parabola_is_had_again_from_the_meter_that_was_late_and_slow_on_it() {
    // What the meter reads, `m`, has in it the line's flow: `m + lag m' = f(t - delay)`.
    let n = 60;
    let flow = |t: f64| 0.03 + 2e-4 * t + 1e-6 * t * t;
    for (delay, lag) in [(6.0, 0.0), (0.0, 5.0), (0.0, 3.0), (4.0, 6.0), (2.0, 20.0)] {
        let meter: Vec<f64> = (0..n)
            .map(|i| {
                let t = DT_S * f64::from(i) - delay;
                // The lag of a parabola: `f - lag f' + lag² f''`.
                flow(t) - lag * (2e-4 + 2e-6 * t) + lag * lag * 2e-6
            })
            .collect();
        let found = line_flow(&meter, path(delay, lag), DT_S, 0.0);
        assert_eq!(found.len(), meter.len());
        // Away from the ends, where means and slopes have both their sides.
        for (i, q) in found.iter().enumerate().skip(7).take(38) {
            let expected = flow(DT_S * i as f64);
            assert!(
                (q - expected).abs() < 1e-12,
                "{delay} {lag}, {i}: {q} {expected}"
            );
        }
    }
}

#[test]
fn a_line_is_had_again_up_to_its_ends_as_far_as_the_meter_tells_it() {
    let meter: Vec<f64> = (0..40).map(|i| 0.03 + 1e-4 * f64::from(i)).collect();
    // What a slow meter read in the last samples has a slope too.
    let slow = line_flow(&meter, path(0.0, 6.0), DT_S, 0.0);
    for (q, read) in slow[7..33].iter().zip(&meter[7..33]) {
        assert!((q - read - 6.0 * 5e-5).abs() < 1e-12);
    }
    for (q, read) in slow.iter().zip(&meter) {
        // Means of one side are flatter, and none is steeper.
        assert!(*q > read + 2.0 * 5e-5 && *q < read + 6.1 * 5e-5);
    }
    // What a late one has not yet read nobody knows: its last readings stand.
    let late = line_flow(&meter, path(6.0, 0.0), DT_S, 0.0);
    for (q, read) in late[2..35].iter().zip(&meter[2..35]) {
        assert!((q - read - 6.0 * 5e-5).abs() < 1e-12);
    }
    assert_eq!(late[37..], meter[37..]);
    let both = line_flow(&meter, path(6.0, 1.0), DT_S, 0.0);
    assert_eq!(both[37..], meter[37..]);
}

#[test]
fn standing_mud_has_no_store() {
    // It comes to rest at once, and the mean about the stop falls slowly.
    let meter: Vec<f64> = (0..40).map(|i| if i < 20 { 0.04 } else { 0.0 }).collect();
    let found = line_flow(&meter, path(0.0, 6.0), DT_S, 0.0);
    assert!(found[17..20].iter().all(|q| *q < 0.04 - 1e-3));
    assert!(found[20..].iter().all(|q| *q == 0.0));
}

#[test]
fn beside_a_gap_a_late_meter_tells_the_line_as_far_as_it_goes() {
    let mut meter: Vec<f64> = (0..60).map(|i| 0.03 + 1e-4 * f64::from(i)).collect();
    meter[30..40].fill(f64::NAN);
    // Three samples late, and a mean of five: what the meter showed in its last ones is known of the line three earlier.
    let found = line_flow(&meter, path(6.0, 0.0), DT_S, 0.0);
    for i in (2..25).chain(42..55) {
        assert!((found[i] - meter[i] - 6.0 * 5e-5).abs() < 1e-12, "{i}");
    }
    for i in 25..29 {
        assert!(found[i] > meter[i] + 1e-4, "{i}");
    }
    assert_eq!(found[29], meter[29]);
    assert!(found[30..40].iter().all(|q| q.is_nan()));
}

#[test]
fn what_is_three_times_the_noise_of_its_estimate_counts_by_half() {
    let noise = 2e-4;
    for dt_s in [1.0, 2.0, 4.0] {
        // Four seconds to either side are averaged, and a difference of two such means has the noise of one twice.
        let side = 4.0 / dt_s;
        let mean = noise * f64::sqrt(2.0 / (2.0 * side + 1.0));
        let ahead = |path: MeterPath, rate: f64| {
            let meter: Vec<f64> = (0..120)
                .map(|i| 0.03 + rate * dt_s * f64::from(i))
                .collect();
            line_flow(&meter, path, dt_s, noise)[60] - meter[60]
        };
        let late = ahead(path(12.0, 0.0), 3.0 * mean / 12.0);
        assert!((late / (1.5 * mean) - 1.0).abs() < 1e-9);
        // A lag's slope is over eight seconds to either side, or half as long as a long one lasts, between means over as long, which
        // share samples; its noise adds to that.
        for (lag, long) in [(4.0, 8.0), (16.0, 8.0), (40.0, 20.0)] {
            let over = 2.0 * long / dt_s;
            let share = noise * f64::sqrt(2.0 * over) / (over + 1.0);
            let floor = mean + share * lag / (over * dt_s);
            let slow = ahead(path(0.0, lag), 3.0 * floor / lag);
            assert!((slow / (1.5 * floor) - 1.0).abs() < 1e-9, "{dt_s} {lag}");
        }
    }
}

#[test]
fn noise_adds_next_to_nothing_and_a_sharp_change_stays_sharp() {
    let noise = 2e-4;
    for n in [0.5, 1.0, 2.0_f64] {
        // Under a deviation, and at two.
        let left = cleared(n * noise, noise) / noise;
        assert!(left < n * n.powi(4) / 620.0, "{left}");
    }
    // A step that a store of 8 s rounds is had again beyond 6 s to either side, within three deviations.
    let meter: Vec<f64> = (0..120)
        .map(|i| 0.03 + 0.02 * (1.0 - (-(f64::from(i) - 60.0).max(0.0) / 8.0).exp()))
        .collect();
    let found = line_flow(&meter, path(0.0, 8.0), 1.0, noise);
    let off = |i: usize, q: f64| (found[i] - q).abs();
    assert!(
        off(53, 0.03) < 3.0 * noise && off(67, 0.05) < 3.0 * noise,
        "{} {}",
        off(53, 0.03),
        off(67, 0.05)
    );
}

#[test]
fn a_lag_loses_by_being_turned_round_where_a_slope_reaches_further_than_a_mean() {
    let lost = |hours: f64, every_s: f64, path: MeterPath| {
        blurred(path, (1e4, 1e4 + 3600.0 * hours), every_s)
    };
    for (every_s, an_hour) in [(1.0, 3.4), (2.0, 3.4), (5.0, 3.4), (6.0, 0.0), (10.0, 0.0)] {
        for (hours, counted) in [(0.5, 0.5), (5.0, 5.0), (8.0, 8.0), (85.0, 8.0)] {
            for (delay_s, lag_s) in [(0.0, 8.0), (2.0, 6.0)] {
                let found = lost(hours, every_s, path(delay_s, lag_s));
                let expected: f64 = counted * an_hour;
                assert!((found - expected).abs() < 1e-9, "{every_s} {found}");
            }
            assert_eq!(lost(hours, every_s, path(8.0, 0.0)), 0.0);
        }
    }
}
