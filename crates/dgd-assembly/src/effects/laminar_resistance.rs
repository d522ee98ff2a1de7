//! A laminar part of the resistance, felt at low flow.

use crate::Dual;
use crate::effect::{About, Effect, Now, ParameterAbout, Size};
use crate::spec::Kind;

pub(crate) struct This;

static ABOUT: About = About {
    id: "laminar_resistance",
    title: "a laminar part of the resistance, visible at low flow",
    kinds: &[Kind::Valve, Kind::Orifice],
    equation: "dp = K q|q| + p_l q/Q",
    source: "Idelchik, I. E., Handbook of Hydraulic Resistance (2007), on resistance as A/Re + B",
    excited_by: "low and high flow",
    confusable: &[
        (
            "discharge_exponent",
            "two ways to bend the same curve: low flow by decades separates",
        ),
        (
            "reynolds_coefficient",
            "two ways to bend the same curve: low flow by decades separates",
        ),
    ],
    parameters: &[ParameterAbout {
        name: "drop",
        meaning: "laminar drop at the usual flow",
        size: Size::Pressure,
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
        drop + now.p[0] / now.scale.flow_m3_s * q
    }
}
