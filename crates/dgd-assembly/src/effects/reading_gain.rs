//! The instrument reads by a factor too much or too little.

use crate::effect::{About, Effect, Now, ParameterAbout, Size};
use crate::spec::Kind;

pub(crate) struct This;

static ABOUT: About = About {
    id: "reading_gain",
    title: "the reading has a proportional error",
    kinds: &[Kind::Instrument],
    equation: "y = (1 + excess) y_true",
    source: "IEC 61298-2 (2008), measured error; Lipták, B. G. (ed.), Instrument Engineers' Handbook, vol. 1 (2003), on errors of instruments",
    excited_by: "a reading that varies",
    confusable: &[
        (
            "reading_offset",
            "low and high readings separate: an offset is the same at both",
        ),
        ("eccentricity", "a drop alone cannot tell them apart"),
    ],
    parameters: &[ParameterAbout {
        name: "excess",
        meaning: "gain less 1",
        size: Size::One,
        low: -0.4,
        high: 0.4,
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
            *value *= 1.0 + now.p[0];
        }
    }
}
