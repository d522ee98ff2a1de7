//! A booster line that stores mud, so that its outflow lags.

use crate::moment::Lag;
use crate::shrunk;
use crate::{
    About, Action, Belief, Component, Effect, Excitation, Parameter, Relation, Role, Search,
    Setting,
};

/// See the module.
pub(super) struct BoosterLineStorage;

static ABOUT: About = About {
    id: "booster_line_storage",
    title: "the booster line stores mud and releases it late",
    component: Component::Line,
    relation: Relation::RiserMassBalance,
    equation_without: Some("q_out = q_booster"),
    equation: "tau dq_out/dt = q_booster - q_out",
    source: "Slettebø 2015, Eqs. 2.30 and 2.38, reduced to one time constant",
    excited_by: "starts and stops of the booster pump",
    confusable: &[("u_tube", "step the booster flow alone")],
    parameters: &[Parameter {
        name: "tau_s",
        meaning: "time constant of the line",
        role: Role::Grid(&[
            3.0, 5.0, 8.0, 12.0, 17.0, 23.0, 30.0, 38.0, 48.0, 60.0, 80.0,
        ]),
        low: 0.0,
        high: 400.0,
        usual: 25.0,
        ..Parameter::BASE
    }],
    search: Search {
        least: Some(5.0),
        form_error: 0.1,
        size_error: 0.06,
        needs: &[Excitation::BoosterSteps],
        allowance: &[1.5, 3.0, 4.5],
        belief: Belief {
            hurdle: 4.0,
            scale: 3.0,
        },
        ..Search::BASE
    },
};

impl Effect for BoosterLineStorage {
    fn about(&self) -> &'static About {
        &ABOUT
    }

    fn begin(&self, p: &[f64], setting: &Setting) -> Action {
        let mut lag = Lag::new(p[0]);
        let noise = setting.noise.booster_m3_s;
        Box::new(move |at, changes| {
            let behind = lag.step(at.booster_m3_s, at.dt_s) - at.booster_m3_s;
            changes.inflow_m3_s += shrunk(behind, noise);
        })
    }

    fn memory_s(&self, p: &[f64]) -> f64 {
        Lag::memory_s(p[0])
    }
}
