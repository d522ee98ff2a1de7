//! Head does not follow the speed as the curve says.

use crate::effect::{About, Effect, Now, ParameterAbout, Size};
use crate::spec::Kind;

pub(crate) struct This;

static ABOUT: About = About {
    id: "affinity_exponent",
    title: "head does not follow the speed as the curve predicts",
    kinds: &[Kind::CentrifugalPump],
    equation: "w_felt = w (w/50 %)^e",
    source: "Gülich, J. F., Centrifugal Pumps (2010), on similarity laws and their limits; the power is empirical",
    excited_by: "several speeds at like flow over speed",
    confusable: &[
        ("speed_offset", "low speed separates"),
        ("viscosity_derating", "that goes with the flow"),
    ],
    parameters: &[ParameterAbout {
        name: "exponent",
        meaning: "excess exponent of the speed",
        size: Size::One,
        low: -0.4,
        high: 0.4,
        neutral: 0.0,
        usual: 0.05,
    }],
};

impl Effect for This {
    fn about(&self) -> &'static About {
        &ABOUT
    }

    fn input(&self, now: &Now<'_>, value: f64) -> f64 {
        if value > 0.0 {
            value * (value / 50.0).powf(now.p[0])
        } else {
            value
        }
    }
}
