//! Cases for the proof: recordings of drawn rigs, with drawn effects concealed, and the truth about them.

mod case;
mod dialect;
mod effect;
mod files;
mod rig;
mod routine;

pub use case::{Case, Kind, Order, conceal};
pub use dialect::{Dialect, Form};
pub use effect::{EFFECTS, FOREIGN, Hidden, PASSING, RECURRING, Severity};
pub use files::{write_case, write_case_well_toml, write_truth};
pub use rig::Level;
