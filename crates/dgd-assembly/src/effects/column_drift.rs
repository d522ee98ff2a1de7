//! The column grows heavier or lighter along the record: cuttings, gas, temperature.

use crate::Dual;
use crate::effect::{About, Effect, Now, ParameterAbout, Size};
use crate::spec::Kind;

pub(crate) struct This;

static ABOUT: About = About {
    id: "column_drift",
    title: "the column grows heavier or lighter along the record: cuttings, gas, temperature",
    kinds: &[Kind::Line],
    equation: "dp = F(q) + ρ g z + p_d t/1000 T",
    source: "Bourgoyne, A. T. et al., Applied Drilling Engineering, SPE (1986), on cuttings",
    excited_by: "rest or flow, early and late",
    confusable: &[
        ("friction_drift", "a drifting column also acts at rest"),
        (
            "reading_drift",
            "the same at one gauge; a second gauge on the line separates",
        ),
        (
            "tool_joints",
            "a column also acts at rest, joints only with flow",
        ),
    ],
    parameters: &[ParameterAbout {
        name: "change",
        meaning: "change in a thousand usual times",
        size: Size::Pressure,
        low: -2.0,
        high: 2.0,
        neutral: 0.0,
        usual: 0.05,
    }],
};

impl Effect for This {
    fn about(&self) -> &'static About {
        &ABOUT
    }

    fn drop(&self, now: &Now<'_>, _: Dual, drop: Dual) -> Dual {
        drop + now.p[0] * now.t_s / (1000.0 * now.scale.time_s)
    }
}
