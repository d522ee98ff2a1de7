//! U-tubing: the drill string gives its mud late.

use crate::moment::Lag;
use crate::shrunk;
use crate::{
    About, Action, Belief, Component, Effect, Excitation, Extent, Parameter, Relation, Role,
    Search, Setting,
};

/// See the module.
pub(super) struct UTube;

static ABOUT: About = About {
    id: "u_tube",
    title: "the drill string drains after the mud pump slows and fills when it starts",
    component: Component::Line,
    relation: Relation::RiserMassBalance,
    equation_without: Some("q_string = q_mud_pump"),
    equation: "tau dq_string/dt = q_mud_pump - q_string",
    source: "Slettebø 2015, Eqs. 2.29 and 2.34, reduced to one time constant",
    excited_by: "starts and stops of the mud pump",
    confusable: &[
        ("booster_line_storage", "step the booster alone"),
        ("pipe_displacement", "a connection without moving pipe"),
    ],
    parameters: &[Parameter {
        name: "tau_s",
        meaning: "time constant of the string",
        role: Role::Grid(&[
            3.0, 5.0, 8.0, 12.0, 18.0, 24.0, 32.0, 42.0, 55.0, 70.0, 90.0, 120.0,
        ]),
        low: 0.0,
        high: 600.0,
        usual: 40.0,
        ..Parameter::BASE
    }],
    extent: Extent::Always,
    search: Search {
        least: Some(7.5),
        form_error: 0.1,
        size_error: 0.1,
        needs: &[Excitation::Connections],
        allowance: &[1.0, 2.0, 3.0, 4.0],
        belief: Belief {
            hurdle: 6.0,
            scale: 4.0,
        },
        ..Search::BASE
    },
};

impl Effect for UTube {
    fn about(&self) -> &'static About {
        &ABOUT
    }

    fn begin(&self, p: &[f64], setting: &Setting) -> Action {
        let mut lag = Lag::new(p[0]);
        let noise = setting.noise.mud_pump_m3_s;
        Box::new(move |at, changes| {
            let behind = lag.step(at.mud_pump_m3_s, at.dt_s) - at.mud_pump_m3_s;
            changes.inflow_m3_s += shrunk(behind, noise);
        })
    }

    fn memory_s(&self, p: &[f64]) -> f64 {
        Lag::memory_s(p[0])
    }
}
