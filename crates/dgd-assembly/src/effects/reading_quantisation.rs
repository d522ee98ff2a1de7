//! The reading moves in steps.

use crate::effect::{About, Effect, Now, ParameterAbout, Size};
use crate::spec::Kind;

pub(crate) struct This;

static ABOUT: About = About {
    id: "reading_quantisation",
    title: "the reading moves in steps",
    kinds: &[Kind::Instrument],
    equation: "y = step round(y_true/step)",
    source: "Widrow, B. and Kollár, I., Quantization Noise (2008)",
    excited_by: "slow changes",
    confusable: &[],
    parameters: &[ParameterAbout {
        name: "step",
        meaning: "step",
        size: Size::Reading,
        low: 0.0,
        high: 0.1,
        neutral: 0.0,
        usual: 0.01,
    }],
};

impl Effect for This {
    fn about(&self) -> &'static About {
        &ABOUT
    }

    fn reading(&self, now: &Now<'_>, _: &[f64], values: &mut [f64]) {
        let step = now.p[0];
        if step > 0.0 {
            for value in values {
                *value = step * (*value / step).round();
            }
        }
    }
}
