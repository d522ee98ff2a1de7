//! The level stands above the brim while it spills.

use crate::effect::{About, Balance, Effect, Now, ParameterAbout, Place, Size};
use crate::spec::Kind;

pub(crate) struct This;

static ABOUT: About = About {
    id: "brim_head",
    title: "the level rises above the brim while it spills",
    kinds: &[Kind::Tank],
    equation: "q_overflow = q_0 ((h − h_brim)/rise)^(3/2)",
    source: "White, F. M., Fluid Mechanics (2011), on sharp-crested weirs",
    excited_by: "spilling at several rates",
    confusable: &[(
        "overflow_caught",
        "check the tank itself: its level exceeds the brim",
    )],
    parameters: &[ParameterAbout {
        name: "rise",
        meaning: "height above the brim at the usual flow",
        size: Size::Level,
        low: 0.0,
        high: 0.3,
        neutral: 0.0,
        usual: 0.03,
    }],
};

impl Effect for This {
    fn about(&self) -> &'static About {
        &ABOUT
    }

    fn fits(&self, place: &Place) -> bool {
        place.has_brim
    }

    fn brim(&self, now: &Now<'_>, brim: f64) -> f64 {
        brim + 10.0 * now.p[0]
    }

    fn balance(&self, now: &Now<'_>, flows: &mut Balance) {
        let rise = now.p[0];
        // The brim that the balance sees stands ten rises above the true one.
        let above = flows.level_m - (flows.brim_m - 10.0 * rise);
        if rise > 0.0 && above > 0.0 && above.is_finite() {
            flows.overflow_m3_s += now.scale.flow_m3_s * (above / rise).powf(1.5);
        }
    }
}
