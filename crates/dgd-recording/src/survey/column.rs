//! What one pass over a column tells of it.

use super::{QUANTUM_STEPS, Run, quantum_of};

/// A column that comes in pieces.
#[derive(Debug, Clone, Default)]
pub(super) struct ColumnPass {
    pub(super) samples: usize,
    pub(super) missing: usize,
    /// Smallest and largest finite value.
    ends: Option<(f64, f64)>,
    repeats: usize,
    /// Whether a value was not above the one before.
    falls: bool,
    last: Option<f64>,
    /// The first differences of neighbours that are none.
    steps: Vec<f64>,
    run: Option<Run>,
    longest: Option<Run>,
}

impl ColumnPass {
    pub(super) fn add(&mut self, values: &[f64]) {
        let Some((first, _)) = values.split_first() else {
            return;
        };
        let before = self.last.unwrap_or(f64::NAN);
        let begins = self.last.is_none();
        for (v, w) in std::iter::once(&before).chain(values).zip(values) {
            self.repeats += usize::from(v == w);
            // NaN is not above anything; the first value is above none.
            self.falls |= !(w > v);
            let step = (w - v).abs();
            if step > 0.0 && step.is_finite() && self.steps.len() < QUANTUM_STEPS {
                self.steps.push(step);
            }
        }
        if begins {
            self.falls = values.windows(2).any(|w| !(w[1] > w[0]));
        }
        let (mut low, mut high) = self.ends.unwrap_or((f64::INFINITY, f64::NEG_INFINITY));
        let mut missing = 0;
        for v in values {
            if v.is_finite() {
                (low, high) = (low.min(*v), high.max(*v));
            } else {
                missing += 1;
            }
        }
        if missing < values.len() || self.ends.is_some() {
            self.ends = Some((low, high));
        }
        let mut run = self.run.unwrap_or(Run {
            start: self.samples,
            length: 0,
            value: *first,
        });
        for (index, v) in values.iter().enumerate() {
            if *v == run.value {
                run.length += 1;
            } else {
                self.longest = longer(self.longest, run);
                run = Run {
                    start: self.samples + index,
                    length: 1,
                    value: *v,
                };
            }
        }
        self.run = Some(run);
        self.missing += missing;
        self.samples += values.len();
        self.last = values.last().copied();
    }

    /// Smallest and largest finite value.
    pub(super) fn ends(&self) -> Option<(f64, f64)> {
        self.ends
    }

    /// Longest run of at least two equal values, of equals the last one.
    pub(super) fn longest_run(&self) -> Option<Run> {
        match self.run {
            Some(run) => longer(self.longest, run),
            None => self.longest,
        }
    }

    pub(super) fn repeated_share(&self) -> f64 {
        self.repeats as f64 / self.samples.saturating_sub(1).max(1) as f64
    }

    /// Whether there are several values, each above the one before.
    pub(super) fn increases(&self) -> bool {
        self.samples > 2 && !self.falls
    }

    pub(super) fn quantum(&self) -> Option<f64> {
        quantum_of(self.steps.clone())
    }
}

fn longer(longest: Option<Run>, run: Run) -> Option<Run> {
    let counts = run.length >= 2 && run.value.is_finite();
    let best = longest.is_none_or(|longest| run.length >= longest.length);
    if counts && best { Some(run) } else { longest }
}
