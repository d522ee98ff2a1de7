//! Inputs without holes: a simulation needs a value at every instant.

use dgd_recording::draw_line;

/// Interpolates over values that are not finite, holding the nearest at the ends.
///
/// Returns how many were filled; `None` if there is no finite value at all.
///
/// ```
/// let mut values = [f64::NAN, 1.0, f64::NAN, f64::NAN, 4.0];
/// assert_eq!(dgd_replay::fill_gaps(&mut values), Some(3));
/// assert_eq!(values, [1.0, 1.0, 2.0, 3.0, 4.0]);
/// ```
pub fn fill_gaps(values: &mut [f64]) -> Option<usize> {
    let first = values.iter().position(|v| v.is_finite())?;
    let mut filled = first;
    let opening = values[first];
    values[..first].fill(opening);
    let mut last = first;
    for index in first + 1..values.len() {
        if !values[index].is_finite() {
            filled += 1;
            continue;
        }
        let (from, to) = (values[last], values[index]);
        draw_line(&mut values[last + 1..index], from, to);
        last = index;
    }
    let closing = values[last];
    values[last + 1..].fill(closing);
    Some(filled)
}

/// Appends values; to nothing they are moved.
pub(crate) fn join(mine: &mut Vec<f64>, theirs: Vec<f64>) {
    if mine.is_empty() {
        *mine = theirs;
    } else {
        mine.extend(theirs);
    }
}

/// A series that comes in parts and is filled as by [`fill_gaps`]; or is left as it is, where nobody reads it.
#[derive(Debug, Default)]
pub(crate) struct Filling {
    pub(crate) values: Vec<f64>,
    read: bool,
    /// The latest value.
    last: Option<f64>,
    /// Missing values after it.
    missing: usize,
    filled: usize,
}

impl Filling {
    pub(crate) fn new(read: bool) -> Self {
        Self {
            read,
            ..Self::default()
        }
    }

    pub(crate) fn is_read(&self) -> bool {
        self.read
    }

    /// So many values are as they will be.
    pub(crate) fn known(&self) -> usize {
        self.values.len() - self.missing
    }

    /// So many were missing.
    pub(crate) fn filled(&self) -> usize {
        self.filled
    }

    pub(crate) fn extend(&mut self, values: Vec<f64>) {
        let old = self.values.len();
        join(&mut self.values, values);
        if !self.read {
            return;
        }
        for index in old..self.values.len() {
            let value = self.values[index];
            if !value.is_finite() {
                self.missing += 1;
                self.filled += 1;
                continue;
            }
            let gap = &mut self.values[index - self.missing..index];
            match self.last {
                Some(last) => draw_line(gap, last, value),
                None => gap.fill(value),
            }
            self.last = Some(value);
            self.missing = 0;
        }
    }

    /// Fills what is missing at the end; `None` if it is read and has no value at all.
    pub(crate) fn end(&mut self) -> Option<()> {
        if !self.read {
            return Some(());
        }
        let from = self.known();
        self.values[from..].fill(self.last?);
        self.missing = 0;
        Some(())
    }

    /// Forgets the first values.
    pub(crate) fn forget(&mut self, values: usize) {
        self.values.drain(..values.min(self.values.len()));
    }
}
