//! Part of what enters splashes out.

use crate::effect::{About, Balance, Effect, Now, ParameterAbout, Size};
use crate::spec::Kind;

pub(crate) struct This;

static ABOUT: About = About {
    id: "splash",
    title: "part of the inflow splashes out",
    kinds: &[Kind::Tank],
    equation: "q_lost = share · q_in",
    source: "White, F. M., Fluid Mechanics (2011), on mass balance",
    excited_by: "inflow that is known or measured beside the level",
    confusable: &[
        ("pump_nonlinear_gain", "splashing spares a pump's meter"),
        ("tank_leak", "a leak goes on when the inflow stops"),
    ],
    parameters: &[ParameterAbout {
        name: "share",
        meaning: "share that is lost",
        size: Size::One,
        low: 0.0,
        high: 0.5,
        neutral: 0.0,
        usual: 0.05,
    }],
};

impl Effect for This {
    fn about(&self) -> &'static About {
        &ABOUT
    }

    fn balance(&self, now: &Now<'_>, flows: &mut Balance) {
        flows.lost_m3_s += now.p[0] * flows.inflow_m3_s;
    }
}
