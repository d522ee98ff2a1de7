//! A viscous fluid costs head with the flow.

use crate::Dual;
use crate::effect::{About, Effect, Now, ParameterAbout, Size};
use crate::spec::Kind;

pub(crate) struct This;

static ABOUT: About = About {
    id: "viscosity_derating",
    title: "a viscous fluid reduces the head in proportion to flow",
    kinds: &[Kind::CentrifugalPump],
    equation: "H = H(w, q) − p_v q/(Q ρ g)",
    source: "ANSI/HI 9.6.7 (2015); Gülich, J. F., Centrifugal Pumps (2010), on viscous fluids; a loss in proportion to the flow is a simplification",
    excited_by: "low and high flow",
    confusable: &[(
        "internal_leakage",
        "leakage shifts the curve along the flow, viscosity turns it",
    )],
    parameters: &[ParameterAbout {
        name: "drop",
        meaning: "pressure lost at the usual flow",
        size: Size::Pressure,
        low: 0.0,
        high: 1.0,
        neutral: 0.0,
        usual: 0.05,
    }],
};

impl Effect for This {
    fn about(&self) -> &'static About {
        &ABOUT
    }

    fn drop(&self, now: &Now<'_>, q: Dual, drop: Dual) -> Dual {
        drop + now.p[0] / now.scale.flow_m3_s * q
    }
}
