//! Why a recording was not screened.

use dgd_recording::Unequal;

/// Why a recording was not screened.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ScreenError {
    /// A series of the recording is not as long as the clock.
    #[error(transparent)]
    Unequal(#[from] Unequal),
    /// Something beside a recording is not as long as its clock.
    #[error("`{channel}` has {found} samples, expected {expected} to match the time")]
    Length {
        /// What is odd.
        channel: &'static str,
        /// Its length.
        found: usize,
        /// Length of the time.
        expected: usize,
    },
    /// Blocks that are not those of the recording that was announced.
    #[error("blocks of {found} samples in all, expected {expected} of the same transmitters")]
    Blocks {
        /// Samples that came.
        found: usize,
        /// Samples announced.
        expected: usize,
    },
    /// The step of the clock is no step.
    #[error("the step is {found} s, expected a positive number")]
    Step {
        /// The step given, s.
        found: f64,
    },
    /// An option that cannot be.
    #[error("option `{name}` is {found}, expected {expected}")]
    Option {
        /// Name of the field.
        name: &'static str,
        /// Its value.
        found: f64,
        /// What it may be.
        expected: &'static str,
    },
}
