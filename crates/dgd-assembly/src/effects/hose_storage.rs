//! The hose behind the pump fills and drains: what arrives lags.

use super::outlet_lag::OutletLag;
use crate::effect::{About, ParameterAbout, Size};
use crate::spec::Kind;

pub(crate) static THIS: OutletLag = OutletLag(&ABOUT);

static ABOUT: About = About {
    id: "hose_storage",
    title: "the hose downstream of the pump fills and drains: the delivery lags",
    kinds: &[Kind::DisplacementPump],
    equation: "τ dq_out/dt = q − q_out",
    source: "Wylie, E. B. and Streeter, V. L., Fluid Transients in Systems (1993), on lumped capacitance",
    excited_by: "changes of input",
    confusable: &[
        ("pump_lag", "a meter at the pump separates"),
        ("inflow_lag", "the same seen from the tank: not separable"),
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
