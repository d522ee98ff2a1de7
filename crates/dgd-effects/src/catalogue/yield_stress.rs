//! A yield-stress mud: friction does not vanish with the flow, and standing mud shows none of it.

use crate::{
    About, Action, Belief, Component, Effect, Parameter, Relation, Role, STANDING_M3_S, Search,
    Setting,
};

/// See the module.
pub(super) struct YieldStress;

static ABOUT: About = About {
    id: "yield_stress",
    title: "friction does not vanish as the flow goes to zero",
    component: Component::Line,
    relation: Relation::ReturnLineFriction,
    equation_without: Some("dp = 0"),
    equation: "dp = dp_0 / (1 + q/q_f), 0 at rest; dp_0 = 16 tau_y L / (3 d)",
    source: "Herschel and Bulkley 1926; Buckingham 1921 for 16/3, the asymptote of laminar flow (at the onset it is 4); the fading with flow is empirical",
    excited_by: "low flow, high flow and pump stops",
    confusable: &[(
        "outlet_pressure_bias",
        "stop the pump: a bias stays, a yield stress vanishes",
    )],
    parameters: &[
        Parameter {
            name: "drop_pa",
            meaning: "laminar friction, extrapolated to zero flow",
            role: Role::Amplitude,
            low: 0.0,
            high: 1e6,
            usual: 3e4,
            ..Parameter::BASE
        },
        Parameter {
            name: "fade",
            meaning: "flow at which turbulence has halved it, as a share of that at 3.5 m/s in the line",
            role: Role::Shape(&[0.3, 1.0, 10.0, 40.0]),
            low: 0.05,
            high: 100.0,
            usual: 1.0,
            ..Parameter::BASE
        },
    ],
    search: Search {
        belief: Belief {
            hurdle: 6.0,
            scale: 2.0,
        },
        form_error: 0.15,
        size_error: 0.15,
        ..Search::BASE
    },
};

impl Effect for YieldStress {
    fn about(&self) -> &'static About {
        &ABOUT
    }

    fn begin(&self, p: &[f64], setting: &Setting) -> Action {
        let drop = p[0];
        // A pipe of this bore carries about 3.5 m/s at the most.
        let fade = p[1] * 3.5 * setting.line_area_m2;
        Box::new(move |at, changes| {
            let q = at.flow_m3_s.max(0.0);
            let moving = (q / STANDING_M3_S).min(1.0);
            changes.line_drop_pa += drop * moving / (1.0 + q / fade);
        })
    }

    fn memory_s(&self, _: &[f64]) -> f64 {
        0.0
    }
}
