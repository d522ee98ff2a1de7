//! Claims about what the same effect explains at other times.
#![allow(clippy::unwrap_used, reason = "a test may fail by panic")]

use super::{beyond, other_times, placebo};
use crate::diagnosis::Check;
use crate::record::Record;
use crate::scan::{Candidate, weigh};
use crate::selection::{Named, Selection};
use crate::tangent::{Bend, Tangent};
use crate::test_rig::{DT_S, Hidden, INFLUX_S, SPEED_PCT, drilled, named, steady};
use dgd_lsq::dot;
use dgd_units::STANDARD_GRAVITY_M_S2;

fn selected(named: Vec<Named>) -> Selection {
    Selection {
        held: 0,
        allowances: Vec::new(),
        named,
        first: Vec::new(),
        stays: false,
    }
}

fn with_influx() -> Record {
    drilled(Hidden {
        influx_m3_s: 3e-3,
        ..Hidden::default()
    })
}

fn influx(onset_s: f64) -> Named {
    named("influx", &[3e-3, onset_s, INFLUX_S.1, INFLUX_S.2])
}

/// Percent that the best placebo explains, of what the finding does.
fn share(check: &Check) -> f64 {
    let (_, told) = check.detail.split_once("explains ").unwrap();
    told.trim_end_matches(" %").parse().unwrap()
}

/// The same drilling with a second influx 1782 s after the first, whose pump lifts from the level that this makes.
fn with_another(mut record: Record, rate_m3_s: f64) -> Record {
    let s = &record.setting;
    let pa_m3 = s.density_kg_m3 * STANDARD_GRAVITY_M_S2 / s.riser_area_m2;
    let (from, lasts, rise) = (INFLUX_S.0 + 1782.0, INFLUX_S.1, INFLUX_S.2);
    let mut more_pa = 0.0;
    for i in 0..record.t_s.len() {
        record.inlet[i] += more_pa;
        // Head `45e5·(w/70)²` less what flow takes.
        record.speed[i] = (record.speed[i].powi(2) - SPEED_PCT.powi(2) * more_pa / 45e5).sqrt();
        let x = (record.t_s[i] + 0.5 * DT_S - from) / lasts;
        let share = (x / rise).min((1.0 - x) / rise).clamp(0.0, 1.0);
        more_pa += pa_m3 * rate_m3_s * share * DT_S;
    }
    record.filled.inlet.clone_from(&record.inlet);
    record.filled.speed.clone_from(&record.speed);
    record
}

#[test]
fn an_influx_that_came_again_nearly_as_strong_fails_its_placebo_and_one_that_came_again_weakly_does_not()
 {
    for (again, passed) in [(0.3, true), (0.9, false)] {
        let record = with_another(with_influx(), again * 3e-3);
        let checks = placebo(&record, &selected(vec![influx(INFLUX_S.0)]));
        assert_eq!(checks[0].passed, passed, "{}", checks[0].detail);
        assert!(share(&checks[0]) > 2.0, "{}", checks[0].detail);
    }
}

#[test]
fn an_influx_explains_less_at_other_times_and_at_a_wrong_time_less_than_at_its_own() {
    let mut record = with_influx();
    // A clock that starts late: times are told as it has them.
    record.setting.span_s = (1000.0, 6400.0);
    record.t_s.iter_mut().for_each(|t| *t += 1000.0);
    let from = INFLUX_S.0 + 1000.0;
    for (onset, passed) in [(from, true), (from + 1782.0, false)] {
        let checks = placebo(&record, &selected(vec![influx(onset)]));
        let [check] = &checks[..] else {
            panic!("{checks:?}");
        };
        assert_eq!(check.name, "influx: explains less at any other onset");
        assert_eq!(check.passed, passed, "{}", check.detail);
        let own = format!(" at {onset:.0} s, the best of 5 other times, ");
        assert!(check.detail.contains(&own), "{}", check.detail);
        assert_eq!(share(check) < 20.0, passed, "{}", check.detail);
    }
    // What is there all the time has no other time; beside it the influx shows what it does beside nothing else.
    let gain = named("return_flow_gain", &[0.0]);
    let both = placebo(&record, &selected(vec![gain, influx(from)]));
    let alone = placebo(&record, &selected(vec![influx(from)]));
    assert_eq!(both.len(), 1);
    assert_eq!(both, alone);
}

