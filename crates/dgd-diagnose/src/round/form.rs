//! How far the form of an effect is bent, and whether that is more than a form may.

use super::Round;
use super::beside::Beside;
use super::hurdles::NO_ODDS;
use crate::ablation::Step;
use crate::contest::{Contender, is_pump, solved};
use crate::empirical::{Correction, at_will, correction, plausible};
use crate::refine::refine;
use crate::relations::{Applied, joined};
use crate::scan::weigh;
use crate::tangent::{Bend, Tangent};
use dgd_effects::{About, Place, Quantity};
use tracing::debug;

/// Error of a form up to which it is exact: a gain, an area, a loss on the velocity head, a lag in what is pumped.
pub(super) const EXACT: f64 = 0.1;

/// Share of its evidence by which a form that is not exact may bend, whatever its error: that sets how far it can. Set by hand, above
/// what single causes in simulated recordings bend by; what only resembles them often bends by more (both are traced).
pub(super) const ROUGH: f64 = 0.25;

/// Share of what a form gains by bending that a second effect must explain beside it to be what bends it.
pub(super) const MOSTLY: f64 = 0.7;

/// Odds, in e-folds, that a temporary effect is a permanent one, from which on it counts as permanent: its end must be plain to see.
const NO_END: f64 = -1.0;

/// How far the form of an effect is bent.
pub(super) struct Bent {
    /// Logarithm of the odds that it does not hold.
    pub odds: f64,
    /// The state with the effect sharpened, and what its form gains there; `None` where its form was asked as it stands.
    pub sharpened: Option<(Vec<Applied>, f64)>,
}

impl Bent {
    /// Logarithm of the odds that the effect only lends its name to something of another form, unless it is a second effect that
    /// bends it: an exact form that two effects bend is seldom the one of the two.
    pub(super) fn unless_told(&self, beside: &Beside) -> f64 {
        // What the timing allowed for beside it lacks is no second cause.
        let timeless = |about: &About| about.search.timing.is_none();
        match &self.sharpened {
            Some((_, gain)) if self.odds > 0.0 => match beside.second(timeless) {
                Some(second) if second.evidence > MOSTLY * gain => f64::NEG_INFINITY,
                _ => self.odds,
            },
            _ => self.odds,
        }
    }
}

/// Whether the form of an effect holds to the letter.
pub(super) fn is_exact(about: &About) -> bool {
    about.search.form_error <= EXACT
}

/// Whether it lowers the head of the pump for a while.
fn passes_at_pump(c: &Contender) -> bool {
    c.effect.about().duration().is_some() && is_pump(c.effect)
}

