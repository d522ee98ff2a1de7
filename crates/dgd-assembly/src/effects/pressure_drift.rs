//! The pressure at the boundary drifts: weather, a separator filling.

use crate::effect::{About, Effect, Now, ParameterAbout, Place, Size};
use crate::spec::Kind;

pub(crate) struct This;

static ABOUT: About = About {
    id: "pressure_drift",
    title: "the pressure at the boundary drifts: weather, a separator filling",
    kinds: &[Kind::Boundary],
    equation: "p = p_b + change t/1000 T",
    source: "WMO-No. 8, Guide to Instruments and Methods of Observation (2021), on atmospheric pressure",
    excited_by: "the same flow early and late",
    confusable: &[("reading_drift", "other gauges separate")],
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

    fn fits(&self, place: &Place) -> bool {
        !place.gives_flow
    }

    fn input(&self, now: &Now<'_>, value: f64) -> f64 {
        value + now.p[0] * now.t_s / (1000.0 * now.scale.time_s)
    }
}
