//! From a screened recording to an identified return-line model in one call.
//!
//! [`identify`] walks the thesis's ladder: friction without a delay (Eq. 3.14), the
//! delay sweep (3.23), the law with an offset and a cube (3.26), the head curve with
//! fixed exponents (3.31, free and constrained), the search for exponents (3.39). It
//! returns the final [`Model`] and every rung, so that figures and reports need no
//! second fit. This crate opens no file and prints nothing.
#![deny(missing_docs)]

mod clocks;
mod correlation;
mod friction;
mod identify;
mod model;
mod prepare;
mod pump;
mod series;

/// The simulations' parameters, which [`Model::return_line`] gives.
pub use dgd_dynamics::return_line::ReturnLine;
// What the functions here take and return, so that their user need not name the crates below.
pub use dgd_friction::{
    DelaySweep, FrictionError, Loss, LsqError, Minimum, Polynomial, PolynomialFit, Reweighting,
    RobustOptions, RobustStatus,
};
pub use dgd_pump::{
    ConstrainedFit, CurveFit, ExponentSearch, HeadCurve, JointErrors, Limit, PathPoint, Place,
    PumpError, Rule, SearchOptions, SearchStatus, ShapeCheck, SolverStatus, Trial,
};
pub use dgd_recording::{Geometry, Recording, Well, WellError};
pub use dgd_screen::{Limits, ScreenError, ScreenOptions, Tally};
pub use identify::{Identification, IdentifyError, IdentifyOptions, identify};
pub use model::{DataUsed, Estimate, FrictionModel, FrictionTerm, Model, PumpModel};
pub use prepare::{Prepared, prepare};
pub use pump::PumpRungs;
pub use series::{Series, read_ahead};

/// The README's examples are tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
