//! What enters arrives late: it fills the feed pipe or runs down the wall first.

use crate::effect::{About, Balance, Drive, Effect, Now, ParameterAbout, Size};
use crate::spec::Kind;

pub(crate) struct This;

static ABOUT: About = About {
    id: "inflow_lag",
    title: "the inflow arrives late: it first fills the feed pipe or runs down the wall",
    kinds: &[Kind::Tank],
    equation: "τ dq_a/dt = q_in − q_a; A dh/dt = q_a − q_out",
    source: "Ogunnaike, B. A. and Ray, W. H., Process Dynamics, Modeling, and Control (1994), on first-order systems",
    excited_by: "steps of inflow",
    confusable: &[
        (
            "pump_lag",
            "the same order and place: only a flow meter between them separates",
        ),
        ("reading_lag", "a late reading delays draining as well"),
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

impl Effect for This {
    fn about(&self) -> &'static About {
        &ABOUT
    }

    fn states(&self) -> usize {
        1
    }

    fn start(&self, _: &Now<'_>, drive: &Drive, x: &mut [f64]) {
        x[0] = drive.flow_m3_s;
    }

    fn rates(&self, now: &Now<'_>, drive: &Drive, rate: &mut [f64]) {
        rate[0] = super::lag(now.p[0], now.x[0], drive.flow_m3_s, now.scale.time_s);
    }

    fn balance(&self, now: &Now<'_>, flows: &mut Balance) {
        flows.inflow_m3_s = super::lagged(now.p[0], now.x[0], flows.inflow_m3_s, now.scale.time_s);
    }
}
