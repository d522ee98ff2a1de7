//! The pressure at the boundary swings.

use crate::effect::{About, Effect, Now, ParameterAbout, Place, Size};
use crate::spec::Kind;

pub(crate) struct This;

static ABOUT: About = About {
    id: "tide",
    title: "the pressure at the boundary swings",
    kinds: &[Kind::Boundary],
    equation: "p = p_b + swing sin(2π t/period + phase)",
    source: "Pugh, D. and Woodworth, P., Sea-Level Science (2014)",
    excited_by: "several periods",
    confusable: &[("stroke_ripple", "the pump's speed sets that period")],
    parameters: &[
        ParameterAbout {
            name: "swing",
            meaning: "amplitude",
            size: Size::Pressure,
            low: 0.0,
            high: 1.0,
            neutral: 0.0,
            usual: 0.05,
        },
        ParameterAbout {
            name: "period",
            meaning: "period",
            size: Size::Time,
            low: 0.2,
            high: 1000.0,
            neutral: 20.0,
            usual: 20.0,
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

    fn fits(&self, place: &Place) -> bool {
        !place.gives_flow
    }

    fn input(&self, now: &Now<'_>, value: f64) -> f64 {
        let turn = std::f64::consts::TAU * now.t_s / now.p[1].max(1e-9);
        value + now.p[0] * (turn + now.p[2]).sin()
    }
}
