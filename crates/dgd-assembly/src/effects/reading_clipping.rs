//! The instrument reads no more than its range.

use crate::effect::{About, Effect, Now, ParameterAbout, Size};
use crate::spec::Kind;

pub(crate) struct This;

static ABOUT: About = About {
    id: "reading_clipping",
    title: "the reading is clipped at the end of the range",
    kinds: &[Kind::Instrument],
    equation: "y = min(y_true, limit)",
    source: "Lipták, B. G. (ed.), Instrument Engineers' Handbook, vol. 1 (2003), on range and span",
    excited_by: "readings near the limit",
    confusable: &[(
        "unseen_brim",
        "a clipped reading leaves the flow out of the tank as it is",
    )],
    parameters: &[ParameterAbout {
        name: "limit",
        meaning: "greatest reading",
        size: Size::Reading,
        low: 0.2,
        high: 1.5,
        neutral: f64::INFINITY,
        usual: 0.9,
    }],
};

impl Effect for This {
    fn about(&self) -> &'static About {
        &ABOUT
    }

    fn reading(&self, now: &Now<'_>, _: &[f64], values: &mut [f64]) {
        for value in values {
            *value = value.min(now.p[0]);
        }
    }
}
