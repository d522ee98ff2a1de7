//! The flow coefficient is not proportional to the opening.

use crate::effect::{About, Effect, Now, ParameterAbout, Place, Size};
use crate::spec::Kind;

pub(crate) struct This;

static ABOUT: About = About {
    id: "opening_characteristic",
    title: "the flow coefficient is not proportional to the opening",
    kinds: &[Kind::Valve, Kind::Orifice],
    equation: "C = C_full z^(1 + e)",
    source: "IEC 60534-2-4 (2009), inherent flow characteristics; the power is a stand-in for them",
    excited_by: "the same drop at several openings",
    confusable: &[("opening_leak", "a leak is felt at the shut valve only")],
    parameters: &[ParameterAbout {
        name: "exponent",
        meaning: "excess over the exponent 1",
        size: Size::One,
        low: -0.8,
        high: 3.0,
        neutral: 0.0,
        usual: 0.3,
    }],
};

impl Effect for This {
    fn about(&self) -> &'static About {
        &ABOUT
    }

    fn fits(&self, place: &Place) -> bool {
        place.driven
    }

    fn input(&self, now: &Now<'_>, value: f64) -> f64 {
        if value > 0.0 {
            value * value.powf(now.p[0])
        } else {
            value
        }
    }
}
