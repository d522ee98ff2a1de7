//! Claims about how small an effect would have been seen.
#![allow(clippy::unwrap_used, reason = "a test may fail by panic")]

use super::{Energy, Showing, most_allowed};
use crate::contest::{Contender, at_bound, material};
use crate::relations::Applied;
use crate::scan::Candidate;
use dgd_effects::{About, Effect, Method, catalogue, find};

fn amplitudes() -> impl Iterator<Item = &'static dyn Effect> {
    catalogue().iter().copied().filter(|effect| {
        let about = effect.about();
        about.search.method == Method::Relations && !crate::relations::on_grid(about)
    })
}

fn showing(about: &About, energy: f64) -> Showing {
    Showing {
        energy: Energy::Unit(energy),
        hurdle: about.search.belief.hurdle,
        before: 0.0,
    }
}

/// An effect of so much strength, all else as usual.
fn of(effect: &'static dyn Effect, strength: f64) -> Applied {
    let mut parameters: Vec<f64> = (effect.about().parameters.iter())
        .map(|p| p.usual)
        .collect();
    parameters[0] = strength;
    Applied::new(effect, parameters)
}

#[test]
fn no_limit_lies_below_what_may_be_named_or_beyond_what_is_plausible() {
    let mut within = 0;
    for effect in amplitudes() {
        let about = effect.about();
        let high = about.parameters[0].high;
        for decade in -12..=16 {
            let unit = 10.0_f64.powi(decade) / (high * high);
            let showing = showing(about, unit);
            let Some(limit) = showing.limit(about) else {
                assert!(decade < 3, "{}", about.id);
                continue;
            };
            let least = about.search.least.unwrap_or(0.0);
            assert!(limit >= least, "{}: {limit}", about.id);
            assert!(material(&of(effect, 1.001 * limit)), "{}", about.id);
            assert!(!at_bound(&of(effect, limit)), "{}", about.id);
            let evidence = 0.5 * limit * limit * unit;
            let short = evidence < showing.hurdle + 3.0 - 1e-9;
            assert!(!short, "{}: {evidence}", about.id);
            // A little less would not have been seen, or not been told.
            let less = 0.5 * (0.99 * limit).powi(2) * unit;
            let unseen = less < showing.hurdle + 3.0 || !material(&of(effect, 0.99 * limit));
            assert!(unseen, "{}", about.id);
            within += usize::from(limit == least);
        }
    }
    assert!(within > 20, "{within}");
}

#[test]
fn what_could_have_been_there_from_the_start_must_be_larger() {
    let about = find("line_restriction").unwrap().about();
    let needed = |before: f64| {
        let showing = Showing {
            before,
            ..showing(about, 1.0)
        };
        showing.limit(about).map(|k| 0.5 * k * k)
    };
    let hurdle = about.search.belief.hurdle;
    // It explains 3 more than from the start: (0.97 - share) of it.
    for (before, evidence) in [(0.0, hurdle + 3.0), (0.5, hurdle + 3.0), (0.92, 60.0)] {
        assert!(
            (needed(before).unwrap() - evidence).abs() < 1e-9,
            "{before}"
        );
    }
    assert_eq!(needed(0.98), None);
}

