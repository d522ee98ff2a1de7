//! The reading sticks within a band when it turns.

use crate::effect::{About, Effect, Now, ParameterAbout, Size};
use crate::spec::Kind;

pub(crate) struct This;

static ABOUT: About = About {
    id: "reading_backlash",
    title: "the reading sticks within a band when it turns",
    kinds: &[Kind::Instrument],
    equation: "y follows y_true at the edge of a band",
    source: "IEC 61298-2 (2008), hysteresis and dead band; Nordin, M. and Gutman, P.-O., Automatica 38 (2002)",
    excited_by: "a reading that turns often",
    confusable: &[("reading_lag", "slow turns separate")],
    parameters: &[ParameterAbout {
        name: "band",
        meaning: "width of the band",
        size: Size::Reading,
        low: 0.0,
        high: 0.3,
        neutral: 0.0,
        usual: 0.02,
    }],
};

impl Effect for This {
    fn about(&self) -> &'static About {
        &ABOUT
    }

    fn reading(&self, now: &Now<'_>, _: &[f64], values: &mut [f64]) {
        let mut last = values.first().copied().unwrap_or(0.0);
        for value in values {
            last = super::played(now.p[0], last, *value);
            *value = last;
        }
    }
}
