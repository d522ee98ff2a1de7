//! An effect or a correction as a finding, beside what else it could be.

use super::footprint::differs_along_stands;
use super::form::is_exact;
use super::{Round, Ruling};
use crate::belief::{logistic, shared};
use crate::contest::{Contender, alike, at_bound, solved, stands};
use crate::empirical::{Correction, hurdle, instead_of};
use crate::relations::Applied;
use crate::select::{Held, Named};
use dgd_effects::PLACES;

/// Evidence over which belief in a correction grows by a factor e in the odds, as a share of its hurdle: as sound recordings
/// fall off below it.
pub(super) const SCALE: f64 = 0.4;

/// What it costs a cause, in e-folds, that it may not be named as it is.
pub(super) const BARRED: f64 = 1.4;

impl Round<'_> {
    /// An effect as a finding, beside the alternatives to it.
    pub(super) fn named(&self, best: &Contender, rival: Option<&Correction>, broken: f64) -> Named {
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
    pub(super) fn real(&self, best: &Contender) -> f64 {
        let scale = best.effect.about().search.belief.scale;
        logistic((best.evidence - self.hurdle(best)) / scale + 1.0)
    }

    /// What else may be the cause, each with its weight against that of the best, which is 1.
    pub(super) fn others(
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

    /// A correction as the finding, with the effects of the relations that it enters as alternatives; `evidence` is what they are held
    /// against, and tells that there is something where the correction does not. Of the `best` effect it is known how far its form is
    /// broken.
    pub(super) fn unnamed(
        &self,
        c: &Correction,
        evidence: f64,
        best: Option<(&Contender, f64)>,
    ) -> Ruling {
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
