//! One round of the search: what stands out is named, or shown to be nothing in the catalogue, or nothing is.

mod findings;
mod footprint;
mod form;
mod hurdles;

use crate::contest::{Contender, contest, material, solved};
use crate::empirical::{Correction, FLOW_RATE, corrections, hurdle, plausible};
use crate::ended::ended;
use crate::record::Record;
use crate::relations::Applied;
use crate::select::{Named, Selection};
use crate::step::Step;
use crate::suction::Unmeasured;
use crate::tangent::{Bend, Tangent};
use dgd_effects::{About, HEAD, PLACES, QUANTITIES, Relation};
use footprint::{Footprint, known};
use form::{Bent, MOSTLY};
use hurdles::{FURTHER, timed};
use tracing::debug;

/// Share of what an effect explains from which on it shows in a relation.
const SHOWS: f64 = 0.1;

/// Share of the evidence of what two transmitters show from which on an effect of the catalogue may be what one of them does.
const ALIKE: f64 = 0.7;

/// Share of what a correction explains that an effect explains at least if it is the cause: so far the scales of the two differ in
/// simulated recordings.
const OF_ONE_SCALE: f64 = 0.4;

/// Share of what an effect explains that it leaves over to corrections at least if it only resembles the cause: true causes of a set of
/// simulated pairs left a sixth of it at the most.
const RESEMBLES: f64 = 0.25;

