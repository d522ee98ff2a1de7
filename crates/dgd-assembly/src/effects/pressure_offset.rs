//! The pressure at the boundary is not what was stated.

use crate::effect::{About, Effect, Now, ParameterAbout, Place, Size};
use crate::spec::Kind;

pub(crate) struct This;

static ABOUT: About = About {
    id: "pressure_offset",
    title: "the pressure at the boundary is not what was stated",
    kinds: &[Kind::Boundary],
    equation: "p = p_b + offset",
    source: "White, F. M., Fluid Mechanics (2011), on hydrostatic pressure; Lipták, B. G. (ed.), Instrument Engineers' Handbook, vol. 1 (2003), on pressure references",
    excited_by: "flow over the boundary",
    confusable: &[
        ("static_head_error", "the same at the end of a line"),
        ("back_pressure", "a back-pressure grows with the flow"),
    ],
    parameters: &[ParameterAbout {
        name: "offset",
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

    fn fits(&self, place: &Place) -> bool {
        !place.gives_flow
    }

    fn input(&self, now: &Now<'_>, value: f64) -> f64 {
        value + now.p[0]
    }
}
