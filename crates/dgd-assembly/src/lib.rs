//! Any hydraulic assembly from a description of its components: checked, simulated, linearised, fitted.
//!
//! Start at [`Assembly::parse`] with a `system.toml`, [`Assembly::windows`] with the columns of a record, then
//! [`Assembly::simulate`] and [`fit()`]. [`effects_for`] lists what the textbook laws may leave out. SI units
//! inside. This crate opens no file, prints nothing and names no cause: which effects a recording asks for is decided
//! elsewhere.
#![deny(missing_docs)]

mod assemble;
mod assembly;
mod build;
mod catalogue;
mod connect;
mod dual;
mod effect;
pub mod effects;
mod error;
mod fit;
mod held_out;
mod identify;
mod kinds;
mod laws;
mod linear;
mod locate;
mod model;
mod near;
mod network;
mod reach;
mod record;
mod residual;
mod sensitivity;
mod simulate;
mod spec;
mod structure;

pub use assembly::{Assembly, Edge, Parameter, parse_system};
pub use catalogue::{EffectParameter, Hypothesis, effects_for};
pub use dgd_dynamics::integrate::Method;
pub use dual::Dual;
pub use effect::{About, Balance, Drive, Effect, Now, ParameterAbout, Place, Scale, Size};
pub use error::{AssemblyError, Problem, Problems};
pub use fit::{Fit, FitOptions, FitStatus, Loss, fit};
pub use held_out::HeldOut;
pub use identify::{Identifiability, NearNull, ProfilePoint, identifiability, profile};
pub use kinds::Property;
pub use linear::{Linear, Steady, linearise, steady_state};
pub use record::{Portion, Record, Window};
pub use sensitivity::{Sensitivities, sensitivities, sensitivities_variational};
pub use simulate::{ATMOSPHERE, RunStatus, Simulation, SimulationOptions, Simulator};
pub use spec::{
    Between, Bounds, Component, EffectSetting, Initial, Input, Kind, Measured, PartLayout,
    RecordLayout, Setting, System,
};
pub use structure::{Excess, Incidence};

/// Compiles the examples of the README.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
