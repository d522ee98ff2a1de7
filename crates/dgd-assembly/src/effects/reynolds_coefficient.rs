//! The discharge coefficient falls at low Reynolds number.

use crate::Dual;
use crate::effect::{About, Effect, Now, ParameterAbout, Size};
use crate::spec::Kind;

pub(crate) struct This;

static ABOUT: About = About {
    id: "reynolds_coefficient",
    title: "the discharge coefficient falls at low Reynolds number",
    kinds: &[Kind::Valve, Kind::Orifice],
    equation: "C = C_0 / (1 + fall/(1 + 10 |q|/Q))",
    source: "Lichtarowicz, A., Duggins, R. K. and Markland, E., J. Mech. Eng. Sci. 7 (1965), on long orifices; a thin plate's rises slightly (ISO 5167-2, 2003): a negative fall; the form is empirical",
    excited_by: "low and high flow",
    confusable: &[
        (
            "laminar_resistance",
            "two ways to bend the same curve: low flow by decades separates",
        ),
        (
            "discharge_exponent",
            "two ways to bend the same curve: low and high flow by decades separate",
        ),
    ],
    parameters: &[ParameterAbout {
        name: "fall",
        meaning: "relative change of the coefficient at low flow",
        size: Size::One,
        low: -0.4,
        high: 2.0,
        neutral: 0.0,
        usual: 0.2,
    }],
};

impl Effect for This {
    fn about(&self) -> &'static About {
        &ABOUT
    }

    fn drop(&self, now: &Now<'_>, q: Dual, drop: Dual) -> Dual {
        let factor = 1.0 + now.p[0] / (1.0 + (10.0 / now.scale.flow_m3_s) * q.abs());
        factor * factor * drop
    }
}
