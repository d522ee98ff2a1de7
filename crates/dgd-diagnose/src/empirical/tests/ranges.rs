//! Claims about what a correction must exceed, and over which range it is drawn.

use super::made;
use crate::empirical::{hurdle, is_correction, plausible, range};
use crate::test_rig::steady;
use dgd_effects::{KNOTS, PLACES, QUANTITIES, Relation, catalogue, unknown};

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
        (1, 1e7, 2e7),
        (2, 0.01, 0.03),
        (3, 0.0, 0.01),
        (4, 0.02, 0.05),
        (5, 20.0, 70.0),
    ] {
        let (low, high) = range(&record, quantity);
        assert!(
            ((low - from) / (to - from) - 0.02).abs() < 0.005,
            "{quantity}: {low}"
        );
        assert!(
            ((high - from) / (to - from) - 0.98).abs() < 0.005,
            "{quantity}: {high}"
        );
    }
    assert_eq!(range(&record, 0), (640.0, 1640.0));
    // An hour and a half after a start, and a flow that changes by a fiftieth of a litre a minute either way, are enough.
    let (from, to) = range(&record, 6);
    assert!(from == 0.0 && (to.exp_m1() - 90.0).abs() < 2.0);
    let (from, to) = range(&record, 7);
    assert!(from == -to && to > 0.0);
}

#[test]
fn what_answers_late_or_stands_for_the_flow_must_show_more() {
    let of = |relation: Relation, quantity: &str| {
        let place = PLACES.iter().position(|p| p.relation == relation).unwrap();
        let quantity = QUANTITIES.iter().position(|q| q.name == quantity).unwrap();
        hurdle(&made(place, quantity, &[], 0.0))
    };
    let head = |quantity| of(Relation::PumpHead, quantity);
    let friction = |quantity| of(Relation::ReturnLineFriction, quantity);
    let balance = |quantity| of(Relation::RiserMassBalance, quantity);
    let reading = |quantity| of(Relation::Instrument, quantity);
    assert!(head("inlet pressure") > head("rate of the return flow"));
    assert!(head("rate of the return flow") > head("booster flow"));
    assert!(head("booster flow") > head("time") && head("time") == head("mud pump flow"));
    assert!(friction("pump speed") > 2.0 * friction("rate of the return flow"));
    assert!(friction("rate of the return flow") > friction("inlet pressure"));
    assert!(friction("inlet pressure") > friction("time"));
    assert!(friction("time") == head("time") && head("time") > balance("time"));
    assert!(balance("time") == balance("pump speed") && balance("time") == reading("time"));
    assert!(reading("mud pump flow") > friction("time") && balance("time") > 9.0);
}

#[test]
fn no_correction_is_plausible_within_the_accuracy_of_instruments() {
    for (place, least) in [3e3, 6e3, 1.5e-4, 6e3, 6e3, 4e-3].into_iter().enumerate() {
        let spread = |by: f64, about: f64| -> bool {
            // As far above as below.
            let knots: Vec<f64> = (0..KNOTS)
                .map(|k| about + by * least * if k % 2 == 0 { 1.0 } else { -1.0 })
                .collect();
            plausible(&made(place, 0, &knots, 0.0))
        };
        assert!(spread(1.01, 0.0) && !spread(0.99, 0.0), "{place}");
        // A constant is nothing but in the balance.
        assert_eq!(spread(0.5, 30.0 * least), place == 2);
        assert_eq!(spread(0.5, -30.0 * least), place == 2);
    }
}

#[test]
fn a_correction_is_the_one_effect_without_physics() {
    assert!(is_correction(unknown()));
    for effect in catalogue() {
        assert_eq!(is_correction(*effect), effect.about().id == "unknown");
    }
}
