//! A flap or an airlock keeps the flow from running back.

use crate::Dual;
use crate::effect::{About, Effect, Now, ParameterAbout, Size};
use crate::spec::Kind;

pub(crate) struct This;

static ABOUT: About = About {
    id: "backflow_stop",
    title: "a flap or an airlock keeps the flow from running back",
    kinds: &[Kind::Valve, Kind::Orifice],
    equation: "dp = K q|q| (1 + stop) for q < 0",
    source: "Crane Co., Flow of Fluids, TP-410 (2009), on check valves",
    excited_by: "a drop that changes its sign",
    confusable: &[],
    parameters: &[ParameterAbout {
        name: "stop",
        meaning: "resistance to backflow, in units of ten thousand times the forward resistance",
        size: Size::One,
        low: 0.0,
        high: 1.0,
        neutral: 0.0,
        usual: 0.1,
    }],
};

impl Effect for This {
    fn about(&self) -> &'static About {
        &ABOUT
    }

    fn drop(&self, now: &Now<'_>, q: Dual, drop: Dual) -> Dual {
        if q.v < 0.0 {
            (1.0 + 1e4 * now.p[0]) * drop
        } else {
            drop
        }
    }
}
