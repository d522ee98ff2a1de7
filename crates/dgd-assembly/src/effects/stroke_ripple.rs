//! The flow pulses with the strokes.

use crate::effect::{About, Effect, Now, ParameterAbout, Size};
use crate::spec::Kind;

pub(crate) struct This;

static ABOUT: About = About {
    id: "stroke_ripple",
    title: "the flow pulses with the strokes",
    kinds: &[Kind::DisplacementPump],
    equation: "q = c u (1 + depth sin(2π t/period + phase))",
    source: "Ivantysyn, J. and Ivantysynova, M., Hydrostatic Pumps and Motors (2003), on flow ripple",
    excited_by: "sampling faster than half the period",
    confusable: &[],
    parameters: &[
        ParameterAbout {
            name: "depth",
            meaning: "relative amplitude",
            size: Size::One,
            low: 0.0,
            high: 0.8,
            neutral: 0.0,
            usual: 0.1,
        },
        ParameterAbout {
            name: "period",
            meaning: "period",
            size: Size::Time,
            low: 0.2,
            high: 50.0,
            neutral: 2.0,
            usual: 2.0,
        },
        ParameterAbout {
            name: "phase",
            meaning: "phase at the start, rad",
            size: Size::One,
            low: 0.0,
            high: std::f64::consts::TAU,
            neutral: 0.0,
            usual: 0.0,
        },
    ],
};

impl Effect for This {
    fn about(&self) -> &'static About {
        &ABOUT
    }

    fn input(&self, now: &Now<'_>, value: f64) -> f64 {
        let turn = std::f64::consts::TAU * now.t_s / now.p[1].max(1e-9);
        value * (1.0 + now.p[0] * (turn + now.p[2]).sin())
    }
}
