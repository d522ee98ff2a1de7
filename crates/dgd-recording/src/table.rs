//! What a reader found in a file: columns of numbers, and what was wrong with it.

use crate::origin::nanoseconds;
use std::fmt;

/// One column as the file has it.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Column {
    /// Name in the file; nested MAT structs are joined with dots (`gom.FT1`).
    pub tag: String,
    /// Unit as written in the file, if it says one.
    pub unit: Option<String>,
    /// Values in that unit; NaN where the file has none.
    pub values: Vec<f64>,
}

/// The columns of one file, which need not be of equal length.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Table {
    /// In the order of the file.
    pub columns: Vec<Column>,
    /// What the reader found wrong and lived with.
    pub issues: Vec<Issue>,
    /// Wall-clock time of the first sample where the file knows it, RFC 3339.
    pub origin: Option<String>,
}

impl Table {
    /// [`Self::origin`] in nanoseconds from 1970; `None` if it is not told, or is no RFC 3339 time from 1970 to 2200.
    ///
    /// ```
    /// # let mut table = dgd_recording::Table::default();
    /// table.origin = Some("1970-01-02T00:00:00.5Z".to_owned());
    /// assert_eq!(table.origin_ns(), Some(86_400_500_000_000));
    /// ```
    #[must_use]
    pub fn origin_ns(&self) -> Option<u64> {
        self.origin.as_deref().and_then(nanoseconds)
    }
}

/// Something wrong in a file that still could be read.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Issue {
    /// What sort of trouble.
    pub kind: IssueKind,
    /// Where: a line, a byte offset, a column, a sample.
    pub place: String,
    /// What it means for the data, with counts.
    pub message: String,
}

/// What sort of trouble an [`Issue`] tells of.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[non_exhaustive]
pub enum IssueKind {
    /// The file ends early; what came before was kept.
    Truncated,
    /// A part is damaged and was left out.
    Damaged,
    /// A value is not a number; it became NaN.
    UnreadableValue,
    /// A variable of a kind that holds no numbers was passed over.
    Skipped,
    /// A time stamp is missing or not finite; its sample was dropped.
    MissingTime,
    /// Two samples share a time stamp; the later one was dropped.
    DuplicateTime,
    /// Time runs backwards; the samples were put in order.
    BackwardTime,
    /// Samples are missing; the gap was filled with NaN.
    Gap,
    /// Time steps vary; each sample was moved to the nearest even step.
    Jitter,
    /// The file's unit and the well description disagree; the description was used.
    UnitDisagrees,
}

impl fmt::Display for Issue {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.place, self.message)
    }
}

impl Table {
    /// The column of this name: an exact match, else the only one that ends in `.tag`.
    pub fn column(&self, tag: &str) -> Option<&Column> {
        self.find(tag).map(|index| &self.columns[index])
    }

    /// Index of the column that [`Table::column`] gives.
    pub fn find(&self, tag: &str) -> Option<usize> {
        if let Some(index) = self.columns.iter().position(|c| c.tag == tag) {
            return Some(index);
        }
        let ends = |c: &Column| {
            c.tag
                .strip_suffix(tag)
                .is_some_and(|head| head.ends_with('.'))
        };
        let mut hits = self.columns.iter().enumerate().filter(|(_, c)| ends(c));
        match (hits.next(), hits.next()) {
            (Some((index, _)), None) => Some(index),
            _ => None,
        }
    }

    /// Length of the longest column.
    pub fn rows(&self) -> usize {
        self.columns
            .iter()
            .map(|c| c.values.len())
            .max()
            .unwrap_or(0)
    }
}
