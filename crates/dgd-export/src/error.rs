//! Why a table was not written.

/// Why a table was not written.
///
/// Nothing is known about what reached the writer before that.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ExportError {
    /// The writer failed.
    #[error("cannot write: {0}")]
    Io(#[from] std::io::Error),
    /// The MCAP library failed.
    ///
    /// Boxed: its error type is not part of this crate's interface, and may change with the library.
    #[error("cannot write the log: {0}")]
    Mcap(#[source] Box<dyn std::error::Error + Send + Sync>),
    /// A table without columns.
    #[error("the table has no columns")]
    NoColumns,
    /// Two columns of one name: a reader could not tell them apart.
    #[error("two columns are named `{tag}`; names must differ")]
    NameTaken {
        /// The name.
        tag: String,
    },
    /// A series that is not as long as the clock.
    #[error("`{name}` has {found} samples, expected {expected} to match the time")]
    Length {
        /// The series.
        name: String,
        /// Length of the time.
        expected: usize,
        /// Its length.
        found: usize,
    },
    /// A matrix with another number of values than its shape has.
    #[error("matrix `{name}` has {found} values, expected {rows} x {columns}")]
    Shape {
        /// The matrix.
        name: String,
        /// Its rows.
        rows: usize,
        /// Its columns.
        columns: usize,
        /// Its values.
        found: usize,
    },
    /// A block that has not the columns of its head.
    #[error("a block of {found} columns, expected {expected} as the head has")]
    Width {
        /// Columns of the head.
        expected: usize,
        /// Columns of the block.
        found: usize,
    },
    /// The column that is to be the clock is not there.
    #[error("no time column `{tag}`; the table has {present}")]
    NoTime {
        /// The name looked for.
        tag: String,
        /// The names there are, shortened.
        present: String,
    },
    /// The clock has no column beside it: its messages would say nothing, and no reader would find a number in them.
    #[error("the table has no column but its clock `{tag}`, expected at least one more")]
    OnlyTime {
        /// The clock.
        tag: String,
    },
    /// The time column's unit is no unit of time.
    #[error("time column `{tag}` is in `{found}`, expected a unit of time")]
    TimeUnit {
        /// The column.
        tag: String,
        /// Its unit.
        found: String,
    },
    /// A sample that cannot be put on the log's clock.
    #[error(
        "time of sample {index} is {found} s, expected a number from 0 to 5e8 s after the start"
    )]
    TimeValue {
        /// The sample, counted from 0.
        index: usize,
        /// Its time.
        found: f64,
    },
    /// The table's origin is no RFC 3339 time from 1970 on.
    #[error("origin `{found}` is no RFC 3339 time from 1970 to 2200")]
    Origin {
        /// The origin.
        found: String,
    },
    /// A name that MATLAB does not take.
    #[error(
        "`{name}` is not a MATLAB name: a letter, then letters, digits and `_`, at most 63 in all, and no keyword such as `end`"
    )]
    Name {
        /// The name.
        name: String,
    },
    /// More than the format can hold.
    #[error(
        "{what} takes {bytes} bytes, the format holds {limit}; split the table, or write another format"
    )]
    TooLarge {
        /// What is too large.
        what: String,
        /// Its size.
        bytes: u64,
        /// The most the format holds.
        limit: u64,
    },
}
