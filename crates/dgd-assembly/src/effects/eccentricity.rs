//! The inner pipe lies on the wall, or the section differs: friction by a factor.

use crate::Dual;
use crate::effect::{About, Effect, Now, ParameterAbout, Size};
use crate::spec::Kind;

pub(crate) struct This;

static ABOUT: About = About {
    id: "eccentricity",
    title: "the inner pipe lies on the wall, or the section differs: friction changes by a factor",
    kinds: &[Kind::Line],
    equation: "F = F_0(q) (1 + change)",
    source: "Haciislamoglu, M. and Langlinais, J., J. Energy Resour. Technol. 112 (1990): less friction than a concentric annulus; one factor for all flows is a simplification",
    excited_by: "any flow, if friction is not fitted already",
    confusable: &[(
        "tool_joints",
        "those grow with length and with the square of flow",
    )],
    parameters: &[ParameterAbout {
        name: "change",
        meaning: "relative change of friction",
        size: Size::One,
        low: -0.6,
        high: 1.0,
        neutral: 0.0,
        usual: 0.1,
    }],
};

impl Effect for This {
    fn about(&self) -> &'static About {
        &ABOUT
    }

    fn drop(&self, now: &Now<'_>, _: Dual, drop: Dual) -> Dual {
        let still = super::still(now);
        still + (1.0 + now.p[0]) * (drop - still)
    }
}
