//! The column is heavier or higher than stated.

use crate::Dual;
use crate::effect::{About, Effect, Now, ParameterAbout, Size};
use crate::spec::Kind;

pub(crate) struct This;

static ABOUT: About = About {
    id: "static_head_error",
    title: "the column is heavier or higher than stated",
    kinds: &[Kind::Line],
    equation: "dp = F(q) + ρ g z + p_e",
    source: "Slettebø, D., NTNU (2015), Eq. 2.19c; Bourgoyne, A. T. et al., Applied Drilling Engineering, SPE (1986), on hydrostatics",
    excited_by: "flow and rest",
    confusable: &[
        (
            "reading_offset",
            "the same at one gauge; two gauges or another meter separate",
        ),
        (
            "pressure_offset",
            "the same at the line's end; a gauge there separates",
        ),
    ],
    parameters: &[ParameterAbout {
        name: "head",
        meaning: "pressure that is added",
        size: Size::Pressure,
        low: -0.5,
        high: 0.5,
        neutral: 0.0,
        usual: 0.05,
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
