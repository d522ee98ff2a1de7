//! Why there is no revision.

use dgd_assembly::AssemblyError;

/// Why a revision was refused.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ReviseError {
    /// The record and the assembly do not fit together.
    #[error(transparent)]
    Assembly(#[from] AssemblyError),
    /// Too few samples to leave blocks out; a reading that the log repeats counts once an update.
    #[error("the training part has {found} readings, expected at least {expected}")]
    TooShort {
        /// Readings needed.
        expected: usize,
        /// Readings found.
        found: usize,
    },
    /// No parameters in the bounds could be simulated over the training part.
    #[error("the system cannot be simulated over the training part at any start within the bounds")]
    NotRun,
    /// An option is out of range.
    #[error("option `{name}` is {found}, expected {expected}")]
    Option {
        /// Option.
        name: &'static str,
        /// Value found.
        found: f64,
        /// What would have been accepted.
        expected: &'static str,
    },
}
