//! Claims about what was looked for and how small it would have been seen.
#![allow(clippy::unwrap_used, reason = "a test may fail by panic")]

use super::{placebo, tested};
use crate::Simulation;
use crate::claims::fixture::{DT_S, Hidden, INFLUX_S, SPEED_PCT, drilled, named, steady};
use crate::diagnosis::{Outcome, Tested};
use crate::finding::heaving;
use crate::heave::Swell;
use crate::limit::{Energy, Showing};
use crate::record::Record;
use crate::relations::Applied;
use crate::select::{First, Named, Selection};
use dgd_effects::{Connection, Excitation, Method, catalogue, find};
use dgd_units::STANDARD_GRAVITY_M_S2;

fn selected(named: Vec<Named>, first: Vec<First>) -> Selection {
    Selection {
        held: 0,
        allowances: Vec::new(),
        named,
        first,
    }
}

const SWELL: Swell = Swell {
    period_s: 10.0,
    period_sd_s: 0.1,
    amplitude_m: 0.1,
    ratio: 2.0,
    limit_m: 0.04,
};

/// All effects as they fared on a recording in which each by itself showed evidence of 2 and an energy of 25.
fn fared(record: &Record, swell: Option<Swell>, start: &[Applied], but: &str) -> Vec<Tested> {
    let first = |id| First {
        id,
        evidence: 2.0,
        energy: 25.0,
        admissible: true,
        showing: Some(Showing {
            energy: Energy::Unit(25.0),
            hurdle: 7.0,
            before: 0.0,
        }),
    };
    let ids = catalogue().iter().map(|e| e.about().id);
    let selection = selected(Vec::new(), ids.filter(|id| *id != but).map(first).collect());
    tested(record, &selection, &[], start, swell)
}

fn outcome<'a>(of: &'a [Tested], id: &str) -> &'a Outcome {
    &of.iter().find(|t| t.effect == id).unwrap().outcome
}

#[test]
fn a_recording_that_lacks_what_an_effect_needs_cannot_show_it() {
    // Nothing stops and the booster stays within a litre a second.
    let mut record = steady(90);
    record.filled.booster[7] += 0.9e-3;
    let needing = |need: Excitation| {
        let effects = catalogue().iter().map(|e| e.about());
        effects
            .filter(move |a| a.search.needs.contains(&need))
            .map(|a| a.id)
    };
    let says = |record: &Record, swell, need, why: &str| {
        let found = fared(record, swell, &[], "");
        let mut count = 0;
        for id in needing(need) {
            let expected = Outcome::NotTestable(why.to_owned());
            assert_eq!(*outcome(&found, id) == expected, !why.is_empty(), "{id}");
            if why.is_empty() {
                assert_eq!(*outcome(&found, id), Outcome::NotSeen, "{id}");
            }
            count += 1;
        }
        assert!(count > 0);
    };
    says(
        &record,
        None,
        Excitation::PumpStops,
        "the subsea pump never stops",
    );
    says(
        &record,
        None,
        Excitation::Connections,
        "the mud pump never stops",
    );
    says(
        &record,
        None,
        Excitation::BoosterSteps,
        "the booster flow does not change",
    );
    says(
        &record,
        None,
        Excitation::FastSampling,
        "the sampling is too slow to show swell",
    );
    // A pump that only starts has not stopped.
    record.filled.pumping[..50].fill(false);
    says(
        &record,
        None,
        Excitation::PumpStops,
        "the subsea pump never stops",
    );
    record.filled.pumping[100..150].fill(false);
    record.setting.connections = vec![Connection {
        from_s: 100.0,
        to_s: 200.0,
    }];
    record.filled.booster[9] -= 0.2e-3;
    for need in [
        Excitation::PumpStops,
        Excitation::Connections,
        Excitation::BoosterSteps,
        Excitation::FastSampling,
    ] {
        says(&record, Some(SWELL), need, "");
    }
}

#[test]
fn what_nothing_excites_is_not_testable_and_what_the_model_holds_is_not_told() {
    let record = steady(90);
    let start = [named("inflow_gain", &[0.01]).applied];
    let found = fared(&record, Some(SWELL), &start, "influx");
    assert_eq!(found.len(), catalogue().len() - 1);
    assert!(found.iter().all(|t| t.effect != "inflow_gain"));
    let none = Outcome::NotTestable("nothing in the recording excites it".to_owned());
    assert_eq!(*outcome(&found, "influx"), none);
    // Swell is sought in a spectrum, which is there.
    let heave = find("heave").unwrap().about();
    assert_eq!(heave.search.method, Method::Spectrum);
    let without = fared(&record, Some(SWELL), &start, "heave");
    assert_eq!(*outcome(&without, "heave"), Outcome::NotSeen);
    let nothing_run = Simulation {
        t_s: Vec::new(),
        held_out: Vec::new(),
        valid: Vec::new(),
        signals: Vec::new(),
    };
    let swelling = [heaving(&record, heave, SWELL, &nothing_run)];
    let told = tested(
        &record,
        &selected(Vec::new(), Vec::new()),
        &swelling,
        &[],
        None,
    );
    assert_eq!(*outcome(&told, "heave"), Outcome::Found);
}