#[test]
fn what_explains_next_to_nothing_by_itself_has_no_placebo() {
    let told = |record: &Record, onset_s| placebo(record, &selected(vec![influx(onset_s)]));
    assert_eq!(told(&with_influx(), INFLUX_S.0).len(), 1);
    // No influx came.
    assert_eq!(told(&drilled(Hidden::default()), INFLUX_S.0), []);
    // One that sets in when the recording is over changes nothing.
    assert_eq!(told(&with_influx(), 5400.0), []);
}

#[test]
fn other_times_are_spread_and_do_not_meet_what_passes() {
    let record = steady(540);
    let times = |id: &str, parameters: &[f64]| other_times(&record, &named(id, parameters).applied);
    // Of 5400 s: an influx of 1300 s that begins at 2000 s fits before it and behind it.
    let passing = times("influx", &[3e-3, 2000.0, 1300.0, 0.15]);
    assert_eq!(passing.len(), 5);
    assert!(passing.is_sorted() && passing[0] <= 700.0 && passing[4] >= 3700.0);
    let clear = |at: &f64| (at - 2000.0).abs() >= 1300.0 && *at > 0.0 && at + 1300.0 < 5400.0;
    assert!(passing.iter().all(clear), "{passing:?}");
    // What stays on is on at every later onset: its other times are a tenth of the recording away.
    let staying = times("line_restriction", &[5.0, 4800.0]);
    assert_eq!(staying.len(), 5);
    assert!(staying.is_sorted() && staying[0] < 900.0 && staying[4] > 3400.0);
    assert!(staying.iter().all(|at| (at - 4800.0).abs() >= 540.0));
    assert_eq!(times("influx", &[3e-3, 1000.0, 4500.0, 0.15]), [0.0; 0]);
    assert_eq!(times("return_flow_gain", &[0.02]), [0.0; 0]);
}

#[test]
fn other_times_stand_in_the_middle_of_as_many_stretches() {
    let mut record = steady(540);
    record.setting.span_s = (1000.0, 6400.0);
    let times = |id: &str, parameters: &[f64]| other_times(&record, &named(id, parameters).applied);
    // Of 13 places in 40 from which an influx of 1300 s ends before 3000 s, or which it has left behind.
    let passing = times("influx", &[3e-3, 3000.0, 1300.0, 0.15]);
    assert_eq!(passing, [1205.0, 1410.0, 4382.5, 4690.0, 4895.0]);
    // What stays may set in up to a tenth of the recording before its end.
    let staying = times("line_restriction", &[5.0, 5800.0]);
    assert_eq!(staying, [1486.0, 2336.5, 3187.0, 4037.5, 4888.0]);
}

#[test]
fn a_placebo_counts_for_what_it_does_not_share_with_the_finding() {
    let candidate = |id: &str, signature: [f64; 2]| {
        let residual = [3.0, 4.0];
        Candidate {
            applied: named(id, &[]).applied,
            signature: signature.to_vec(),
            energy: dot(&signature, &signature),
            score: dot(&signature, &residual),
            evidence: 0.0,
        }
    };
    // Of either sign, and of one.
    let (any, one) = ("mud_density_change", "line_restriction");
    for (own, placebo, id, expected) in [
        ([1.0, 0.0], [0.0, 1.0], any, 8.0),
        ([1.0, 0.0], [0.6, 0.8], any, 8.0),
        ([2.0, 0.0], [0.6, 0.8], any, 8.0),
        ([2.0, 0.0], [0.3, -0.4], any, 8.0),
        ([2.0, 0.0], [0.3, -0.4], one, 0.0),
        ([2.0, 0.0], [0.3, 0.4], one, 8.0),
        // It is the finding over again.
        ([2.0, 0.0], [3.0, 0.0], any, 0.0),
        ([2.0, 0.0], [3.0, 0.05], any, 0.0),
        ([2.0, 0.0], [3.0, 0.15], any, 8.0),
    ] {
        let found = beyond(&candidate(any, own), &candidate(id, placebo));
        assert!(
            (found - expected).abs() < 1e-9,
            "{own:?} {placebo:?} {found}"
        );
    }
}

#[test]
fn the_evidence_told_is_what_the_finding_explains_beside_the_others() {
    let record = with_influx();
    let checks = placebo(&record, &selected(vec![influx(INFLUX_S.0)]));
    let tangent = Tangent::at(&record, &[], &[], Bend::Stiff).unwrap();
    let own = weigh(&record, &tangent, &[], influx(INFLUX_S.0).applied);
    let explained = 0.5 * own.score.powi(2) / own.energy;
    let told = format!("of the evidence of {explained:.0} at ");
    assert!(checks[0].detail.starts_with(&told), "{}", checks[0].detail);
}
