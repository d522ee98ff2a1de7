//! Claims about what a correction must exceed, and over which range it is drawn.

use super::made;
use crate::empirical::drawn::range;
use crate::empirical::{DRAWN, hurdle, plausible};
use crate::relations::Applied;
use crate::test_rig::steady;
use dgd_effects::{KNOTS, Place, Quantity, catalogue, unknown};

#[test]
fn a_quantity_has_the_range_that_all_but_the_last_fiftieths_of_it_lie_in() {
    let mut record = steady(100);
    record.setting.span_s = (640.0, 1640.0);
    let n = record.t_s.len();
    let even = |from: f64, to: f64, count: usize| -> Vec<f64> {
        (0..n)
            .map(|i| {
                if i < count {
                    from + (to - from) * i as f64 / count as f64
                } else {
                    0.0
                }
            })
            .collect()
    };
    record.filled.inlet = even(1e7, 2e7, n);
    record.filled.mud_pump = even(0.01, 0.03, n);
    record.filled.booster = even(0.0, 0.01, n);
    // Mud that stands and a pump that does not turn have no part in theirs.
    record.filled.flow = even(0.02, 0.05, n / 2);
    record.filled.speed = even(20.0, 70.0, n / 2);
    for (quantity, from, to) in [
        (Quantity::InletPressure, 1e7, 2e7),
        (Quantity::MudPumpFlow, 0.01, 0.03),
        (Quantity::BoosterFlow, 0.0, 0.01),
        (Quantity::ReturnFlow, 0.02, 0.05),
        (Quantity::PumpSpeed, 20.0, 70.0),
    ] {
        let (low, high) = range(&record, quantity).unwrap();
        assert!(
            ((low - from) / (to - from) - 0.02).abs() < 0.005,
            "{quantity:?}: {low}"
        );
        assert!(
            ((high - from) / (to - from) - 0.98).abs() < 0.005,
            "{quantity:?}: {high}"
        );
    }
    assert_eq!(range(&record, Quantity::Time), Some((640.0, 1640.0)));
    assert_eq!(range(&record, Quantity::Period), None);
    // An hour and a half after a start, and a flow that changes by a fiftieth of a litre a minute either way, are enough.
    let (from, to) = range(&record, Quantity::SinceStart).unwrap();
    assert!(from == 0.0 && (to.exp_m1() - 90.0).abs() < 2.0);
    let (from, to) = range(&record, Quantity::FlowRate).unwrap();
    assert!(from == -to && to > 0.0);
}

#[test]
fn what_answers_late_or_stands_for_the_flow_must_show_more() {
    use Quantity::{BoosterFlow, FlowRate, InletPressure, MudPumpFlow, PumpSpeed, Time};
    let of = |place, quantity| hurdle(&made(place, quantity, &[], 0.0));
    let head = |quantity| of(Place::Head, quantity);
    let friction = |quantity| of(Place::Friction, quantity);
    let balance = |quantity| of(Place::Balance, quantity);
    let reading = |quantity| of(Place::InletReading, quantity);
    assert!(head(InletPressure) > head(FlowRate));
    assert!(head(FlowRate) > head(BoosterFlow));
    assert!(head(BoosterFlow) > head(Time) && head(Time) == head(MudPumpFlow));
    assert!(friction(PumpSpeed) > 2.0 * friction(FlowRate));
    assert!(friction(FlowRate) > friction(InletPressure));
    assert!(friction(InletPressure) > friction(Time));
    assert!(head(Time) > friction(Time) && friction(Time) > balance(Time));
    assert!(balance(Time) == balance(PumpSpeed) && reading(Time) > balance(Time));
    assert!(reading(MudPumpFlow) > friction(Time) && balance(Time) > 9.0);
}

#[test]
fn no_correction_is_plausible_within_the_accuracy_of_instruments() {
    for (place, least) in DRAWN.into_iter().zip([3e3, 6e3, 1.5e-4, 6e3, 6e3, 4e-3]) {
        let spread = |by: f64, about: f64| -> bool {
            // As far above as below.
            let knots: Vec<f64> = (0..KNOTS)
                .map(|k| about + by * least * if k % 2 == 0 { 1.0 } else { -1.0 })
                .collect();
            plausible(&made(place, Quantity::Time, &knots, 0.0))
        };
        assert!(spread(1.01, 0.0) && !spread(0.99, 0.0), "{place:?}");
        // A constant is nothing but in the balance.
        assert_eq!(spread(0.5, 30.0 * least), place == Place::Balance);
        assert_eq!(spread(0.5, -30.0 * least), place == Place::Balance);
    }
}

#[test]
fn a_correction_is_the_one_effect_without_physics() {
    let is_correction = |effect| Applied::new(effect, Vec::new()).is_correction();
    assert!(is_correction(unknown()));
    assert!(!catalogue().iter().any(|effect| is_correction(*effect)));
}
