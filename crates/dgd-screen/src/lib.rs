//! Screening: which samples of a recording may be used for identification, and
//! why the others may not.
//!
//! Start at [`screen`] with a [`Recording`] on an even clock. It
//! applies the rules of section 3.3 of the thesis (pump on, positive pressure
//! rise, positive flow, no stuck runs) and looks at each transmitter for gaps,
//! spikes, frozen values, impossible values and short disagreement with its
//! twin. [`Screening::keep`] is the mask for identification,
//! [`Screening::channel`] tells which transmitter may be trusted when.
//! [`suspect`] looks at a recording before that: can its units and tags be what the well
//! description says? Nothing is repaired in the recording, but by [`blank_strays`], which takes out readings before lines are
//! drawn from them and says how many; this crate fits no model, opens no file and
//! prints nothing.
//!
//! ```
//! use dgd_screen::{Reasons, Recording, ScreenOptions, screen};
//! let n = 100;
//! let noisy = |level: f64, step: f64| -> Vec<f64> {
//!     (0..n).map(|i| level + step * f64::from(i * 37 % 11)).collect()
//! };
//! let mut recording = Recording {
//!     time_s: (0..n).map(f64::from).collect(),
//!     mud_pump_flow_m3_s: noisy(0.03, 1e-5),
//!     booster_flow_m3_s: noisy(0.01, 1e-5),
//!     topfill_flow_m3_s: noisy(0.002, 1e-5),
//!     return_flow_m3_s: noisy(0.042, 1e-5),
//!     pump_inlet_pressure_pa: vec![noisy(24e5, 500.0)],
//!     pump_outlet_pressure_pa: vec![noisy(40e5, 500.0)],
//!     riser_pressure_pa: None,
//!     pump_speed_pct: noisy(60.0, 0.1),
//! };
//! recording.return_flow_m3_s[20..60].fill(0.0421); // the meter froze
//! let screening = screen(&recording, 1.0, &ScreenOptions::default())?;
//! assert!(screening.reasons[30].contains(Reasons::STUCK_RETURN_FLOW));
//! assert_eq!(screening.keep().iter().filter(|k| **k).count(), 60);
//! # Ok::<(), dgd_screen::ScreenError>(())
//! ```
#![deny(missing_docs)]

mod blocks;
mod channel;
mod error;
mod options;
mod plausible;
mod reasons;
mod redundant;
mod scan;
mod screening;
mod speed;
mod spike;
mod strays;
mod stuck;

pub use blocks::{BlockScreen, ScreenedBlock};
pub use channel::{ChannelScreen, Faults};
// What the functions here take, so that their user need not name the crate below.
pub use dgd_recording::{Channel, Recording, Well};
pub use error::ScreenError;
pub use options::{Limits, ScreenOptions};
pub use plausible::{
    BlockSuspect, Coarse, Kept, Suspicion, TOO_SELDOM_S, WellLine, coarse, suspect,
};
pub use reasons::{Reasons, Tally};
pub use screening::{Screening, screen};
pub use strays::blank_strays;

/// The example of the README compiles.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
