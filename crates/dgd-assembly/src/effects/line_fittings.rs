//! Bends, entries and valves that were not counted.

use crate::Dual;
use crate::effect::{About, Effect, Now, ParameterAbout, Size};
use crate::spec::Kind;

pub(crate) struct This;

static ABOUT: About = About {
    id: "line_fittings",
    title: "bends, entries and valves that were not counted",
    kinds: &[Kind::Line],
    equation: "dp = F(q) + p_f q|q|/Q²",
    source: "Crane Co., Flow of Fluids, TP-410 (2009); Idelchik, I. E., Handbook of Hydraulic Resistance (2007)",
    excited_by: "low and high flow",
    confusable: &[("line_laminar", "its drop goes with the flow itself")],
    parameters: &[ParameterAbout {
        name: "drop",
        meaning: "their drop at the usual flow",
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

    fn drop(&self, now: &Now<'_>, q: Dual, drop: Dual) -> Dual {
        let share = q * (1.0 / now.scale.flow_m3_s);
        drop + now.p[0] * share * share.abs()
    }
}
