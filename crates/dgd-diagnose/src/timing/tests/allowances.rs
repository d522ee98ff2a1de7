//! Claims about the delays and lags of a sound rig that are allowed for.

use crate::record::Record;
use crate::relations::Applied;
use crate::tangent::Bend;
use crate::test_rig::{Hidden, drilled, one, tangent_at};
use crate::timing::allowances_with;
use dgd_effects::Timing;
use dgd_lsq::dot;

fn drilling(late_s: f64, lag_s: f64) -> Record {
    drilled(Hidden {
        late_s,
        lag_s,
        ..Hidden::default()
    })
}

/// What is allowed for on top of `start`, with its values.
fn allowed(
    record: &Record,
    start: &[Applied],
    decided_on: Option<Timing>,
) -> Vec<(&'static str, f64)> {
    let state = allowances_with(record, start, &[], Bend::Stiff, decided_on).unwrap();
    for (start, kept) in start.iter().zip(&state) {
        assert_eq!(start.parameters, kept.parameters);
        assert_eq!(start.allowance, kept.allowance);
    }
    let more = &state[start.len()..];
    assert!(more.iter().all(|a| a.allowance));
    (more.iter()).map(|a| (a.id(), a.parameters[0])).collect()
}

#[test]
fn a_drill_string_that_answers_late_is_not_put_down_to_the_meter() {
    let mut record = drilling(0.0, 0.0);
    let inflow = record.mud_pump.clone();
    for i in 1..inflow.len() - 1 {
        record.mud_pump[i] += 3.0 * (inflow[i + 1] - inflow[i - 1]) / (2.0 * record.dt_s);
    }
    record.filled.mud_pump.clone_from(&record.mud_pump);
    assert_eq!(allowed(&record, &[], None), [("u_tube", 3.0)]);
}

/// A delay comes out up to half a second too long, a step of what is tried: most likely the inertia of the line, told from means of
/// blocks, falls short where the flow changes quickly.
#[test]
fn what_answers_late_is_allowed_for_at_its_time_and_nothing_else_is() {
    for (late_s, lag_s) in [(1.0, 0.0), (2.0, 0.0), (1.5, 3.0), (2.5, 2.0)] {
        let found = allowed(&drilling(late_s, lag_s), &[], None);
        let of = |id: &str| found.iter().find(|f| f.0 == id).map_or(0.0, |f| f.1);
        assert_eq!(of("pump_speed_lag"), lag_s, "{found:?}");
        let meter = of("return_flow_delay");
        assert!((late_s..=late_s + 0.5).contains(&meter), "{found:?}");
        assert_eq!(found.len(), if lag_s > 0.0 { 2 } else { 1 });
    }
}

#[test]
fn each_allowance_earns_its_place_and_no_other_time_is_better() {
    for (late_s, lag_s) in [
        (0.0, 1.0),
        (0.0, 3.0),
        (0.0, 2.5),
        (1.0, 2.0),
        (2.0, 0.0),
        (2.0, 3.0),
    ] {
        let record = drilling(late_s, lag_s);
        let state = allowances_with(&record, &[], &[], Bend::Stiff, None).unwrap();
        let tangent = tangent_at(&record, &state);
        let misfit = |state: &[Applied]| {
            let off = tangent.refitted(&record, state).off;
            0.5 * dot(&off, &off)
        };
        let least = misfit(&state);
        assert!(!state.is_empty());
        for k in 0..state.len() {
            let mut other = state.clone();
            let about = state[k].effect.about();
            if about.search.timing.is_none() {
                continue;
            }
            for value in about.search.allowance {
                other[k].parameters[0] = *value;
                assert!(misfit(&other) > least - 0.05, "{} {value}", about.id);
            }
            other.remove(k);
            assert!(misfit(&other) > least + 2.0, "{}", about.id);
        }
    }
}

#[test]
fn what_is_held_or_settled_is_not_allowed_for_again() {
    let record = drilling(2.0, 3.0);
    let held = [one("return_flow_delay", &[2.0])];
    assert_eq!(allowed(&record, &held, None), [("pump_speed_lag", 3.0)]);
    let unknown = |decided_on| {
        let found = allowed(&record, &[], Some(decided_on));
        found.iter().map(|f| f.0).collect::<Vec<_>>()
    };
    assert!(!unknown(Timing::Pump).contains(&"pump_speed_lag"));
    assert!(unknown(Timing::Pump).contains(&"return_flow_delay"));
    assert!(!unknown(Timing::Meter).contains(&"return_flow_delay"));
    assert!(unknown(Timing::Meter).contains(&"pump_speed_lag"));
}
