use crate::inputs::InputError;
use crate::integrate::IntegrateError;

/// Why a simulation was refused.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum DynamicsError {
    /// A parameter is not usable.
    #[error("`{name}` is {found}, expected {expected}")]
    Parameter {
        /// Parameter.
        name: &'static str,
        /// Value found.
        found: f64,
        /// What would have been accepted.
        expected: &'static str,
    },
    /// A sample of a series is not usable.
    #[error("`{name}` is {found} at sample {index}, expected {expected}")]
    Sample {
        /// Series.
        name: String,
        /// First bad sample.
        index: usize,
        /// Value found.
        found: f64,
        /// What would have been accepted.
        expected: &'static str,
    },
    /// Two series differ in length.
    #[error("`{name}` has {found} samples, expected {expected}")]
    Length {
        /// Series.
        name: &'static str,
        /// Samples expected.
        expected: usize,
        /// Samples found.
        found: usize,
    },
    /// An input does not cover the times asked for.
    #[error("`{name}` covers {first} to {last} s, expected {start} to {end} s")]
    Span {
        /// Signal.
        name: String,
        /// Its first time.
        first: f64,
        /// Its last time.
        last: f64,
        /// First time needed.
        start: f64,
        /// Last time needed.
        end: f64,
    },
    /// A signal was refused.
    #[error(transparent)]
    Input(#[from] InputError),
    /// The integrator refused its arguments.
    #[error(transparent)]
    Integrate(#[from] IntegrateError),
}
