//! What effects share by which a component is not where its channel says: late, or with play.

use crate::effect::{About, Drive, Effect, Now, Place};

/// What a state that goes after what drives it makes of the two.
type Response = fn(&Now<'_>, f64, f64) -> f64;

/// A component with a state that goes after what drives it; the effect says the rest.
pub(super) struct Follower {
    pub(super) about: &'static About,
    /// Rate of the state, by the state and what drives it.
    pub(super) rate: Response,
    /// What the component then works with, by the same.
    pub(super) input: Response,
}

impl Follower {
    /// A first-order lag, whose time constant is the first parameter.
    pub(super) const fn lag(about: &'static About) -> Self {
        Self {
            about,
            rate: |now, state, set| super::lag(now.p[0], state, set, now.scale.time_s),
            input: |now, state, set| super::lagged(now.p[0], state, set, now.scale.time_s),
        }
    }
}

impl Effect for Follower {
    fn about(&self) -> &'static About {
        self.about
    }

    fn fits(&self, place: &Place) -> bool {
        place.driven && place.in_time
    }

    fn states(&self) -> usize {
        1
    }

    fn start(&self, _: &Now<'_>, drive: &Drive, x: &mut [f64]) {
        x[0] = drive.input;
    }

    fn rates(&self, now: &Now<'_>, drive: &Drive, rate: &mut [f64]) {
        rate[0] = (self.rate)(now, now.x[0], drive.input);
    }

    fn input(&self, now: &Now<'_>, value: f64) -> f64 {
        let state = now.x.first().copied().unwrap_or(value);
        (self.input)(now, state, value)
    }
}
