//! What a search for anything finds where only some effects are suspected.

use super::{believe, unless_outweighed};
use crate::belief::less_likely;
use crate::record::Record;
use crate::relations::Applied;
use crate::round::Round;
use crate::select::{Sought, select};
use crate::selection::Named;
use tracing::debug;

/// Doubts suspects, believed as they are fitted alone, that a search for anything does not name and that do not show beside its findings:
/// an effect explains something of any cause whose signature has some of its own.
///
/// - `most`: how many effects that search fits together at most.
pub(super) fn doubt_outdone(
    record: &Record,
    start: &[Applied],
    named: &mut [Named],
    (suspects, most): (&[String], usize),
    round_begins: impl FnMut(usize),
) {
    if named.is_empty() {
        return;
    }
    let sought = Sought::Any(most);
    let Some(mut any) = select(record, start, sought, round_begins) else {
        return;
    };
    believe(record, &mut any.named, sought);
    if any.named.is_empty() {
        return;
    }
    let Some(round) = Round::about(record, &any) else {
        return;
    };
    for suspect in named {
        let id = suspect.applied.id();
        let is_named = any.named.iter().any(|n| n.applied.id() == id);
        if is_named || round.shows_beside(id) {
            continue;
        }
        let Some((by, instead)) = outdoes(&any.named, suspect) else {
            continue;
        };
        let probability = instead.max(round.beside(id));
        debug!("{id} does not show beside {by}: {probability:.3}");
        less_likely(suspect, probability, by);
        unless_outweighed(suspect, suspects);
    }
}

/// The finding that tells instead of a suspect what that would, and how likely the suspect is in its place: the one that it is the likeliest
/// alternative to, or else the one of most evidence, in its relation if there is one.
fn outdoes(findings: &[Named], suspect: &Named) -> Option<(&'static str, f64)> {
    let about = suspect.applied.effect.about();
    let instead = |n: &Named| {
        let it = n.alternatives.iter().find(|a| a.0 == about.id);
        it.map_or(0.0, |a| a.1)
    };
    let there = |n: &Named| n.shows_in(about.relation);
    let by = findings.iter().max_by(|a, b| {
        instead(a)
            .total_cmp(&instead(b))
            .then(there(a).cmp(&there(b)))
            .then(a.evidence.total_cmp(&b.evidence))
    })?;
    Some((by.applied.id(), instead(by)))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may fail by panic")]

    use super::{doubt_outdone, outdoes};
    use crate::ablation::Step;
    use crate::conclude::believe;
    use crate::relations::Applied;
    use crate::select::{Sought, select};
    use crate::selection::Named;
    use crate::test_rig::{Hidden, drilled, named};
    use dgd_effects::{Curve, KNOTS, Place, Quantity};

    /// How likely one suspect is, fitted alone and beside what a search for anything finds, where mud flows in for a while.
    fn likely(gain: f64, suspect: &str) -> [f64; 2] {
        let mut record = drilled(Hidden {
            influx_m3_s: 3e-3,
            ..Hidden::default()
        });
        // The level of this drilling moves with every step of the flow: late flows would look like an area.
        record.without = vec![Step::LateFlows];
        for read in &mut record.filled.mud_pump {
            *read *= 1.0 + gain;
        }
        let suspects = [suspect.to_owned()];
        let sought = Sought::Given(&suspects);
        let mut found = select(&record, &[], sought, |_| {}).unwrap();
        believe(&record, &mut found.named, sought);
        let alone = found.named[0].probability;
        doubt_outdone(&record, &[], &mut found.named, (&suspects, 3), |_| {});
        [alone, found.named[0].probability]
    }

    #[test]
    fn a_suspect_that_only_resembles_what_was_not_suspected_is_doubted() {
        for only_resembles in ["annulus_area", "lost_circulation"] {
            let [alone, beside] = likely(0.0, only_resembles);
            assert!(alone > 0.5 && beside < 0.01, "{alone} {beside}");
        }
        let [_, right] = likely(0.0, "influx");
        assert!(right > 0.9, "{right}");
    }

    /// A wrong reading of the inflow beside an influx that explains more: too small to be named there at 2 %, named at 3 %.
    #[test]
    fn a_suspect_that_shows_beside_a_stronger_one_is_not() {
        for gain in [-0.02, -0.03] {
            let [alone, beside] = likely(gain, "inflow_gain");
            assert!(beside > 0.7 && beside == alone, "{alone} {beside}");
        }
    }

    #[test]
    fn a_suspect_is_outdone_by_what_it_may_stand_for_or_else_by_what_is_in_its_relation() {
        let of = |id: &str, evidence: f64, alternatives: &[(&str, f64)]| Named {
            evidence,
            alternatives: alternatives.iter().map(|a| (a.0.to_owned(), a.1)).collect(),
            ..named(id, &[1e-3, 4e3, 1e3, 0.15])
        };
        let suspect = of("influx", 10.0, &[]);
        let loss = of("lost_circulation", 20.0, &[]);
        let wear = of("pump_wear", 900.0, &[]);
        let by = |findings: &[Named]| outdoes(findings, &suspect);
        assert_eq!(
            by(&[loss.clone(), wear.clone()]),
            Some(("lost_circulation", 0.0))
        );
        assert_eq!(by(std::slice::from_ref(&wear)), Some(("pump_wear", 0.0)));
        let wear = of("pump_wear", 900.0, &[("influx", 0.2)]);
        assert_eq!(by(&[loss, wear]), Some(("pump_wear", 0.2)));
        assert_eq!(by(&[]), None);
        // A correction is in the relations of its place, whatever its effect says of itself.
        let of_place = |place: Place| {
            let knots = vec![1e-3; KNOTS];
            Named {
                evidence: 50.0,
                applied: Applied::from(&Curve::new(place, Quantity::Time, (0.0, 1e4), knots)),
                ..of("unknown", 0.0, &[])
            }
        };
        let wear = of("pump_wear", 900.0, &[]);
        let beside_wear = |place: Place| by(&[of_place(place), wear.clone()]);
        assert_eq!(beside_wear(Place::Balance), Some(("unknown", 0.0)));
        assert_eq!(beside_wear(Place::Friction), Some(("pump_wear", 0.0)));
    }
}
