//! Part of what enters misses the tank and falls into the one below.

use crate::effect::{About, Balance, Effect, Now, ParameterAbout, Place, Size};
use crate::spec::Kind;

pub(crate) struct This;

static ABOUT: About = About {
    id: "bypass",
    title: "part of the inflow misses the tank and falls into the one below",
    kinds: &[Kind::Tank],
    equation: "q_below += share · q_in",
    source: "White, F. M., Fluid Mechanics (2011), on mass balance",
    excited_by: "changes of inflow, with a level below that is measured",
    confusable: &[("overflow_caught", "overflow acts only at the brim")],
    parameters: &[ParameterAbout {
        name: "share",
        meaning: "share that misses",
        size: Size::One,
        low: 0.0,
        high: 0.9,
        neutral: 0.0,
        usual: 0.1,
    }],
};

impl Effect for This {
    fn about(&self) -> &'static About {
        &ABOUT
    }

    fn fits(&self, place: &Place) -> bool {
        place.has_tank_below
    }

    fn balance(&self, now: &Now<'_>, flows: &mut Balance) {
        flows.passed_on_m3_s += now.p[0] * flows.inflow_m3_s;
    }
}
