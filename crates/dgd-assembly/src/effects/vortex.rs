//! Air drawn in through a vortex chokes the outlet at low level.

use crate::effect::{About, Effect, Now, ParameterAbout, Size};
use crate::spec::Kind;

pub(crate) struct This;

static ABOUT: About = About {
    id: "vortex",
    title: "air drawn in through a vortex chokes the outlet at low level",
    kinds: &[Kind::Tank],
    equation: "h_outlet = h (1 − depth exp(−h/h_v))",
    source: "Knauss, J. (ed.), Swirling Flow Problems at Intakes, IAHR (1987), on critical submergence; the exponential is empirical",
    excited_by: "outflow at low level",
    confusable: &[
        (
            "outlet_offset",
            "a vortex fades above the critical submergence",
        ),
        (
            "laminar_resistance",
            "that goes with the flow, not with the level",
        ),
    ],
    parameters: &[
        ParameterAbout {
            name: "depth",
            meaning: "share of the head that is lost near the outlet",
            size: Size::One,
            low: 0.0,
            high: 0.95,
            neutral: 0.0,
            usual: 0.3,
        },
        ParameterAbout {
            name: "submergence",
            meaning: "level at which it fades",
            size: Size::Level,
            low: 0.02,
            high: 0.5,
            neutral: 0.1,
            usual: 0.1,
        },
    ],
};

impl Effect for This {
    fn about(&self) -> &'static About {
        &ABOUT
    }

    fn head(&self, now: &Now<'_>, level: f64) -> f64 {
        let fade = (-level.max(0.0) / now.p[1].max(1e-12)).exp();
        level * (1.0 - now.p[0] * fade)
    }
}
