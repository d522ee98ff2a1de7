//! What a search has found so far.

use crate::limit::Showing;
use crate::relations::{Applied, joined};
use dgd_effects::{Curve, Relation};

/// A named effect.
#[derive(Clone)]
pub(crate) struct Named {
    pub applied: Applied,
    pub evidence: f64,
    /// What its form gained within its error, where its strength differs along stands; else 0.
    pub bent: f64,
    /// Evidence that sound recordings, and what was named before, do not reach.
    pub hurdle: f64,
    pub probability: f64,
    pub alternatives: Vec<(String, f64)>,
    /// The most that its probability may be beside another effect that is fitted to the same rows, which has the rest.
    pub most: Option<(f64, &'static str)>,
    /// Of a curve that is seen, while it is searched with the curve itself.
    pub held: Option<Held>,
}

impl Named {
    /// Whether it is something that the catalogue does not hold, and not what two transmitters show; until the search ends.
    pub(crate) fn is_unnamed(&self) -> bool {
        self.applied.is_correction() && self.held.is_none()
    }

    /// Whether it shows in a relation.
    pub(crate) fn shows_in(&self, relation: Relation) -> bool {
        match self.applied.curve() {
            Some(curve) => curve.place.shows_in().contains(&relation),
            None => self.applied.effect.about().relation == relation,
        }
    }

    /// Whether its strength was refined to nothing. A correction's curve has none.
    pub(crate) fn has_no_size(&self) -> bool {
        !self.applied.is_correction() && self.applied.parameters[0] == 0.0
    }

    /// How likely it is that there is anything: the cause named, or one that cannot be told from it.
    pub(crate) fn likely(&self) -> f64 {
        self.probability + self.alternatives.iter().map(|a| a.1).sum::<f64>()
    }
}

/// What a model can hold of a curve that is seen.
#[derive(Clone)]
pub(crate) struct Held {
    pub curve: Curve,
    /// Evidence that the relations bear of it.
    pub borne: f64,
}

/// An effect in the first round.
#[derive(Clone)]
pub(crate) struct First {
    pub id: &'static str,
    pub evidence: f64,
    /// Evidence that it must show to be named.
    pub hurdle: f64,
    /// Energy of a unit of strength, 0 where the strength is on a grid.
    pub energy: f64,
    /// Whether it might be named but for its evidence.
    pub admissible: bool,
    /// How it would show beside what was named before the last round that weighed it; `None` before, and where it may not be named there.
    pub showing: Option<Showing>,
}

/// The outcome of the search.
#[derive(Clone)]
pub(crate) struct Selection {
    /// How many effects the search starts from; they stand first among the allowances.
    pub held: usize,
    /// What the search starts from, and what is allowed for beside it.
    pub allowances: Vec<Applied>,
    pub named: Vec<Named>,
    /// How each effect fared before anything was named.
    pub first: Vec<First>,
    /// Whether nothing is weighed as what ends or comes again: what did so was part of what the catalogue does not hold.
    pub stays: bool,
}

impl Selection {
    /// The full hypothesis.
    pub(crate) fn state(&self) -> Vec<Applied> {
        let mut out = self.allowances.clone();
        for n in &self.named {
            out = joined(&out, &n.applied);
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::Held;
    use crate::selection::Named;
    use crate::test_rig::{named, one};
    use dgd_effects::{Curve, KNOTS, Place, Quantity, unknown};

    #[test]
    fn what_has_no_name_is_a_correction_that_no_two_transmitters_show() {
        let curve = Curve::new(Place::Head, Quantity::Time, (0.0, 5400.0), vec![0.0; KNOTS]);
        let correction = |held: Option<Held>| Named {
            applied: (&curve).into(),
            held,
            ..named("influx", &[1e-3, 0.0, 600.0, 0.15])
        };
        let held = Held {
            curve: curve.clone(),
            borne: 1.0,
        };
        assert_eq!(correction(None).applied.id(), unknown().about().id);
        assert!(correction(None).is_unnamed());
        assert!(!correction(Some(held)).is_unnamed());
        let effect = Named {
            applied: one("inflow_gain", &[0.02]),
            ..correction(None)
        };
        assert!(!effect.is_unnamed());
    }
}
