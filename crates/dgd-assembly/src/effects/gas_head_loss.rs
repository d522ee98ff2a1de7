//! Gas in the pump takes part of its head.

use crate::Dual;
use crate::effect::{About, Effect, Now, ParameterAbout, Size};
use crate::spec::Kind;

pub(crate) struct This;

static ABOUT: About = About {
    id: "gas_head_loss",
    title: "gas in the pump takes part of its head",
    kinds: &[Kind::CentrifugalPump],
    equation: "H = (1 − share) H(w, q)",
    source: "Gülich, J. F., Centrifugal Pumps (2010), on two-phase flow",
    excited_by: "any flow at speed, if the curve is not fitted already",
    confusable: &[
        (
            "affinity_exponent",
            "gas takes the same share at any speed: several speeds separate",
        ),
        (
            "pump_wear",
            "wear shifts the curve along the flow: several flows separate",
        ),
    ],
    parameters: &[ParameterAbout {
        name: "share",
        meaning: "share of the head that is lost",
        size: Size::One,
        low: -0.3,
        high: 0.8,
        neutral: 0.0,
        usual: 0.05,
    }],
};

impl Effect for This {
    fn about(&self) -> &'static About {
        &ABOUT
    }

    fn drop(&self, now: &Now<'_>, _: Dual, drop: Dual) -> Dual {
        (1.0 - now.p[0]) * drop
    }
}