/// What a round comes to.
pub(crate) enum Ruling {
    /// An effect.
    Named(Named),
    /// An effect, on the promise that a second one, whose name it is, does beside it what a correction does; and what the
    /// round comes to if it does not.
    Promised(Named, &'static str, Box<Self>),
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
    gate: Tangent,
    pub contenders: Vec<Contender>,
    /// How many effects have been named, here or in the model that the search starts from.
    known: usize,
    footprints: Vec<Footprint>,
    /// What the suction may lose, where nothing tells it.
    suction: Option<Unmeasured>,
    /// Plausible corrections, best first.
    rivals: Vec<Correction>,
    /// Places of what has been found that the catalogue does not hold: effects that show there are not told beside it.
    unnamed: Vec<usize>,
}

impl<'a> Round<'a> {
    /// Weighs everything about what has been named so far.
    pub(crate) fn about(record: &'a Record, selection: &Selection) -> Option<Self> {
        let state = selection.state();
        let gate = Tangent::beside(record, &state, &[], Bend::Lean)?;
        let contenders = contest(record, &gate, &state);
        let mut rivals = if record.takes(Step::Corrections) {
            corrections(record, &state)
        } else {
            Vec::new()
        };
        let timed = timed(&state);
        rivals.retain(|r| plausible(r) && !(timed && owed_to_timing(r)));
        if !rivals.is_empty() {
            for end in ended(record, &gate, &state) {
                let along_time = |r: &&mut Correction| {
                    PLACES[r.place].relation == end.relation && QUANTITIES[r.quantity] == "time"
                };
                // It is a curve along time, with an edge that knots do not have.
                if let Some(r) = rivals.iter_mut().find(along_time) {
                    r.evidence = r.evidence.max(end.evidence);
                    r.borne = r.borne.max(end.evidence);
                }
            }
            rivals.sort_by(|a, b| b.borne.total_cmp(&a.borne));
        }
        let unnamed: Vec<usize> = (selection.named.iter())
            .filter(|n| n.is_unnamed())
            .filter_map(|n| n.correction.map(|(place, _)| place))
            .collect();
        // Knots leave something over where they act.
        let enters = |place: usize, relation| PLACES[place].shows_in.contains(relation);
        rivals.retain(|r| {
            let mut relations = PLACES[r.place].shows_in.iter();
            !relations.any(|relation| unnamed.iter().any(|place| enters(*place, relation)))
        });
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
                c.effect.about().id,
                c.evidence,
                c.formed,
                self.asked(c),
                solved(&c.best).parameters
            );
        }
        for r in self.rivals.iter().take(3) {
            debug!(
                "round {number}: correction of {} by {} {:.1} of {:.1}, freedom {:.1}",
                PLACES[r.place].name,
                QUANTITIES[r.quantity],
                r.evidence,
                self.unknown_hurdle(r),
                r.freedom
            );
        }
    }

    /// Decides between the best effect and the best correction. Beside what the catalogue does not hold only an effect that needs no second one
    /// is named.
    pub(crate) fn ruling(&self) -> Ruling {
        match self.decided() {
            Ruling::Named(named) => Ruling::Named(named),
            _ if !self.unnamed.is_empty() => Ruling::Nothing,
            ruling => ruling,
        }
    }

    fn decided(&self) -> Ruling {
        let best = self.best();
        if let Some(seen) = self.seen_first() {
            return self.unnamed(seen, seen.evidence, None);
        }
        if let Some(beyond) = self.beyond()
            && (best.as_ref()).is_none_or(|(b, _)| beyond.evidence > 2.0 * b.claim() + 10.0)
            && let Some(r) = self.rivals_in(beyond.effect.about().relation).next()
        {
            return self.unnamed(r, beyond.evidence, None);
        }
        let Some((best, bent)) = best else {
            let stands = |r: &&Correction| r.evidence > self.unknown_hurdle(r);
            let most = (self.rivals.iter().filter(stands))
                .max_by(|a, b| a.evidence.total_cmp(&b.evidence));
            return most.map_or(Ruling::Nothing, |r| self.unnamed(r, r.evidence, None));
        };
        let broken = self.broken(&bent);
        let rival = (self.rival(best, broken)).or_else(|| self.rival_beyond(best, broken));
        let Some(rival) = rival else {
            return Ruling::Named(self.named(best, None, broken));
        };
        let alone = self.against(best, rival, broken);
        if let Some(otherwise) = self.by_what_is_left((best, &bent), rival, broken, &alone) {
            return otherwise;
        }
        // No two effects part two transmitters.
        if rival.claim() < best.claim() - 10.0 || rival.seen.is_some() {
            return alone;
        }
        // Where two effects do what the correction does, it is the second that bends the first.
        match self.two_do(best, rival.claim()) {
            Some(second) => {
                let named = self.named(best, None, f64::NEG_INFINITY);
                Ruling::Promised(named, second, Box::new(alone))
            }
            None => alone,
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
            let enters = PLACES[seen.place].shows_in.contains(&about.relation);
            about.sensor().is_some() && enters && c.evidence > ALIKE * seen.evidence
        };
        (!self.contenders.iter().any(of_the_catalogue)).then_some(seen)
    }

    /// What an effect leaves over, where that decides against what the evidence of the two came to.
    ///
    /// An effect is weighed where the curves bend little, a correction where they bend at will: each has its own noise, and what the two
    /// explain is not of one scale. What corrections tell beside the effect is: nothing, if it is the cause; if it only resembles the cause, a
    /// good part of what it explains, which no second effect tells.
    fn by_what_is_left(
        &self,
        (best, bent): (&Contender, &Bent),
        rival: &Correction,
        broken: f64,
        alone: &Ruling,
    ) -> Option<Ruling> {
        if rival.seen.is_some() || !self.record.takes(Step::Corrections) {
            return None;
        }
        // It may have been sharpened for a look at its form.
        let sharpened = || match &bent.sharpened {
            Some((state, _)) => state.clone(),
            None => self.sharpened(best),
        };
        match alone {
            Ruling::Unnamed(_) if broken <= 0.0 && best.claim() > OF_ONE_SCALE * rival.claim() => {
                let shows_in = |c: &Correction| PLACES[c.place].shows_in;
                let beside = |c: &Correction| {
                    let mut relations = shows_in(c).iter();
                    relations.any(|relation| shows_in(rival).contains(relation))
                };
                let left = corrections(self.record, &sharpened());
                let stands = |c: &Correction| beside(c) && c.borne > hurdle(c);
                (!left.iter().any(stands)).then(|| Ruling::Named(self.named(best, None, broken)))
            }
            Ruling::Named(_) if rival.claim() > RESEMBLES * best.claim() => {
                let state = sharpened();
                let own = |c: &Correction| {
                    PLACES[c.place].relation == best.effect.about().relation
                        && c.borne > self.rival_hurdle(c)
                };
                let left = corrections(self.record, &state);
                let left = (left.iter().filter(|c| own(c))).map(|c| c.borne);
                let most = left.fold(0.0, f64::max);
                let told = |(_, evidence)| evidence > MOSTLY * most;
                let least = RESEMBLES * best.claim();
                if most <= least || self.second(&state, |_| true).is_some_and(told) {
                    return None;
                }
                debug!("{} leaves {most:.1} over", best.effect.about().id);
                let (evidence, odds) = (rival.borne.max(best.evidence), (most / least).ln());
                Some(self.unnamed(rival, evidence, Some((best, broken.max(0.0) + odds))))
            }
            _ => None,
        }
    }

    /// Decides between an effect by itself and a correction.
    fn against(&self, best: &Contender, rival: &Correction, broken: f64) -> Ruling {
        let unnamed = |evidence: f64| self.unnamed(rival, evidence, Some((best, broken)));
        if rival.borne > self.rival_hurdle(rival) && rival.borne > 1.2 * best.claim() + 30.0 {
            return unnamed(rival.borne);
        }
        let named = self.named(best, Some(rival), broken);
        // Where the empirical correction is likelier than all of the catalogue, it stands as the finding.
        let is_unknown = |o: &&(String, f64)| o.0 == "unknown";
        let of = |o: &(String, f64)| o.1;
        let unknown: f64 = named.alternatives.iter().filter(is_unknown).map(of).sum();
        let others: f64 = named.alternatives.iter().map(of).sum::<f64>() - unknown;
        if unknown > named.probability + others {
            return unnamed(rival.borne.max(best.evidence));
        }
        Ruling::Named(named)
    }

    /// The one of some effects that explains most, named whatever its evidence; `None` if the recording excites none of them.
    pub(crate) fn given(&self, ids: &[String]) -> Option<Named> {
        let given = |c: &&Contender| ids.iter().any(|id| id == c.effect.about().id);
        Some(self.named(self.contenders.iter().find(given)?, None, f64::NEG_INFINITY))
    }

    /// The effect that, beside the best one, does what a correction does, if there is one.
    fn two_do(&self, best: &Contender, rival: f64) -> Option<&'static str> {
        let (second, evidence) = self.second(&self.sharpened(best), |_| true)?;
        // Two physical forms that come near what knots can do at will are the likelier.
        (evidence > 0.9 * rival - best.evidence).then_some(second)
    }

    /// A second effect of some kind, and what it explains for its own beside the best one that a state ends with.
    fn second(
        &self,
        state: &[Applied],
        kind: impl Fn(&About) -> bool,
    ) -> Option<(&'static str, f64)> {
        if !self.record.takes(Step::TwoDo) {
            return None;
        }
        let gate = Tangent::beside(self.record, state, &[], Bend::Lean)?;
        let second = contest(self.record, &gate, state).into_iter().find(|c| {
            let about = c.effect.about();
            c.evidence > about.search.belief.hurdle && material(&solved(&c.best)) && kind(about)
        })?;
        let id = second.effect.about().id;
        debug!("beside it {id} shows {:.1}", second.evidence);
        let further = FURTHER[(self.known + 1).min(FURTHER.len() - 1)];
        Some((id, second.evidence - further))
    }

    /// The correction that competes with an effect: of its own relation, or one that nothing in the catalogue comes near.
    fn rival(&self, best: &Contender, broken: f64) -> Option<&Correction> {
        let relation = best.effect.about().relation;
        let far =
            (self.rivals.iter()).find(|r| r.borne > self.rival_hurdle(r).max(2.0 * best.claim()));
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
            broken > 0.0 && r.borne > self.rival_hurdle(r) && self.share_in(best, r.place) > SHOWS
        };
        self.rivals.iter().find(enters)
    }

    /// The corrections that enter a relation, best first.
    fn rivals_in(&self, relation: Relation) -> impl Iterator<Item = &Correction> {
        (self.rivals.iter()).filter(move |r| PLACES[r.place].shows_in.contains(&relation))
    }
}

/// Whether a correction is what a late meter leaves over, and no second thing: its form follows the rate of the flow, and the flow
/// that is made of its reading is the noisier, which turns the head towards the inlet pressure.
fn owed_to_timing(r: &Correction) -> bool {
    let quantity = QUANTITIES[r.quantity];
    quantity == FLOW_RATE || (r.place == HEAD && quantity == "inlet pressure")
}

#[cfg(test)]
mod tests;
