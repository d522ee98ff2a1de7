//! The fluid has a yield stress.

use crate::Dual;
use crate::effect::{About, Effect, Now, ParameterAbout, Size};
use crate::spec::Kind;

pub(crate) struct This;

static ABOUT: About = About {
    id: "line_yield",
    title: "the fluid has a yield stress",
    kinds: &[Kind::Line],
    equation: "dp = F(q) + p_y q/(|q| + 0.02 Q)",
    source: "Buckingham, E., Proc. ASTM 21 (1921); API RP 13D (2010)",
    excited_by: "low flow and stops",
    confusable: &[
        (
            "static_head_error",
            "a yield stress changes sides with the flow and vanishes at rest",
        ),
        ("line_laminar", "a yield stress does not grow"),
    ],
    parameters: &[ParameterAbout {
        name: "drop",
        meaning: "drop at flow",
        size: Size::Pressure,
        low: 0.0,
        high: 0.5,
        neutral: 0.0,
        usual: 0.05,
    }],
};

impl Effect for This {
    fn about(&self) -> &'static About {
        &ABOUT
    }

    fn drop(&self, now: &Now<'_>, q: Dual, drop: Dual) -> Dual {
        drop + now.p[0] * (q / (q.abs() + 0.02 * now.scale.flow_m3_s))
    }
}
