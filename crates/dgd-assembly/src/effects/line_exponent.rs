//! Friction follows the flow with another exponent: transition, smooth walls, shear thinning.

use crate::Dual;
use crate::effect::{About, Effect, Now, ParameterAbout, Size};
use crate::spec::Kind;

pub(crate) struct This;

static ABOUT: About = About {
    id: "line_exponent",
    title: "friction follows the flow with a different exponent: transition, smooth walls, shear thinning",
    kinds: &[Kind::Line],
    equation: "F = F_0(q) |q/Q|^e",
    source: "Dodge, D. W. and Metzner, A. B., AIChE J. 5 (1959); Blasius, Forschg. Ing.-Wes. 131 (1913)",
    excited_by: "flow over a wide range",
    confusable: &[
        (
            "line_laminar",
            "two ways to bend the same curve: low flow by decades separates",
        ),
        (
            "line_fittings",
            "two ways to bend the same curve: high flow by decades separates",
        ),
    ],
    parameters: &[ParameterAbout {
        name: "exponent",
        meaning: "excess over the law's exponent",
        size: Size::One,
        low: -0.6,
        high: 0.6,
        neutral: 0.0,
        usual: -0.1,
    }],
};

impl Effect for This {
    fn about(&self) -> &'static About {
        &ABOUT
    }

    fn drop(&self, now: &Now<'_>, q: Dual, drop: Dual) -> Dual {
        let still = super::still(now);
        still + super::bent(now.p[0], now.scale.flow_m3_s, q, drop - still)
    }
}
