//! Every channel as a percentage, its transmitter's step hidden by noise.

use crate::MaskingError;
use crate::dither::{flicker, share};
use dgd_identify::{Prepared, Series};
use dgd_units::MaskReferences;

/// A recording that may be passed on: percentages and seconds from its start.
///
/// All series have the length of `time_s`; NaN where nothing can be trusted.
#[derive(Debug, Clone, PartialEq)]
pub struct MaskedRecording {
    /// Seconds from the start.
    pub time_s: Vec<f64>,
    /// q_in = q_p + q_bp + q_tf, % of the flow reference.
    pub inflow_pct: Vec<f64>,
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
    pub fn columns(&self) -> [(&'static str, &[f64]); 7] {
        [
            ("t", &self.time_s),
            ("inflow", &self.inflow_pct),
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
/// What no usable sample shows is left out: a meter at its full scale or a dead transmitter reads a number that people know.
/// Flows are also blanked beyond twice the reference. Of the flows into the riser only the sum is told,
/// which is all that the model reads (Eq. 3.45): a topfill that rests on a round number
/// would be a guess away from the reference.
///
/// # Errors
/// [`MaskingError::Prepared`] or [`MaskingError::Length`] if the two are not of one length.
pub fn mask_recording(
    prepared: &Prepared,
    series: &Series,
    references: &MaskReferences,
) -> Result<MaskedRecording, MaskingError> {
    prepared.check()?;
    let recording = &prepared.recording;
    for (name, values) in [
        ("level_m", &series.level_m),
        ("friction_pa", &series.friction_pa),
        ("head_m", &series.head_m),
    ] {
        if values.len() != recording.len() {
            return Err(MaskingError::Length {
                name,
                found: values.len(),
                expected: recording.len(),
            });
        }
    }
    let [inflow, outflow, inlet, outlet] = flicker(recording, prepared.step_s, references);
    let [flow_m3_s, _, _, level_m] = references.disclose();

    let inflows = [
        recording.mud_pump_flow_m3_s.as_slice(),
        &recording.booster_flow_m3_s,
        &recording.topfill_flow_m3_s,
    ];
    let flow = |values: &[f64]| -> Vec<f64> {
        let told = known(values, &prepared.keep);
        let masked = told.map(|v| references.mask_flow(v));
        masked
            .map(|p| if p.abs() > 200.0 { f64::NAN } else { p })
            .collect()
    };
    let sums = sum(inflows.map(flow));
    let inflow_pct = with(sums, &inflow, 100.0 * share(&inflows, flow_m3_s));
    let outflows = [recording.return_flow_m3_s.as_slice()];
    let return_flow_pct = with(
        flow(outflows[0]),
        &outflow,
        100.0 * share(&outflows, flow_m3_s),
    );

    // Level, friction and head are three views of two pressures. It is the pressures that are dithered: noise of its
    // own on each view would average out of a combination of them, and the steps would show again.
    let weight_pa_m = weight_pa_m(prepared, series);
    let side = |transmitters: &[Vec<f64>], noise: &[f64]| -> Vec<f64> {
        let all: Vec<&[f64]> = transmitters.iter().map(Vec::as_slice).collect();
        let size_m = level_m * share(&all, level_m * weight_pa_m);
        noise.iter().map(|n| size_m * n).collect()
    };
    let inlet_m = side(&recording.pump_inlet_pressure_pa, &inlet);
    let outlet_m = side(&recording.pump_outlet_pressure_pa, &outlet);
    let view = |values: &[f64], noise: &dyn Fn(usize) -> f64, mask: &dyn Fn(f64) -> f64| {
        let told = known(values, &prepared.keep).enumerate();
        told.map(|(i, v)| mask(v + noise(i)))
            // Without a weight there is no noise either, and bare steps are not passed on.
            .map(|p| if p.is_finite() { p } else { f64::NAN })
            .collect()
    };
    let at = |values: &[f64], i: usize| values.get(i).copied().unwrap_or(f64::NAN);
    let friction_pct = view(
        &series.friction_pa,
        &|i| at(&outlet_m, i) * weight_pa_m,
        &|v| references.mask_friction(v),
    );
    let head_pct = view(
        &series.head_m,
        &|i| at(&outlet_m, i) - at(&inlet_m, i),
        &|v| references.mask_head(v),
    );
    let level_pct = view(&series.level_m, &|i| -at(&inlet_m, i), &|v| {
        references.mask_level(v)
    });
    let first = recording.time_s.first().copied().unwrap_or(0.0);
    Ok(MaskedRecording {
        time_s: recording.time_s.iter().map(|t| t - first).collect(),
        inflow_pct,
        return_flow_pct,
        friction_pct,
        head_pct,
        level_pct,
        pump_speed_pct: recording.pump_speed_pct.clone(),
        keep: prepared.keep.clone(),
    })
}

/// Values within the range of the usable ones and nothing; NaN beyond, for a full scale may be just above the largest.
fn known<'a>(values: &'a [f64], keep: &[bool]) -> impl Iterator<Item = f64> + use<'a> {
    let kept = values.iter().zip(keep).filter(|(_, keep)| **keep);
    let (low, high) = kept.fold((0.0f64, 0.0f64), |(low, high), (v, _)| {
        (low.min(*v), high.max(*v))
    });
    let told = low..=high;
    values
        .iter()
        .map(move |v| if told.contains(v) { *v } else { f64::NAN })
}

/// Noise of a size, added.
fn with(mut values: Vec<f64>, noise: &[f64], size: f64) -> Vec<f64> {
    for (value, noise) in values.iter_mut().zip(noise) {
        *value += size * noise;
    }
    values
}

/// Sample by sample; NaN where any is.
fn sum([mut total, b, c]: [Vec<f64>; 3]) -> Vec<f64> {
    for (total, (b, c)) in total.iter_mut().zip(b.iter().zip(&c)) {
        *total += b + c;
    }
    total
}

/// ρg, Pa/m, out of the series themselves: pressure across the pump against head.
fn weight_pa_m(prepared: &Prepared, series: &Series) -> f64 {
    let sides = prepared
        .outlet_pressure_pa
        .iter()
        .zip(&prepared.inlet_pressure_pa);
    let across = sides.map(|(outlet, inlet)| outlet - inlet);
    // Of the largest head, whose digits are the best.
    across
        .zip(&series.head_m)
        .filter(|(_, head)| head.abs() > 0.0)
        .max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()))
        .map_or(f64::INFINITY, |(across_pa, head_m)| across_pa / head_m)
}
