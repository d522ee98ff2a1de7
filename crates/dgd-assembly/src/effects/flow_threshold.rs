//! Surface tension or a cake holds the flow back until a small head is there.

use crate::Dual;
use crate::effect::{About, Effect, Now, ParameterAbout, Size};
use crate::spec::Kind;

pub(crate) struct This;

static ABOUT: About = About {
    id: "flow_threshold",
    title: "surface tension or a cake blocks the flow until there is a small head",
    kinds: &[Kind::Valve, Kind::Orifice],
    equation: "dp = K q|q| + p_t tanh(q/0.01 Q)",
    source: "de Gennes, P.-G., Brochard-Wyart, F. and Quéré, D., Capillarity and Wetting Phenomena (2004), on capillary pressure; the tanh only smooths its sign",
    excited_by: "flow that stops and starts at low head",
    confusable: &[
        (
            "outlet_offset",
            "a threshold acts near zero flow only in time, an offset at any",
        ),
        ("vortex", "a vortex acts at low level but any flow"),
    ],
    parameters: &[ParameterAbout {
        name: "head",
        meaning: "pressure that holds",
        size: Size::Pressure,
        low: 0.0,
        high: 0.2,
        neutral: 0.0,
        usual: 0.01,
    }],
};

impl Effect for This {
    fn about(&self) -> &'static About {
        &ABOUT
    }

    fn drop(&self, now: &Now<'_>, q: Dual, drop: Dual) -> Dual {
        drop + now.p[0] * (q * (100.0 / now.scale.flow_m3_s)).tanh()
    }
}
