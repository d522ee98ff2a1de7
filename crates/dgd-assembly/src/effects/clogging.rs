//! The passage narrows with time.

use crate::Dual;
use crate::effect::{About, Effect, Now, ParameterAbout, Size};
use crate::spec::Kind;

pub(crate) struct This;

static ABOUT: About = About {
    id: "clogging",
    title: "the passage narrows with time",
    kinds: &[Kind::Valve, Kind::Orifice],
    equation: "C(t) = C exp(−share t/1000 T)",
    source: "Crane Co., Flow of Fluids, TP-410 (2009); fouling as in Idelchik, I. E., Handbook of Hydraulic Resistance (2007)",
    excited_by: "the same flow early and late",
    confusable: &[(
        "reading_drift",
        "clogging changes the dynamics as well as the level",
    )],
    parameters: &[ParameterAbout {
        name: "share",
        meaning: "share of the opening lost in a thousand usual times, negative if it washes out",
        size: Size::One,
        low: -2.0,
        high: 4.0,
        neutral: 0.0,
        usual: 0.1,
    }],
};

impl Effect for This {
    fn about(&self) -> &'static About {
        &ABOUT
    }

    fn drop(&self, now: &Now<'_>, _: Dual, drop: Dual) -> Dual {
        (2.0 * now.p[0] * now.t_s / (1000.0 * now.scale.time_s))
            .clamp(-20.0, 20.0)
            .exp()
            * drop
    }
}
