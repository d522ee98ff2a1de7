//! A return line that loses mud before its meter from some time on.

use crate::passing::Passing;
use crate::{
    About, Action, Belief, Component, Effect, Parameter, Relation, Role, STANDING_M3_S, Search,
    Setting,
};
use dgd_units::STANDARD_ATMOSPHERE_PA;

/// See the module.
pub(super) struct LineLeak;

const PARAMETERS: [Parameter; 2] = [
    Parameter {
        name: "leak_m3_s",
        meaning: "leak rate at 10 bar above atmospheric",
        role: Role::Amplitude,
        low: 0.0,
        high: 0.05,
        usual: 0.0015,
        ..Parameter::BASE
    },
    Parameter::ONSET,
];

static ABOUT: About = About {
    id: "line_leak",
    title: "the return line loses mud before its meter",
    component: Component::Line,
    relation: Relation::RiserMassBalance,
    equation_without: Some("q_meter = q"),
    equation: "q_meter = q - C sqrt(p_out - p_0)",
    source: "orifice flow",
    excited_by: "flow and pressure on both sides of the onset",
    confusable: &[
        (
            "lost_circulation",
            "check head and line friction: a leak changes both",
        ),
        ("return_flow_gain", "check the time before the onset"),
    ],
    parameters: &PARAMETERS,
    search: Search {
        // At 50 bar half a percent of 2,700 L/min, within which a meter may wander.
        least: Some(1e-4),
        belief: Belief {
            hurdle: 7.0,
            scale: 5.0,
        },
        form_error: 0.15,
        size_error: 0.15,
        flowing: true,
        ..Search::BASE
    },
};

static PASSING: Passing = Passing {
    lasting: &LineLeak,
    about: &About {
        title: "the return line loses mud before its meter for a while",
        parameters: &[PARAMETERS[0], PARAMETERS[1], Parameter::LASTS],
        ..ABOUT
    },
};

impl Effect for LineLeak {
    fn about(&self) -> &'static About {
        &ABOUT
    }

    fn passing(&self) -> Option<&'static dyn Effect> {
        Some(&PASSING)
    }

    fn begin(&self, p: &[f64], _: &Setting) -> Action {
        let (leak, onset) = (p[0], p[1]);
        Box::new(move |at, changes| {
            if at.t_s >= onset && at.flow_m3_s > STANDING_M3_S {
                let over = (at.outlet_pa - STANDARD_ATMOSPHERE_PA).max(0.0) / 1e6;
                changes.leak_m3_s += leak * over.sqrt();
            }
        })
    }

    fn same_as(&self, _: &[f64], _: &Setting) -> Option<String> {
        Some("a return flow meter that reads less in that time; compare it with what is pumped in while the level stands".to_owned())
    }

    fn is_switch(&self) -> bool {
        true
    }
}
