//! The flow at the boundary drifts off its meter.

use crate::effect::{About, Effect, Now, ParameterAbout, Place, Size};
use crate::spec::Kind;

pub(crate) struct This;

static ABOUT: About = About {
    id: "inflow_drift",
    title: "the flow at the boundary drifts away from its meter",
    kinds: &[Kind::Boundary],
    equation: "q = q_b (1 + change t/1000 T)",
    source: "Lipták, B. G. (ed.), Instrument Engineers' Handbook, vol. 1 (2003), on flow meters",
    excited_by: "the same reading early and late",
    confusable: &[
        (
            "inflow_gain",
            "the same flow early and late: a gain stays as it is",
        ),
        ("pump_drift", "the same at a pump"),
    ],
    parameters: &[ParameterAbout {
        name: "change",
        meaning: "relative change in a thousand usual times",
        size: Size::One,
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

    fn fits(&self, place: &Place) -> bool {
        place.gives_flow
    }

    fn input(&self, now: &Now<'_>, value: f64) -> f64 {
        value * (1.0 + now.p[0] * now.t_s / (1000.0 * now.scale.time_s))
    }
}
