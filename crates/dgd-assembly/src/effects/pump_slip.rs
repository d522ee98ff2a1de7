//! The pump delivers less against pressure.

use crate::Dual;
use crate::effect::{About, Effect, Now, ParameterAbout, Size};
use crate::spec::Kind;

pub(crate) struct This;

static ABOUT: About = About {
    id: "pump_slip",
    title: "the pump delivers less against pressure",
    kinds: &[Kind::DisplacementPump],
    equation: "q = c u − slip (p_out − p_in)/P",
    source: "Wilson, W. E., Trans. ASME 71 (1949); Ivantysyn, J. and Ivantysynova, M., Hydrostatic Pumps and Motors (2003), on losses",
    excited_by: "like inputs against several pressures",
    confusable: &[
        ("pump_turbulent_slip", "low and high pressure separate"),
        ("pump_offset", "the pressure separates"),
    ],
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
        flow - now.p[0] / now.scale.pressure_pa * rise
    }

    fn has_delivery(&self) -> bool {
        true
    }
}
