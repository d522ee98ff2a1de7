//! Gas that lowers the pump head for a while.

use crate::{About, Action, Belief, Component, Effect, Parameter, Relation, Role, Search, Setting};

/// See the module.
pub(super) struct GasInPump;

static ABOUT: About = About {
    id: "gas_in_pump",
    title: "gas lowers the pump head temporarily",
    component: Component::Pump,
    relation: Relation::PumpHead,
    equation_without: None,
    equation: "p_out - p_in = (1 - loss s(t)) H(w, q), s a trapezium",
    source: "two-phase degradation: Gülich 2010, on gas-liquid mixtures; the trapezium is empirical",
    excited_by: "steady running on both sides of the event",
    confusable: &[("pump_wear", "wait: gas passes, wear grows")],
    parameters: &[
        Parameter {
            name: "head_loss_fraction",
            meaning: "head lost",
            role: Role::Amplitude,
            low: 0.0,
            high: 0.9,
            usual: 0.05,
            ..Parameter::BASE
        },
        Parameter::ONSET,
        Parameter {
            name: "duration_s",
            meaning: "duration",
            role: Role::Duration(&[1300.0, 2300.0, 3600.0]),
            low: 1200.0,
            high: f64::INFINITY,
            usual: 2400.0,
            time_error_s: 20.0,
            ..Parameter::BASE
        },
        Parameter {
            name: "edge_s",
            meaning: "rise time, and equal fall time",
            role: Role::Edge(&[20.0, 150.0, 400.0]),
            low: 1.0,
            high: 1800.0,
            usual: 150.0,
            ..Parameter::BASE
        },
    ],
    search: Search {
        belief: Belief {
            hurdle: 8.0,
            scale: 4.0,
        },
        least: Some(8e-3),
        form_error: 0.15,
        ..Search::BASE
    },
};

impl Effect for GasInPump {
    fn about(&self) -> &'static About {
        &ABOUT
    }

    fn begin(&self, p: &[f64], _: &Setting) -> Action {
        let (loss, from, to) = (p[0], p[1], p[1] + p[2]);
        let edge = p[3].min(0.5 * p[2]).max(1e-3);
        Box::new(move |at, changes| {
            let inside = (at.t_s - from).min(to - at.t_s);
            changes.head_factor *= 1.0 - loss * (inside / edge).clamp(0.0, 1.0);
        })
    }

    fn is_switch(&self) -> bool {
        true
    }
}
