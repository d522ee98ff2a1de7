//! What is left over beside an effect: corrections that still tell something, and effects that do.

use super::hurdles::{FURTHER, NO_ODDS, timed};
use super::{Bent, Round};
use crate::ablation::Step;
use crate::belief::is_strange;
use crate::contest::{self, Contender, contest, ending, material, solved};
use crate::empirical::{Correction, corrections, episode_may_be, hurdle, plausible};
use crate::ends_early::ended;
use crate::record::Record;
use crate::relations::{Applied, joined, on_grid};
use crate::tangent::{Bend, Tangent};
use crate::timing::is_late_meter;
use dgd_effects::{About, Curve, Place, Quantity, Relation};
use std::cell::OnceCell;
use tracing::debug;

/// What corrections still claim beside an effect, over what the effect or its rival claims (the more of the two), from which on the effect is
/// more likely not the cause.
///
/// In simulated recordings of pairs (sets of seeds 882 and 883) true causes left at most 0.09 over, or a second effect told it, in 174 of 175
/// rounds; beside single causes from outside the catalogue (860 to 862) effects left 0.12 and more in 138 of 144.
const RESEMBLES: f64 = 0.12;

/// By which power the odds grow with that share.
const POWER: f64 = 3.0;

/// Share of what is left over that a second effect must tell to be what leaves it.
const TOLD: f64 = 0.9;

/// Share of what a rival explains that it still explains beside an effect, from which on the two are causes of their own.
const APART: f64 = 0.9;

/// Share of what a correction tells beside an effect that it tells without it, below which the effect has put it there. Set by hand.
const BROUGHT_OUT: f64 = 0.5;

/// A second effect beside the best one.
#[derive(Clone)]
pub(super) struct Second {
    pub applied: Applied,
    /// What it explains beyond what a further effect must.
    pub evidence: f64,
}

/// The best effect of a round, and what there is beside it. It is sharpened, and others are weighed beside it, when that is first asked for.
pub(super) struct Beside<'r, 'a> {
    round: &'r Round<'a>,
    best: &'r Contender,
    state: OnceCell<Vec<Applied>>,
    seconds: OnceCell<Vec<Second>>,
}

impl<'r, 'a> Beside<'r, 'a> {
    pub(super) fn of(round: &'r Round<'a>, best: &'r Contender, bent: &Bent) -> Self {
        let state = OnceCell::new();
        if let Some((sharpened, _)) = &bent.sharpened {
            // It has been sharpened for a look at its form.
            state.get_or_init(|| sharpened.clone());
        }
        Self {
            round,
            best,
            state,
            seconds: OnceCell::new(),
        }
    }

    pub(super) fn state(&self) -> &[Applied] {
        self.state.get_or_init(|| self.round.sharpened(self.best))
    }

    /// Whether the effect, sharpened, has come to an end of what its form may be.
    pub(super) fn is_strange(&self) -> bool {
        let may_be = self
            .best
            .effect
            .about()
            .parameters
            .iter()
            .any(|p| p.strange.is_some());
        may_be && self.state().last().is_some_and(is_strange)
    }

    /// The state with the effect, and with the likeliest second one, if there is any.
    pub(super) fn with_second(&self) -> Vec<Applied> {
        let second = self.second(|_| true);
        second.map_or_else(
            || self.state().to_vec(),
            |s| joined(self.state(), &s.applied),
        )
    }

    fn gate(&self) -> Option<Tangent> {
        Tangent::beside(self.round.record, self.state(), &[], Bend::Lean)
    }

    /// The likeliest second effect of some kind that might be named.
    pub(super) fn second(&self, kind: impl Fn(&About) -> bool) -> Option<Second> {
        let seconds = self.seconds.get_or_init(|| self.seconds());
        seconds
            .iter()
            .find(|second| kind(second.applied.effect.about()))
            .cloned()
    }

    fn seconds(&self) -> Vec<Second> {
        let record = self.round.record;
        if !record.takes(Step::TwoDo) {
            return Vec::new();
        }
        let Some(gate) = self.gate() else {
            return Vec::new();
        };
        let further = FURTHER[(self.round.known + 1).min(FURTHER.len() - 1)];
        let stands = |c: &Contender| {
            let hurdle = contest::hurdle(record, &c.best.applied);
            c.evidence > hurdle && material(&solved(&c.best))
        };
        let second = |c: Contender| Second {
            applied: solved(&c.best),
            evidence: c.evidence - further,
        };
        let mut contenders = contest(record, &gate, self.state());
        // What ended may come again.
        let again =
            |about: &About| self.best.effect.lasting().is_some() && about.id == self.best.id();
        contenders.extend(ending(record, &gate, self.state(), again));
        contenders.sort_by(|a, b| b.evidence.total_cmp(&a.evidence));
        contenders.into_iter().filter(stands).map(second).collect()
    }

