//! A mud pump flow, counted from strokes, that is off in proportion.
//!
//! The parameter is carried as the gain less 1, so that 0 changes nothing; it is reported as the gain.

use super::return_flow_gain::gallons;
use crate::{
    About, Action, Belief, Component, Effect, Parameter, Relation, Role, Search, Setting, Shown,
};

/// See the module.
pub(super) struct InflowGain;

static ABOUT: About = About {
    id: "inflow_gain",
    title: "the mud pump flow (from strokes) has a proportional error",
    component: Component::Instrument,
    relation: Relation::RiserMassBalance,
    equation_without: Some("q_meter = q_mud_pump"),
    equation: "q_meter = gain q_mud_pump",
    source: "volumetric efficiency of piston pumps: Bourgoyne et al. 1986, on the circulating system",
    excited_by: "mud pump flow that changes while other inflows do not",
    confusable: &[
        (
            "return_flow_gain",
            "run the booster alone: the mud pump then cannot be at fault",
        ),
        (
            "lost_circulation",
            "stop the mud pump: a loss continues, a gain does not",
        ),
        (
            "line_leak",
            "check head and line friction: a leak changes both, an inflow gain changes neither",
        ),
    ],
    parameters: &[Parameter {
        name: "gain",
        meaning: "reading over truth",
        role: Role::Amplitude,
        low: -0.8,
        high: 1.0,
        usual: 0.03,
        shown: Shown::Gain,
        ..Parameter::BASE
    }],
    search: Search {
        least: Some(6e-3),
        belief: Belief {
            hurdle: 6.0,
            scale: 3.0,
        },
        ..Search::BASE
    },
};

impl Effect for InflowGain {
    fn about(&self) -> &'static About {
        &ABOUT
    }

    fn begin(&self, p: &[f64], _: &Setting) -> Action {
        let excess = 1.0 / (1.0 + p[0]) - 1.0;
        Box::new(move |at, changes| changes.inflow_m3_s += excess * at.mud_pump_m3_s)
    }

    fn same_as(&self, p: &[f64], _: &Setting) -> Option<String> {
        /// Less than a liner of 7 inches displaces beside one a quarter of an inch wider, as a share.
        const NEXT_LINER: f64 = 0.07;
        let gain = 1.0 + p[0];
        // A stroke displaces the area of its liner.
        let wider = 100.0 * (gain.sqrt() - 1.0);
        let side = if wider > 0.0 { "wider" } else { "narrower" };
        let liner = (p[0].abs() > NEXT_LINER).then(|| {
            let share = wider.abs();
            format!("strokes counted for liners {share:.1} % {side} than those in the pump")
        });
        match (liner, gallons(gain)) {
            (Some(liner), Some(gallons)) => Some(format!("{liner}; or {gallons}")),
            (liner, gallons) => liner.or(gallons.map(str::to_owned)),
        }
    }

    fn memory_s(&self, _: &[f64]) -> f64 {
        0.0
    }
}
