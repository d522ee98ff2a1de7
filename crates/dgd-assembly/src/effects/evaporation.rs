//! The tank loses at a constant rate.

use crate::effect::{About, Balance, Effect, Now, ParameterAbout, Size};
use crate::spec::Kind;

pub(crate) struct This;

static ABOUT: About = About {
    id: "evaporation",
    title: "the tank loses at a constant rate",
    kinds: &[Kind::Tank],
    equation: "A dh/dt = … − rate",
    source: "Penman, H. L., Proc. R. Soc. A 193 (1948), on open water; that the rate is constant is a simplification",
    excited_by: "long stretches without flow",
    confusable: &[
        ("tank_leak", "a leak falls with the level"),
        ("reading_drift", "a drift goes on in an empty tank"),
    ],
    parameters: &[ParameterAbout {
        name: "rate",
        meaning: "rate of loss",
        size: Size::Flow,
        low: 0.0,
        high: 0.2,
        neutral: 0.0,
        usual: 0.01,
    }],
};

impl Effect for This {
    fn about(&self) -> &'static About {
        &ABOUT
    }

    fn balance(&self, now: &Now<'_>, flows: &mut Balance) {
        if flows.level_m > 0.0 {
            flows.lost_m3_s += now.p[0];
        }
    }
}
