//! The tank leaks.

use crate::effect::{About, Balance, Effect, Now, ParameterAbout, Size};
use crate::spec::Kind;

pub(crate) struct This;

static ABOUT: About = About {
    id: "tank_leak",
    title: "the tank leaks",
    kinds: &[Kind::Tank],
    equation: "q_leak = leak sqrt(h/H)",
    source: "White, F. M., Fluid Mechanics (2011), on Torricelli's law",
    excited_by: "levels that change while the outflow is measured or goes into a measured tank",
    confusable: &[
        (
            "splash",
            "a leak goes with the level, splashing with the inflow",
        ),
        ("evaporation", "evaporation does not depend on the level"),
    ],
    parameters: &[ParameterAbout {
        name: "leak",
        meaning: "leak at the usual level",
        size: Size::Flow,
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
        flows.lost_m3_s += now.p[0] * (flows.level_m.max(0.0) / now.scale.level_m).sqrt();
    }
}
