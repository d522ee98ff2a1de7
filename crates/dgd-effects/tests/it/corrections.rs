//! The correction without physics: along which quantity, and to what, it is made.

use crate::{close, drive, model, moments, setting};
use dgd_effects::{
    Changes, Curve, KNOTS, Moment, Place, Quantity, Setting, catalogue, find, unknown,
};

/// What a quantity is at a moment.
type Of = fn(&Moment) -> f64;

/// Knots that rise by one each, so that a correction tells its own position among them.
fn line(place: Place, quantity: Quantity, from: f64, to: f64) -> Curve {
    Curve::new(
        place,
        quantity,
        (from, to),
        (0..KNOTS).map(|k| k as f64).collect(),
    )
}

fn run(curve: &Curve, moments: &[Moment]) -> Vec<Changes> {
    drive("unknown", &curve.parameters(), &setting(), moments)
}

/// What a line along time does in a place.
fn along_time(place: Place) -> Vec<Changes> {
    run(&line(place, Quantity::Time, 0.0, 6000.0), &moments())
}

/// Where a quantity lies between the ends, as the balance's correction has it.
fn position(quantity: Quantity, from: f64, to: f64, moments: &[Moment]) -> Vec<f64> {
    run(&line(Place::Balance, quantity, from, to), moments)
        .iter()
        .map(|c| c.inflow_m3_s / (KNOTS - 1) as f64)
        .collect()
}

#[test]
fn a_correction_follows_its_quantity() {
    let at = moments();
    let quantities: [(Quantity, f64, f64, Of); 6] = [
        (Quantity::Time, -10.0, 6100.0, |m| m.t_s),
        (Quantity::InletPressure, 150e5, 180e5, |m| m.inlet_pa),
        (Quantity::MudPumpFlow, -0.01, 0.05, |m| m.mud_pump_m3_s),
        (Quantity::BoosterFlow, 0.0, 0.02, |m| m.booster_m3_s),
        (Quantity::ReturnFlow, -0.02, 0.06, |m| m.flow_m3_s),
        (Quantity::PumpSpeed, -5.0, 100.0, |m| m.speed_pct),
    ];
    for (quantity, from, to, of) in quantities {
        for (m, found) in at.iter().zip(position(quantity, from, to, &at)) {
            close(found, (of(m) - from) / (to - from), 1e-9);
        }
    }
}

#[test]
fn the_time_since_the_pump_started_counts_from_its_last_start_in_minutes() {
    let found = position(Quantity::SinceStart, -1.0, 9.0, &moments());
    // It stands from 3100 s to 3300 s, and had turned for an hour before the recording.
    for (i, found) in found.into_iter().enumerate() {
        let since = match i {
            0..3100 => 3601.0 + i as f64,
            3100..3300 => 0.0,
            _ => i as f64 - 3299.0,
        };
        close(found, ((1.0 + since / 60.0).ln() + 1.0) / 10.0, 1e-9);
    }
}

#[test]
fn the_time_of_a_period_begins_again_with_each() {
    let found = position(Quantity::Period, 500.0, 1300.0, &moments());
    for (i, found) in found.into_iter().enumerate() {
        // 500 s lie before the first one: they end another.
        let within = (i + 300) % 800;
        close(found, within as f64 / 800.0, 1e-9);
    }
    // A period of no length has no time, and a code beyond the last no quantity.
    let none = line(Place::Balance, Quantity::Period, 500.0, 500.0).parameters();
    let mut beyond = line(Place::Balance, Quantity::Period, 500.0, 1300.0).parameters();
    beyond[1] = Quantity::ALL.len() as f64;
    for parameters in [none, beyond] {
        let found = drive("unknown", &parameters, &setting(), &moments());
        assert!(found.iter().all(|c| *c == Changes::default()));
    }
}

#[test]
fn a_correction_takes_as_many_knots_as_it_is_fine() {
    let unknown = find("unknown").unwrap();
    let least = unknown.about().parameters.len();
    assert!(unknown.takes(least) && unknown.takes(least + 1) && unknown.takes(1000));
    assert!(!unknown.takes(least - 1));
    // Three times as many draw the same line.
    let fine = Curve {
        knots: (0..34).map(|k| f64::from(k) / 3.0).collect(),
        ..line(Place::Balance, Quantity::Time, 0.0, 6000.0)
    };
    let coarse = along_time(Place::Balance);
    for (coarse, fine) in coarse.iter().zip(run(&fine, &moments())) {
        close(coarse.inflow_m3_s, fine.inflow_m3_s, 1e-9);
    }
    for effect in catalogue().iter().filter(|e| e.about().id != "unknown") {
        let own = effect.about().parameters.len();
        assert!(effect.takes(own) && !effect.takes(own + 1));
    }
}

