//! Why a recording was not screened.

use dgd_recording::{Recording, Unequal, Uneven, check_even};

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
    /// A block that has not the transmitters of those before.
    #[error("a block of {found} channels, expected the {expected} of the blocks before")]
    Transmitters {
        /// Channels of the block.
        found: usize,
        /// Channels of the blocks before.
        expected: usize,
    },
    /// The step of the clock is no step.
    #[error("the step is {found} s, expected a positive number")]
    Step {
        /// The step given, s.
        found: f64,
    },
    /// The clock of the recording is not even, or its step is another one.
    #[error(transparent)]
    Uneven(#[from] Uneven),
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

/// Refuses a step that is none, series that are not as long as the clock, and a clock that is not even by the step.
pub(crate) fn check(recording: &Recording, step_s: f64) -> Result<(), ScreenError> {
    check_step(step_s)?;
    recording.check()?;
    Ok(recording.check_even(step_s)?)
}

/// The same of a block after one that ended at `last_s`.
pub(crate) fn check_next(
    block: &Recording,
    step_s: f64,
    last_s: Option<f64>,
) -> Result<(), ScreenError> {
    check(block, step_s)?;
    if let (Some(last_s), Some(first_s)) = (last_s, block.time_s.first()) {
        check_even(&[last_s, *first_s], step_s)?;
    }
    Ok(())
}

/// Refuses a step that is none.
pub(crate) fn check_step(step_s: f64) -> Result<(), ScreenError> {
    if step_s > 0.0 && step_s.is_finite() {
        return Ok(());
    }
    Err(ScreenError::Step { found: step_s })
}
