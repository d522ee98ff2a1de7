//! Locates the mismatch between a model and a recording, names the physics left out, or abstains.
mod conclude;
mod diagnosis;
#[cfg(test)]
mod draws;
mod empirical;
mod estimates;
mod finding;
mod free_run;
mod heave;
mod held_out;
mod noise;
mod record;
mod relations;
mod scan;
mod select;
mod tangent;
mod tested;
mod traces;
mod unrest;
mod vectors;
pub use conclude::diagnose;
pub use diagnosis::{
    Check, DiagnoseError, Diagnosis, Finding, HeldOut, Options, Outcome, ParameterEstimate, Signal,
    Simulation, Stage, Tested, Trace, Verdict,
};
