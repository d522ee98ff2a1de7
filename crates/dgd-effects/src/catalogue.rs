//! The list of effects: one line each.

use crate::{Effect, own};

mod annulus_area;
mod booster_line_storage;
mod cuttings_loading;
mod gas_in_pump;
mod gel_strength;
mod heave;
mod inflow_gain;
mod influx;
mod line_drainage;
mod line_gas_storage;
mod line_leak;
mod line_restriction;
mod lost_circulation;
mod mud_density_change;
mod outlet_pressure_bias;
mod outlet_pressure_bias_step;
mod pipe_displacement;
mod pump_speed_lag;
mod pump_wear;
mod return_flow_delay;
mod return_flow_gain;
mod u_tube;
mod unknown;
mod viscosity_drift;
mod yield_stress;

/// The effects that are always there, in a fixed order.
pub(crate) const BUILT_IN: [&dyn Effect; 24] = [
    &return_flow_delay::ReturnFlowDelay,
    &return_flow_gain::ReturnFlowGain,
    &inflow_gain::InflowGain,
    &outlet_pressure_bias::OutletPressureBias,
    &outlet_pressure_bias_step::OutletPressureBiasStep,
    &mud_density_change::MudDensityChange,
    &cuttings_loading::CuttingsLoading,
    &yield_stress::YieldStress,
    &gel_strength::GelStrength,
    &line_drainage::LineDrainage,
    &pump_wear::PumpWear,
    &gas_in_pump::GasInPump,
    &pump_speed_lag::PumpSpeedLag,
    &influx::Influx,
    &lost_circulation::LostCirculation,
    &u_tube::UTube,
    &booster_line_storage::BoosterLineStorage,
    &annulus_area::AnnulusArea,
    &pipe_displacement::PipeDisplacement,
    &heave::Heave,
    &viscosity_drift::ViscosityDrift,
    &line_restriction::LineRestriction,
    &line_leak::LineLeak,
    &line_gas_storage::LineGasStorage,
];

/// Every effect, in a fixed order: the built-in ones, and behind them those that were [registered](crate::register).
pub fn catalogue() -> &'static [&'static dyn Effect] {
    own::all()
}

/// The empirical correction, which stands for what the catalogue does not hold.
pub fn unknown() -> &'static dyn Effect {
    &unknown::Unknown
}

/// What would tell two causes apart, if the catalogue knows it: the first has its say, then the other.
///
/// Of what the catalogue does not hold (`unknown`) one thing can be said: it has the equation of none of its effects.
pub fn told_apart_by(one: &str, other: &str) -> Option<&'static str> {
    let says = |of: &str, against: &str| {
        let about = find(of)?.about();
        let like = about.confusable.iter().find(|(id, _)| *id == against);
        like.map(|(_, test)| *test)
    };
    let outside = |of: &str, against: &str| {
        (of == "unknown" && against != of && find(against).is_some()).then_some(ITS_OWN_EQUATION)
    };
    says(one, other)
        .or_else(|| says(other, one))
        .or_else(|| outside(one, other))
        .or_else(|| outside(other, one))
}

/// What tells an effect from a cause that the catalogue does not hold.
const ITS_OWN_EQUATION: &str = "change flow, level and speed one at a time: the effect follows its equation, something else does not";

/// The effect of an id; `unknown` is the empirical correction.
pub fn find(id: &str) -> Option<&'static dyn Effect> {
    if id == "unknown" {
        return Some(unknown());
    }
    catalogue().iter().copied().find(|e| e.about().id == id)
}

/// The effect of an id that takes so many parameters: as it stays, or as it [passes](Effect::passing).
///
/// ```
/// use dgd_effects::{Extent, find_taking};
/// let extent = |count| find_taking("line_leak", count).map(|effect| effect.about().extent());
/// assert_eq!(extent(2), Some(Extent::FromOnset));
/// assert_eq!(extent(3), Some(Extent::Passing));
/// assert_eq!(extent(4), None);
/// ```
pub fn find_taking(id: &str, parameters: usize) -> Option<&'static dyn Effect> {
    let stays = find(id)?;
    let mut forms = [Some(stays), stays.passing()].into_iter().flatten();
    forms.find(|effect| effect.takes(parameters))
}
