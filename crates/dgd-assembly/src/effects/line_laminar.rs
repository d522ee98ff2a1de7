//! A laminar part of the friction.

use crate::Dual;
use crate::effect::{About, Effect, Now, ParameterAbout, Size};
use crate::spec::Kind;

pub(crate) struct This;

static ABOUT: About = About {
    id: "line_laminar",
    title: "a laminar part of the friction",
    kinds: &[Kind::Line],
    equation: "dp = F(q) + p_l q/Q",
    source: "White, F. M., Fluid Mechanics (2011), on laminar pipe flow",
    excited_by: "low and high flow",
    confusable: &[
        (
            "line_fittings",
            "fittings go with the square of the flow: low and high flow separate",
        ),
        (
            "line_exponent",
            "two ways to bend the same curve: low flow by decades separates",
        ),
    ],
    parameters: &[ParameterAbout {
        name: "drop",
        meaning: "its drop at the usual flow",
        size: Size::Pressure,
        low: 0.0,
        high: 1.0,
        neutral: 0.0,
        usual: 0.1,
    }],
};

impl Effect for This {
    fn about(&self) -> &'static About {
        &ABOUT
    }

    fn drop(&self, now: &Now<'_>, q: Dual, drop: Dual) -> Dual {
        drop + now.p[0] / now.scale.flow_m3_s * q
    }
}