    /// Logarithm of the odds that the effect only resembles the cause, by what corrections still tell where it acts; and the second effect
    /// that tells it instead, if there is one.
    ///
    /// An effect is weighed where the curves bend little, a correction where they bend at will: each has its own noise, and what the two
    /// explain is not of one scale. What corrections tell without the effect and beside it is.
    pub(super) fn resembles(&self, rival: &Correction) -> (f64, Option<Second>) {
        let (left, apart) = if self.vanishes() {
            // All is left over.
            (self.best.claim().max(rival.claim()), false)
        } else {
            self.left(rival)
        };
        let claim = self.best.claim();
        let share = left / claim.max(rival.claim());
        let odds = if apart && claim > rival.claim() {
            // The two are causes of their own, of which the larger is named first.
            (rival.claim() - claim) / self.best.temperature()
        } else {
            POWER * (share / RESEMBLES).ln()
        };
        debug!("{} leaves {left:.1} over: odds {odds:.1}", self.best.id());
        if odds < NO_ODDS {
            return (odds, None);
        }
        let second = self.second(|_| true);
        (odds, second.filter(|second| second.evidence > TOLD * left))
    }

    /// Whether the effect is sharpened to nothing.
    fn vanishes(&self) -> bool {
        let one = self.state().last();
        one.is_some_and(|one| !on_grid(one.effect.about()) && one.parameters[0] == 0.0)
    }

    /// What the likeliest correction may still claim where the effect acts, 0 where none may; and whether the rival tells as much beside
    /// the effect as without it.
    fn left(&self, rival: &Correction) -> (f64, bool) {
        let Some(gate) = self.gate() else {
            return (0.0, false);
        };
        let Round {
            record, unnamed, ..
        } = self.round;
        let left = rivals_beside(record, &gate, self.state(), unnamed);
        let about = self.best.effect.about();
        let of_the_rival = left
            .iter()
            .filter(|c| c.curve.is_alike(&rival.curve) || !self.told_before(c));
        let most = of_the_rival.map(|c| left_of(c, rival, about));
        let itself = |c: &&Correction| c.curve.is_alike(&rival.curve);
        let still = left.iter().find(itself).map_or(0.0, |c| c.borne);
        (most.fold(0.0, f64::max), still > APART * rival.borne)
    }

    /// Whether a correction told as much without the effect: what the effect does not touch is a cause of its own, and nothing that it
    /// leaves of the rival.
    pub(super) fn told_before(&self, c: &Correction) -> bool {
        let before = (self.round.rivals.iter()).find(|b| b.curve.is_alike(&c.curve));
        // A correction that shows only beside the effect is the effect's doing.
        before.is_some_and(|b| c.borne > APART * b.borne && b.borne > BROUGHT_OUT * c.borne)
    }
}

/// What a correction claims of what an effect leaves over that a rival tells, e-folds; 0 of one that tells of something else.
pub(super) fn left_of(c: &Correction, rival: &Correction, about: &About) -> f64 {
    let enters = |place: Place| place.shows_in().contains(&about.relation);
    let (ours, theirs) = (&c.curve, &rival.curve);
    if ours.place == theirs.place {
        let by_speed = (ours.place, ours.quantity) == (Place::Friction, Quantity::PumpSpeed);
        let of_another = theirs.quantity != Quantity::PumpSpeed || is_late_meter(about);
        return if by_speed && of_another {
            // Speed stands for flow without its meter's noise: of sound recordings, too, friction shows along it. And without its lateness: friction
            // along speed is no rival of what makes a meter late, but a part of it.
            (c.claim() - hurdle(c)).max(0.0)
        } else {
            c.claim().max(0.0)
        };
    }
    // A rival of another relation is told by what acts there.
    let beyond = !enters(theirs.place);
    let acts = enters(ours.place) || beyond && share_rows(ours.place, theirs.place);
    // In another place than the rival's sound recordings may show as much.
    if acts {
        (c.claim() - hurdle(c)).max(0.0)
    } else {
        0.0
    }
}

/// Plausible corrections beside a state, best first, in relations that nothing `unnamed` enters but at another time.
pub(super) fn rivals_beside(
    record: &Record,
    gate: &Tangent,
    state: &[Applied],
    unnamed: &[Curve],
) -> Vec<Correction> {
    if !record.takes(Step::Corrections) {
        return Vec::new();
    }
    let timed = timed(state);
    // Knots leave something over where they act.
    let acts = |curve: &Curve| {
        let mut held = unnamed.iter();
        held.any(|held| share_rows(curve.place, held.place) && !curve.is_apart(held))
    };
    let mut rivals = corrections(record, state, episode_may_be(record, gate));
    rivals.retain(|r| plausible(r) && !acts(&r.curve) && !(timed && owed_to_timing(r)));
    // What ends is a curve along time, with an edge that knots do not have.
    let along_time: Vec<Relation> = (rivals.iter())
        .filter(|r| r.curve.quantity == Quantity::Time)
        .map(|r| r.curve.place.relation())
        .collect();
    for end in ended(record, gate, state, &along_time) {
        let course = |r: &&mut Correction| {
            r.curve.quantity == Quantity::Time && r.curve.place.relation() == end.relation
        };
        if let Some(r) = rivals.iter_mut().find(course) {
            r.evidence = r.evidence.max(end.evidence);
            r.borne = r.borne.max(end.evidence);
        }
    }
    rivals.sort_by(|a, b| b.borne.total_cmp(&a.borne));
    rivals
}

/// Whether corrections of two places enter a relation in common.
pub(super) fn share_rows(one: Place, other: Place) -> bool {
    let mut relations = one.shows_in().iter();
    relations.any(|relation| other.shows_in().contains(relation))
}

/// Whether a correction is what a late meter leaves over, and no second thing: its form follows the rate of the flow.
pub(super) fn owed_to_timing(r: &Correction) -> bool {
    r.curve.quantity == Quantity::FlowRate
}
