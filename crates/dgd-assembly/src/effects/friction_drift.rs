//! Friction changes in time or along the record: warming, fouling, conditioning of the mud.

use crate::Dual;
use crate::effect::{About, Effect, Now, ParameterAbout, Size};
use crate::spec::Kind;

pub(crate) struct This;

static ABOUT: About = About {
    id: "friction_drift",
    title: "friction changes in time or along the record: warming, fouling, conditioning of the mud",
    kinds: &[Kind::Line],
    equation: "F = F_0(q) exp(change t/1000 T)",
    source: "Slettebø, D., NTNU (2015), Eq. 2.20; Kutasov, I. M., Applied Geothermics for Petroleum Engineers (1999)",
    excited_by: "the same flow early and late",
    confusable: &[("column_drift", "a drifting column also acts at rest")],
    parameters: &[ParameterAbout {
        name: "change",
        meaning: "relative change in a thousand usual times",
        size: Size::One,
        low: -3.0,
        high: 3.0,
        neutral: 0.0,
        usual: 0.1,
    }],
};

impl Effect for This {
    fn about(&self) -> &'static About {
        &ABOUT
    }

    fn drop(&self, now: &Now<'_>, _: Dual, drop: Dual) -> Dual {
        let still = super::still(now);
        let factor = (now.p[0] * now.t_s / (1000.0 * now.scale.time_s))
            .clamp(-20.0, 20.0)
            .exp();
        still + factor * (drop - still)
    }
}
