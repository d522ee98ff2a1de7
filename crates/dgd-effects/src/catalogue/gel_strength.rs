//! Gel that builds while the mud stands and breaks with the volume pumped on restart.

use crate::{
    About, Action, Belief, Component, Effect, End, Excitation, Parameter, Relation, Role,
    STANDING_M3_S, Search, Setting,
};

/// See the module.
pub(super) struct GelStrength;

static ABOUT: About = About {
    id: "gel_strength",
    title: "gel builds up in standing mud and breaks on restart",
    component: Component::Line,
    relation: Relation::ReturnLineFriction,
    equation_without: Some("dp = 0"),
    equation: "dp = s 4 tau L / d; at rest T ds/dt = 1 - s, in flow V_b ds/dt = -s q",
    source: "4 tau L / d: force balance on the plug, in field units in Lapeyrouse 2002; growth and breaking are empirical",
    excited_by: "restarts of the subsea pump after minutes of rest",
    confusable: &[(
        "line_drainage",
        "check the pressure at rest: it falls when the line drains",
    )],
    parameters: &[
        Parameter {
            name: "tau_gel_pa",
            meaning: "gel strength",
            role: Role::Amplitude,
            low: 0.0,
            high: 200.0,
            usual: 8.0,
            ..Parameter::BASE
        },
        Parameter {
            name: "broken",
            meaning: "pumped volume that breaks it to 1/e, as a share of the line volume",
            role: Role::Shape(&[0.08, 0.15, 0.3, 0.6]),
            low: 0.01,
            high: 3.0,
            usual: 0.2,
            // What breaks with three fillings of the line is no gel.
            strange: Some(End::High),
            ..Parameter::BASE
        },
        Parameter {
            name: "growth_s",
            meaning: "time constant of its growth at rest",
            role: Role::Shape(&[60.0, 300.0, 900.0]),
            low: 10.0,
            high: 7200.0,
            usual: 300.0,
            ..Parameter::BASE
        },
    ],
    search: Search {
        belief: Belief {
            hurdle: 4.0,
            scale: 4.0,
        },
        form_error: 0.15,
        size_error: 0.4,
        needs: &[Excitation::PumpStops],
        ..Search::BASE
    },
};

impl Effect for GelStrength {
    fn about(&self) -> &'static About {
        &ABOUT
    }

    fn begin(&self, p: &[f64], setting: &Setting) -> Action {
        let full = 4.0 * p[0] * setting.line_length_m / setting.line_diameter_m;
        let breaking = p[1] * setting.line_volume_m3();
        let growth = p[2];
        let mut gelled = 0.0_f64;
        Box::new(move |at, changes| {
            if at.flow_m3_s < STANDING_M3_S {
                gelled += (1.0 - (-at.dt_s / growth).exp()) * (1.0 - gelled);
            } else if at.flow_m3_s.is_finite() {
                changes.line_drop_pa += full * gelled;
                gelled *= (-at.flow_m3_s * at.dt_s / breaking).exp();
            }
        })
    }
}
