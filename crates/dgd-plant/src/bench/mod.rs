//! Two benches that have nothing to do with a rig: a surge shaft on a pipeline, and a loop of glycol.
//!
//! Start at [`draw`], which makes a [`Case`] of an [`Order`], and hand it to [`simulate`]. [`write_csv`] files what the
//! instruments say, [`write_truth`] what was concealed; [`Bench::system_toml`] is the textbook form that somebody
//! would write down of the bench. The physics (own friction law, own integrator) shares no code with what is to diagnose
//! it, and what it can conceal was taken from the hydraulics literature without regard to any catalogue of effects.

mod case;
mod circuit;
mod files;
mod friction;
mod gauge;
mod hidden;
mod integrate;
mod run;
mod schedule;
mod surge;

pub use case::{Case, Kind, Order, Severity, draw};
pub use circuit::Circuit;
pub use files::{write_csv, write_truth};
pub use friction::friction_factor;
pub use gauge::Gauge;
pub use hidden::{Hidden, Place};
pub use integrate::rk4;
pub use run::{Record, simulate, simulate_for};
pub use schedule::Programme;
pub use surge::Surge;

/// A bench.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Bench {
    /// Reservoir, pipeline, surge shaft, penstock and control valve: masses that swing.
    SurgeShaft,
    /// Sump, gear pump, accumulator, laminar line, needle valve and header tank, closed on itself.
    GlycolLoop,
}

impl Bench {
    /// Both.
    pub const ALL: [Bench; 2] = [Bench::SurgeShaft, Bench::GlycolLoop];

    /// The bench of that name.
    pub fn named(name: &str) -> Option<Bench> {
        Bench::ALL.into_iter().find(|b| b.name() == name)
    }

    /// `surge-shaft` or `glycol-loop`.
    pub fn name(self) -> &'static str {
        match self {
            Bench::SurgeShaft => "surge-shaft",
            Bench::GlycolLoop => "glycol-loop",
        }
    }

    /// The description of its textbook form: known values, free values with bounds, channels, and which samples are held out.
    pub fn system_toml(self) -> &'static str {
        match self {
            Bench::SurgeShaft => include_str!("surge_shaft.toml"),
            Bench::GlycolLoop => include_str!("glycol_loop.toml"),
        }
    }

    /// What it can conceal of what the literature knows, by name.
    pub fn things(self) -> [&'static str; 8] {
        match self {
            Bench::SurgeShaft => [
                "crest_overflow",
                "shaft_widening",
                "shaft_leak",
                "rack_clogging",
                "valve_backlash",
                "tailwater_rise",
                "foot_throttle",
                "level_drift",
            ],
            Bench::GlycolLoop => [
                "pump_slip",
                "relief_cracking",
                "warming_fluid",
                "early_transition",
                "sump_evaporation",
                "needle_stiction",
                "trapped_gas",
                "meter_lag",
            ],
        }
    }

    /// What it can conceal that no catalogue could hold, by name.
    pub fn foreign(self) -> [&'static str; 2] {
        match self {
            Bench::SurgeShaft => ["humming_shaft", "echo_of_the_valve"],
            Bench::GlycolLoop => ["travelling_rag", "float_switch"],
        }
    }

    /// The inputs as filed: tag, unit, noise and quantum in that unit.
    pub fn inputs(self) -> &'static [Gauge] {
        match self {
            Bench::SurgeShaft => &surge::INPUTS,
            Bench::GlycolLoop => &circuit::INPUTS,
        }
    }

    /// The outputs as filed, likewise.
    pub fn outputs(self) -> &'static [Gauge] {
        match self {
            Bench::SurgeShaft => &surge::OUTPUTS,
            Bench::GlycolLoop => &circuit::OUTPUTS,
        }
    }
}

/// Seconds from sample to sample.
pub const SAMPLING_S: f64 = 3.0;
/// Samples recorded.
pub const SAMPLES: usize = 600;
/// The first sample that is held out.
pub const HELD_OUT: usize = 400;
