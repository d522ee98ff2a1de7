//! The tank spills at a height that was not stated; part of it may be caught below.

use crate::effect::{About, Balance, Effect, Now, ParameterAbout, Size};
use crate::spec::Kind;

pub(crate) struct This;

static ABOUT: About = About {
    id: "unseen_brim",
    title: "the tank spills at a height that was not stated; part of the overflow may be caught below",
    kinds: &[Kind::Tank],
    equation: "h ≤ h_spill; q_below += share · q_overflow",
    source: "White, F. M., Fluid Mechanics (2011), on mass balance and weirs",
    excited_by: "inflow that fills the tank to that height",
    confusable: &[(
        "reading_clipping",
        "a clipped reading leaves the flow out of the tank as it is",
    )],
    parameters: &[
        ParameterAbout {
            name: "height",
            meaning: "height at which it spills",
            size: Size::Level,
            low: 0.2,
            high: 1.5,
            neutral: f64::INFINITY,
            usual: 0.9,
        },
        ParameterAbout {
            name: "share",
            meaning: "share that is caught below",
            size: Size::One,
            low: 0.0,
            high: 1.0,
            neutral: 0.0,
            usual: 0.3,
        },
    ],
};

impl Effect for This {
    fn about(&self) -> &'static About {
        &ABOUT
    }

    fn brim(&self, now: &Now<'_>, brim: f64) -> f64 {
        brim.min(now.p[0])
    }

    fn balance(&self, now: &Now<'_>, flows: &mut Balance) {
        flows.caught += now.p[1];
    }
}
