//! An uncounted flow sets in at some time.

use crate::effect::{About, Effect, Now, ParameterAbout, Place, Size};
use crate::spec::Kind;

pub(crate) struct This;

static ABOUT: About = About {
    id: "inflow_step",
    title: "an uncounted flow sets in at some time",
    kinds: &[Kind::Boundary],
    equation: "q = q_b + step for t ≥ onset",
    source: "Basseville, M. and Nikiforov, I. V., Detection of Abrupt Changes (1993)",
    excited_by: "stretches before and after",
    confusable: &[
        ("inflow_offset", "a stretch before the onset separates"),
        (
            "inflow_drift",
            "the balance before and after: a step jumps, a drift grows",
        ),
    ],
    parameters: &[
        ParameterAbout {
            name: "step",
            meaning: "flow that is added",
            size: Size::Flow,
            low: -1.0,
            high: 1.0,
            neutral: 0.0,
            usual: 0.1,
        },
        ParameterAbout {
            name: "onset",
            meaning: "when it sets in",
            size: Size::Time,
            low: 0.0,
            high: 1000.0,
            neutral: 0.0,
            usual: 50.0,
        },
    ],
};

impl Effect for This {
    fn about(&self) -> &'static About {
        &ABOUT
    }

    fn fits(&self, place: &Place) -> bool {
        place.gives_flow && place.in_time
    }

    fn input(&self, now: &Now<'_>, value: f64) -> f64 {
        // Over a hundredth of the usual time, so that the onset can be fitted.
        let since = (now.t_s - now.p[1]) / (0.01 * now.scale.time_s);
        value + now.p[0] * since.clamp(0.0, 1.0)
    }
}
