//! The shut valve leaks.

use crate::effect::{About, Effect, Now, ParameterAbout, Place, Size};
use crate::spec::Kind;

pub(crate) struct This;

static ABOUT: About = About {
    id: "opening_leak",
    title: "the shut valve leaks",
    kinds: &[Kind::Valve, Kind::Orifice],
    equation: "z = z_set + leak",
    source: "IEC 60534-4 (2021), seat leakage classes",
    excited_by: "a drop over the shut valve",
    confusable: &[(
        "opening_characteristic",
        "a leak is felt at the shut valve only",
    )],
    parameters: &[ParameterAbout {
        name: "leak",
        meaning: "opening that remains",
        size: Size::One,
        low: 0.0,
        high: 0.2,
        neutral: 0.0,
        usual: 0.01,
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
        value + now.p[0]
    }
}
