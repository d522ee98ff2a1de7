//! Mud lost to the formation, driven by pressure, from some time on.

use crate::passing::Passing;
use crate::{About, Action, Belief, Component, Effect, Parameter, Relation, Role, Search, Setting};

/// See the module.
pub(super) struct LostCirculation;

const PARAMETERS: [Parameter; 3] = [
    Parameter {
        name: "J_m3_s_pa",
        meaning: "loss rate per unit of pressure above the fracture pressure",
        role: Role::Amplitude,
        low: 0.0,
        high: 1e-5,
        usual: 1.5e-8,
        ..Parameter::BASE
    },
    Parameter::ONSET,
    Parameter {
        name: "fracture",
        meaning: "fracture pressure: 0 the lowest, 1 the highest inlet pressure recorded",
        role: Role::Shape(&[-1.0, -0.1, 0.3]),
        low: -30.0,
        high: 0.95,
        usual: 0.0,
        ..Parameter::BASE
    },
];

static ABOUT: About = About {
    id: "lost_circulation",
    title: "mud is lost to the formation, driven by pressure",
    component: Component::Boundary,
    relation: Relation::RiserMassBalance,
    equation_without: None,
    equation: "A dh/dt = q_in - J max(p_in - p_frac, 0) - q",
    source: "loss in proportion to the overpressure; fracture pressure: Bourgoyne et al. 1986",
    excited_by: "riser level that moves after the onset",
    confusable: &[
        (
            "inflow_gain",
            "stop the mud pump: a loss continues, a gain does not",
        ),
        (
            "line_leak",
            "check head and line friction: a leak changes both",
        ),
        (
            "return_flow_gain",
            "stop all pumps and observe the level: a loss continues, a meter gain does not",
        ),
    ],
    parameters: &PARAMETERS,
    search: Search {
        form_error: 0.15,
        size_error: 0.05,
        belief: Belief {
            hurdle: 4.0,
            scale: 3.0,
        },
        ..Search::BASE
    },
};

static PASSING: Passing = Passing {
    lasting: &LostCirculation,
    about: &About {
        title: "mud is lost to the formation, driven by pressure, until the losses cease",
        parameters: &[
            PARAMETERS[0],
            PARAMETERS[1],
            PARAMETERS[2],
            Parameter::LASTS,
        ],
        ..ABOUT
    },
};

impl Effect for LostCirculation {
    fn about(&self) -> &'static About {
        &ABOUT
    }

    fn passing(&self) -> Option<&'static dyn Effect> {
        Some(&PASSING)
    }

    fn begin(&self, p: &[f64], setting: &Setting) -> Action {
        let (index, onset) = (p[0], p[1]);
        let (low, high) = setting.inlet_range_pa;
        let fracture = low + p[2] * (high - low);
        Box::new(move |at, changes| {
            if at.t_s >= onset && at.inlet_pa.is_finite() {
                changes.inflow_m3_s -= index * (at.inlet_pa - fracture).max(0.0);
            }
        })
    }

    fn ranged(&self, p: &[f64], from: (f64, f64), to: (f64, f64)) -> Option<Vec<f64>> {
        let fracture = from.0 + p[2] * (from.1 - from.0);
        let share = (fracture - to.0) / (to.1 - to.0);
        share.is_finite().then(|| vec![p[0], p[1], share])
    }

    fn is_switch(&self) -> bool {
        true
    }
}
