//! Locates the mismatch between a model and a recording, names the physics left out, or abstains.
mod conclude;
mod diagnosis;
mod empirical;
mod heave;
mod noise;
mod record;
mod relations;
mod scan;
mod select;
mod tangent;
pub use conclude::diagnose;
pub use diagnosis::{
    Check, DiagnoseError, Diagnosis, Finding, HeldOut, Options, Outcome, ParameterEstimate, Signal,
    Simulation, Stage, Tested, Trace, Verdict,
};
pub use scan::{betas, choose, dump, explore, gains, try_one};
