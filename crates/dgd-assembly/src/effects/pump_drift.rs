//! The pump gives more or less as it warms or its supply sags.

use crate::effect::{About, Effect, Now, ParameterAbout, Size};
use crate::spec::Kind;

pub(crate) struct This;

static ABOUT: About = About {
    id: "pump_drift",
    title: "the pump gives more or less as it warms or its supply sags",
    kinds: &[Kind::DisplacementPump],
    equation: "q = c u (1 + change t/1000 T)",
    source: "Ivantysyn, J. and Ivantysynova, M., Hydrostatic Pumps and Motors (2003), on viscosity and slip",
    excited_by: "the same input early and late",
    confusable: &[
        ("clogging", "clogging changes how fast a tank drains"),
        ("reading_drift", "a drift goes on without flow"),
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

    fn input(&self, now: &Now<'_>, value: f64) -> f64 {
        value * (1.0 + now.p[0] * now.t_s / (1000.0 * now.scale.time_s)).max(0.0)
    }
}
