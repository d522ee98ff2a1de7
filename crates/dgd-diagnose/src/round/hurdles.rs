//! What effects and corrections must show beside what has been named, and which effects may be.

use super::form::Bent;
use super::{Round, SHOWS};
use crate::contest::{self, Contender, at_bound, before, material, sets_in, solved, stands};
use crate::empirical::{Correction, hurdle, rival_hurdle};
use crate::layout::Section;
use crate::limit::{Energy, Showing};
use crate::relations::{Applied, on_grid};
use crate::scan::Candidate;
use crate::timing::is_late_meter;
use dgd_effects::{About, Place};
use dgd_lsq::dot;
use std::ops::Range;
use tracing::debug;

/// Odds, in e-folds, that matter to no probability.
pub(super) const NO_ODDS: f64 = -4.0;

/// Evidence that a first, second, third effect and so on must show beyond its hurdle: causes seldom come together. Each asks twice what the
/// one before it does.
///
/// When they were set, in 60 recordings of three or four causes (`dgd-plant conceal --kind several --level 2 --seed 721`) 176 of 213 causes were named with
/// these, 154 with 40, 200 and 400 for the third to the fifth and 179 with 12, 16 and 24, with two wrong names each; beside causes from outside the catalogue
/// (`--kind beside --seed 732 --count 40`) wrong names were 7, 6 and 8.
pub(super) const FURTHER: [f64; 6] = [0.0, 8.0, 16.0, 32.0, 64.0, 128.0];

/// By what its hurdle is multiplied where an effect is to stand beside what the catalogue does not hold: of that, knots leave more over than any
/// footprint tells, and simulated recordings of a single such cause show effects of others up to twice their hurdle.
pub(super) const HURDLES_BESIDE_UNNAMED: f64 = 3.0;

/// Whether a late meter has been named.
pub(super) fn timed(state: &[Applied]) -> bool {
    let late = |a: &Applied| !a.allowance && is_late_meter(a.effect.about());
    state.iter().any(late)
}

