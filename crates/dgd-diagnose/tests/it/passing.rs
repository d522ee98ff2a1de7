//! What ends before the recording does, and what comes again.

use crate::rig::answer;
use dgd_diagnose::{Diagnosis, Verdict};
use dgd_plant::{Case, Kind, Level, Order, Severity, conceal};

/// A moderate case of level one.
fn case(seed: u64, kind: Kind, effect: &'static str) -> Case {
    let order = Order {
        seed,
        level: Level::One,
        kind,
        severity: Some(Severity::Moderate),
        effect: Some(effect),
        hours: Some(5.0),
        viscosity: 1.0,
    };
    conceal(&order, 0)
}

/// When the findings, all of which must be of one effect, are said to act, s, the earliest first.
#[track_caller]
fn times_of(found: &Diagnosis, effect: &str) -> Vec<(f64, f64)> {
    let named: Vec<&str> = found.findings.iter().map(|f| f.effect.as_str()).collect();
    assert!(named.iter().all(|name| *name == effect), "{named:?}");
    assert_eq!(found.verdict, Verdict::Explained);
    let mut times: Vec<(f64, f64)> = (found.findings.iter())
        .flat_map(|f| f.intervals_s.clone())
        .collect();
    times.sort_by(|a, b| a.0.total_cmp(&b.0));
    times
}

#[track_caller]
fn near((from, to): (f64, f64), expected: (f64, f64), within_s: f64) {
    let apart = (from - expected.0).abs().max((to - expected.1).abs());
    assert!(apart < within_s, "{from} to {to}, not {expected:?}");
}

#[test]
fn what_ends_is_named_with_its_end_and_its_size() {
    for (effect, seed, within_s) in [
        ("line_leak", 305, 60.0),
        ("line_restriction", 306, 60.0),
        ("outlet_pressure_bias_step", 307, 60.0),
        // It mixes in and out over minutes.
        ("mud_density_change", 308, 400.0),
    ] {
        let case = case(seed, Kind::Passing, effect);
        let found = answer(&case);
        let times = times_of(&found, effect);
        assert_eq!(times.len(), 1, "{effect}");
        near(times[0], case.hidden[0].interval_s.unwrap(), within_s);
        let told = &found.findings[0].parameters;
        assert!(told.iter().any(|p| p.name == "duration_s"), "{effect}");
        for (name, size) in &case.hidden[0].params {
            let told = told.iter().find(|p| p.name == *name).unwrap();
            assert!((told.estimate - size).abs() < 0.1 * size.abs(), "{effect}");
        }
    }
}

#[test]
fn what_comes_again_is_named_at_each_of_its_times() {
    for (effect, seed) in [("line_leak", 312), ("influx", 310)] {
        let case = case(seed, Kind::Recurring, effect);
        // A kick dies away over a third of its time.
        let within_s = if effect == "influx" { 400.0 } else { 60.0 };
        is_named_twice(&case, effect, within_s);
    }
}

#[track_caller]
fn is_named_twice(case: &Case, effect: &str, within_s: f64) {
    let times = times_of(&answer(case), effect);
    let [first, again] = times[..] else {
        panic!("{times:?}");
    };
    near(first, case.hidden[0].interval_s.unwrap(), within_s);
    near(again, case.hidden[0].again_s.unwrap(), within_s);
}

/// The meter of this recording freezes where the leak begins.
#[test]
fn where_nothing_tells_when_it_begins_the_interval_of_its_onset_does() {
    let case = case(309, Kind::Recurring, "line_leak");
    let found = answer(&case);
    assert_eq!(times_of(&found, "line_leak").len(), 2);
    for (begins, _) in [case.hidden[0].interval_s, case.hidden[0].again_s]
        .into_iter()
        .flatten()
    {
        let onsets = found.findings.iter().flat_map(|f| &f.parameters);
        let mut onsets = onsets.filter(|p| p.name == "onset_s");
        assert!(
            onsets.any(|p| p.ci95.0 <= begins && begins <= p.ci95.1),
            "{begins}"
        );
    }
}

/// A case of the proof (PROOF.md) with a seed that these answers have been built on since.
fn proved(seed: u64, level: Level, kind: Kind, number: usize) -> Case {
    let order = Order {
        seed,
        level,
        kind,
        severity: None,
        effect: None,
        hours: None,
        viscosity: 1.0,
    };
    conceal(&order, number)
}

/// Its evidence lies in the minutes about its ends, as transmitters of this level wander.
#[test]
fn a_shift_of_a_transmitter_that_wanders_is_found_by_both_its_ends() {
    let case = proved(577_399, Level::Two, Kind::Passing, 0);
    let times = times_of(&answer(&case), "outlet_pressure_bias_step");
    assert_eq!(times.len(), 1);
    near(times[0], case.hidden[0].interval_s.unwrap(), 60.0);
}

/// Most of it is lost within ten minutes.
#[test]
fn losses_that_cease_leave_no_influx() {
    let case = proved(577_399, Level::One, Kind::Passing, 24);
    let times = times_of(&answer(&case), "lost_circulation");
    let (_, ceases) = case.hidden[0].interval_s.unwrap();
    assert!((times[0].1 - ceases).abs() < 60.0, "{times:?}");
}

#[test]
fn a_choke_that_sticks_is_not_several_restrictions_that_end() {
    let found = answer(&proved(577_399, Level::One, Kind::Mix, 187));
    assert_eq!(found.verdict, Verdict::Unexplained);
}

#[test]
fn what_the_form_of_cuttings_lacks_is_no_change_of_the_mud_that_ends() {
    let found = answer(&proved(577_399, Level::One, Kind::Mix, 169));
    assert_eq!(found.findings.len(), 1);
    times_of(&found, "cuttings_loading");
}

/// In the first round it looks like one that lasts for hours, and bends.
#[test]
fn a_strong_kick_that_comes_twice_is_two() {
    let case = proved(587_407, Level::One, Kind::Recurring, 26);
    is_named_twice(&case, "influx", 400.0);
}

/// Two transmitters show what the minutes about its ends tell.
#[test]
fn a_strong_shift_that_comes_twice_is_no_reading_that_drifts() {
    let case = proved(587_407, Level::One, Kind::Recurring, 21);
    is_named_twice(&case, "outlet_pressure_bias_step", 10.0);
}
