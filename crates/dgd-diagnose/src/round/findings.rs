//! An effect or a correction as a finding, beside what else it could be.

use super::footprint::differs_along_stands;
use super::form::is_exact;
use super::{Round, Ruling};
use crate::belief::{BARRED, logistic, shared};
use crate::contest::{self, Contender, alike, at_bound, material, solved, stands};
use crate::empirical::{Correction, hurdle, instead_of};
use crate::relations::Applied;
use crate::selection::{Held, Named};
use crate::timing::is_late_meter;

/// Evidence over which belief in a correction grows by a factor e in the odds, as a share of its hurdle: as sound recordings
/// fall off below it.
pub(super) const SCALE: f64 = 0.4;

/// Logarithm of the odds that there is anything where an effect, or a correction, just reaches its hurdle. Set by hand.
const EFFECT_AT_HURDLE: f64 = 1.0;
const CORRECTION_AT_HURDLE: f64 = 0.7;

impl Round<'_> {
    /// An effect as a finding, beside the alternatives to it; with the logarithm of the odds that it is none of the catalogue's, if that is
    /// in question.
    pub(super) fn named(&self, best: &Contender, unknown: Option<f64>) -> Named {
        self.among(best, self.alike(best), unknown)
    }

    /// A finding with the evidence and the alternatives that it has here, but for one that is known not to be the cause; `None` of a correction.
    pub(crate) fn without_rival(&self, named: &Named, rival: &str) -> Option<Named> {
        let best = self.contender(named.applied.id())?;
        let mut others = self.alike(best);
        others.retain(|other| other.0 != rival);
        Some(Named {
            applied: named.applied.clone(),
            ..self.among(best, others, None)
        })
    }

    /// A suspect as a finding. Another effect may be likelier than it by any number: that was not asked about.
    pub(super) fn suspected(&self, best: &Contender) -> Named {
        /// More than any probability tells.
        const MOST: f64 = 1e6;
        self.among(best, self.alike_up_to(best, MOST), None)
    }

    /// An effect as a finding, beside others with their weights.
    fn among(
        &self,
        best: &Contender,
        mut others: Vec<(String, f64)>,
        unknown: Option<f64>,
    ) -> Named {
        if let Some(odds) = unknown {
            others.push(("unknown".to_owned(), odds.exp() * self.class(best)));
        }
        let bent = if differs_along_stands(best.effect.about()) {
            best.formed - best.evidence
        } else {
            0.0
        };
        let (probability, mut alternatives) = shared(self.real(best), others);
        // Something within an instrument's accuracy may be what shows, and then is nothing that was left out.
        alternatives.retain(|(id, _)| !self.is_tolerated(id));
        Named {
            applied: solved(&best.best),
            evidence: best.evidence,
            bent,
            hurdle: self.hurdle(best),
            probability,
            alternatives,
            held: None,
            most: self.most(best),
        }
    }

    /// Whether an effect would be within an instrument's accuracy.
    fn is_tolerated(&self, id: &str) -> bool {
        let mut named = self.contenders.iter().filter(|c| c.id() == id);
        named.any(|c| !material(&solved(&c.best)))
    }

    /// Whether there is anything, by how far the evidence stands above the hurdle.
    pub(super) fn real(&self, best: &Contender) -> f64 {
        let belief = &best.effect.about().search.belief;
        let times = contest::times(self.record, &best.best.applied);
        logistic((best.evidence - self.hurdle(best)) / (times * belief.scale) + EFFECT_AT_HURDLE)
    }

    /// The most that the probability of an effect may be, and which other has the rest: a delay and a store are fitted to the same rows with
    /// all that is allowed for beside either, so how far they are apart, what is lost by turning the meter round put back, tells by itself.
    ///
    /// The other need not stand out: eight delays of less than 25 e-folds beside which no store did were stores, each of them (PROOF-HISTORY.md).
    fn most(&self, best: &Contender) -> Option<(f64, &'static str)> {
        /// E-folds that make one of the two likelier by a factor e.
        const TEMPERATURE: f64 = 6.3;
        let about = best.effect.about();
        if !is_late_meter(about) {
            return None;
        }
        let others = (self.contenders.iter())
            .filter(|c| c.id() != about.id && is_late_meter(c.effect.about()));
        let nearest = others.max_by(|a, b| a.unblurred().total_cmp(&b.unblurred()))?;
        let apart = best.unblurred() - nearest.unblurred();
        let most = logistic(apart.max(0.0) / TEMPERATURE);
        Some((most, nearest.id()))
    }

    /// Effects that look like the best one, each with its weight against that, which is 1. One that may not be named itself is no likelier
    /// than the one that may.
    pub(super) fn alike(&self, best: &Contender) -> Vec<(String, f64)> {
        self.alike_up_to(best, 1.0)
    }

    fn alike_up_to(&self, best: &Contender, most: f64) -> Vec<(String, f64)> {
        let weight = |c: &Contender| ((c.claim() - best.claim()) / best.temperature()).exp();
        let id = best.id();
        self.contenders
            .iter()
            .filter(|c| c.id() != id && c.evidence > 0.0)
            .filter(|c| alike(&best.best, &c.best) && stands(self.record, &solved(&c.best)))
            .map(|c| (c.id().to_owned(), weight(c).min(most)))
            .collect()
    }

    /// The weight of the best effect and of all that look like it.
    pub(super) fn class(&self, best: &Contender) -> f64 {
        1.0 + self.alike(best).iter().map(|o| o.1).sum::<f64>()
    }

    /// A correction as what the round comes to: something that two transmitters show, or something that the catalogue does not hold.
    pub(super) fn unnamed(
        &self,
        c: &Correction,
        evidence: f64,
        best: Option<(&Contender, f64)>,
    ) -> Ruling {
        let found = self.corrected(c, evidence, best);
        if found.held.is_some() {
            Ruling::Seen(found)
        } else {
            Ruling::Unnamed(found)
        }
    }

    /// A correction as the finding, with the effects of the relations that it enters as alternatives; `evidence` is what they are held
    /// against, and tells that there is something where the correction does not. Of a `best` effect, and what looks like it, the logarithm
    /// of the odds is known that they only resemble the cause.
    pub(super) fn corrected(
        &self,
        c: &Correction,
        evidence: f64,
        best: Option<(&Contender, f64)>,
    ) -> Named {
        /// E-folds that make an effect less likely than the correction by a factor e: a share of what both are held against, and the least.
        /// Set by hand.
        const TEMPERATURE: f64 = 0.08;
        const LEAST_TEMPERATURE: f64 = 6.0;
        /// An effect is held against the correction at this many times its evidence. Set by hand.
        const HANDICAP: f64 = 1.2;
        // That there is something was found without times of its own; with them it may be told better what.
        let timed = instead_of(self.record, &self.state, c);
        let told = timed.as_ref().unwrap_or(c);
        let temperature = (TEMPERATURE * evidence).max(LEAST_TEMPERATURE);
        let resembling = best.map_or_else(Vec::new, |(best, odds)| {
            let mut class = self.alike(best);
            class.push((best.id().to_owned(), 1.0));
            let share = (-odds).exp() / self.class(best);
            class.iter_mut().for_each(|one| one.1 *= share);
            class
        });
        let is_best = |o: &Contender| best.is_some_and(|(best, _)| std::ptr::eq(best, o));
        let weight = |o: &Contender| {
            let about = o.effect.about();
            let barred = if self.admissible(o) { 0.0 } else { BARRED };
            // What has not been sharpened bends for want of that.
            let broken = if is_exact(about) && !is_best(o) {
                self.form_broken(o, o.formed - o.evidence).max(0.0)
            } else {
                0.0
            };
            let resembling = resembling.iter().find(|one| one.0 == about.id);
            let likely = || {
                ((HANDICAP * o.evidence - evidence) / temperature)
                    .min(0.0)
                    .exp()
            };
            resembling.map_or_else(likely, |one| one.1) * (-broken - barred).exp()
        };
        let others = self
            .contenders
            .iter()
            .filter(|o| o.evidence > 0.0 && stands(self.record, &solved(&o.best)))
            .filter(|o| {
                (c.curve.place.shows_in()).contains(&o.effect.about().relation)
                    && !at_bound(&solved(&o.best))
            })
            .map(|o| (o.id().to_owned(), weight(o)))
            .collect();
        let evidence = evidence.max(c.evidence);
        let real = logistic(
            (evidence - self.unknown_hurdle(c)) / (SCALE * hurdle(c)) + CORRECTION_AT_HURDLE,
        );
        // That the effect stands out tells as well that there is something. Beside others it may be what their forms lack.
        let real = match best {
            Some((best, _)) if self.known == 0 => real.max(self.real(best)),
            _ => real,
        };
        let (probability, alternatives) = shared(real, others);
        let held = c.seen.as_ref().map(|_| Held {
            curve: c.curve.clone(),
            borne: c.borne,
        });
        Named {
            applied: Applied::from(c.seen.as_ref().unwrap_or(&told.curve)),
            evidence,
            bent: 0.0,
            hurdle: self.unknown_hurdle(c),
            probability,
            alternatives,
            held,
            most: None,
        }
    }
}
