//! Mud of another weight, which fills riser and line from some time on.

use crate::moment::{MIXING_LEAST, Stirred};
use crate::passing::Passing;
use crate::{
    About, Action, Belief, Component, Effect, End, Parameter, Relation, Role, Search, Setting,
};

/// See the module.
pub(super) struct MudDensityChange;

const PARAMETERS: [Parameter; 4] = [
    Parameter {
        name: "delta_rho_kg_m3",
        meaning: "new minus old density",
        role: Role::Amplitude,
        low: -400.0,
        high: 400.0,
        usual: 25.0,
        ..Parameter::BASE
    },
    Parameter {
        // Until the line shows it, and how it mixes on the way.
        time_error_s: 80.0,
        ..Parameter::ONSET
    },
    Parameter {
        name: "mixing",
        meaning: "mixed volume / mud volume in the riser",
        role: Role::Shape(&[0.25, 0.7]),
        low: 0.01,
        high: 2.0,
        usual: 0.7,
        // What is there at once has not been pumped through the riser, and what comes over hours has stirred more than that.
        strange: Some(End::Either),
        ..Parameter::BASE
    },
    Parameter {
        name: "column_share",
        meaning: "share of the mud above the pump inlet that changes density",
        role: Role::Shape(&[0.3, 1.0]),
        low: 0.05,
        high: 1.5,
        usual: 0.5,
        // What fills the line has come through the riser.
        strange: Some(End::Low),
        ..Parameter::BASE
    },
];

static ABOUT: About = About {
    id: "mud_density_change",
    title: "mud of a different density fills riser and line",
    component: Component::Tank,
    relation: Relation::ReturnLineFriction,
    equation_without: Some("rho = rho_0"),
    equation: "V d(rho)/dt = q (rho_in - rho); p_in gains (rho - rho_0) g V_column/A; p_out gains (rho - rho_0) g L",
    source: "stirred-tank mixing: Levenspiel 1999",
    excited_by: "any flow after the change; a pump stop shows the column alone",
    confusable: &[
        (
            "line_restriction",
            "stop the pump: a density change stays, a restriction vanishes",
        ),
        (
            "outlet_pressure_bias_step",
            "compare two outlet transmitters",
        ),
    ],
    parameters: &PARAMETERS,
    search: Search {
        belief: Belief {
            hurdle: 14.0,
            scale: 5.0,
        },
        least: Some(1.5),
        form_error: 0.15,
        size_error: 0.06,
        ..Search::BASE
    },
};

static PASSING: Passing = Passing {
    lasting: &MudDensityChange,
    about: &About {
        title: "mud of a different density fills riser and line, until the former comes back",
        parameters: &[
            PARAMETERS[0],
            PARAMETERS[1],
            PARAMETERS[2],
            PARAMETERS[3],
            Parameter::LASTS,
        ],
        ..ABOUT
    },
};

impl Effect for MudDensityChange {
    fn about(&self) -> &'static About {
        &ABOUT
    }

    fn passing(&self) -> Option<&'static dyn Effect> {
        Some(&PASSING)
    }

    fn begin(&self, p: &[f64], setting: &Setting) -> Action {
        let (step, onset) = (p[0], p[1]);
        let mut riser = Stirred::new(p[2] * setting.riser_volume_m3);
        let turned = p[3] / p[2].max(MIXING_LEAST);
        let mut line = Stirred::new(0.5 * setting.line_volume_m3());
        if onset <= setting.span_s.0 {
            // It was there before, and has mixed in.
            (riser.value, line.value) = (step, step);
        }
        Box::new(move |at, changes| {
            let entering = if at.t_s >= onset { step } else { 0.0 };
            let inflow = at.mud_pump_m3_s + at.booster_m3_s + at.topfill_m3_s;
            let leaving = riser.step(entering, inflow, at.dt_s);
            // Not all of what is stirred stands above the inlet, and what stands there need not be stirred by the flow.
            changes.entering_kg_m3 += leaving + turned * (entering - leaving);
            changes.riser_kg_m3 += leaving;
            changes.line_kg_m3 += line.step(leaving, at.flow_m3_s, at.dt_s);
        })
    }
}
