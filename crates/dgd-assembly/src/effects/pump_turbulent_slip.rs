//! The pump leaks through wide gaps, as an orifice does.

use crate::Dual;
use crate::effect::{About, Effect, Now, ParameterAbout, Size};
use crate::spec::Kind;

pub(crate) struct This;

static ABOUT: About = About {
    id: "pump_turbulent_slip",
    title: "the pump leaks through wide gaps, as an orifice does",
    kinds: &[Kind::DisplacementPump],
    equation: "q = c u − slip sqrt((p_out − p_in)/P)",
    source: "Schlösser, W. M. J., Hydraulic Power Transmission 7 (1961); Ivantysyn and Ivantysynova (2003), on losses",
    excited_by: "like inputs against several pressures",
    confusable: &[("pump_slip", "low and high pressure separate")],
    parameters: &[ParameterAbout {
        name: "slip",
        meaning: "flow lost at the usual pressure",
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

    fn delivery(&self, now: &Now<'_>, rise: Dual, flow: Dual) -> Dual {
        let share = rise * (1.0 / now.scale.pressure_pa);
        // Straight near zero, where the root is too steep to solve for.
        flow - now.p[0] * share / (share * share + 1e-6).powf(0.25)
    }

    fn has_delivery(&self) -> bool {
        true
    }
}
