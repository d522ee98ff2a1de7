//! The flow at the boundary is known by a factor only.

use crate::effect::{About, Effect, Now, ParameterAbout, Place, Size};
use crate::spec::Kind;

pub(crate) struct This;

static ABOUT: About = About {
    id: "inflow_gain",
    title: "the flow at the boundary is known only up to a factor",
    kinds: &[Kind::Boundary],
    equation: "q = (1 + excess) q_b",
    source: "Lipták, B. G. (ed.), Instrument Engineers' Handbook, vol. 1 (2003), on flow meters",
    excited_by: "flow that varies, with a balance beside it",
    confusable: &[
        ("reading_gain", "the mass balance separates"),
        ("splash", "another inflow separates"),
    ],
    parameters: &[ParameterAbout {
        name: "excess",
        meaning: "gain less 1",
        size: Size::One,
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
        place.gives_flow
    }

    fn input(&self, now: &Now<'_>, value: f64) -> f64 {
        (1.0 + now.p[0]) * value
    }
}