impl Round<'_> {
    /// What an effect must show beside what has been named, and beyond what the suction may lose unseen.
    pub(crate) fn hurdle(&self, c: &Contender) -> f64 {
        self.beside_named(c) + self.lost_unseen(&c.best.signature)
    }

    /// The same for one of which nobody asks how many have been named.
    pub(super) fn hurdle_of_one(&self, c: &Contender) -> f64 {
        self.hurdle(c) - self.further()
    }

    /// The same but for what the suction may lose unseen.
    fn beside_named(&self, c: &Contender) -> f64 {
        /// By what is multiplied what is left over for an effect that ends: it may be anywhere, for any time. Set by hand.
        const ENDS: f64 = 1.5;
        let ends = if c.effect.lasting().is_some() {
            ENDS
        } else {
            1.0
        };
        contest::hurdle(self.record, &c.best.applied)
            + self.further()
            + ends * self.left_over(&c.best.signature, false)
    }

    /// From what evidence on an effect may be named.
    pub(super) fn asked(&self, c: &Contender) -> f64 {
        let times = if self.unnamed.is_empty() {
            1.0
        } else {
            HURDLES_BESIDE_UNNAMED
        };
        times * self.beside_named(c) + self.lost_unseen(&c.best.signature)
    }

    /// What a correction must show to be held against an effect: more than sound recordings show, and a loss at the suction.
    pub(super) fn rival_hurdle(&self, r: &Correction) -> f64 {
        rival_hurdle(r) + self.lost_unseen(&r.signature)
    }

    /// What a correction must show beside what has been named: knots fit the want of form of another effect with ease.
    pub(super) fn unknown_hurdle(&self, r: &Correction) -> f64 {
        /// By what its hurdle, and what a further effect must show, are multiplied beside what has been named. Set by hand.
        const BESIDE_NAMED: f64 = 1.5;
        const TIMES_FURTHER: f64 = 2.0;
        let first = if self.known == 0 { 1.0 } else { BESIDE_NAMED };
        first * hurdle(r)
            + TIMES_FURTHER * self.further()
            + self.left_over(&r.signature, true)
            + self.lost_unseen(&r.signature)
    }

    /// Evidence for a correction that instruments within their accuracy explain as well: of what stands out most where it acts and is less than
    /// may be named.
    pub(super) fn tolerated(&self, r: &Correction) -> f64 {
        let within = |c: &&Contender| {
            (r.curve.place.shows_in()).contains(&c.effect.about().relation)
                && !material(&solved(&c.best))
        };
        let evidence = self.contenders.iter().filter(within).map(|c| c.evidence);
        evidence.fold(0.0, f64::max)
    }

    /// Evidence for a candidate that may come of what the suction loses unseen.
    fn lost_unseen(&self, signature: &[f64]) -> f64 {
        (self.suction.as_ref()).map_or(0.0, |loss| loss.left_over(signature))
    }

    /// What one more cause must show beyond its hurdle.
    pub(super) fn further(&self) -> f64 {
        FURTHER[self.known.min(FURTHER.len() - 1)]
    }

    /// Evidence that what has been named leaves over for a candidate, which may be `knots`.
    pub(super) fn left_over(&self, signature: &[f64], knots: bool) -> f64 {
        let each = self.footprints.iter();
        each.map(|f| f.left_over(signature, knots)).sum()
    }

    /// How an effect would show beside what has been named; `None` if it may not be named there.
    pub(crate) fn showing(&self, c: &Contender) -> Option<Showing> {
        let about = c.effect.about();
        if self.late_again(about) {
            return None;
        }
        let hurdle = self.asked(c);
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
        debug!("{} {wanting}", c.id());
        false
    }

    /// Whether an effect stands out, and may be what it seems.
    pub(super) fn may_be_named(&self, c: &Contender) -> bool {
        c.evidence > self.asked(c)
            && !self.late_again(c.effect.about())
            && self.is_beside(c)
            && self.admissible(c)
    }

    /// Whether an effect shows elsewhere than what the catalogue does not hold.
    fn is_beside(&self, c: &Contender) -> bool {
        let relation = &c.effect.about().relation;
        (self.unnamed.iter())
            .map(|curve| curve.place)
            .all(|place| !place.shows_in().contains(relation) && self.share_in(c, place) < SHOWS)
    }

    /// Of the effects of the meter's timing one at the most: what it leaves over looks like the other.
    pub(super) fn late_again(&self, about: &About) -> bool {
        is_late_meter(about) && timed(&self.state)
    }

    /// The likeliest effect that may be named, and how far its form is bent.
    ///
    /// What a form gains within its error is its own as long as it holds; else it may be a second effect's, and the evidence decides.
    ///
    /// - `passed`: what is none of them.
    pub(super) fn best(&self, passed: &[&Contender]) -> Option<(&Contender, Bent)> {
        let open: Vec<&Contender> = (self.contenders.iter())
            .filter(|c| passed.iter().all(|p| !std::ptr::eq(*p, *c)) && self.may_be_named(c))
            .collect();
        let most = |of: fn(&Contender) -> f64| {
            (open.iter().copied()).max_by(|a, b| of(a).total_cmp(&of(b)))
        };
        let likeliest = most(Contender::claim)?;
        let bent = self.bent(likeliest);
        match most(Contender::unblurred) {
            Some(strongest) if bent.odds > 0.0 && !std::ptr::eq(strongest, likeliest) => {
                Some((strongest, self.bent(strongest)))
            }
            _ => Some((likeliest, bent)),
        }
    }

    /// What would explain most, were it not at the bound of what is plausible: something else does what it would do.
    pub(super) fn beyond(&self) -> Option<&Contender> {
        // Later it may be the want of form of what has been named.
        if self.known > 0 {
            return None;
        }
        self.contenders
            .iter()
            .filter(|c| c.evidence > self.hurdle(c) && at_bound(&solved(&c.best)))
            .max_by(|a, b| a.evidence.total_cmp(&b.evidence))
    }

    /// How much of an effect shows in the relations that a correction of some place enters.
    pub(super) fn share_in(&self, c: &Contender, place: Place) -> f64 {
        let energy =
            |rows: Range<usize>| dot(&c.best.signature[rows.clone()], &c.best.signature[rows]);
        let (mut there, mut whole) = (0.0, 0.0);
        for section in Section::ALL {
            let energy = energy(self.gate.layout.rows(section));
            whole += energy;
            there += if place.shows_in().contains(&section.relation()) {
                energy
            } else {
                0.0
            };
        }
        if whole > 0.0 { there / whole } else { 0.0 }
    }
}
