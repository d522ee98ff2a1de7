//! The flow saturates: cavitation or critical flow.

use crate::Dual;
use crate::effect::{About, Effect, Now, ParameterAbout, Size};
use crate::spec::Kind;

pub(crate) struct This;

static ABOUT: About = About {
    id: "choking",
    title: "the flow saturates: cavitation or critical flow",
    kinds: &[Kind::Valve, Kind::Orifice],
    equation: "dp = K q|q| + P (choke q/Q)^8",
    source: "IEC 60534-2-1 (2011), choked flow of liquids; the eighth power is a smooth wall in place of the limit",
    excited_by: "high flow",
    confusable: &[("discharge_exponent", "choking does not affect low flow")],
    parameters: &[ParameterAbout {
        name: "choke",
        meaning: "usual flow over the flow that chokes",
        size: Size::One,
        low: 0.0,
        high: 1.5,
        neutral: 0.0,
        usual: 0.7,
    }],
};

impl Effect for This {
    fn about(&self) -> &'static About {
        &ABOUT
    }

    fn drop(&self, now: &Now<'_>, q: Dual, drop: Dual) -> Dual {
        super::wall(now.p[0], now, q, drop)
    }
}
