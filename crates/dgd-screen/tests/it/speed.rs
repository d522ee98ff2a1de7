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

/// A logger that drops one value in ten, or tells the pressures every ten seconds only, hides no frozen reading.
#[test]
fn a_frozen_reading_is_found_where_values_are_missing() {
    let mut recording = with_speed(6000, 1.0, |t| 60.0 + 5.0 * (t / 200.0).sin());
    let held = recording.pump_speed_pct[3000];
    recording.pump_speed_pct[3000..3300].fill(held);
    let flow = recording.return_flow_m3_s[1000];
    recording.return_flow_m3_s[1000..1200].fill(flow);
    let without = |values: &mut Vec<f64>, out: fn(usize) -> bool| {
        let values = values.iter_mut().enumerate();
        values
            .filter(|(i, _)| out(*i))
            .for_each(|(_, v)| *v = f64::NAN);
    };
    let dropped = |i: usize| i.wrapping_mul(2_654_435_761) % 1000 < 100;
    let mut some = recording.clone();
    without(&mut some.pump_speed_pct, dropped);
    without(&mut some.return_flow_m3_s, dropped);
    for side in [
        &mut some.pump_outlet_pressure_pa,
        &mut some.pump_inlet_pressure_pa,
    ] {
        side.iter_mut().for_each(|values| without(values, dropped));
    }
    let mut seldom = recording;
    for values in &mut seldom.pump_outlet_pressure_pa {
        without(values, |i| i % 10 != 0);
    }
    for recording in [some, seldom] {
        let screening = screen(&recording, 1.0, &ScreenOptions::default()).unwrap();
        let of = |channel| {
            let faults = &screening.channel(channel).unwrap().faults;
            let of_a_run = [Faults::STUCK, Faults::HELD, Faults::MISSING];
            move |i: usize| of_a_run.iter().any(|fault| faults[i].contains(*fault))
        };
        assert!((3000..3300).all(of(Channel::PumpSpeed)));
        assert!((1000..1200).all(of(Channel::ReturnFlow)));
        assert_eq!(
            screening.channel(Channel::PumpSpeed).unwrap().stuck.len(),
            1
        );
    }
}

#[test]
fn a_set_point_in_steps_is_never_frozen() {
    let recording = with_speed(12_000, 1.0, |t| 55.0 + 3.0 * ((t / 400.0).floor() % 5.0));
    let screening = screen(&recording, 1.0, &ScreenOptions::default()).unwrap();
    let speed = screening.channel(Channel::PumpSpeed).unwrap();
    assert_eq!(speed.stuck, []);
    assert!(screening.keep().iter().all(|k| *k));
}
