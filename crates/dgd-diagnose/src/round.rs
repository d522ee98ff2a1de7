//! One round of the search: what stands out is named, or shown to be nothing in the catalogue, or nothing is.

mod beside;
mod ends;
mod findings;
mod footprint;
mod form;
mod hurdles;
mod suction;

use crate::ablation::Step;
use crate::belief::BARRED;
use crate::contest::{self, Contender, contest, solved};
use crate::cores::both;
use crate::empirical::{Correction, episode_like, hurdle};
use crate::record::Record;
use crate::relations::Applied;
use crate::selection::{Named, Selection};
use crate::tangent::{Bend, Tangent};
use beside::{Beside, Second, rivals_beside};
use dgd_effects::{Curve, Quantity, Relation};
use ends::weigh_ends;
use footprint::{Footprint, known};
use form::Bent;
use suction::Unmeasured;
use tracing::debug;

/// Share of what an effect explains from which on it shows in a relation.
const SHOWS: f64 = 0.1;

/// Share of the evidence of what two transmitters show from which on an effect of the catalogue may be what one of them does.
const ALIKE: f64 = 0.7;

/// What a round comes to.
pub(crate) enum Ruling {
    /// An effect.
    Named(Named),
    /// An effect beside which a second one seems to explain what a correction does.
    Promised {
        named: Named,
        /// Id of the effect that the next round is to name.
        second: &'static str,
        /// The correction, which takes the place of the effect if that round does not keep this promise.
        otherwise: Box<Named>,
    },
    /// Something that the catalogue does not hold: only effects of other relations are named beside it.
    Unnamed(Named),
    /// Something that two transmitters show: the search goes on beside it.
    Seen(Named),
    /// Nothing more that sound recordings do not show.
    Nothing,
}

/// Effects and the best correction, weighed about a state.
pub(crate) struct Round<'a> {
    record: &'a Record,
    state: Vec<Applied>,
    /// How many effects of the model that the search starts from come first in it.
    held: usize,
    gate: Tangent,
    pub contenders: Vec<Contender>,
    /// How many effects have been named, here or in the model that the search starts from.
    known: usize,
    footprints: Vec<Footprint>,
    /// What the suction may lose, where nothing tells it.
    suction: Option<Unmeasured>,
    /// Plausible corrections, best first.
    rivals: Vec<Correction>,
    /// What has been found that the catalogue does not hold: effects that show there are not told beside it.
    unnamed: Vec<Curve>,
}

/// The likeliest effect of a round.
struct Likeliest<'a> {
    effect: &'a Contender,
    /// How far its form is bent.
    bent: Bent,
    /// The head as a curve of the pump's speed, with the logarithm of the odds of that, where it tells more than the effect.
    of_speed: Option<(Correction, f64)>,
}

/// Evidence of an effect against what two transmitters show: of one that ends with the minutes about its ends, which the other keeps.
fn with_its_ends(c: &Contender) -> f64 {
    if c.effect.lasting().is_some() {
        c.evidence.max(c.best.evidence)
    } else {
        c.evidence
    }
}

impl<'a> Round<'a> {
    /// Weighs everything about what has been named so far.
    pub(crate) fn about(record: &'a Record, selection: &Selection) -> Option<Self> {
        let state = selection.state();
        let gate = Tangent::beside(record, &state, &[], Bend::Lean)?;
        let unnamed: Vec<Curve> = (selection.named.iter())
            .filter(|n| n.is_unnamed())
            .filter_map(|n| n.applied.curve())
            .collect();
        let (mut contenders, rivals) = both(
            || contest(record, &gate, &state),
            || rivals_beside(record, &gate, &state, &unnamed),
        );
        if !selection.stays {
            weigh_ends((record, &gate, &state), &mut contenders, &rivals);
        }
        let known = known(record, &state, selection)?;
        let footprints = if record.takes(Step::Footprints) {
            Footprint::all(record, &gate, &state, &known)
        } else {
            Vec::new()
        };
        let round = Self {
            known: known.len(),
            footprints,
            suction: Unmeasured::of(record, &gate, &state),
            record,
            state,
            held: selection.held,
            gate,
            contenders,
            rivals,
            unnamed,
        };
        round.trace(selection.named.len() + 1);
        Some(round)
    }

