//! The catalogue of effects by component kind: one file an effect, one line here beside its `mod`.
//!
//! Written from the literature alone, before any recording of a bench was looked at. Parameters are multiples of the
//! assembly's usual sizes ([`Scale`](crate::Scale)), so that the same file serves a laboratory tank and a riser.

use crate::Dual;
use crate::effect::{Effect, Now};
use crate::kinds::{displacement, line};

mod affinity_exponent;
mod back_pressure;
mod backflow_stop;
mod boundary_lag;
mod brim_head;
mod bypass;
mod cavitation;
mod choking;
mod clogging;
mod column_drift;
mod discharge_exponent;
mod eccentricity;
mod entrance_jet;
mod evaporation;
mod flow_threshold;
mod follower;
mod friction_drift;
mod gas_head_loss;
mod gas_pocket;
mod hose_storage;
mod inflow_drift;
mod inflow_gain;
mod inflow_lag;
mod inflow_offset;
mod inflow_step;
mod internal_leakage;
mod laminar_resistance;
mod line_exponent;
mod line_fittings;
mod line_inertia;
mod line_laminar;
mod line_leak;
mod line_yield;
mod low_flow_cutoff;
mod opening_characteristic;
mod opening_lag;
mod opening_leak;
mod opening_play;
mod opening_stiction;
mod outlet_lag;
mod outlet_offset;
mod overflow_caught;
mod pressure_drift;
mod pressure_offset;
mod pump_dead_band;
mod pump_drift;
mod pump_lag;
mod pump_nonlinear_gain;
mod pump_offset;
mod pump_saturation;
mod pump_slip;
mod pump_turbulent_slip;
mod pump_wear;
mod reading_backlash;
mod reading_clipping;
mod reading_curvature;
mod reading_delay;
mod reading_drift;
mod reading_gain;
mod reading_lag;
mod reading_offset;
mod reading_quantisation;
mod reynolds_coefficient;
mod speed_drift;
mod speed_lag;
mod speed_offset;
mod splash;
mod static_head_error;
mod stroke_ripple;
mod tail_head;
mod tank_area;
mod tank_leak;
mod taper;
mod tide;
mod tool_joints;
mod unseen_brim;
mod viscosity_derating;
mod vortex;

// Those of a component act in this order: along the way of the signal, from the quantity to what is shown of it, and from the command to what it does.
static ALL: &[&dyn Effect] = &[
    // Tanks.
    &overflow_caught::This,
    &unseen_brim::This,
    &brim_head::This,
    &tank_area::This,
    &taper::This,
    &outlet_offset::This,
    &tank_leak::This,
    &vortex::This,
    &entrance_jet::This,
    &splash::This,
    &evaporation::This,
    &bypass::This,
    &inflow_lag::This,
    // Valves and orifices.
    &laminar_resistance::This,
    &discharge_exponent::This,
    &clogging::This,
    &flow_threshold::This,
    &backflow_stop::This,
    &reynolds_coefficient::This,
    &opening_play::THIS,
    &opening_stiction::This,
    &opening_lag::THIS,
    &opening_characteristic::This,
    &opening_leak::This,
    &choking::This,
    // What adds to the pressure comes after what multiplies the friction.
    &tail_head::This,
    // Lines.
    &line_inertia::This,
    &line_fittings::This,
    &line_laminar::This,
    &line_exponent::This,
    &gas_pocket::THIS,
    &line_yield::This,
    &eccentricity::This,
    &friction_drift::This,
    &line_leak::This,
    &tool_joints::This,
    &static_head_error::This,
    &column_drift::This,
    // Centrifugal pumps.
    &speed_lag::THIS,
    &speed_offset::This,
    &speed_drift::This,
    &affinity_exponent::This,
    &internal_leakage::This,
    &pump_wear::This,
    &gas_head_loss::This,
    &viscosity_derating::This,
    &cavitation::This,
    // Displacement pumps.
    &pump_slip::This,
    &pump_turbulent_slip::This,
    &pump_dead_band::This,
    &pump_saturation::This,
    &pump_lag::THIS,
    &pump_nonlinear_gain::This,
    &pump_offset::This,
    &stroke_ripple::This,
    &pump_drift::This,
    &hose_storage::THIS,
    // Boundaries.
    &pressure_offset::This,
    &pressure_drift::This,
    &back_pressure::This,
    &tide::This,
    &inflow_gain::This,
    &inflow_offset::This,
    &inflow_step::This,
    &inflow_drift::This,
    &boundary_lag::THIS,
    // Instruments.
    &reading_delay::This,
    &reading_lag::This,
    &reading_backlash::This,
    &reading_curvature::This,
    &reading_gain::This,
    &reading_offset::This,
    &reading_drift::This,
    &low_flow_cutoff::This,
    &reading_clipping::This,
    &reading_quantisation::This,
];

/// Every effect, in the order of the catalogue, in which those of a component act.
#[must_use]
pub fn all() -> &'static [&'static dyn Effect] {
    ALL
}

/// The effect of an id.
#[must_use]
pub fn find(id: &str) -> Option<&'static dyn Effect> {
    ALL.iter().copied().find(|e| e.about().id == id)
}

/// Time constants below this share of the usual time are none: the lag is left out and its state stands still.
const NO_LAG: f64 = 1e-6;

/// Rate of a first-order lag.
fn lag(tau: f64, state: f64, target: f64, usual_s: f64) -> f64 {
    if tau > NO_LAG * usual_s {
        (target - state) / tau
    } else {
        0.0
    }
}

/// What a first-order lag shows.
fn lagged(tau: f64, state: f64, target: f64, usual_s: f64) -> f64 {
    if tau > NO_LAG * usual_s {
        state
    } else {
        target
    }
}

/// Where what has play and stood at `z` is when it is told to be at `set`.
fn played(play: f64, z: f64, set: f64) -> f64 {
    let half = 0.5 * play.max(0.0);
    // `max` and `min` in place of `clamp`, which panics on bounds that are no numbers.
    z.max(set - half).min(set + half)
}

/// `drop · |q/Q|^e`, with the power rounded off near zero flow so that it stays finite.
fn bent(exponent: f64, flow: f64, q: Dual, drop: Dual) -> Dual {
    if exponent == 0.0 {
        return drop;
    }
    let share = q * (1.0 / flow);
    (share * share + 1e-6).powf(0.5 * exponent) * drop
}

/// A drop that grows steeply beyond a flow.
fn wall(choke: f64, now: &Now<'_>, q: Dual, drop: Dual) -> Dual {
    let share = (choke / now.scale.flow_m3_s) * q;
    let square = share * share;
    let fourth = square * square;
    // Odd, so that it stands against the flow in both directions.
    drop + now.scale.pressure_pa * fourth * square * share * share.abs()
}

/// Drop of a line at rest, Pa: rise and constant term.
fn still(now: &Now<'_>) -> f64 {
    now.density_kg_m3 * now.gravity_m_s2 * now.own[line::ELEVATION] + now.own[line::CONSTANT]
}

/// The input of a displacement pump that gives a flow.
fn per_coefficient(now: &Now<'_>, flow: f64) -> f64 {
    let coefficient = now.own[displacement::COEFFICIENT];
    if coefficient == 0.0 {
        flow
    } else {
        flow / coefficient
    }
}
