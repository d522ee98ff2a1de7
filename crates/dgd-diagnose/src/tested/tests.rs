//! Claims about what was looked for and how small it would have been seen.
#![allow(clippy::unwrap_used, reason = "a test may fail by panic")]

use super::{placebo, tested};
use crate::Simulation;
use crate::claims::fixture::{Hidden, INFLUX_S, drilled, steady};
use crate::diagnosis::{Outcome, Tested};
use crate::finding::heaving;
use crate::heave::Swell;
use crate::record::Record;
use crate::relations::Applied;
use crate::select::{First, Named, Selection};
use dgd_effects::{Connection, Excitation, Method, catalogue, find};

fn named(id: &str, parameters: &[f64]) -> Named {
    Named {
        applied: Applied::new(find(id).unwrap(), parameters.to_vec()),
        evidence: 40.0,
        bent: 0.0,
        hurdle: 3.5,
        probability: 0.9,
        alternatives: Vec::new(),
        correction: None,
    }
}

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
};

/// All effects as they fared on a recording in which each by itself showed evidence of 2 and an energy of 25.
fn fared(record: &Record, swell: Option<Swell>, start: &[Applied], but: &str) -> Vec<Tested> {
    let first = |id| First {
        id,
        evidence: 2.0,
        energy: 25.0,
        admissible: true,
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

/// The strength a whose evidence, `a²·energy/2`, is three e-folds above the hurdle.
#[test]
fn the_limit_is_the_strength_that_would_have_passed_the_hurdle_by_three() {
    let record = steady(90);
    let found = fared(&record, Some(SWELL), &[], "lost_circulation");
    for one in &found {
        let about = find(one.effect).unwrap().about();
        assert_eq!(
            (one.hurdle, one.strength),
            (about.search.belief.hurdle, about.parameters[0].name)
        );
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
        let (error, limit) = (
            one.standard_error.unwrap() / unit,
            one.limit.unwrap() / unit,
        );
        assert!((error - 0.2).abs() < 1e-12, "{}", one.effect);
        assert!((0.5 * limit * limit * 25.0 - one.hurdle - 3.0).abs() < 1e-9);
    }
}

#[test]
fn an_influx_explains_less_a_third_of_the_recording_away() {
    let record = drilled(Hidden {
        influx_m3_s: 3e-3,
        ..Hidden::default()
    });
    let (from, lasts, rise) = INFLUX_S;
    let influx = |onset| named("influx", &[3e-3, onset, lasts, rise]);
    // From there later, if half an hour is left of the 5400 s then; else earlier.
    for (onset, moved, passed) in [
        (from, from + 1782.0, true),
        (1817.0, 3599.0, true),
        (1818.0, 36.0, true),
        (from + 1782.0, from, false),
    ] {
        let checks = placebo(&record, &selected(vec![influx(onset)], Vec::new()));
        let [check] = &checks[..] else {
            panic!("{checks:?}");
        };
        assert_eq!(check.name, "influx: placebo at another time explains less");
        assert_eq!(check.passed, passed, "{}", check.detail);
        let times = (format!(" at {onset:.0} s, "), format!(" at {moved:.0} s"));
        assert!(
            check.detail.contains(&times.0) && check.detail.ends_with(&times.1),
            "{}",
            check.detail
        );
    }
    // What is there all the time has no other time; beside it the influx shows what it does beside nothing else.
    let gain = named("return_flow_gain", &[0.0]);
    let both = placebo(&record, &selected(vec![gain, influx(from)], Vec::new()));
    let alone = placebo(&record, &selected(vec![influx(from)], Vec::new()));
    assert_eq!(both.len(), 1);
    assert_eq!(both, alone);
}
