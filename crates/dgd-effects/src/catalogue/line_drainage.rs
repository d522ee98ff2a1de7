//! A return line that drains back into the riser while the pump is off, until the pressures beside the pump meet, and
//! that the pump fills again before any mud returns.

use crate::{
    About, Action, Belief, Component, Effect, Excitation, Parameter, Relation, Role, STANDING_M3_S,
    Search, Setting,
};
use dgd_units::{STANDARD_ATMOSPHERE_PA, STANDARD_GRAVITY_M_S2};

/// See the module.
pub(super) struct LineDrainage;

static ABOUT: About = About {
    id: "line_drainage",
    title: "the return line drains while the pump is off",
    component: Component::Line,
    relation: Relation::ReturnLineFriction,
    equation_without: Some("z = 0"),
    equation: "dz/dt = rate s^taper at rest, s = (L - z - h) / (L - h_usual); dz/dt = -q / A as the pump fills it; p_out loses rho g z",
    source: "backflow through a pump whose check valve leaks; Torricelli for a taper of 0.5, Hagen-Poiseuille for 1",
    excited_by: "pump stops",
    confusable: &[(
        "gel_strength",
        "check the pressure at rest: it falls when the line drains",
    )],
    parameters: &[
        Parameter {
            name: "rate_m_s",
            meaning: "rate of fall of the mud surface from a full line, at the usual riser level",
            role: Role::Amplitude,
            low: 0.0,
            high: 2.0,
            usual: 0.1,
            ..Parameter::BASE
        },
        Parameter {
            name: "taper",
            meaning: "how the rate depends on the driving head: 0 not at all, 0.5 as through an orifice, 1 as through a narrow gap",
            role: Role::Shape(&[0.0, 0.5, 1.0]),
            low: 0.0,
            high: 1.5,
            usual: 0.0,
            ..Parameter::BASE
        },
        Parameter {
            name: "prompt_s",
            meaning: "time in which the closed valve would leak the volume that passes while it closes",
            role: Role::Shape(&[0.0, 60.0, 300.0]),
            low: 0.0,
            high: 1800.0,
            usual: 60.0,
            ..Parameter::BASE
        },
    ],
    search: Search {
        needs: &[Excitation::PumpStops],
        // A hand's breadth a minute: a surface that settles, not one that drains.
        least: Some(2e-3),
        form_error: 0.15,
        size_error: 0.02,
        stand_error: Some(0.3),
        belief: Belief {
            hurdle: 14.0,
            scale: 3.0,
        },
        ..Search::BASE
    },
};

impl Effect for LineDrainage {
    fn about(&self) -> &'static About {
        &ABOUT
    }

    fn begin(&self, p: &[f64], setting: &Setting) -> Action {
        let (rate, taper, prompt_s) = (p[0], p[1], p[2]);
        let area = setting.line_area_m2;
        let weight = setting.density_kg_m3 * STANDARD_GRAVITY_M_S2;
        let length = setting.line_length_m;
        let usual = (length - setting.riser_volume_m3 / setting.riser_area_m2).max(1.0);
        let mut fall = 0.0_f64;
        let mut resting = false;
        Box::new(move |at, changes| {
            if at.pumping {
                resting = false;
                // A meter tells nothing of what fills the line, but when it is full.
                fall = if at.outflow_m3_s > STANDING_M3_S {
                    0.0
                } else {
                    (fall - at.flow_m3_s.max(0.0) * at.dt_s / area).max(0.0)
                };
            } else if at.inlet_pa.is_finite() {
                // Surface above the level at which the line would stand in balance with the riser.
                let level = (at.inlet_pa - STANDARD_ATMOSPHERE_PA) / weight;
                let left = ((length - level).min(length) - fall).max(0.0);
                let for_s = if resting { at.dt_s } else { at.dt_s + prompt_s };
                resting = true;
                let step = (rate * (left / usual).powf(taper) * for_s).min(left);
                fall += step;
                changes.inflow_m3_s += area * step / at.dt_s;
            }
            changes.line_fall_m += fall;
        })
    }
}
