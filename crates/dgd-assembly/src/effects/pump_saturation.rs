//! The pump gives no more than some flow.

use crate::effect::{About, Effect, Now, ParameterAbout, Size};
use crate::spec::Kind;

pub(crate) struct This;

static ABOUT: About = About {
    id: "pump_saturation",
    title: "the pump flow saturates",
    kinds: &[Kind::DisplacementPump],
    equation: "q = min(c u, limit)",
    source: "Slotine, J.-J. E. and Li, W., Applied Nonlinear Control (1991), on saturation",
    excited_by: "high inputs",
    confusable: &[
        (
            "unseen_brim",
            "a full tank leaves the flow into it as it is",
        ),
        (
            "pump_nonlinear_gain",
            "saturation does not affect low inputs",
        ),
    ],
    parameters: &[ParameterAbout {
        name: "limit",
        meaning: "greatest flow",
        size: Size::Flow,
        low: 0.2,
        high: 3.0,
        neutral: f64::INFINITY,
        usual: 0.8,
    }],
};

impl Effect for This {
    fn about(&self) -> &'static About {
        &ABOUT
    }

    fn input(&self, now: &Now<'_>, value: f64) -> f64 {
        value.min(super::per_coefficient(now, now.p[0]))
    }
}
