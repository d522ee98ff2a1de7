//! Below some input the pump stands.

use crate::effect::{About, Effect, Now, ParameterAbout, Size};
use crate::spec::Kind;

pub(crate) struct This;

static ABOUT: About = About {
    id: "pump_dead_band",
    title: "below some input the pump does not turn",
    kinds: &[Kind::DisplacementPump],
    equation: "q = c sign(u) max(|u| − band, 0)",
    source: "Slotine, J.-J. E. and Li, W., Applied Nonlinear Control (1991), on dead zones",
    excited_by: "low inputs",
    confusable: &[(
        "pump_offset",
        "an offset acts at any input, also through zero",
    )],
    parameters: &[ParameterAbout {
        name: "band",
        meaning: "flow that the band would have given",
        size: Size::Flow,
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

    fn input(&self, now: &Now<'_>, value: f64) -> f64 {
        let band = super::per_coefficient(now, now.p[0]);
        value.signum() * (value.abs() - band).max(0.0)
    }
}
