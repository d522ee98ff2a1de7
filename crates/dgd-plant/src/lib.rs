//! An independent plant of higher fidelity than the model, which makes stand-in recordings.
//!
//! Start at [`Plan::gom`] or [`Plan::short`] and hand the plan to [`record`]. The plan's fields are open: another
//! well, another mud, another crew. Output is plain data in field units with the truth beside it; [`write_csv`] and its
//! neighbours turn it into bytes.
//!
//! Nothing here knows the two-state model, its polynomials or its estimators: the line is an elastic column of
//! cells with a free surface, friction is Herschel-Bulkley with a transition to turbulence, head comes from
//! velocity triangles and losses. So a fit on this data commits no inverse crime.
//!
//! For the proof, [`conceal`] draws a case: another well, another crew, and in its physics one or two [`Cause`]s that a
//! model leaves out; [`write_truth`] says which. [`mod@bench`] does the same on two benches that are no rig. Absent: temperature as a state, free gas, the hole below the wellhead. This
//! library opens no file and prints nothing.
#![deny(missing_docs)]

pub mod bench;
mod cause;
mod conceal;
mod config;
mod constants;
mod control;
mod instrument;
mod line;
mod mud;
mod noise;
mod plant;
mod pump;
mod record;
mod riser;
mod schedule;
mod well;
mod write;

pub use cause::{Cause, Foreign, Spans};
pub use conceal::{
    Case, Dialect, EFFECTS, FOREIGN, Form, Hidden, Kind, Level, Order, PASSING, RECURRING,
    Severity, conceal, write_case, write_case_well_toml, write_truth,
};
pub use config::{CHANNELS, Controller, Historian, Physics, Plan, UNITS};
pub use instrument::{Fault, FaultKind, FaultRates, Transmitter};
pub use line::LineParameters;
pub use mud::Rheology;
pub use plant::TrueState;
pub use pump::PumpParameters;
pub use record::{PlantError, Recording, record};
pub use schedule::{Control, Segment};
pub use well::Well;
pub use write::{write_csv, write_provenance, write_well_toml};

/// The example of the README compiles.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
