//! One round of the search: what stands out is named, or shown to be nothing in the catalogue, or nothing is.

mod footprint;

use crate::belief::{logistic, shared};
use crate::contest::{
    Contender, alike, at_bound, before, contest, material, sets_in, solved, stands,
};
use crate::empirical::{Correction, FLOW_RATE, corrections, hurdle, instead_of, plausible};
use crate::ended::ended;
use crate::limit::{Energy, Showing};
use crate::record::Record;
use crate::refine::refine;
use crate::relations::Applied;
use crate::scan::{Candidate, joined, on_grid};
use crate::select::{Held, Named, Selection};
use crate::step::Step;
use crate::tangent::{Bend, Tangent, dot};
use crate::timing::is_late_meter;
use dgd_effects::{About, HEAD, PLACES, QUANTITIES, Relation};
use footprint::{Footprint, KNOTS_WANT, differs_along_stands, known};
use std::ops::Range;
use tracing::debug;

/// Evidence that a first, second, third effect and so on must show beyond its hurdle: causes seldom come together.
const FURTHER: [f64; 6] = [0.0, 8.0, 40.0, 200.0, 400.0, 800.0];

/// Evidence over which belief in a correction grows by a factor e in the odds, as a share of its hurdle: as sound recordings
/// fall off below it.
const SCALE: f64 = 0.4;

/// Error of a form up to which it is exact: a gain, an area, a loss on the velocity head, a lag in what is pumped.
const EXACT: f64 = 0.1;

/// Share of its evidence by which a form that is not exact may bend, whatever its error: that sets how far it can. Set by hand, above
/// what single causes in simulated recordings bend by; what only resembles them often bends by more (both are traced).
const ROUGH: f64 = 0.25;

/// Over what a form bends by: what a second effect must show beside it, the slack of that form allowed for, to be what bends it.
const MOSTLY: f64 = 0.7;

/// Share of what an effect explains from which on it shows in a relation.
const SHOWS: f64 = 0.1;

/// Share of the evidence of what two transmitters show from which on an effect of the catalogue may be what one of them does.
const ALIKE: f64 = 0.7;

/// What it costs a cause, in e-folds, that it may not be named as it is.
const BARRED: f64 = 1.4;

/// What a round comes to.
pub(crate) enum Ruling {
    /// An effect.
    Named(Named),
    /// An effect, on the promise that a second one, whose name it is, does beside it what a correction does; and what the
    /// round comes to if it does not.
    Promised(Named, &'static str, Box<Self>),
    /// Something that the catalogue does not hold: the search ends.
    Unnamed(Named),
    /// Something that two transmitters show: the search goes on beside it.
    Seen(Named),
    /// Nothing more that sound recordings do not show.
    Nothing,
}

/// How far the form of an effect is bent.
struct Bent {
    /// Logarithm of the odds that it does not hold.
    odds: f64,
    /// The state with the effect sharpened, and what its form gains there; `None` where its form was asked as it stands.
    sharpened: Option<(Vec<Applied>, f64)>,
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
    /// Plausible corrections, best first.
    rivals: Vec<Correction>,
    /// Places of what has been found that the catalogue does not hold.
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
        for c in contenders.iter().take(9) {
            let about = c.effect.about();
            debug!(
                "round {}: {} {:.1} ({:.1} within its form) of {:.0}, {:?}",
                selection.named.len() + 1,
                about.id,
                c.evidence,
                c.formed,
                about.search.belief.hurdle,
                solved(&c.best).parameters
            );
        }
        for r in rivals.iter().take(3) {
            let (place, quantity) = (PLACES[r.place].name, QUANTITIES[r.quantity]);
            debug!(
                "correction of {place} by {quantity} {:.1} of {:.0}, freedom {:.1}",
                r.evidence,
                hurdle(r),
                r.freedom
            );
        }
        let known = known(record, &state, selection)?;
        let footprints = if record.takes(Step::Footprints) {
            Footprint::all(record, &gate, &state, &known)
        } else {
            Vec::new()
        };
        Some(Self {
            known: known.len(),
            footprints,
            record,
            state,
            gate,
            contenders,
            rivals,
            unnamed: (selection.named.iter())
                .filter(|n| n.is_unnamed())
                .filter_map(|n| n.correction.map(|(place, _)| place))
                .collect(),
        })
    }