    /// Tells in the log what stands out, and what is asked of it.
    fn trace(&self, number: usize) {
        for c in self.contenders.iter().take(9) {
            debug!(
                "round {number}: {} {:.1} ({:.1} within its form) of {:.1}, {:?}",
                c.id(),
                c.evidence,
                c.formed,
                self.asked(c),
                solved(&c.best).parameters
            );
        }
        for r in self.rivals.iter().take(3) {
            debug!(
                "round {number}: correction of {} by {} {:.1} of {:.1}, freedom {:.1}",
                r.curve.place.name(),
                r.curve.quantity.name(),
                r.evidence,
                self.unknown_hurdle(r),
                r.freedom
            );
        }
    }

    /// Decides between the best effect and the best correction. Beside what the catalogue does not hold only an effect that needs no second one
    /// is named, and an episode at another time: what happens once may happen again.
    pub(crate) fn ruling(&self) -> Ruling {
        match self.decided() {
            Ruling::Named(named) => Ruling::Named(named),
            Ruling::Unnamed(found) if self.is_at_another_time(&found) => Ruling::Unnamed(found),
            _ if !self.unnamed.is_empty() => Ruling::Nothing,
            ruling => ruling,
        }
    }

    /// Whether all that the catalogue does not hold are episodes, no two of which overlap.
    fn is_at_another_time(&self, found: &Named) -> bool {
        let found = found.applied.curve();
        found.is_some_and(|found| self.unnamed.iter().all(|held| held.is_apart(&found)))
    }

