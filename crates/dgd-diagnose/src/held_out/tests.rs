//! Claims about how much is held out.
#![allow(clippy::unwrap_used, reason = "a test may fail by panic")]

mod windows;

use super::held_out;

#[test]
fn every_window_lasts_twenty_minutes_and_all_a_fifth_of_one_to_a_hundred_hours() {
    for quarter in 4..=400 {
        let (from, total) = (17.0, 900.0 * f64::from(quarter));
        let windows = held_out((from, from + total), &[]);
        let mut last = from;
        for w in &windows {
            assert!(w.1 - w.0 >= 1200.0, "{total} s: window {w:?}");
            assert!(w.0 >= last, "{total} s: {w:?} begins before {last}");
            last = w.1;
        }
        assert!(last <= from + total);
        let held: f64 = windows.iter().map(|w| w.1 - w.0).sum();
        assert!(held >= 0.2 * total, "{total} s: {held} s held out");
        // Something must be left to fit on.
        assert!(held <= 0.36 * total, "{total} s: {held} s held out");
    }
}
