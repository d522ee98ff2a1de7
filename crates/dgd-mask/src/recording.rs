//! Every channel as a percentage, dithered over its transmitter's step.

use crate::references::secret_generator;
use dgd_identify::{Prepared, Series};
use dgd_recording::quantum;
use dgd_units::MaskReferences;
use rand::{Rng, RngExt};

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
/// Flows are blanked where they are beyond twice the reference: an instrument's full
/// scale is a number that people know. Of the flows into the riser only the sum is told,
/// which is all that the model reads (Eq. 3.45): a topfill that rests on a round number
/// would be a guess away from the reference.
pub fn mask_recording(
    prepared: &Prepared,
    series: &Series,
    references: &MaskReferences,
) -> MaskedRecording {
    let recording = &prepared.recording;
    let mut random = secret_generator(recording, b"dither");
    let mut flow = |values: &[f64]| {
        let step = quantum(values).map(|step| references.mask_flow(step));
        let masked = values
            .iter()
            .map(|v| references.mask_flow(*v))
            .map(|p| if p.abs() > 200.0 { f64::NAN } else { p });
        let noise = dither(values.len(), step.as_slice(), &mut random);
        masked.zip(noise).map(|(p, d)| p + d).collect::<Vec<f64>>()
    };
    let inflow_pct = sum([
        flow(&recording.mud_pump_flow_m3_s),
        flow(&recording.booster_flow_m3_s),
        flow(&recording.topfill_flow_m3_s),
    ]);
    let return_flow_pct = flow(&recording.return_flow_m3_s);
    // Level, friction and head are three views of two pressures. It is the pressures that are dithered: noise of its
    // own on each view would average out of a combination of them, and the steps would show again.
    let mut side = |transmitters: &[Vec<f64>]| {
        let steps: Vec<f64> = transmitters.iter().filter_map(|t| quantum(t)).collect();
        dither(recording.len(), &steps, &mut random)
    };
    let inlet_pa = side(&recording.pump_inlet_pressure_pa);
    let outlet_pa = side(&recording.pump_outlet_pressure_pa);
    let weight_pa_m = weight_pa_m(prepared, series);
    let friction = series.friction_pa.iter().zip(&outlet_pa);
    let friction_pct = friction
        .map(|(f, outlet)| references.mask_friction(f + outlet))
        .collect();
    let head = series.head_m.iter().zip(inlet_pa.iter().zip(&outlet_pa));
    let head_pct = head
        .map(|(h, (inlet, outlet))| references.mask_head(h + (outlet - inlet) / weight_pa_m))
        .collect();
    let level = series.level_m.iter().zip(&inlet_pa);
    let level_pct = level
        .map(|(h, inlet)| references.mask_level(h - inlet / weight_pa_m))
        .collect();
    let first = recording.time_s.first().copied().unwrap_or(0.0);
    MaskedRecording {
        time_s: recording.time_s.iter().map(|t| t - first).collect(),
        inflow_pct,
        return_flow_pct,
        friction_pct,
        head_pct,
        level_pct,
        pump_speed_pct: recording.pump_speed_pct.clone(),
        keep: prepared.keep.clone(),
    }
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

/// Noise uniform over one step of each transmitter: the mean stays, the steps are gone.
///
/// One draw a transmitter, not one over the coarsest: noise as wide as another's step
/// does not fill one's own.
fn dither(len: usize, steps: &[f64], random: &mut impl Rng) -> Vec<f64> {
    // Drawn for missing values too, so that a gap does not shift the rest.
    let mut draw = |step: &f64| step * (random.random::<f64>() - 0.5);
    (0..len)
        .map(|_| steps.iter().map(&mut draw).sum())
        .collect()
}
