//! The gaps widen in service: leakage grows with time.

use crate::Dual;
use crate::effect::{About, Effect, Now, ParameterAbout, Size};
use crate::kinds::centrifugal;
use crate::spec::Kind;

pub(crate) struct This;

static ABOUT: About = About {
    id: "pump_wear",
    title: "the gaps widen in service: leakage grows with time",
    kinds: &[Kind::CentrifugalPump],
    equation: "H = H(w, q + leak · w/50 % · t/1000 T)",
    source: "Gülich, J. F., Centrifugal Pumps (2010), on leakage losses and wear",
    excited_by: "the same speed and flow early and late",
    confusable: &[
        ("gas_head_loss", "gas takes the same share at any flow"),
        ("speed_drift", "a drifting speed acts at shut-off too"),
    ],
    parameters: &[ParameterAbout {
        name: "leak",
        meaning: "flow that runs back after a thousand usual times",
        size: Size::Flow,
        low: 0.0,
        high: 2.0,
        neutral: 0.0,
        usual: 0.05,
    }],
};

impl Effect for This {
    fn about(&self) -> &'static About {
        &ABOUT
    }

    fn through(&self, now: &Now<'_>, q: Dual) -> Dual {
        let worn = now.t_s / (1000.0 * now.scale.time_s);
        q + now.p[0] * worn * now.own[centrifugal::SPEED] / 50.0
    }
}
