//! Restrictions repeated along the line.

use crate::Dual;
use crate::effect::{About, Effect, Now, ParameterAbout, Size};
use crate::kinds::line;
use crate::spec::Kind;

pub(crate) struct This;

static ABOUT: About = About {
    id: "tool_joints",
    title: "restrictions repeated along the line",
    kinds: &[Kind::Line],
    equation: "dp = F(q) + p_j (l/1000 m) q|q|/Q²",
    source: "Jeong, Y.-T. and Shah, S. N., IADC/SPE 87182 (2004); the square of the flow is a simplification",
    excited_by: "length that varies, or low and high flow",
    confusable: &[
        ("line_fittings", "those do not grow with length"),
        (
            "eccentricity",
            "joints grow with length and with the square of flow, an eccentric pipe scales all friction",
        ),
    ],
    parameters: &[ParameterAbout {
        name: "drop",
        meaning: "drop of a thousand metres at the usual flow",
        size: Size::Pressure,
        low: 0.0,
        high: 1.0,
        neutral: 0.0,
        usual: 0.05,
    }],
};

impl Effect for This {
    fn about(&self) -> &'static About {
        &ABOUT
    }

    fn drop(&self, now: &Now<'_>, q: Dual, drop: Dual) -> Dual {
        let share = q * (1.0 / now.scale.flow_m3_s);
        drop + now.p[0] * now.own[line::LENGTH] / 1000.0 * share * share.abs()
    }
}
