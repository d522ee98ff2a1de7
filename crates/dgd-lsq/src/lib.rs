//! Linear least squares in one pass over the rows, with the statistics of MATLAB's `lsqcov`.
//!
//! Start at [`Accumulator`]: name the columns, push rows, call
//! [`finish`](Accumulator::finish). Rows are reduced block by block to a small triangle, so the
//! memory does not grow with the recording and the normal equations are never formed.
//! [`fit_robust`] is the Huber variant for data with outliers; it replays the rows.
//!
//! A fit that is not persistently excited (thesis Eq. 3.8: the inverse must exist) is refused
//! with the names of the columns that cannot be told apart. [`lm`] is for what is not linear:
//! Levenberg-Marquardt within a box. This crate opens no file, prints nothing and holds no model:
//! what the columns mean is the caller's affair. Absent: sparse problems, constraints other than
//! bounds, regularisation.
//!
//! ```
//! use dgd_lsq::Accumulator;
//! let mut rows = Accumulator::new(["1", "t"])?;
//! for (t, y) in [(0.0, 1.0), (1.0, 3.1), (2.0, 4.9)] {
//!     rows.push(&[1.0, t], y)?;
//! }
//! let fit = rows.finish()?;
//! assert!((fit.coefficients[1] - 1.95).abs() < 1e-12);
//! assert_eq!(fit.n, 3);
//! # Ok::<(), dgd_lsq::LsqError>(())
//! ```
#![deny(missing_docs)]

mod accumulate;
mod error;
mod fit;
pub mod lm;
mod robust;

pub use accumulate::{Accumulator, MAX_COLUMNS, dot};
pub use error::LsqError;
pub use fit::{CONDITION_LIMIT, Fit, Reduced};
/// The matrices of [`lm`], of the version that it is built with.
pub use nalgebra;
pub use robust::{RobustFit, RobustOptions, RobustStatus, fit_robust};

/// The example of the README compiles.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
