//! The cross-section changes with height.

use crate::effect::{About, Effect, Now, ParameterAbout, Size};
use crate::spec::Kind;

pub(crate) struct This;

static ABOUT: About = About {
    id: "taper",
    title: "the cross-section changes with height",
    kinds: &[Kind::Tank],
    equation: "A(h) = A (1 + slope (h/H − 1/2))",
    source: "White, F. M., Fluid Mechanics (2011), on mass balance; a cone to first order",
    excited_by: "slow and fast changes of level high and low in the tank",
    confusable: &[(
        "reading_curvature",
        "compare static levels: taper leaves them alone",
    )],
    parameters: &[ParameterAbout {
        name: "slope",
        meaning: "relative change of area over the usual level",
        size: Size::One,
        low: -1.5,
        high: 1.5,
        neutral: 0.0,
        usual: 0.2,
    }],
};

impl Effect for This {
    fn about(&self) -> &'static About {
        &ABOUT
    }

    fn area(&self, now: &Now<'_>, level: f64, area: f64) -> f64 {
        let height = level / now.scale.level_m - 0.5;
        area * (1.0 + now.p[0] * height).max(0.1)
    }
}
