//! Subsea pump head curves: constrained fits and the search for exponents.
//!
//! The curve is `H = c0 w^n0 - c1 w q - c2 q^n2` (thesis Eq. 3.39): head H in m of the pumped
//! fluid, pump speed w in percent of full, flow q in m³/s. [`HeadCurve`] evaluates it.
//!
//! Start at [`fit_unconstrained`] for known exponents, at [`fit_constrained`] if the curve must
//! fall with flow though the data are poor, and at [`search_exponents`] to find the exponents
//! themselves. [`check_shape`] answers whether a curve falls and is concave over a range.
//!
//! This crate opens no file and prints nothing. Absent: rules about which samples are
//! trustworthy (the caller gives `keep`), the delay of the flow meter (shift the flow first), and
//! dynamics.
#![deny(missing_docs)]

mod constrained;
mod curve;
mod error;
mod fit;
mod joint;
mod pass;
mod search;
mod shape;
mod table;

pub use constrained::{
    ConstrainedFit, ConstrainedOptions, SolverStatus, fit_constrained, fit_free_and_constrained,
};
pub use curve::HeadCurve;
pub use dgd_lsq::LsqError;
pub use error::PumpError;
pub use fit::{CONDITION_LIMIT, CurveFit, Samples, fit_unconstrained};
pub use joint::JointErrors;
pub use search::{
    ExponentSearch, Limit, PathPoint, Rule, SearchOptions, SearchStatus, Trial, search_exponents,
};
pub use shape::{Place, ShapeCheck, check_shape};

/// The example of the README compiles.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
