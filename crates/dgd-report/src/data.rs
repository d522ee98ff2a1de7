//! What the figures take: slices, named.

use crate::color::Role;
use crate::error::ReportError;

/// Points `(x[i], y[i])`. A point with a NaN or infinite coordinate is counted and not drawn.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scatter<'a> {
    /// Across.
    pub x: &'a [f64],
    /// Up; as long as `x`.
    pub y: &'a [f64],
}

/// A line through `(x[i], y[i])` in the order given. A NaN or infinite coordinate breaks it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Curve<'a> {
    /// Across.
    pub x: &'a [f64],
    /// Up; as long as `x`.
    pub y: &'a [f64],
}

/// A quantity over time, on its own clock. A value that is not finite breaks the line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Series<'a> {
    /// Words for the legend, such as `Measured`.
    pub label: &'a str,
    /// What it stands for; gives the colour.
    pub role: Role,
    /// Time, s, increasing.
    pub time_s: &'a [f64],
    /// Value in the unit of the panel's axis; as long as `time_s`.
    pub value: &'a [f64],
}

/// A stretch of time to be shaded through all panels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Interval<'a> {
    /// Start, s.
    pub start_s: f64,
    /// End, s.
    pub end_s: f64,
    /// A word or two drawn at the top of the first panel; may be empty.
    pub label: &'a str,
}

pub(crate) fn same_length(
    name: &'static str,
    of: &[f64],
    slice: &[f64],
) -> Result<(), ReportError> {
    if of.len() == slice.len() {
        Ok(())
    } else {
        Err(ReportError::Length {
            name,
            expected: of.len(),
            found: slice.len(),
        })
    }
}

impl Scatter<'_> {
    pub(crate) fn check(&self, name: &'static str) -> Result<(), ReportError> {
        same_length(name, self.x, self.y)
    }
}

impl Curve<'_> {
    pub(crate) fn check(&self, name: &'static str) -> Result<(), ReportError> {
        same_length(name, self.x, self.y)
    }
}