/// Strength and standard error are of the first round, the limit is of the last one.
#[test]
fn what_was_looked_for_is_told_with_its_standard_error_and_its_limit_in_the_scale_that_is_reported()
{
    let record = steady(90);
    let found = fared(&record, Some(SWELL), &[], "lost_circulation");
    for one in &found {
        let about = find(one.effect).unwrap().about();
        assert_eq!(one.hurdle, about.search.belief.hurdle);
        if one.effect == "heave" {
            assert_eq!((one.strength, one.limit), ("amplitude_m", Some(0.04)));
            continue;
        }
        assert_eq!(one.strength, about.parameters[0].name);
        if one.effect == "lost_circulation" {
            assert_eq!((one.standard_error, one.limit), (None, None));
            assert_eq!((one.evidence, one.admissible), (0.0, false));
            continue;
        }
        assert_eq!((one.evidence, one.admissible), (2.0, true));
        // Areas are told in m², by the riser's.
        let unit = if one.effect == "annulus_area" {
            record.setting.riser_area_m2
        } else {
            1.0
        };
        let error = one.standard_error.unwrap() / unit;
        assert!((error - 0.2).abs() < 1e-12, "{}", one.effect);
        // Evidence `a²·25/2` of 10 by a strength of 0.894.
        let strength = 0.8_f64.sqrt().max(about.search.least.unwrap_or(0.0));
        let told = (strength < about.parameters[0].high).then_some(strength);
        let limit = one.limit.map(|limit| limit / unit);
        assert_eq!(limit.is_some(), told.is_some(), "{}", one.effect);
        assert!((limit.unwrap_or(0.0) - told.unwrap_or(0.0)).abs() < 1e-9);
    }
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

/// What is held against it is less than seven tenths of the evidence; of an influx that goes with the square of its rate.
#[test]
fn an_influx_that_came_again_by_two_thirds_is_told_from_its_placebo_and_one_nearly_as_strong_is_not()
 {
    let (from, lasts, rise) = INFLUX_S;
    for (share, passed) in [(2.0 / 3.0, true), (0.95, false)] {
        let hidden = Hidden {
            influx_m3_s: 3e-3,
            ..Hidden::default()
        };
        let record = with_another(drilled(hidden), share * 3e-3);
        let influx = named("influx", &[3e-3, from, lasts, rise]);
        let checks = placebo(&record, &selected(vec![influx], Vec::new()));
        assert_eq!(checks[0].passed, passed, "{}", checks[0].detail);
        let (more, less) = checks[0].detail.split_once(" s, ").unwrap();
        let number = |text: &str| -> f64 {
            let words = text.trim_start_matches("ln Bayes factor ").split(' ');
            words.into_iter().next().unwrap().parse().unwrap()
        };
        assert!(
            number(more) > number(less) && number(less) > 5.0,
            "{}",
            checks[0].detail
        );
    }
}

#[test]
fn an_influx_explains_less_a_third_of_the_recording_away() {
    let mut record = drilled(Hidden {
        influx_m3_s: 3e-3,
        ..Hidden::default()
    });
    // A clock that starts at 1000 s.
    record.setting.span_s = (1000.0, 6400.0);
    record.t_s.iter_mut().for_each(|t| *t += 1000.0);
    let (from, lasts, rise) = (INFLUX_S.0 + 1000.0, INFLUX_S.1, INFLUX_S.2);
    let influx = |onset| named("influx", &[3e-3, onset, lasts, rise]);
    // From there later, if half an hour is left of the 5400 s then; else earlier.
    for (onset, moved, passed) in [
        (from, from + 1782.0, true),
        (2817.0, 4599.0, true),
        (2818.0, 1036.0, true),
        (from + 1782.0, from, false),
    ] {
        let checks = placebo(&record, &selected(vec![influx(onset)], Vec::new()));
        let [check] = &checks[..] else {
            panic!("{checks:?}");
        };
        assert_eq!(check.name, "influx: placebo at another time explains less");
        assert_eq!(check.passed, passed, "{}", check.detail);
        let times = (format!(" at {onset:.0} s, "), format!(" at {moved:.0} s"));
        let told = check.detail.contains(&times.0) && check.detail.ends_with(&times.1);
        assert!(told, "{}", check.detail);
    }
    // What is there all the time has no other time; beside it the influx shows what it does beside nothing else.
    let gain = named("return_flow_gain", &[0.0]);
    let both = placebo(&record, &selected(vec![gain, influx(from)], Vec::new()));
    let alone = placebo(&record, &selected(vec![influx(from)], Vec::new()));
    assert_eq!(both.len(), 1);
    assert_eq!(both, alone);
}
