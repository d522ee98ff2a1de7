//! What effects share by which a component follows its channel late.

use crate::effect::{About, Drive, Effect, Now, Place};

/// A first-order lag of what drives it; the effect says the rest.
pub(super) struct InputLag(pub(super) &'static About);

impl Effect for InputLag {
    fn about(&self) -> &'static About {
        self.0
    }

    fn fits(&self, place: &Place<'_>) -> bool {
        place.driven && place.in_time
    }

    fn states(&self) -> usize {
        1
    }

    fn start(&self, _: &Now<'_>, drive: &Drive, x: &mut [f64]) {
        x[0] = drive.input;
    }

    fn rates(&self, now: &Now<'_>, drive: &Drive, rate: &mut [f64]) {
        rate[0] = super::lag(now.p[0], now.x[0], drive.input, now.scale.time_s);
    }

    fn input(&self, now: &Now<'_>, value: f64) -> f64 {
        let state = now.x.first().copied().unwrap_or(value);
        super::lagged(now.p[0], state, value, now.scale.time_s)
    }
}