/// Timing goes by re-fits, on a grid: energy `4·(t - 1)²` of a lateness t of which one second is allowed for.
#[test]
fn a_lateness_is_seen_from_where_it_shows_beyond_what_a_sound_rig_may_have() {
    let about = find("return_flow_delay").unwrap().about();
    let strengths = [2.0, 3.0, 4.0, 6.0, 10.0];
    let points = |from: f64| -> Vec<(f64, f64)> {
        let at = |t: &f64| (*t, 4.0 * (t - from) * (t - from));
        [from].iter().chain(&strengths).map(at).collect()
    };
    let limit = |points: Vec<(f64, f64)>, hidden: f64| {
        let energy = Energy::Grid { points, hidden };
        let (hurdle, before) = (10.0, 0.0);
        let showing = Showing {
            energy,
            hurdle,
            before,
        };
        showing.limit(about)
    };
    // Evidence of 13, energy of 26: between 3 s, where it is 16, and 4 s, where it is 36.
    let shows = 1.0 + 6.5_f64.sqrt();
    assert!((limit(points(1.0), 1.5).unwrap() - shows - 1.5).abs() < 1e-12);
    // A meter that is early by itself shows as much when it is late by less: here within what its instrument may be off by.
    let early = limit(points(-2.0), 0.0).unwrap();
    assert_eq!(Some(early), about.search.least);
    assert!((limit(points(-2.0), 4.0).unwrap() - (6.5_f64.sqrt() - 2.0) - 4.0).abs() < 1e-12);
    // Where it shows at once an instrument's accuracy is the limit, and where it hardly shows there is none.
    let strongly = points(1.0).iter().map(|p| (p.0, 1e3 * p.1)).collect();
    assert_eq!(limit(strongly, 0.0), about.search.least);
    let hardly = points(1.0).iter().map(|p| (p.0, 1e-3 * p.1)).collect();
    assert_eq!(limit(hardly, 0.0), None);
    // What shows less where it is later is sure from its last shortfall on.
    let mut falls = points(1.0);
    falls[4].1 = 20.0;
    assert!(limit(falls, 0.0).unwrap() > 6.0);
}

#[test]
fn a_sound_rig_may_hide_as_much_of_a_late_meter_as_of_its_like() {
    let allowed = |id: &str| most_allowed(&find(id).unwrap().about().search);
    assert_eq!(allowed("return_flow_delay"), 2.5);
    assert_eq!(allowed("line_gas_storage"), 2.5);
    assert_eq!(allowed("pump_speed_lag"), 3.0);
    assert_eq!(allowed("u_tube"), 4.0);
    assert_eq!(allowed("influx"), 0.0);
}

/// The contest's grid, without what it begins with.
#[test]
fn a_grid_begins_with_what_a_sound_rig_is_allowed_and_hides_what_its_like_may_have_besides() {
    let delay = find("return_flow_delay").unwrap();
    let allowed = |id: &str, seconds: f64, allowance: bool| Applied {
        allowance,
        ..of(find(id).unwrap(), seconds)
    };
    let on_grid = |state: &[Applied]| {
        let plain = Candidate {
            applied: of(delay, 8.0),
            signature: Vec::new(),
            score: 0.0,
            energy: 1.0,
            evidence: 20.0,
        };
        let contender = Contender {
            effect: delay,
            plainest: plain.clone(),
            best: plain,
            evidence: 20.0,
            formed: 20.0,
            lost: 0.0,
            evened: 0.0,
            once: 0.0,
            strengths: vec![(1.0, 1.0), (1.5, 3.0), (4.0, 30.0)],
        };
        match Energy::on_grid(&contender, state) {
            Energy::Grid { points, hidden } => (points, hidden),
            Energy::Unit(_) => panic!("no grid"),
        }
    };
    let (points, hidden) = on_grid(&[]);
    assert_eq!(points, [(0.0, 0.0), (1.0, 1.0), (1.5, 3.0), (4.0, 30.0)]);
    assert_eq!(hidden, 2.5);
    // What is allowed for of the meter itself, and of the store that looks like it; of the pump, which does not, nothing counts, and
    // nor does what is a finding.
    let (points, hidden) = on_grid(&[
        allowed("return_flow_delay", 1.5, true),
        allowed("pump_speed_lag", 2.0, true),
        allowed("line_gas_storage", 0.5, false),
    ]);
    assert_eq!(points, [(1.5, 0.0), (4.0, 30.0)]);
    assert_eq!(hidden, 1.0);
    let (points, hidden) = on_grid(&[allowed("line_gas_storage", 2.0, true)]);
    assert_eq!(points.len(), 4);
    assert_eq!(hidden, 0.5);
    let (_, hidden) = on_grid(&[
        allowed("return_flow_delay", 1.5, true),
        allowed("line_gas_storage", 2.0, true),
    ]);
    assert_eq!(hidden, 0.0);
}
