//! What a diagnosis costs, counted.

use std::sync::atomic::{AtomicU64, Ordering};

/// What a diagnosis cost in counts: the same on any number of threads, and together what its time goes with.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
pub struct Work {
    /// Samples of the working clock over which the relations were run under a hypothesis.
    pub samples_run: u64,
    /// Hypotheses that were weighed: an effect with its parameters, beside what is named.
    pub hypotheses: u64,
    /// Fits of the base curves, each with a tangent of its own.
    pub fits: u64,
}

/// Counts while a diagnosis runs.
#[derive(Debug, Default)]
pub(crate) struct Tally {
    samples_run: AtomicU64,
    hypotheses: AtomicU64,
    fits: AtomicU64,
}

impl Tally {
    pub(crate) fn ran(&self, samples: usize) {
        self.samples_run
            .fetch_add(samples as u64, Ordering::Relaxed);
    }

    pub(crate) fn weighed(&self) {
        self.hypotheses.fetch_add(1, Ordering::Relaxed);
    }

    pub(crate) fn fitted(&self) {
        self.fits.fetch_add(1, Ordering::Relaxed);
    }

    /// The counts so far.
    pub(crate) fn work(&self) -> Work {
        let told = |count: &AtomicU64| count.load(Ordering::Relaxed);
        Work {
            samples_run: told(&self.samples_run),
            hypotheses: told(&self.hypotheses),
            fits: told(&self.fits),
        }
    }
}
