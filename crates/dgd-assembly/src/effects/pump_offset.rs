//! A constant flow beside what the input asks for.

use crate::effect::{About, Effect, Now, ParameterAbout, Size};
use crate::spec::Kind;

pub(crate) struct This;

static ABOUT: About = About {
    id: "pump_offset",
    title: "a constant flow in addition to that set by the input",
    kinds: &[Kind::DisplacementPump],
    equation: "q = c u + offset",
    source: "Ivantysyn, J. and Ivantysynova, M., Hydrostatic Pumps and Motors (2003), on losses; zero error of the set-point",
    excited_by: "low and high inputs",
    confusable: &[
        (
            "pump_dead_band",
            "an offset acts at any input, a dead band only by size: inputs through zero separate",
        ),
        (
            "pump_slip",
            "slip goes with the pressure: one input against several pressures separates",
        ),
        (
            "evaporation",
            "a constant loss of the first tank is the same",
        ),
    ],
    parameters: &[ParameterAbout {
        name: "offset",
        meaning: "flow that is added",
        size: Size::Flow,
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

    fn input(&self, now: &Now<'_>, value: f64) -> f64 {
        value + super::per_coefficient(now, now.p[0])
    }
}
