//! Why a file gave no table at all.

/// Why a file was refused.
///
/// Trouble that leaves usable columns is no error: it becomes an
/// [`Issue`](dgd_recording::Issue) in the table. Each message says the place and,
/// where one is known, the mend.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum IngestError {
    /// No bytes, or none but white space.
    #[error("the file is empty; record or export it again")]
    Empty,
    /// Neither MAT, nor MCAP, nor text.
    #[error(
        "the file begins with {first_bytes}, which is not MAT v5, MAT v7.3, MCAP or CSV text; export it to one of these"
    )]
    Unrecognised {
        /// The first bytes in hexadecimal, at most sixteen.
        first_bytes: String,
    },
    /// The format is known by its name, but this crate does not read it.
    #[error("this is {format}, which is not read; {mend}")]
    Unsupported {
        /// What the file is.
        format: &'static str,
        /// How to get a file that can be read.
        mend: &'static str,
    },
    /// Text that is not a table of numbers.
    #[error("{place}: {reason}; {mend}")]
    NotTabular {
        /// Line and column.
        place: String,
        /// What was found there, and what was expected.
        reason: String,
        /// How to mend it.
        mend: String,
    },
    /// The structure of the file is broken and nothing before that place was usable.
    #[error("damaged {format} at {place}: {reason}; {mend}")]
    Damaged {
        /// The format that the file claims.
        format: &'static str,
        /// Byte offset, variable, line or column.
        place: String,
        /// What was found there, and what was expected.
        reason: String,
        /// How to mend it.
        mend: String,
    },
    /// The file claims more than its bytes can hold, or more than a documented limit.
    #[error("{what} claims {claimed}, the limit is {limit}; the file is damaged, or split it")]
    TooLarge {
        /// What is too large, and where.
        what: String,
        /// The size that the file claims.
        claimed: u64,
        /// The most that is accepted here.
        limit: u64,
    },
    /// Sound, but without a column of numbers.
    #[error("no column of numbers in this {format} file: {found}")]
    NothingNumeric {
        /// The format of the file.
        format: &'static str,
        /// What it holds instead.
        found: String,
    },
}
