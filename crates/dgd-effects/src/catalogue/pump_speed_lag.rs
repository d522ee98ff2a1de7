//! A pump that follows its set-point with a lag.

use crate::moment::Lag;
use crate::shrunk;
use crate::{
    About, Action, Belief, Component, Effect, Parameter, Relation, Role, Search, Setting, Timing,
};

/// See the module.
pub(super) struct PumpSpeedLag;

static ABOUT: About = About {
    id: "pump_speed_lag",
    title: "the pump follows its set-point late",
    component: Component::Pump,
    relation: Relation::PumpHead,
    equation_without: Some("w = w_set"),
    equation: "tau dw/dt = w_set - w",
    source: "drive and rotor inertia",
    excited_by: "changes of pump speed",
    confusable: &[(
        "return_flow_delay",
        "compare outlet pressure with speed: a late pump delays both, a late meter only the flow",
    )],
    parameters: &[Parameter {
        name: "tau_s",
        meaning: "time constant",
        role: Role::Grid(&[
            1.0, 2.0, 3.0, 4.5, 6.0, 8.0, 10.0, 13.0, 16.0, 20.0, 25.0, 32.0, 40.0,
        ]),
        low: 0.0,
        high: 240.0,
        usual: 12.0,
        ..Parameter::BASE
    }],
    search: Search {
        belief: Belief {
            hurdle: 7.0,
            scale: 4.0,
        },
        least: Some(4.0),
        allowance: &[1.0, 2.0, 3.0],
        timing: Some(Timing::Pump),
        size_error: 0.1,
        ..Search::BASE
    },
};

impl Effect for PumpSpeedLag {
    fn about(&self) -> &'static About {
        &ABOUT
    }

    fn begin(&self, p: &[f64], setting: &Setting) -> Action {
        let mut lag = Lag::new(p[0]);
        let noise = setting.noise.speed_pct;
        Box::new(move |at, changes| {
            let behind = lag.step(at.speed_pct, at.dt_s) - at.speed_pct;
            changes.speed_pct += shrunk(behind, noise);
        })
    }

    fn memory_s(&self, p: &[f64]) -> f64 {
        Lag::memory_s(p[0])
    }
}
