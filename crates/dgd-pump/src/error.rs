use dgd_lsq::LsqError;

/// Why a pump estimate was refused.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PumpError {
    /// Series of one recording differ in length.
    #[error("`{name}` has {found} samples, expected {expected}")]
    Length {
        /// Series that differs.
        name: &'static str,
        /// Its length.
        found: usize,
        /// Length of the speed series.
        expected: usize,
    },
    /// A kept sample is NaN or infinite.
    #[error("sample {index} is kept but its `{name}` is not finite")]
    NonFinite {
        /// Series.
        name: &'static str,
        /// Sample, from 0.
        index: usize,
    },
    /// A kept sample runs backwards: powers of it are not defined by the model.
    #[error("sample {index} is kept but its `{name}` is {found}, expected at least 0")]
    Negative {
        /// Series.
        name: &'static str,
        /// Sample, from 0.
        index: usize,
        /// Value found.
        found: f64,
    },
    /// A number is out of its domain.
    #[error("`{name}` is {found}, expected {expected}")]
    Domain {
        /// Name of the number.
        name: &'static str,
        /// Value found.
        found: f64,
        /// Its domain.
        expected: &'static str,
    },
    /// A range of exponents falls, or leaves what is allowed.
    #[error("`{name}` is {from} to {to}, expected {expected}")]
    Range {
        /// Name of the range.
        name: &'static str,
        /// Its start.
        from: f64,
        /// Its end.
        to: f64,
        /// What would have been accepted.
        expected: &'static str,
    },
    /// No exponents tried give a falling, concave curve (thesis Eq. 3.44), by
    /// [`Rule::Refuse`](crate::Rule::Refuse); or those that do by the sums of the search do not by QR of the rows.
    #[error("none of {tried} exponent pairs gives c1 > 0 and c2 > 0")]
    NoFeasibleExponents {
        /// Pairs tried: the start and a grid over the allowed range.
        tried: usize,
    },
    /// The quadratic programme could not be set up or run.
    #[error("the quadratic programme was not accepted by the solver")]
    Solver,
    /// The least-squares problem was refused: too few samples, or too little excitation.
    #[error(transparent)]
    Fit(#[from] LsqError),
}