    /// Decides between the best effect and the best correction.
    pub(crate) fn ruling(&self) -> Ruling {
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

    /// The effect that stands out where nothing of what the catalogue does not hold is shown, if it is beyond doubt.
    pub(crate) fn apart(&self) -> Option<Named> {
        let Ruling::Named(named) = self.ruling() else {
            return None;
        };
        let of = |c: &&Contender| c.effect.about().id == named.applied.effect.about().id;
        let c = self.contenders.iter().find(of)?;
        let beside = |place: &usize| {
            let enters = PLACES[*place].shows_in.contains(&c.effect.about().relation);
            !enters && self.share_in(c, *place) < SHOWS
        };
        self.unnamed.iter().all(beside).then_some(named)
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

    /// Decides between an effect by itself and a correction.
    fn against(&self, best: &Contender, rival: &Correction, broken: f64) -> Ruling {
        let unnamed = |evidence: f64| self.unnamed(rival, evidence, Some((best, broken)));
        if rival.borne > hurdle(rival) && rival.borne > 1.2 * best.claim() + 30.0 {
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

    /// An effect as a finding, beside the alternatives to it.
    fn named(&self, best: &Contender, rival: Option<&Correction>, broken: f64) -> Named {
        let others = self.others(best, rival, broken);
        let bent = if differs_along_stands(best.effect.about()) {
            best.formed - best.evidence
        } else {
            0.0
        };
        let (probability, alternatives) = shared(self.real(best), others);
        Named {
            applied: solved(&best.best),
            evidence: best.evidence,
            bent,
            hurdle: self.hurdle(best),
            probability,
            alternatives,
            correction: None,
            held: None,
        }
    }

    /// Whether there is anything, by how far the evidence stands above the hurdle.
    fn real(&self, best: &Contender) -> f64 {
        let scale = best.effect.about().search.belief.scale;
        logistic((best.evidence - self.hurdle(best)) / scale + 1.0)
    }

    /// The effect that, beside the best one, does what a correction does, if there is one.
    fn two_do(&self, best: &Contender, rival: f64) -> Option<&'static str> {
        let (second, evidence) = self.second(&self.sharpened(best), |_| true)?;
        // Two physical forms that come near what knots can do at will are the likelier.
        (evidence > 0.9 * rival - best.evidence).then_some(second)
    }

    /// How much of an effect shows in the relations that a correction of some place enters.
    fn share_in(&self, c: &Contender, place: usize) -> f64 {
        const SECTIONS: [Relation; 4] = [
            Relation::ReturnLineFriction,
            Relation::PumpHead,
            Relation::Instrument,
            Relation::RiserMassBalance,
        ];
        let energy =
            |rows: Range<usize>| dot(&c.best.signature[rows.clone()], &c.best.signature[rows]);
        let sections = self.gate.layout.sections();
        let (mut there, mut whole) = (0.0, 0.0);
        for (rows, relation) in sections.into_iter().zip(SECTIONS) {
            let energy = energy(rows);
            whole += energy;
            there += if PLACES[place].shows_in.contains(&relation) {
                energy
            } else {
                0.0
            };
        }
        if whole > 0.0 { there / whole } else { 0.0 }
    }

    /// The best effect beside those named, with its parameters sharpened: a strength that was solved for on a straight line and
    /// a shape from a grid would leave over what passes for something else.
    fn sharpened(&self, best: &Contender) -> Vec<Applied> {
        let mut state = joined(&self.state, &solved(&best.best));
        let last = state.len() - 1;
        refine(self.record, &mut state, last, &[], 1);
        state
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

    /// What a correction must show beside what has been named: knots fit the want of form of another effect with ease.
    fn unknown_hurdle(&self, r: &Correction) -> f64 {
        let first = if self.known == 0 { 1.0 } else { 1.5 };
        first * hurdle(r) + 2.0 * self.further() + KNOTS_WANT * self.left_over(&r.signature)
    }

    /// What an effect must show beside what has been named.
    fn hurdle(&self, c: &Contender) -> f64 {
        c.effect.about().search.belief.hurdle + self.further() + self.left_over(&c.best.signature)
    }

    /// How an effect would show beside what has been named; `None` if it may not be named there.
    pub(crate) fn showing(&self, c: &Contender) -> Option<Showing> {
        let about = c.effect.about();
        if self.late_again(about) {
            return None;
        }
        let hurdle = self.hurdle(c);
        if on_grid(about) {
            return Some(Showing {
                energy: Energy::on_grid(c, &self.state),
                hurdle,
                before: 0.0,
            });
        }
        let shape = |shape: &Candidate| Showing {
            energy: Energy::Unit(shape.energy),
            hurdle,
            before: before(self.record, &self.gate, &self.state, shape),
        };
        // The likeliest shape may be one that does nothing, or comes too late to set in.
        let likeliest = shape(&c.best);
        let told = likeliest.limit(about).is_some();
        Some(if told { likeliest } else { shape(&c.plainest) })
    }

    /// What one more cause must show beyond its hurdle.
    fn further(&self) -> f64 {
        FURTHER[self.known.min(FURTHER.len() - 1)]
    }

    /// Evidence that what has been named leaves over for a candidate.
    fn left_over(&self, signature: &[f64]) -> f64 {
        self.footprints.iter().map(|f| f.left_over(signature)).sum()
    }

    /// The correction that competes with an effect: of its own relation, or one that nothing in the catalogue comes near.
    fn rival(&self, best: &Contender, broken: f64) -> Option<&Correction> {
        let relation = best.effect.about().relation;
        let far = (self.rivals.iter()).find(|r| r.borne > hurdle(r).max(2.0 * best.claim()));
        // What sound recordings show too is no rival to a form that holds.
        let stands = |r: &Correction| r.borne > hurdle(r) || (r.borne > 0.0 && broken > 0.0);
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
            broken > 0.0 && r.borne > hurdle(r) && self.share_in(best, r.place) > SHOWS
        };
        self.rivals.iter().find(enters)
    }

    /// The corrections that enter a relation, best first.
    fn rivals_in(&self, relation: Relation) -> impl Iterator<Item = &Correction> {
        (self.rivals.iter()).filter(move |r| PLACES[r.place].shows_in.contains(&relation))
    }

    /// What would explain most, were it not at the bound of what is plausible: something else does what it would do.
    fn beyond(&self) -> Option<&Contender> {
        // Later it may be the want of form of what has been named.
        if self.known > 0 {
            return None;
        }
        self.contenders
            .iter()
            .filter(|c| c.evidence > self.hurdle(c) && at_bound(&solved(&c.best)))
            .max_by(|a, b| a.evidence.total_cmp(&b.evidence))
    }

    /// Whether an effect may be named if its evidence suffices.
    pub(crate) fn admissible(&self, c: &Contender) -> bool {
        let one = solved(&c.best);
        let wanting = if at_bound(&one) {
            "stands at the bound of what is plausible"
        } else if !material(&one) {
            "is within an instrument's accuracy"
        } else if !stands(self.record, &one) {
            "does not part the two transmitters"
        } else if !sets_in(self.record, &self.gate, &self.state, &c.best) {
            "is as good when it is always there"
        } else {
            return true;
        };
        debug!("{} {wanting}", c.effect.about().id);
        false
    }

    /// The likeliest effect that may be named, and how far its form is bent.
    ///
    /// What a form gains within its error is its own as long as it holds; else it may be a second effect's, and the evidence decides.
    fn best(&self) -> Option<(&Contender, Bent)> {
        let open: Vec<&Contender> = (self.contenders.iter())
            .filter(|c| self.may_be_named(c))
            .collect();
        let most = |of: fn(&Contender) -> f64| {
            (open.iter().copied()).max_by(|a, b| of(a).total_cmp(&of(b)))
        };
        let likeliest = most(Contender::claim)?;
        let bent = self.bent(likeliest);
        match most(|c| c.evidence) {
            Some(strongest) if bent.odds > 0.0 && !std::ptr::eq(strongest, likeliest) => {
                Some((strongest, self.bent(strongest)))
            }
            _ => Some((likeliest, bent)),
        }
    }

    /// Whether an effect stands out, and may be what it seems.
    fn may_be_named(&self, c: &Contender) -> bool {
        c.evidence > self.hurdle(c) && !self.late_again(c.effect.about()) && self.admissible(c)
    }

    /// Of the effects of the meter's timing one at the most: what it leaves over looks like the other.
    fn late_again(&self, about: &About) -> bool {
        is_late_meter(about) && timed(&self.state)
    }

    /// What else may be the cause, each with its weight against that of the best, which is 1.
    fn others(
        &self,
        best: &Contender,
        rival: Option<&Correction>,
        broken: f64,
    ) -> Vec<(String, f64)> {
        // A Bayes factor counts in full near the noise; far above it, forms decide, and they are rough.
        let temperature = (0.06 * best.claim()).hypot(1.5);
        let weight = |e: f64| ((e - best.claim()) / temperature).exp();
        let id = best.effect.about().id;
        let mut others: Vec<(String, f64)> = self
            .contenders
            .iter()
            .filter(|c| c.effect.about().id != id && c.evidence > 0.0)
            .filter(|c| alike(&best.best, &c.best) && stands(self.record, &solved(&c.best)))
            // One that may not be named itself is no likelier than the one that may.
            .map(|c| (c.effect.about().id.to_owned(), weight(c.claim()).min(1.0)))
            .collect();
        // A form that does not hold tells of something else even where no correction shows what.
        let claimed = rival.map_or(0.0, |r| weight(r.claim()));
        if rival.is_some() || broken > 0.0 {
            others.push(("unknown".to_owned(), claimed.max(broken.exp())));
        }
        others
    }

    /// Logarithm of the odds that an effect only lends its name to something of another form, unless it is a second effect that
    /// bends it: an exact form that two effects bend is seldom the one of the two.
    fn broken(&self, bent: &Bent) -> f64 {
        let Some((state, gain)) = &bent.sharpened else {
            return bent.odds;
        };
        // What the timing allowed for beside it lacks is no second cause.
        let timeless = |about: &About| about.search.timing.is_none();
        let bends = |(_, evidence)| evidence > MOSTLY * gain;
        if bent.odds > 0.0 && self.second(state, timeless).is_some_and(bends) {
            return f64::NEG_INFINITY;
        }
        bent.odds
    }

    /// How far the form of an effect is bent, whatever bends it.
    fn bent(&self, c: &Contender) -> Bent {
        /// Odds that matter to no probability.
        const NO_ODDS: f64 = -4.0;
        let as_it_stands = |odds: f64| Bent {
            odds,
            sharpened: None,
        };
        if !self.record.takes(Step::Form) {
            return as_it_stands(f64::NEG_INFINITY);
        }
        let about = c.effect.about();
        let odds = self.form_broken(c, c.formed - c.evidence);
        if is_exact(about) || odds < NO_ODDS {
            return as_it_stands(odds);
        }
        let state = self.sharpened(c);
        // Sharpened to nothing it has no form to look at.
        let Some(one) = state.last().filter(|one| one.parameters[0] != 0.0) else {
            return as_it_stands(odds);
        };
        let gain = self.gate.form_gain(self.record, &self.state, one);
        if !gain.is_finite() {
            return as_it_stands(odds);
        }
        let odds = self.form_broken(c, gain);
        debug!("{} bends by {gain:.1}, odds {odds:.1}", about.id);
        Bent {
            odds,
            sharpened: Some((state, gain)),
        }
    }

    /// The same by itself, from what the slack of its form gains: how much that is beyond what the error of the form, and those
    /// of the effects that were named before it, account for. What has another strength in each stand has no form to break.
    fn form_broken(&self, c: &Contender, gain: f64) -> f64 {
        let search = &c.effect.about().search;
        if search.stand_error.is_some() {
            return f64::NEG_INFINITY;
        }
        let error = if is_exact(c.effect.about()) {
            search.form_error
        } else {
            ROUGH
        };
        let gain = gain - self.left_over(&c.best.signature);
        let odds = (gain - 3.0 - error * c.evidence) / (4.0 + 0.02 * c.evidence);
        if odds > 50.0 { 50.0 } else { odds }
    }

    /// A correction as the finding, with the effects of the relations that it enters as alternatives; `evidence` is what they are held
    /// against, and tells that there is something where the correction does not. Of the `best` effect it is known how far its form is
    /// broken.
    fn unnamed(&self, c: &Correction, evidence: f64, best: Option<(&Contender, f64)>) -> Ruling {
        // That there is something was found without a period; with one it may be told better what.
        let swings = instead_of(self.record, &self.state, c);
        let told = swings.as_ref().unwrap_or(c);
        let temperature = (0.08 * evidence).max(6.0);
        let weight = |o: &Contender| {
            let likely = ((1.2 * o.evidence - evidence) / temperature).min(0.0);
            let barred = if self.admissible(o) { 0.0 } else { BARRED };
            let broken = match best {
                Some((best, broken)) if std::ptr::eq(best, o) => broken,
                // What has not been sharpened bends for want of that.
                _ if !is_exact(o.effect.about()) => 0.0,
                _ => self.form_broken(o, o.formed - o.evidence),
            };
            (likely - broken.max(0.0) - barred).exp()
        };
        let others = self
            .contenders
            .iter()
            .filter(|o| o.evidence > 0.0 && stands(self.record, &solved(&o.best)))
            .filter(|o| {
                (PLACES[c.place].shows_in).contains(&o.effect.about().relation)
                    && !at_bound(&solved(&o.best))
            })
            .map(|o| (o.effect.about().id.to_owned(), weight(o)))
            .collect();
        let evidence = evidence.max(c.evidence);
        let real = logistic((evidence - self.unknown_hurdle(c)) / (SCALE * hurdle(c)) + 0.7);
        let (probability, alternatives) = shared(real, others);
        let found = |applied: &Applied, held: Option<Held>| Named {
            applied: applied.clone(),
            evidence,
            bent: 0.0,
            hurdle: self.unknown_hurdle(c),
            probability,
            alternatives,
            correction: Some((told.place, told.quantity)),
            held,
        };
        match &c.seen {
            Some(seen) => {
                let held = Held {
                    applied: c.applied.clone(),
                    borne: c.borne,
                };
                Ruling::Seen(found(seen, Some(held)))
            }
            None => Ruling::Unnamed(found(&told.applied, None)),
        }
    }
}

/// Whether the form of an effect holds to the letter.
fn is_exact(about: &About) -> bool {
    about.search.form_error <= EXACT
}

/// Whether a correction is what a late meter leaves over, and no second thing: its form follows the rate of the flow, and the flow
/// that is made of its reading is the noisier, which turns the head towards the inlet pressure.
fn owed_to_timing(r: &Correction) -> bool {
    let quantity = QUANTITIES[r.quantity];
    quantity == FLOW_RATE || (r.place == HEAD && quantity == "inlet pressure")
}

/// Whether a late meter has been named.
fn timed(state: &[Applied]) -> bool {
    let late = |a: &Applied| !a.allowance && is_late_meter(a.effect.about());
    state.iter().any(late)
}

#[cfg(test)]
mod tests;
