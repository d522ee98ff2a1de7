//! Viscosity, and with it friction, drifts over hours.

use crate::{
    About, Action, Belief, Component, Effect, End, Parameter, Relation, Role, Search, Setting,
};

/// Viscosity of a drilling mud at pipe shear rates; the well file does not tell it.
const USUAL_VISCOSITY_PA_S: f64 = 0.02;
/// Roughness of commercial steel, 0.046 mm, over a bore of 6 in.
const USUAL_ROUGHNESS: f64 = 3e-4;

/// Darcy's friction factor: the greater of Haaland's, held below Re = 2000, and the laminar 64/Re.
fn haaland(reynolds: f64) -> f64 {
    let re = reynolds.max(1.0);
    let root = -1.8 * ((USUAL_ROUGHNESS / 3.7).powf(1.11) + 6.9 / re.max(2000.0)).log10();
    (64.0 / re).max(1.0 / (root * root))
}

/// See the module.
pub(super) struct ViscosityDrift;

static ABOUT: About = About {
    id: "viscosity_drift",
    title: "viscosity, and with it friction, drifts over hours",
    component: Component::Line,
    relation: Relation::ReturnLineFriction,
    equation_without: Some("F(q, t) = F(q)"),
    equation: "F(q, t) = F(q) f(Re(mu(t))) / f(Re(mu_0)), f by Haaland or 64/Re",
    source: "Haaland 1983; Slettebø 2015, Eqs. 2.21-2.24",
    excited_by: "hours of flow at several rates",
    confusable: &[
        (
            "line_restriction",
            "low flow: a restriction falls with the square of flow, viscous friction more slowly",
        ),
        (
            "mud_density_change",
            "stop the pump: a density change stays, friction vanishes",
        ),
    ],
    parameters: &[
        Parameter {
            name: "relative_mu_change",
            meaning: "relative change of viscosity at the end",
            role: Role::Amplitude,
            low: -0.97,
            high: 4.0,
            usual: 0.5,
            ..Parameter::BASE
        },
        Parameter {
            name: "bend",
            meaning: "0 even drift, positive slow at first, negative fast at first",
            role: Role::Shape(&[-0.5, 0.0, 0.7]),
            low: -0.9,
            high: 3.0,
            usual: 0.0,
            // What comes in the last quarter alone does not drift, it sets in.
            strange: Some(End::High),
            ..Parameter::BASE
        },
    ],
    search: Search {
        least: Some(0.05),
        form_error: 0.15,
        size_error: 0.5,
        belief: Belief {
            hurdle: 4.5,
            scale: 5.0,
        },
        flowing: true,
        ..Search::BASE
    },
};

impl Effect for ViscosityDrift {
    fn about(&self) -> &'static About {
        &ABOUT
    }

    fn begin(&self, p: &[f64], setting: &Setting) -> Action {
        let (change, power) = (p[0], 1.0 + p[1]);
        let (from, to) = setting.span_s;
        let (area, d) = (setting.line_area_m2, setting.line_diameter_m);
        let rho = setting.density_kg_m3;
        Box::new(move |at, changes| {
            let x = ((at.t_s - from) / (to - from).max(1.0))
                .max(0.0)
                .powf(power);
            let q = at.flow_m3_s.max(0.0);
            if q > 1e-4 {
                let reynolds = rho * q / area * d / USUAL_VISCOSITY_PA_S;
                let mu = (1.0 + change * x).max(0.03);
                changes.friction_factor *= haaland(reynolds / mu) / haaland(reynolds);
            }
        })
    }

    fn grown(&self, p: &[f64], times: f64) -> Option<Vec<f64>> {
        Some(vec![p[0] * times.max(0.0).powf(1.0 + p[1]), p[1]])
    }

    fn memory_s(&self, _: &[f64]) -> f64 {
        0.0
    }
}
