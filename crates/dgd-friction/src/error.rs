use dgd_lsq::LsqError;

/// Why a friction estimate was refused.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FrictionError {
    /// Series of one recording differ in length.
    #[error("`{name}` has {found} samples, expected {expected}")]
    Length {
        /// Series that differs.
        name: &'static str,
        /// Its length.
        found: usize,
        /// Length of the flow series.
        expected: usize,
    },
    /// A kept friction sample is NaN or infinite.
    #[error("sample {index} is kept but its friction is not finite")]
    NonFinite {
        /// Sample, from 0.
        index: usize,
    },
    /// Powers of the flow are not a model: none, too many, repeated, negative or not finite.
    #[error(
        "powers {found:?} are not a friction model: expected 1 to {limit} distinct finite powers of at least 0"
    )]
    Powers {
        /// Powers given.
        found: Vec<f64>,
        /// Most allowed.
        limit: usize,
    },
    /// The range of delays is empty or longer than the recording can support.
    #[error(
        "delays {first}..={last} samples in a recording of {samples} samples, expected a rising range within it"
    )]
    Delays {
        /// First delay, samples.
        first: i64,
        /// Last delay, samples.
        last: i64,
        /// Samples in the recording.
        samples: usize,
    },
    /// The sampling interval or another number is out of its domain.
    #[error("`{name}` is {found}, expected {expected}")]
    Domain {
        /// Name of the number.
        name: &'static str,
        /// Value found.
        found: f64,
        /// Its domain.
        expected: &'static str,
    },
    /// The least-squares problem was refused: too few samples, or the flow excites too little.
    #[error(transparent)]
    Fit(#[from] LsqError),
}
