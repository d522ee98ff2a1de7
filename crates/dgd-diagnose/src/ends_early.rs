//! What was there from the start and ends: none of the catalogue's causes, which set in.
//!
//! A plug that washes out, a seat that a choke leaves: the form of a cause that sets in, with the other sign. Knots along time are
//! too coarse for its edge, and mud of another weight or thickness stands in for it.

use crate::contest::{hurdle, sets_in, sustained};
use crate::cores::apiece;
use crate::numbers::product;
use crate::record::Record;
use crate::relations::{Applied, on_grid};
use crate::scan::{Candidate, grids, of_each, sharpen, switches, weigh, weighed};
use crate::tangent::Tangent;
use dgd_effects::{Effect, Method, Relation, catalogue};
use tracing::debug;

/// Something that ends.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Ended {
    pub relation: Relation,
    /// Logarithm of the Bayes factor against nothing.
    pub evidence: f64,
}

/// Whether an effect is of one sign and there from some time on, so that there is an opposite to it.
fn begins(effect: &dyn Effect) -> bool {
    let about = effect.about();
    about.search.method == Method::Relations
        && effect.is_switch()
        && about.onset().is_some()
        && about.duration().is_none()
        && about.parameters[0].low >= 0.0
        && !on_grid(about)
}

/// What shows that something ends in some relations, beside a state, above the hurdle of what would begin.
pub(crate) fn ended(
    record: &Record,
    gate: &Tangent,
    state: &[Applied],
    relations: &[Relation],
) -> Vec<Ended> {
    let pull = gate.pull();
    let effects: Vec<&'static dyn Effect> = (catalogue().iter().copied())
        .filter(|effect| begins(*effect) && relations.contains(&effect.about().relation))
        .collect();
    let opposite = |effect: &'static dyn Effect, mut parameters: Vec<f64>| {
        parameters[0] = -parameters[0].abs();
        Applied::new(effect, parameters)
    };
    let grids = (effects.iter())
        .map(|effect| {
            let all = product(&grids(*effect, record)).into_iter();
            all.map(|parameters| opposite(*effect, parameters))
                .collect()
        })
        .collect();
    let coarse = of_each(grids, |one| vec![weighed(record, gate, state, one).bare()]);
    let of = |(effect, coarse): (&'static dyn Effect, Vec<Candidate>)| -> Option<Ended> {
        let about = effect.about();
        let places = (coarse.len() as f64).ln();
        let best = (switches(record, gate, &pull, state, effect, &coarse).into_iter())
            .map(|parameters| weigh(record, gate, state, opposite(effect, parameters)))
            .filter(|c| c.evidence.is_finite())
            .max_by(|a, b| a.evidence.total_cmp(&b.evidence))?;
        let hurdle = hurdle(record, &best.applied);
        if best.evidence - places < 0.5 * hurdle {
            return None;
        }
        let best = sharpen(record, gate, state, best);
        let mut evidence = best.evidence - places;
        if let Some(sustained) = sustained(record, state, &best, &gate.rows.still) {
            evidence = evidence.min(sustained);
        }
        debug!(
            "{} ends at {:?}: {evidence:.1}",
            about.id, best.applied.parameters
        );
        (evidence > hurdle && sets_in(record, gate, state, &best)).then_some(Ended {
            relation: about.relation,
            evidence,
        })
    };
    (apiece(effects.into_iter().zip(coarse).collect(), of).into_iter())
        .flatten()
        .collect()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may fail by panic")]

    use super::{begins, ended};
    use crate::record::Record;
    use crate::tangent::{Bend, Tangent};
    use crate::test_rig::{FLOW_M3_S, Hidden, drilled};
    use dgd_effects::{Relation, catalogue, find};

    const AT_S: f64 = 2700.0;

    /// A line that loses more, Pa at the usual flow, before and after some time.
    fn restricted(before_pa: f64, after_pa: f64) -> Record {
        let mut record = drilled(Hidden::default());
        for i in 0..record.t_s.len() {
            let more = if record.t_s[i] < AT_S {
                before_pa
            } else {
                after_pa
            };
            record.outlet[i] += more * (record.flow[i] / FLOW_M3_S).powi(2);
        }
        record.filled.outlet.clone_from(&record.outlet);
        record.outlets = vec![record.outlet.clone()];
        record
    }

    #[test]
    fn a_restriction_that_goes_is_told_from_one_that_comes_and_from_none() {
        let found = |before_pa: f64, after_pa: f64| {
            let record = restricted(before_pa, after_pa);
            let gate = Tangent::at(&record, &[], &[], Bend::Lean).unwrap();
            ended(
                &record,
                &gate,
                &[],
                &[Relation::ReturnLineFriction, Relation::RiserMassBalance],
            )
        };
        let gone = found(6e4, 0.0);
        let friction = |one: &&super::Ended| one.relation == Relation::ReturnLineFriction;
        let one = gone.iter().find(friction).unwrap();
        assert!(one.evidence > 50.0, "{gone:?}");
        assert_eq!(found(0.0, 6e4), []);
        assert_eq!(found(0.0, 0.0), []);
        assert_eq!(found(6e4, 6e4), []);
    }

    #[test]
    fn what_begins_is_of_one_sign_and_stays() {
        for (id, expected) in [
            ("line_restriction", true),
            ("line_leak", true),
            // Of either sign; for a while; always there.
            ("mud_density_change", false),
            ("gas_in_pump", false),
            ("yield_stress", false),
        ] {
            assert_eq!(begins(find(id).unwrap()), expected, "{id}");
        }
        assert!(!catalogue().iter().all(|effect| begins(*effect)));
    }
}
