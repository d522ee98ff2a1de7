//! The head breaks down at high flow.

use crate::Dual;
use crate::effect::{About, Effect, Now, ParameterAbout, Size};
use crate::spec::Kind;

pub(crate) struct This;

static ABOUT: About = About {
    id: "cavitation",
    title: "the head breaks down at high flow",
    kinds: &[Kind::CentrifugalPump],
    equation: "H = H(w, q) − P/(ρ g) (choke q/Q)^8",
    source: "Gülich, J. F., Centrifugal Pumps (2010), on cavitation and head drop; the eighth power is a smooth wall in place of the breakdown",
    excited_by: "high flow",
    confusable: &[("viscosity_derating", "cavitation does not affect low flow")],
    parameters: &[ParameterAbout {
        name: "choke",
        meaning: "usual flow over the flow of breakdown",
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
