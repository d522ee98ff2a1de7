//! A flow that was not counted enters, or one is lost: influx, losses, a valve left open.

use crate::effect::{About, Effect, Now, ParameterAbout, Place, Size};
use crate::spec::Kind;

pub(crate) struct This;

static ABOUT: About = About {
    id: "inflow_offset",
    title: "a flow that was not counted enters, or one is lost: influx, losses, a valve left open",
    kinds: &[Kind::Boundary],
    equation: "q = q_b + offset",
    source: "White, F. M., Fluid Mechanics (2011), on mass balance",
    excited_by: "levels that move",
    confusable: &[
        (
            "evaporation",
            "the same in the tank it feeds: not separable",
        ),
        ("inflow_gain", "flow that varies separates"),
    ],
    parameters: &[ParameterAbout {
        name: "offset",
        meaning: "flow that is added",
        size: Size::Flow,
        low: -0.5,
        high: 0.5,
        neutral: 0.0,
        usual: 0.05,
    }],
};

impl Effect for This {
    fn about(&self) -> &'static About {
        &ABOUT
    }

    fn fits(&self, place: &Place) -> bool {
        place.gives_flow
    }

    fn input(&self, now: &Now<'_>, value: f64) -> f64 {
        value + now.p[0]
    }
}
