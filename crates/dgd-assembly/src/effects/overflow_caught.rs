//! Part of what spills over the brim falls into the tank below.

use crate::effect::{About, Balance, Effect, Now, ParameterAbout, Place, Size};
use crate::spec::Kind;

pub(crate) struct This;

static ABOUT: About = About {
    id: "overflow_caught",
    title: "part of the overflow falls into the tank below",
    kinds: &[Kind::Tank],
    equation: "q_below += share · q_overflow",
    source: "White, F. M., Fluid Mechanics (2011), on the mass balance of a control volume",
    excited_by: "inflow that fills the tank to its brim, and a level below",
    confusable: &[(
        "pump_nonlinear_gain",
        "the level below rises only while the upper tank is full",
    )],
    parameters: &[ParameterAbout {
        name: "share",
        meaning: "share of the overflow that is caught",
        size: Size::One,
        low: 0.0,
        high: 1.0,
        neutral: 0.0,
        usual: 0.5,
    }],
};

impl Effect for This {
    fn about(&self) -> &'static About {
        &ABOUT
    }

    fn fits(&self, place: &Place) -> bool {
        place.has_brim && place.has_tank_below
    }

    fn balance(&self, now: &Now<'_>, flows: &mut Balance) {
        flows.caught += now.p[0];
    }
}
