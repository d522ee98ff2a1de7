//! Locates the mismatch between a model and a recording, names the physics left out, or abstains.
//!
//! Start at [`diagnose`]: a well and a screened recording in, a [`Diagnosis`] out. Its chain, each step with its reason:
//!
//! 1. **Record and relations**: the recording on one clock, friction, head, redundant instruments and mass balance in blocks of
//!    10 s, or 20 s beyond 40 h. Relations are linear in most effects and say where a mismatch sits; a free run tells neither.
//! 2. **Noise**: spread, memory, coupling of relations and wander of instruments within their accuracy. Drift that every sound
//!    instrument has would otherwise be the first thing found.
//! 3. **Tangent**: all base parameters fitted again, and only what lies off their tangent counted. What a re-fit removes
//!    needs no new physics.
//! 4. **Scan**: each effect of the catalogue as a Bayes factor, its strength integrated out, so that freedom is paid for.
//! 5. **Selection**: one effect a round above a hurdle that sound recordings do not reach, refined together with those
//!    before it. Two effects can hide each other, and a strong one leaves something over: a second must stand out from its slack.
//! 6. **Empirical corrections** compete in each round: where a curve with no physics is clearly likelier, the cause is `unknown`.
//! 7. **Free runs** of the models without and with the findings, both fitted without the held-out windows, and placebos. Evidence in
//!    relations may not pay in the simulation that the model is for.
//! 8. **Detection limits**: what was not seen, and how small it would have been seen. Without them `consistent` says nothing.
//!
//! `METHOD.md` describes the method in full, the README its limits. Absent: reading and screening (`dgd-ingest`, `dgd-identify`), the effects
//! themselves (`dgd-effects`), documents and reports. This crate opens no file and prints nothing.
#![deny(missing_docs)]

mod ablation;
mod bayes;
mod belief;
mod conclude;
mod contest;
mod cores;
mod cost;
mod dead;
mod diagnosis;
mod empirical;
mod ends_early;
mod error_budget;
mod estimates;
mod finding;
mod free_run;
mod frozen_speed;
mod heave;
mod held_out;
mod incremental;
mod layout;
mod limit;
mod noise;
mod noisier;
mod numbers;
mod placebo;
mod record;
mod refine;
mod regime;
mod relations;
mod remains;
mod round;
mod scan;
mod select;
mod selection;
mod slack;
mod stops;
mod suction;
mod tangent;
#[cfg(test)]
mod test_rig;
mod tested;
mod timing;
mod told;
mod traces;
mod twins;
mod vectors;

pub use ablation::Step;
pub use conclude::diagnose;
pub use cost::Work;
pub use diagnosis::{
    Archived, Check, CorrectionCurve, DiagnoseError, Diagnosis, Finding, HeldOut, Options, Outcome,
    ParameterEstimate, Signal, Simulation, Stage, Tested, Trace, Verdict,
};

/// The README's examples are tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
