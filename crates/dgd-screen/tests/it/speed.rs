use crate::synthetic::with_speed;
use dgd_recording::{Channel, Recording};
use dgd_screen::{Faults, Reasons, ScreenOptions, screen};

/// Ten minutes of control, then rest at 62 % from 3000 s to 3300 s.
fn resting(then: f64) -> Recording {
    with_speed(6000, 1.0, move |t| {
        if (3000.0..3300.0).contains(&t) {
            62.0
        } else if t < 3300.0 {
            60.0 + 4.0 * (t / 60.0).sin()
        } else {
            then + 2.0 * ((t - 3300.0) / 60.0).sin()
        }
    })
}

#[test]
fn an_honest_rest_is_kept_unless_asked_for() {
    let recording = resting(65.0);
    let screening = screen(&recording, 1.0, &ScreenOptions::default()).unwrap();
    let speed = screening.channel(Channel::PumpSpeed).unwrap();
    assert!((300..305).contains(&speed.count(Faults::CONSTANT)));
    assert_eq!(speed.stuck, []);
    assert!(speed.valid().iter().all(|v| *v));
    assert!(screening.keep().iter().all(|k| *k));
    let thesis = screen(&recording, 1.0, &ScreenOptions::thesis()).unwrap();
    assert!((3000..3300).all(|i| thesis.reasons[i] == Reasons::CONSTANT_PUMP_SPEED));
}

#[test]
fn a_reading_that_catches_up_without_the_pressure_was_frozen() {
    let mut recording = with_speed(6000, 1.0, |t| 60.0 + 5.0 * (t / 200.0).sin());
    // Frozen on the way: the reading lags behind by several percent when released.
    let held = recording.pump_speed_pct[3000];
    recording.pump_speed_pct[3000..3300].fill(held);
    let jump = (recording.pump_speed_pct[3300] - held).abs();
    assert!(jump > 3.0, "{jump}");
    let screening = screen(&recording, 1.0, &ScreenOptions::default()).unwrap();
    let speed = screening.channel(Channel::PumpSpeed).unwrap();
    assert_eq!(speed.stuck.len(), 1);
    assert!((3000..3300).all(|i| screening.reasons[i] == Reasons::STUCK_PUMP_SPEED));
    let rejected = screening.keep().iter().filter(|k| !**k).count();
    assert!((300..=310).contains(&rejected), "{rejected}");
}

#[test]
fn a_set_point_in_steps_is_never_frozen() {
    let recording = with_speed(12_000, 1.0, |t| 55.0 + 3.0 * ((t / 400.0).floor() % 5.0));
    let screening = screen(&recording, 1.0, &ScreenOptions::default()).unwrap();
    let speed = screening.channel(Channel::PumpSpeed).unwrap();
    assert_eq!(speed.stuck, []);
    assert!(screening.keep().iter().all(|k| *k));
}
