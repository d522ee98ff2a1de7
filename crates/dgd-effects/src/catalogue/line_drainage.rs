//! A return line that drains back into the riser while the pump is off.

use crate::{
    About, Action, Belief, Component, Effect, Excitation, Extent, Parameter, Relation, Role,
    Search, Setting,
};

/// See the module.
pub(super) struct LineDrainage;

static ABOUT: About = About {
    id: "line_drainage",
    title: "the return line drains while the pump is off",
    component: Component::Line,
    relation: Relation::ReturnLineFriction,
    equation: "dz/dt = rate at rest; p_out loses rho g z, the riser gains A_line dz/dt",
    source: "backflow through a pump without check valve",
    excited_by: "pump stops",
    confusable: &[(
        "gel_strength",
        "look at the pressure at rest: it falls when the line drains",
    )],
    parameters: &[Parameter {
        name: "rate_m_s",
        meaning: "fall of the mud surface",
        role: Role::Amplitude,
        low: 0.0,
        high: 2.0,
        usual: 0.1,
        ..Parameter::BASE
    }],
    extent: Extent::Always,
    search: Search {
        needs: &[Excitation::PumpStops],
        form_error: 0.15,
        belief: Belief {
            hurdle: 6.0,
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
        let rate = p[0];
        let (area, length) = (setting.line_area_m2, setting.line_length_m);
        let mut fall = 0.0_f64;
        Box::new(move |at, changes| {
            if at.pumping {
                if at.flow_m3_s > 1e-3 {
                    fall = 0.0;
                }
            } else {
                let step = (rate * at.dt_s).min((length - fall).max(0.0));
                fall += step;
                changes.inflow_m3_s += area * step / at.dt_s;
            }
            changes.line_fall_m += fall;
        })
    }
}
