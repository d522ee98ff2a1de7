//! The instrument is not straight over its range.

use crate::effect::{About, Effect, Now, ParameterAbout, Size};
use crate::spec::Kind;

pub(crate) struct This;

static ABOUT: About = About {
    id: "reading_curvature",
    title: "the instrument is not linear over its range",
    kinds: &[Kind::Instrument],
    equation: "y = y_true + 4 bow R (y_true/R)(1 − y_true/R)",
    source: "IEC 61298-2 (2008), terminal-based linearity",
    excited_by: "readings over the whole range at rest",
    confusable: &[
        ("taper", "compare static levels: a taper leaves them alone"),
        ("discharge_exponent", "static levels separate"),
    ],
    parameters: &[ParameterAbout {
        name: "bow",
        meaning: "greatest deviation over the usual reading",
        size: Size::One,
        low: -0.25,
        high: 0.25,
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
            *value += 4.0 * now.p[0] * *value * (1.0 - *value / now.scale.reading);
        }
    }
}
