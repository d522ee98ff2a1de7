//! The true speed differs from the set-point by a constant.

use crate::effect::{About, Effect, Now, ParameterAbout, Size};
use crate::spec::Kind;

pub(crate) struct This;

static ABOUT: About = About {
    id: "speed_offset",
    title: "the true speed differs from the set-point by a constant",
    kinds: &[Kind::CentrifugalPump],
    equation: "w_felt = w + offset",
    source: "IEC 60034-1 (2022), speed tolerance; motor slip: Chapman, S. J., Electric Machinery Fundamentals (2012)",
    excited_by: "several speeds",
    confusable: &[("affinity_exponent", "low speed separates")],
    parameters: &[ParameterAbout {
        name: "offset",
        meaning: "offset in percent of speed",
        size: Size::One,
        low: -10.0,
        high: 10.0,
        neutral: 0.0,
        usual: 1.0,
    }],
};

impl Effect for This {
    fn about(&self) -> &'static About {
        &ABOUT
    }

    fn input(&self, now: &Now<'_>, value: f64) -> f64 {
        if value > 0.0 {
            (value + now.p[0]).max(0.0)
        } else {
            value
        }
    }
}
