//! What flows out raises the pressure at the boundary.

use crate::effect::{About, Drive, Effect, Now, ParameterAbout, Place, Size};
use crate::spec::Kind;

pub(crate) struct This;

static ABOUT: About = About {
    id: "back_pressure",
    title: "the outflow raises the pressure at the boundary",
    kinds: &[Kind::Boundary],
    equation: "p = p_b + rise q|q|/Q²",
    source: "Idelchik, I. E., Handbook of Hydraulic Resistance (2007), on discharge losses",
    excited_by: "low and high flow",
    confusable: &[(
        "line_fittings",
        "the same at the end of a line: not separable",
    )],
    parameters: &[ParameterAbout {
        name: "rise",
        meaning: "pressure at the usual flow",
        size: Size::Pressure,
        low: 0.0,
        high: 2.0,
        neutral: 0.0,
        usual: 0.1,
    }],
};

impl Effect for This {
    fn about(&self) -> &'static About {
        &ABOUT
    }

    fn fits(&self, place: &Place) -> bool {
        !place.gives_flow && place.in_time
    }

    fn states(&self) -> usize {
        1
    }

    fn start(&self, _: &Now<'_>, drive: &Drive, x: &mut [f64]) {
        x[0] = -drive.flow_m3_s;
    }

    // Pressure builds within a tenth of the usual time: at once it would have to be solved for together with the flow.
    fn rates(&self, now: &Now<'_>, drive: &Drive, rate: &mut [f64]) {
        rate[0] = (-drive.flow_m3_s - now.x[0]) / (0.1 * now.scale.time_s);
    }

    fn input(&self, now: &Now<'_>, value: f64) -> f64 {
        let share = now.x.first().copied().unwrap_or(0.0) / now.scale.flow_m3_s;
        value + now.p[0] * share * share.abs()
    }
}
