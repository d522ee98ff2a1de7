//! A restriction in the return line from some time on.

use crate::passing::Passing;
use crate::{About, Action, Belief, Component, Effect, Parameter, Relation, Role, Search, Setting};

/// See the module.
pub(super) struct LineRestriction;

const PARAMETERS: [Parameter; 2] = [
    Parameter {
        name: "K",
        meaning: "loss coefficient on the velocity head of the line",
        role: Role::Amplitude,
        low: 0.0,
        high: 500.0,
        usual: 10.0,
        ..Parameter::BASE
    },
    Parameter::ONSET,
];

static ABOUT: About = About {
    id: "line_restriction",
    title: "a restriction appears in the return line",
    component: Component::Line,
    relation: Relation::ReturnLineFriction,
    equation_without: Some("dp = 0"),
    equation: "dp = K rho v^2 / 2",
    source: "minor losses: Crane TP-410",
    excited_by: "flow that changes after the onset, and a pump stop",
    confusable: &[
        (
            "mud_density_change",
            "stop the pump: a density change stays, a restriction vanishes",
        ),
        (
            "viscosity_drift",
            "low flow: a restriction falls with the square of flow, viscous friction more slowly",
        ),
    ],
    parameters: &PARAMETERS,
    search: Search {
        belief: Belief {
            hurdle: 9.0,
            scale: 5.0,
        },
        // On 1160 kg/m³ through 140 mm that costs 0.03 bar at 1800 L/min, 0.08 bar at 2800: transmitters wander by 0.05.
        least: Some(1.5),
        form_error: 0.1,
        flowing: true,
        ..Search::BASE
    },
};

static PASSING: Passing = Passing {
    lasting: &LineRestriction,
    about: &About {
        title: "a restriction appears in the return line, and goes",
        parameters: &[PARAMETERS[0], PARAMETERS[1], Parameter::LASTS],
        ..ABOUT
    },
};

impl Effect for LineRestriction {
    fn about(&self) -> &'static About {
        &ABOUT
    }

    fn passing(&self) -> Option<&'static dyn Effect> {
        Some(&PASSING)
    }

    fn begin(&self, p: &[f64], setting: &Setting) -> Action {
        let (k, onset) = (p[0], p[1]);
        let (rho, area) = (setting.density_kg_m3, setting.line_area_m2);
        Box::new(move |at, changes| {
            if at.t_s >= onset {
                let v = at.flow_m3_s / area;
                changes.line_drop_pa += 0.5 * k * rho * v * v.abs();
            }
        })
    }

    fn is_switch(&self) -> bool {
        true
    }
}
