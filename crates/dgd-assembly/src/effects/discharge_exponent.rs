//! The flow does not go with the square root of the drop.

use crate::Dual;
use crate::effect::{About, Effect, Now, ParameterAbout, Size};
use crate::spec::Kind;

pub(crate) struct This;

static ABOUT: About = About {
    id: "discharge_exponent",
    title: "the flow is not proportional to the square root of the drop",
    kinds: &[Kind::Valve, Kind::Orifice],
    equation: "dp = K q² |q/Q|^e",
    source: "Bos, M. G. (ed.), Discharge Measurement Structures, ILRI 20 (1989), on discharge exponents",
    excited_by: "flow over a wide range",
    confusable: &[
        (
            "laminar_resistance",
            "two ways to bend the same curve: low flow by decades separates",
        ),
        ("taper", "a taper acts only on moving levels"),
    ],
    parameters: &[ParameterAbout {
        name: "exponent",
        meaning: "excess over the exponent 2",
        size: Size::One,
        low: -0.9,
        high: 1.5,
        neutral: 0.0,
        usual: 0.1,
    }],
};

impl Effect for This {
    fn about(&self) -> &'static About {
        &ABOUT
    }

    fn drop(&self, now: &Now<'_>, q: Dual, drop: Dual) -> Dual {
        super::bent(now.p[0], now.scale.flow_m3_s, q, drop)
    }
}
