//! What effects share by which a branch stores on its way and delivers late.

use crate::effect::{About, Drive, Effect, Now, Place};

/// A first-order lag of what drives it; the effect says the rest.
pub(super) struct OutletLag(pub(super) &'static About);

impl Effect for OutletLag {
    fn about(&self) -> &'static About {
        self.0
    }

    fn fits(&self, place: &Place) -> bool {
        place.in_time && place.outlet_stores
    }

    fn states(&self) -> usize {
        1
    }

    fn start(&self, _: &Now<'_>, drive: &Drive, x: &mut [f64]) {
        x[0] = drive.flow_m3_s;
    }

    fn rates(&self, now: &Now<'_>, drive: &Drive, rate: &mut [f64]) {
        rate[0] = super::lag(now.p[0], now.x[0], drive.flow_m3_s, now.scale.time_s);
    }

    fn outlet(&self, now: &Now<'_>, q: f64, _: f64) -> f64 {
        let state = now.x.first().copied().unwrap_or(q);
        super::lagged(now.p[0], state, q, now.scale.time_s)
    }
}