    /// The likeliest effect that may be named and is not the pump's own curve of its speed.
    fn likeliest(&self) -> Option<Likeliest<'_>> {
        let mut passed = Vec::new();
        while let Some((effect, bent)) = self.best(&passed) {
            let of_speed = self.of_speed(effect);
            if (of_speed.as_ref()).is_some_and(|(curve, _)| curve.evidence <= hurdle(curve)) {
                debug!("{} is the pump's own curve of its speed", effect.id());
                passed.push(effect);
                continue;
            }
            return Some(Likeliest {
                effect,
                bent,
                of_speed,
            });
        }
        None
    }

    fn decided(&self) -> Ruling {
        /// What lies at its bound must explain more than so many times what the best effect claims, and so many e-folds. Set by hand.
        const BEYOND: f64 = 2.0;
        const BEYOND_BESIDES: f64 = 10.0;
        let likeliest = self.likeliest();
        if let Some(seen) = self.seen_first() {
            return self.unnamed(seen, seen.evidence, None);
        }
        if let Some(beyond) = self.beyond()
            && (likeliest.as_ref())
                .is_none_or(|l| beyond.evidence > BEYOND * l.effect.claim() + BEYOND_BESIDES)
            && let Some(r) = self.rivals_in(beyond.effect.about().relation).next()
        {
            return self.unnamed(r, beyond.evidence, None);
        }
        let Some(Likeliest {
            effect: best,
            bent,
            of_speed,
        }) = likeliest
        else {
            let stands = |r: &&Correction| r.evidence - self.tolerated(r) > self.unknown_hurdle(r);
            let most = (self.rivals.iter().filter(stands))
                .max_by(|a, b| a.evidence.total_cmp(&b.evidence));
            return most.map_or(Ruling::Nothing, |r| self.unnamed(r, r.evidence, None));
        };
        if let Some((curve, odds)) = of_speed {
            return self.unnamed(&curve, curve.borne, Some((best, odds)));
        }
        if let Some((lasting, odds)) = self.lasting(best) {
            let episode = self.episode_like(&lasting, odds, || self.sharpened(&lasting));
            return episode.unwrap_or_else(|| Ruling::Named(self.named(&lasting, Some(odds))));
        }
        let beside = Beside::of(self, best, &bent);
        let resembles = if beside.is_strange() {
            bent.odds.max(BARRED)
        } else {
            bent.odds
        };
        let with = || {
            if resembles > 0.0 {
                beside.with_second()
            } else {
                beside.state().to_vec()
            }
        };
        if let Some(episode) = self.episode_like(best, resembles, with) {
            return episode;
        }
        let broken = bent.unless_told(&beside);
        let rival = (self.rival(best, broken)).or_else(|| self.rival_beyond(best, broken));
        let Some(rival) = rival else {
            return Ruling::Named(self.named(best, (broken > 0.0).then_some(broken)));
        };
        if rival.seen.is_some() {
            return self.against_seen(best, rival, broken);
        }
        // What is left over decides, however far the form is bent: a form may bend and leave nothing.
        let (resembles, second) = beside.resembles(rival);
        self.by_what_is_left(best, rival, resembles, second)
    }

    /// An episode in place of an effect that by the logarithm of the odds only resembles the cause, or that tells hardly more than an episode
    /// does, if one tells more than the state `with` the effect, and what may be beside it.
    fn episode_like(
        &self,
        best: &Contender,
        odds: f64,
        with: impl FnOnce() -> Vec<Applied>,
    ) -> Option<Ruling> {
        /// Share of the evidence of an effect from which on an episode is held against it: a meter that reads less from some time on tells
        /// nearly what a leak does. Set by hand.
        const NEARLY: f64 = 0.8;
        let nearly = |r: &Correction| {
            r.curve.quantity == Quantity::Episode && r.borne > NEARLY * best.evidence
        };
        // What passes by itself is an episode already.
        let stays = best.effect.about().duration().is_none();
        if odds <= 0.0 && !(stays && self.rivals.iter().any(nearly)) {
            return None;
        }
        let rival = (self.rivals.iter()).find(|r| r.borne > self.rival_hurdle(r));
        let (episode, less) = episode_like(self.record, &self.state, &with(), rival)?;
        let evidence = episode.borne.max(best.evidence);
        let odds = if odds > 0.0 {
            odds
        } else {
            less / best.temperature()
        };
        let resembling = Some((best, odds));
        Some(Ruling::Unnamed(
            self.corrected(&episode, evidence, resembling),
        ))
    }

    /// Decides by the logarithm of the odds that the best effect only resembles what a rival tells, and by the second effect that tells what
    /// the best one leaves over, if there is one: then the two are the cause, if the second is named.
    fn by_what_is_left(
        &self,
        best: &Contender,
        rival: &Correction,
        odds: f64,
        second: Option<Second>,
    ) -> Ruling {
        let resembling =
            || self.corrected(rival, rival.borne.max(best.evidence), Some((best, odds)));
        match second {
            Some(second) if odds > 0.0 => Ruling::Promised {
                named: self.named(best, None),
                second: second.applied.id(),
                otherwise: Box::new(resembling()),
            },
            Some(_) => Ruling::Named(self.named(best, None)),
            None if odds > 0.0 => Ruling::Unnamed(resembling()),
            None => Ruling::Named(self.named(best, Some(odds))),
        }
    }

    /// What two transmitters show, before any effect is weighed against what it leaves of the relations; unless the catalogue holds
    /// what one of the two does.
    fn seen_first(&self) -> Option<&Correction> {
        let seen = (self.rivals.iter())
            .filter(|r| r.seen.is_some() && r.evidence > self.unknown_hurdle(r))
            .max_by(|a, b| a.evidence.total_cmp(&b.evidence))?;
        let of_the_catalogue = |c: &Contender| {
            let about = c.effect.about();
            let enters = seen.curve.place.shows_in().contains(&about.relation);
            about.sensor().is_some() && enters && with_its_ends(c) > ALIKE * seen.evidence
        };
        (!self.contenders.iter().any(of_the_catalogue)).then_some(seen)
    }

    /// Decides between an effect and what two transmitters show.
    fn against_seen(&self, best: &Contender, seen: &Correction, broken: f64) -> Ruling {
        let claim = best.claim().max(with_its_ends(best));
        let odds = (seen.claim() - claim) / best.temperature() - self.class(best).ln();
        let odds = odds.max(broken);
        if odds > 0.0 {
            let evidence = seen.borne.max(best.evidence);
            return self.unnamed(seen, evidence, None);
        }
        Ruling::Named(self.named(best, Some(odds)))
    }

    /// Whether an effect stands out beside what has been named, by what is asked of one that stands alone.
    pub(crate) fn shows(&self, id: &str) -> bool {
        (self.contender(id))
            .is_some_and(|c| c.evidence > contest::hurdle(self.record, &c.best.applied))
    }

    /// The same, where what the forms of named effects leave over, and the suction loses unseen, does not count.
    pub(crate) fn shows_beside(&self, id: &str) -> bool {
        (self.contender(id)).is_some_and(|c| c.evidence > self.hurdle_of_one(c))
    }

    /// How likely it is that an effect is there beside what has been named, whatever looks like it.
    pub(crate) fn beside(&self, id: &str) -> f64 {
        self.contender(id).map_or(0.0, |c| self.real(c))
    }

    fn contender(&self, id: &str) -> Option<&Contender> {
        self.contenders.iter().find(|c| c.id() == id)
    }

    /// The one of some effects that explains most, named whatever its evidence; `None` if the recording excites none of them.
    pub(crate) fn given(&self, ids: &[String]) -> Option<Named> {
        let held = |id: &str| {
            let mut found = self.state[self.held..].iter().filter(|one| !one.allowance);
            found.any(|one| one.id() == id)
        };
        // What comes and goes is weighed at other times as well, but each is asked about once.
        let given = |c: &&Contender| {
            let about = c.effect.about();
            ids.iter().any(|id| id == about.id) && !held(about.id) && c.best.energy > 0.0
        };
        let given = self.contenders.iter().filter(given).map(Contender::alone);
        let best = given.max_by(|a, b| a.unblurred().total_cmp(&b.unblurred()))?;
        Some(self.suspected(&best))
    }

    /// The correction that competes with an effect: of its own relation, or one that nothing in the catalogue comes near.
    fn rival(&self, best: &Contender, broken: f64) -> Option<&Correction> {
        /// How many times what an effect claims a correction of another relation must explain. Set by hand.
        const FAR: f64 = 2.0;
        let relation = best.effect.about().relation;
        let far =
            (self.rivals.iter()).find(|r| r.borne > self.rival_hurdle(r).max(FAR * best.claim()));
        // What sound recordings show too is no rival to a form that holds.
        let stands =
            |r: &Correction| r.borne > self.rival_hurdle(r) || (r.borne > 0.0 && broken > 0.0);
        let own = (self.rivals_in(relation)).find(|r| stands(r));
        match (far, own) {
            (Some(far), Some(own)) if own.borne > far.borne => Some(own),
            (far, own) => far.or(own),
        }
    }

    /// Where the form of an effect is broken, the best correction of another relation that it shows in: what it lends its name
    /// to may sit there.
    fn rival_beyond(&self, best: &Contender, broken: f64) -> Option<&Correction> {
        // Only then is it asked where the effect shows.
        let enters = |r: &&Correction| {
            broken > 0.0
                && r.borne > self.rival_hurdle(r)
                && self.share_in(best, r.curve.place) > SHOWS
        };
        self.rivals.iter().find(enters)
    }

    /// The corrections that enter a relation, best first.
    fn rivals_in(&self, relation: Relation) -> impl Iterator<Item = &Correction> {
        (self.rivals.iter()).filter(move |r| r.curve.place.shows_in().contains(&relation))
    }
}

#[cfg(test)]
mod tests;
