//! A tail pipe pulls, or the outlet is drowned.

use crate::Dual;
use crate::effect::{About, Effect, Now, ParameterAbout, Size};
use crate::spec::Kind;

pub(crate) struct This;

static ABOUT: About = About {
    id: "tail_head",
    title: "a tail pipe adds suction, or the outlet is submerged",
    kinds: &[Kind::Valve, Kind::Orifice],
    equation: "dp = K q|q| + p_tail",
    source: "White, F. M., Fluid Mechanics (2011), on Bernoulli's equation and exit losses",
    excited_by: "low and high heads",
    confusable: &[(
        "outlet_offset",
        "the same head at the outlet: not separable",
    )],
    parameters: &[ParameterAbout {
        name: "head",
        meaning: "pressure against the flow; negative: suction",
        size: Size::Pressure,
        low: -0.5,
        high: 0.3,
        neutral: 0.0,
        usual: -0.05,
    }],
};

impl Effect for This {
    fn about(&self) -> &'static About {
        &ABOUT
    }

    fn drop(&self, now: &Now<'_>, _: Dual, drop: Dual) -> Dual {
        drop + now.p[0]
    }
}
