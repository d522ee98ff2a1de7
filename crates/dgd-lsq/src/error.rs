/// Why a least-squares fit, or the bounds of one, were refused.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum LsqError {
    /// The number of columns is zero or above [`MAX_COLUMNS`](crate::MAX_COLUMNS).
    #[error("a fit has 1 to {limit} columns, found {found}")]
    Columns {
        /// Columns named.
        found: usize,
        /// Most columns allowed.
        limit: usize,
    },
    /// A row has another width than the column names.
    #[error("row {index} has {found} values, expected {expected}")]
    Width {
        /// Row, counted from 0 in the order pushed.
        index: u64,
        /// Values in the row.
        found: usize,
        /// Columns named.
        expected: usize,
    },
    /// Columns pushed together differ in length.
    #[error("column `{column}` has {found} rows, expected {expected}")]
    Length {
        /// Column name.
        column: String,
        /// Its rows.
        found: usize,
        /// Rows of the observation.
        expected: usize,
    },
    /// A regressor or the observation is NaN or infinite.
    #[error("row {index} is not finite in `{column}`")]
    NonFinite {
        /// Row, counted from 0 in the order pushed.
        index: u64,
        /// Column name, or `y` for the observation.
        column: String,
    },
    /// A weight is negative, NaN or infinite.
    #[error("row {index} has weight {weight}, expected a finite weight of at least 0")]
    Weight {
        /// Row, counted from 0 in the order pushed.
        index: u64,
        /// The weight found.
        weight: f64,
    },
    /// Two accumulators of unlike columns were to be merged.
    #[error("cannot merge columns {found:?} into {expected:?}")]
    Names {
        /// Names in the other accumulator.
        found: Vec<String>,
        /// Names in this one.
        expected: Vec<String>,
    },
    /// Fewer rows than coefficients plus one: no residual is left to judge by.
    #[error("{found} rows for {columns} columns, expected at least {}", columns + 1)]
    TooFewRows {
        /// Rows of positive weight.
        found: u64,
        /// Columns named.
        columns: usize,
    },
    /// The regressors are not persistently exciting: these columns cannot be told apart.
    #[error(
        "columns {columns:?} are not excited: condition {condition:.3e}, expected at most {limit:.3e}"
    )]
    NotExcited {
        /// Columns that take part in the near-dependence (or are zero throughout).
        columns: Vec<String>,
        /// Condition number of the column-scaled triangle; infinite for a zero column.
        condition: f64,
        /// The limit it was held against.
        limit: f64,
    },
    /// The sums of squares leave the range of `f64`: give the columns more sensible units.
    #[error("the squares of column `{column}` overflow")]
    Overflow {
        /// Column name, or `y` for the observation.
        column: String,
    },
    /// The sums of squares are too small for `f64`: give the columns more sensible units.
    #[error("the squares of column `{column}` underflow")]
    Underflow {
        /// Column name, or `y` for the observation.
        column: String,
    },
    /// A coefficient is held at no number, or twice.
    #[error("coefficient {index} is held at {value}, expected one finite value")]
    Held {
        /// Column, counted from 0.
        index: usize,
        /// The value, or the second one.
        value: f64,
    },
    /// There are not as many lower bounds as upper ones.
    #[error("{high} upper bounds for {low} lower ones, expected one of each a parameter")]
    BoundCount {
        /// Lower bounds.
        low: usize,
        /// Upper bounds.
        high: usize,
    },
    /// The bounds of a parameter are not finite, not finitely apart or not in order.
    #[error("parameter {index} is bound to {low}..={high}, expected finite numbers in this order")]
    Bound {
        /// Parameter, counted from 0.
        index: usize,
        /// Its lower bound.
        low: f64,
        /// Its upper bound.
        high: f64,
    },
    /// An option is out of its domain.
    #[error("option `{name}` is {found}, expected {expected}")]
    Option {
        /// Option name.
        name: &'static str,
        /// Value found.
        found: f64,
        /// Its domain.
        expected: &'static str,
    },
}
