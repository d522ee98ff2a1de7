//! The speed drifts away from its set-point.

use crate::effect::{About, Effect, Now, ParameterAbout, Size};
use crate::spec::Kind;

pub(crate) struct This;

static ABOUT: About = About {
    id: "speed_drift",
    title: "the speed drifts away from its set-point",
    kinds: &[Kind::CentrifugalPump],
    equation: "w_felt = w (1 + change t/1000 T)",
    source: "Lipták, B. G. (ed.), Instrument Engineers' Handbook, vol. 1 (2003), on tachometers",
    excited_by: "the same set-point early and late",
    confusable: &[("pump_wear", "a drifting speed acts at shut-off too")],
    parameters: &[ParameterAbout {
        name: "change",
        meaning: "relative change in a thousand usual times",
        size: Size::One,
        low: -1.0,
        high: 1.0,
        neutral: 0.0,
        usual: 0.02,
    }],
};

impl Effect for This {
    fn about(&self) -> &'static About {
        &ABOUT
    }

    fn input(&self, now: &Now<'_>, value: f64) -> f64 {
        value * (1.0 + now.p[0] * now.t_s / (1000.0 * now.scale.time_s)).max(0.0)
    }
}
