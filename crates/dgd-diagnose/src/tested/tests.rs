//! Claims about what was looked for and how small it would have been seen.
#![allow(clippy::unwrap_used, reason = "a test may fail by panic")]

use super::tested;
use crate::diagnosis::{Outcome, Tested};
use crate::finding::heaving;
use crate::heave::{Swell, Unseen};
use crate::limit::{Energy, Showing};
use crate::record::Record;
use crate::relations::Applied;
use crate::selection::{First, Named, Selection};
use crate::test_rig::{named, steady};
use dgd_effects::{Connection, Excitation, Method, catalogue, find};

fn selected(named: Vec<Named>, first: Vec<First>) -> Selection {
    Selection {
        held: 0,
        allowances: Vec::new(),
        named,
        first,
        stays: false,
    }
}

const SWELL: Swell = Swell {
    period_s: 10.0,
    period_sd_s: 0.1,
    amplitude_m: 0.1,
    amplitude_sd_m: 0.01,
    ratio: 2.0,
    believed: 2.5,
    evidence: 4.0,
    hurdle: 8.0,
    limit_m: 0.04,
    folded_s: None,
};

/// All effects as they fared on a recording in which each by itself showed evidence of 2 and an energy of 25.
fn fared(
    record: &Record,
    swell: Result<Swell, Unseen>,
    start: &[Applied],
    but: &str,
) -> Vec<Tested> {
    let first = |id| First {
        id,
        evidence: 2.0,
        hurdle: 7.0,
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
        Err(Unseen::Slow),
        Excitation::PumpStops,
        "the subsea pump never stops",
    );
    says(
        &record,
        Err(Unseen::Slow),
        Excitation::Connections,
        "the mud pump never stops",
    );
    says(
        &record,
        Err(Unseen::Slow),
        Excitation::BoosterSteps,
        "the booster flow does not change",
    );
    says(
        &record,
        Err(Unseen::Slow),
        Excitation::FastSampling,
        "the sampling is too slow to show swell",
    );
    // What never runs does not stop either.
    let mut idle = record.clone();
    idle.filled.pumping.fill(false);
    idle.filled.mud_pump.fill(0.0);
    says(
        &idle,
        Err(Unseen::Slow),
        Excitation::PumpStops,
        "the subsea pump never runs",
    );
    says(
        &idle,
        Err(Unseen::Slow),
        Excitation::Connections,
        "the mud pump never runs",
    );
    // At rest at first, or in the end: either shows what a rest leaves.
    for rest in [0..50, 400..450] {
        let mut rested = record.clone();
        rested.filled.pumping[rest].fill(false);
        says(&rested, Err(Unseen::Slow), Excitation::PumpStops, "");
    }
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
        says(&record, Ok(SWELL), need, "");
    }
}

#[test]
fn what_nothing_excites_is_not_testable_and_what_the_model_holds_is_not_told() {
    let record = steady(90);
    let start = [named("inflow_gain", &[0.01]).applied];
    let found = fared(&record, Ok(SWELL), &start, "influx");
    assert_eq!(found.len(), catalogue().len() - 1);
    assert!(found.iter().all(|t| t.effect != "inflow_gain"));
    let none = Outcome::NotTestable("nothing in the recording excites it".to_owned());
    assert_eq!(*outcome(&found, "influx"), none);
    // Swell is sought in a spectrum, which is there.
    let heave = find("heave").unwrap().about();
    assert_eq!(heave.search.method, Method::Spectrum);
    let without = fared(&record, Ok(SWELL), &start, "heave");
    assert_eq!(*outcome(&without, "heave"), Outcome::NotSeen);
    let swelling = [heaving(&record, heave, SWELL, None)];
    let told = tested(
        &record,
        &selected(Vec::new(), Vec::new()),
        &swelling,
        &[],
        Err(Unseen::Slow),
    );
    assert_eq!(*outcome(&told, "heave"), Outcome::Found);
}

/// Strength and standard error are of the first round, the limit is of the last one.
#[test]
fn what_was_looked_for_is_told_with_its_standard_error_and_its_limit_in_the_scale_that_is_reported()
{
    let record = steady(90);
    let found = fared(&record, Ok(SWELL), &[], "lost_circulation");
    for one in &found {
        let about = find(one.effect).unwrap().about();
        // What no round weighed would have to show what the catalogue asks.
        let asked = match one.effect {
            "lost_circulation" => about.search.belief.hurdle,
            _ => 7.0,
        };
        assert_eq!(one.hurdle, asked);
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
