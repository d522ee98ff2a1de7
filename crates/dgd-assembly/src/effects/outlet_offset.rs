//! The outlet does not lie where the level is zero.

use crate::effect::{About, Effect, Now, ParameterAbout, Size};
use crate::spec::Kind;

pub(crate) struct This;

static ABOUT: About = About {
    id: "outlet_offset",
    title: "the outlet does not lie where the level is zero",
    kinds: &[Kind::Tank],
    equation: "p_outlet = ρ g (h + offset)",
    source: "White, F. M., Fluid Mechanics (2011), on Torricelli's law: the outlet below the floor, or dead volume above it",
    excited_by: "low and high levels",
    confusable: &[
        (
            "reading_offset",
            "an outlet's offset acts on the flow, a reading's does not: run the tank dry",
        ),
        ("tail_head", "the same head at the outlet: not separable"),
    ],
    parameters: &[ParameterAbout {
        name: "offset",
        meaning: "height of the zero level above the outlet",
        size: Size::Level,
        low: -0.3,
        high: 0.5,
        neutral: 0.0,
        usual: 0.05,
    }],
};

impl Effect for This {
    fn about(&self) -> &'static About {
        &ABOUT
    }

    fn head(&self, now: &Now<'_>, level: f64) -> f64 {
        level + now.p[0]
    }
}
