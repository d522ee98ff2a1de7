//! Gas trapped in the return line, which stores mud and rounds the flow at the meter.

use crate::MeterPath;
use crate::{
    About, Action, Belief, Component, Effect, Parameter, Relation, Role, Search, Setting, Timing,
};

/// See the module.
pub(super) struct LineGasStorage;

static ABOUT: About = About {
    id: "line_gas_storage",
    title: "trapped gas makes the return line store mud",
    component: Component::Line,
    relation: Relation::ReturnLineFriction,
    equation_without: Some("q_meter = q"),
    equation: "tau dq_meter/dt = q - q_meter; spread, (tau - t_d) dq_meter/dt = q(t - t_d) - q_meter",
    source: "lumped gas cushion: C dp/dt = q - q_meter with tau = C dp/dq; a chain of cushions to its second moment",
    excited_by: "changes of return flow",
    confusable: &[(
        "return_flow_delay",
        "a step of the pump speed: a delay moves the whole response, a store rounds it",
    )],
    parameters: &[
        Parameter {
            name: "tau_s",
            meaning: "time constant of the store",
            role: Role::Grid(&[
                2.0, 3.0, 4.0, 5.0, 7.0, 9.0, 12.0, 15.0, 18.0, 22.0, 27.0, 33.0, 40.0,
            ]),
            low: 0.0,
            high: 240.0,
            usual: 15.0,
            ..Parameter::BASE
        },
        Parameter {
            name: "spread",
            meaning: "how far gas is spread along the line: 0 one cushion, 0.5 two equal ones, 1 infinitely many",
            role: Role::Shape(&[0.0, 0.5]),
            low: 0.0,
            high: 1.0,
            usual: 0.0,
            ..Parameter::BASE
        },
    ],
    search: Search {
        belief: Belief {
            hurdle: 7.0,
            scale: 4.0,
        },
        least: Some(2.5),
        form_error: 0.15,
        size_error: 0.1,
        timing: Some(Timing::Meter),
        ..Search::BASE
    },
};

impl Effect for LineGasStorage {
    fn about(&self) -> &'static About {
        &ABOUT
    }

    fn begin(&self, _: &[f64], _: &Setting) -> Action {
        Box::new(|_, _| {})
    }

    fn same_as(&self, p: &[f64], _: &Setting) -> Option<String> {
        Some(format!(
            "a return flow whose transmitter damps it by {:.0} s",
            p[0]
        ))
    }

    fn memory_s(&self, _: &[f64]) -> f64 {
        0.0
    }

    fn meter_path(&self, p: &[f64]) -> MeterPath {
        // Of n equal cushions in a row the answer has the mean time tau and, 1/n of its square, a variance: so have a delay
        // and one lag behind it.
        let lag_s = p[0] * (1.0 - p[1]).max(0.0).sqrt();
        MeterPath {
            delay_s: p[0] - lag_s,
            lag_s,
        }
    }
}
