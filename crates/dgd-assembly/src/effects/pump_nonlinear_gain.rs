//! The flow is not proportional to the input.

use crate::effect::{About, Effect, Now, ParameterAbout, Size};
use crate::kinds::displacement;
use crate::spec::Kind;

pub(crate) struct This;

static ABOUT: About = About {
    id: "pump_nonlinear_gain",
    title: "the flow is not proportional to the input",
    kinds: &[Kind::DisplacementPump],
    equation: "q = c u (1 + bend c u/Q)",
    source: "Ivantysyn, J. and Ivantysynova, M., Hydrostatic Pumps and Motors (2003), on filling losses; the parabola is empirical",
    excited_by: "low and high inputs",
    confusable: &[
        (
            "pump_dead_band",
            "very low inputs separate: within a dead band the pump stands",
        ),
        (
            "splash",
            "splashing is lost behind the pump: a meter at the pump separates",
        ),
    ],
    parameters: &[ParameterAbout {
        name: "bend",
        meaning: "relative change of the gain at the usual flow",
        size: Size::One,
        low: -0.6,
        high: 0.6,
        neutral: 0.0,
        usual: 0.1,
    }],
};

impl Effect for This {
    fn about(&self) -> &'static About {
        &ABOUT
    }

    fn input(&self, now: &Now<'_>, value: f64) -> f64 {
        let share = now.own[displacement::COEFFICIENT] * value / now.scale.flow_m3_s;
        // Flow may level off but not fall again.
        let share = if now.p[0] < 0.0 {
            share.clamp(0.0, -0.5 / now.p[0])
        } else {
            share
        };
        value * (1.0 + now.p[0] * share)
    }
}
