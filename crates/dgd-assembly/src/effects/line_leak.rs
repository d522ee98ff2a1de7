//! The line leaks before its end.

use crate::effect::{About, Effect, Now, ParameterAbout, Place, Size};
use crate::spec::Kind;

pub(crate) struct This;

static ABOUT: About = About {
    id: "line_leak",
    title: "the line leaks before its end",
    kinds: &[Kind::Line],
    equation: "q_out = q − leak sqrt((p_in − p_0)/P)",
    source: "Wylie, E. B. and Streeter, V. L., Fluid Transients in Systems (1993), on leaks; White, F. M., Fluid Mechanics (2011), on Torricelli's law",
    excited_by: "flow and pressure that vary apart from each other",
    confusable: &[("tank_leak", "a tank's leak goes with its level")],
    parameters: &[ParameterAbout {
        name: "leak",
        meaning: "leak at the usual pressure",
        size: Size::Flow,
        low: 0.0,
        high: 0.5,
        neutral: 0.0,
        usual: 0.05,
    }],
};

impl Effect for This {
    fn about(&self) -> &'static About {
        &ABOUT
    }

    fn fits(&self, place: &Place) -> bool {
        place.outlet_stores
    }

    fn outlet(&self, now: &Now<'_>, q: f64, inlet_pa: f64) -> f64 {
        q - now.p[0] * ((inlet_pa - crate::ATMOSPHERE).max(0.0) / now.scale.pressure_pa).sqrt()
    }
}
