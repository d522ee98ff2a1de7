//! Small readings are shown as zero.

use crate::effect::{About, Effect, Now, ParameterAbout, Size};
use crate::spec::Kind;

pub(crate) struct This;

static ABOUT: About = About {
    id: "low_flow_cutoff",
    title: "small readings are shown as zero",
    kinds: &[Kind::Instrument],
    equation: "y = 0 for |y_true| < cutoff",
    source: "Lipták, B. G. (ed.), Instrument Engineers' Handbook, vol. 1 (2003), on low-flow cut-off",
    excited_by: "low readings",
    confusable: &[("flow_threshold", "other instruments separate")],
    parameters: &[ParameterAbout {
        name: "cutoff",
        meaning: "reading below which it shows zero",
        size: Size::Reading,
        low: 0.0,
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
            if value.abs() < now.p[0] {
                *value = 0.0;
            }
        }
    }
}
