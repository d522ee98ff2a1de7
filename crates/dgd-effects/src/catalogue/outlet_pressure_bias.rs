//! A constant offset of the pump outlet pressure.

use crate::{About, Action, Belief, Component, Effect, Parameter, Relation, Role, Search, Setting};
use dgd_units::{STANDARD_ATMOSPHERE_PA, STANDARD_GRAVITY_M_S2};

/// See the module.
pub(super) struct OutletPressureBias;

static ABOUT: About = About {
    id: "outlet_pressure_bias",
    title: "the pump outlet pressure has a constant offset",
    component: Component::Instrument,
    relation: Relation::ReturnLineFriction,
    equation_without: Some("p_meter = p_out"),
    equation: "p_meter = p_out + bias",
    source: "Slettebø 2015, section 3.3.2 (the constant B of Eq. 3.26)",
    excited_by: "stretches with the pump stopped and stretches with flow",
    confusable: &[
        (
            "yield_stress",
            "stop the pump: a bias stays, a yield stress vanishes",
        ),
        (
            "outlet_pressure_bias_step",
            "check the redundant transmitter",
        ),
    ],
    parameters: &[Parameter {
        name: "bias_pa",
        meaning: "reading minus true value",
        role: Role::Amplitude,
        // No transmitter is off by so much, but a depth or a density in the description may be.
        low: -5e6,
        high: 5e6,
        usual: 4e4,
        ..Parameter::BASE
    }],
    search: Search {
        belief: Belief {
            hurdle: 24.0,
            scale: 5.0,
        },
        least: Some(1.05e4),
        size_error: 0.1,
        ..Search::BASE
    },
};

impl Effect for OutletPressureBias {
    fn about(&self) -> &'static About {
        &ABOUT
    }

    fn begin(&self, p: &[f64], _: &Setting) -> Action {
        let bias = p[0];
        Box::new(move |_, changes| {
            changes.outlet_bias_pa[0] += bias;
            changes.outlet_bias_pa[1] += bias;
        })
    }

    fn same_as(&self, p: &[f64], setting: &Setting) -> Option<String> {
        /// Share of an atmosphere within which an offset is one.
        const NEAR: f64 = 0.1;
        let bias = p[0];
        let (rho, length) = (setting.density_kg_m3, setting.line_length_m);
        let heavier = bias / (STANDARD_GRAVITY_M_S2 * length);
        let longer = bias / (STANDARD_GRAVITY_M_S2 * rho);
        if !heavier.is_finite() || !longer.is_finite() {
            return None;
        }
        let atmospheres = bias / STANDARD_ATMOSPHERE_PA;
        let gauge = if (atmospheres.abs() - 1.0).abs() > NEAR {
            ""
        } else if atmospheres < 0.0 {
            "gauge outlet transmitters described as absolute; or "
        } else {
            "absolute outlet transmitters described as gauge; or "
        };
        let more = if longer < 0.0 { "less" } else { "more" };
        let told = rho + heavier;
        let mud = if told > 0.0 {
            format!("mud of {told:.0} kg/m3 in the line, described as {rho:.0}; or ")
        } else {
            String::new()
        };
        Some(format!(
            "{gauge}{mud}{:.1} m {more} of the mud above the outlet than described",
            longer.abs()
        ))
    }

    fn memory_s(&self, _: &[f64]) -> f64 {
        0.0
    }
}
