//! The instrument's zero is off.

use crate::effect::{About, Effect, Now, ParameterAbout, Size};
use crate::spec::Kind;

pub(crate) struct This;

static ABOUT: About = About {
    id: "reading_offset",
    title: "the instrument has a zero error",
    kinds: &[Kind::Instrument],
    equation: "y = y_true + offset",
    source: "IEC 61298-2 (2008), zero error; Lipták, B. G. (ed.), Instrument Engineers' Handbook, vol. 1 (2003), on errors of instruments",
    excited_by: "a reading at rest or at a known value",
    confusable: &[
        (
            "outlet_offset",
            "an outlet's offset acts on the flow, a reading's does not: run the tank dry",
        ),
        (
            "static_head_error",
            "the same at one gauge; two gauges or another meter separate",
        ),
    ],
    parameters: &[ParameterAbout {
        name: "offset",
        meaning: "offset",
        size: Size::Reading,
        low: -0.3,
        high: 0.3,
        neutral: 0.0,
        usual: 0.03,
    }],
};

impl Effect for This {
    fn about(&self) -> &'static About {
        &ABOUT
    }

    fn reading(&self, now: &Now<'_>, _: &[f64], values: &mut [f64]) {
        for value in values {
            *value += now.p[0];
        }
    }
}
