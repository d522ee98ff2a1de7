//! Claims about how small an effect would have been seen.
#![allow(clippy::unwrap_used, reason = "a test may fail by panic")]

use super::Showing;
use crate::contest::{at_bound, material};
use crate::relations::Applied;
use dgd_effects::{About, Effect, Method, catalogue, find};

fn amplitudes() -> impl Iterator<Item = &'static dyn Effect> {
    catalogue().iter().copied().filter(|effect| {
        let about = effect.about();
        about.search.method == Method::Relations && !crate::scan::on_grid(about)
    })
}

fn showing(about: &About, energy: f64) -> Showing {
    Showing {
        energy,
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
            let showing = showing(about, 10.0_f64.powi(decade) / (high * high));
            let Some(limit) = showing.limit(about) else {
                assert!(decade < 3, "{}", about.id);
                continue;
            };
            let least = about.search.least.unwrap_or(0.0);
            assert!(limit >= least, "{}: {limit}", about.id);
            assert!(material(&of(effect, 1.001 * limit)), "{}", about.id);
            assert!(!at_bound(&of(effect, limit)), "{}", about.id);
            let evidence = 0.5 * limit * limit * showing.energy;
            let short = evidence < showing.hurdle + 3.0 - 1e-9;
            assert!(!short, "{}: {evidence}", about.id);
            // A little less would not have been seen, or not been told.
            let less = 0.5 * (0.99 * limit).powi(2) * showing.energy;
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
            ..showing(about, 25.0)
        };
        showing.limit(about).map(|k| 0.5 * k * k * 25.0)
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
