//! The instrument drifts.

use crate::effect::{About, Effect, Now, ParameterAbout, Size};
use crate::spec::Kind;

pub(crate) struct This;

static ABOUT: About = About {
    id: "reading_drift",
    title: "the instrument drifts",
    kinds: &[Kind::Instrument],
    equation: "y = y_true + change t/1000 T",
    source: "IEC 61298-2 (2008), long-term drift; Lipták, B. G. (ed.), Instrument Engineers' Handbook, vol. 1 (2003), on errors of instruments",
    excited_by: "like states early and late",
    confusable: &[
        (
            "clogging",
            "clogging changes the dynamics as well as the level",
        ),
        (
            "column_drift",
            "the same at one gauge; a second gauge on the line separates",
        ),
    ],
    parameters: &[ParameterAbout {
        name: "change",
        meaning: "change in a thousand usual times",
        size: Size::Reading,
        low: -1.0,
        high: 1.0,
        neutral: 0.0,
        usual: 0.03,
    }],
};

impl Effect for This {
    fn about(&self) -> &'static About {
        &ABOUT
    }

    fn reading(&self, now: &Now<'_>, t_s: &[f64], values: &mut [f64]) {
        for (value, t) in values.iter_mut().zip(t_s) {
            *value += now.p[0] * t / (1000.0 * now.scale.time_s);
        }
    }
}