impl Round<'_> {
    /// The best effect beside those named, with its parameters sharpened: a strength that was solved for on a straight line and
    /// a shape from a grid would leave over what passes for something else.
    pub(super) fn sharpened(&self, best: &Contender) -> Vec<Applied> {
        let mut state = joined(&self.state, &solved(&best.best));
        let last = state.len() - 1;
        refine(self.record, &mut state, last, &[], 1);
        state
    }

    /// How far the form of an effect is bent, whatever bends it.
    pub(super) fn bent(&self, c: &Contender) -> Bent {
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

    /// Logarithm of the odds that the form of an effect does not hold, from what it gains by bending: by how much that exceeds what the error
    /// of the form accounts for, and those of the effects named before it. A strength that differs in each stand has no form to break.
    pub(super) fn form_broken(&self, c: &Contender, gain: f64) -> f64 {
        /// E-folds that any form may gain. Set by hand.
        const FREE: f64 = 3.0;
        /// E-folds beyond what it may gain that raise the odds by a factor e: these, and a share of the evidence. Set by hand.
        const TEMPERATURE: f64 = 4.0;
        const TEMPERATURE_SHARE: f64 = 0.02;
        /// More odds than any probability tells, e-folds.
        const MOST: f64 = 50.0;
        let search = &c.effect.about().search;
        if search.stand_error.is_some() {
            return f64::NEG_INFINITY;
        }
        let error = if is_exact(c.effect.about()) {
            search.form_error
        } else {
            ROUGH
        };
        let gain = gain - self.left_over(&c.best.signature, false);
        let odds =
            (gain - FREE - error * c.evidence) / (TEMPERATURE + TEMPERATURE_SHARE * c.evidence);
        // Not `min`: a NaN stays one.
        if odds > MOST { MOST } else { odds }
    }

    /// The head as a curve of the pump's speed, with the logarithm of the odds of that, where it explains more than what passes at the
    /// pump, and than any other correction: the pump came to a speed at which its head is another, and left it again. No correction is made
    /// along the speed otherwise, as that is the pump's curve itself; whether it is more than that its evidence tells.
    pub(super) fn of_speed(&self, c: &Contender) -> Option<(Correction, f64)> {
        if !passes_at_pump(c) || !self.record.takes(Step::Corrections) {
            return None;
        }
        let loose = Tangent::beside(self.record, &self.state, &[], Bend::Loose)?;
        let along = (Place::Head, Quantity::PumpSpeed);
        let curve = correction(self.record, &loose, &self.state, &[], along)?;
        // Whatever brings it the evidence, it is not what passes that does.
        let tells = curve.claim() + curve.owed;
        let odds = (tells - c.claim()) / c.temperature();
        debug!(
            "{} along speed: odds {odds:.1}, {:.1} of it owed",
            c.id(),
            curve.owed
        );
        // A rival that is drawn on stiff curves claims more there than beside this one.
        let claim = |r: &Correction| {
            let here = at_will(self.record, &loose, &self.state, r);
            here.map_or(r.claim(), |here| here.claim().min(r.claim()))
        };
        let most = self.rivals.iter().all(|r| claim(r) < tells);
        (odds > 0.0 && most && plausible(&curve)).then_some((curve, odds))
    }

    /// What lowers the head for a while as something that stays once it has set in, with the logarithm of the odds of that, unless an end is
    /// seen. Gas passes and wear grows: the catalogue holds no loss that stays. An influx that goes on is one all the same.
    pub(super) fn lasting(&self, c: &Contender) -> Option<(Contender, f64)> {
        /// Ends that are tried up to that of the recording, and one.
        const LATER: usize = 10;
        /// How long what stays lasts, over the recording. Set by hand.
        const STAYS: f64 = 4.0;
        /// Share of the temperature: of the same effect twice the calibration takes half of the odds.
        const TWICE: f64 = 0.5;
        let about = c.effect.about();
        let (Some(onset), Some(duration)) = (about.onset(), about.duration()) else {
            return None;
        };
        if !passes_at_pump(c) || !self.record.takes(Step::Form) {
            return None;
        }
        let one = solved(&c.best);
        let (from, to) = about.interval_s(&one.parameters, self.record.setting.span_s);
        let lasting = |lasts: f64| {
            let mut one = one.clone();
            (one.parameters[onset], one.parameters[duration]) = (from, lasts);
            weigh(self.record, &self.gate, &self.state, one)
        };
        let best = lasting(STAYS * self.record.lasts_s());
        // It may pass later than the search looks for.
        let rest = self.record.setting.span_s.1 - from;
        let later = (1..LATER).map(|k| rest * k as f64 / LATER as f64);
        let passing = later
            .chain([to - from])
            .map(|lasts| lasting(lasts).evidence);
        let more = best.evidence - passing.fold(f64::NEG_INFINITY, f64::max);
        let odds = more / (TWICE * c.temperature());
        debug!("{} stays: odds {odds:.1}", about.id);
        let lasting = Contender {
            best,
            evidence: c.evidence + more,
            formed: c.formed + more,
            ..c.clone()
        };
        (odds > NO_END).then_some((lasting, odds))
    }
}
