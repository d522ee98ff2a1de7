//! A riser annulus of another area than the well file says.
//!
//! The parameter is carried as x, the excess over the well file relative to it, so that 0 changes nothing; it is reported as
//! an area.

use crate::{
    About, Action, Belief, Component, Effect, Parameter, Relation, Role, Search, Setting, Shown,
};

/// See the module.
pub(super) struct AnnulusArea;

static ABOUT: About = About {
    id: "annulus_area",
    title: "the riser annulus area differs from the well file",
    component: Component::Tank,
    relation: Relation::RiserMassBalance,
    equation_without: None,
    equation: "(1 + x) A dh/dt = q_in - q",
    source: "Slettebø 2015, Eq. 3.45",
    excited_by: "level that moves",
    confusable: &[
        (
            "return_flow_gain",
            "hold the level: an area error shows only while the level moves",
        ),
        (
            "u_tube",
            "move the level while the mud pump runs steadily: an area error shows, a draining string does not",
        ),
        (
            "booster_line_storage",
            "move the level while the booster runs steadily: an area error shows, a storing line does not",
        ),
    ],
    parameters: &[Parameter {
        name: "area_m2",
        meaning: "true area of the riser annulus",
        role: Role::Amplitude,
        low: -0.85,
        high: 1.5,
        usual: 0.1,
        shown: Shown::RiserArea,
        ..Parameter::BASE
    }],
    search: Search {
        belief: Belief {
            hurdle: 8.0,
            scale: 4.0,
        },
        least: Some(0.02),
        ..Search::BASE
    },
};

impl Effect for AnnulusArea {
    fn about(&self) -> &'static About {
        &ABOUT
    }

    fn begin(&self, p: &[f64], _: &Setting) -> Action {
        let factor = 1.0 + p[0];
        Box::new(move |_, changes| changes.area_factor *= factor)
    }

    fn same_as(&self, p: &[f64], setting: &Setting) -> Option<String> {
        /// Share by which the density of a mud that is described at all may be off.
        const DESCRIBED: f64 = 0.2;
        // A pressure stands for a height by the density, and for a volume by the area.
        let rho = setting.density_kg_m3;
        let off = p[0].abs() < DESCRIBED && rho.is_finite();
        off.then(|| {
            let told = rho / (1.0 + p[0]);
            format!("mud of {told:.0} kg/m3 in the riser, described as {rho:.0}")
        })
    }

    fn memory_s(&self, _: &[f64]) -> f64 {
        0.0
    }
}
