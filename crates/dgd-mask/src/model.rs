//! The identified model as percentages.

use dgd_identify::{Estimate, Model};
use dgd_units::{MaskReferences, STANDARD_GRAVITY_M_S2};

/// A model that may be passed on: flow, friction, head and level in percent.
#[derive(Debug, Clone, PartialEq)]
pub struct MaskedModel {
    /// Terms of the friction law, % of friction by % of flow.
    pub friction: Vec<MaskedTerm>,
    /// Root mean square of the friction fit, %.
    pub friction_rmse_pct: f64,
    /// c0, c1, c2: % of head by % of speed and % of flow.
    pub pump: [MaskedEstimate; 3],
    /// Exponent of the speed.
    pub n0: f64,
    /// Exponent of the flow.
    pub n2: f64,
    /// Root mean square of the head fit, %.
    pub head_rmse_pct: f64,
    /// How late the flow meter is, s.
    pub delay_s: f64,
    /// Level change a second and percent of net outflow: `dh/dt = rate (q - q_in)`, 1/s (Eq. 3.45).
    pub level_rate_per_s: f64,
    /// `H = level_in_head h + friction_in_head F + depth_in_head_pct` in steady flow (Eq. 4.2), all in percent.
    pub level_in_head: f64,
    /// See [`Self::level_in_head`].
    pub friction_in_head: f64,
    /// By how much the pump's outlet lies deeper than its inlet, % of head; 0 for a pump with both at one depth, as in the thesis.
    ///
    /// It is in the recording too, which gives the other three terms of this balance.
    pub depth_in_head_pct: f64,
    /// Samples the model was identified from.
    pub kept: usize,
}

/// A masked coefficient with its standard error.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MaskedEstimate {
    /// Its value.
    pub value: f64,
    /// Its standard error; `None` if it was held.
    pub standard_error: Option<f64>,
}

/// A masked term of the friction law.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MaskedTerm {
    /// Power of the flow.
    pub power: u8,
    /// Coefficient, %/%^power.
    pub coefficient: MaskedEstimate,
}

/// Masks an identified model (Eqs. 3.9-3.12 applied to 3.26, 3.39, 3.45 and 4.2).
pub fn mask_model(model: &Model, references: &MaskReferences) -> MaskedModel {
    let weight_pa_m = model.density_kg_m3 * STANDARD_GRAVITY_M_S2;
    let scaled = |estimate: &Estimate, scale: &dyn Fn(f64) -> f64| MaskedEstimate {
        value: scale(estimate.value),
        standard_error: estimate.standard_error.map(scale),
    };
    let term = |term: &dgd_identify::FrictionTerm| MaskedTerm {
        power: term.power,
        coefficient: scaled(&term.coefficient, &|c| {
            references.mask_friction_coefficient(c, f64::from(term.power))
        }),
    };
    let head = |estimate: &Estimate, power: f64| {
        scaled(estimate, &|c| references.mask_head_coefficient(c, power))
    };
    let pump = &model.pump;
    let unit_flow_m3_s = references.unmask_flow(1.0);
    MaskedModel {
        friction: model.friction.terms.iter().map(term).collect(),
        friction_rmse_pct: references.mask_friction(model.friction.mse_pa2.sqrt()),
        pump: [
            head(&pump.c0, 0.0),
            head(&pump.c1, 1.0),
            head(&pump.c2, pump.n2),
        ],
        n0: pump.n0,
        n2: pump.n2,
        head_rmse_pct: references.mask_head(pump.mse_m2.sqrt()),
        delay_s: model.delay_s,
        level_rate_per_s: references.mask_level(unit_flow_m3_s / model.geometry.riser_area_m2()),
        level_in_head: references.mask_head(references.unmask_level(1.0)),
        friction_in_head: references.mask_head(references.unmask_friction(1.0) / weight_pa_m),
        depth_in_head_pct: references
            .mask_head(model.geometry.pump_outlet_depth_m - model.geometry.pump_inlet_depth_m),
        kept: model.data.kept,
    }
}
