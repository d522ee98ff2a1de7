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
        // The value before the piece, where there is one, and the first of it.
        let seam = self.last.map(|before| [before, *first]);
        let pairs = || seam.iter().map(|w| &w[..]).chain(values.windows(2));
        self.repeats += usize::from(seam.is_some_and(|[v, w]| v == w));
        self.repeats += values.windows(2).filter(|w| w[0] == w[1]).count();
        // NaN is not above anything.
        self.falls = self.falls || pairs().any(|w| !(w[1] > w[0]));
        if self.steps.len() < QUANTUM_STEPS {
            let steps = pairs().map(|w| (w[1] - w[0]).abs());
            let changes = steps.filter(|d| *d > 0.0 && d.is_finite());
            let room = QUANTUM_STEPS - self.steps.len();
            self.steps.extend(changes.take(room));
        }
        let (mut low, mut high) = self.ends.unwrap_or((f64::INFINITY, f64::NEG_INFINITY));
        let missing = values.iter().filter(|v| !v.is_finite()).count();
        for v in values.iter().filter(|v| v.is_finite()) {
            (low, high) = (low.min(*v), high.max(*v));
        }
        if missing < values.len() || self.ends.is_some() {
            self.ends = Some((low, high));
        }
        let mut run = self.run.unwrap_or(Run {
            start: self.samples,
            length: 0,
            value: *first,
        });
        let mut at = 0;
        while at < values.len() {
            let value = run.value;
            let same = values[at..].iter().take_while(|v| **v == value).count();
            run.length += same;
            at += same;
            if let Some(next) = values.get(at) {
                self.longest = longer(self.longest, run);
                run = Run {
                    start: self.samples + at,
                    length: 1,
                    value: *next,
                };
                at += 1;
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
