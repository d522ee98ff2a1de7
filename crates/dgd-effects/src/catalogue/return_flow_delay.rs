//! A return flow meter that is late by a pure transport delay.

use crate::MeterPath;
use crate::{
    About, Action, Belief, Component, Effect, Parameter, Relation, Role, Search, Setting, Timing,
};

/// See the module.
pub(super) struct ReturnFlowDelay;

static ABOUT: About = About {
    id: "return_flow_delay",
    title: "the return flow is measured late",
    component: Component::Instrument,
    relation: Relation::ReturnLineFriction,
    equation_without: Some("q_meter(t) = q(t)"),
    equation: "q_meter(t) = q(t - delay)",
    source: "Slettebø 2015, Eq. 3.21",
    excited_by: "changes of return flow",
    confusable: &[
        (
            "line_gas_storage",
            "a step of the pump speed: a delay moves the whole response, a store rounds it",
        ),
        (
            "pump_speed_lag",
            "compare outlet pressure with speed: a late pump delays both, a late meter only the flow",
        ),
    ],
    parameters: &[Parameter {
        name: "delay_s",
        meaning: "pure delay of the meter",
        role: Role::Grid(&[
            1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0, 10.0, 11.0, 12.0, 13.0, 14.0, 16.0, 18.0,
            20.0, 23.0, 26.0, 30.0,
        ]),
        low: 0.0,
        high: 180.0,
        usual: 10.0,
        ..Parameter::BASE
    }],
    search: Search {
        belief: Belief {
            hurdle: 7.0,
            scale: 4.0,
        },
        least: Some(3.5),
        form_error: 0.15,
        size_error: 0.1,
        // Loggers have clocks of their own: a meter may seem to be ahead.
        allowance: &[-5.0, -4.0, -3.0, -2.0, 0.5, 1.0, 1.5, 2.0, 2.5],
        timing: Some(Timing::Meter),
        ..Search::BASE
    },
};

impl Effect for ReturnFlowDelay {
    fn about(&self) -> &'static About {
        &ABOUT
    }

    fn begin(&self, _: &[f64], _: &Setting) -> Action {
        Box::new(|_, _| {})
    }

    fn memory_s(&self, _: &[f64]) -> f64 {
        0.0
    }

    fn meter_path(&self, p: &[f64]) -> MeterPath {
        MeterPath {
            delay_s: p[0],
            lag_s: 0.0,
        }
    }
}
