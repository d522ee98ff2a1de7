//! The cross-section is not the one that was stated.

use crate::effect::{About, Effect, Now, ParameterAbout, Size};
use crate::spec::Kind;

pub(crate) struct This;

static ABOUT: About = About {
    id: "tank_area",
    title: "the cross-section is not as stated",
    kinds: &[Kind::Tank],
    equation: "A(h) = (1 + excess) A",
    source: "White, F. M., Fluid Mechanics (2011), on mass balance",
    excited_by: "changes of level with flows that are known",
    confusable: &[
        (
            "reading_gain",
            "compare static levels: the area leaves them alone",
        ),
        (
            "inflow_gain",
            "compare flows in and out at rest: the area leaves them alone",
        ),
    ],
    parameters: &[ParameterAbout {
        name: "excess",
        meaning: "true over stated area, less 1",
        size: Size::One,
        low: -0.8,
        high: 4.0,
        neutral: 0.0,
        usual: 0.2,
    }],
};

impl Effect for This {
    fn about(&self) -> &'static About {
        &ABOUT
    }

    fn area(&self, now: &Now<'_>, _level: f64, area: f64) -> f64 {
        area * (1.0 + now.p[0])
    }
}
