//! Every channel as a percentage, dithered over its transmitter's step.

use crate::references::secret_generator;
use dgd_identify::{Prepared, Series};
use dgd_recording::{Recording, quantum};
use dgd_units::MaskReferences;
use rand::{Rng, RngExt};

/// A recording that may be passed on: percentages and seconds from its start.
///
/// All series have the length of `time_s`; NaN where nothing can be trusted.
#[derive(Debug, Clone, PartialEq)]
pub struct MaskedRecording {
    /// Seconds from the start.
    pub time_s: Vec<f64>,
    /// q_p, % of the flow reference.
    pub mud_pump_flow_pct: Vec<f64>,
    /// q_bp, % of the flow reference.
    pub booster_flow_pct: Vec<f64>,
    /// q_tf, % of the flow reference.
    pub topfill_flow_pct: Vec<f64>,
    /// q_MRL, % of the flow reference.
    pub return_flow_pct: Vec<f64>,
    /// F_MRL, % of the friction reference (Eq. 3.9).
    pub friction_pct: Vec<f64>,
    /// ΔH, % of the head reference (Eq. 3.11).
    pub head_pct: Vec<f64>,
    /// h_r, % of the level reference (Eq. 3.12).
    pub level_pct: Vec<f64>,
    /// ω, % of full speed as recorded.
    pub pump_speed_pct: Vec<f64>,
    /// Samples that identification may use.
    pub keep: Vec<bool>,
}

impl MaskedRecording {
    /// Every series with its name, time first.
    pub fn columns(&self) -> [(&'static str, &[f64]); 9] {
        [
            ("t", &self.time_s),
            ("mud_pump_flow", &self.mud_pump_flow_pct),
            ("booster_flow", &self.booster_flow_pct),
            ("topfill_flow", &self.topfill_flow_pct),
            ("return_flow", &self.return_flow_pct),
            ("friction", &self.friction_pct),
            ("pump_head", &self.head_pct),
            ("riser_level", &self.level_pct),
            ("pump_speed", &self.pump_speed_pct),
        ]
    }
}

/// Masks a screened recording.
///
/// - `series`: level, friction and head of the same recording.
///
/// Flows are blanked where they are beyond twice the reference: an instrument's full
/// scale is a number that people know.
pub fn mask_recording(
    prepared: &Prepared,
    series: &Series,
    references: &MaskReferences,
) -> MaskedRecording {
    let recording = &prepared.recording;
    let mut random = secret_generator(recording, b"dither");
    let mut flow = |values: &[f64]| {
        let step = quantum(values).unwrap_or(0.0);
        let masked = values
            .iter()
            .map(|v| references.mask_flow(*v))
            .map(|p| if p.abs() > 200.0 { f64::NAN } else { p });
        dithered(masked.collect(), references.mask_flow(step), &mut random)
    };
    let mud_pump_flow_pct = flow(&recording.mud_pump_flow_m3_s);
    let booster_flow_pct = flow(&recording.booster_flow_m3_s);
    let topfill_flow_pct = flow(&recording.topfill_flow_m3_s);
    let return_flow_pct = flow(&recording.return_flow_m3_s);
    let step_pa = pressure_step_pa(recording);
    // A metre of mud in Pa is what friction and head differ by; the steps of level and head follow from their own
    // series, which are the pressures' but for that factor.
    let mut derived = |values: &[f64], mask: &dyn Fn(f64) -> f64, step: f64| {
        dithered(
            values.iter().map(|v| mask(*v)).collect(),
            mask(step),
            &mut random,
        )
    };
    let weight_pa_m = weight_pa_m(prepared, series);
    let friction_pct = derived(
        &series.friction_pa,
        &|v| references.mask_friction(v),
        step_pa,
    );
    let head_pct = derived(
        &series.head_m,
        &|v| references.mask_head(v),
        step_pa / weight_pa_m,
    );
    let level_pct = derived(
        &series.level_m,
        &|v| references.mask_level(v),
        step_pa / weight_pa_m,
    );
    let first = recording.time_s.first().copied().unwrap_or(0.0);
    MaskedRecording {
        time_s: recording.time_s.iter().map(|t| t - first).collect(),
        mud_pump_flow_pct,
        booster_flow_pct,
        topfill_flow_pct,
        return_flow_pct,
        friction_pct,
        head_pct,
        level_pct,
        pump_speed_pct: recording.pump_speed_pct.clone(),
        keep: prepared.keep.clone(),
    }
}

/// Coarsest step of the pressure transmitters, Pa.
fn pressure_step_pa(recording: &Recording) -> f64 {
    let sides = recording
        .pump_inlet_pressure_pa
        .iter()
        .chain(&recording.pump_outlet_pressure_pa);
    sides
        .filter_map(|values| quantum(values))
        .fold(0.0, f64::max)
}

/// ρg, Pa/m, out of the series themselves: inlet pressure against level.
fn weight_pa_m(prepared: &Prepared, series: &Series) -> f64 {
    let inlet = &prepared.inlet_pressure_pa;
    let pairs = || {
        inlet
            .iter()
            .zip(&series.level_m)
            .filter(|(p, _)| p.is_finite())
    };
    let far = |a: (&f64, &f64), b: (&f64, &f64)| (a.0 - b.0).abs() > 1.0;
    let Some(first) = pairs().next() else {
        return f64::INFINITY;
    };
    let other = pairs().find(|pair| far(first, *pair));
    other.map_or(f64::INFINITY, |(p, h)| (p - first.0) / (first.1 - h))
}

/// Adds noise uniform over one step: the mean stays, the steps are gone.
fn dithered(mut values: Vec<f64>, step: f64, random: &mut impl Rng) -> Vec<f64> {
    for value in &mut values {
        // Drawn for missing values too, so that a gap does not shift the rest.
        *value += step * (random.random::<f64>() - 0.5);
    }
    values
}
