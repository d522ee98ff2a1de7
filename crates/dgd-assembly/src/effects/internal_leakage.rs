//! Part of the flow runs back inside the pump.

use crate::Dual;
use crate::effect::{About, Effect, Now, ParameterAbout, Size};
use crate::kinds::centrifugal;
use crate::spec::Kind;

pub(crate) struct This;

static ABOUT: About = About {
    id: "internal_leakage",
    title: "part of the flow runs back inside the pump",
    kinds: &[Kind::CentrifugalPump],
    equation: "H = H(w, q + leak · w/50 %)",
    source: "Gülich, J. F., Centrifugal Pumps (2010), on leakage losses",
    excited_by: "low and high flow at one speed",
    confusable: &[(
        "viscosity_derating",
        "leakage shifts the curve along the flow, viscosity turns it",
    )],
    parameters: &[ParameterAbout {
        name: "leak",
        meaning: "flow that runs back at half speed",
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

    fn through(&self, now: &Now<'_>, q: Dual) -> Dual {
        q + now.p[0] * now.own[centrifugal::SPEED] / 50.0
    }
}