#[test]
fn the_rate_of_the_flow_is_that_of_some_twenty_seconds() {
    let moment = |i: usize, dt_s: f64, flow_m3_s: f64| Moment {
        index: i,
        t_s: dt_s * i as f64,
        dt_s,
        flow_m3_s,
        outflow_m3_s: flow_m3_s,
        ..moments()[0]
    };
    for rate in [2e-5, -3e-5] {
        // In small steps, long after the ramp began.
        let ramp: Vec<Moment> = (0..4000)
            .map(|i| moment(i, 0.1, 0.03 + rate * 0.1 * i as f64))
            .collect();
        let found = position(Quantity::FlowRate, -1e-4, 1e-4, &ramp);
        close((2.0 * found[3999] - 1.0) * 1e-4, rate, 0.01);
        assert!((found[0] - 0.5).abs() < 1e-9);
        // Half of a change is gone after 20 s ln 2.
        let mut step = vec![moment(0, 0.1, 0.03); 10];
        step.extend((10..300).map(|i| moment(i, 0.1, 0.03 + 20.0 * rate)));
        let found = position(Quantity::FlowRate, -1e-4, 1e-4, &step);
        close((2.0 * found[148] - 1.0) * 1e-4, 0.5 * rate, 0.01);
    }
    // Of a steady ramp its slope, however seldom it is read.
    for dt_s in [0.5, 5.0, 20.0, 30.0] {
        let ramp: Vec<Moment> = (0..400)
            .map(|i| moment(i, dt_s, 0.03 + 2e-5 * dt_s * i as f64))
            .collect();
        let found = position(Quantity::FlowRate, -1e-4, 1e-4, &ramp);
        close((2.0 * found[399] - 1.0) * 1e-4, 2e-5, 1e-3);
    }
    // A gap is forgotten.
    let slow = [0.03, 0.031, f64::NAN, 0.032].map(|q| moment(0, 20.0, q));
    let found = position(Quantity::FlowRate, -1e-4, 1e-4, &slow);
    for (i, expected) in [(0, 0.5), (1, 0.75), (3, 0.75)] {
        assert!((found[i] - expected).abs() < 1e-9, "{found:?}");
    }
    assert_eq!(found[2], 0.0);
}

#[test]
fn a_reading_is_off_by_its_correction() {
    let inlet = along_time(Place::InletReading);
    let outlet = along_time(Place::OutletReading);
    for (i, (inlet, outlet)) in inlet.iter().zip(&outlet).enumerate().skip(1) {
        let expected = (KNOTS - 1) as f64 * i as f64 / 6000.0;
        close(inlet.inlet_bias_pa[0], expected, 1e-9);
        assert_eq!(inlet.inlet_bias_pa[0], inlet.inlet_bias_pa[1]);
        assert_eq!(inlet.outlet_bias_pa, [0.0; 2]);
        close(outlet.outlet_bias_pa[0], expected, 1e-9);
        assert_eq!(outlet.outlet_bias_pa[0], outlet.outlet_bias_pa[1]);
        assert_eq!(outlet.inlet_bias_pa, [0.0; 2]);
    }
}

#[test]
fn what_is_lost_before_the_inlet_is_lost_to_the_pump_and_to_its_reading() {
    let lost = along_time(Place::Suction);
    let riser = along_time(Place::RiserReading);
    for (i, (lost, riser)) in lost.iter().zip(&riser).enumerate() {
        let by = (KNOTS - 1) as f64 * i as f64 / 6000.0;
        let expected = Changes {
            inlet_bias_pa: lost.inlet_bias_pa,
            head_pa: lost.inlet_bias_pa[0],
            ..Changes::default()
        };
        assert_eq!(*lost, expected);
        assert_eq!(lost.inlet_bias_pa[0], lost.inlet_bias_pa[1]);
        close(lost.head_pa, by, 1e-9);
        let expected = Changes {
            riser_bias_pa: riser.riser_bias_pa,
            ..Changes::default()
        };
        assert_eq!(*riser, expected);
        close(riser.riser_bias_pa, by, 1e-9);
    }
}

