//! Values that well logs write for no value, in every format.

use crate::count;

/// Numbers that stand for none (LAS and WITS conventions).
const LOG_NULLS: [f64; 2] = [-999.25, -9999.0];

/// Whether a number stands for none.
pub(crate) fn is_log_null(value: f64) -> bool {
    value < 0.0 && LOG_NULLS.contains(&value)
}

/// What to say of so many of them, of which the first is shown.
pub(crate) fn message(number: u64, shown: &str) -> String {
    format!(
        "{} with {shown}, which well logs write for no value; read as NaN",
        count(number, "cell")
    )
}

/// Those of a column that is no text.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Nulls {
    count: u64,
    /// Which value of the column, from 1, and what it was.
    first: Option<(u64, f64)>,
}

impl Nulls {
    /// Those of a whole column, which are NaN from here on.
    pub(crate) fn blanked(column: &mut [f64]) -> Self {
        /// Values looked at together.
        const STRETCH: usize = 64;
        let mut nulls = Self::default();
        let mut number = 1;
        for stretch in column.chunks_mut(STRETCH) {
            // Most have none; without an early exit the compiler can vectorise.
            let null = |v: &f64| u64::from(LOG_NULLS.contains(v));
            if stretch.iter().map(null).sum::<u64>() > 0 {
                for (value, number) in stretch.iter_mut().zip(number..) {
                    *value = nulls.blank(*value, number);
                }
            }
            number += STRETCH as u64;
        }
        nulls
    }

    /// NaN for a value that stands for none; `number` is its place in the column, from 1.
    pub(crate) fn blank(&mut self, value: f64, number: u64) -> f64 {
        if !is_log_null(value) {
            return value;
        }
        self.count += 1;
        self.first.get_or_insert((number, value));
        f64::NAN
    }

    /// Place of the first and what to say, if there was one.
    pub(crate) fn told(&self) -> Option<(u64, String)> {
        let (number, value) = self.first?;
        Some((number, message(self.count, &value.to_string())))
    }
}
