//! Formation fluid that enters for a while: a kick.

use crate::{
    About, Action, Belief, Component, Effect, PUMPED_M3_S, Parameter, Relation, Role, Search,
    Setting,
};
use dgd_units::Legible;

/// See the module.
pub(super) struct Influx;

static ABOUT: About = About {
    id: "influx",
    title: "formation fluid enters the well",
    component: Component::Boundary,
    relation: Relation::RiserMassBalance,
    equation_without: None,
    equation: "A dh/dt = q_in + rate s(t) - q",
    source: "kick in the two-state mass balance (Eq. 3.45)",
    excited_by: "flow at any rate",
    confusable: &[
        (
            "lost_circulation",
            "the sign of the imbalance: an influx raises the level, a loss lowers it",
        ),
        (
            "line_leak",
            "check head and line friction: a leak changes both",
        ),
    ],
    parameters: &[
        Parameter {
            name: "rate_m3_s",
            meaning: "plateau rate",
            role: Role::Amplitude,
            low: 0.0,
            high: 0.05,
            usual: 0.0015,
            ..Parameter::BASE
        },
        Parameter::ONSET,
        Parameter {
            name: "duration_s",
            meaning: "duration from start to end",
            role: Role::Duration(&[1300.0, 2300.0, 3600.0, 6000.0, 10_000.0]),
            low: 120.0,
            high: f64::INFINITY,
            usual: 3000.0,
            // A kick dies away more slowly than it came.
            time_error_s: 120.0,
            ..Parameter::BASE
        },
        Parameter {
            name: "ramp",
            meaning: "rise time, and equal fall time, as a share of the duration",
            role: Role::Shape(&[0.15]),
            low: 0.01,
            high: 0.5,
            usual: 0.15,
            ..Parameter::BASE
        },
    ],
    search: Search {
        belief: Belief {
            hurdle: 3.0,
            scale: 2.5,
        },
        form_error: 0.15,
        ..Search::BASE
    },
};

impl Effect for Influx {
    fn about(&self) -> &'static About {
        &ABOUT
    }

    fn begin(&self, p: &[f64], _: &Setting) -> Action {
        let (rate, from, lasts, ramp) = (p[0], p[1], p[2].max(1.0), p[3].max(1e-3));
        Box::new(move |at, changes| {
            let x = (at.t_s - from) / lasts;
            let shape = (x / ramp).min((1.0 - x) / ramp).clamp(0.0, 1.0);
            changes.inflow_m3_s += rate * shape;
        })
    }

    fn same_as(&self, p: &[f64], _: &Setting) -> Option<String> {
        (p[0] >= PUMPED_M3_S).then(|| {
            let Legible { factor, unit, .. } = Legible::of(ABOUT.parameters[0].name);
            let rate = factor * p[0];
            format!("a pump of {rate:.0} {unit} that is not logged, or logged as stopped")
        })
    }

    fn memory_s(&self, _: &[f64]) -> f64 {
        0.0
    }
}