#[test]
fn one_of_two_transmitters_is_off_by_itself() {
    for (place, inlet, k) in [
        (Place::FirstInlet, true, 0),
        (Place::SecondInlet, true, 1),
        (Place::FirstOutlet, false, 0),
        (Place::SecondOutlet, false, 1),
    ] {
        for (i, c) in along_time(place).iter().enumerate() {
            let mut expected = Changes::default();
            let (bias, found) = if inlet {
                (&mut expected.inlet_bias_pa, c.inlet_bias_pa)
            } else {
                (&mut expected.outlet_bias_pa, c.outlet_bias_pa)
            };
            bias[k] = found[k];
            close(bias[k], (KNOTS - 1) as f64 * i as f64 / 6000.0, 1e-9);
            assert_eq!(*c, expected);
        }
    }
}

#[test]
fn a_meters_factor_is_true_over_indicated_and_stays_one_of_a_meter() {
    let off = |knot: f64| {
        let level = Curve {
            knots: vec![knot; KNOTS],
            ..line(Place::MeterFactor, Quantity::Time, 0.0, 6000.0)
        };
        run(&level, &moments())
    };
    for (knot, factor) in [(0.03, 1.03), (-0.2, 0.8), (7.0, 3.0), (-7.0, 0.33)] {
        for c in off(knot) {
            close(c.meter_gain, 1.0 / factor, 1e-12);
            assert_eq!(
                c,
                Changes {
                    meter_gain: c.meter_gain,
                    ..Changes::default()
                }
            );
        }
    }
}

#[test]
fn a_finer_curve_than_a_model_holds_is_followed_too() {
    let mut fine = line(Place::Balance, Quantity::Time, 0.0, 6000.0);
    fine.knots = vec![0.0; 601];
    fine.knots[300] = 1.0;
    for (i, c) in run(&fine, &moments()).iter().enumerate() {
        close(
            c.inflow_m3_s,
            (1.0 - (i as f64 - 3000.0).abs() / 10.0).max(0.0),
            1e-9,
        );
    }
}

#[test]
fn a_correction_remembers_as_long_as_the_knots_after_a_start_last() {
    // They end at `ln(1 + minutes)` of 4.5.
    let last = 60.0 * 4.5_f64.exp_m1();
    let memory =
        unknown().memory_s(&line(Place::Friction, Quantity::SinceStart, 0.0, 4.5).parameters());
    assert!((last..2.0 * last).contains(&memory), "{memory}");
}

#[test]
fn an_episode_acts_between_its_times_alone() {
    let (value, moments) = (2e-3, moments());
    for times in [(1000.0, Some(1500.0)), (1000.0, None)] {
        let changes = run(&Curve::episode(Place::Balance, times, value), &moments);
        for (moment, c) in moments.iter().zip(&changes) {
            let acts = moment.t_s >= times.0 && times.1.is_none_or(|to| moment.t_s <= to);
            let expected = if acts { value } else { 0.0 };
            assert!(
                (c.inflow_m3_s - expected).abs() < 1e-15,
                "{times:?} at {}",
                moment.t_s
            );
        }
    }
}

#[test]
fn on_a_later_recording_an_episode_goes_on_from_its_start_or_is_over() {
    let carried = |times: (f64, Option<f64>)| {
        let curve = Curve::episode(Place::Head, times, -4e4);
        let mut model = model(&[("unknown", &curve.parameters())]);
        let told = model.carry_over(&Setting {
            span_s: (100.0, 4000.0),
            ..setting()
        });
        let left = model
            .effects
            .first()
            .map(|e| Curve::read(&e.parameters).unwrap());
        (left, told.ongoing, told.over)
    };
    let from_there = Curve::episode(Place::Head, (100.0, None), -4e4);
    assert_eq!(
        carried((7000.0, None)),
        (Some(from_there), vec!["unknown"], vec![])
    );
    assert_eq!(
        carried((7000.0, Some(7800.0))),
        (None, vec![], vec!["unknown"])
    );
}
