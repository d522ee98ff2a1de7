//! Rig motion that modulates the pressures with the period of the swell.

use crate::{
    About, Action, Component, Effect, Excitation, Method, Parameter, Relation, Role, Search,
    Setting,
};

/// See the module.
pub(super) struct Heave;

static ABOUT: About = About {
    id: "heave",
    title: "rig motion modulates the pressures",
    component: Component::Boundary,
    relation: Relation::PumpHead,
    equation_without: Some("p_in = p"),
    equation: "p_in = p + rho g a cos(2 pi t / T)",
    source: "hydrostatic pressure of a column that moves as a rigid body",
    excited_by: "sampling faster than half the period",
    confusable: &[],
    parameters: &[
        Parameter {
            name: "period_s",
            meaning: "period of the motion",
            role: Role::Grid(&[]),
            low: 3.0,
            high: 30.0,
            usual: 10.0,
            ..Parameter::BASE
        },
        Parameter {
            name: "amplitude_m",
            meaning: "amplitude, metres of mud",
            role: Role::Shape(&[]),
            low: 0.0,
            high: 20.0,
            usual: 0.5,
            ..Parameter::BASE
        },
    ],
    search: Search {
        method: Method::Spectrum,
        needs: &[Excitation::FastSampling],
        ..Search::BASE
    },
};

impl Effect for Heave {
    fn about(&self) -> &'static About {
        &ABOUT
    }

    fn begin(&self, _: &[f64], _: &Setting) -> Action {
        // Its phase wanders from wave to wave: it changes the spectrum of the pressures, not their course.
        Box::new(|_, _| {})
    }

    fn memory_s(&self, _: &[f64]) -> f64 {
        0.0
    }
}
