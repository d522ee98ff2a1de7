//! Gas in the line stores fluid: what leaves lags what enters.

use super::outlet_lag::OutletLag;
use crate::effect::{About, ParameterAbout, Size};
use crate::spec::Kind;

pub(crate) static THIS: OutletLag = OutletLag(&ABOUT);

static ABOUT: About = About {
    id: "gas_pocket",
    title: "gas in the line stores fluid: the outflow lags the inflow",
    kinds: &[Kind::Line],
    equation: "τ dq_out/dt = q_in − q_out",
    source: "Wylie, E. B. and Streeter, V. L., Fluid Transients in Systems (1993), on lumped capacitance and gas",
    excited_by: "changes of flow",
    confusable: &[
        (
            "line_inertia",
            "inertia delays the whole line, gas only what leaves",
        ),
        (
            "reading_lag",
            "a late meter leaves the tank behind it on time",
        ),
    ],
    parameters: &[ParameterAbout {
        name: "tau",
        meaning: "time constant",
        size: Size::Time,
        low: 0.0,
        high: 20.0,
        neutral: 0.0,
        usual: 1.0,
    }],
};
