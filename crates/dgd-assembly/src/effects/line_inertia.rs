//! The fluid in the line needs time to speed up.

use crate::effect::{About, Effect, Now, ParameterAbout, Place, Size};
use crate::spec::Kind;

pub(crate) struct This;

static ABOUT: About = About {
    id: "line_inertia",
    title: "the fluid in the line needs time to speed up",
    kinds: &[Kind::Line],
    equation: "M dq/dt = p_1 − p_2 − F(q)",
    source: "Slettebø, D., NTNU (2015), Eq. 2.18",
    excited_by: "steps of pressure, speed or opening",
    confusable: &[
        ("pump_lag", "a late pump is late at no flow as well"),
        (
            "gas_pocket",
            "inertia delays the whole line, gas only what leaves",
        ),
    ],
    parameters: &[ParameterAbout {
        name: "share",
        meaning: "inertia over usual pressure · time / flow",
        size: Size::One,
        low: 0.0,
        high: 20.0,
        neutral: 0.0,
        usual: 0.5,
    }],
};

impl Effect for This {
    fn about(&self) -> &'static About {
        &ABOUT
    }

    fn fits(&self, place: &Place) -> bool {
        place.may_have_inertia || place.has_inertia
    }

    fn inertia(&self, now: &Now<'_>) -> f64 {
        now.p[0] * now.scale.pressure_pa * now.scale.time_s / now.scale.flow_m3_s
    }

    fn gives_inertia(&self) -> bool {
        true
    }
}
